"""What a torch that is tilted along the bar makes of a profile: skew ends, or bevels of its edges.

Of a skew end each tilted cut says the whole plane: its tilt leans across the wall, its path slants
along it, and it runs half a kerf off. A bevel is a pass along an edge that is cut square besides.
"""

from collections.abc import Iterator, Sequence
from math import atan, degrees, dist, hypot, radians, sqrt, tan
from typing import Any

from msgspec.structs import replace

from beamcam.checks.coping.section import CoperSection
from beamcam.checks.coping.skew import SkewEnd
from beamcam.checks.coping.strokes import TorchStroke
from beamcam.geometry.curves import Line, signed_area
from beamcam.geometry.plane import dot
from beamcam.model.part import Bevel, Contour, EndCuts, Feature
from beamcam.recovery.recovered import plain

Shape = Any  #: of shapely

ALIKE = 1e-3  #: that slopes of one plane may differ by
SAME = 0.1  #: mm that the cuts of one plane may lie apart
ANGLE_DEG = 0.003  #: to which angles are known
LAND = 0.02  #: mm to which lands are known
DECIMALS = 3
ALONG = 0.999  #: cosine between a pass and its edge, at least

Ends = tuple[SkewEnd | None, SkewEnd | None]


def ends_of(strokes: Sequence[TorchStroke], section: CoperSection) -> Ends | None:
    """The skew ends that tilted strokes make, start and end; None where they make no two planes."""
    xs = [x for stroke in strokes for x, _ in stroke.points] or [0.0]
    middle = (min(xs) + max(xs)) / 2
    ends: list[SkewEnd | None] = []
    for side in (-1, 1):
        own = [
            _plane(stroke, side, section) for stroke in strokes
            if stroke.b_deg and not stroke.leans and side * (stroke.points[-1][0] - middle) > 0.0
        ]  # fmt: skip
        for end in own:
            slopes = max(abs(end.by_y - own[0].by_y), abs(end.by_z - own[0].by_z))
            if slopes > ALIKE or abs(end.c - own[0].c) > SAME:
                return None
        ends.append(own[0] if own else None)
    return ends[0], ends[1]


def _plane(stroke: TorchStroke, side: int, section: CoperSection) -> SkewEnd:
    """The plane that a stroke leaves of an end."""
    ways = zip(stroke.points[1:], stroke.points[2:], strict=False)
    (xa, ya), (xb, yb) = max(ways, key=lambda way: dist(*way))
    lean, slope = tan(radians(stroke.b_deg)), (xb - xa) / (yb - ya) if yb != ya else 0.0
    if stroke.face == "v":
        by_y, by_z, y, z = -slope, -lean, ya, section.front
    elif stroke.face == "o":
        by_y, by_z, y, z = -lean, -slope, section.high, ya
    else:
        by_y, by_z, y, z = lean, -slope, 0.0, ya
    off = stroke.row.kerf / 2 * sqrt(1.0 + by_y**2 + by_z**2)
    return SkewEnd(side, xa + y * by_y + z * by_z - side * off, by_y, by_z)


def cuts_of(ends: Ends) -> EndCuts:
    """The angles of a header that skew ends have."""

    def angle(slope: float) -> float:
        return plain(degrees(atan(slope)), ANGLE_DEG, DECIMALS)

    pairs = [(angle(e.by_y), angle(e.by_z)) if e else (0.0, 0.0) for e in ends]
    (web, flange), (web_end, flange_end) = pairs
    return EndCuts(web_start=web, web_end=web_end, flange_start=flange, flange_end=flange_end)


def length_of(end: SkewEnd, section: CoperSection) -> float:
    """The length of a part by its skew end: x of the outermost corner of its section."""
    return max(end.x(y, z) for y, z in section.outermost)


def whole_wall(face: str, ends: Ends, length: float, section: CoperSection, wide: float) -> Shape:
    """A wall between its ends, of which nothing else is cut."""
    from shapely import Polygon

    (a, more_a), (b, more_b) = (
        end.on(face, section, 0.0) if end is not None else (at, 0.0)
        for end, at in zip(ends, (0.0, length), strict=True)
    )
    return Polygon([(a, 0.0), (b, 0.0), (b + more_b * wide, wide), (a + more_a * wide, wide)])


def with_bevels(
    features: Sequence[Feature], strokes: Sequence[TorchStroke], section: CoperSection
) -> Iterator[Feature]:
    """Features whose outlines have the bevels that tilted strokes make of their edges."""
    for feature in features:
        if not isinstance(feature, Contour) or feature.kind != "outer":
            yield feature
            continue
        own = [one for one in strokes if one.is_tilted and one.face == feature.face]
        bevels = [_bevel(feature, stroke, section.thickness(feature.face)) for stroke in own]
        yield replace(feature, bevels=tuple(bevel for bevel in bevels if bevel is not None))


def _bevel(contour: Contour, stroke: TorchStroke, thick: float) -> Bevel | None:
    """The bevel of the nearest edge of a contour that a straight stroke runs along; None without
    one."""
    if len({*stroke.leans}) > 1:
        return None
    start, end = stroke.points[1], stroke.points[-1]
    turned = -1.0 if signed_area(contour.curves) < 0.0 else 1.0
    bevels: list[tuple[float, Bevel]] = []  #: and how far the stroke runs from its edge
    for k, curve in enumerate(contour.curves):
        if not isinstance(curve, Line) or curve.length <= 0.0:
            continue
        dx, dy = (turned * way for way in curve.tangent(0.0))
        along = dot((dx, dy), (end[0] - start[0], end[1] - start[1]))
        if abs(along) < ALONG * (dist(start, end) or 1.0):
            continue
        (x, y), (px, py) = curve.start, start
        inside = -dy * (px - x) + dx * (py - y)  # the steel lies on the left
        lx, ly = stroke.leans[0] if stroke.leans else (tan(radians(stroke.b_deg)), 0.0)
        slope = ly * dx - lx * dy
        reach = stroke.row.kerf / 2 * hypot(1.0, slope)
        if not slope:
            continue
        land = thick - (inside + reach) / slope
        bevel = Bevel(k, plain(degrees(atan(slope)), ANGLE_DEG, DECIMALS), plain(land, LAND, 2))
        if -LAND <= land <= thick + LAND:
            bevels.append((abs(inside), bevel))
    return min(bevels, key=lambda one: one[0])[1] if bevels else None
