"""The texts of a sheet, found in the strokes of a program and added to what it needs."""

from collections.abc import Iterator, Sequence
from itertools import pairwise
from math import ceil
from typing import TYPE_CHECKING

import numpy as np
from msgspec.structs import replace

from beamcam.errors import Diagnostic, Source
from beamcam.geometry.curves import Curve, Line
from beamcam.geometry.plane import Point
from beamcam.machine.machine import Machine
from beamcam.machine.torch import Torch, TorchProcess
from beamcam.model.description import policy_on
from beamcam.model.part import Part, TextMark
from beamcam.verify.drawn_texts import EXACT, NEAR, DrawnPieces
from beamcam.verify.left_out import by_hand, is_by_hand
from beamcam.verify.lettering import Steel, box_of, is_clear, is_surely_clear, steel_within
from beamcam.verify.sheets import rules
from beamcam.verify.sheets.need import Need, shift_of
from beamcam.verify.sheets.strokes import Strokes
from beamcam.verify.text_assignment import standings
from beamcam.verify.wanted_texts import Wanted, wanted

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


# --- spots ----------------------------------------------------------------------------------------

# Spots: centres for the drill, burnt by a torch that stands, each once and before anything is cut.
#
# A controller wants a move between the words that start and stop its tool: it is no longer than
# `LONGEST`.


LONGEST = 0.1  #: mm


def spot_faults(
    strokes: Strokes, need: Need, shift: tuple[float, float], tolerance: float, name: str
) -> Iterator[Diagnostic]:
    """Spots that are missing, made twice or elsewhere, moved, or made after a cut."""
    first_cut = min((s.line for s in strokes.each if s.process == "cut"), default=None)
    places = np.array(list(need.spots)).reshape(-1, 2) + np.array(shift)
    done = [0] * len(places)
    for stroke in strokes.each:
        if stroke.process != "spot":
            continue
        at, end = strokes.moves.start[stroke.first], strokes.moves.end[stroke.first : stroke.last]
        source = Source(name, stroke.line)
        values = {"x": f"{at[0]:.3f}", "y": f"{at[1]:.3f}"}
        near = np.flatnonzero(np.hypot(*(places - at).T) <= tolerance)
        for k in near.tolist():
            done[k] += 1
        reach = float(np.hypot(*(end - at).T).max())
        found = ""
        if not len(near):
            found, expected = "a spot", "none there"
        elif reach > LONGEST:
            found, expected = f"a torch that moves {reach:.3f} mm as it spots", "it standing"
        elif any(done[k] > 1 for k in near.tolist()):
            found, expected = "a second spot", "one there"
        elif first_cut is not None and stroke.line > first_cut:
            found, expected = "a spot behind a cut", "all of them before"
        if found:
            yield rules.SPOT.at(source, found=found, expected=expected, **values)
    for (x, y), feature, count in zip(
        places.tolist(), need.spots.values(), done, strict=True
    ):  # fmt: skip
        if not count:
            expected = f"the centre of {need.sources[feature]}"
            yield rules.SPOT.at(
                Source(name), found="no spot", x=f"{x:.3f}", y=f"{y:.3f}", expected=expected
            )


def without_spots(strokes: Strokes) -> Strokes:
    """The strokes that follow something, with their own moves alone."""
    kept = [s for s in strokes.each if s.process != "spot"]
    if len(kept) == len(strokes.each):
        return strokes
    spans = [np.arange(s.first, s.last) for s in kept]
    lasts = np.cumsum([len(span) for span in spans]).tolist()
    each = [
        replace(s, first=last - len(span), last=last)
        for s, span, last in zip(kept, spans, lasts, strict=True)
    ]
    return Strokes(each, strokes.moves.take(np.concatenate([np.zeros(0, dtype=np.int64), *spans])))
