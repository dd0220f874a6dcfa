"""Modal interpretation common to all G-code controllers.

    line -> block (each family's lexer) -> modal state -> events, into a record

A cell's program is short and is read block by block. Of a table's, plain moves wait until a block
that is not an M word, or the end, and are then carried out together.
"""

from abc import ABC, abstractmethod
from bisect import bisect_left
from collections.abc import Callable, Sequence
from math import atan2, degrees, dist, inf, isnan, nan
from typing import Any, Protocol

from msgspec.structs import replace

from beamcam.controllers.dialect import DOCUMENTED, Dialect
from beamcam.controllers.events import Curve, Heights, Lettering, Move, Other, Pause, Place
from beamcam.errors import Diagnostic, Rule, Source
from beamcam.geometry.curves import Arc
from beamcam.geometry.plane import Point
from beamcam.machine.machine import shown_code
from beamcam.model.cycles import (
    DRILL,
    DRILL_AND_DWELL,
    PECKING,
    clear_place,
    cycle_moves,
    peck_fault,
)

Words = dict[str, float]
#: Start, end, centre, clockwise: what is wrong with an arc, None if nothing is.
ArcFault = Callable[[Point, Point, Point, bool], str | None]


class TableRecorder(Protocol):
    """Collects the events of a table, and holds its plain moves."""

    def event(self, event: Other, /) -> None:
        """Anything but a move."""

    def move(self, move: Move[Any], /) -> None:
        """A move by itself."""

    def lines(self) -> list[int]:
        """Of the plain moves, ascending."""

    def motion(self, row: int) -> int:
        """The motion of a plain move."""

    def words(self, row: int) -> Words:
        """The words of a plain move."""

    def run(self, first: int, last: int, start: Point, feed: float) -> tuple[Point, float]:
        """Carries out plain moves from a place, with its feed; place and feed behind them."""


class Interpreter(ABC):
    """The state of a controller between two blocks; each family says what a block means."""

    controller: str  #: its name, for messages
    longest_line: int | None = None  #: characters
    fed_traverse: bool  #: whether a table's traverse may say a feed
    arc_slack: float  #: what the radii at both ends of an arc may always differ by
    arc_fault: ArcFault  #: the controller's deviation from an arc

    def __init__(self, dialect: Dialect, name: str) -> None:
        self.diagnostics: list[Diagnostic] = []
        self.per_minute = dialect.per_minute
        self._dialect, self._rules = dialect, dialect.rules
        self._name = name
        self._event: Callable[[Other], None]
        self._add: Callable[[Move[Any]], None]
        self._plain: TableRecorder | None = None  #: of plain moves that are carried out together
        self._lines: list[float] = [inf]  #: of plain moves
        self._next = 0  #: plain move
        self._place: Place = (nan, nan, nan)  #: of a table Z stays nan
        self._a_deg = self._b_deg = nan  #: of a machine that has A, and B
        self._inverse = False  #: whether F is the inverse of a move's time (G93)
        self._feed = 0.0  #: in the unit of F words
        self._flat = len(dialect.axes) == 2  #: a table, whose head moves in X and Y
        self._turns = len(dialect.axes) > 3  #: a torch round a profile, which has A, or A and B
        self._share = 1.0  #: of the feed, at which a table's head moves
        self._heights = Heights(dialect.lifting) if dialect.lifting is not None else None
        self._motion = -1
        self._absolute = True
        self._drilling = DRILL  #: the canned cycle that was called last
        self._cycle: Words | None = None  #: of a canned cycle that holds
        self._before_cycle = nan  #: Z where it began
        self._back_to_near = False  #: whether it draws back to R only (G99)
        self._row = 0  #: blocks since the last move that a controller limits, such as M words
        self._over = False
        self._last = 0  #: line of the text

    @property
    def plain_motions(self) -> tuple[int, ...]:
        """The numbers of the G words of plain moves that the machine's controller takes.

        In laser mode each move may switch the tool, so that none is plain.
        """
        if self._dialect.laser_mode:
            return ()
        return tuple(n for n in range(4) if self._dialect.is_allowed(f"G{n}"))

    def lines_of(self, text: str) -> list[str]:
        """The lines of a text."""
        return text.split("\n")

    def begin(self, lines: int) -> None:
        """The beginning of a text of so many lines."""
        self._last = lines

    @abstractmethod
    def knows(self, code: str) -> bool:
        """Whether a G word, `G1`, has a meaning on this controller or in the machine's file."""

    @abstractmethod
    def vocabulary(self) -> dict[str, frozenset[str]]:
        """All words that it gives a meaning, each with what it may carry, by letters.

        M words of the machine's own stand there by their roles (`saw`) and what they carry by the
        placeholders of the machine file (`{angle}`), words of `[codes]` by their meaning.
        """

    def _words_of_the_file(self) -> dict[str, frozenset[str]]:
        """Those that the machine's file gives a meaning, and those of all controllers."""
        words: dict[str, frozenset[str]] = {}
        for number, word in self._dialect.m_words.items():
            name = f"M{number}" if number in DOCUMENTED else word.role
            fields = frozenset(f"{{{field}}}" for _, field in word.fields)
            words[name] = words.get(name, frozenset()) | fields
        if self._dialect.text_word is not None:
            groups = self._dialect.text_word.pattern.groupindex
            words["text"] = frozenset(f"{{{field}}}" for field in groups)
        words |= {f"codes: {meaning}": frozenset() for meaning in self._dialect.codes.values()}
        return words

    @abstractmethod
    def lines(self, texts: Sequence[str], first: int = 1) -> None:
        """Carries out lines that follow each other, as `lines_of` gives them, by their number."""

    @abstractmethod
    def _carry_out(self, line: int, motion: int, words: Words) -> None:
        """Carries out a block that is a motion and its words."""

    def _is_text(self, line: int, body: str) -> bool:
        """Whether a line without its number tells a stamp or printer a text; carries it out."""
        word = self._dialect.text_word
        match = word.pattern.fullmatch(body.strip()) if word is not None else None
        if word is None or match is None:
            return False
        for code in word.codes:
            if not self._dialect.is_allowed(code):
                self._wrong(line, shown_code(code), self._dialect.shown_allowed())
        if not self.is_over(line):
            groups = match.groupdict()
            text = groups.pop("string")
            values = {name: float(value) for name, value in groups.items()}
            self._event(Lettering(line, word.kind, text, values))
        return True

    def _drill(self, line: int, cycle: int, words: Words, own_feed: bool) -> None:
        """Carries out a canned cycle of drilling, whose words hold until it ends."""
        x, y, z = self._place
        if self._cycle is None:
            self._before_cycle = z
        self._cycle = values = {**(self._cycle or {}), **words}
        missing = [letter for letter in "ZR" if letter not in values]
        if missing or not self._absolute or self._flat:
            expected = "absolute places (G90) of a cell, and Z and R"
            self._wrong(line, "a drilling cycle that is not whole", expected)
            return
        bottom, near = values["Z"], values["R"]
        if cycle in PECKING:
            wrong = peck_fault(values.get("Q"), near, bottom)
            if wrong is not None:
                self._wrong(line, f"a drilling cycle with Q {values.get('Q', 0.0):g}", wrong)
                return
        clear = clear_place(self._before_cycle, near, bottom, self._back_to_near)
        place = values.get("X", x), values.get("Y", y)
        peck = values.get("Q", 0.0)
        for rapid, end in cycle_moves(
            self._place, place, bottom, near, clear, self._before_cycle, cycle, peck
        ):
            self._go(line, 0 if rapid else 1, dict(zip("XYZ", end, strict=True)), own_feed)
            if not rapid and cycle == DRILL_AND_DWELL:
                self._event(Pause(line, values.get("P", 0.0)))

    @abstractmethod
    def curve(self, motion: int, start: Point, end: Point, words: Words) -> Curve | str:
        """The curve of a block, or what is wrong with it."""

    def record(self, event: Callable[[Other], None], move: Callable[[Move[Any]], None]) -> None:
        """Hands moves and all other events on from here on."""
        self._event, self._add = event, move

    def follow(self, plain: TableRecorder) -> None:
        """Sends the events to where plain moves wait, which are carried out in their turn."""
        self.record(plain.event, plain.move)
        self._plain = plain
        self._lines = [*plain.lines(), inf]

    def plain_until(self, line: float) -> None:
        """Carries out the plain moves before a line."""
        lines, first, plain = self._lines, self._next, self._plain
        if plain is None or lines[first] >= line:
            return
        while lines[first] < line and not self._is_simple():
            if not self.is_over(int(lines[first])):
                self._carry_out(int(lines[first]), plain.motion(first), plain.words(first))
            first += 1
        last = bisect_left(lines, line, first) if lines[first] < line else first
        self._next = last
        if first < last:
            x, y, z = self._place
            (x, y), self._feed = plain.run(first, last, (x, y), self._feed)
            self._place = x, y, z
            self._motion = plain.motion(last - 1)
            self._row = 0

    def _is_simple(self) -> bool:
        """Whether moves are to where they say, and from somewhere."""
        return self._absolute and not self._over and not isnan(self._place[0] + self._place[1])

    def is_over(self, line: int) -> bool:
        """Whether the program ended before a block; says so once, and nothing of it counts."""
        if self._over:
            found = "a block behind the end of the program"
            if not any(diagnostic.code == self._rules.end.code for diagnostic in self.diagnostics):
                self._say(line, self._rules.end, found=found)
        return self._over

    def finish(self) -> None:
        """The end of the text."""
        self.plain_until(inf)
        if not self._over:
            self._say(max(self._last, 1), self._rules.end, found="the end of the program")

    def _say(self, line: int, rule: Rule, **values: object) -> None:
        self.diagnostics.append(rule.at(Source(self._name, line), **values))

    def _wrong(self, line: int, found: str, expected: str) -> None:
        self._say(line, self._rules.word, found=found, expected=expected)

    def wrong_arc(self, line: int, found: str) -> None:
        """Says what the controller would make of an arc."""
        self._say(line, self._rules.arc, found=found, controller=self.controller)

    def _go(self, line: int, motion: int, words: Words, own_feed: bool) -> None:
        start = x, y, z = self._place
        if self._absolute:
            get = words.get
            end = get("X", x), get("Y", y), get("Z", z)
        else:
            end = x + words.get("X", 0.0), y + words.get("Y", 0.0), z + words.get("Z", 0.0)
        self._place = end
        if start != end:
            self._row = 0
        if (self._flat or not self._absolute) and self._is_lost(line, motion, start, end, words):
            return
        curve: Curve | None = None
        if motion > 1:
            is_known = not isnan(start[0] + start[1] + end[0] + end[1])
            made: Curve | str = "that starts nowhere"
            made = self.curve(motion, start[:2], end[:2], words) if is_known else made
            if isinstance(made, str):
                self.wrong_arc(line, made)
                return
            curve = made
        feed = self._feed * self.per_minute
        if self._flat:
            feed *= self._share
            self._add(Move(line, motion == 0, start[:2], end[:2], feed, own_feed, curve))
        elif self._turns:
            self._turn(Move(line, motion == 0, start, end, feed, own_feed, curve), words)
        else:
            self._add(Move(line, motion == 0, start, end, feed, own_feed, curve))

    def _turn(self, move: Move[Place], words: Words) -> None:
        """Hands on a move of a torch, with its A and B and the time that it may be given in."""
        a_before, b_before = self._a_deg, self._b_deg
        if "A" in words:
            self._a_deg = words["A"] + (0.0 if self._absolute else a_before)
        if "B" in words:
            self._b_deg = words["B"] + (0.0 if self._absolute else b_before)
        a_deg, b_deg, minutes = (a_before, self._a_deg), (b_before, self._b_deg), 0.0
        feed = move.feed_mm_min
        if self._inverse and not move.rapid:
            if not move.own_feed or not self._feed > 0.0:
                expected = "one in each block of inverse time (G93)"
                self._wrong(move.line, "no F in that block", expected)
                return
            feed, minutes = 0.0, 1.0 / self._feed
        self._add(replace(move, feed_mm_min=feed, minutes=minutes, a_deg=a_deg, b_deg=b_deg))

    def _is_lost(self, line: int, motion: int, start: Place, end: Place, words: Words) -> bool:
        """Whether a move leads from or to nowhere; says so.

        The axes of a cell move one by one, the head of a table in both.
        """
        if self._flat:
            if not isnan(end[0] + end[1]) and (motion == 0 or not isnan(start[0] + start[1])):
                return False
            self._wrong(line, "a move from or to nowhere", "X and Y of a traverse before")
            return True
        if not self._absolute and any(
            letter in words and isnan(at)
            for letter, at in zip("XYZAB", (*end, self._a_deg, self._b_deg), strict=True)
        ):
            self._wrong(line, "a relative move from nowhere", "an absolute place (G90) before")
        return False


# --- arcs that controllers make of start, end and centre ------------------------------------------


def sweep_of(start: Point, end: Point, centre: Point, clockwise: bool) -> float:
    """The angle that an arc turns through, negative if clockwise; 360 where start is end."""
    if start == end:
        return -360.0 if clockwise else 360.0
    (x0, y0), (x1, y1), (cx, cy) = start, end, centre
    turn = degrees(atan2(y1 - cy, x1 - cx) - atan2(y0 - cy, x0 - cx)) % 360.0
    return turn - 360.0 if clockwise else turn or 360.0


def arc_of(start: Point, end: Point, centre: Point, clockwise: bool) -> Arc:
    """The arc that a controller makes of its numbers; from a point to itself it is a circle."""
    x, y = start[0] - centre[0], start[1] - centre[1]
    sweep = sweep_of(start, end, centre, clockwise)
    return Arc(centre, dist(start, centre), degrees(atan2(y, x)), sweep)
