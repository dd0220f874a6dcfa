"""The texts of a sheet, found in the strokes of a program and added to what it needs."""

from collections.abc import Iterator, Sequence
from itertools import pairwise
from math import ceil
from typing import TYPE_CHECKING

import numpy as np

from beamcam.geometry.curves import Curve, Line
from beamcam.geometry.plane import Point
from beamcam.machine.machine import Machine
from beamcam.machine.torch import Torch, TorchProcess
from beamcam.model.description import policy_on
from beamcam.model.part import Part, TextMark
from beamcam.verify.asked import by_hand, is_by_hand
from beamcam.verify.drawn_texts import EXACT, NEAR, DrawnPieces, Wanted, wanted
from beamcam.verify.lettering import Steel, box_of, is_clear, is_surely_clear, steel_within
from beamcam.verify.sheets.need import Need, shift_of
from beamcam.verify.text_assignment import standings

if TYPE_CHECKING:
    from beamcam.verify.sheets.strokes import Strokes

FACES = ("v",)  #: that a head over a sheet comes to
CHORD = 0.5  #: mm, of the edges of the steel


def add_texts(need: Need, part: Part, machine: Machine, torch: Torch, strokes: "Strokes") -> None:
    """Add the texts of a part where a program draws them, and what is wrong with their places.

    One that it does not draw is needed where the part has it, unless it can stand nowhere: then
    it is left for manual work.
    """
    texts = [
        (index, feature) for index, feature in enumerate(part.features)
        if isinstance(feature, TextMark) and policy_on(feature, machine.marks) == "make"
        and not is_by_hand(feature, machine)
    ]  # fmt: skip
    if not texts:
        return
    marks, process = machine.marks, text_process(machine)
    asked = [(index, wanted(feature, marks)) for index, feature in texts]
    if not need.curves.get("cut"):  # a sheet that is only marked lies where its marks do
        for index, text in asked:
            _need(need, process, index, text, text.feature.x, text.feature.y, text.height)
        need.drawn.clear()
        return
    steel = steel_within([piece for curve in _once(need) for piece in _chords(curve)])
    pieces = _pieces(strokes, process, shift_of(need, torch))
    if machine.stepper is not None:
        _where_they_are(need, asked, part, machine, steel, pieces)
        return
    drawn = DrawnPieces(pieces, max(NEAR, torch.tolerance))
    ours = {index: text for index, text in asked if text.feature.face in FACES}
    standing = standings([*ours.values()], drawn, steel, steel, marks)
    stands = dict(zip(ours, standing, strict=True))
    for index, text in asked:
        one = stands.get(index)
        if one is None:
            need.said.append(by_hand(text.feature, part, machine))
        else:
            need.said += one.said
            _need(need, process, index, text, one.x, one.y, one.height)
    need.drawn.clear()


def _where_they_are(
    need: Need, asked: Sequence[tuple[int, Wanted]], part: Part, machine: Machine, steel: Steel,
    pieces: Sequence[tuple[Point, Point]],
) -> None:  # fmt: skip
    """Add the texts that a table letters where the part has them; it moves none.

    Stairs of steps do not tell one stroke from the next, so that no text is looked for elsewhere.
    """
    import shapely

    marks = machine.marks
    boxes: list[shapely.Polygon] = []
    middles = shapely.MultiPoint([((a + c) / 2, (b + d) / 2) for (a, b), (c, d) in pieces])
    for index, text in asked:
        feature = text.feature
        box = None
        if feature.face in FACES and text.pieces and text.height >= marks.min_height:
            box = box_of(text, feature.x, feature.y, text.height)
        if (
            box is not None
            and is_clear(box, steel, boxes, marks.min_distance - EXACT)
            and (is_surely_clear(text, steel, boxes, marks) or box.intersects(middles))
        ):
            place = feature.x, feature.y, text.height
            _need(need, text_process(machine), index, text, *place)
            boxes.append(box)
        else:
            need.said.append(by_hand(feature, part, machine))
    need.drawn.clear()


def text_process(machine: Machine) -> TorchProcess:
    """The process that draws the strokes of texts."""
    return "engrave" if machine.marks.unit == "laser" else "mark"


def _need(
    need: Need, process: TorchProcess, index: int, text: Wanted, x: float, y: float, height: float
) -> None:
    need.add(process, [Line(a, b) for a, b in text.at(x, y, height)], index, text.feature.source)


def _pieces(
    strokes: "Strokes", process: TorchProcess, shift: Point
) -> Sequence[tuple[Point, Point]]:
    """The straight moves of a process, in the numbers of the part."""
    moves = strokes.moves
    found: list[tuple[Point, Point]] = []
    for stroke in strokes.each:
        if stroke.process == process:
            rows = slice(stroke.first, stroke.last)
            ends = np.hstack((moves.start[rows] - shift, moves.end[rows] - shift)).tolist()
            found += [((a, b), (c, d)) for a, b, c, d in ends]
    return found


def _once(need: Need) -> Iterator[Curve]:
    """The curves that are cut; of contours that lie on one another only those of one.

    Two of them around a place would be no steel there, if their edges were counted.
    """
    contours: dict[int, list[Curve]] = {}
    for feature, curve in zip(need.features["cut"], need.curves["cut"], strict=True):
        contours.setdefault(feature, []).append(curve)
    known = set()
    for curves in contours.values():
        corners = ((c.start, c.point(0.5), c.end) for c in curves)
        place = frozenset(frozenset((round(x, 6), round(y, 6)) for x, y in c) for c in corners)
        if place not in known:
            known.add(place)
            yield from curves


def _chords(curve: Curve) -> Iterator[tuple[Point, Point]]:
    count = 1 if isinstance(curve, Line) else min(1024, max(16, ceil(curve.length / CHORD)))
    yield from pairwise([curve.point(k / count) for k in range(count + 1)])
