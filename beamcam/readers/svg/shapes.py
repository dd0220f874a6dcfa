"""The basic shapes as chains of exact curves, in the units of the drawing."""

import re
from math import hypot

from beamcam.geometry.conics import ellipse_of
from beamcam.geometry.curves import Arc, Curve, EllipseArc
from beamcam.geometry.plane import MAX_COORDINATE, Point
from beamcam.readers.drawing import MM_PER_UNIT, lines_through, round_if_circle, split_length
from beamcam.readers.svg.page import CSS_PX
from beamcam.readers.svg.path import Subpath, parse_path
from beamcam.readers.svg.tree import Element

View = tuple[float, float]

SHAPES = ("path", "rect", "circle", "ellipse", "line", "polyline", "polygon")


class NumberError(ValueError):
    """An attribute that is not a length: its name, what was found and what was expected."""

    def __init__(self, attribute: str, found: str, expected: str) -> None:
        self.attribute, self.found, self.expected = attribute, found, expected
        super().__init__(f"found {attribute}={found!r}, expected {expected}")


def subpaths_of(element: Element, view: View) -> list[Subpath]:
    """The chains of a shape; `view` is what percentages count from.

    Raises PathError or NumberError.
    """
    match element.tag:
        case "path":
            return parse_path(element.get("d") or "")
        case "rect":
            return [_rect(element, view)]
        case "circle":
            radius = length_of(element, "r", view)
            return [_round(element, view, radius, radius)]
        case "ellipse":
            rx, ry = length_of(element, "rx", view), length_of(element, "ry", view)
            return [_round(element, view, rx, ry)]
        case "line":
            ends = [(length_of(element, x, view), length_of(element, y, view)) for x, y in _LINE]
            return [lines_through(ends)]
        case _:
            points = _points(element)
            if element.tag == "polygon" and points:
                points.append(points[0])
            return [lines_through(points)]


_LINE = (("x1", "y1"), ("x2", "y2"))


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


def view_box(text: str) -> tuple[float, float, float, float]:
    """The numbers of a viewBox: x, y, width and height. Raises NumberError for anything else."""
    words = re.split(r"[\s,]+", text.strip())
    try:
        x, y, width, height = map(float, words)
    except ValueError as error:
        raise NumberError("viewBox", text, "four numbers") from error
    if not (
        width > 0.0 and height > 0.0 and max(map(abs, (x, y, width, height))) <= MAX_COORDINATE
    ):
        raise NumberError("viewBox", text, "a width and a height above 0")
    return x, y, width, height


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
    rx = _radius(element, "rx", view)
    ry = _radius(element, "ry", view)
    rx, ry = (ry if rx is None else rx), (rx if ry is None else ry)
    rx, ry = min(rx or 0.0, width / 2), min(ry or 0.0, height / 2)
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


def _radius(element: Element, attribute: str, view: View) -> float | None:
    if (element.get(attribute) or "auto").strip() == "auto":
        return None
    return _size(element, attribute, view)


def _round(element: Element, view: View, rx: float, ry: float) -> Subpath:
    if rx <= 0.0 or ry <= 0.0:
        return ()
    centre = (length_of(element, "cx", view), length_of(element, "cy", view))
    return (_arc(centre, rx, ry, 0.0, 360.0),)


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
