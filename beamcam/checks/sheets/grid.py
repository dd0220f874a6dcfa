"""Which elements lie near which points, by the cells of a square grid."""

from collections.abc import Iterator
from copy import copy
from functools import cached_property

import numpy as np
from msgspec import Struct

from beamcam.checks.sheets import rules
from beamcam.errors import Source, VerifyError
from beamcam.geometry.array_types import Counts, Flags, Floats

# --- elements -------------------------------------------------------------------------------------

# Lines and arcs in arrays, the elements of every chain.
#
# Arcs are kept as they are. Other curves are chains of chords.


QUARTERS = ((1.0, 0.0), (0.0, 1.0), (-1.0, 0.0), (0.0, -1.0))


class Elements:
    """Lines and arcs; rows of `arcs` are 0 where an element is a line."""

    def __init__(self, start: Floats, end: Floats, is_arc: Flags, arcs: Floats) -> None:
        self.start = start  #: (n, 2)
        self.end = end
        self.is_arc = is_arc
        self.arcs = arcs  #: centre x, y, radius, start and sweep in rad, (n, 5)
        x, y = (end - start).T
        self.chord: Floats = np.hypot(x, y)
        safe = np.where(self.chord > 0.0, self.chord, 1.0)
        #: Direction of the chord, along x and along y; 0 where an element has no length.
        self.along: tuple[Floats, Floats] = (x / safe, y / safe)
        radius, turn = arcs[is_arc, 2], np.abs(arcs[is_arc, 4])
        self.length = self.chord.copy()
        self.length[is_arc] = radius * turn
        #: How far an element leaves its chord at most; of more than half a circle its diameter.
        self.rise: Floats = np.zeros(len(self.chord))
        self.rise[is_arc] = np.where(turn <= np.pi, radius * (1 - np.cos(turn / 2)), 2 * radius)

    def __len__(self) -> int:
        return len(self.length)

    @cached_property
    def columns(self) -> tuple[Floats, ...]:
        """x and y of the start, and of the direction of the chord, each in one piece."""
        return (*(np.ascontiguousarray(c) for c in self.start.T), *self.along)

    def moved(self, shift: tuple[float, float]) -> "Elements":
        """The same elsewhere."""
        arcs = self.arcs.copy()
        arcs[self.is_arc, :2] += shift
        return Elements(self.start + shift, self.end + shift, self.is_arc, arcs)

    def boxes(self) -> tuple[Floats, Floats]:
        """Minimum and maximum corner of the box around each element, (n, 2) each."""
        low, high = np.minimum(self.start, self.end), np.maximum(self.start, self.end)
        rows = np.flatnonzero(self.is_arc)
        arcs = self.arcs[rows]
        for quarter, direction in enumerate(QUARTERS):
            turn = (quarter * np.pi / 2 - arcs[:, 3]) * np.sign(arcs[:, 4]) % (2 * np.pi)
            passes = turn <= np.abs(arcs[:, 4])
            corner = arcs[passes, :2] + arcs[passes, 2:3] * direction
            row = rows[passes]
            low[row] = np.minimum(low[row], corner)
            high[row] = np.maximum(high[row], corner)
        return low, high

    def places(self, which: Counts, share: Floats) -> Floats:
        """The places of elements at shares of their lengths, (n, 2)."""
        start_x, start_y, way_x, way_y = (column.take(which) for column in self.columns)
        along = self.chord.take(which) * share
        x, y = start_x + along * way_x, start_y + along * way_y
        bent = np.flatnonzero(self.is_arc.take(which))
        if len(bent):
            centre_x, centre_y, radius, first, sweep = self.arcs.take(which[bent], axis=0).T
            turn = first + sweep * share[bent]
            x[bent] = centre_x + radius * np.cos(turn)
            y[bent] = centre_y + radius * np.sin(turn)
        return np.stack((x, y)).T

    def directions(self, which: Counts, share: Floats) -> Floats:
        """The direction of travel at shares of elements, (n, 2)."""
        x, y = (column.take(which) for column in self.along)
        bent = np.flatnonzero(self.is_arc.take(which))
        if len(bent):
            first, sweep = self.arcs.take(which[bent], axis=0).T[3:]
            turn, sign = first + sweep * share[bent], np.sign(sweep)
            x[bent], y[bent] = -np.sin(turn) * sign, np.cos(turn) * sign
        return np.stack((x, y)).T

    def from_chords(self, x: Floats, y: Floats, which: Counts) -> tuple[Floats, Floats]:
        """The same as if all elements were straight; `chord` is the length of each then."""
        start_x, start_y, way_x, way_y = (column.take(which) for column in self.columns)
        to_x, to_y = x - start_x, y - start_y
        along = to_x * way_x
        along += to_y * way_y
        np.clip(along, 0.0, self.chord.take(which), out=along)
        to_x -= along * way_x
        to_y -= along * way_y
        to_x *= to_x
        to_y *= to_y
        to_x += to_y
        return np.sqrt(to_x, out=to_x), along

    def from_arcs(self, x: Floats, y: Floats, which: Counts) -> tuple[Floats, Floats]:
        """The same of elements that are arcs."""
        centre_x, centre_y, radius, first, sweep = self.arcs.take(which, axis=0).T
        to_x, to_y = x - centre_x, y - centre_y
        turn = (np.arctan2(to_y, to_x) - first) * np.sign(sweep)
        turn %= 2 * np.pi
        reach = np.abs(sweep)
        away = np.abs(np.sqrt(to_x * to_x + to_y * to_y) - radius)
        beyond = np.flatnonzero(turn > reach)  # nearest to one of the ends
        if len(beyond):
            ends = [
                np.hypot(x[beyond] - p[:, 0], y[beyond] - p[:, 1])
                for p in (self.start[which[beyond]], self.end[which[beyond]])
            ]
            away[beyond] = np.minimum(*ends)
            turn[beyond] = np.where(ends[1] < ends[0], reach[beyond], 0.0)
        return away, turn * radius


MAX_TURN_RAD = 0.5  #: of a piece of an arc whose cells are looked for
LARGER = 1.001  #: of a reach, for the last digits of elements that were moved
LEAST_REACH = 0.1  #: reach by the size of cells, below which a narrower one is no quicker
WIDE = 2.0  #: cells by the mean length of elements, unless they have many
MOST_IN_A_CELL = 8  #: else cells are made smaller once
MOST_CELLS = 1 << 20  #: along one side, so that the number of a cell and an element fits
MOST_PAIRS = 1 << 16  #: of points and elements that are measured at once, in a cache


#: Of points and elements that may be near one another, so that they fit into 500 MB; the planner
#: refuses a drawing of so many curves on one place.
MOST_NEAR = 1 << 24
#: The same before distances are measured: as many, or so many for each point.
MOST_MEASURED = 1 << 24
MOST_AT_A_POINT = 1024


class Pairs(Struct, frozen=True):
    """Points and elements that are near each other, by the number of the point."""

    point: Counts
    element: Counts
    away: Floats
    along: Floats  #: from the start of the element to the place nearest to the point

    def kept(self, which: Flags | Counts) -> "Pairs":
        """Some of them."""
        return Pairs(self.point[which], self.element[which], self.away[which], self.along[which])


class Grid:
    """The cells of a square grid that elements come within a reach of."""

    def __init__(self, elements: Elements, reach: float) -> None:
        self._elements = elements
        self._bent = bool(elements.is_arc.any())
        self._shift = 0.0, 0.0
        sides = (*elements.start.T, *elements.end.T) if len(elements) else ()
        wide = 2 * max((float(np.ptp(side)) for side in sides), default=0.0)
        mean = float(elements.length.sum()) / max(len(elements), 1)
        least = max(2.0 * LARGER * reach, wide / MOST_CELLS, 1e-6)
        self._fill(max(WIDE * mean, least), reach)
        # Long elements beside one another: a cell that one is in has many others.
        if np.square(self._sizes).sum() > MOST_IN_A_CELL * len(self._members):
            self._fill(max(mean / 4, least), reach)

    def _fill(self, size: float, reach: float) -> None:
        """Put the elements into the cells that they come near."""
        self.size, self.reach = size, max(LARGER * reach, LEAST_REACH * size)
        count = max(len(self._elements), 1)
        low, high, owner = _boxes(self._elements, self.size)
        x0, y0 = (np.floor((c - self.reach) / self.size).astype(np.int64) for c in low.T)
        x1, y1 = (np.floor((c + self.reach) / self.size).astype(np.int64) for c in high.T)
        self._origin = int(x0.min(initial=0)), int(y0.min(initial=0))
        self._rows = int(y1.max(initial=0)) - self._origin[1] + 1
        self._columns = int(x1.max(initial=0)) - self._origin[0] + 1
        x1 -= x0
        y1 -= y0
        x1 += 1
        y1 += 1
        first = self._key(x0, y0)
        # Most boxes lie in one cell; of the others every cell is listed.
        cells = x1 * y1
        wider = np.flatnonzero(cells > 1)
        box = np.repeat(wider, cells[wider])
        number = np.arange(len(box)) - np.repeat(
            np.cumsum(cells[wider]) - cells[wider], cells[wider]
        )
        across, up = np.divmod(number, y1[box])
        single = np.flatnonzero(cells == 1)
        key = np.concatenate((first[single], first[box] + across * self._rows + up))
        # Cell and element in one number, so that one sort orders both and shows what is double.
        both = np.sort(key * count + np.concatenate((owner[single], owner[box])))
        both = both[np.diff(both, prepend=-1) != 0]
        key = both // count
        self._members = both - key * count
        self._begins = np.flatnonzero(np.diff(key, prepend=-1))
        self._cells = key[self._begins]
        self._sizes = np.diff(self._begins, append=len(key))

    def moved(self, elements: Elements, shift: tuple[float, float]) -> "Grid":
        """The grid of the same elements elsewhere."""
        grid = copy(self)
        grid._elements = elements
        grid._shift = self._shift[0] + shift[0], self._shift[1] + shift[1]
        return grid

    def _key(self, x: Counts, y: Counts) -> Counts:
        return (x - self._origin[0]) * self._rows + (y - self._origin[1])

    def near(self, points: Floats, reach: float) -> Pairs:
        """All pairs of a point (n, 2) and an element no farther from it than `reach`.

        That is at most the reach of the grid. Raises VerifyError for more than `MOST_NEAR`.
        """
        parts: list[Pairs] = []
        count = 0
        for part in self.batches(points, reach):
            parts.append(part)
            count += len(part.point)
            _refuse_more(MOST_NEAR, count, points)
        columns = [[getattr(part, name) for part in parts] for name in Pairs.__struct_fields__]
        return parts[0] if len(parts) == 1 else Pairs(*map(np.concatenate, columns))

    def batches(self, points: Floats, reach: float) -> Iterator[Pairs]:
        """The same pairs, point by point in batches of about `MOST_PAIRS` that were measured.

        At least one batch comes. Raises VerifyError for more than `MOST_MEASURED` pairs if they
        are more than `MOST_AT_A_POINT` on an average.
        """
        x, y = (np.ascontiguousarray(c) for c in points.T)
        column, row = (
            np.floor((c - by) / self.size).astype(np.int64)
            for c, by in zip((x, y), self._shift, strict=True)
        )
        key = self._key(column, row)
        row -= self._origin[1]
        inside = (row >= 0) & (row < self._rows)
        at = np.searchsorted(self._cells, key)
        at[at == len(self._cells)] = 0
        known = inside & (self._cells[at] == key) if len(self._cells) else inside & False
        which = np.flatnonzero(known)
        at = at[which]
        total = np.cumsum(self._sizes[at])
        if not len(which):
            yield Pairs(which, which, x[:0], x[:0])
            return
        _refuse_more(max(MOST_MEASURED, MOST_AT_A_POINT * len(points)), int(total[-1]), points)
        begin = 0
        while begin < len(which):
            done = int(total[begin - 1]) if begin else 0
            end = max(begin + 1, int(np.searchsorted(total, done + MOST_PAIRS, "right")))
            yield self._measured(x, y, which[begin:end], at[begin:end], reach)
            begin = end

    def _measured(self, x: Floats, y: Floats, which: Counts, cell: Counts, reach: float) -> Pairs:
        """Points against all elements of a cell each."""
        sizes = self._sizes[cell]
        point = np.repeat(which, sizes)
        member = np.arange(len(point))
        member += np.repeat(self._begins[cell] - (np.cumsum(sizes) - sizes), sizes)
        element = self._members.take(member)
        elements = self._elements
        away, along = elements.from_chords(x.take(point), y.take(point), element)
        pairs = Pairs(point, element, away, along)
        if self._bent:
            # An arc is looked at only where its chord is no farther than it may lie beside that.
            pairs = pairs.kept(np.flatnonzero(away <= elements.rise.take(element) + reach))
            bent = np.flatnonzero(elements.is_arc.take(pairs.element))
            at = pairs.point[bent]
            pairs.away[bent], pairs.along[bent] = elements.from_arcs(
                x[at], y[at], pairs.element[bent]
            )
        return pairs.kept(np.flatnonzero(pairs.away <= reach))


def _refuse_more(most: int, count: int, points: Floats) -> None:
    if count > most:
        x, y = (f"{at:.0f}" for at in np.median(points, axis=0).tolist())
        raise VerifyError([rules.CROWDED.at(Source("program"), found=count, x=x, y=y)])


def _boxes(elements: Elements, size: float) -> tuple[Floats, Floats, Counts]:
    """Boxes around pieces of elements about as long as a cell: least and greatest corner, owner."""
    turns = np.abs(elements.arcs[:, 4]) / MAX_TURN_RAD
    count = np.ceil(np.maximum(elements.length / size, turns)).astype(np.int64)
    short, long = np.flatnonzero(count <= 1), np.flatnonzero(count > 1)
    count = count[long]
    owner = np.repeat(long, count + 1)
    number = np.arange(len(owner)) - np.repeat(np.cumsum(count + 1) - count - 1, count + 1)
    whole = np.repeat(count, count + 1)
    places = elements.places(owner, number / whole)
    start = np.concatenate((elements.start[short], places[number < whole]))
    end = np.concatenate((elements.end[short], places[number > 0]))
    owner = np.concatenate((short, np.repeat(long, count)))
    low, high = np.minimum(start, end), np.maximum(start, end)
    # An arc leaves the box around its ends by its sagitta at most.
    bent = np.flatnonzero(elements.is_arc[owner])
    pieces = np.concatenate((np.ones(len(short)), np.repeat(count, count)))[bent]
    arcs = elements.arcs[owner[bent]]
    rise = (arcs[:, 2] * (1 - np.cos(arcs[:, 4] / pieces / 2)))[:, None]
    low[bent] -= rise
    high[bent] += rise
    return low, high, owner
