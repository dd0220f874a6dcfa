"""Places for small texts beside what they name, so that none lies over another."""

from collections.abc import Callable, Iterator
from itertools import product
from math import ceil, dist

from beamcam.pictures.scene import Point

Box = tuple[float, float, float, float]

#: Ways to go from a place: up to the right first, where a reader looks for a number.
SIDES = ((1, -1), (-1, -1), (1, 1), (-1, 1), (0, -1), (0, 1))
CENTRE = ((0, 0),)
LEVEL = ((1, 0), (-1, 0))
CELL = 16.0  #: pixels of the squares by which neighbours are found
LINE_STEP = 3.0  #: pixels between the boxes that stand for a line
LETTER = 0.6  #: width of a letter, in sizes of the text
CAPITAL = 0.72  #: height of a capital


class Labels:
    """What lies on a paper already, and room for more texts."""

    def __init__(self) -> None:
        self._cells: dict[tuple[int, int], list[Box]] = {}

    def block(self, box: Box) -> None:
        """Nothing is to lie over this box."""
        for cell in _cells(box):
            self._cells.setdefault(cell, []).append(box)

    def block_line(self, a: Point, b: Point) -> None:
        """Nothing is to lie over the line between two points."""
        count = max(1, ceil(dist(a, b) / LINE_STEP))
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
                if suits(box) and self._is_free(box):
                    self.block(box)
                    return x, y
        return None

    def _is_free(self, box: Box) -> bool:
        near = (other for cell in _cells(box) for other in self._cells.get(cell, ()))
        return not any(_overlap(box, other) for other in near)


def _cells(box: Box) -> Iterator[tuple[int, int]]:
    x0, y0, x1, y1 = (int(v // CELL) for v in box)
    return product(range(x0, x1 + 1), range(y0, y1 + 1))


def is_in(a: Box, b: Box) -> bool:
    """Whether a box lies in another."""
    return b[0] <= a[0] and b[1] <= a[1] and a[2] <= b[2] and a[3] <= b[3]


def _overlap(a: Box, b: Box) -> bool:
    return a[0] < b[2] and b[0] < a[2] and a[1] < b[3] and b[1] < a[3]
