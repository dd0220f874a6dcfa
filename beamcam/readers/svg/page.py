"""The page: how long a unit of the drawing is, and where its origin lies."""

import re
from collections.abc import Callable
from math import inf, radians, tan
from typing import Literal, NamedTuple

from msgspec import Struct

from beamcam.errors import Diagnostic, ReadError, Source
from beamcam.geometry.plane import IDENTITY, MAX_COORDINATE, Matrix, unit_vector
from beamcam.readers.drawing import MM_PER_UNIT, UNITS_OPTION, WIDTH_OPTION, split_length
from beamcam.readers.svg import rules
from beamcam.readers.svg.tree import Document, declarations

_ASPECT = re.compile(
    r"(?:defer\s+)?(?:(?P<none>none)|x(?P<x>Min|Mid|Max)Y(?P<y>Min|Mid|Max))"
    r"(?:\s+(?P<how>meet|slice))?"
)
_SHARES = {"Min": 0.0, "Mid": 0.5, "Max": 1.0}
_CALL = re.compile(r"[\s,]*(\w+)\s*\(([^()]*)\)\s*")


def product(first: Matrix, second: Matrix) -> Matrix:
    """The map that does `second`, then `first`."""
    (a, b, c), (d, e, f) = first
    (g, h, i), (j, k, m) = second
    return (
        (a * g + b * j, a * h + b * k, a * i + b * m + c),
        (d * g + e * j, d * h + e * k, d * i + e * m + f),
    )


def shift(x: float, y: float) -> Matrix:
    return (1.0, 0.0, x), (0.0, 1.0, y)


def scale(x: float, y: float) -> Matrix:
    return (x, 0.0, 0.0), (0.0, y, 0.0)


def _rotate(angle_deg: float, x: float = 0.0, y: float = 0.0) -> Matrix:
    c, s = unit_vector(angle_deg)
    turn: Matrix = ((c, -s, 0.0), (s, c, 0.0))
    return product(product(shift(x, y), turn), shift(-x, -y))


#: Name to map and the counts of numbers that it takes. Source: SVG 1.1, section 7.6.
_MAPS: dict[str, tuple[Callable[..., Matrix], tuple[int, ...]]] = {
    "matrix": (lambda a, b, c, d, e, f: ((a, c, e), (b, d, f)), (6,)),  # SVG lists the columns
    "translate": (lambda x, y=0.0: shift(x, y), (1, 2)),
    "scale": (lambda x, y=None: scale(x, x if y is None else y), (1, 2)),
    "rotate": (_rotate, (1, 3)),
    "skewX": (lambda a: ((1.0, tan(radians(a)), 0.0), (0.0, 1.0, 0.0)), (1,)),
    "skewY": (lambda a: ((1.0, 0.0, 0.0), (tan(radians(a)), 1.0, 0.0)), (1,)),
}


def parse_transform(text: str) -> Matrix:
    """The map of "translate(1 2) rotate(90)", the last one done first.

    Raises ValueError with what was expected.
    """
    result, position = IDENTITY, 0
    text = text.strip()
    while position < len(text):
        call = _CALL.match(text, position)
        if call is None or call[1] not in _MAPS:
            raise ValueError(f"one of {', '.join(_MAPS)} with numbers in brackets")
        build, counts = _MAPS[call[1]]
        numbers = [float(n) for n in re.split(r"[\s,]+", call[2].strip()) if n]
        if len(numbers) not in counts:
            raise ValueError(f"{' or '.join(map(str, counts))} numbers in {call[1]}()")
        if not all(-MAX_COORDINATE <= number <= MAX_COORDINATE for number in numbers):
            raise ValueError(f"numbers of at most {MAX_COORDINATE:g}")
        result = product(result, build(*numbers))
        position = call.end()
    return result


class ViewBoxFit(NamedTuple):
    """How a viewBox lies in its page. Source: SVG 1.1, section 7.8, preserveAspectRatio."""

    how: Literal["meet", "slice", "none"] = "meet"  #: seen whole, page filled, or stretched
    share_x: float = 0.5  #: of the free space that lies left of the drawing
    share_y: float = 0.5  #: above it
    is_given: bool = False  #: whether the file says it

    def scales(self, across: float, down: float) -> tuple[float, float]:
        """The scales of x and y, of those by width and by height."""
        if self.how == "none":
            return across, down
        one = max(across, down) if self.how == "slice" else min(across, down)
        return one, one


def fit_of(text: str | None) -> ViewBoxFit:
    """What preserveAspectRatio says; xMidYMid meet where it says nothing that is known."""
    match = _ASPECT.fullmatch((text or "").strip())
    if match is None:
        return ViewBoxFit()
    if match["none"]:
        return ViewBoxFit("none", is_given=True)
    how: Literal["meet", "slice"] = "slice" if match["how"] == "slice" else "meet"
    return ViewBoxFit(how, _SHARES[match["x"]], _SHARES[match["y"]], True)


#: CSS fixes the px at 1/96 inch; lengths with units inside a drawing are counted in these.
CSS_PX = MM_PER_UNIT["px96"]

#: Scales by width and by height that differ more than this deny each other. CorelDRAW rounds the
#: viewBox, which was found to cost up to 1e-3.
SCALE_SLACK = 0.01

_PX = ("", "px")
_ABSOLUTE = ("mm", "cm", "in", "pt", "pc", "q")


class ViewBox(NamedTuple):
    """The part of the drawing's plane that the page shows."""

    x: float
    y: float
    width: float
    height: float


class NumberError(ValueError):
    """An attribute that is not a length: its name, what was found and what was expected."""

    def __init__(self, attribute: str, found: str, expected: str) -> None:
        self.attribute, self.found, self.expected = attribute, found, expected
        super().__init__(f"found {attribute}={found!r}, expected {expected}")


def view_box(text: str) -> ViewBox:
    """The numbers of a viewBox. Raises NumberError for anything else."""
    try:
        box = ViewBox(*map(float, re.split(r"[\s,]+", text.strip())))
    except (ValueError, TypeError) as error:
        raise NumberError("viewBox", text, "four numbers") from error
    is_bounded = all(abs(number) <= MAX_COORDINATE for number in box)
    if not (is_bounded and box.width > 0.0 and box.height > 0.0):
        raise NumberError("viewBox", text, "a width and a height above 0")
    return box


class Page(Struct, frozen=True):
    """The map from the drawing's units, y down, to mm from the lower left corner, y up."""

    matrix: Matrix
    unit: float  #: mm in a unit of the drawing, the smaller one if x and y differ
    view: tuple[float, float]  #: width and height that percentages count from, in units
    remarks: tuple[Diagnostic, ...] = ()


class _Size(Struct, frozen=True):
    """One side of the page as the file gives it."""

    text: str
    number: float
    unit: str  #: "" or "px" is no length by itself

    @property
    def mm(self) -> float | None:
        return self.number * MM_PER_UNIT[self.unit] if self.unit in _ABSOLUTE else None


def find_page(document: Document, name: str, units: str | None, width: str | float | None) -> Page:
    """The page of a drawing, from the file or from what the user says.

    `units` names the unit of plain numbers: "px90" that of a px, "mm" that of the drawing.
    `width` is the width of the page. Raises ReadError where nothing says how long a unit is.
    """
    finder = _Finder(document, name)
    if units is not None and units.lower() not in MM_PER_UNIT:
        raise ReadError(UNITS_OPTION.at(Source(name), found=units, expected=", ".join(MM_PER_UNIT)))
    if width is None:
        return finder.by_file() if units is None else finder.by_units(units.lower())
    try:
        number, unit = (width, "mm") if isinstance(width, int | float) else split_length(width)
        mm = number * MM_PER_UNIT[unit or "mm"]
    except (ValueError, KeyError):
        mm = 0.0
    if not 0.0 < mm < inf:
        raise ReadError(WIDTH_OPTION.at(Source(name), found=width))
    return finder.by_width(mm)


class _Finder:
    """The sizes that the root element gives, and the ways to a scale."""

    def __init__(self, document: Document, name: str) -> None:
        self.document = document
        self.source = Source(name, document.root.line)
        style = {key: value for key, value, _ in declarations(document.root.get("style") or "")}
        self.width = self._size("width", style)
        self.height = self._size("height", style)
        self.box: ViewBox | None = None
        if (text := document.root.get("viewBox")) is not None:
            try:
                self.box = view_box(text)
            except NumberError as error:
                raise self._refuse(f"viewBox={text!r}", error.expected) from error
        self.fit = fit_of(document.root.get("preserveAspectRatio"))

    def _refuse(self, found: str, expected: str) -> ReadError:
        return ReadError(rules.SIZE.at(self.source, found=found, expected=expected))

    def _size(self, side: str, style: dict[str, str]) -> _Size | None:
        text = style.get(side) or self.document.root.get(side)
        if text is None or text.strip() in ("", "auto"):
            return None
        try:
            number, unit = split_length(text)
        except ValueError as error:
            raise self._refuse(f"{side}={text!r}", "a number and a unit") from error
        if unit not in (*_PX, *_ABSOLUTE, "%"):
            raise self._refuse(f"{side}={text!r}", f"mm, cm, in, pt, pc, px or none, not {unit!r}")
        if not 0.0 < number < inf:
            raise self._refuse(f"{side}={text!r}", "a length above 0")
        return _Size(text, number, unit)

    def by_width(self, mm: float) -> Page:
        """The page, `mm` wide."""
        if self.box is not None:
            return self._uniform(mm / self.box.width)
        if self.width is None or self.width.unit == "%":
            raise ReadError(rules.NO_SIZE.at(self.source, found="viewBox"))
        return self._uniform(mm / (self.width.mm or self.width.number * CSS_PX) * CSS_PX)

    def by_units(self, units: str) -> Page:
        """The page, where the user says what a plain number is."""
        unit = MM_PER_UNIT[units]
        sides = [side for side in (self.width, self.height) if side is not None]
        if self.box is not None and units.startswith("px"):
            if any(side.mm is not None for side in sides):
                return self.by_file()
            for side, length in ((self.width, self.box.width), (self.height, self.box.height)):
                if side is not None and side.unit in _PX:
                    return self._uniform(side.number * unit / length)
        return self._uniform(unit)

    def by_file(self) -> Page:
        """The page as the file says it."""
        for side in (self.width, self.height):
            if side is not None and side.unit == "%":
                raise ReadError(rules.PERCENT.at(self.source, found=side.text))
        if self.width is None and self.height is None:
            missing = "width and height" if self.box else "width, height and viewBox"
            raise ReadError(rules.NO_SIZE.at(self.source, found=missing))
        sides = [side for side in (self.width, self.height) if side is not None]
        if self.box is None:
            return self._by_pixels("no viewBox", 1.0, 1.0)
        if any(side.mm is None for side in sides):
            if any(side.mm is not None for side in sides):
                both = " and ".join(side.text for side in sides)
                raise self._refuse(f"the size {both}", "one kind of unit for both")
            ratios = self._ratios([side.number for side in sides])
            return self._by_pixels(sides[0].text, *self.fit.scales(ratios[0], ratios[-1]))
        ratios = self._ratios([side.mm or 0.0 for side in sides])
        return self._page(*self.fit.scales(ratios[0], ratios[-1]), CSS_PX)

    def _ratios(self, lengths: list[float]) -> list[float]:
        """Length of a unit by width and by height; one of them where the file has one.

        Raises ReadError if they deny each other, and the file does not say what then.
        """
        assert self.box is not None
        by = [("width", self.box.width), ("height", self.box.height)]
        if len(lengths) == 1:
            by = [by[0] if self.width is not None else by[1]]
        ratios = [length / side for length, (_, side) in zip(lengths, by, strict=True)]
        if not all(1.0 / MAX_COORDINATE <= ratio <= MAX_COORDINATE for ratio in ratios):
            expected = f"between {1.0 / MAX_COORDINATE:g} and {MAX_COORDINATE:g} mm"
            raise self._refuse(f"a unit of {min(ratios):g} mm", expected)
        if len(ratios) == 2 and not self.fit.is_given:
            slack = SCALE_SLACK
            if all(side == round(side) for _, side in by):
                slack += 0.5 / self.box.width + 0.5 / self.box.height  # rounded to whole units
            if abs(ratios[0] / ratios[1] - 1.0) > slack:
                first, second = (f"{ratio:g}" for ratio in ratios)
                names = {"first_by": "width and viewBox", "second_by": "height and viewBox"}
                raise ReadError(
                    rules.CONTRADICT.at(self.source, first=first, second=second, **names)
                )
        return ratios

    def _by_pixels(self, found: str, across: float, down: float) -> Page:
        """The page where a unit is so many px, if something says how long a px is."""
        known = _writer(self.document)
        if known is None:
            raise ReadError(rules.PIXELS.at(self.source, found=found))
        writer, dpi = known
        diagnostic = rules.PIXELS_BY_WRITER.at(self.source, found=found, dpi=dpi, writer=writer)
        px = 25.4 / dpi
        return self._page(across * px, down * px, px, (diagnostic,))

    def _uniform(self, unit: float) -> Page:
        return self._page(unit, unit, None)

    def _page(
        self, sx: float, sy: float, px: float | None, remarks: tuple[Diagnostic, ...] = ()
    ) -> Page:
        """The page of scales `sx` and `sy`, the drawing in its middle, y turned up.

        `px` is the length of a px in mm that the page's own size counts by; with None the page is
        as large as the viewBox, since the user gave the scale. What sticks out of it stays.
        """
        box = self.box
        if box is None:
            view = (self._pixels(self.width), self._pixels(self.height))
            matrix = ((sx, 0.0, 0.0), (0.0, -sy, view[1] * sy))
            return Page(matrix, min(sx, sy), view, remarks)
        width, height = box.width * sx, box.height * sy
        if px is not None:
            width = self._pixels(self.width) * px or width
            height = self._pixels(self.height) * px or height
        left = self.fit.share_x * (width - box.width * sx) - box.x * sx
        top = self.fit.share_y * (height - box.height * sy) - box.y * sy
        matrix = ((sx, 0.0, left), (0.0, -sy, height - top))
        return Page(matrix, min(sx, sy), (box.width, box.height), remarks)

    def _pixels(self, side: _Size | None) -> float:
        """A side of the page in px; 0 if it is not known."""
        if side is None or side.unit == "%":
            return 0.0
        return side.number if side.mm is None else side.mm / CSS_PX


def _writer(document: Document) -> tuple[str, int] | None:
    """The program that wrote a file and how many px it counts to an inch; None if not known."""
    comments = " ".join(document.comments)
    foreign = " ".join(sorted(document.foreign))
    # Other programs that save a drawing again keep the size that its first writer gave it.
    if "CorelDRAW" in comments:
        return "CorelDRAW", 96
    if "Adobe Illustrator" in comments:
        return "Adobe Illustrator", 72
    if match := re.search(r"inkscape:version=(\d{1,9})\.(\d{1,9})", foreign):
        old = (int(match[1]), int(match[2])) < (0, 92)
        return f"Inkscape {match[1]}.{match[2]}", 90 if old else 96
    by_corel = any(identity.startswith("CorelCorpID") for identity in document.ids)
    return ("CorelDRAW", 96) if by_corel or "corel.com/coreldraw" in foreign else None
