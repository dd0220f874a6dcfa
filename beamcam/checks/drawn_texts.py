"""Texts found in the strokes of a program.

A text is found by its longest straight piece: each piece that was drawn in that direction says
where the text would stand and how high, and all its other pieces have to be there too. A dash may
be a text, or belong to a longer one: those places count that leave the fewest pieces without a
text.
"""

from collections.abc import Iterable, Iterator, Sequence
from itertools import islice, pairwise, product
from math import cos, dist, radians, sin
from typing import TYPE_CHECKING

import numpy as np
from msgspec import Struct

from beamcam.geometry.array_types import Floats
from beamcam.geometry.lettering import body_share, glyph_of, spelled, spelled_with
from beamcam.geometry.plane import Point
from beamcam.machine.stations import Marks
from beamcam.model.part import MIRRORED_FACES, TextMark

if TYPE_CHECKING:
    from numpy.typing import NDArray

Segment = tuple[Point, Point]


class RequiredText(Struct, frozen=True):
    """A required text."""

    feature: TextMark
    text: str  #: as the font spells it
    height: float  #: of a capital
    pieces: tuple[Segment, ...]  #: of height 1, from where it begins, turned as it stands
    counts: tuple[int, ...] = ()  #: pieces of each stroke, one stroke behind the other

    def at(self, x: float, y: float, height: float) -> tuple[Segment, ...]:
        """Its pieces at a place."""
        return tuple(placed(piece, x, y, height) for piece in self.pieces)

    def strokes(self, x: float, y: float, height: float) -> Iterator[tuple[Segment, ...]]:
        """The pieces of each of its strokes at a place."""
        pieces = iter(self.at(x, y, height))
        return (tuple(islice(pieces, count)) for count in self.counts)


def text_to_letter(feature: TextMark, marks: Marks) -> RequiredText:
    """The strokes that a text requires."""
    text = spelled(feature.text, marks.replace).text
    share = body_share() if marks.height_of == "body" else 1.0
    pieces: list[Segment] = []  # along a line, letter behind letter
    counts: list[int] = []
    begin = 0.0
    for sign in text:
        glyph = glyph_of(sign)
        if glyph is None:
            raise AssertionError(f"the font has no {sign!r}")
        pieces += [((begin + a, b), (begin + c, d)) for (a, b), (c, d) in glyph.segments]
        counts += [len(stroke) - 1 for stroke in glyph.strokes]
        begin += marks.spacing * glyph.advance
    turned = tuple(_turned(pieces, feature))
    return RequiredText(feature, text, feature.height * share, turned, tuple(counts))


def text_to_print(feature: TextMark, marks: Marks) -> RequiredText | None:
    """A text as a stamp or printer letters it, in the box of its characters.

    None where it has no characters, no angle or no height for it.
    """
    spelling = spelled_with(feature.text, marks.replace, marks.characters)
    turns = [abs(angle - feature.angle) % 360.0 for angle in marks.angles]
    if spelling is None or not spelling.text.strip() or not any(t in (0.0, 360.0) for t in turns):
        return None
    height = feature.height
    if marks.heights:
        apart = [(abs(own - height), own) for own in marks.heights]
        if feature.option == "z" and min(apart)[0] > 0.0:
            return None
        height = min(apart)[1]
    elif height < marks.min_height:
        return None
    wide = len(spelling.text) * marks.pitch
    corners = ((0.0, 0.0), (wide, 0.0), (wide, 1.0), (0.0, 1.0), (0.0, 0.0))
    pieces = tuple(_turned(pairwise(corners), feature))
    return RequiredText(feature, spelling.text, height, pieces)


def _turned(pieces: Iterable[Segment], feature: TextMark) -> Iterator[Segment]:
    """Pieces turned to the angle of a text; on faces that are seen mirrored they are mirrored."""
    up = -1.0 if feature.face in MIRRORED_FACES else 1.0
    c, s = cos(radians(feature.angle)), sin(radians(feature.angle))

    def turn(p: Point) -> Point:
        return p[0] * c - up * p[1] * s, p[0] * s + up * p[1] * c

    for a, b in pieces:
        yield turn(a), turn(b)


def placed(piece: Segment, x: float, y: float, height: float) -> Segment:
    """A piece of height 1 at a place."""
    (a, b), (c, d) = piece
    return (x + height * a, y + height * b), (x + height * c, y + height * d)


NEAR = 0.03  #: mm that the ends of a piece may be from where the font has them
MOST_OFF = 0.9  #: mm that a piece may be from where the anchor alone has it
EXACT = 0.02  #: mm within which a text stands where the part has it
#: Ways to share out pieces that are tried; where more would have to be, the best of these counts.
MOST_BRANCHES = 20_000
RATIO = 0.02  #: sine of the angle between a piece and its like in the font


class DrawnText(Struct, frozen=True):
    """A text that a program draws."""

    x: float
    y: float
    height: float  #: of a capital
    taken: tuple[int, ...] = ()  #: of the drawn pieces, by their numbers


class DrawnPieces:
    """The straight pieces that a program draws."""

    def __init__(self, pieces: Sequence[Segment], near: float = NEAR) -> None:
        self.pieces, self.near = pieces, near
        self._ends: Floats = np.array(pieces, dtype=np.float64).reshape(-1, 2, 2)
        self._by_middle: dict[tuple[int, int], list[int]] = {}
        for k, (a, b) in enumerate(pieces):
            self._by_middle.setdefault(self._cell(_middle(a, b)), []).append(k)
        cells = np.array([*self._by_middle], dtype=np.int64).reshape(-1, 2)
        around = [*product((-1, 0, 1), (-1, 0, 1))]
        self._near_pieces = np.unique(_number((cells[:, None] + around).reshape(-1, 2)))

    @staticmethod
    def _cell(p: Point) -> tuple[int, int]:
        return round(p[0]), round(p[1])

    def like(self, a: Point, b: Point, near: float) -> int | None:
        """The piece nearest to one between two points, whichever way round; None if none is."""
        x, y = self._cell(_middle(a, b))
        best, apart = None, near
        for i, j in product((-1, 0, 1), (-1, 0, 1)):
            for k in self._by_middle.get((x + i, y + j), ()):
                if (away := _ends_apart(self.pieces[k], a, b)) <= apart:
                    best, apart = k, away
        return best

    def all_of(
        self, text: RequiredText, min_height: float, max_height: float
    ) -> Iterator[DrawnText]:
        """Each place where all pieces of a text are drawn, in heights between two."""
        if not text.pieces or not self.pieces:
            return
        anchor = max(text.pieces, key=lambda piece: dist(*piece))
        places = self._by_direction(anchor)
        high = places[:, 2]
        places = places[(high >= min_height - EXACT) & (high <= max_height + EXACT)]
        for a, b in text.pieces:
            if not len(places):
                return
            at = places[:, :2] + places[:, 2:] * _middle(a, b)
            cells = _number(np.rint(at).astype(np.int64))
            k = np.searchsorted(self._near_pieces, cells) % len(self._near_pieces)
            places = places[self._near_pieces[k] == cells]
        for x, y, height in places.tolist():
            if (drawn := self._all(text, x, y, height, anchor)) is not None:
                yield drawn

    def _by_direction(self, anchor: Segment) -> Floats:
        """Where texts of one shape would stand, by the pieces that may be their longest: x, y and
        height (n, 3)."""
        (ax, ay), (bx, by) = anchor
        ux, uy, own = bx - ax, by - ay, dist(*anchor)
        both = np.concatenate((self._ends, self._ends[:, ::-1])).reshape(2, -1, 2, 2)
        ends = both.swapaxes(0, 1).reshape(-1, 2, 2)  # each piece both ways round
        (vx, vy), (x, y) = (ends[:, 1] - ends[:, 0]).T, ends[:, 0].T
        length = np.hypot(vx, vy)
        like = (
            (length > 0.0)
            & (ux * vx + uy * vy > 0.0)
            & (abs(ux * vy - uy * vx) <= RATIO * length * own)
        )
        height = length[like] / own
        return np.column_stack((x[like] - height * ax, y[like] - height * ay, height))

    def _all(
        self, text: RequiredText, x: float, y: float, height: float, anchor: Segment
    ) -> DrawnText | None:
        """The text at a place, if all its pieces are drawn there.

        The place follows from one piece, so that others may be off by more the further they are;
        where all of them together have it they have to be near.
        """
        begin = _middle(*anchor)
        share = 2 * self.near / dist(*anchor)
        taken = []
        for unit in text.pieces:
            a, b = placed(unit, x, y, height)
            slack = self.near + share * dist(begin, _middle(*unit))
            k = self.like(a, b, min(slack, MOST_OFF))
            if k is None:
                return None
            taken.append(k)
        x, y, height = self._fitted(text, taken, (x, y, height))
        for k, (a, b) in zip(taken, text.at(x, y, height), strict=True):
            if _ends_apart(self.pieces[k], a, b) > self.near:
                return None
        return DrawnText(x, y, height, tuple(taken))

    def _fitted(
        self, text: RequiredText, taken: Sequence[int], near: tuple[float, float, float]
    ) -> tuple[float, float, float]:
        """Place and height that fit all pieces best (least squares of a shift and a scale)."""
        pairs: list[tuple[Point, Point]] = []
        for unit, (a, b), k in zip(text.pieces, text.at(*near), taken, strict=True):
            p, q = self.pieces[k]
            if dist(p, a) + dist(q, b) > dist(q, a) + dist(p, b):
                p, q = q, p
            pairs += [(unit[0], p), (unit[1], q)]
        n = len(pairs)
        ux, uy = sum(u[0] for u, _ in pairs) / n, sum(u[1] for u, _ in pairs) / n
        px, py = sum(p[0] for _, p in pairs) / n, sum(p[1] for _, p in pairs) / n
        up = sum((u[0] - ux) * (p[0] - px) + (u[1] - uy) * (p[1] - py) for u, p in pairs)
        uu = sum((u[0] - ux) ** 2 + (u[1] - uy) ** 2 for u, _ in pairs)
        height = up / uu
        return px - height * ux, py - height * uy, height


def _number(cells: "NDArray[np.int64]") -> "NDArray[np.int64]":
    """A number of its own for each cell of a drawing."""
    return cells[:, 0] * 2**31 + cells[:, 1]


def is_in_place(text: RequiredText, drawn: DrawnText) -> bool:
    """Whether a text stands where the part has it, in its height."""
    apart = (drawn.x - text.feature.x, drawn.y - text.feature.y, drawn.height - text.height)
    return max(map(abs, apart)) <= EXACT


def covering(places: Sequence[frozenset[int]]) -> list[frozenset[int]]:
    """Of some sets of pieces those that are disjoint and leave the fewest pieces out."""
    of: dict[int, list[int]] = {}
    for k, place in enumerate(places):
        for piece in place:
            of.setdefault(piece, []).append(k)
    chosen: list[frozenset[int]] = []
    left = dict.fromkeys(range(len(places)))
    while left:
        group = [left.popitem()[0]]  # sets that meet one another by the pieces that they share
        for k in group:
            more = [j for piece in places[k] for j in of.pop(piece, ()) if j in left]
            for j in dict.fromkeys(more):
                del left[j]
                group.append(j)
        together = [places[k] for k in group]
        chosen += _covering(sorted(together, key=lambda place: (-len(place), min(place))))
    return chosen


def _covering(places: Sequence[frozenset[int]]) -> list[frozenset[int]]:
    """The same of sets that meet one another, the largest first (branch and bound)."""
    bits = {piece: 1 << k for k, piece in enumerate(frozenset().union(*places))}
    masks = [sum(bits[piece] for piece in place) for place in places]
    rest = [0]  # the pieces of a set and those behind it
    for mask in reversed(masks):
        rest.append(rest[-1] | mask)
    rest.reverse()
    best: tuple[int, ...] = ()
    most = -1
    todo: list[tuple[int, int, tuple[int, ...]]] = [(0, 0, ())]
    for _ in range(MOST_BRANCHES):
        if not todo:
            break
        k, taken, chosen = todo.pop()
        if (count := taken.bit_count()) > most:
            best, most = chosen, count
        if k == len(masks) or (taken | rest[k]).bit_count() <= most:
            continue
        todo.append((k + 1, taken, chosen))
        if not taken & masks[k]:
            todo.append((k + 1, taken | masks[k], (*chosen, k)))
    return [places[k] for k in best]


def _middle(a: Point, b: Point) -> Point:
    return (a[0] + b[0]) / 2, (a[1] + b[1]) / 2


def _ends_apart(piece: Segment, a: Point, b: Point) -> float:
    """How far the ends of a piece are from two points, in the better order."""
    p, q = piece
    return min(max(dist(p, a), dist(q, b)), max(dist(p, b), dist(q, a)))
