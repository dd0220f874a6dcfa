"""Pairs of curves that may lie on one another."""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from beamcam.geometry.array_types import Counts
from beamcam.geometry.arrays import CurveTable
from beamcam.geometry.curves import Arc, Line
from beamcam.geometry.near import near_pairs

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
