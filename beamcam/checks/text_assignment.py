"""Which of a part's texts each text is that a program draws or prints, and where it stands.

Where one may stand follows from the steel and the machine file; nothing is known of where it was
planned.

Texts that are alike may stand in for each other. Of all ways to share them out the one counts by
which the fewest stand where they may not, and then by the least way from where the part has them.
"""

from collections.abc import Callable, Iterator, Sequence
from itertools import pairwise
from math import hypot
from typing import TYPE_CHECKING

import numpy as np
from msgspec import Struct

from beamcam.checks.drawn_texts import (
    EXACT,
    DrawnPieces,
    DrawnText,
    RequiredText,
    Segment,
    covering,
    is_in_place,
)
from beamcam.checks.rules import TEXT_MOVED
from beamcam.errors import Diagnostic, error
from beamcam.geometry.array_types import Floats
from beamcam.geometry.plane import Point
from beamcam.machine.stations import Marks
from beamcam.model.part import MIRRORED_FACES

if TYPE_CHECKING:
    from shapely import Geometry, Polygon

TEXT = error("verify-text",
    "found the text {text!r} at x {x}, y {y}, {height} mm high; expected {expected}",
    "A text stands where the part has it, or where it is clear of holes, edges and other "
    "texts.")  # fmt: skip
TEXT_MISSING = error("verify-text-missing",
    "found no text {text!r} on face {face} of {mark} at {angle} degrees; expected it at x {x}, y "
    "{y}",
    "A text that the machine's stamp or printer could letter has to be in the program, character "
    "by character.")  # fmt: skip
TEXT_EXTRA = error("verify-text-extra",
    "found the text {text!r} on face {face} at machine x {x}, y {y}; expected none, no part has it "
    "there",
    "What is stamped or printed cannot be taken off again.")  # fmt: skip


SURE = 0.15  #: mm by which a place is more than clear, or a room wide enough


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


def box_of(text: RequiredText, x: float, y: float, height: float) -> "Polygon":
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


def _judge(
    text: RequiredText, drawn: DrawnText, steel: Steel, others: Sequence["Polygon"], marks: Marks,
    sure: Steel | None,
) -> Iterator[Diagnostic]:  # fmt: skip
    """What is wrong with the place of a text, or that it is another than the part's.

    `sure` is the steel to which what letters comes for sure, where that is not all of it.
    """
    feature = text.feature
    box = box_of(text, drawn.x, drawn.y, drawn.height)
    labels = {
        "text": text.text, "x": f"{drawn.x:.1f}", "y": f"{drawn.y:.1f}",
        "height": f"{drawn.height:.1f}",
    }  # fmt: skip
    if not is_clear(box, steel, others, marks.min_distance - EXACT):
        expected = f"it {marks.min_distance:g} mm clear of edges and holes, beside other texts"
        yield TEXT.at(feature.source, expected=expected, **labels)
    elif is_in_place(text, drawn):
        return
    elif feature.option == "z" or is_surely_clear(text, sure or steel, others, marks):
        expected = f"it at x {feature.x:g}, y {feature.y:g}, {text.height:g} mm high"
        yield TEXT.at(feature.source, expected=expected, **labels)
    else:
        yield TEXT_MOVED.at(
            feature.source, wanted_x=f"{feature.x:g}", wanted_y=f"{feature.y:g}",
            wanted_height=f"{text.height:g}", **labels,
        )  # fmt: skip


def is_surely_clear(
    text: RequiredText, steel: Steel, others: Sequence["Polygon"], marks: Marks
) -> bool:
    feature = text.feature
    box = box_of(text, feature.x, feature.y, text.height)
    return is_clear(box, steel, others, marks.min_distance + SURE, SURE)


def _can_stand(
    text: RequiredText, steel: Steel, others: Sequence["Polygon"], marks: Marks,
    rooms: dict[object, bool],
) -> bool:  # fmt: skip
    """Whether a text might have been drawn: where the part has it, or elsewhere.

    `rooms` holds the answers for texts of one shape, which are the same.
    """
    if not text.pieces or text.height < marks.min_height:
        return False
    if is_surely_clear(text, steel, others, marks):
        return True
    if text.feature.option == "z":
        return False
    shape = text.text, text.feature.angle, text.feature.face in MIRRORED_FACES
    if shape not in rooms:
        rooms[shape] = _has_room(text, steel, others, marks)
    return rooms[shape]


def _has_room(text: RequiredText, steel: Steel, others: Sequence["Polygon"], marks: Marks) -> bool:
    """Whether there is surely room for the smallest box of a text.

    The middle of a box that is clear lies in the steel, and outside of what the box sweeps when it
    moves along all edges (their Minkowski sum).
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


WRONG = 1e7  #: mm that a place which is not allowed counts as, beside the way to it
LEFT = 1e10  #: mm that a text without a place counts as
NEVER = 1e13  #: mm that what cannot be the text counts as

#: For each text what it would be as each of the texts that were found; None where it cannot be.
Options = Sequence[Sequence[DrawnText | None]]


def text_positions(
    texts: Sequence[RequiredText], drawn: Sequence[DrawnText | None], steel: Steel,
    sure: Steel | None, marks: Marks,
) -> Iterator[tuple[DrawnText, Sequence[Diagnostic]] | None]:  # fmt: skip
    """Of each text of a face where a program draws it, or where the part has it if it has to, and
    what is wrong with that.

    None where it is not drawn and can stand nowhere on the steel: it is left for manual work.
    `drawn` is where each is drawn, `sure` the steel to which what letters comes for sure.
    """
    boxes = [
        None if one is None else box_of(text, one.x, one.y, one.height)
        for text, one in zip(texts, drawn, strict=True)
    ]
    clear_of, rooms = [box for box in boxes if box is not None], dict[object, bool]()
    for k, (text, one) in enumerate(zip(texts, drawn, strict=True)):
        others = [box for j, box in enumerate(boxes) if j != k and box is not None]
        if one is not None:
            yield one, tuple(_judge(text, one, steel, others, marks, sure))
        elif sure is not None and _can_stand(text, sure, clear_of, marks, rooms):
            yield DrawnText(text.feature.x, text.feature.y, text.height), ()
        else:
            yield None


def found_texts(
    texts: Sequence[RequiredText], drawn: DrawnPieces, steel: Steel, marks: Marks,
    is_ours: Callable[[RequiredText, DrawnText], bool] | None = None,
) -> list[DrawnText | None]:  # fmt: skip
    """Where a program draws each text of a face; None for those that it does not draw.

    `steel` is that where texts stand for sure; `is_ours` tells texts of the part from those of
    others on the same bar.
    """
    numbers: dict[tuple[Segment, ...], int] = {}
    shapes = [numbers.setdefault(text.pieces, len(numbers)) for text in texts]
    tallest: dict[int, RequiredText] = {}
    for shape, text in zip(shapes, texts, strict=True):
        if shape not in tallest or text.height > tallest[shape].height:
            tallest[shape] = text
    readings: dict[frozenset[int], dict[int, DrawnText]] = {}
    for shape, text in tallest.items():
        for one in drawn.all_of(text, marks.min_height, text.height):
            if is_ours is None or is_ours(text, one):
                readings.setdefault(frozenset(one.taken), {}).setdefault(shape, one)
    chosen = [readings[place] for place in covering([*readings])]
    options = []
    for shape, text in zip(shapes, texts, strict=True):
        row = [reading.get(shape) for reading in chosen]
        highest = text.height + EXACT
        options.append([one if one and one.height <= highest else None for one in row])
    return assigned(texts, options, steel, marks)


def assigned(
    texts: Sequence[RequiredText], options: Options, steel: Steel, marks: Marks
) -> list[DrawnText | None]:
    """What each text is, no two the same; as many as can be have one."""
    import shapely

    result: list[DrawnText | None] = [None] * len(texts)
    left, taken = [], set()
    for t, (text, row) in enumerate(zip(texts, options, strict=True)):
        own = (k for k, one in enumerate(row) if one is not None and k not in taken)
        exact = next((k for k in own if is_in_place(text, row[k])), None)  # type: ignore[arg-type]
        if exact is None:
            left.append(t)
        else:
            taken.add(exact)
            result[t] = row[exact]
    places = [k for k in range(len(options[0]) if options else 0) if k not in taken]
    if not left or not places:
        return result
    boxes = []  #: of the texts that were found
    for k in range(len(options[0])):
        for text, row in zip(texts, options, strict=True):
            if (drawn := row[k]) is not None:
                boxes.append((k, box_of(text, drawn.x, drawn.y, drawn.height)))
                break
    costs = np.full((len(left), len(places) + len(left)), LEFT)
    for line, t in enumerate(left):
        # What keeps the text from standing where the part has it: the number of a text if that
        # alone does, which would itself be free to stand there; -1 of an edge or several texts.
        forbidden: int | None = -1
        own = box_of(texts[t], texts[t].feature.x, texts[t].feature.y, texts[t].height)
        if is_clear(own, steel, (), marks.min_distance + SURE):
            near = [k for k, box in boxes if shapely.distance(own, box) <= SURE]
            forbidden = None if not near else near[0] if len(near) == 1 else -1
        for column, k in enumerate(places):
            drawn, feature = options[t][k], texts[t].feature
            if drawn is None:
                costs[line, column] = NEVER
                continue
            is_too_high = drawn.height > texts[t].height + EXACT
            is_wrong = forbidden in (None, k) or feature.option == "z" or is_too_high
            way = hypot(drawn.x - feature.x, drawn.y - feature.y)
            costs[line, column] = way + WRONG * is_wrong  # mm from where the part has it
        costs[line, len(places) :] += WRONG * (forbidden is None)
    for t, column in zip(left, cheapest(costs), strict=True):
        if column < len(places):
            result[t] = options[t][places[column]]
    return result


def cheapest(costs: Floats) -> list[int]:
    """A column for each row, no two the same, by which the sum of costs is least.

    There are at least as many columns as rows (the Hungarian method, by shortest paths).
    """
    rows, columns = costs.shape
    over, under = np.zeros(rows), np.zeros(columns)
    row_of = np.full(columns, -1)
    for begin in range(rows):
        least, before = np.full(columns, np.inf), np.full(columns, -1)
        done = np.zeros(columns, dtype=bool)
        row, last, way = begin, -1, 0.0
        while True:
            to = way + costs[row] - over[row] - under
            nearer = ~done & (to < least)
            least[nearer], before[nearer] = to[nearer], last
            column = int(np.where(done, np.inf, least).argmin())
            way, done[column] = float(least[column]), True
            last = column
            if row_of[column] < 0:
                break
            row = int(row_of[column])
        passed = np.flatnonzero(done & (np.arange(columns) != column))
        over[begin] += way
        over[row_of[passed]] += way - least[passed]
        under[passed] -= way - least[passed]
        while column >= 0:
            previous = int(before[column])
            row_of[column] = begin if previous < 0 else row_of[previous]
            column = previous
    column_of = {int(row): column for column, row in enumerate(row_of.tolist()) if row >= 0}
    return [column_of[row] for row in range(rows)]
