"""The run of a table program, recorded while its blocks are executed.

Plain moves are carried out in runs, as rows of arrays; what stands between them one by one.
"""

import re
from collections.abc import Sequence
from itertools import starmap
from string import ascii_uppercase
from typing import cast

import numpy as np
from msgspec import Struct
from numpy.typing import NDArray

from beamcam.controllers.events import FeedShare, HeadMove, Other
from beamcam.controllers.interpreter import ArcFault, Interpreter
from beamcam.controllers.moves import Moves, TableRun, arcs_between, joined, moves_of, sure_arcs
from beamcam.errors import Diagnostic
from beamcam.geometry.array_types import Counts, Flags, Floats
from beamcam.geometry.plane import Point

# --- blocks that are plain moves, all at once; every other block is left to be read ---------------

#     G1 X10 Y-5.5                     a letter and a number each, one space between them
#     N12 G03 X0 Y0 I-5 J0 F600        block number, and feed behind, where they are said
#
# Such blocks say all that there is to their move but the feed that goes on, so that their numbers
# can be read as arrays. A block that differs in anything is not touched here.


LONGEST_NUMBER = 15  #: characters; how far a controller counts is a matter for its interpreter

_OTHER, _DIGIT, _DOT, _SIGN, _LETTER, _SPACE, _NEWLINE = range(7)
_KINDS = bytes(
    _DIGIT if c in "0123456789" else _DOT if c == "." else _SIGN if c in "+-"
    else _LETTER if c in ascii_uppercase else _SPACE if c == " " else _NEWLINE if c == "\n"
    else _OTHER
    for c in map(chr, range(256))
)  # fmt: skip
#: What may stand behind a character of each kind in a block of plain words.
_FOLLOWERS = {
    _LETTER: (_DIGIT, _DOT, _SIGN), _SIGN: (_DIGIT, _DOT), _DOT: (_DIGIT,),
    _DIGIT: (_DIGIT, _DOT, _SPACE, _NEWLINE), _SPACE: (_LETTER,), _NEWLINE: (_LETTER,),
}  # fmt: skip
#: Whether two kinds may follow one another, at 8 * first + second.
_PAIRS = bytes(k % 8 not in _FOLLOWERS.get(k // 8, ()) for k in range(256))
_TWO_DOTS = re.compile(rb"\.[0-9]*\.")


class PlainMoves(Struct, frozen=True):
    """The plain moves of a text, in its order; numbers that are not said are nan."""

    line: Counts  #: from 1
    motion: Counts  #: 0 to 3, as behind G
    end: Floats  #: X and Y, (n, 2)
    centre: Floats  #: I and J, (n, 2)
    feed: Floats  #: F


class _Words(Struct):
    """The words of all good lines, one after the other."""

    letter: NDArray[np.uint8]
    value: Floats
    whole: Flags  #: whether the number is digits and no more
    first: Counts  #: word of each line
    count: Counts  #: of the words of each line


def scan(
    text: str,
    longest: int | None = None,
    traverse_with_feed: bool = True,
    motions: Sequence[int] = range(4),
) -> tuple[PlainMoves, list[tuple[int, str]], int]:
    """The plain moves of a text, the other lines by their number from 1, and how many there are.

    Empty lines at its end do not count. The others are also lines longer than `longest`, moves
    whose motion is not in `motions`, and, where it is not allowed, a traverse with a feed; and the
    first plain move and the last line, so that the beginning and the end of a program are
    interpreted one by one.
    """
    text = text.rstrip("\n") + "\n"
    data = text.encode("ascii", "replace")
    kinds = data.translate(_KINDS)
    ends = np.flatnonzero(np.frombuffer(data, dtype=np.uint8) == ord("\n"))
    good = _good_lines(data, kinds, ends)
    if longest is not None:
        good &= np.diff(ends, prepend=-1) - 1 <= longest
    good[-1] = False
    plain, taken = _plain_moves(_words(data, kinds, ends, good), traverse_with_feed, motions)
    begins = np.concatenate(([0], ends[:-1] + 1))
    odd = np.flatnonzero(~taken)
    bounds = zip(*(a.tolist() for a in (odd + 1, begins[odd], ends[odd])), strict=True)
    return plain, [(k, text[a:b]) for k, a, b in bounds], len(ends)


def _good_lines(data: bytes, kinds: bytes, ends: Counts) -> Flags:
    """Which lines are letters with a number each and one space between them."""
    kind = np.frombuffer(kinds, dtype=np.uint8)
    pairs = np.left_shift(kind[:-1], 3)
    pairs |= kind[1:]
    wrong = np.flatnonzero(np.frombuffer(pairs.tobytes().translate(_PAIRS), dtype=np.bool_))
    if b"\2\2" in kinds.translate(None, bytes([_DIGIT])):
        twice = [match.start() for match in _TWO_DOTS.finditer(data)]
        wrong = np.concatenate((wrong, np.array(twice, dtype=np.int64)))
    good = np.ones(len(ends), dtype=bool)
    good[0] = kind[0] == _LETTER
    # What may not stand behind the end of a line is the fault of the next one.
    good[np.searchsorted(ends, wrong + (kind[wrong] == _NEWLINE))] = False
    letters = np.flatnonzero(kind == _LETTER)
    long = letters[np.diff(letters, append=len(kind)) > LONGEST_NUMBER + 2]
    good[np.searchsorted(ends, long)] = False
    return good


def _words(data: bytes, kinds: bytes, ends: Counts, good: Flags) -> _Words:
    characters = np.frombuffer(data, dtype=np.uint8)
    kind = np.frombuffer(kinds, dtype=np.uint8)
    sizes = np.diff(ends, prepend=-1)
    is_letter = kind == _LETTER
    numbers = np.where(np.repeat(good, sizes) & ~is_letter, characters, ord(" "))
    letters = np.flatnonzero(is_letter)
    count = np.diff(np.searchsorted(letters, ends), prepend=0)
    letters = letters[np.repeat(good, count)]
    count[~good] = 0
    value = np.fromstring(numbers.tobytes().decode("ascii"), sep=" ")
    # A number without sign and dot: as many digits as there is room up to the next word.
    marks = np.flatnonzero((kind == _DOT) | (kind == _SIGN))
    whole = np.ones(len(letters), dtype=bool)
    owner = np.searchsorted(letters, marks) - 1
    whole[owner[owner >= 0]] = False
    return _Words(characters.take(letters), value, whole, np.cumsum(count) - count, count)


def _plain_moves(
    words: _Words, traverse_with_feed: bool, motions: Sequence[int]
) -> tuple[PlainMoves, Flags]:
    """The plain moves among the good lines but for the first, and which lines they are."""
    letter = np.concatenate((words.letter, np.zeros(8, dtype=np.uint8)))
    line = np.flatnonzero(words.count >= 3)
    at, rest = words.first[line], words.count[line]

    def has(name: str, at: Counts, rest: Counts) -> Flags:
        """Which lines, with so many words left, have a letter at a word."""
        plain_moves: Flags = (letter.take(at) == ord(name)) & (rest > 0)
        return plain_moves

    numbered = has("N", at, rest)
    right = ~numbered | words.whole.take(at)
    at, rest = at + numbered, rest - numbered
    right &= has("G", at, rest) & has("X", at + 1, rest - 1) & has("Y", at + 2, rest - 2)
    motion = words.value.take(at)
    right &= words.whole.take(at) & np.any([motion == known for known in motions], axis=0)
    centred = has("I", at + 3, rest - 3) & has("J", at + 4, rest - 4)
    right &= centred == (motion >= 2)
    behind = at + 3 + 2 * centred
    fed = has("F", behind, at + rest - behind)
    right &= at + rest == behind + fed
    if not traverse_with_feed:
        right &= ~fed | (motion > 0)
    right &= np.cumsum(right) > 1
    line, at, motion = line[right], at[right], motion[right]
    centred, behind, fed = centred[right], behind[right], fed[right]
    taken = np.zeros(len(words.count), dtype=bool)
    taken[line] = True
    end = np.column_stack((words.value.take(at + 1), words.value.take(at + 2)))
    centre = np.full((len(line), 2), np.nan)
    centre[centred, 0] = words.value.take(at[centred] + 3)
    centre[centred, 1] = words.value.take(at[centred] + 4)
    feed = np.full(len(line), np.nan)
    feed[fed] = words.value.take(behind[fed])
    return PlainMoves(line + 1, motion.astype(np.int64), end, centre, feed), taken


def table_run(text: str, interpreter: Interpreter) -> tuple[TableRun, list[Diagnostic]]:
    """The events of a program for a table, its moves as arrays, and the faults of its blocks."""
    plain, odd, count = scan(
        text, interpreter.longest_line, interpreter.fed_traverse, interpreter.plain_motions
    )
    track = Track(plain, interpreter.per_minute)
    interpreter.follow(track)
    interpreter.begin(count)
    for number, line in odd:
        interpreter.plain_until(number)
        interpreter.lines(interpreter.lines_of(line), number)
    interpreter.finish()
    done, faults = track.finish(interpreter.arc_slack, interpreter.arc_fault)
    for number, fault in faults:
        interpreter.wrong_arc(number, fault)
    return done, sorted(interpreter.diagnostics, key=lambda one: one.source.line or 0)


class Track:
    """The moves and events so far."""

    def __init__(self, plain: PlainMoves, per_minute: float) -> None:
        self.plain = plain
        self._per_minute = per_minute  #: makes mm/min of an F word
        self._runs: list[tuple[int, int]] = []  #: first row of each, and the one behind its last
        self._starts: list[Point] = []  #: where each run begins
        self._feeds: list[float] = []  #: that each begins with
        self._shares: list[float] = []  #: of the feed, in each
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
            feeds = np.where(own, plain.feed[self._fed[rows]], np.repeat(self._feeds, sizes))
            feed[rows] = feeds * np.repeat(self._shares, sizes) * self._per_minute
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
    faults = []
    for k in np.flatnonzero(~sure_arcs(start, end, centre, difference)).tolist():
        clockwise = bool(moves.arcs[rows[k], 4] < 0.0)
        fault = arc_fault(_point(start[k]), _point(end[k]), _point(centre[k]), clockwise)
        if fault is not None:
            faults.append((int(rows[k]), fault))
    return faults


def _point(row: Floats) -> Point:
    return cast("Point", tuple(row.tolist()))
