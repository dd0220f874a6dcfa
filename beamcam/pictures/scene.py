"""A picture as data: shapes, their positions on the paper, and their styles.

Paper coordinates are pixels of 1/96 inch, x to the right and y down. The first class of a shape
names its style (`styles`); all of them stand in the SVG, where tests and pages find them.
"""

from collections.abc import Callable, Iterator, Sequence
from itertools import chain, product
from math import ceil, dist
from typing import Literal

from msgspec import Struct

Point = tuple[float, float]
Unit = Literal["mm", "inch"]
Pieces = tuple[str | float, ...]  #: of a text: words, and lengths in mm among them


class Polyline(Struct, frozen=True):
    """A chain of straight lines."""

    classes: str
    points: tuple[Point, ...]
    closed: bool = False
    tip: str = ""  #: what it is, shown where one points at it
    line: int = 0  #: of the program that makes it; 0 where there is none


class Circle(Struct, frozen=True):
    """A circle."""

    classes: str
    at: Point
    radius: float
    tip: str = ""
    line: int = 0


class Text(Struct, frozen=True):
    """A line of text, its base line at `at`."""

    classes: str
    at: Point
    text: str
    size: float = 11.0  #: height of the letters' body
    anchor: Literal["start", "middle", "end"] = "start"
    turn_deg: float = 0.0  #: counter-clockwise
    mm: float | None = None  #: the length that the text shows; a page may show it in other units
    tip: str = ""
    line: int = 0
    pieces: Pieces = ()  #: of a text with lengths among its words, for the same reason
    unit: Unit = "mm"  #: that these lengths are shown in


Shape = Polyline | Circle | Text


class Scene(Struct, frozen=True):
    """A picture."""

    title: str
    about: str  #: what it shows, in a sentence
    width: float
    height: float
    shapes: tuple[Shape, ...]


class PaperFrame(Struct, frozen=True):
    """Mapping of millimetres to the paper."""

    scale: float  #: pixels in a millimetre
    left: float  #: of mm x 0
    base: float  #: of mm y 0
    down: bool = False  #: whether y runs down the paper, as on a flange seen from above

    def at(self, x: float, y: float) -> Point:
        """The place of a point."""
        rise = -y if self.down else y
        return self.left + x * self.scale, self.base - rise * self.scale

    def all(self, points: Sequence[Sequence[float]]) -> tuple[Point, ...]:
        """The places of points."""
        return tuple([self.at(p[0], p[1]) for p in points])


MM_PER_INCH = 25.4
_FORMS: dict[Unit, tuple[float, int]] = {"mm": (1.0, 1), "inch": (MM_PER_INCH, 3)}


def shown(mm: float, unit: Unit = "mm") -> str:
    """A length as a dimension shows it: tenths of a millimetre, thousandths of an inch."""
    by, decimals = _FORMS[unit]
    text = f"{mm / by:.{decimals}f}"
    text = text.rstrip("0").rstrip(".") if "." in text else text
    return "0" if text == "-0" else text


def as_text(pieces: Pieces, unit: Unit = "mm") -> str:
    """A text with the lengths among its words in a unit."""
    return "".join([one if isinstance(one, str) else shown(one, unit) for one in pieces])


# --- styles: how a class of shapes is drawn, on paper and in the dark -----------------------------


class Style(Struct, frozen=True):
    """Colours as #rrggbb; none is not drawn."""

    stroke: str | None = None
    fill: str | None = None
    width: float = 1.0
    dash: tuple[float, ...] = ()
    dark_stroke: str | None = None  #: on a dark page; as `stroke` where there is none
    dark_fill: str | None = None
    bold: bool = False


INK, PALE = "#1c2530", "#e8ecf1"
DARK_INK, DARK_PALE = "#e6ebf2", "#2a333f"

#: Colours of tools, told apart by people who do not see red or green too (Okabe and Ito).
TOOL_COLOURS = (
    ("#0072b2", "#56b4e9"), ("#d55e00", "#ff8a3c"), ("#00795a", "#2ec4a0"), ("#b0478a", "#e38bc4"),
    ("#8a6d00", "#e3c23a"), ("#4b4bb3", "#9a9aff"), ("#7a3b12", "#c98a5c"), ("#3d5a66", "#9fbecb"),
)  # fmt: skip

#: From slow to fast (viridis, without its palest end).
SPEED_COLOURS = (
    ("#440154", "#b07cc6"), ("#46327e", "#9d8fe0"), ("#365c8d", "#7fb0e6"), ("#277f8e", "#5cc4d1"),
    ("#1f8a70", "#43cfa6"), ("#3f9e4d", "#74dd7f"), ("#7a9a1f", "#b8dc4a"), ("#a58a00", "#f5dc3c"),
)  # fmt: skip


def _line(colour: str, dark: str, width: float = 1.0, dash: tuple[float, ...] = ()) -> Style:
    return Style(colour, None, width, dash, dark)


def _text(colour: str = INK, dark: str = DARK_INK, bold: bool = False) -> Style:
    return Style(None, colour, dark_fill=dark, bold=bold)


STYLES: dict[str, Style] = {
    "paper": Style(None, "#ffffff", dark_fill="#12171d"),
    "face": Style(INK, "#f4f6f9", 1.2, (), DARK_INK, "#1c232c"),
    "part": Style(INK, "#dfe9f5", 1.0, (), DARK_INK, "#22364d"),
    "trim": Style("#8a5a00", "#f6e7c8", 0.8, (), "#e0b050", "#3d3320"),
    "remnant": Style("#59636e", "#ffffff", 0.8, (6.0, 3.0), "#9aa5b1", "#181e25"),
    "stock": _line("#59636e", "#9aa5b1", 0.8, (6.0, 3.0)),
    "outer": Style(INK, "#f4f6f9", 1.2, (), DARK_INK, "#1c232c"),
    "inner": Style(INK, "#ffffff", 1.0, (), DARK_INK, "#12171d"),
    "open": _line("#b3261e", "#ff8a80", 1.0),
    "hole": Style("#0072b2", "#ffffff", 1.0, (), "#56b4e9", "#12171d"),
    "slot": Style("#0072b2", "#ffffff", 1.0, (), "#56b4e9", "#12171d"),
    "thread": _line("#0072b2", "#56b4e9", 0.6, (3.0, 2.0)),
    "mark": _line("#00795a", "#2ec4a0", 1.0),
    "engrave": _line("#7a3b12", "#c98a5c", 1.0),
    "punch": _line("#00795a", "#2ec4a0", 1.0, (1.5, 2.0)),
    "powder": _line("#7a5af0", "#b5a4ff", 1.0, (4.0, 2.0)),
    "ignored": _line("#8d99a6", "#75828f", 0.8, (2.0, 3.0)),
    "bend": _line("#7a5af0", "#b5a4ff", 1.0, (8.0, 3.0, 2.0, 3.0)),
    "cut": _line("#b3261e", "#ff8a80", 1.8),
    "cut-edge": _line("#b3261e", "#ff8a80", 1.0),
    "section": Style(INK, "#c9d3df", 1.0, (), DARK_INK, "#3a4756"),
    "guide": _line("#8d99a6", "#75828f", 0.5, (2.0, 3.0)),
    "datum": _line(INK, DARK_INK, 2.4),
    "dim": _line("#59636e", "#9aa5b1", 0.6),
    "figure": _text("#3f4a56", "#c3ccd6"),
    "text": _text("#7a3b12", "#c98a5c"),
    "label": _text(),
    "heading": _text(bold=True),
    "number": _text("#1c2530", "#e6ebf2", True),
    "rapid": _line("#8d99a6", "#75828f", 0.8, (4.0, 3.0)),
    "lead": _line("#ffb000", "#7a5a10", 5.0),
    "pierce": Style("#b3261e", "#ffffff", 1.4, (), "#ff8a80", "#12171d"),
    "stop": _line("#4b4bb3", "#9a9aff", 1.0),
    "grid": _line("#d5dbe2", "#333d49", 0.6),
    "axis": _line("#3f4a56", "#c3ccd6", 1.0),
    "position": _line("#00795a", "#2ec4a0", 1.6),
    "velocity": _line("#0072b2", "#56b4e9", 1.6),
    "acceleration": _line("#b3261e", "#ff8a80", 1.6),
    "true": _line("#59636e", "#9aa5b1", 1.4),
    "stair": _line("#0072b2", "#56b4e9", 1.8),
    "off": Style("#b3261e", None, 1.8, (), "#ff8a80"),
    "gone": Style("#b3261e", None, 1.6, (4.0, 2.0), "#ff8a80"),
    "new": Style("#00795a", None, 1.8, (), "#2ec4a0"),
    "moved": _line("#7a5af0", "#b5a4ff", 1.6),
    "same": Style("#7d8996", None, 0.8, (), "#75828f"),
    "gone-text": _text("#b3261e", "#ff8a80"),
    "new-text": _text("#00795a", "#2ec4a0"),
    "same-text": _text("#59636e", "#9aa5b1"),
    **{f"tool-{k}": Style(c, "#ffffff", 1.6, (), d, "#12171d")
       for k, (c, d) in enumerate(TOOL_COLOURS)},
    **{f"path-{k}": _line(c, d, 1.4) for k, (c, d) in enumerate(TOOL_COLOURS)},
    **{f"speed-{k}": _line(c, d, 1.5) for k, (c, d) in enumerate(SPEED_COLOURS)},
}  # fmt: skip


def style_of(classes: str) -> Style:
    """The style of the first class. Raises KeyError for one that has none."""
    return STYLES[classes.split(" ", 1)[0]]


def css(prefix: str = "", dark: bool = False) -> str:
    """The styles as rules of CSS, each behind `prefix`; `dark` as they are on a dark page."""
    lines = []
    for name, s in STYLES.items():
        stroke = (s.dark_stroke if dark else None) or s.stroke
        fill = (s.dark_fill if dark else None) or s.fill
        rule = f"fill:{fill or 'none'}"
        if stroke:
            rule += f";stroke:{stroke}"
            if not dark:
                rule += f";stroke-width:{s.width:g}"
                if s.dash:
                    rule += f";stroke-dasharray:{' '.join(f'{d:g}' for d in s.dash)}"
        if s.bold and not dark:
            rule += ";font-weight:bold"
        lines.append(f"{prefix}.{name}{{{rule}}}")
    return "".join(lines)


# --- labels: places for small texts beside what they name, so that none lies over another ---------

Box = tuple[float, float, float, float]

#: Ways to go from a place: up to the right first, where a reader looks for a number.
SIDES = ((1, -1), (-1, -1), (1, 1), (-1, 1), (0, -1), (0, 1))
CENTRE = ((0, 0),)
LEVEL = ((1, 0), (-1, 0))
CELL = 16.0  #: pixels of the squares by which neighbours are found
LINE_STEP = 3.0  #: pixels between the boxes that stand for a line
MOST_CELLS = 4096  #: of one box
MOST_BOXES = 4096  #: of one line
LETTER = 0.6  #: width of a letter, in sizes of the text
CAPITAL = 0.72  #: height of a capital


class Labels:
    """What lies on a paper already, and room for more texts."""

    def __init__(self) -> None:
        self._cells: dict[tuple[int, int], list[Box]] = {}
        self._large: list[Box] = []  #: those that lie over too many cells

    def block(self, box: Box) -> None:
        """Nothing is to lie over this box."""
        if (box[2] - box[0]) * (box[3] - box[1]) > MOST_CELLS * CELL * CELL:
            self._large.append(box)
            return
        for cell in _cells(box):
            self._cells.setdefault(cell, []).append(box)

    def block_line(self, a: Point, b: Point) -> None:
        """Nothing is to lie over the line between two points."""
        count = min(max(1, ceil(dist(a, b) / LINE_STEP)), MOST_BOXES)
        for k in range(count):
            x, y = (p + (k + 0.5) / count * (q - p) for p, q in zip(a, b, strict=True))
            self.block((x - 1.0, y - 1.0, x + 1.0, y + 1.0))

    def place(
        self, at: Point, gap: float, text: str, size: float, rings: int = 3,
        suits: Callable[[Box], bool] = lambda _: True, is_open: bool = False,
    ) -> Point | None:  # fmt: skip
        """The base line's beginning of a text near a place, which is taken from then on.

        The first free one of the sides, `gap` away, then further off; None where none is free.
        `suits` is asked of the box of the text. The place itself is tried first if it is open.
        """
        wide, high = LETTER * size * len(text), CAPITAL * size
        # Level with a place run the ways from hole to hole, so that it is tried last.
        for sides, ring in product((CENTRE if is_open else (), SIDES, LEVEL), range(rings)):
            for right, down in sides:
                off = gap + ring * (high + 1.0)
                x = at[0] + right * off - wide * (1 - right) / 2
                y = at[1] + down * off + high * (1 + down) / 2
                box = (x, y - high, x + wide, y)
                about = (other for cell in _cells(box) for other in self._cells.get(cell, ()))
                is_taken = any(
                    box[0] < b[2] and b[0] < box[2] and box[1] < b[3] and b[1] < box[3]
                    for b in chain(about, self._large)
                )
                if not is_taken and suits(box):
                    self.block(box)
                    return x, y
        return None


def _cells(box: Box) -> Iterator[tuple[int, int]]:
    x0, y0, x1, y1 = (int(v // CELL) for v in box)
    return product(range(x0, x1 + 1), range(y0, y1 + 1))


def is_in(a: Box, b: Box) -> bool:
    """Whether a box lies in another."""
    return b[0] <= a[0] and b[1] <= a[1] and a[2] <= b[2] and a[3] <= b[3]


def arrow(a: Point, b: Point, classes: str = "axis") -> Polyline:
    """An arrow from a to b, along one of the paper's axes."""
    (x0, y0), (x1, y1) = a, b
    length = abs(x1 - x0) + abs(y1 - y0)
    ux, uy = (x1 - x0) / length, (y1 - y0) / length
    wings = tuple((x1 - 8 * ux + k * uy * 4, y1 - 8 * uy + k * ux * 4) for k in (1, -1))
    return Polyline(classes, (a, b, wings[0], b, wings[1]))
