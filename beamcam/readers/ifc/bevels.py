"""Edges that lean through their wall: bevels, each with its angle and its land.

     looked-at surface
  ____________________
 /                        angle from square, until `land` is left;
|    land                 an X has another one from the far side
|_____________________
"""

from collections.abc import Sequence
from math import atan, atan2, degrees

from beamcam.geometry.curves import Line
from beamcam.model.part import Bevel
from beamcam.readers.ifc.curves2d import Chain
from beamcam.readers.ifc.region import Shape
from beamcam.readers.ifc.walls import Wall

SET_BACK = 0.05  #: mm by which a level stands back behind the outermost
MIN_EDGE = 1.0  #: mm of an edge that can be bevelled
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
        found += told or [_through(i, run)]
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
    return Bevel(curve, way * degrees(atan(grade)), land)


def _through(curve: int, run: Run) -> Bevel:
    """The bevel from surface to surface of an edge of another form."""
    near, far = run[0][1], run[-1][1]
    angle = degrees(atan2(max(near, far), run[-1][0] - run[0][0]))
    return Bevel(curve, angle if near > far else -angle, 0.0)
