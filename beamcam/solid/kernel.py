"""The solid kernel, loaded where it is used, and what is built with it: prisms and turned tools.

Circles are regular polygons inscribed in them, whose chords lie at most CHORD inside.
"""

import os
import sys
from collections.abc import Iterable, Iterator, Sequence
from contextlib import suppress
from itertools import product
from math import acos, ceil, cos, pi, radians, sin, tan
from typing import TYPE_CHECKING, Any, Literal

from msgspec import Struct
from shapely import MultiPoint, Polygon, box, union_all

from beamcam.errors import BeamcamError, Source
from beamcam.model.part import Part, Profile
from beamcam.model.section import ring_of
from beamcam.solid import NO_KERNEL, NO_SOLID

if TYPE_CHECKING:
    from manifold3d import Manifold

CHORD = 0.01  #: mm between a circle and its chords
FLAT_DEG = 180.0  #: point of a tool that is flat

Row = tuple[float, float, float, float]
Frame = tuple[Row, Row, Row]  #: rows of the matrix that takes (u, v, depth, 1) to (x, y, z)
Vec = tuple[float, float, float]


def kernel() -> Any:
    """The module manifold3d, on one thread. Raises BeamcamError if it is not installed."""
    loaded = sys.modules.get("manifold3d")
    return _loaded() if loaded is None else loaded


def _loaded() -> Any:
    """manifold3d, loaded while this thread may use one processor only.

    As it works for the first time it starts a thread for each further one. A process that is forked
    then has none of these, and would wait for them for good.
    """
    processors: set[int] = set()
    with suppress(AttributeError, OSError):  # of Linux, where processes are forked
        processors = os.sched_getaffinity(0)
        os.sched_setaffinity(0, {min(processors)})
    try:
        import manifold3d

        manifold3d.Manifold.batch_boolean(
            [manifold3d.Manifold.cube((2, 2, 2)), manifold3d.Manifold.cube((1, 1, 1))],
            manifold3d.OpType.Subtract,
        ).volume()
    except ImportError as missing:
        raise BeamcamError(NO_KERNEL.at(Source("beamcam"))) from missing
    finally:
        with suppress(AttributeError, OSError):
            os.sched_setaffinity(0, processors)
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
    return extruded(shape, low, high).transform(frame)


def extruded(shape: Any, low: float, high: float) -> "Manifold":
    """A plane shape of shapely in (u, v), from one depth to another along the third axis."""
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
    return m.Manifold.extrude(section, high - low).translate((0.0, 0.0, low))


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


# --- section --------------------------------------------------------------------------------------

# The section of a bar as a plane shape, and the walls that its faces look at.
#
#         Y                       I: web at mid flange          T: flange flat along Y at Z = 0,
#         |  o                    U, C: web on the h side          stem along Z at mid height
#         |-----                  L: v leg flat along Y at Z = 0, u leg along Z at Y = 0
#      h  |      v                M: four walls                 B: height along Y, thickness along Z
#         |-----
#         0  u     Z              v is seen from +Z, h from -Z, o from +Y, u from -Y
#
# Figures from the standard's page 7. Toes of angles are sharp: no figure of a part gives them. Lips
# of a C whose length is not known end behind their bend.


Interval = tuple[float, float]
FREE = 1.0  #: mm that a cutter reaches into the air, so that no faces coincide


class Wall(Struct, frozen=True):
    """The wall behind a face: a plate in (x, q) of the face, d deep from its surface."""

    normal: Literal["y", "z"]
    surface: float  #: coordinate of its surface along the normal
    inward: int  #: whether depth counts up or down that coordinate
    thickness: float
    width: float  #: of the face
    others: tuple[Interval, ...] = ()  #: q where other walls stand on it
    before: float = 0.0  #: how far a fillet rises from its surface, or its air reaches freely
    behind: float = 0.0  #: likewise from its far side

    @property
    def frame(self) -> Frame:
        """Takes (x, q, depth) to (x, y, z)."""
        along_x = (1.0, 0.0, 0.0, 0.0)
        across = (0.0, 1.0, 0.0, 0.0)
        deep = (0.0, 0.0, float(self.inward), self.surface)
        return (along_x, deep, across) if self.normal == "y" else (along_x, across, deep)


class _Plate(Struct, frozen=True):
    """A plate of a section, from one place to another along its normal."""

    normal: Literal["y", "z"]
    faces: str  #: that look at it from below and from above; "." for none
    extent: Interval
    others: tuple[Interval, ...] = ()
    rises: Interval = (0.0, 0.0)  #: of the fillets below and above it


def _plates(profile: Profile) -> list[_Plate]:
    """The plates of a section; none of a round or special one."""
    h, b, r = profile.height, profile.width, profile.radius
    t, s = profile.flange_thickness, profile.web_thickness or 0.0
    low, high, back, front = (0.0, t), (h - t, h), (0.0, s), (b - s, b)
    inside = max(0.0, r - t)
    match profile.code:
        case "B":
            return [_Plate("z", "hv", back)]
        case "I":
            web = (b - s) / 2, (b + s) / 2
            return [
                _Plate("z", "hv", web, (low, high), (r, r)),
                _Plate("y", ".o", high, (web,), (r, 0.0)), _Plate("y", "u.", low, (web,), (0.0, r)),
            ]  # fmt: skip
        case "U" | "C":
            beside = (back,) if profile.lip is None else (back, front)
            return [
                _Plate("z", "hv", back, (low, high), (0.0, r)),
                _Plate("y", ".o", high, beside, (r, 0.0)), _Plate("y", "u.", low, beside, (0.0, r)),
            ]  # fmt: skip
        case "L":
            return [
                _Plate("z", "hv", back, (low,), (0.0, r)), _Plate("y", "uo", low, (back,), (0.0, r))
            ]  # fmt: skip
        case "T":
            stem = (h - t) / 2, (h + t) / 2
            return [
                _Plate("z", "hv", back, (stem,), (0.0, r)), _Plate("y", "uo", stem, (back,), (r, r))
            ]  # fmt: skip
        case "M":
            return [
                _Plate("z", ".v", front, (low, high), (inside, 0.0)),
                _Plate("z", "h.", back, (low, high), (0.0, inside)),
                _Plate("y", ".o", high, (back, front), (inside, 0.0)),
                _Plate("y", "u.", low, (back, front), (0.0, inside)),
            ]
    return []


def walls(profile: Profile) -> dict[str, Wall]:
    """The walls of a section by face; none of a round or special one."""
    found: dict[str, Wall] = {}
    for one in _plates(profile):
        thick, width = profile.web_thickness or 0.0, profile.height
        if one.normal == "y":
            thick, width = profile.flange_thickness, profile.width
        (below, above), (low, high), faces = one.rises, one.extent, one.faces
        found[faces[1]] = Wall(one.normal, high, -1, thick, width, one.others, above, below)
        found[faces[0]] = Wall(one.normal, low, 1, thick, width, one.others, below, above)
    found.pop(".", None)
    return found


def outline(part: Part) -> Any:
    """The section in (Y, Z), as a shape of shapely. Raises BeamcamError where it is not known."""
    profile = part.profile
    h, b = profile.height, profile.width
    t, s = profile.flange_thickness, profile.web_thickness or 0.0
    match profile.code:
        case "RU":
            return Polygon(circle(h / 2, h / 2, h / 2))
        case "RO":
            _needed(part, wall=t or s)
            hole = circle(h / 2, h / 2, h / 2 - (t or s))
            return Polygon(circle(h / 2, h / 2, h / 2), [hole] if 2 * (t or s) < h else [])
        case "SO":
            if len(part.section) < 3:
                raise no_solid(part, f"a special section {profile.name} without its outline")
            inner = [p for p in part.section if p.side == "-"]
            whole = Polygon(ring_of([p for p in part.section if p.side == "+"])).buffer(0)
            return whole.difference(Polygon(ring_of(inner)).buffer(0)) if inner[2:] else whole
        case "B":
            _needed(part, thickness=s)
            return box(0.0, 0.0, h, s)
    _needed(part, height=h, width=b, flange_thickness=t, web_thickness=s)
    if profile.code == "M":
        r = profile.radius
        hollow = _rounded(t, s, h - t, b - s, max(0.0, r - t))
        return _rounded(0.0, 0.0, h, b, r).difference(hollow)
    plates = [
        box(0, one.extent[0], h, one.extent[1]) if one.normal == "z"
        else box(one.extent[0], 0, one.extent[1], b)
        for one in _plates(profile)
    ]  # fmt: skip
    if lip := (profile.lip or 0.0 if profile.code == "C" else 0.0):
        plates += [box(0, b - s, lip, b), box(h - lip, b - s, h, b)]
    whole = union_all([*plates, *_fillets(profile)])
    if profile.code == "C" and profile.radius:  # bent: round outside as well, and to its lips
        outer = profile.radius + s
        bend = _rounded(0.0, 0.0, h, b, outer).difference(_rounded(s, s, h - s, b - s, outer - s))
        flats = box(0.0, b - outer, outer, b), box(h - outer, b - outer, h, b)
        whole = union_all([whole.difference(union_all(flats)), bend.intersection(union_all(flats))])
        return whole.intersection(_rounded(0.0, 0.0, h, b, outer))
    return whole


def corners(part: Part) -> list[tuple[float, float]]:
    """Outermost places (y, z) of the section's steel, which a skew end may touch first.

    They are those of the solid itself, not the model's, so that each checks the other.
    """
    return list(outline(part).convex_hull.exterior.coords)


def no_solid(part: Part, found: str) -> BeamcamError:
    """The error that a part has no solid."""
    return BeamcamError(NO_SOLID.at(part.source, found=found))


def _needed(part: Part, **figures: float) -> None:
    for name, value in figures.items():
        if not value > 0.0:
            raise no_solid(part, f"a {name.replace('_', ' ')} of {value:g} mm")


def _fillets(profile: Profile) -> Iterator[Any]:
    """The root fillets: spandrels between a corner of two plates and the arc that touches both."""
    n = facets(profile.radius) // 4
    turns = [pi / 2 * k / n for k in range(n + 1)]
    web, *flanges = _plates(profile)
    for flange, up, out in product(flanges, (0, 1), (0, 1)):
        if r := min(flange.rises[up], web.rises[out]):
            y, z, dy, dz = flange.extent[up], web.extent[out], 2 * up - 1, 2 * out - 1
            arc = [(y + dy * r * (1 - sin(a)), z + dz * r * (1 - cos(a))) for a in turns]
            yield Polygon([*arc, (y, z)])


def _rounded(y0: float, z0: float, y1: float, z1: float, r: float) -> Any:
    """A rectangle with round corners."""
    r = min(r, (y1 - y0) / 2, (z1 - z0) / 2)
    if r <= 0.0:
        return box(y0, z0, y1, z1)
    places = [(y, z) for y in (y0 + r, y1 - r) for z in (z0 + r, z1 - r)]
    return MultiPoint([p for y, z in places for p in circle(y, z, r)]).convex_hull
