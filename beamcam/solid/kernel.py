"""The solid kernel, loaded where it is used, and what is built with it: prisms and turned tools.

Circles are regular polygons inscribed in them, whose chords lie at most CHORD inside.
"""

from collections.abc import Iterable, Sequence
from math import acos, ceil, cos, pi, radians, sin, tan
from typing import TYPE_CHECKING, Any

from beamcam.errors import BeamcamError, Source
from beamcam.solid.rules import NO_KERNEL

if TYPE_CHECKING:
    from manifold3d import Manifold

CHORD = 0.01  #: mm between a circle and its chords
FLAT_DEG = 180.0  #: point of a tool that is flat

Row = tuple[float, float, float, float]
Frame = tuple[Row, Row, Row]  #: rows of the matrix that takes (u, v, depth, 1) to (x, y, z)
Vec = tuple[float, float, float]


def kernel() -> Any:
    """The module manifold3d. Raises BeamcamError if it is not installed."""
    try:
        import manifold3d
    except ImportError as missing:
        raise BeamcamError(NO_KERNEL.at(Source("beamcam"))) from missing
    return manifold3d


def facets(radius: float, chord: float = CHORD) -> int:
    """Sides of the polygon that stands for a circle: a multiple of 4, so that its box is exact."""
    if radius <= 2 * chord:
        return 8
    return 4 * max(3, ceil(pi / acos(1 - chord / radius) / 4))


def circle(x: float, y: float, radius: float) -> list[tuple[float, float]]:
    """The corners of that polygon, counter-clockwise from the first axis."""
    n = facets(radius)
    steps = (2 * pi * k / n for k in range(n))
    return [(x + radius * cos(t), y + radius * sin(t)) for t in steps]


def prism(shape: Any, low: float, high: float, frame: Frame) -> "Manifold":
    """A plane shape of shapely, in (u, v) of a frame, from one depth to another."""
    m = kernel()
    rings = [
        ring.coords[:-1]
        for polygon in getattr(shape, "geoms", (shape,))
        if polygon.geom_type == "Polygon" and not polygon.is_empty
        for ring in (polygon.exterior, *polygon.interiors)
    ]
    if not rings or high <= low:
        return m.Manifold()
    section = m.CrossSection([[p[:2] for p in ring] for ring in rings], m.FillRule.EvenOdd)
    return m.Manifold.extrude(section, high - low).translate((0.0, 0.0, low)).transform(frame)


def turned(
    profile: Sequence[tuple[float, float]], frame: Frame, chord: float = CHORD
) -> "Manifold":
    """A tool turned about the depth axis of a frame, by (radius, depth) from mouth to point.

    It is convex: the radii fall, if they change.
    """
    m = kernel()
    n = facets(max(radius for radius, _ in profile), chord)
    ring = [(cos(2 * pi * k / n), sin(2 * pi * k / n)) for k in range(n)]
    points = [
        (radius * c, radius * s, depth)
        for radius, depth in profile
        for c, s in (ring if radius > 0 else [(0.0, 0.0)])
    ]
    return m.Manifold.hull_points(points).transform(frame)


def drill_profile(radius: float, top: float, depth: float, point_deg: float) -> list[Any]:
    """A drill from `top` to its full diameter at `depth`, and its point beyond."""
    if point_deg >= FLAT_DEG:
        return [(radius, top), (radius, depth)]
    return [(radius, top), (radius, depth), (0.0, depth + radius / tan(radians(point_deg) / 2))]


def moved(frame: Frame, u: float, v: float) -> Frame:
    """The frame with its zero at (u, v)."""
    return tuple((a, b, c, d + a * u + b * v) for a, b, c, d in frame)  # type: ignore[return-value]


def minus(body: "Manifold", taken: Iterable["Manifold"]) -> "Manifold":
    """A body less others."""
    m = kernel()
    return m.Manifold.batch_boolean([body, *taken], m.OpType.Subtract)


def behind(body: "Manifold", point: Vec, normal: Vec) -> "Manifold":
    """What of a body lies behind a plane, against its normal."""
    a, b, c = normal
    length = (a * a + b * b + c * c) ** 0.5
    a, b, c = a / length, b / length, c / length
    return body.trim_by_plane((-a, -b, -c), -(a * point[0] + b * point[1] + c * point[2]))
