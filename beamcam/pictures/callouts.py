"""Sizes said beside what has them, as on a drawing: `4 × Ø18`, `slot 34 × 18, 30°`, `R20`.

A  4 × Ø18   B  2 × M16, 20 deep     above a narrow face, each on its leader, in rows;
|            |                       on a face with room beside the hole itself
o  oA        o   oB    oA  oA        letters where a part has holes of several sizes: the same
                                     letter is the same size on all of its faces
"""

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from math import dist, hypot
from typing import Literal

import numpy as np
from msgspec import Struct
from msgspec.structs import replace
from numpy.typing import NDArray

from beamcam.geometry.curves import Arc, Curve, Line, circle_of
from beamcam.model.part import Bend, Camber, Contour, EndPlane, Feature, Hole, Slot, TextMark
from beamcam.pictures.scene import (
    CAPITAL,
    LETTER,
    Box,
    Labels,
    Pieces,
    Point,
    Polyline,
    Shape,
    Text,
    Unit,
    as_text,
    is_in,
)
from beamcam.pictures.views import WIDTH, View, laid_out

SIZE = 10.0  #: of a callout's letters
ROW = 13.0  #: from row to row above a face
LETTER_SIZES = (8.0, 6.0)  #: of the letter beside a hole
CLEAR = 2.0  #: pixels that a letter is nearer to its own hole than to another
MAX_CURVES = 16  #: of a contour whose radii are shown
MAX_SIZES = 24  #: different sizes on a face that are shown; a drawing may have hundreds
ROOM = 70.0  #: pixels that a face is high at least that has callouts on it
THREADS = {"thread": "", "left-thread": " left"}


class SizePlace(Struct, frozen=True):
    """Where a size is found on a face, and how far its edge is from there; mm."""

    at: Point
    radius: float = 0.0
    is_open: bool = False  #: whether there is room within it, as in a cut-out


class FaceSize(Struct, frozen=True):
    """A size, and all places of a face that have it."""

    words: Pieces
    places: tuple[SizePlace, ...]
    is_hole: bool  #: or a slot or a cut-out


def sizes_on(features: Iterable[Feature]) -> list[FaceSize]:
    """The sizes of the features of a face, holes first, each with its places."""
    sizes: dict[tuple[Pieces, bool], list[SizePlace]] = {}
    for feature in features:
        for words, place, is_hole in _sizes(feature):
            sizes.setdefault((words, is_hole), []).append(place)
    rows = [FaceSize(words, tuple(places), is_hole) for (words, is_hole), places in sizes.items()]
    return sorted(rows, key=lambda size: (not size.is_hole, size.places[0].is_open))


def _sizes(feature: Feature) -> Iterator[tuple[Pieces, SizePlace, bool]]:
    match feature:
        case Hole():
            place = SizePlace((feature.x, feature.y), feature.diameter / 2)
            yield hole_words(feature), place, True
        case Slot():
            radius = min(feature.height, feature.length) / 2 + feature.diameter / 2
            yield slot_words(feature), SizePlace((feature.x, feature.y), radius), True
        case Contour() if feature.process == "cut":
            yield from _contour_sizes(feature)
        case TextMark():
            words = ("text ", feature.height, " high")
            yield words, SizePlace((feature.x, feature.y + feature.height)), False
        case Bend():
            (x0, y0), (x1, y1) = feature.start, feature.end
            radius_said: Pieces = () if feature.radius is None else (", R", feature.radius)
            middle = SizePlace(((x0 + x1) / 2, (y0 + y1) / 2))
            yield (f"bend {_degrees(feature.angle)}", *radius_said), middle, False
        case Camber():
            yield ("camber ", feature.y), SizePlace((feature.x, feature.y)), False
        case EndPlane() | Contour():
            return


def hole_words(hole: Hole) -> Pieces:
    """The size of a hole as a drawing says it."""
    depth: Pieces = () if hole.depth is None else (", ", hole.depth, " deep")
    if hole.kind == "mark" or not hole.diameter:
        return ("centre point",)
    if hole.kind in THREADS:
        return (f"M{hole.diameter:g}{THREADS[hole.kind]}", *depth)
    if hole.kind == "countersink" and hole.angle is not None:
        return ("sink Ø", hole.diameter, f" × {_degrees(hole.angle)}", *depth)
    return ("flat sink Ø" if hole.kind == "countersink" else "Ø", hole.diameter, *depth)


def slot_words(slot: Slot) -> Pieces:
    """Length and width of a slot over all, its angle, and the radius of a rectangle's corners."""
    long, high = slot.length + slot.diameter, slot.height + slot.diameter
    words: Pieces = ("slot " if not slot.height else "cut-out ", long, " × ", high)
    if slot.height:
        words = (*words, ", R", slot.diameter / 2)
    angle = (slot.angle + 90.0) % 180.0 - 90.0  # a slot looks the same turned half round
    if angle:
        words = (*words, f", {_degrees(angle)}")
    return words if slot.depth is None else (*words, ", ", slot.depth, " deep")


def _contour_sizes(contour: Contour) -> Iterator[tuple[Pieces, SizePlace, bool]]:
    curves = contour.curves
    circle = circle_of(curves)
    if circle is not None:
        (x, y), radius = circle
        yield ("Ø", round(2 * radius, 3)), SizePlace((x, y), radius), contour.kind == "inner"
        return
    if contour.kind == "inner" and contour.closed:
        boxes = [curve.bbox for curve in curves]
        x0, y0 = (min(box[k] for box in boxes) for k in (0, 1))
        x1, y1 = (max(box[k] for box in boxes) for k in (2, 3))
        lines = [curve for curve in curves if isinstance(curve, Line)]
        arcs = [curve for curve in curves if isinstance(curve, Arc)]
        # All straight edges run along x or y, four of them, and the corners are round.
        is_rectangle = (
            len(lines) == 4
            and len(lines) + len(arcs) == len(curves)
            and all(min(map(abs, np.subtract(a.start, a.end))) < 1e-6 for a in lines)
            and all(abs(abs(arc.sweep_deg) - 90.0) < 1e-6 for arc in arcs)
        )
        words = "cut-out " if is_rectangle else "cut-out within "
        middle = SizePlace(((x0 + x1) / 2, (y0 + y1) / 2), (y1 - y0) / 2, True)
        yield (words, round(x1 - x0, 3), " × ", round(y1 - y0, 3)), middle, True
    if len(curves) <= MAX_CURVES:
        for curve in curves:
            if isinstance(curve, Arc):
                yield ("R", round(curve.radius, 3)), SizePlace(_middle(curve)), False
    for bevel in contour.bevels:
        words_of: Pieces = (f"bevel {_degrees(abs(bevel.angle))}",)
        if bevel.angle < 0:  # whose land is what lies above it
            deep: Pieces = (", ", bevel.land, " deep") if bevel.land else ()
            words_of = (*words_of, " of the far side", *deep)
        elif bevel.land:
            words_of = (*words_of, ", land ", bevel.land)
        yield words_of, SizePlace(_middle(curves[bevel.curve])), False


def _middle(curve: Curve) -> Point:
    x, y = curve.point(0.5)
    return x, y


def _degrees(angle: float) -> str:
    return f"{round(angle, 2):g}\N{DEGREE SIGN}"


def size_letters(faces: Iterable[Sequence[FaceSize]]) -> dict[Pieces, str]:
    """A letter for each size that several holes have; none where all holes have one size."""
    counts: dict[Pieces, int] = {}
    for size in (s for sizes in faces for s in sizes if s.is_hole):
        counts[size.words] = counts.get(size.words, 0) + len(size.places)
    if len(counts) < 2:
        return {}
    several = [words for words, count in counts.items() if count > 1]
    return {words: _letter(k) for k, words in enumerate(several)}


def _letter(number: int) -> str:
    """A to Z without I and O, which are read as figures; then AA, AB."""
    letters = "ABCDEFGHJKLMNPQRSTUVWXYZ"
    more, last = divmod(number, len(letters))
    return (_letter(more - 1) if more else "") + letters[last]


class Callouts(Struct, frozen=True):
    """The callouts of a view, drawn with its frame, and how high they stand above its face."""

    shapes: tuple[Shape, ...]
    above: float
    left: int = 0  #: sizes that are not shown, because there are too many


def called_on(
    views: Sequence[View], sizes: Mapping[str, Sequence[FaceSize]], top: float, unit: Unit = "mm",
    letters: Mapping[Pieces, str] | None = None,
    labels_of: Callable[[View], Labels] = lambda _: Labels(),
) -> tuple[tuple[View, ...], float, dict[str, Callouts]]:  # fmt: skip
    """Views with room for callouts above each face, y below the last, and the callouts.

    `labels_of` says what lies on a face already.
    """

    placed, bottom, called = tuple(views), 0.0, dict[str, Callouts]()
    for _ in range(2):  # once more, as each face stands lower by what is above it
        placed = tuple(
            replace(one, above=called[one.name].above) if called else one for one in placed
        )
        placed, bottom = laid_out(placed, top)
        called = {
            view.name: _callouts(sizes[view.name], letters or {}, view, labels_of(view), unit)
            for view in placed
        }
    return placed, bottom, called


class _RaisedCallout(Struct):
    """A callout above a face: where its leader goes up, and where it leads."""

    words: Pieces
    x: float
    tip: Point


def _callouts(
    sizes: Sequence[FaceSize], letters: Mapping[Pieces, str], view: View, labels: Labels,
    unit: Unit,
) -> Callouts:  # fmt: skip
    """Each size at its first place, and the letters of the others; `labels` knows what lies on the
    paper."""
    frame = view.frame
    face = (*frame.at(view.box[0], view.top), *frame.at(view.box[2], view.bottom))
    drawn: list[Shape] = []
    callouts: list[_RaisedCallout] = []
    holes = np.array([(*frame.at(*p.at), p.radius * frame.scale)
                      for size in sizes if size.is_hole for p in size.places])  # fmt: skip
    roomy = face[3] - face[1] >= ROOM
    for size in sizes[:MAX_SIZES]:
        # Above a face the topmost place has the shortest leader, of a row the first.
        at = [(frame.at(*p.at), p.radius * frame.scale) for p in size.places]
        order = sorted(at, key=lambda one: (round(one[0][1] - one[1], 1), one[0][0]))
        letter = letters.get(size.words, "")
        count = f"{len(size.places)} × " if len(size.places) > 1 else ""
        lead = f"{letter}  {count}" if letter else count
        words = (lead, *size.words) if lead else size.words
        (x, y), radius = order[0]
        free = (
            _beside(words, (x, y), radius, size.places[0].is_open, labels, unit, face)
            if roomy
            else None
        )
        if free is not None:
            drawn += free
        else:
            callouts.append(_RaisedCallout(words, x, (x, y - radius)))
        if letter:
            drawn += [
                _lettered(letter, one, holes, labels)
                for one in dict.fromkeys(order[1:])
                if one != order[0]
            ]
    shapes, rows = _rows(callouts, face[1], unit)
    return Callouts((*drawn, *shapes), rows * ROW, max(0, len(sizes) - MAX_SIZES))


def _lettered(
    letter: str, hole: tuple[Point, float], holes: NDArray[np.float64], labels: Labels
) -> Text:
    """The letter of a hole, nearer to it than to any other; on it where there is no room beside."""
    at, radius = hole
    others = holes[np.any(holes[:, :2] != at, axis=1)]

    def is_nearest(box: Box) -> bool:
        middle = ((box[0] + box[2]) / 2, (box[1] + box[3]) / 2)
        own = dist(middle, at) - radius
        away = np.hypot(*(others[:, :2] - middle).T) - others[:, 2]
        return bool(np.all(own + CLEAR < away))

    for size in LETTER_SIZES:
        place = labels.place(at, 0.8 * radius + 1.5, letter, size, 2, is_nearest)
        if place is not None:
            return Text("figure letter", place, letter, size)
    size = LETTER_SIZES[-1]
    middle = (at[0] - LETTER * size / 2, at[1] + CAPITAL * size / 2)
    return Text("figure letter", middle, letter, size)


def _beside(
    words: Pieces, at: Point, radius: float, is_open: bool, labels: Labels, unit: Unit, face: Box
) -> list[Shape] | None:
    """A callout on the face itself beside its hole; None where there is no room."""
    text = as_text(words, unit)
    gap = 1.0 if is_open else 0.75 * radius + 6.0
    place = labels.place(at, gap, text, SIZE, 6, lambda box: is_in(box, face), is_open)
    if place is None:
        return None
    x, y = place
    wide = LETTER * SIZE * len(text)
    # Letters are narrower than the room that is kept for them: it ends where its leader begins.
    is_left = x + wide / 2 < at[0]
    tail = (x + wide + 2.0 if is_left else x - 2.0, y - CAPITAL * SIZE / 2)
    anchor: Literal["start", "end"] = "end" if is_left else "start"
    start = (x + wide if is_left else x, y)
    shapes: list[Shape] = [
        Text("label callout", start, text, SIZE, anchor, pieces=words, unit=unit)
    ]
    if not is_open and abs(x + wide / 2 - at[0]) < 1.0:  # right above or below it
        tail = (at[0], y + 2.0 if y < at[1] else y - CAPITAL * SIZE - 2.0)
    way = hypot(tail[0] - at[0], tail[1] - at[1])
    if radius + 2.0 < way and not (is_open and abs(x + wide / 2 - at[0]) < 1.0):
        share = radius / way
        edge = (at[0] + (tail[0] - at[0]) * share, at[1] + (tail[1] - at[1]) * share)
        shapes.append(Polyline("dim leader", (edge, tail)))
        labels.block_line(edge, tail)
    return shapes


def _rows(callouts: Sequence[_RaisedCallout], top: float, unit: Unit) -> tuple[list[Shape], int]:
    """Callouts above a face, so that no text lies over another or over its leader.

    A text stands to the right of its leader. From right to left, each takes the lowest row in
    which it meets no text, and no leader of a text above that row.
    """
    taken: list[tuple[int, float, float]] = []  #: row, leader, end of the text
    shapes: list[Shape] = []
    rows = 0
    wide = {id(one): LETTER * SIZE * len(as_text(one.words, unit)) + 6.0 for one in callouts}
    for one in callouts:
        one.x = min(one.x, WIDTH - 8.0 - wide[id(one)])
    for one in sorted(callouts, key=lambda each: -each.x):
        row, end = 0, one.x + wide[id(one)]
        while any(
            (r == row and a < end and one.x < b) or (r > row and one.x < a < end)
            for r, a, b in taken
        ):
            row += 1
        taken.append((row, one.x, end))
        rows = max(rows, row + 1)
        y = top - 5.0 - ROW * row
        shapes.append(Polyline("dim leader", (one.tip, (one.x, top), (one.x, y - SIZE * CAPITAL))))
        at = (one.x + 3.0, y)
        shapes.append(
            Text("label callout", at, as_text(one.words, unit), SIZE, pieces=one.words, unit=unit)
        )
    return shapes, rows
