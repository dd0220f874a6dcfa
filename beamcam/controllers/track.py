"""The run of a table program, recorded while its blocks are executed.

Plain moves are carried out in runs, as rows of arrays; what stands between them one by one.
"""

from collections.abc import Callable
from itertools import starmap
from typing import cast

import numpy as np

from beamcam.controllers.events import FeedShare, HeadMove, Other
from beamcam.controllers.interpreter import Interpreter
from beamcam.controllers.moves import Moves, TableRun, arcs_between, joined, moves_of, sure_arcs
from beamcam.controllers.scan import PlainMoves, scan
from beamcam.errors import Diagnostic
from beamcam.geometry.array_types import Counts, Floats
from beamcam.geometry.plane import Point

#: Start, end, centre, clockwise: what is wrong with an arc, None if nothing is.
ArcFault = Callable[[Point, Point, Point, bool], str | None]


def table_run(text: str, interpreter: Interpreter) -> tuple[TableRun, list[Diagnostic]]:
    """The events of a program for a table, its moves as arrays, and the faults of its blocks."""
    found = scan(
        text, interpreter.longest_line, interpreter.fed_traverse, interpreter.plain_motions
    )
    track = Track(found.plain, interpreter.per_minute)
    interpreter.follow(track)
    interpreter.begin(found.lines)
    for number, line in found.odd:
        interpreter.plain_until(number)
        interpreter.line(number, *interpreter.lines_of(line))
    interpreter.finish()
    done, faults = track.finish(interpreter.arc_slack, interpreter.arc_fault)
    for number, fault in faults:
        interpreter.wrong_arc(number, fault)
    return done, sorted(interpreter.said, key=lambda said: said.source.line or 0)


class Track:
    """The moves and events so far."""

    def __init__(self, plain: PlainMoves, per_minute: float) -> None:
        self.plain = plain
        self._per_minute = per_minute  #: makes mm/min of an F word
        self._runs: list[tuple[int, int]] = []  #: first row of each, and the one behind its last
        self._starts: list[Point] = []  #: where each run begins
        self._feeds: list[float] = []  #: that each begins with
        self._shares: list[float] = []  #: of the feed that is said, in each
        self._share = 1.0
        self._moves: list[HeadMove] = []
        self._order: list[tuple[int, int]] = []  #: runs as above, moves behind all plain rows
        self._others: list[tuple[int, Other]] = []
        self._count = 0
        #: The row behind the last run, and place and feed there, if nothing moved since.
        self._behind: tuple[int, Point, float] | None = None
        rows = np.arange(len(plain.feed))
        #: The last row up to each that says a feed; -1 before the first.
        self._fed: Counts = np.maximum.accumulate(np.where(np.isnan(plain.feed), -1, rows))

    def lines(self) -> list[int]:
        """Of the plain moves, ascending."""
        lines: list[int] = self.plain.line.tolist()
        return lines

    def motion(self, row: int) -> int:
        """The motion of a plain move."""
        return int(self.plain.motion[row])

    def words(self, row: int) -> dict[str, float]:
        """The words of a plain move."""
        plain = self.plain
        numbers = (*plain.end[row].tolist(), *plain.centre[row].tolist(), float(plain.feed[row]))
        return {k: v for k, v in zip("XYIJF", numbers, strict=True) if v == v}

    def event(self, event: Other) -> None:
        """Anything but a move."""
        self._others.append((self._count, event))
        if isinstance(event, FeedShare):
            self._share = event.share
            self._behind = None  # the next moves are a run of their own

    def move(self, move: HeadMove) -> None:
        """A move by itself."""
        number = len(self.plain.line) + len(self._moves)
        self._moves.append(move)
        self._behind = None
        self._order.append((number, number + 1))
        self._count += 1

    def run(self, first: int, last: int, start: Point, feed: float) -> tuple[Point, float]:
        """Plain moves from a place, with the feed that holds there; place and feed behind them.

        Feeds are in the unit of the program's F words.
        """
        if self._behind == (first, start, feed):
            self._runs[-1] = self._order[-1] = self._runs[-1][0], last
        else:
            self._runs.append((first, last))
            self._order.append((first, last))
            self._starts.append(start)
            self._feeds.append(feed)
            self._shares.append(self._share)
        self._count += last - first
        x, y = self.plain.end[last - 1].tolist()
        fed = int(self._fed[last - 1])
        if fed >= first:
            feed = float(self.plain.feed[fed])
        self._behind = last, (x, y), feed
        return (x, y), feed

    def finish(
        self, difference: float, arc_fault: ArcFault
    ) -> tuple[TableRun, list[tuple[int, str]]]:
        """All of it, and by their lines the arcs that are not valid, which are left out.

        `difference` is what the radii at the ends of an arc may always differ by.
        """
        moves = self._plain_moves()
        faults = _arc_faults(moves, self._rows(), difference, arc_fault)
        order = np.concatenate([np.zeros(0, dtype=np.int64), *starmap(np.arange, self._order)])
        others = self._others
        if faults:
            wrong = np.isin(order, [row for row, _ in faults])
            lost = np.concatenate(([0], np.cumsum(wrong)))
            others = [(before - int(lost[before]), event) for before, event in others]
            order = order[~wrong]
        lines = [(int(moves.line[row]), fault) for row, fault in faults]
        return TableRun(joined(moves, moves_of(self._moves), order), others), lines

    def _rows(self) -> Counts:
        """The plain rows that were carried out."""
        return np.concatenate([np.zeros(0, dtype=np.int64), *starmap(np.arange, self._runs)])

    def _plain_moves(self) -> Moves:
        """All plain moves; those that were not carried out say nothing."""
        plain = self.plain
        start = np.roll(plain.end, 1, axis=0)
        feed = np.zeros(len(plain.line))
        if self._runs:
            firsts = np.array([first for first, _ in self._runs])
            sizes = np.array([last - first for first, last in self._runs])
            start[firsts] = self._starts
            rows = self._rows()
            own = self._fed[rows] >= np.repeat(firsts, sizes)
            said = np.where(own, plain.feed[self._fed[rows]], np.repeat(self._feeds, sizes))
            feed[rows] = said * np.repeat(self._shares, sizes) * self._per_minute
        is_arc = plain.motion >= 2
        arcs = np.zeros((len(plain.line), 5))
        centre = start[is_arc] + plain.centre[is_arc]
        clockwise = plain.motion[is_arc] == 2
        arcs[is_arc] = arcs_between(start[is_arc], plain.end[is_arc], centre, clockwise)
        return Moves(plain.line, plain.motion == 0, start, plain.end, feed, is_arc, arcs)


def _arc_faults(
    moves: Moves, rows: Counts, difference: float, arc_fault: ArcFault
) -> list[tuple[int, str]]:
    """Which of some rows are arcs that the controller would not take, and why."""
    rows = rows[moves.is_arc[rows]]
    start, end, centre = moves.start[rows], moves.end[rows], moves.arcs[rows, :2]
    found = []
    for k in np.flatnonzero(~sure_arcs(start, end, centre, difference)).tolist():
        clockwise = bool(moves.arcs[rows[k], 4] < 0.0)
        fault = arc_fault(_point(start[k]), _point(end[k]), _point(centre[k]), clockwise)
        if fault is not None:
            found.append((int(rows[k]), fault))
    return found


def _point(row: Floats) -> Point:
    return cast("Point", tuple(row.tolist()))
