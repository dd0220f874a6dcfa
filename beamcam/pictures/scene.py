"""A picture as data: shapes, their positions on the paper, and their styles.

Paper coordinates are pixels of 1/96 inch, x to the right and y down. The first class of a shape
names its style (`styles`); all of them stand in the SVG, where tests and pages find them.
"""

from collections.abc import Sequence
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
    tip: str = ""  #: what it is, for whoever points at it
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


class Frame(Struct, frozen=True):
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


def said(pieces: Pieces, unit: Unit = "mm") -> str:
    """A text with the lengths among its words in a unit."""
    return "".join([one if isinstance(one, str) else shown(one, unit) for one in pieces])
