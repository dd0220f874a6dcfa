"""The interpreter of RS274/NGC, for the controllers that descend from it: LinuxCNC and grbl.

    G1 X10 Y5 F600 (comment)      words in any order, spaces mean nothing
    G3 X0 Y0 I-5 J0               I and J from the start of the arc (G91.1)

A block's words act in a fixed order: feed, speed, M words, dwell, settings, motion, end. Motion is
modal. Written from the "G-Code Overview" of the LinuxCNC documentation and the grbl 1.1 wiki.
"""

import re
from collections.abc import Callable
from math import atan2, degrees, hypot, isnan, nan

from msgspec import Struct

from beamcam.errors import Diagnostic, Source
from beamcam.geometry.curves import Arc
from beamcam.geometry.plane import Point
from beamcam.verify.sheets import rules
from beamcam.verify.sheets.events import Event, Keep, Leg, Pause, Side, Switch

_NUMBER = r"[+-]?(?:\d+\.?\d*|\.\d+)"
_WORD = re.compile(rf"([A-Z])({_NUMBER})")
# What nearly every block of a program looks like; anything else takes the slower way.
_USUAL = re.compile(
    rf"G([0-3]) X({_NUMBER}) Y({_NUMBER})(?: I({_NUMBER}) J({_NUMBER}))?(?: F({_NUMBER}))?"
)
_COMMENT = re.compile(r"\([^()]*\)|;.*")

Fault = str | None


class Dialect(Struct, frozen=True):
    """What a controller of the family takes, and what it does with arcs."""

    name: str
    percent: bool  #: whether % stands alone on the first and the last line
    longest_line: int  #: characters
    settings: frozenset[str]  #: G words that need no more than to be there
    needed: tuple[str, ...]  #: those that a program has to say before it moves
    switches: dict[int, frozenset[str]]  #: M words and the letters that belong to them
    beside: dict[str, Side]  #: G words of cutter compensation
    arc_fault: Callable[[Point, Point, Point, bool], Fault]  #: start, end, centre, clockwise


def run(text: str, name: str, dialect: Dialect) -> tuple[list[Event], list[Diagnostic]]:
    """The events of a program, and what its controller would not do as it says."""
    reader = _Reader(name, dialect)
    lines = text.rstrip("\n").split("\n")
    for number, line in enumerate(lines, 1):
        reader.block(number, line, number in (1, len(lines)))
    reader.finish(len(lines), lines)
    return reader.events, reader.said


class _Reader:
    """The state of the controller between two blocks."""

    def __init__(self, name: str, dialect: Dialect) -> None:
        self.events: list[Event] = []
        self.said: list[Diagnostic] = []
        self._name = name
        self._dialect = dialect
        self._place: Point = (nan, nan)
        self._feed = 0.0
        self._motion = -1
        self._seen: set[str] = set()
        self._ready = False
        self._absolute = True
        self._ended = 0

    def _wrong(self, line: int, found: str, expected: str) -> None:
        self.said.append(rules.WORD.at(Source(self._name, line), found=found, expected=expected))

    def block(self, line: int, text: str, outermost: bool) -> None:
        """Carries out one block."""
        if len(text) > self._dialect.longest_line:
            self._syntax(line, text, f"at most {self._dialect.longest_line} characters")
        usual = _USUAL.fullmatch(text)
        if usual is not None and not self._ended:
            motion, x, y, i, j, f = usual.groups()
            if f is not None:
                self._feed = float(f)
            self._move(
                line, int(motion), float(x), float(y),
                None if i is None else float(i), None if j is None else float(j),
            )  # fmt: skip
            return
        bare = _COMMENT.sub(" ", text).upper().strip()
        if bare == "%":
            if not self._dialect.percent:
                self._syntax(line, text, f"no %, {self._dialect.name} does not know it")
            elif not outermost:
                self._syntax(line, text, "% alone on the first and the last line only")
            return
        if "(" in bare or ")" in bare:
            self._syntax(line, text, "a comment that begins and ends on its line")
            return
        squeezed = "".join(bare.split())
        words = _WORD.findall(squeezed)
        if "".join(letter + digits for letter, digits in words) != squeezed:
            self._syntax(line, text, "letters with a number each")
            return
        if words:
            self._words(line, [(letter, float(digits), digits) for letter, digits in words])

    def _syntax(self, line: int, found: str, expected: str) -> None:
        said = rules.SYNTAX.at(Source(self._name, line), found=found.strip(), expected=expected)
        self.said.append(said)

    def _words(self, line: int, words: list[tuple[str, float, str]]) -> None:
        if self._ended:
            self._wrong(line, "a block behind the end", "M2 or M30 as the last one")
            return
        values: dict[str, float] = {}
        codes: list[str] = []
        switches: list[int] = []
        for place, (letter, value, digits) in enumerate(words):
            if letter == "N":
                if place:
                    self._wrong(line, f"N{digits}", "it at the beginning of a block")
            elif letter == "G":
                codes.append(f"G{value:g}")
            elif letter == "M":
                switches.append(int(value))
                if value != int(value):
                    self._wrong(line, f"M{digits}", "a whole number")
            elif letter in values:
                self._wrong(line, f"{letter} twice in a block", "it once")
            else:
                values[letter] = value
        if "F" in values:
            self._feed = values.pop("F")
        end = [m for m in switches if m in (2, 30)]
        for number in switches:
            if number not in end:
                self._switch(line, number, values)
        self._settings(line, codes, values)
        motions = [int(c[1:]) for c in codes if c in ("G0", "G1", "G2", "G3")]
        if len(motions) > 1:
            self._wrong(line, "two motions in a block", "one")
        if motions or {"X", "Y"} & values.keys():
            motion = motions[-1] if motions else self._motion
            if motion < 0:
                self._wrong(line, "X or Y without a motion", "G0, G1, G2 or G3 before")
            elif "X" in values or "Y" in values:
                self._relative(line, motion, values)
            else:
                self._motion = motion
        if values:
            self._wrong(line, f"the letter {min(values)} in that block", "no such word there")
        if end:
            self._ended += 1
            self.events.append(Switch(line, end[0], ()))

    def _switch(self, line: int, number: int, values: dict[str, float]) -> None:
        letters = self._dialect.switches.get(number)
        if letters is None:
            self._wrong(line, f"M{number}", f"an M word that {self._dialect.name} knows")
            return
        own = tuple(sorted((k, values.pop(k)) for k in letters & values.keys()))
        self.events.append(Switch(line, number, own))

    def _settings(self, line: int, codes: list[str], values: dict[str, float]) -> None:
        for code in codes:
            if code in ("G0", "G1", "G2", "G3"):
                continue
            if code == "G4":
                if "P" in values:
                    self.events.append(Pause(line, values.pop("P")))
                else:
                    self._wrong(line, "G4", "P with seconds")
            elif code in self._dialect.beside:
                radius = values.pop("D", 0.0) / 2
                self.events.append(Keep(line, self._dialect.beside[code], radius))
            elif code == "G40":
                self.events.append(Keep(line, "on", 0.0))
            elif code == "G64" and code in self._dialect.settings:
                values.pop("P", None)
                values.pop("Q", None)
            elif code in ("G90", "G91"):
                self._absolute = code == "G90"
            elif code not in self._dialect.settings:
                self._wrong(line, code, f"a G word that {self._dialect.name} knows here")
            self._seen.add(code)

    def _relative(self, line: int, motion: int, values: dict[str, float]) -> None:
        """A move whose words are not all there, or count from the last place (G91)."""
        x0, y0 = self._place
        base = (0.0, 0.0) if self._absolute else (x0, y0)
        x = base[0] + values.pop("X") if "X" in values else x0
        y = base[1] + values.pop("Y") if "Y" in values else y0
        i = values.pop("I", None) if motion > 1 else None
        j = values.pop("J", None) if motion > 1 else None
        self._go(line, motion, (x, y), i, j)

    def _move(
        self, line: int, motion: int, x: float, y: float, i: float | None, j: float | None
    ) -> None:
        if not self._absolute:
            x, y = self._place[0] + x, self._place[1] + y
        if motion < 2 and i is not None:
            self._wrong(line, f"I and J behind G{motion}", "no such word there")
            return
        self._go(line, motion, (x, y), i, j)

    def _go(self, line: int, motion: int, end: Point, i: float | None, j: float | None) -> None:
        start = self._place
        self._place, self._motion = end, motion
        if not self._ready:
            missing = [code for code in self._dialect.needed if code not in self._seen]
            if missing:
                source = Source(self._name, line)
                self.said.append(rules.SETTING.at(source, found=", ".join(missing)))
            self._ready = True
        if isnan(end[0]) or isnan(end[1]):
            self._wrong(line, "a move that says only one of X and Y", "both, the first time")
            return
        if motion < 2:
            if motion == 1 and isnan(start[0]):
                self._wrong(line, "a feed from nowhere", "a traverse before it")
                return
            self.events.append(Leg(line, motion == 0, start, end, None, self._feed))
            return
        if isnan(start[0]) or (i is None and j is None):
            self._arc(line, "without I and J, or from nowhere")
            return
        centre = (start[0] + (i or 0.0), start[1] + (j or 0.0))
        clockwise = motion == 2
        fault = self._dialect.arc_fault(start, end, centre, clockwise)
        if fault is not None:
            self._arc(line, fault)
            return
        self.events.append(Leg(line, False, start, end, arc(start, end, centre, clockwise),
                               self._feed))  # fmt: skip

    def _arc(self, line: int, fault: str) -> None:
        source = Source(self._name, line)
        self.said.append(rules.ARC.at(source, found=fault, controller=self._dialect.name))

    def finish(self, last: int, lines: list[str]) -> None:
        """Says what a whole program has and this one has not."""
        if self._ended != 1:
            found = f"{self._ended} ends of program"
            self.said.append(rules.END.at(Source(self._name, last), found=found))
        if self._dialect.percent:
            marks = [lines[0].strip() == "%", lines[-1].strip() == "%"]
            if marks[0] != marks[1]:
                self._syntax(last, lines[-1], "% on both the first and the last line, or on none")


def arc(start: Point, end: Point, centre: Point, clockwise: bool) -> Arc:
    """The arc that a controller makes of its numbers; from a point to itself it is a circle."""
    first = degrees(atan2(start[1] - centre[1], start[0] - centre[0]))
    sweep = 360.0
    if start != end:
        last = degrees(atan2(end[1] - centre[1], end[0] - centre[0]))
        sweep = ((first - last) if clockwise else (last - first)) % 360.0 or 360.0
    radius = hypot(start[0] - centre[0], start[1] - centre[1])
    return Arc(centre, radius, first, -sweep if clockwise else sweep)
