"""Stretches of a tour turned round where that shortens the way.

    a   c   d   b              a   d   c   b
    o---o   o---o      ->      o---o   o---o      if |ad| + |cb| < |ac| + |db|

A stretch may be turned if no contour in it lies inside another one of it, since those two would
change places. The ways inside a stretch keep their lengths: open contours are turned with it.

From each place of the tour, in their order, the best stretch is taken; then again from the first
place on. What a place looks at is the `WINDOW` places behind it, so that a place is asked again
only after something there was turned.
"""

from collections.abc import Callable

import numpy as np

from beamcam.geometry.array_types import Counts, Floats
from beamcam.geometry.plane import Point

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
        self,
        tour: list[tuple[int, bool]],
        starts: Floats,
        ends: Floats,
        parents: Counts,
        here: Point,
    ) -> None:
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
            found = self._first_to_turn(places)
            if found is None:
                self._asks[places] = False
                at, together = int(places[-1]) + 1, min(2 * together, MOST_AT_ONCE)
                continue
            first, last = found
            self._asks[places[places < first]] = False
            self._turn(first, last)
            improved = True
            at, together = first + 1, AFTER_A_TURN

    def _first_to_turn(self, places: Counts) -> tuple[int, int] | None:
        """The first of `places` from which a stretch is worth turning, and the best one's last.

        Quick lengths show that most are not, and as a rule which stretch gains most; where gains
        are too near one another for that, exact lengths decide.
        """
        quick = self._gains(places, _quick_lengths)
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
        found: Counts = places[self._nodes]
        return found


def _quick_lengths(x: Floats, y: Floats) -> Floats:
    """As `np.hypot` but for the last digit, in a third of the time."""
    return np.sqrt(x * x + y * y)
