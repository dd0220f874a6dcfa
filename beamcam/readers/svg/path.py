"""Path data to exact curves, in the units of the drawing.

`d` is a row of commands, each with numbers: M moves, L H V draw lines, C S Q T Bezier curves, A
ellipse arcs, Z closes; small letters count from the current point. Source: SVG 1.1, section 8.3.
"""

import re
from math import cos, hypot, inf, radians, sin, sqrt

from beamcam.caches import cached
from beamcam.geometry.conics import direction_deg, ellipse_of
from beamcam.geometry.curves import Arc, Bezier, Curve, EllipseArc, Line
from beamcam.geometry.plane import MAX_COORDINATE, Point
from beamcam.readers.drawing import MM_PER_UNIT, lines_through, round_if_circle, split_length
from beamcam.readers.svg.page import CSS_PX, NumberError
from beamcam.readers.svg.tree import Element

_COMMANDS = re.compile(r"([MmZzLlHhVvCcSsQqTtAa])")
_NUMBER = re.compile(r"[-+]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?")
_SEPARATORS = " \t\r\n\f,"
#: Number of arguments of a command; an arc has two flags, which may be without separators.
_TAKES = {"M": 2, "L": 2, "H": 1, "V": 1, "C": 6, "S": 4, "Q": 4, "T": 2, "A": 7}
_N = r"([-+]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?)"
_S = r"[\s,]*"
_ARC = re.compile(f"{_S}{_N}{_S}{_N}{_S}{_N}{_S}([01]){_S}([01]){_S}{_N}{_S}{_N}{_S}")


class PathError(ValueError):
    """Path data that cannot be read: what was found, and what was expected."""

    def __init__(self, found: str, expected: str) -> None:
        self.found, self.expected = found, expected
        super().__init__(f"found {found!r}, expected {expected}")


#: A chain of curves, empty if it has no length; one that is not closed may end where it began.
Subpath = tuple[Curve, ...]


def parse_path(d: str) -> list[Subpath]:
    """The subpaths of path data, each closed one with the line that closes it.

    Raises PathError where the data breaks off or holds something else.
    """
    pen = _Pen()
    pieces = _COMMANDS.split(d)
    if pieces[0].strip():
        raise PathError(_short(pieces[0]), "a command (M)")
    for command, text in zip(pieces[1::2], pieces[2::2], strict=True):
        pen.draw(command, _numbers(command, text))
    pen.finish()
    return pen.done


def _numbers(command: str, text: str) -> list[float]:
    """The numbers behind a command. Raises PathError for anything else, or too few."""
    name = command.upper()
    if name == "A":
        numbers = _arc_numbers(text)
    else:  # "1-2.5.5" are three as well
        numbers = [float(n) for n in _NUMBER.findall(text)]
        if rest := _NUMBER.sub(" ", text).strip(_SEPARATORS):
            raise PathError(_short(rest), "a number")
    if not all(-MAX_COORDINATE <= number <= MAX_COORDINATE for number in numbers):
        raise PathError(_short(text), f"numbers of at most {MAX_COORDINATE:g}")
    if name == "Z":
        if numbers:
            raise PathError(_short(text), "a command after Z")
    elif not numbers or len(numbers) % _TAKES[name]:
        raise PathError(_short(command + text), f"{_TAKES[name]} numbers, or a multiple of them")
    return numbers


def _arc_numbers(text: str) -> list[float]:
    numbers: list[float] = []
    position = 0
    while position < len(text):
        match = _ARC.match(text, position)
        if match is None and not text[position:].strip(_SEPARATORS):
            break
        if match is None:
            raise PathError(_short("A" + text[position:]), "two radii, a turn, two flags, a point")
        numbers += map(float, match.groups())
        position = match.end()
    return numbers


def _short(text: str) -> str:
    text = " ".join(text.split())
    return text if len(text) <= 40 else text[:37] + "..."


class _Pen:
    """The current point and what was drawn so far."""

    def __init__(self) -> None:
        self.done: list[Subpath] = []
        self.curves: list[Curve] = []
        self.moved = False  #: whether a subpath is open
        self.at: Point = (0.0, 0.0)
        self.first: Point = (0.0, 0.0)  #: where the subpath began, which Z returns to
        self.handle: tuple[str, Point] | None = None  #: kind and last control point, for S and T

    def draw(self, command: str, numbers: list[float]) -> None:
        name, relative = command.upper(), command.islower()
        if name == "Z":
            if not self.moved and not self.done:
                raise PathError("z", "M before anything else")
            self.curves += lines_through([self.at, self.first])
            self.at, self.handle = self.first, None
            self.finish()
            return
        if name == "M":
            self.finish()
            x, y = self._points(numbers[:2], relative)[0]
            self.at = self.first = (x, y)
            self.moved, self.handle = True, None
            numbers, name = numbers[2:], "L"
        elif not self.done and not self.moved:
            raise PathError(command, "M before anything else")
        self.moved = True
        takes = _TAKES[name]
        for k in range(0, len(numbers), takes):
            self._segment(name, relative, numbers[k : k + takes])

    def _points(self, numbers: list[float], relative: bool) -> list[Point]:
        x0, y0 = self.at if relative else (0.0, 0.0)
        return [(x0 + x, y0 + y) for x, y in zip(numbers[::2], numbers[1::2], strict=True)]

    def _segment(self, name: str, relative: bool, numbers: list[float]) -> None:
        x0, y0 = self.at
        handle = None
        if name == "A":
            end = self._points(numbers[5:], relative)[0]
            self.curves += arc_curves(self.at, end, numbers[:5])
        elif name in "LHV":
            if name == "H":
                end = (numbers[0] + (x0 if relative else 0.0), y0)
            elif name == "V":
                end = (x0, numbers[0] + (y0 if relative else 0.0))
            else:
                end = self._points(numbers, relative)[0]
            self.curves += lines_through([self.at, end])
        else:
            kind, points = "C" if name in "CS" else "Q", self._points(numbers, relative)
            if name in "ST":  # the control point that continues the curve before smoothly
                x, y = self.handle[1] if self.handle and self.handle[0] == kind else self.at
                points.insert(0, (2 * x0 - x, 2 * y0 - y))
            end = points[-1]
            handle = (kind, points[-2])
            if any(p != self.at for p in points):
                self.curves.append(Bezier((self.at, *points)))
        self.at, self.handle = end, handle

    def finish(self) -> None:
        if self.moved:
            self.done.append(tuple(self.curves))
        self.curves, self.moved = [], False


def arc_curves(start: Point, end: Point, numbers: list[float]) -> list[Curve]:
    """The arc of command A from `start` to `end`: none, a line, or one arc.

    `numbers` are both radii, the turn of the ellipse in degrees, and the flags for the long way
    round and for a sweep in the direction of growing angles. Radii that are too small are grown.
    Source: SVG 1.1, appendix F.6.5 and F.6.6.
    """
    if start == end:
        return []
    rx, ry, turn_deg, large, sweep = abs(numbers[0]), abs(numbers[1]), *numbers[2:]
    if rx == 0.0 or ry == 0.0:
        return [Line(start, end)]
    c, s = cos(radians(turn_deg)), sin(radians(turn_deg))
    dx, dy = (start[0] - end[0]) / 2, (start[1] - end[1]) / 2
    # Half of the chord, in a frame where the ellipse is the unit circle.
    x, y = (c * dx + s * dy) / rx, (c * dy - s * dx) / ry
    half = hypot(x, y)
    if not 0.0 < half < inf:
        raise PathError(f"radii {numbers[0]:g} and {numbers[1]:g}", "those of an ellipse")
    if half > 1.0:
        rx, ry, x, y, half = rx * half, ry * half, x / half, y / half, 1.0
    rise = sqrt(max(0.0, 1.0 - half * half)) / half
    side = -1.0 if bool(large) == bool(sweep) else 1.0
    u, v = side * rise * y, -side * rise * x  # the centre, in that frame
    centre = (
        (start[0] + end[0]) / 2 + c * rx * u - s * ry * v,
        (start[1] + end[1]) / 2 + s * rx * u + c * ry * v,
    )
    first = direction_deg((x - u, y - v))
    around = (direction_deg((-x - u, -y - v)) - first) % 360.0
    sweep_deg = around if sweep else around - 360.0
    if abs(sweep_deg) in (0.0, 360.0):  # ends so near that their angles are one
        return [Line(start, end)]
    axes = ((rx * c, rx * s), (-ry * s, ry * c))
    return [round_if_circle(ellipse_of(centre, *axes, first, sweep_deg))]


def decimals(text: str, least: int = 0) -> int:
    """The most digits behind a point in `text`, but not fewer than `least`."""
    while match := _fraction(least + 1).search(text):
        least = len(match[0]) - 1
    return least


@cached("svg.decimals")
def _fraction(digits: int) -> re.Pattern[str]:
    """A point and as many digits or more."""
    return re.compile(rf"\.\d{{{digits},}}")


# --- shapes ---------------------------------------------------------------------------------------

View = tuple[float, float]

SHAPES = ("path", "rect", "circle", "ellipse", "line", "polyline", "polygon")


def subpaths_of(element: Element, view: View) -> list[Subpath]:
    """The chains of a shape; `view` is what percentages count from.

    Raises PathError or NumberError.
    """

    def length(name: str) -> float:
        return length_of(element, name, view)

    match element.tag:
        case "path":
            return parse_path(element.get("d") or "")
        case "rect":
            return [_rect(element, view)]
        case "circle" | "ellipse":
            rx, ry = map(length, ("r", "r") if element.tag == "circle" else ("rx", "ry"))
            centre = length("cx"), length("cy")
            return [(_arc(centre, rx, ry, 0.0, 360.0),) if rx > 0.0 and ry > 0.0 else ()]
        case "line":
            ends = [(length("x1"), length("y1")), (length("x2"), length("y2"))]
            return [lines_through(ends)]
        case _:
            points = _points(element)
            if element.tag == "polygon" and points:
                points.append(points[0])
            return [lines_through(points)]


def length_of(element: Element, attribute: str, view: View) -> float:
    """A length in units of the drawing: a plain number, one with a unit, or a percentage.

    0 if there is none. Raises NumberError for anything else.
    """
    text = element.get(attribute)
    if text is None:
        return 0.0
    try:
        number, unit = split_length(text)
    except ValueError as error:
        raise NumberError(attribute, text, "a length") from error
    if unit in ("", "px"):
        return number
    if unit == "%":
        along = {"x": view[0], "y": view[1]}.get(_AXIS.get(attribute, ""))
        # Source: SVG 1.1, section 7.10: radii count from the diagonal.
        whole = along if along is not None else hypot(*view) / 2**0.5
        return number / 100 * whole
    if unit not in MM_PER_UNIT:
        raise NumberError(attribute, text, "a number or a length in mm, cm, in, pt, pc, px")
    return number * MM_PER_UNIT[unit] / CSS_PX


_AXIS = {
    **dict.fromkeys(("x", "x1", "x2", "cx", "width", "rx"), "x"),
    **dict.fromkeys(("y", "y1", "y2", "cy", "height", "ry"), "y"),
}


def _size(element: Element, attribute: str, view: View) -> float:
    size = length_of(element, attribute, view)
    if size < 0.0:
        raise NumberError(attribute, element.get(attribute) or "", "a length that is not negative")
    return size


def _rect(element: Element, view: View) -> tuple[Curve, ...]:
    """Corners round as rx and ry say: one of them stands for both, at most half of the side."""
    x, y = length_of(element, "x", view), length_of(element, "y", view)
    width, height = _size(element, "width", view), _size(element, "height", view)
    if width == 0.0 or height == 0.0:
        return ()
    given = [name for name in ("rx", "ry") if (element.get(name) or "auto").strip() != "auto"]
    radii = [_size(element, name, view) for name in given] or [0.0]
    rx, ry = min(radii[0], width / 2), min(radii[-1], height / 2)
    right, low = x + width, y + height
    if rx == 0.0 or ry == 0.0:
        return lines_through([(x, y), (right, y), (right, low), (x, low), (x, y)])
    corners = (
        (right - rx, y + ry, 270.0),
        (right - rx, low - ry, 0.0),
        (x + rx, low - ry, 90.0),
        (x + rx, y + ry, 180.0),
    )
    curves: list[Curve] = []
    at: Point = (x + rx, y)
    for cx, cy, start_deg in corners:
        arc = _arc((cx, cy), rx, ry, start_deg, 90.0)
        curves += (*lines_through([at, arc.start]), arc)
        at = arc.end
    return tuple(curves)


def _arc(
    centre: Point, rx: float, ry: float, start_deg: float, sweep_deg: float
) -> Arc | EllipseArc:
    if rx == ry:
        return Arc(centre, rx, start_deg, sweep_deg)
    return round_if_circle(ellipse_of(centre, (rx, 0.0), (0.0, ry), start_deg, sweep_deg))


def _points(element: Element) -> list[Point]:
    """The pairs of `points`; a trailing separator is usual, an odd count is not."""
    text = element.get("points") or ""
    words = re.findall(r"[^\s,]+", re.sub(r"(?<=[\d.])-", " -", text))
    try:
        numbers = [float(word) for word in words]
    except ValueError as error:
        raise NumberError("points", text[:40], "numbers") from error
    if not all(-MAX_COORDINATE <= number <= MAX_COORDINATE for number in numbers):
        raise NumberError("points", text[:40], f"numbers of at most {MAX_COORDINATE:g}")
    if len(numbers) % 2:
        raise NumberError("points", text[:40], "pairs of numbers")
    return list(zip(numbers[::2], numbers[1::2], strict=True))
