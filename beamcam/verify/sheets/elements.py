"""Lines and arcs in arrays, the elements of every chain.

Arcs are kept as they are. Other curves are chains of arcs and chords.
"""

from functools import cached_property

import numpy as np
from msgspec import Struct

from beamcam.geometry.array_types import Counts, Flags, Floats

QUARTERS = ((1.0, 0.0), (0.0, 1.0), (-1.0, 0.0), (0.0, -1.0))


class Pieces(Struct, frozen=True):
    """What curves are drawn with: lines and arcs one after the other, curve by curve."""

    counts: Counts  #: of the pieces of each curve
    start: Floats  #: (n, 2)
    end: Floats
    is_arc: Flags
    arcs: Floats  #: as those of elements

    @property
    def columns(self) -> tuple[Floats, Floats, Flags, Floats]:
        """What there is of each piece."""
        return self.start, self.end, self.is_arc, self.arcs

    def some(self, which: Flags) -> "Pieces":
        """Some of the pieces of curves that have one each."""
        return Pieces(
            self.counts[which], self.start[which], self.end[which], self.is_arc[which],
            self.arcs[which],
        )  # fmt: skip


def straight_pieces(counts: Counts, start: Floats, end: Floats) -> Pieces:
    """Curves that are drawn with chords alone."""
    return Pieces(counts, start, end, np.zeros(len(start), dtype=bool), np.zeros((len(start), 5)))


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
        found = np.stack((start_x + along * way_x, start_y + along * way_y))
        bent = np.flatnonzero(self.is_arc.take(which))
        if len(bent):
            x, y, radius, first, sweep = self.arcs[which[bent]].T
            turn = first + sweep * share[bent]
            found[:, bent] = x + radius * np.cos(turn), y + radius * np.sin(turn)
        return found.T

    def directions(self, which: Counts, share: Floats) -> Floats:
        """The direction of travel at shares of elements, (n, 2)."""
        found = np.column_stack([column[which] for column in self.along])
        bent = np.flatnonzero(self.is_arc[which])
        arcs = self.arcs[which[bent]]
        turn = arcs[:, 3] + arcs[:, 4] * share[bent]
        sign = np.sign(arcs[:, 4])
        found[bent] = np.column_stack((-np.sin(turn) * sign, np.cos(turn) * sign))
        return found

    def distances(self, x: Floats, y: Floats, which: Counts) -> tuple[Floats, Floats]:
        """How far places are from an element each, and how far along it the nearest place lies."""
        away, along = self.from_chords(x, y, which)
        bent = np.flatnonzero(self.is_arc.take(which))
        if len(bent):
            away[bent], along[bent] = self.from_arcs(x[bent], y[bent], which[bent])
        return away, along

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
        centre_x, centre_y, radius, first, sweep = self.arcs[which].T
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
