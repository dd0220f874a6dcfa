"""Planes that end a tube: of their own, whatever way they lean, and those of a round one's header.

A torch square to the surface cuts where the wall reaches farthest, at its outside or at its inside.
"""

from collections.abc import Collection, Iterator
from math import atan, degrees, hypot, pi, radians, tan
from typing import Any

from beamcam.checks.coping.section import TubeSection
from beamcam.model.part import EndPlane, Part

Shape = Any  #: of shapely
End = tuple[float, float, float]  #: x = first - second Y - third Z from the axis of the tube

PLACES = 240  #: of a plane across a corner, or a quarter of a round tube
SAME_DEG = 0.2  #: by which a plane and the header may differ and mean the same end
FAR = 1e5
SAME = 1e-6  #: mm
SQUARE_DEG = 0.2  #: of an end; less is noise


def planes_of(part: Part, left: Collection[int], section: TubeSection) -> Iterator[tuple[int, End]]:
    """The planes of a part, -1 before those of its start and 1 before the others; `left` are
    features that are not made."""
    for index, feature in enumerate(part.features):
        if isinstance(feature, EndPlane) and feature.normal[0] and index not in left:
            (x, y, z), (a, b, c) = feature.point, feature.normal
            on_axis = x - (b * (section.half_y - y) + c * (section.half_z - z)) / a
            yield (1 if a > 0.0 else -1), (on_axis, b / a, c / a)


def is_stated(part: Part, side: int, web_deg: float, flange_deg: float) -> bool:
    """Whether a plane of the part is that of an end by its header."""
    for feature in part.features:
        if isinstance(feature, EndPlane) and feature.normal[0] * side > 0.0:
            a, b, c = feature.normal
            offs = degrees(atan(b / a)) - web_deg, degrees(atan(c / a)) - flange_deg
            if max(map(abs, offs)) <= SAME_DEG:
                return True
    return False


def surfaces_of(face: str, section: TubeSection) -> tuple[float, float]:
    """Where the outside and the inside of a wall lie, from the axis, along Y or along Z."""
    out = section.half_y if face in "ou" else section.half_z
    side = 1.0 if face in "vo" else -1.0
    return side * out, side * (out - section.wall)


def x_on(end: End, face: str, at: float, y: float, section: TubeSection) -> float:
    """x of a plane at a y of a face, on the surface that is `at` from the axis."""
    if face in "vh":
        return end[0] - end[1] * (y - section.half_y) - end[2] * at
    return end[0] - end[1] * at - end[2] * (y - section.half_z)


def round_corner(end: End, k: int, turns: Any, section: TubeSection, is_start: bool) -> Any:
    """x at which a plane is cut round a corner, so far into it as the normal has turned."""
    import numpy as np

    way = k * pi / 2 + turns  # of the normal, from -Y towards +Z
    y = section.flat_y * (1 if k in (1, 2) else -1)
    z = section.flat_z * (1 if k in (0, 1) else -1)
    xs = [
        end[0] - end[1] * (y - q * np.cos(way)) - end[2] * (z + q * np.sin(way))
        for q in (section.radius, section.radius - section.wall)
    ]
    return np.minimum(*xs) if is_start else np.maximum(*xs)


def kept(shape: Shape, side: int, end: End, section: TubeSection) -> Shape:
    """What stays of three turns of the surface behind a plane.

    Between two corners it is cut along a straight line.
    """
    import numpy as np
    from shapely import Polygon

    turns = np.linspace(0.0, pi / 2, PLACES)
    xs = [round_corner(end, k, turns, section, side < 0) for k in range(4)]
    ss = [section.corner(k) + section.radius * turns for k in range(4)]
    x = np.tile(np.concatenate(xs), 5)
    s = np.concatenate([one + k * section.turn for k in range(-2, 3) for one in ss])
    # Of a round tube one corner ends where another begins.
    apart, away = np.diff(s, prepend=-np.inf) > SAME, -side * FAR
    x, s = x[apart], s[apart]
    behind = Polygon([(away, s[0]), *zip(x, s, strict=True), (away, s[-1])])
    return shape.intersection(behind.buffer(0))


def header_planes(part: Part, section: TubeSection) -> Iterator[tuple[int, End]]:
    """The skew ends of a round tube by its header, as `planes_of`: they touch x 0 or the length at
    its outside."""
    cuts = part.cuts
    for side, x, web, flange in (
        (-1, 0.0, cuts.web_start, cuts.flange_start),
        (1, part.length, cuts.web_end, cuts.flange_end),
    ):
        rise, lean = (tan(radians(a)) if abs(a) > SQUARE_DEG else 0.0 for a in (web, flange))
        if rise or lean:
            yield side, (x - side * section.radius * hypot(rise, lean), rise, lean)
