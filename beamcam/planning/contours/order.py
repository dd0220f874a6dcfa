"""The order of contours: marks before cuts, inner before outer, with short traverses.

First the nearest contour each time (`nearest`), then stretches of the tour turned round where that
shortens the way (`two_opt`).
"""

from collections import Counter, defaultdict
from collections.abc import Callable, Iterator, Sequence
from itertools import product
from math import floor, inf

import numpy as np

from beamcam.errors import Diagnostic
from beamcam.geometry.array_types import Counts, Floats
from beamcam.geometry.plane import Point
from beamcam.machine.torch import LayerSettings, Torch
from beamcam.planning.contours import rules
from beamcam.planning.contours.outline import Shape

# --- two opt --------------------------------------------------------------------------------------

# Stretches of a tour turned round where that shortens the way.
#
#     a   c   d   b              a   d   c   b
#     o---o   o---o      ->      o---o   o---o      if |ad| + |cb| < |ac| + |db|
#
# A stretch may be turned if no contour in it lies inside another one of it, since those two would
# change places. The ways inside a stretch keep their lengths: open contours are turned with it.
#
# From each place of the tour, in their order, the best stretch is taken; then again from the first
# place on. What a place looks at is the `WINDOW` places behind it, so that a place is asked again
# only after something there was turned.


Lengths = Callable[[Floats, Floats], Floats]  #: of vectors by their x and y

WINDOW = 60  #: longest stretch that is turned round
PASSES = 6  #: over the whole tour; the third rarely gains one per cent
MIN_GAIN = 1e-9
MOST_AT_ONCE = 256  #: places evaluated together
AFTER_A_TURN = 24  #: and at first after a turn, as another one is seldom far


def turn_stretches(
    tour: list[tuple[int, bool]], starts: Floats, ends: Floats, parents: Counts, here: Point
) -> list[tuple[int, bool]]:
    """The tour, begun at `here`, with stretches turned round while that shortens it."""
    if len(tour) < 3:
        return tour
    ways = _Ways(tour, starts, ends, parents, here)
    for _ in range(PASSES):
        if not ways.one_pass():
            break
    return ways.tour()


class _Ways:
    """A tour as arrays, in the order of its places."""

    def __init__(
        self, tour: list[tuple[int, bool]], starts: Floats, ends: Floats, parents: Counts,
        here: Point,
    ) -> None:  # fmt: skip
        self._count = len(tour)
        self._nodes = np.array([index for index, _ in tour])
        self._turned = np.array([turned for _, turned in tour])
        begin, end = starts[self._nodes].T, ends[self._nodes].T
        #: Where each place is entered, x and y; column `count` stands for nothing.
        self._enter = np.zeros((2, self._count + 1))
        self._enter[:, :-1] = np.where(self._turned, end, begin)
        #: Column k + 1 is where place k is left; column 0 is where the head comes from.
        self._leave = np.empty((2, self._count + 1))
        self._leave[:, 0] = here
        self._leave[:, 1:] = np.where(self._turned, begin, end)
        #: The length of the way to each place; none to what comes behind the last one.
        self._ways = np.zeros(self._count + 1)
        self._measure(slice(0, self._count))
        self._parents = parents
        self._nested = bool((parents[self._nodes] >= 0).any())
        self._inner = self._last_inner()
        self._asks = np.ones(self._count, dtype=bool)

    def tour(self) -> list[tuple[int, bool]]:
        """The contours in their order, and which of them are turned."""
        return list(zip(self._nodes.tolist(), self._turned.tolist(), strict=True))

    def one_pass(self) -> bool:
        """Turns the best stretch from each place, in their order; whether any was turned."""
        improved = False
        at, together = 0, 1
        while True:
            places = at + np.flatnonzero(self._asks[at : self._count - 1])[:together]
            if not len(places):
                return improved
            pair = self._first_to_turn(places)
            if pair is None:
                self._asks[places] = False
                at, together = int(places[-1]) + 1, min(2 * together, MOST_AT_ONCE)
                continue
            first, last = pair
            self._asks[places[places < first]] = False
            self._turn(first, last)
            improved = True
            at, together = first + 1, AFTER_A_TURN

    def _first_to_turn(self, places: Counts) -> tuple[int, int] | None:
        """The first of `places` from which a stretch is worth turning, and the best one's last.

        Quick lengths show that most are not, and as a rule which stretch gains most; where gains
        are too near one another for that, exact lengths decide.
        """
        # As `np.hypot` but for the last digit, in a third of the time.
        quick = self._gains(places, lambda x, y: np.sqrt(x * x + y * y))
        for k in np.flatnonzero(quick.max(axis=1) > MIN_GAIN / 2).tolist():
            place, gains = int(places[k]), quick[k]
            near_best = np.flatnonzero(gains > gains.max() - MIN_GAIN / 2)
            if len(near_best) > 1 or gains.max() < 2 * MIN_GAIN:
                gains = self._gains(places[k : k + 1], np.hypot)[0]
            best = int(gains.argmax())
            if gains[best] > MIN_GAIN:
                return place, place + 1 + best
        return None

    def _gains(self, places: Counts, lengths: Lengths) -> Floats:
        """What is gained by turning the stretches from each of `places` to the one behind it, to
        the second one behind it and so on, (n, WINDOW - 1); -inf for what cannot be turned."""
        count = self._count
        last = places[:, None] + np.arange(1, WINDOW)
        behind = np.minimum(last + 1, count)
        from_x, from_y = (v[:, None] for v in self._leave[:, places])
        into_x, into_y = (v[:, None] for v in self._enter[:, places])
        out_x, out_y = self._leave.take(behind, axis=1)
        next_x, next_y = self._enter.take(behind, axis=1)
        gains = self._ways[places][:, None] - lengths(out_x - from_x, out_y - from_y)
        gains += self._ways[behind]
        to_next = lengths(next_x - into_x, next_y - into_y)
        if places[-1] + WINDOW >= count:
            to_next[behind == count] = 0.0  # nothing comes behind the last one
            gains[last >= count] = -np.inf
        gains -= to_next
        if self._nested:
            # The stretch ends before a contour that lies round one of its others.
            clash = self._inner[behind - 1] >= places[:, None]
            gains[np.logical_or.accumulate(clash, axis=1)] = -np.inf
        return gains

    def _turn(self, i: int, j: int) -> None:
        """Turns the stretch from place `i` to `j`."""
        stretch, left = slice(i, j + 1), slice(i + 1, j + 2)
        self._nodes[stretch] = self._nodes[stretch][::-1].copy()
        self._turned[stretch] = ~self._turned[stretch][::-1]
        enter, leave = self._leave[:, left][:, ::-1].copy(), self._enter[:, stretch][:, ::-1].copy()
        self._enter[:, stretch], self._leave[:, left] = enter, leave
        self._measure(slice(i, min(j + 2, self._count)))
        self._asks[max(0, i - WINDOW - 1) : j + 2] = True
        if self._nested:
            self._inner = self._last_inner()

    def _measure(self, places: slice) -> None:
        """Measures the ways to some places."""
        self._ways[places] = np.hypot(*(self._enter[:, places] - self._leave[:, places]))

    def _last_inner(self) -> Counts:
        """The last place of a contour right inside the one at each place; -1 for none."""
        places = np.full(len(self._parents), -1)
        around = self._parents[self._nodes]
        has = around >= 0
        np.maximum.at(places, around[has], np.flatnonzero(has))
        last_inner: Counts = places[self._nodes]
        return last_inner


# --- nearest --------------------------------------------------------------------------------------

# The greedy tour: the contour nearest to the head whose inner contours are done.
#
# The ends of the contours that may be done next lie in square cells. They are looked for in rings
# of cells about the head; where the next ones lie far off, all that are left are measured at once.


#: Ends in a cell, on the average; and rings of cells that are looked into before all are.
ENDS_A_CELL = 2
FARTHEST_RING = 4

#: An end as it is chosen by: square of the distance, 1 for the end of a contour and 0 for its
#: start, and when the contour came free. So equal distances are decided the same way each time.
Choice = tuple[float, int, int]
NOTHING: Choice = (inf, 2, 0)

Cell = tuple[int, int]  #: column and row


#: Offsets of the cells in each square ring, so many cells away.
_RINGS: list[list[Cell]] = [[] for _ in range(FARTHEST_RING + 1)]
for _column, _row in product(range(-FARTHEST_RING, FARTHEST_RING + 1), repeat=2):
    _RINGS[max(abs(_column), abs(_row))].append((_column, _row))


def nearest_first(
    stage: Sequence[int], starts: Sequence[Point], ends: Sequence[Point],
    parents: Sequence[int], here: Point,
) -> list[tuple[int, bool]]:  # fmt: skip
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
        """`places` are those of all contours that will ever be free, one or more."""
        xy = np.array(places, dtype=np.float64).reshape(-1, 2)
        span = np.ptp(xy, axis=0)
        area = max(float(span[0] * span[1]), float(span.max()) ** 2 / len(xy))
        self._cell = (area * ENDS_A_CELL / len(xy)) ** 0.5 or 1.0
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
        away = self._ends[: len(self._where)] - (*here, *here)
        squares = away * away
        to_start, to_end = squares[:, 0] + squares[:, 1], squares[:, 2] + squares[:, 3]
        first, last = int(np.argmin(to_start)), int(np.argmin(to_end))
        return min((float(to_start[first]), 0, first), (float(to_end[last]), 1, last))


Tour = list[tuple[int, bool]]
#: Of processes, behind those of any other: spots by the torch's place.
TURNS = {"spot": 1, "cut": 2}


def order(shapes: Sequence[Shape], ranks: Sequence[int] = (), fixed: Sequence[bool] = ()) -> Tour:
    """Each shape by its index, and whether it is followed backwards, in the order of work.

    Those of lower `ranks` come first, whatever they are, then those of lower levels; those that are
    `fixed` are never turned.

    Closed shapes are met at their first point; which way round they go is not said here.
    """
    starts = [s.curves[0].start for s in shapes]
    ends = [
        start if s.closed or is_fixed else s.curves[-1].end
        for s, start, is_fixed in zip(shapes, starts, fixed or [False] * len(shapes), strict=True)
    ]
    parents = [s.parent for s in shapes]
    ranks = ranks or [0] * len(shapes)
    stages: dict[tuple[int, int, int], list[int]] = {}
    for k, (rank, shape) in enumerate(zip(ranks, shapes, strict=True)):
        turn = TURNS.get(shape.process, 0)
        stages.setdefault((rank, turn, shape.level), []).append(k)
    here: Point = (0.0, 0.0)
    done: Tour = []
    for _, stage in sorted(stages.items()):
        own = set(stage)
        within = [parent if parent in own else -1 for parent in parents]
        tour = nearest_first(stage, starts, ends, within, here)
        begins, stops = (np.array(points, dtype=float) for points in (starts, ends))
        tour = turn_stretches(tour, begins, stops, np.array(within), here)
        done += tour
        if tour:
            last, turned = tour[-1]
            here = starts[last] if turned else ends[last]
    return done


# --- settings ------------------------------------------------------------------------------------

# What the settings of a colour or a layer say of the order of its contours.

PLAIN = LayerSettings()


def rank(shape: Shape, torch: Torch) -> int:
    """The place in the order of work that the settings of a contour give it; 0 without any."""
    return torch.settings.get(shape.look, PLAIN).order


def refuse_order(shapes: Sequence[Shape], torch: Torch) -> Iterator[Diagnostic]:
    """An error for the first contour whose turn is after one around it, or a mark's after a cut."""
    if not any(own.order for own in torch.settings.values()):
        return
    cuts = [shape for shape in shapes if shape.process == "cut"]
    earliest = min(cuts, key=lambda s: rank(s, torch), default=None)
    for shape in shapes:
        around = shapes[shape.parent] if shape.parent >= 0 else None
        before = around if shape.process == "cut" else earliest
        if before is not None and rank(before, torch) < rank(shape, torch):
            ranks = {"found": rank(shape, torch), "expected": rank(before, torch)}
            yield rules.LOOK_ORDER.at(
                shape.source, key=shape.look, process=shape.process, other=before.source, **ranks
            )
            return
