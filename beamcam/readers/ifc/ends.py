"""The ends of a member: which plane cuts each, and its angles in DSTV's signs.

    x = a Y + b Z + c        web angle = -atan a, flange angle = -atan b

which is DSTV's atan2(x(lowest y) - x(highest y), y_high - y_low) at either end. Where several
planes or cuts form an end, the plane that holds most of the end's height and width counts, and
what it does not explain stays in the contours.
"""

from collections.abc import Iterable, Sequence
from math import atan, atan2, degrees
from operator import sub

from msgspec import Struct
from msgspec.structs import replace
from shapely import Point as ShapelyPoint

from beamcam.geometry.curves import Line, Point
from beamcam.model.part import Bevel
from beamcam.readers.ifc.curves2d import Chain
from beamcam.readers.ifc.cutters import HalfSpace
from beamcam.readers.ifc.region import Shape, pieces_of
from beamcam.readers.ifc.section import Wall
from beamcam.readers.ifc.space import add

MIN_EDGE = 1.0  #: mm across the member of an edge that counts for an end
SAME_REACH = 1e-4  #: mm by which one plane may be before the sole one
REACHED = 0.01  #: mm by which an end's plane may miss the end of the member
LEVEL_REACH = 0.08  #: mm that the outer levels of a wall lie inside it, at most
UNEXPLAINED = 0.05  #: mm, the width of what no end plane explains
SQUARE = 0.9  #: share of what a square end holds by which a plane of a face is taken before it
FILM = 0.05  #: mm before a plane in which the walls that end at it are seen


class Trim(Struct, frozen=True, gc=False):
    """Limits of a stock by the planes at one end, along the lines of its section's corners."""

    planes: tuple[HalfSpace, ...]  #: the stock's own square end, and those that cut it
    sole: HalfSpace | None  #: the one plane that cuts the whole section; None if several share it
    reach: float  #: side * x that the sole plane reaches at most; as `most` without one
    least: float  #: side * x up to which no plane takes anything
    most: float  #: side * x beyond which nothing is left


def trim(square: HalfSpace, cuts: Sequence[HalfSpace], corners: Sequence[Point]) -> Trim:
    """The end of a stock that is `square` before its cuts, at the (Y, Z) of the corners."""
    planes, level = (square, *cuts), square.side * square.point[0]
    if not cuts:
        return Trim(planes, square, level, level, level)
    lines = [[level] * len(corners), *(reaches(one, corners) for one in cuts)]
    left = list(map(min, *lines))
    least, most = min(left), max(left)
    for one, line in zip(planes, lines, strict=True):
        if max(map(sub, line, left)) <= SAME_REACH:
            return Trim(planes, one, max(line), least, most)
    return Trim(planes, None, most, least, most)


def reaches(end: HalfSpace, corners: Sequence[Point]) -> list[float]:
    """side * x of an end at each of the corners."""
    (a, b), c, side = end.slopes, end.x(0.0, 0.0), end.side
    return [side * (a * y + b * z + c) for y, z in corners]


Level = tuple[Wall, float, Shape]  #: a wall, c, and its region there


def end_of(
    side: int,
    planes: Iterable[HalfSpace],
    levels: Sequence[Level],
    corners: Sequence[Point],
    x: float | None = None,
) -> tuple[HalfSpace, float]:
    """The plane that most of an end lies in, and the x in which the member ends there.

    That is one of `planes` which reaches the end of the member at one of its section's corners, and
    leaves no wall beyond it: a shoulder of copes is not an end. Without one the end is square. `x`
    is where the member ends, if that is known better than from `levels`.
    """
    bounds = [p.bounds for _, _, s in levels for p in pieces_of(s)]
    outermost = max(b[2] for b in bounds) if side > 0 else min(b[0] for b in bounds)
    # A level lies a little inside its wall, and a leaning end reaches further at the surface.
    last, inside = (outermost, LEVEL_REACH) if x is None else (x, 0.0)
    best, best_x = HalfSpace.at(side, last), last
    most = SQUARE * _weight(best, levels)
    for one in planes:
        plane = one.facing(side)
        reached = side * max(reaches(plane, corners))
        if abs(reached - last) >= inside * sum(map(abs, one.slopes)) + REACHED:
            continue
        over = (s.intersection(plane.slice(wall, c)) for wall, c, s in levels)
        weight = _weight(plane, levels)
        if weight > most and all(shape.buffer(-UNEXPLAINED).is_empty for shape in over):
            best, best_x, most = plane, reached, weight
    return best, best_x if x is None else x


def _weight(end: HalfSpace, levels: Sequence[Level]) -> float:
    """mm across the walls in which they end at a plane."""
    film = replace(end, point=add(end.point, (-end.side * FILM, 0.0, 0.0)))
    areas = (float(s.intersection(film.slice(wall, c)).area) for wall, c, s in levels)
    return sum(areas) / FILM


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
    by_depth = sorted(levels, key=lambda level: -level[0] if wall.outer else level[0])
    bevels: list[Bevel] = []
    for i, curve in enumerate(outer):
        if not isinstance(curve, Line) or curve.length < MIN_EDGE:
            continue
        middle = ShapelyPoint(curve.point(0.5))
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
        bevels += told
    return tuple(bevels)


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
