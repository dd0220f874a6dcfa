"""Texts found in the strokes of a program, and checked for position.

A text is found by its longest straight piece: each piece that was drawn in that direction says
where the text would stand and how high, and all its other pieces have to be there too. Where it may
stand follows from the steel and the machine file; nothing is known of where it was planned.
"""

from collections.abc import Iterator, Sequence
from itertools import pairwise
from math import hypot
from typing import TYPE_CHECKING

import numpy as np
from msgspec import Struct, field

from beamcam.errors import Diagnostic, Rule, Severity
from beamcam.geometry.array_types import Floats
from beamcam.geometry.plane import Point
from beamcam.machine.marking import Marks
from beamcam.model.part import MIRRORED_FACES
from beamcam.verify.by_hand import TEXT_MOVED
from beamcam.verify.wanted_texts import Segment, Wanted, placed

if TYPE_CHECKING:
    from numpy.typing import NDArray
    from shapely import Geometry, Polygon

TEXT = Rule(
    "verify-text",
    Severity.ERROR,
    "found the text {text!r} at x {x}, y {y}, {height} mm high; expected {expected}",
    "A text stands where the part has it, or where it is clear of holes, edges and other texts.",
)
TEXT_MISSING = Rule(
    "verify-text-missing",
    Severity.ERROR,
    "found no text {text!r} on face {face} of {mark} at {angle} degrees; "
    "expected it at x {x}, y {y}",
    "A text that the machine's stamp or printer could letter has to be in the program, character "
    "by character.",
)
TEXT_EXTRA = Rule(
    "verify-text-extra",
    Severity.ERROR,
    "found the text {text!r} on face {face} at machine x {x}, y {y}; "
    "expected none, no part has it there",
    "What is stamped or printed cannot be taken off again.",
)
RULES = (TEXT, TEXT_MISSING, TEXT_EXTRA)


NEAR = 0.03  #: mm that the ends of a piece may be from where the font has them
MOST_OFF = 0.9  #: mm that a piece may be from where the anchor alone has it
EXACT = 0.02  #: mm within which a text stands where the part has it
SURE = 0.15  #: mm by which a place is more than clear, or a room wide enough
RATIO = 0.02  #: sine of the angle between a piece and its like in the font


class Found(Struct, frozen=True):
    """A text that a program draws."""

    x: float
    y: float
    height: float  #: of a capital
    pieces: tuple[Segment, ...]  #: as the font has them there
    taken: tuple[int, ...]  #: of the drawn pieces, by their numbers


class Steel(Struct, frozen=True):
    """Steel on a face, and obstacles for letters."""

    edges: "Geometry"  #: of the steel and its holes
    pieces: Floats  #: the same as straight pieces, (n, 2, 2)

    def holds(self, box: "Polygon") -> bool:
        """Whether steel lies under a box that no edge passes.

        Around steel lies an odd number of edges: most rays from the box cross so many, whatever
        gap between two curves one of them may slip through.
        """
        x, y = box.centroid.x, box.centroid.y
        places = [(x, y), *box.exterior.coords[:4]]
        return sum(map(self._is_in, places)) * 2 > len(places)

    def _is_in(self, place: Point) -> bool:
        a, b = self.pieces[:, 0], self.pieces[:, 1]
        passed = (a[:, 1] > place[1]) != (b[:, 1] > place[1])
        a, b = a[passed], b[passed]
        at = a[:, 0] + (place[1] - a[:, 1]) * (b[:, 0] - a[:, 0]) / (b[:, 1] - a[:, 1])
        return int((at > place[0]).sum()) % 2 == 1


def steel_within(pieces: Sequence[Segment]) -> Steel:
    """The steel that edges lie around, given as straight pieces in any order."""
    import shapely

    ends = np.array(pieces, dtype=np.float64)
    return Steel(shapely.multilinestrings(shapely.linestrings(ends)), ends)


class _Places(Struct, frozen=True):
    """Where texts of one shape would stand, by the pieces that may be their longest."""

    piece: "NDArray[np.int64]"
    x: Floats
    y: Floats
    height: Floats
    without: set[int] = field(default_factory=set)  #: where other pieces are missing


class Drawn:
    """The straight pieces that a program draws, of which texts take theirs."""

    def __init__(self, pieces: Sequence[Segment], near: float = NEAR) -> None:
        self.pieces, self.near = pieces, near
        self.free = set(range(len(pieces)))
        self._ends: Floats = np.array(pieces, dtype=np.float64).reshape(-1, 2, 2)
        self._known: dict[tuple[Segment, ...], _Places] = {}  #: by the shape of a text
        self._by_middle: dict[tuple[int, int], list[int]] = {}
        for k, (a, b) in enumerate(pieces):
            self._by_middle.setdefault(self._cell(_middle(a, b)), []).append(k)

    @staticmethod
    def _cell(p: Point) -> tuple[int, int]:
        return round(p[0]), round(p[1])

    def like(self, a: Point, b: Point, near: float) -> int | None:
        """The piece nearest to one between two points, whichever way round; None if none is."""
        x, y = self._cell(_middle(a, b))
        best, apart = None, near
        for cell in ((x + i, y + j) for i in (-1, 0, 1) for j in (-1, 0, 1)):
            for k in self._by_middle.get(cell, ()):
                if k in self.free and (away := _piece_apart(self.pieces[k], a, b)) <= apart:
                    best, apart = k, away
        return best

    def find(self, text: Wanted, marks: Marks) -> Found | None:
        """The text, nearest to where the part has it; its pieces are taken."""
        if not text.pieces:
            return None
        anchor = max(text.pieces, key=_length)
        places = self._places(text, anchor)
        away = np.hypot(places.x - text.feature.x, places.y - text.feature.y)
        is_high = (places.height >= marks.min_height - EXACT) & (
            places.height <= text.height + EXACT
        )
        order = np.lexsort((text.height - places.height, away))
        for c in order[is_high[order]].tolist():
            place = float(places.x[c]), float(places.y[c]), float(places.height[c])
            if places.piece[c] in self.free and c not in places.without:
                found = self._all(text, *place, anchor)
                if found is not None:
                    self.free -= {*found.taken}
                    return found
                places.without.add(c)
        return None

    def _places(self, text: Wanted, anchor: Segment) -> "_Places":
        """Where a text would stand by each piece that points as its longest one does."""
        if text.pieces not in self._known:
            self._known[text.pieces] = self._by_direction(anchor)
        return self._known[text.pieces]

    def _by_direction(self, anchor: Segment) -> "_Places":
        (ax, ay), (bx, by) = anchor
        ux, uy, own = bx - ax, by - ay, _length(anchor)
        both = np.concatenate((self._ends, self._ends[:, ::-1])).reshape(2, -1, 2, 2)
        ends = both.swapaxes(0, 1).reshape(-1, 2, 2)  # each piece both ways round
        (vx, vy), (x, y) = (ends[:, 1] - ends[:, 0]).T, ends[:, 0].T
        length = np.hypot(vx, vy)
        like = (
            (length > 0.0)
            & (ux * vx + uy * vy > 0.0)
            & (abs(ux * vy - uy * vx) <= RATIO * length * own)
        )
        height, piece = length[like] / own, np.flatnonzero(like) // 2
        return _Places(piece, x[like] - height * ax, y[like] - height * ay, height)

    def _all(
        self, text: Wanted, x: float, y: float, height: float, anchor: Segment
    ) -> Found | None:
        """The text at a place, if all its pieces are drawn there.

        The place follows from one piece, so that others may be off by more the further they are;
        where all of them together have it they have to be near.
        """
        begin = _middle(*anchor)
        share = 2 * self.near / _length(anchor)
        taken = []
        for unit in text.pieces:
            a, b = placed(unit, x, y, height)
            slack = self.near + share * _apart(begin, _middle(*unit))
            k = self.like(a, b, min(slack, MOST_OFF))
            if k is None:
                return None
            taken.append(k)
        x, y, height = self._fitted(text, taken, (x, y, height))
        pieces = text.at(x, y, height)
        for k, (a, b) in zip(taken, pieces, strict=True):
            if _piece_apart(self.pieces[k], a, b) > self.near:
                return None
        return Found(x, y, height, pieces, tuple(taken))

    def _fitted(
        self, text: Wanted, taken: Sequence[int], near: tuple[float, float, float]
    ) -> tuple[float, float, float]:
        """Place and height that fit all pieces best (least squares of a shift and a scale)."""
        pairs: list[tuple[Point, Point]] = []
        for unit, (a, b), k in zip(text.pieces, text.at(*near), taken, strict=True):
            p, q = self.pieces[k]
            if _apart(p, a) + _apart(q, b) > _apart(q, a) + _apart(p, b):
                p, q = q, p
            pairs += [(unit[0], p), (unit[1], q)]
        n = len(pairs)
        ux, uy = sum(u[0] for u, _ in pairs) / n, sum(u[1] for u, _ in pairs) / n
        px, py = sum(p[0] for _, p in pairs) / n, sum(p[1] for _, p in pairs) / n
        up = sum((u[0] - ux) * (p[0] - px) + (u[1] - uy) * (p[1] - py) for u, p in pairs)
        uu = sum((u[0] - ux) ** 2 + (u[1] - uy) ** 2 for u, _ in pairs)
        height = up / uu
        return px - height * ux, py - height * uy, height


def _middle(a: Point, b: Point) -> Point:
    return (a[0] + b[0]) / 2, (a[1] + b[1]) / 2


def _apart(a: Point, b: Point) -> float:
    return hypot(a[0] - b[0], a[1] - b[1])


def _piece_apart(piece: Segment, a: Point, b: Point) -> float:
    """How far the ends of a piece are from two points, in the better order."""
    p, q = piece
    return min(max(_apart(p, a), _apart(q, b)), max(_apart(p, b), _apart(q, a)))


def _length(piece: Segment) -> float:
    return _apart(*piece)


def box_of(text: Wanted, x: float, y: float, height: float) -> "Polygon":
    """The box around a text along its line."""
    import shapely
    from shapely.affinity import rotate

    turned = shapely.MultiLineString([[a, b] for a, b in text.at(x, y, height)])
    angle = text.feature.angle
    level = rotate(turned, -angle, origin=(x, y))
    return rotate(shapely.box(*level.bounds), angle, origin=(x, y))


def is_clear(
    box: "Polygon", steel: Steel, others: Sequence["Polygon"], distance: float, gap: float = 0.0
) -> bool:
    """Whether a text's box lies in the steel, so far from its edges and beside other texts."""
    import shapely

    return (
        steel.edges.distance(box) >= max(distance, 1e-9)
        and steel.holds(box)
        and not (shapely.distance(box, others) <= gap).any()
    )


def judge(
    text: Wanted, found: Found, steel: Steel, others: Sequence["Polygon"], marks: Marks,
    sure: Steel | None = None,
) -> Iterator[Diagnostic]:  # fmt: skip
    """What is wrong with the place of a text, or that it is another than the part's.

    `sure` is the steel to which what letters comes for sure, where that is not all of it.
    """
    feature = text.feature
    box = box_of(text, found.x, found.y, found.height)
    said = {
        "text": text.text, "x": f"{found.x:.1f}", "y": f"{found.y:.1f}",
        "height": f"{found.height:.1f}",
    }  # fmt: skip
    exact = (
        abs(found.x - feature.x) <= EXACT
        and abs(found.y - feature.y) <= EXACT
        and abs(found.height - text.height) <= EXACT
    )
    if not is_clear(box, steel, others, marks.min_distance - EXACT):
        expected = f"it {marks.min_distance:g} mm clear of edges and holes, beside other texts"
        yield TEXT.at(feature.source, expected=expected, **said)
    elif exact:
        return
    elif feature.option == "z" or is_surely_clear(text, sure or steel, others, marks):
        expected = f"it at x {feature.x:g}, y {feature.y:g}, {text.height:g} mm high"
        yield TEXT.at(feature.source, expected=expected, **said)
    else:
        yield TEXT_MOVED.at(
            feature.source, wanted_x=f"{feature.x:g}", wanted_y=f"{feature.y:g}",
            wanted_height=f"{text.height:g}", **said,
        )  # fmt: skip


def is_surely_clear(text: Wanted, steel: Steel, others: Sequence["Polygon"], marks: Marks) -> bool:
    feature = text.feature
    box = box_of(text, feature.x, feature.y, text.height)
    return is_clear(box, steel, others, marks.min_distance + SURE, SURE)


class Places:
    """Where on a face texts that were not drawn might have been, between those that were."""

    def __init__(self, steel: Steel, others: Sequence["Polygon"], marks: Marks) -> None:
        self._face = steel, others, marks
        self._rooms: dict[object, bool] = {}  #: for texts of one shape the answer is the same

    def has(self, text: Wanted) -> bool:
        """Whether a text might have been drawn: where the part has it, or elsewhere."""
        marks = self._face[2]
        if not text.pieces or text.height < marks.min_height:
            return False
        if is_surely_clear(text, *self._face):
            return True
        if text.feature.option == "z":
            return False
        shape = text.text, text.feature.angle, text.feature.face in MIRRORED_FACES
        if shape not in self._rooms:
            self._rooms[shape] = _has_room(text, *self._face)
        return self._rooms[shape]


def _has_room(text: Wanted, steel: Steel, others: Sequence["Polygon"], marks: Marks) -> bool:
    """Whether there is room for the smallest box of a text, with something to spare.

    The middle of a box that is clear lies in the steel, and outside of what the box sweeps when it
    is led along all edges (their Minkowski sum).
    """
    import shapely
    from shapely.affinity import translate

    box = box_of(text, 0.0, 0.0, marks.min_height)
    low_x, low_y, high_x, high_y = box.bounds
    centred = translate(box, -(low_x + high_x) / 2, -(low_y + high_y) / 2)
    grown = centred.buffer(marks.min_distance + SURE, quad_segs=4)
    sides = [np.array([*pairwise(other.exterior.coords)]) for other in others]
    walls = np.concatenate((steel.pieces, *sides))
    corners = walls[:, :, None, :] + shapely.get_coordinates(grown)
    swept = shapely.convex_hull(shapely.linestrings(corners.reshape(len(walls), -1, 2)))
    around = shapely.box(*steel.edges.bounds)
    middles = around.difference(shapely.union_all([*swept, *others])).buffer(-0.5)
    parts = [part for part in shapely.get_parts(middles) if not part.is_empty]
    places = (part.representative_point() for part in parts)
    return any(steel.holds(translate(centred, p.x, p.y)) for p in places)
