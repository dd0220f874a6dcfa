"""Curves that run over one place again and again, refused before anything is compared with all."""

from collections.abc import Sequence

import numpy as np

from beamcam.errors import PlanError
from beamcam.geometry.array_types import Counts, Floats
from beamcam.geometry.arrays import CurveTable
from beamcam.geometry.curves import Arc, Line
from beamcam.geometry.near import first_equal
from beamcam.planning.contours import rules
from beamcam.planning.contours.assign_process import AssignedCurve
from beamcam.planning.contours.outline import Drawn
from beamcam.planning.contours.shape import Shape

#: Times that a contour may be passed on an average. Hatching of 0.02 mm passes a place of 0.1 mm
#: five times; work that takes every pair of curves on one place grows with the square of it.
MAX_PASSES = 64
MAX_ASKED = 1000  #: stretches of which the neighbours are counted
MAX_EQUAL = 300_000  #: pairs of curves with the same numbers: 775 copies of one, 245 of ten
CELLS = 512  #: along the longer side of the grid in which neighbours are looked for


def refuse_copies(wanted: Sequence[AssignedCurve], curves: CurveTable) -> None:
    """Raise PlanError where more than `MAX_EQUAL` pairs of the curves are equal in every number."""
    first = np.arange(len(wanted))
    free = np.array(curves.free(), dtype=np.int64)
    kinds = (
        (curves.where(Line), curves.lines), (curves.where(Arc), curves.arcs),
        (free, curves.ends[free]),
    )  # fmt: skip
    for which, rows in kinds:
        if len(which):
            first[which] = which[first_equal(rows)]
    times = np.bincount(first)
    if (times * (times - 1) // 2).sum() > MAX_EQUAL:
        most = int(np.argmax(times))
        copies = len(wanted) - np.count_nonzero(times)
        raise PlanError(rules.COPIES.at(wanted[most].source, found=times[most], copies=copies))


def refuse_crowds(shapes: Sequence[Shape], drawn: Drawn, tolerance: float) -> None:
    """Raise PlanError for shapes that pass most of their places more than `MAX_PASSES` times.

    `drawn` are points of the shapes, and the shape of each. The passes of a place are the lengths
    of all stretches no farther than `tolerance` from it, each no longer than that place, by its
    length.
    """
    import shapely

    points, owner = drawn
    along = owner[1:] == owner[:-1]
    starts, ends, owner = points[:-1][along], points[1:][along], owner[1:][along]
    if not len(starts):
        return
    every = -(-len(starts) // MAX_ASKED)
    asked = np.arange(0, len(starts), max(every, 1))
    places = (starts[asked] + ends[asked]) / 2
    kept = _may_pass(starts, ends, places, tolerance)
    starts, ends = starts[kept], ends[kept]
    stretches = shapely.linestrings(np.stack((starts, ends), axis=1))
    middles = shapely.points(places)
    near, place = shapely.STRtree(middles).query(stretches, "dwithin", distance=tolerance)
    lengths = np.minimum(np.hypot(*(ends - starts).T), 2 * tolerance)
    passes = np.bincount(place, lengths[near], len(asked)) / (2 * tolerance)
    if passes.mean() > MAX_PASSES:
        worst = int(np.argmax(passes))
        x, y = shapely.get_coordinates(middles[worst])[0].tolist()
        raise PlanError(
            rules.CROWDED.at(
                shapes[int(owner[asked[worst]])].source,
                found=f"{passes[worst]:.0f}",
                reach=f"{tolerance:g}",
                x=f"{x:.3f}",
                y=f"{y:.3f}",
                expected=MAX_PASSES,
            )
        )


def _may_pass(starts: Floats, ends: Floats, places: Floats, tolerance: float) -> Counts:
    """The stretches that may pass a place within the tolerance.

    Those have a place in a cell of a grid that the box around them comes into. How many places lie
    in the cells of a box follows from the sums of all cells below and to the left of its corners.
    """
    one, other = np.ascontiguousarray(starts.T), np.ascontiguousarray(ends.T)
    low, high = np.minimum(one, other) - tolerance, np.maximum(one, other) + tolerance
    origin = low.min(axis=1, keepdims=True)
    cell = max(float((high.max(axis=1, keepdims=True) - origin).max()) / CELLS, tolerance)

    def cells(points: Floats) -> Counts:
        found: Counts = ((points - origin) / cell).astype(np.int64)
        return found

    side = CELLS + 2
    x, y = cells(places.T)
    held = np.bincount((x + 1) * side + y + 1, minlength=side * side).reshape(side, side)
    sums = held.cumsum(axis=0).cumsum(axis=1).ravel()
    (x0, y0), (x1, y1) = cells(low), cells(high) + 1
    inside = sums[x1 * side + y1] - sums[x0 * side + y1] - sums[x1 * side + y0]
    return np.flatnonzero(inside + sums[x0 * side + y0])
