"""Points that are near one another and rows that are equal, found in near-linear time."""

import numpy as np

from beamcam.geometry.array_types import Counts, Floats

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
    found = np.empty(len(rows), dtype=np.int64)
    found[order] = order[np.maximum.accumulate(np.where(new, np.arange(len(rows)), 0))]
    return found
