"""The moves of a head in arrays, whatever they are read from."""

from collections.abc import Iterator, Mapping, Sequence
from typing import Any

import numpy as np
from msgspec import Struct, field

from beamcam.controllers.events import Curve, HeadMove, Move, Other, TableEvent
from beamcam.geometry.array_types import Counts, Flags, Floats
from beamcam.geometry.curves import Arc, Bezier, EllipseArc

#: Share of what is allowed to an arc that no controller looks at twice.
SURE_SHARE = 0.9
SURE_SWEEP_RAD = 1e-3


class Moves(Struct, frozen=True):
    """Moves one after the other; a row of `arcs` is 0 where the move is not an arc."""

    line: Counts
    rapid: Flags
    start: Floats  #: (n, 2)
    end: Floats  #: (n, 2)
    feed_mm_min: Floats
    is_arc: Flags
    arcs: Floats  #: centre x, y, radius, start and sweep in degrees, (n, 5)
    curves: Mapping[int, Bezier | EllipseArc] = field(default_factory=dict)  #: by their number

    def __len__(self) -> int:
        return len(self.line)

    def take(self, rows: Counts) -> "Moves":
        """The moves of some numbers, each at most once."""
        place = {row: k for k, row in enumerate(rows.tolist())} if self.curves else {}
        curves = {place[k]: curve for k, curve in self.curves.items() if k in place}
        line, rapid, start, end, feed, is_arc, arcs = (column[rows] for column in self.columns)
        return Moves(line, rapid, start, end, feed, is_arc, arcs, curves)

    @property
    def columns(self) -> tuple[Any, ...]:
        """All arrays, in the order of their fields."""
        return (self.line, self.rapid, self.start, self.end, self.feed_mm_min, self.is_arc,
                self.arcs)  # fmt: skip

    def each(self) -> Iterator[HeadMove]:
        """The moves one by one."""
        rows = zip(*(column.tolist() for column in self.columns), strict=True)
        for k, (line, rapid, start, end, feed, is_arc, arc) in enumerate(rows):
            curve: Curve | None = self.curves.get(k)
            if is_arc:
                curve = Arc((arc[0], arc[1]), *arc[2:])
            yield Move(line, rapid, tuple(start), tuple(end), feed, False, curve)


class TableRun(Struct, frozen=True):
    """A program's moves, and the other events between them."""

    moves: Moves
    others: list[tuple[int, Other]]  #: each with the number of moves before it

    def events(self) -> list[TableEvent]:
        """All events in order."""
        events: list[TableEvent] = []
        moves = list(self.moves.each())
        done = 0
        for before, event in self.others:
            events += moves[done:before]
            events.append(event)
            done = before
        return events + moves[done:]


def moves_of(moves: Sequence[HeadMove]) -> Moves:
    """Moves given one by one, as arrays."""
    is_arc = np.array([isinstance(move.curve, Arc) for move in moves], dtype=bool)
    arcs = np.zeros((len(moves), 5))
    curves: dict[int, Bezier | EllipseArc] = {}
    for k, move in enumerate(moves):
        if isinstance(move.curve, Arc):
            c = move.curve
            arcs[k] = (*c.centre, c.radius, c.start_deg, c.sweep_deg)
        elif move.curve is not None:
            curves[k] = move.curve
    return Moves(
        np.array([move.line for move in moves], dtype=np.int64),
        np.array([move.rapid for move in moves], dtype=bool),
        np.array([move.start for move in moves], dtype=np.float64).reshape(-1, 2),
        np.array([move.end for move in moves], dtype=np.float64).reshape(-1, 2),
        np.array([move.feed_mm_min for move in moves], dtype=np.float64), is_arc, arcs, curves,
    )  # fmt: skip


def straight_moves(chains: Sequence[tuple[int, Floats, Floats]]) -> Moves:
    """Straight moves of no feed: of each chain its line, and where its moves start and end."""
    sizes = [len(start) for _, start, _ in chains]
    count = sum(sizes)
    nowhere = np.zeros((0, 2))
    flags = np.zeros(count, dtype=bool)
    return Moves(
        np.repeat(np.array([line for line, _, _ in chains], dtype=np.int64), sizes), flags,
        np.concatenate([nowhere, *(start for _, start, _ in chains)]),
        np.concatenate([nowhere, *(end for _, _, end in chains)]), np.zeros(count), flags,
        np.zeros((count, 5)),
    )  # fmt: skip


def joined(first: Moves, second: Moves, order: Counts) -> Moves:
    """The moves of both, in an order of their numbers; the second's count on from the first's."""
    if not len(second):
        return first if len(order) == len(first) else first.take(order)
    pairs = zip(first.columns, second.columns, strict=True)
    line, rapid, start, end, feed, is_arc, arcs = map(np.concatenate, pairs)
    curves = {len(first) + k: curve for k, curve in second.curves.items()}
    return Moves(line, rapid, start, end, feed, is_arc, arcs, curves).take(order)


def arcs_between(start: Floats, end: Floats, centre: Floats, clockwise: Flags) -> Floats:
    """The rows of arcs that a controller makes of its numbers, (n, 5).

    From a point to itself it is a whole circle.
    """
    u, v = start - centre, end - centre
    first = np.degrees(np.arctan2(u[:, 1], u[:, 0]))
    last = np.degrees(np.arctan2(v[:, 1], v[:, 0]))
    turn = np.where(clockwise, first - last, last - first) % 360.0
    turn[(turn == 0.0) | np.all(start == end, axis=1)] = 360.0
    sweep = np.where(clockwise, -turn, turn)
    return np.column_stack((centre, np.hypot(u[:, 0], u[:, 1]), first, sweep))


def sure_arcs(start: Floats, end: Floats, centre: Floats, difference: float) -> Flags:
    """Arcs so far inside of what their controller takes that its rules need not be asked.

    `difference` of the radii is what it allows at least. Besides, the radius is not tiny, the
    sweep neither tiny nor all but a circle, and the centre near the bisector of the chord.
    """
    near = np.hypot(*(start - centre).T)
    far = np.hypot(*(end - centre).T)
    chord = np.hypot(*(end - start).T)
    off = np.abs(near - far)
    sure: Flags = off <= SURE_SHARE * difference
    sure &= near >= 10 * difference
    sure &= chord >= SURE_SWEEP_RAD * near
    # The centre lies |near^2 - far^2| / (2 chord) beside the bisector; a tenth of the radius is
    # what CODESYS takes.
    sure &= off * (near + far) <= SURE_SHARE * 0.2 * near * chord
    return sure
