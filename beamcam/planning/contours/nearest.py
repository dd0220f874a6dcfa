"""The greedy tour: the contour nearest to the head whose inner contours are done.

The ends of the contours that may be done next lie in square cells. They are looked for in rings of
cells about the head; where the next ones lie far off, all that are left are measured at once.
"""

from collections import Counter, defaultdict
from collections.abc import Sequence
from math import floor, inf

import numpy as np

from beamcam.geometry.plane import Point

#: Ends in a cell, on the average; and rings of cells that are looked into before all are.
ENDS_A_CELL = 2
FARTHEST_RING = 4

#: An end as it is chosen by: square of the distance, 1 for the end of a contour and 0 for its
#: start, and when the contour came free. So equal distances are decided the same way each time.
Choice = tuple[float, int, int]
NOTHING: Choice = (inf, 2, 0)

Cell = tuple[int, int]  #: column and row


def _ring(ring: int) -> list[Cell]:
    """Offsets of the cells in the square ring `ring` cells away."""
    span = range(-ring, ring + 1)
    return [(i, k) for i in span for k in span if max(abs(i), abs(k)) == ring]


_RINGS = [_ring(ring) for ring in range(FARTHEST_RING + 1)]


def nearest_first(
    stage: Sequence[int],
    starts: Sequence[Point],
    ends: Sequence[Point],
    parents: Sequence[int],
    here: Point,
) -> list[tuple[int, bool]]:
    """The contours of `stage` in greedy order, and whether each is begun at its end.

    A contour waits until all those are done whose parent it is.
    """
    waiting = Counter(parents[k] for k in stage)
    members = [k for k in stage if not waiting[k]]
    free = _Free([(starts[k], ends[k]) for k in stage])
    for k in members:
        free.add(starts[k], ends[k])
    tour: list[tuple[int, bool]] = []
    while free.count:
        _, side, number = free.nearest(here)
        free.remove(number)
        index, turned = members[number], bool(side)
        tour.append((index, turned))
        here = starts[index] if turned else ends[index]
        parent = parents[index]
        if parent >= 0:
            waiting[parent] -= 1
            if not waiting[parent]:
                members.append(parent)
                free.add(starts[parent], ends[parent])
    return tour


class _Free:
    """The contours that may be done next, by the number in which they came free."""

    def __init__(self, places: Sequence[tuple[Point, Point]]) -> None:
        """`places` are those of all contours that will ever be free."""
        xy = np.array(places, dtype=np.float64).reshape(-1, 2)
        span = np.ptp(xy, axis=0) if len(xy) else np.zeros(2)
        area = max(float(span[0] * span[1]), float(span.max()) ** 2 / max(len(xy), 1))
        self._cell = (area * ENDS_A_CELL / max(len(xy), 1)) ** 0.5 or 1.0
        self._cells: defaultdict[Cell, list[tuple[float, float, int, int]]] = defaultdict(list)
        self._where: list[set[Cell]] = []  #: the cells that the ends of each lie in
        #: Both ends of each; at infinity once it is done.
        self._ends = np.full((len(places), 4), inf)
        self.count = 0

    def add(self, start: Point, end: Point) -> None:
        """One more contour; its number is how many there were before."""
        number = len(self._where)
        self._ends[number] = (*start, *end)
        self._where.append({self._cell_of(start), self._cell_of(end)})
        for side, point in enumerate((start, end) if start != end else (start,)):
            self._cells[self._cell_of(point)].append((*point, side, number))
        self.count += 1

    def remove(self, number: int) -> None:
        """The contour is done."""
        for cell in self._where[number]:
            self._cells[cell] = [entry for entry in self._cells[cell] if entry[3] != number]
        self._ends[number] = inf
        self.count -= 1

    def _cell_of(self, point: Point) -> Cell:
        return floor(point[0] / self._cell), floor(point[1] / self._cell)

    def nearest(self, here: Point) -> Choice:
        """The nearest end."""
        column, row = self._cell_of(here)
        x, y = here
        best = NOTHING
        # How far the head is from the next cells.
        clear = min(
            x - column * self._cell, (column + 1) * self._cell - x,
            y - row * self._cell, (row + 1) * self._cell - y,
        )  # fmt: skip
        for ring, steps in enumerate(_RINGS):
            for i, k in steps:
                for px, py, side, number in self._cells.get((column + i, row + k), ()):
                    dx, dy = px - x, py - y
                    choice = (dx * dx + dy * dy, side, number)
                    if choice < best:
                        best = choice
            # So far to every side there is nothing that was not looked at.
            if best[0] < ((ring * self._cell + clear) * (1 - 1e-9)) ** 2:
                return best
        return self._nearest_of_all(here)

    def _nearest_of_all(self, here: Point) -> Choice:
        away = self._ends[: len(self._where)] - (*here, *here)
        squares = away * away
        to_start, to_end = squares[:, 0] + squares[:, 1], squares[:, 2] + squares[:, 3]
        first, last = int(np.argmin(to_start)), int(np.argmin(to_end))
        return min((float(to_start[first]), 0, first), (float(to_end[last]), 1, last))
