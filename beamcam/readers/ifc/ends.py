"""The ends of a member: which plane cuts each, and its angles in DSTV's signs.

    x = a Y + b Z + c        web angle = -atan a, flange angle = -atan b

which is DSTV's atan2(x(lowest y) - x(highest y), y_high - y_low) at either end. Where several
planes or cuts form an end, the plane that holds most of the end's height and width counts, and
what it does not explain stays in the contours.
"""

from collections.abc import Sequence
from itertools import pairwise, repeat
from math import atan, atan2, degrees, hypot
from operator import sub

from msgspec import Struct

from beamcam.geometry.curves import Line, Point
from beamcam.model.part import Bevel
from beamcam.readers.ifc.curves2d import Chain
from beamcam.readers.ifc.cutters import HalfSpace
from beamcam.readers.ifc.region import Shape, half_plane, pieces_of
from beamcam.readers.ifc.section import Wall

MIN_LEAN = 0.17  #: of a normal along the member; a plane nearer to the axis is not an end
MIN_EDGE = 1.0  #: mm across the member of an edge that counts for an end
SAME_SLOPE = 2e-4
SAME_REACH = 1e-4  #: mm by which one plane may be before the sole one
SAME_PLANE = 0.3  #: mm


class End(Struct, frozen=True, gc=False):
    """The plane of an end; `side` is 1 at the end and -1 at the start."""

    side: int
    a: float
    b: float
    c: float

    def x(self, y: float, z: float) -> float:
        return self.a * y + self.b * z + self.c

    @property
    def web_deg(self) -> float:
        return round(-degrees(atan(self.a)), 9) + 0.0 if self.a else 0.0

    @property
    def flange_deg(self) -> float:
        return round(-degrees(atan(self.b)), 9) + 0.0 if self.b else 0.0

    def removed(self, wall: Wall, c: float) -> Shape:
        """What lies beyond the end on the wall's plane at `c`."""
        slope_q, slope_c = (self.b, self.a) if wall.normal == "y" else (self.a, self.b)
        # side (x - slope_q q) >= side (slope_c c + self.c)
        return half_plane(self.side, -self.side * slope_q, self.side * (slope_c * c + self.c))


def of_plane(half: HalfSpace) -> End:
    """The end that a half-space cuts."""
    n = half.normal
    return End(1 if n[0] > 0 else -1, -n[1] / n[0], -n[2] / n[0], half.x_at(0.0, 0.0))


class Trim(Struct, frozen=True, gc=False):
    """Limits of a stock by the planes at one end, along the lines of its section's corners."""

    planes: tuple[End, ...]  #: the stock's own square end, and those that cut it
    sole: End | None  #: the one plane that cuts the whole section; None if several share it
    reach: float  #: side * x that the sole plane reaches at most; as `most` without one
    least: float  #: side * x up to which no plane takes anything
    most: float  #: side * x beyond which nothing is left


def trim(square: End, cuts: Sequence[End], corners: Sequence[Point]) -> Trim:
    """The end of a stock that is `square` before its cuts, at the (Y, Z) of the corners."""
    planes, level = (square, *cuts), square.side * square.c
    if not cuts:
        return Trim(planes, square, level, level, level)
    lines = [reaches(one, corners) for one in cuts]
    left = list(map(min, repeat(level), *lines))
    least, most = min(left), max(left)
    if level - least <= SAME_REACH:
        return Trim(planes, square, level, least, most)
    for one, line in zip(cuts, lines, strict=True):
        if max(map(sub, line, left)) <= SAME_REACH:
            return Trim(planes, one, max(line), least, most)
    return Trim(planes, None, most, least, most)


def reaches(end: End, corners: Sequence[Point]) -> list[float]:
    """side * x of an end at each of the corners."""
    if end.a == 0.0 and end.b == 0.0:
        return [end.side * end.c] * len(corners)
    a, b, c = end.side * end.a, end.side * end.b, end.side * end.c
    return [a * y + b * z + c for y, z in corners]


class _Edge(Struct, frozen=True, gc=False):
    """A piece of a wall's border that faces an end."""

    wall: Wall
    level: float  #: c
    x: float  #: of its middle
    q: float
    slope: float  #: dx / dq
    weight: float  #: how much of q it takes


Level = tuple[Wall, float, Shape]  #: a wall, c, and its region there


def fitted_end(side: int, levels: Sequence[Level]) -> End | None:
    """The plane that most of an end lies in; None where no edge faces that way."""
    edges = [e for wall, c, shape in levels for e in _facing(side, wall, c, shape)]
    web = [e for e in edges if e.wall.normal == "z"]
    flange = [e for e in edges if e.wall.normal == "y"]
    if not edges:
        return None
    candidates = [
        _through(side, edges, a, b)
        for a in (_chief_slope(web), 0.0)
        for b in (_chief_slope(flange), _lean(web), 0.0)
        if a is not None and b is not None
    ]
    return max(candidates, key=lambda found: round(found[1], 1))[0]


def _facing(side: int, wall: Wall, c: float, shape: Shape) -> list[_Edge]:
    """The border edges of a region that nothing hides from an observer beyond the end."""
    raw: list[tuple[float, float, float, float]] = []
    for piece in pieces_of(shape):
        points = [(float(x), float(y)) for x, y in piece.exterior.coords]
        if not piece.exterior.is_ccw:
            points.reverse()
        for (x0, q0), (x1, q1) in pairwise(points):
            # Counter-clockwise, the outward normal is (dq, -dx).
            if side * (q1 - q0) > 0.1 * hypot(x1 - x0, q1 - q0):
                raw.append((x0, q0, x1, q1))
    found = []
    for x0, q0, x1, q1 in raw:
        x, middle, wide = (x0 + x1) / 2, (q0 + q1) / 2, abs(q1 - q0)
        hidden = (
            min(a, b) < middle < max(a, b)
            and side * (u + (middle - a) * (v - u) / (b - a)) > side * x + 0.01
            for u, a, v, b in raw
        )
        if wide >= MIN_EDGE and not any(hidden):
            found.append(_Edge(wall, c, x, middle, (x1 - x0) / (q1 - q0), wide))
    return found


def _chief_slope(edges: Sequence[_Edge]) -> float | None:
    """The slope that most of the edges' width has; None where there are no edges."""
    return _chief([(e.slope, e.weight) for e in edges], SAME_SLOPE)[0] if edges else None


def _chief(rows: Sequence[tuple[float, float]], near: float) -> tuple[float, float]:
    """The first value about which most of the weight lies, and that weight."""
    best = (rows[0][0], 0.0)
    for value, _ in rows:
        weight = sum(w for v, w in rows if abs(v - value) < near)
        if weight > best[1] + 1e-6:
            best = (value, weight)
    return best


def _lean(edges: Sequence[_Edge]) -> float | None:
    """How an end leans through the thickness of the webs, by edges at two levels of one wall."""
    chief = _chief_slope(edges)
    if chief is None:
        return None
    along = [e for e in edges if abs(e.slope - chief) < SAME_SLOPE]
    levels = sorted({e.level for e in along if e.wall == along[0].wall})
    if len(levels) < 2:
        return None
    first, last = (
        max((e for e in along if e.level == at), key=lambda e: e.weight)
        for at in (levels[0], levels[-1])
    )
    rise = (last.x - chief * last.q) - (first.x - chief * first.q)
    lean = rise / (levels[-1] - levels[0])
    return lean if abs(lean) > 1e-3 else None


def _through(side: int, edges: Sequence[_Edge], a: float, b: float) -> tuple[End, float]:
    """The plane of slopes a and b that most of the edges lie in, and how much that is."""
    heights = []
    for edge in edges:
        y, z = (edge.level, edge.q) if edge.wall.normal == "y" else (edge.q, edge.level)
        fits = abs(edge.slope - (b if edge.wall.normal == "y" else a)) < SAME_SLOPE
        heights.append((edge.x - a * y - b * z, edge.weight if fits else 0.0))
    c, weight = _chief(heights, SAME_PLANE)
    return End(side, a, b, c), weight


# --- bevels ---------------------------------------------------------------------------------------
# Edges that lean through their wall: bevels, each with its angle and its land.
#
#      looked-at surface
#   ____________________
#  /                        angle from square, until `land` is left;
# |    land                 an X has another one from the far side
# |_____________________

SET_BACK = 0.05  #: mm by which a level stands back behind the outermost
STRAIGHT = 0.1  #: mm that a level may be off the plane of a bevel
MIN_LAND = 0.02  #: share of the thickness; less counts as no land

Run = list[tuple[float, float]]  #: depth below a surface, and how far the edge stands back there


def bevels_of(outer: Chain, wall: Wall, levels: Sequence[tuple[float, Shape]]) -> tuple[Bevel, ...]:
    """The bevels of an outline that goes round the wall at all its levels together."""
    from shapely import Point

    by_depth = sorted(levels, key=lambda level: -level[0] if wall.outer else level[0])
    found: list[Bevel] = []
    for i, curve in enumerate(outer):
        if not isinstance(curve, Line) or curve.length < MIN_EDGE:
            continue
        middle = Point(curve.point(0.5))
        run = [
            (abs(wall.surface - c), 0.0 if s.is_empty else float(s.distance(middle)))
            for c, s in by_depth
        ]
        if max(back for _, back in run) <= SET_BACK:
            continue
        behind = [(wall.thickness - depth, back) for depth, back in reversed(run)]
        sides = [_bevel(i, one, wall.thickness, way) for one, way in ((run, 1.0), (behind, -1.0))]
        told = [bevel for bevel in sides if bevel is not None]
        if not told:  # from surface to surface, of an edge of another form
            (top, near), (deepest, far) = run[0], run[-1]
            angle = degrees(atan2(max(near, far), deepest - top))
            told = [Bevel(i, angle if near > far else -angle, 0.0)]
        found += told
    return tuple(found)


def _bevel(curve: int, run: Run, thickness: float, way: float) -> Bevel | None:
    """The bevel that begins at a surface and gets shallower; None if the edge has none there."""
    (top, back), (under, then), *_ = run
    if back <= SET_BACK or back - then <= SET_BACK / 2:
        return None
    grade = (back - then) / (under - top)
    deep = top + back / grade
    plane = (max(0.0, grade * (deep - depth)) for depth, _ in run)
    # An edge that is set back again on the far side has a bevel of its own there.
    for expected, (depth, found) in zip(plane, run, strict=True):
        if depth <= deep and abs(expected - found) > STRAIGHT:
            return None
    land = max(0.0, thickness - deep)
    if land < MIN_LAND * thickness:
        land = 0.0
    if way < 0.0 and land:  # which counts from the far side, where this one begins
        land = deep
    return Bevel(curve, way * degrees(atan(grade)), land)
