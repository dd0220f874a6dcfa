"""Nesting of contours: which lies inside which."""

from collections import defaultdict
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

from msgspec.structs import replace

from beamcam.errors import Diagnostic, errors_in
from beamcam.planning.contours.assign_process import AssignedCurve
from beamcam.planning.contours.crossing import crossings, refuse_tangles
from beamcam.planning.contours.doubling import told_beside, told_flat, turns
from beamcam.planning.contours.outline import (
    Drawn,
    invalid,
    points_of,
    rings_of,
    signed_areas,
    valid,
)
from beamcam.planning.contours.pinch import taken_apart
from beamcam.planning.contours.shape import Shape

if TYPE_CHECKING:
    from numpy.typing import NDArray

#: A contour that is not wider than twice this, in mm, on an average has no inside.
MIN_WIDTH = 1e-3


def nest(
    shapes: Sequence[Shape],
    drawn: Drawn,
    wanted: Sequence[AssignedCurve],
    tolerance: float,
    gap: float,
    kerf: float,
) -> tuple[list[Shape], list[Diagnostic]]:
    """The shapes with their area, depth and parent, and remarks on those that cross.

    A contour lies in another of greater area that a point inside it lies in. Contours that touch
    are told apart by that, those that cross are not. `tolerance` is the machine's, and `gap` what
    it closes between two ends; `wanted` are the curves that the shapes were made of, and `drawn`
    points of the shapes with the shape of each. With a `kerf`, contours of waste that hangs
    together by a point only are taken apart there.
    """
    closed = [i for i, s in enumerate(shapes) if s.closed and s.process == "cut"]
    if not closed:
        return list(shapes), []
    import numpy as np

    points, owner = drawn
    number = np.full(len(shapes), -1)
    number[closed] = np.arange(len(closed))
    mine = number[owner] >= 0
    rings = rings_of(points[mine], number[owner[mine]], len(closed))
    bad = invalid(rings)
    refuse_tangles([shapes[i] for i in closed], rings, bad, wanted)
    said = crossings([shapes[i] for i in closed], rings, bad, wanted, tolerance, gap, kerf)
    found = _nested(shapes, closed, rings, bad)
    if not kerf or errors_in(said):
        return found, said
    turning = turns((points[mine], number[owner[mine]]))
    needles = list(told_beside([shapes[i] for i in closed], turning, tolerance))
    if needles:
        return found, [*said, *needles]
    # A needle whose mouth is written a hair wide does not meet itself.
    asked = [closed[k] for k in sorted({*bad, *turning})]
    more, flat = taken_apart(found, asked, tolerance)
    if flat:
        return found, [*said, *told_flat(flat)]
    if len(more) > len(found):
        drawn = points_of([s.curves for s in more], tolerance / 4)
        return nest(more, drawn, wanted, tolerance, gap, kerf)
    return found, said


def _nested(
    shapes: Sequence[Shape], closed: Sequence[int], rings: "NDArray[Any]", bad: Sequence[int]
) -> list[Shape]:
    """The shapes with their places; `rings` are the polygons of those that are `closed`."""
    import numpy as np
    import shapely

    found = list(shapes)
    signed = signed_areas(rings)
    areas = np.abs(signed)
    signed[areas <= MIN_WIDTH * shapely.length(rings)] = 0.0
    tree = shapely.STRtree(rings)
    with np.errstate(over="ignore"):  # it divides by sides of next to nothing too
        points = list(shapely.point_on_surface(valid(rings, bad)))
    asked = list(closed)
    own_area = list(areas)
    for i, shape in enumerate(shapes):
        if shape.process == "cut" and not shape.closed:
            points.append(shapely.Point(shape.curves[0].point(0.5)))
            asked.append(i)
            own_area.append(0.0)
    inner, outer = tree.query(points, predicate="within")
    around: dict[int, list[int]] = defaultdict(list)
    for a, b in zip(inner.tolist(), outer.tolist(), strict=True):
        if asked[a] != closed[b] and own_area[a] < areas[b]:
            around[asked[a]].append(b)
    for i, area in zip(asked, [*signed.tolist(), *[0.0] * (len(asked) - len(closed))], strict=True):
        rings_around = around[i]
        parent = closed[min(rings_around, key=lambda b: (areas[b], b))] if rings_around else -1
        found[i] = replace(shapes[i], area=area, depth=len(rings_around), parent=parent)
    for i, rings_around in around.items():
        for b in rings_around:
            _put_inside(found, i, closed[b])
    return found


def _put_inside(shapes: list[Shape], inner: int, outer: int) -> None:
    """Make a contour one of those around another, in the order of their areas.

    Of contours that cross, both around a third, neither lies in the other: the smaller of them
    counts as inner, so that what lies in both is done before both.
    """

    def size(k: int) -> tuple[float, int]:
        return abs(shapes[k].area), k

    while (parent := shapes[inner].parent) != outer:
        if parent < 0 or size(outer) < size(parent):
            shapes[inner] = replace(shapes[inner], parent=outer)
            if parent < 0:
                return
            inner, outer = outer, parent
        else:
            inner = parent
