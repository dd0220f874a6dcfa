"""Points that are near one another and rows that are equal, found in near-linear time."""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from beamcam.geometry.array_types import Counts, Floats
from beamcam.geometry.arrays import CurveTable
from beamcam.geometry.curves import Arc, Line

#: A row of cells in the number of a cell; there are less than half as many rows and columns.
ROW = 2**31
MOST_CELLS = 2.0**29

#: The digits of the golden ratio; the powers of an odd number mix rows to their keys.
ODD = np.uint64(0x9E3779B97F4A7C15)

#: From a cell to itself and to half of its neighbours; the other half looks from over there.
_STEPS = (0, 1, ROW - 1, ROW, ROW + 1)


def near_pairs(points: Floats, reach: float) -> tuple[Counts, Counts]:
    """Indices a < b of all points (n, 2) no farther apart than `reach`, ascending.

    The cells are as wide as the reach, so that it is enough to look into neighbouring ones.
    Raises ValueError if the reach is not above 0.
    """
    if not reach > 0.0:
        raise ValueError(f"reach must be above 0, found {reach:g}")
    if len(points) < 2:
        none = np.empty(0, dtype=np.int64)
        return none, none
    low = points.min(axis=0)
    extent = float((points.max(axis=0) - low).max())
    # A little wider, so that rounding puts no two near points two cells apart.
    cell = max(reach * (1 + 1e-6), extent / MOST_CELLS)
    column_row = np.floor((points - low) / cell).astype(np.int64)
    key = column_row[:, 0] * ROW + column_row[:, 1]
    order = np.argsort(key, kind="stable")
    key = key[order]
    firsts, seconds = [], []
    for step in _STEPS:
        begin = np.searchsorted(key, key + step)
        if step == 0:
            begin = np.arange(1, len(key) + 1)
        end = np.searchsorted(key, key + step, side="right")
        counts = np.maximum(end - begin, 0)
        first = np.repeat(np.arange(len(key)), counts)
        second = np.arange(len(first)) + np.repeat(begin - (np.cumsum(counts) - counts), counts)
        firsts.append(order[first])
        seconds.append(order[second])
    a, b = np.concatenate(firsts), np.concatenate(seconds)
    away = points[a] - points[b]
    near = np.hypot(away[:, 0], away[:, 1]) <= reach
    a, b = np.minimum(a[near], b[near]), np.maximum(a[near], b[near])
    order = np.lexsort((b, a))
    return a[order], b[order]


def first_equal(rows: Floats) -> Counts:
    """For each row (n, m) the first one that is equal to it in every digit, itself if none is."""
    bits = np.ascontiguousarray(rows + 0.0).view(np.uint64)  # -0.0 becomes 0.0
    factors = np.cumprod(np.full(rows.shape[1], ODD))
    key = (bits * factors).sum(axis=1, dtype=np.uint64)
    order = np.argsort(key, kind="stable")
    # Rows of one key that differ all the same are just not told apart as well as they could be.
    new = np.ones(len(rows), dtype=bool)
    new[1:] = np.any(bits[order][1:] != bits[order][:-1], axis=1)
    firsts = np.empty(len(rows), dtype=np.int64)
    firsts[order] = order[np.maximum.accumulate(np.where(new, np.arange(len(rows)), 0))]
    return firsts


#: Curves nearer than this coincide; exports round to 1e-4 and finer.
SAME_PLACE = 1e-3


def overlapping(curves: CurveTable, processes: Sequence[str]) -> list[tuple[int, int]]:
    """Pairs of curves of the same process that may lie on one another, ascending.

    Lines have to be collinear, arcs on one circle, and other curves to have the same ends.
    """
    lines, arcs, others = curves.where(Line), curves.where(Arc), np.array(curves.free(), dtype=int)
    ends = curves.ends[others]
    pairs = [
        lines[np.array(_collinear(curves.lines))],
        arcs[np.array(_concentric(curves.arcs))],
        others[np.array(near_pairs((ends[:, :2] + ends[:, 2:]) / 2, SAME_PLACE))],
    ]
    first, second = np.sort(np.concatenate(pairs, axis=1), axis=0)
    numbers = {name: k for k, name in enumerate(dict.fromkeys(processes))}
    process = np.array([numbers[name] for name in processes], dtype=np.int64)
    alike = np.flatnonzero(process[first] == process[second])
    alike = alike[np.lexsort((second[alike], first[alike]))]
    return list(zip(first[alike].tolist(), second[alike].tolist(), strict=True))


def _concentric(arcs: NDArray[np.float64]) -> tuple[Counts, Counts]:
    """Pairs of arcs (n, 5) on one circle."""
    a, b = near_pairs(arcs[:, :2], SAME_PLACE)
    near = np.abs(arcs[a, 2] - arcs[b, 2]) <= SAME_PLACE
    return a[near], b[near]


def _collinear(ends: NDArray[np.float64]) -> tuple[Counts, Counts]:
    """Pairs of lines (n, 4) that lie on one line and overlap by more than `SAME_PLACE`."""
    import shapely

    if len(ends) < 2:
        none = np.empty(0, dtype=np.int64)
        return none, none
    low = np.minimum(ends[:, :2], ends[:, 2:])
    high = np.maximum(ends[:, :2], ends[:, 2:])
    boxes = shapely.box(
        low[:, 0] - SAME_PLACE, low[:, 1] - SAME_PLACE,
        high[:, 0] + SAME_PLACE, high[:, 1] + SAME_PLACE,
    )  # fmt: skip
    a, b = shapely.STRtree(boxes).query(boxes)
    a, b = a[a < b], b[a < b]
    lengths = np.hypot(*(ends[:, 2:] - ends[:, :2]).T)
    # The longer of both gives the direction.
    swap = lengths[b] > lengths[a]
    long, short = np.where(swap, b, a), np.where(swap, a, b)
    real = lengths[long] > SAME_PLACE
    long, short = long[real], short[real]
    unit = (ends[long, 2:] - ends[long, :2]) / lengths[long][:, None]
    away, along = [], []
    for part in (ends[short, :2], ends[short, 2:]):
        rest = part - ends[long, :2]
        away.append(np.abs(unit[:, 0] * rest[:, 1] - unit[:, 1] * rest[:, 0]))
        along.append(np.sum(unit * rest, axis=1))
    shared = np.minimum(np.maximum(*along), lengths[long]) - np.maximum(np.minimum(*along), 0.0)
    same = (np.maximum(*away) <= SAME_PLACE) & (shared > SAME_PLACE)
    return long[same], short[same]
