"""Curves that run over one place again and again, refused before anything is compared with all."""

from collections.abc import Sequence

import numpy as np

from beamcam.errors import PlanError
from beamcam.geometry.array_types import Counts, Floats
from beamcam.planning.contours import rules
from beamcam.planning.contours.outline import Drawn
from beamcam.planning.contours.shape import Shape

#: Times that a contour may be passed on an average. Hatching of 0.02 mm passes a place of 0.1 mm
#: five times; work that takes every pair of curves on one place grows with the square of it.
MAX_PASSES = 64
MAX_ASKED = 1000  #: stretches of which the neighbours are counted
CELL = 1.0  #: mm, of the grid in which neighbours are looked for
MAX_CELLS = 1 << 24


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

    Those are all that are longer than half a cell, and of the others those that start in a cell
    with a place, or beside one.
    """
    cell = max(CELL, 8 * tolerance)
    low = np.minimum(starts.min(axis=0), ends.min(axis=0)) - 2 * cell
    high = np.maximum(starts.max(axis=0), ends.max(axis=0))
    columns, rows = (np.floor((high - low) / cell).astype(np.int64) + 3).tolist()
    if columns * rows > MAX_CELLS:
        return np.arange(len(starts))

    def cells(points: Floats) -> Counts:
        x, y = ((points - low) / cell).astype(np.int64).T
        found: Counts = x * rows + y
        return found

    wanted = np.zeros(columns * rows, dtype=bool)
    for step in (-rows - 1, -rows, 1 - rows, -1, 0, 1, rows - 1, rows, rows + 1):
        wanted[cells(places) + step] = True
    is_long = np.maximum(*np.abs(ends - starts).T) > cell / 2
    found: Counts = np.flatnonzero(wanted[cells(starts)] | is_long)
    return found
