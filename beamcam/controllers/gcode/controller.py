"""What all controllers of cutting tables have in common while a program is read back.

Plain moves wait until a block that is none, or the end, and are then carried out together.
"""

from abc import ABC, abstractmethod
from bisect import bisect_left
from math import isnan, nan

from beamcam.controllers.gcode import rules
from beamcam.controllers.gcode.moves import Run
from beamcam.controllers.gcode.scan import PlainMoves
from beamcam.controllers.gcode.track import ArcFault, Track
from beamcam.errors import Diagnostic, Rule, Source
from beamcam.geometry.plane import Point


class Controller(ABC):
    """The state of a controller between two blocks; each says how it carries out a move."""

    def __init__(self, name: str, controller: str, plain: PlainMoves) -> None:
        self.said: list[Diagnostic] = []
        self._name = name
        self._controller = controller
        self._plain = plain
        self._lines: list[float] = [*plain.line.tolist(), float("inf")]
        self._next = 0  #: plain move
        self._track = Track(plain)
        self._place: Point = (nan, nan)
        self._feed = 0.0
        self._motion = -1
        self._absolute = True
        self._row = 0  #: blocks since the last move that a controller limits, such as M words
        self._ends = 0

    def plain_until(self, line: int) -> None:
        """Carries out the plain moves before a line."""
        lines, first = self._lines, self._next
        while lines[first] < line and not self._is_simple():
            self._one_plain(first)
            first += 1
        last = bisect_left(lines, line, first) if lines[first] < line else first
        self._next = last
        if first < last:
            self._place, self._feed = self._track.run(first, last, self._place, self._feed)
            self._motion = int(self._plain.motion[last - 1])
            self._row = 0

    def _is_simple(self) -> bool:
        """Whether moves are to where they say, and from somewhere."""
        return self._absolute and not self._ends and not isnan(sum(self._place))

    def _one_plain(self, row: int) -> None:
        """Carries out one plain move as the block that it is."""
        plain = self._plain
        numbers = (*plain.end[row].tolist(), *plain.centre[row].tolist(), float(plain.feed[row]))
        words = {k: v for k, v in zip("XYIJF", numbers, strict=True) if not isnan(v)}
        self._move(int(plain.line[row]), int(plain.motion[row]), words)

    @abstractmethod
    def _move(self, line: int, motion: int, words: dict[str, float]) -> None:
        """Carries out a block that is a motion and its words."""

    def _wrong(self, line: int, found: str, expected: str, rule: Rule = rules.WORD) -> None:
        self.said.append(rule.at(Source(self._name, line), found=found, expected=expected))

    def _arc_fault(self, line: int, fault: str) -> None:
        source = Source(self._name, line)
        self.said.append(rules.ARC.at(source, found=fault, controller=self._controller))

    def _ended(
        self, last: int, per_minute: float, difference: float, arc_fault: ArcFault
    ) -> tuple[Run, list[Diagnostic]]:
        """The whole program, and what is wrong with it; `last` is its last line.

        For the others see `Track.finish`.
        """
        if self._ends != 1:
            found = f"{self._ends} ends of program"
            self.said.append(rules.END.at(Source(self._name, last), found=found))
        done, faults = self._track.finish(per_minute, difference, arc_fault)
        for line, fault in faults:
            self._arc_fault(line, fault)
        self.said.sort(key=lambda said: said.source.line or 0)
        return done, self.said
