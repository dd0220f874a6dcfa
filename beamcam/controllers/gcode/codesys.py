"""CODESYS SoftMotion CNC on a cutting table: lines, arcs, parabolas and ellipses.

    G02 G03 X Y I J        arc, I and J from its start (G99) or absolute (G98)
    G06 X Y I J            parabola, I and J its vertex: there the tangent is parallel to the chord
    G08 G09 X Y I J K R    ellipse, K the direction of its main axis in degrees, R minor / major
    F, E, E-               feed, acceleration to run up and to brake, mm/s2 whatever F is in
    G41 G42 D, G40         beside the contour by the radius D, on it again

Both ends and the centre determine an ellipse; R counts where both ends are equally far from the
main axis. What cannot be becomes a straight line without a word, so it is checked here. Source:
CODESYS online help, "CNC: DIN 66025".
"""

from math import atan2, cos, degrees, dist, isnan, radians, sin, sqrt

from msgspec.structs import replace

from beamcam.controllers.arcs import arc_fault, sweep_of
from beamcam.controllers.blocks import BRAKING, read_blocks
from beamcam.controllers.events import Keep, Leg, Pause, Ramp, Side, Switch
from beamcam.controllers.gcode import rules
from beamcam.controllers.gcode.controller import Controller
from beamcam.controllers.gcode.moves import Run
from beamcam.controllers.gcode.scan import Scan, scan
from beamcam.errors import Diagnostic, Source
from beamcam.geometry.curves import Arc, Bezier, EllipseArc
from beamcam.geometry.plane import Point, cross

NAME = "CODESYS"
M_WORDS_IN_A_ROW = 64  #: SMC_DEC_OUTQUEUE_RAN_EMPTY
_FED = frozenset("XYFE") | {BRAKING}
_TRAVEL = {
    0: frozenset("XY"), 1: _FED, 2: _FED | set("IJ"), 3: _FED | set("IJ"),
    6: _FED | set("IJ"), 8: _FED | set("IJKR"), 9: _FED | set("IJKR"),
}  # fmt: skip
_BESIDE: dict[int, Side] = {40: "on", 41: "left", 42: "right"}


def run(text: str, name: str, resolution: float, per_minute: float) -> tuple[Run, list[Diagnostic]]:
    """What a program does, and what its controller would not do as it says.

    `resolution` is the step of its numbers, `per_minute` what makes mm/min of an F word.
    """
    found = scan(text, traverse_with_feed=False)
    numbers = [number for number, _ in found.odd]
    blocks, said = read_blocks("\n".join(line for _, line in found.odd), name)
    reader = _Reader(name, resolution, found, [_at(d, numbers) for d in said])
    for line, command, number, words in blocks:
        reader.plain_until(numbers[line - 1])
        reader.block(numbers[line - 1], command, number, words)
    return reader.finish(text.count("\n"), per_minute)


def _at(said: Diagnostic, numbers: list[int]) -> Diagnostic:
    """What was said about the odd lines of a text, at the numbers that they have in it."""
    source = said.source
    if source.line is None:
        return said
    return replace(said, source=replace(source, line=numbers[source.line - 1]))


class _Reader(Controller):
    """The state of the controller between two blocks."""

    def __init__(self, name: str, resolution: float, found: Scan, said: list[Diagnostic]) -> None:
        super().__init__(name, NAME, found.plain)
        self.said = said
        self._resolution = resolution
        self._absolute_centre = False
        self._absolute_said = False

    def _is_simple(self) -> bool:
        return self._absolute_said and not self._absolute_centre and super()._is_simple()

    def _move(self, line: int, motion: int, words: dict[str, float]) -> None:
        self.block(line, "G", motion, words)

    def block(self, line: int, command: str, number: int, words: dict[str, float]) -> None:
        """Carries out one block."""
        if self._ends:
            self._wrong(line, "a block behind the end", "M30 as the last one")
        if command == "M":
            self._in_a_row(line)
            self._ends += number in (2, 30)
            self._track.event(Switch(line, number, words))
        elif command == "G" and number not in _TRAVEL:
            self._setting(line, number, words)
        else:
            if command == "G":
                self._motion = number
            self._travel(line, words)

    def _in_a_row(self, line: int) -> None:
        """Counts an M word or a dwell, which wait in one queue until a move or G75."""
        self._row += 1
        if self._row == M_WORDS_IN_A_ROW + 1:
            expected = f"at most {M_WORDS_IN_A_ROW}, or a move"
            self._wrong(line, f"{self._row} M words in a row", expected)

    def _setting(self, line: int, number: int, words: dict[str, float]) -> None:
        if number == 4 and set(words) == {"T"}:
            self._in_a_row(line)
            self._track.event(Pause(line, words["T"]))
        elif number in _BESIDE and set(words) <= {"D"}:
            self._track.event(Keep(line, _BESIDE[number], words.get("D", 0.0)))
        elif number in (90, 91) and not words:
            self._absolute, self._absolute_said = number == 90, True
        elif number in (98, 99) and not words:
            self._absolute_centre = number == 98
        elif number == 75 and not words:
            self._row = 0
        elif not (number in (50, 53) and not words):
            expected = "a G word that is known here, with its own letters"
            self._wrong(line, f"G{number:02}", expected)

    def _travel(self, line: int, words: dict[str, float]) -> None:
        """The words of a move."""
        if self._motion < 0:
            self._wrong(line, "words without a command", "G or M")
            return
        stray = words.keys() - _TRAVEL[self._motion]
        if stray:
            self._wrong(line, f"{min(stray)} behind G{self._motion:02}", "no such word there")
            return
        self._feed = words.get("F", self._feed)
        for letter in ("E", BRAKING):
            if letter in words:
                self._track.event(Ramp(line, letter == BRAKING, abs(words[letter])))
        if not self._absolute_said:
            self.said.append(rules.SETTING.at(Source(self._name, line), found="G90"))
            self._absolute_said = True
        start = self._place
        base = (0.0, 0.0) if self._absolute else start
        self._place = end = (
            base[0] + words["X"] if "X" in words else start[0],
            base[1] + words["Y"] if "Y" in words else start[1],
        )
        self._row = 0
        if isnan(end[0]) or isnan(end[1]) or (self._motion and isnan(start[0])):
            self._wrong(line, "a move from or to nowhere", "X and Y of a traverse before")
        elif self._motion < 2:
            self._track.leg(Leg(line, self._motion == 0, start, end, None, self._feed))
        elif not {"I", "J"} <= words.keys():
            self._wrong(line, f"G{self._motion:02} without I and J", "both")
        else:
            self._curve(line, start, end, words)

    def _curve(self, line: int, start: Point, end: Point, words: dict[str, float]) -> None:
        shift = (0.0, 0.0) if self._absolute_centre else start
        at = (shift[0] + words["I"], shift[1] + words["J"])
        curve: Arc | Bezier | EllipseArc | str
        if self._motion == 6:
            curve = _parabola(start, end, at)
        elif self._motion in (2, 3):
            curve = _arc(start, end, at, self._motion == 2, self._resolution)
        else:
            angle, ratio = words.get("K", 0.0), words.get("R", 0.0)
            curve = _ellipse(start, end, at, angle, ratio, self._motion == 8, self._resolution)
        if isinstance(curve, str):
            self._arc_fault(line, curve)
        else:
            self._track.leg(Leg(line, False, start, end, curve, self._feed))

    def finish(self, last: int, per_minute: float) -> tuple[Run, list[Diagnostic]]:
        """The whole program, and what it has not that a whole one has."""
        self.plain_until(last + 2)

        def fault_of(start: Point, end: Point, centre: Point, clockwise: bool) -> str | None:
            return arc_fault(start, end, centre, self._resolution)

        return self._ended(last, per_minute, 2 * sqrt(2) * self._resolution, fault_of)


def _arc(start: Point, end: Point, centre: Point, clockwise: bool, resolution: float) -> Arc | str:
    fault = arc_fault(start, end, centre, resolution)
    if fault:
        return fault
    x, y = start[0] - centre[0], start[1] - centre[1]
    return Arc(
        centre, dist(start, centre), degrees(atan2(y, x)), sweep_of(start, end, centre, clockwise)
    )


def _parabola(start: Point, end: Point, vertex: Point) -> Bezier | str:
    """The Bezier curve of degree two whose point at t = 1/2 is the vertex."""
    if start == end:
        return "that is a parabola from a point to itself"
    chord = (end[0] - start[0], end[1] - start[1])
    if cross(chord, (vertex[0] - start[0], vertex[1] - start[1])) == 0.0:
        return "that is a parabola whose vertex lies on its chord"
    control = (
        2 * vertex[0] - (start[0] + end[0]) / 2,
        2 * vertex[1] - (start[1] + end[1]) / 2,
    )
    return Bezier((start, control, end))


def _ellipse(
    start: Point,
    end: Point,
    centre: Point,
    angle: float,
    ratio: float,
    clockwise: bool,
    resolution: float,
) -> EllipseArc | str:
    c, s = cos(radians(angle)), sin(radians(angle))

    def local(p: Point) -> Point:
        x, y = p[0] - centre[0], p[1] - centre[1]
        return c * x + s * y, c * y - s * x

    (x1, y1), (x2, y2) = local(start), local(end)
    if abs(abs(y1) - abs(y2)) <= resolution:
        if not 0.0 < ratio <= 1.0:
            return f"that is an ellipse of ratio {ratio:g} whose ends do not determine it"
        major = sqrt(x1 * x1 + (y1 / ratio) ** 2)
        minor = major * ratio
    else:
        det = x1 * x1 * y2 * y2 - x2 * x2 * y1 * y1
        if det == 0.0:
            return "that is an ellipse whose ends lie on one line with its centre"
        over_a2, over_b2 = (y2 * y2 - y1 * y1) / det, (x1 * x1 - x2 * x2) / det
        if over_a2 <= 0.0 or over_b2 <= 0.0:
            return "that is an ellipse on which its ends do not lie"
        major, minor = 1 / sqrt(over_a2), 1 / sqrt(over_b2)
    if minor > major:
        return f"that is an ellipse whose main axis {major:.4f} is shorter than {minor:.4f}"
    first = degrees(atan2(y1 / minor, x1 / major))
    sweep = 360.0
    if start != end:
        last = degrees(atan2(y2 / minor, x2 / major))
        sweep = ((first - last) if clockwise else (last - first)) % 360.0 or 360.0
    return EllipseArc(
        centre, (major * c, major * s), minor / major, first, -sweep if clockwise else sweep
    )
