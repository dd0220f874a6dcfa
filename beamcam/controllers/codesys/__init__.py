"""The blocks of CODESYS SoftMotion CNC: a program's text as words, and its curves (DIN 66025).

    N10 G01 X100.5 Y-20 F40      a block: number, one command, then its words
    N20 M40 K13 L14              K and L are the command's parameters
    % JOB    (a comment)         the program's name, and what the controller does not read

    N30 G01 X5 F40 E900 E-800    E runs up, E- brakes

Words are separated by spaces or tabs; case, leading zeros and the block numbers count for
nothing. At most one G or M stands in a block, before its words. All numbers may be real except
those of N, G, M and H. Source: CODESYS online help, "CNC: DIN 66025".
"""

import re
from collections.abc import Set
from math import atan2, cos, degrees, dist, hypot, radians, sin, sqrt

from msgspec import Struct

from beamcam.caches import BoundedCache
from beamcam.controllers.dialect import LETTERS, NUMBER
from beamcam.controllers.events import Curve
from beamcam.controllers.interpreter import arc_of
from beamcam.geometry.curves import Arc, Bezier, EllipseArc
from beamcam.geometry.plane import Point, cross

_WHOLE = frozenset("NGMH")
BRAKING = "E-"  #: how a block calls an E with a negative value, which may stand beside E
_WORD = re.compile(rf"([A-Z])({NUMBER})")
_COMMENT = re.compile(r"\([^()]*\)")


class CodesysBlock(Struct, frozen=True, gc=False):
    """One block, whatever its number."""

    command: str  #: "G", "M", or "" where the last travel command goes on
    number: int
    words: dict[str, float]  #: the others


class CodesysFault(Struct, frozen=True):
    """A syntax error in a block."""

    found: str
    expected: str


Word = tuple[str, float]  #: its letter, or `BRAKING`, and its value, wherever it stands


class Lexer:
    """Takes lines apart, by the letters of the words that a controller knows."""

    def __init__(self, letters: Set[str] = LETTERS) -> None:
        self._letters = letters
        self._known: BoundedCache[str, Word] = BoundedCache("codesys.words")

    def block(self, text: str) -> CodesysBlock | CodesysFault | None:
        """The words of a line; None where there is nothing in it."""
        if not text.isascii():
            text = "".join(c if c.isascii() else "\N{REPLACEMENT CHARACTER}" for c in text)
        bare = text.upper()
        if "(" in bare or ")" in bare:
            bare = _COMMENT.sub(" ", bare)
            if "(" in bare or ")" in bare:
                expected = "a comment that begins and ends on its line, none in another"
                return CodesysFault(text.strip(), expected)
        command, number, known = "", 0, self._known
        words: dict[str, float] = {}
        for index, word_text in enumerate(bare.split()):
            word = known.get(word_text)
            if word is None:
                read = self._read_word(word_text)
                if isinstance(read, CodesysFault):
                    if not index and word_text.startswith("/"):
                        expected = "a block that always runs; `/` leaves that to a switch"
                        return CodesysFault(text.strip(), expected)
                    return read
                word = read
            name, value = word
            if name not in "GMN":
                if name in words:
                    return CodesysFault(word_text, f"{name} once in a block")
                words[name] = value
            elif name == "N":
                if index:
                    return CodesysFault(word_text, "the block number at the beginning")
            elif command:
                stands = f"{command}{number} stands there already"
                return CodesysFault(word_text, f"one command a block, {stands}")
            elif words:
                return CodesysFault(word_text, "the command before the other words")
            else:
                command, number = name, int(value)
        return CodesysBlock(command, number, words) if command or words else None

    def _read_word(self, text: str) -> Word | CodesysFault:
        match = _WORD.fullmatch(text)
        if match is None:
            return CodesysFault(text, "a letter and a number, set off by spaces")
        letter, digits = match.groups()
        if letter not in self._letters:
            return CodesysFault(text, "a word that the controller knows")
        if letter in _WHOLE and not digits.isdigit():
            return CodesysFault(text, f"a whole number behind {letter}")
        value = float(digits)
        name = BRAKING if letter == "E" and value < 0.0 else letter
        return self._known.keep(text, (name, value))


# --- curves ---------------------------------------------------------------------------------------

#     G02 G03 X Y I J, or R  arc about a centre, or below 180 degrees with a radius
#     G06 X Y I J            parabola, I and J its vertex: the tangent there runs as the chord does
#     G08 G09 X Y I J K R    ellipse, K the direction of its main axis in degrees, R minor / major
#
# Both ends and the centre determine an ellipse; R counts where both ends are equally far from the
# main axis. With I and J the centre of an arc has to lie on the bisector of the chord; up to 10 %
# beside it the controller moves it there. With R it takes the arc below 180 degrees. Start on end
# is a full circle. What cannot be becomes a straight line without a word, so it is checked here.
# Source: CODESYS online help, "CNC: DIN 66025". Lengths in mm, angles in degrees.


CENTRE_SHARE = 0.1  #: how far off the bisector the controller still mends a centre, by the radius


def arc_fault(start: Point, end: Point, centre: Point, resolution: float) -> str | None:
    """The fault of an arc about `centre` as written; None if there is none.

    `resolution` is the step of the numbers: start, end and centre may each be half of it off in
    x and in y, which is sqrt(2) / 2 of it, and the centre counts in both radii; so honest radii
    differ by up to 4 sqrt(2) / 2 of it, and no more.
    """
    radius = dist(start, centre)
    if radius <= resolution:
        return f"of radius {radius:.4g}"
    if start == end:
        return None
    difference = abs(radius - dist(end, centre))
    if difference > 2 * sqrt(2) * resolution + 1e-9:
        return f"whose radii at start and end differ by {difference:.4g}"
    (x0, y0), (x1, y1), (cx, cy) = start, end, centre
    along = (cx - (x0 + x1) / 2) * (x1 - x0) + (cy - (y0 + y1) / 2) * (y1 - y0)
    off = abs(along) / hypot(x1 - x0, y1 - y0)  # from the perpendicular bisector of start and end
    if off > CENTRE_SHARE * radius:
        return f"whose centre lies {off:.4g} beside the bisector of its chord"
    return None


def curve_of(
    motion: int, start: Point, end: Point, words: dict[str, float], origin: Point, resolution: float
) -> Curve | str:
    """The curve of a block, whose I and J count from `origin`, or what is wrong with it.

    `resolution` is the step of the numbers.
    """
    clockwise = motion in (2, 8)
    if motion in (2, 3) and "R" in words:
        return _arc_by_radius(start, end, words, clockwise)
    if not {"I", "J"} <= words.keys():
        return "without I, J or R" if motion in (2, 3) else "without I and J"
    at = (origin[0] + words["I"], origin[1] + words["J"])
    if motion == 6:
        return _parabola(start, end, at)
    if motion in (2, 3):
        fault = arc_fault(start, end, at, resolution)
        return fault or arc_of(start, end, at, clockwise)
    angle, ratio = words.get("K", 0.0), words.get("R", 0.0)
    return _ellipse(start, end, at, angle, ratio, clockwise, resolution)


def _arc_by_radius(start: Point, end: Point, words: dict[str, float], clockwise: bool) -> Arc | str:
    """The arc below 180 degrees from start to end with the radius R."""
    radius, chord = words["R"], dist(start, end)
    if "I" in words or "J" in words:
        return "with R as well as I and J"
    if radius <= 0:
        return f"of radius {radius:.4g}"
    if chord == 0:
        return "by R whose end is its start"
    if radius < chord / 2:
        return f"of radius {radius:.4g} over a chord of {chord:.4g}"
    (x0, y0), (x1, y1) = start, end
    height = sqrt(max(0.0, radius * radius - chord * chord / 4))
    side = -1.0 if clockwise else 1.0  # left of the chord for a counter-clockwise short arc
    centre = (
        (x0 + x1) / 2 - side * height * (y1 - y0) / chord,
        (y0 + y1) / 2 + side * height * (x1 - x0) / chord,
    )
    return arc_of(start, end, centre, clockwise)


def _parabola(start: Point, end: Point, vertex: Point) -> Bezier | str:
    """The Bezier curve of degree two whose point at t = 1/2 is the vertex."""
    if start == end:
        return "that is a parabola from a point to itself"
    chord = (end[0] - start[0], end[1] - start[1])
    if cross(chord, (vertex[0] - start[0], vertex[1] - start[1])) == 0.0:
        return "that is a parabola whose vertex lies on its chord"
    control = (2 * vertex[0] - (start[0] + end[0]) / 2, 2 * vertex[1] - (start[1] + end[1]) / 2)
    return Bezier((start, control, end))


def _ellipse(
    start: Point, end: Point, centre: Point, angle: float, ratio: float, clockwise: bool,
    resolution: float,
) -> EllipseArc | str:  # fmt: skip
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
