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

from math import atan2, cos, degrees, dist, isnan, nan, radians, sin, sqrt

from beamcam.errors import Diagnostic, Source
from beamcam.geometry.curves import Arc, Bezier, EllipseArc
from beamcam.geometry.plane import Point, cross
from beamcam.verify.arcs import arc_fault, sweep_of
from beamcam.verify.blocks import BRAKING, read_blocks
from beamcam.verify.sheets import rules
from beamcam.verify.sheets.events import Event, Keep, Leg, Pause, Ramp, Side, Switch

NAME = "CODESYS"
M_WORDS_IN_A_ROW = 64  #: SMC_DEC_OUTQUEUE_RAN_EMPTY
_FED = frozenset("XYFE") | {BRAKING}
_TRAVEL = {
    0: frozenset("XY"), 1: _FED, 2: _FED | set("IJ"), 3: _FED | set("IJ"),
    6: _FED | set("IJ"), 8: _FED | set("IJKR"), 9: _FED | set("IJKR"),
}  # fmt: skip
_BESIDE: dict[int, Side] = {40: "on", 41: "left", 42: "right"}


def run(
    text: str, name: str, resolution: float, per_minute: float
) -> tuple[list[Event], list[Diagnostic]]:
    """The events of a program, and what its controller would not do as it says.

    `resolution` is the step of its numbers, `per_minute` what makes mm/min of an F word.
    """
    blocks, said = read_blocks(text, name)
    events: list[Event] = []
    place: Point = (nan, nan)
    feed = 0.0
    travel = -1
    absolute, absolute_centre = True, False
    absolute_said = False
    row = 0
    ends = 0

    def wrong(line: int, found: str, expected: str) -> None:
        said.append(rules.WORD.at(Source(name, line), found=found, expected=expected))

    for line, command, number, words in blocks:
        if ends:
            wrong(line, "a block behind the end", "M30 as the last one")
        if command == "M":
            row += 1
            if row == M_WORDS_IN_A_ROW + 1:
                wrong(line, f"{row} M words in a row", f"at most {M_WORDS_IN_A_ROW}, or a move")
            ends += number in (2, 30)
            events.append(Switch(line, number, tuple(sorted(words.items()))))
            continue
        if command == "G" and number not in _TRAVEL:
            if number == 4 and set(words) == {"T"}:
                row += 1
                events.append(Pause(line, words["T"]))
            elif number in _BESIDE and set(words) <= {"D"}:
                events.append(Keep(line, _BESIDE[number], words.get("D", 0.0)))
            elif number in (90, 91) and not words:
                absolute, absolute_said = number == 90, True
            elif number in (98, 99) and not words:
                absolute_centre = number == 98
            elif not (number in (50, 53, 75) and not words):
                wrong(line, f"G{number:02}", "a G word that is known here, with its own letters")
            continue
        if command == "G":
            travel = number
        if travel < 0:
            wrong(line, "words without a command", "G or M")
            continue
        if words.keys() - _TRAVEL[travel]:
            stray = min(words.keys() - _TRAVEL[travel])
            wrong(line, f"{stray} behind G{travel:02}", "no such word there")
            continue
        if "F" in words:
            feed = words["F"] * per_minute
        if "E" in words or BRAKING in words:
            events += (
                Ramp(line, letter == BRAKING, abs(words[letter]))
                for letter in ("E", BRAKING)
                if letter in words
            )
        if not absolute_said:
            said.append(rules.SETTING.at(Source(name, line), found="G90"))
            absolute_said = True
        base = (0.0, 0.0) if absolute else place
        end = (
            base[0] + words["X"] if "X" in words else place[0],
            base[1] + words["Y"] if "Y" in words else place[1],
        )
        start, place = place, end
        row = 0
        if isnan(end[0]) or isnan(end[1]) or (travel and isnan(start[0])):
            wrong(line, "a move from or to nowhere", "X and Y of a traverse before")
            continue
        if travel < 2:
            events.append(Leg(line, travel == 0, start, end, None, feed))
            continue
        if not {"I", "J"} <= words.keys():
            wrong(line, f"G{travel:02} without I and J", "both")
            continue
        shift = (0.0, 0.0) if absolute_centre else start
        at = (shift[0] + words["I"], shift[1] + words["J"])
        curve: Arc | Bezier | EllipseArc | str
        if travel == 6:
            curve = _parabola(start, end, at)
        elif travel in (2, 3):
            curve = _arc(start, end, at, travel == 2, resolution)
        else:
            angle, ratio = words.get("K", 0.0), words.get("R", 0.0)
            curve = _ellipse(start, end, at, angle, ratio, travel == 8, resolution)
        if isinstance(curve, str):
            said.append(rules.ARC.at(Source(name, line), found=curve, controller=NAME))
        else:
            events.append(Leg(line, False, start, end, curve, feed))
    if ends != 1:
        last = text.count("\n")
        said.append(rules.END.at(Source(name, last), found=f"{ends} ends of program"))
    return events, said


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
