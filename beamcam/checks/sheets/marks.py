"""What a sheet is marked with: texts, spots for the drill, and the lines of hatches.

Texts are found in the strokes of a program and added to what it needs.
"""

from collections.abc import Iterable, Iterator, Sequence
from itertools import groupby, pairwise
from math import ceil, cos, radians, sin

import numpy as np
import shapely

from beamcam.checks import text_assignment
from beamcam.checks.drawn_texts import EXACT, NEAR, DrawnPieces, RequiredText, text_to_letter
from beamcam.checks.job import is_manual_work, manual_work
from beamcam.checks.sheets import rules
from beamcam.checks.sheets.need import Need, shift_of
from beamcam.checks.sheets.strokes import Strokes
from beamcam.checks.sheets.work import SHOWN, Work
from beamcam.errors import Diagnostic, Source
from beamcam.geometry.array_types import Floats
from beamcam.geometry.curves import Curve, Line
from beamcam.geometry.plane import Point
from beamcam.machine.machine import Machine
from beamcam.machine.torch import LayerSettings, Torch, TorchProcess
from beamcam.model.part import Part, TextMark
from beamcam.model.request import policy_on

FACES = ("v",)  #: that a head over a sheet comes to
CHORD = 0.5  #: mm, of the edges of the steel


def add_texts(need: Need, part: Part, machine: Machine, torch: Torch, strokes: Strokes) -> None:
    """Add the texts of a part where a program draws them, and what is wrong with their places.

    One that it does not draw is needed where the part has it, unless it can stand nowhere: then
    it is left for manual work.
    """
    required = [
        (index, text_to_letter(feature, machine.marks))
        for index, feature in enumerate(part.features)
        if isinstance(feature, TextMark) and policy_on(feature, machine.marks) == "make"
        and not is_manual_work(feature, machine)
    ]  # fmt: skip
    if not required:
        return
    process = text_process(machine)
    if not need.curves.get("cut"):  # a sheet that is only marked lies where its marks do
        for index, text in required:
            _need(need, process, index, text, (text.feature.x, text.feature.y, text.height))
        return
    chords = [pair for curve in _once(need) for pair in pairwise(_points(curve, CHORD))]
    steel = text_assignment.steel_within(chords)
    moves, shift = strokes.moves, shift_of(need, torch)
    pieces: list[tuple[Point, Point]] = []  # in the numbers of the part
    for stroke in strokes.each:
        if stroke.process == process:
            rows = slice(stroke.first, stroke.last)
            ends = np.hstack((moves.start[rows] - shift, moves.end[rows] - shift)).tolist()
            pieces += [((a, b), (c, d)) for a, b, c, d in ends]
    if machine.stepper is not None:
        _where_they_are(need, required, part, machine, steel, pieces)
        return
    drawn = DrawnPieces(pieces, max(NEAR, torch.tolerance))
    ours = {index: text for index, text in required if text.feature.face in FACES}
    texts = [*ours.values()]
    found = text_assignment.found_texts(texts, drawn, steel, machine.marks)
    positions = text_assignment.text_positions(texts, found, steel, steel, machine.marks)
    position_of = dict(zip(ours, positions, strict=True))
    for index, text in required:
        one = position_of.get(index)
        if one is None:
            need.diagnostics.append(manual_work(text.feature, part, machine))
        else:
            at, diagnostics = one
            need.diagnostics += diagnostics
            _need(need, process, index, text, (at.x, at.y, at.height))


def _where_they_are(
    need: Need, required: Sequence[tuple[int, RequiredText]], part: Part, machine: Machine,
    steel: text_assignment.Steel, pieces: Sequence[tuple[Point, Point]],
) -> None:  # fmt: skip
    """Add the texts that a table letters where the part has them; it moves none.

    Stairs of steps do not tell one stroke from the next, so that no text is looked for elsewhere.
    """
    boxes: list[shapely.Polygon] = []
    middles = shapely.MultiPoint([((a + c) / 2, (b + d) / 2) for (a, b), (c, d) in pieces])
    for index, text in required:
        feature = text.feature
        place = feature.x, feature.y, text.height
        is_drawn = feature.face in FACES and text.pieces and text.height >= machine.marks.min_height
        box = text_assignment.box_of(text, *place) if is_drawn else None
        if (
            box is not None
            and text_assignment.is_clear(box, steel, boxes, machine.marks.min_distance - EXACT)
            and (
                text_assignment.is_surely_clear(text, steel, boxes, machine.marks)
                or box.intersects(middles)
            )
        ):
            _need(need, text_process(machine), index, text, place)
            boxes.append(box)
        else:
            need.diagnostics.append(manual_work(feature, part, machine))


def text_process(machine: Machine) -> TorchProcess:
    """The process that draws the strokes of texts."""
    return "engrave" if machine.marks.unit == "laser" else "mark"


def _need(
    need: Need, process: TorchProcess, index: int, text: RequiredText, place: tuple[float, ...]
) -> None:
    need.add(process, [Line(a, b) for a, b in text.at(*place)], index, text.feature.source)


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


def _points(curve: Curve, chord: float) -> list[Point]:
    """Places of a curve no farther apart than a chord, both of its ends among them."""
    count = 1 if isinstance(curve, Line) else max(16, ceil(curve.length / chord))
    return [curve.point(k / count) for k in range(count + 1)]


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
    for (x, y), feature, count in zip(places.tolist(), need.spots.values(), done, strict=True):
        if not count:
            expected = f"the centre of {need.sources[feature]}"
            yield rules.SPOT.at(
                Source(name), found="no spot", x=f"{x:.3f}", y=f"{y:.3f}", expected=expected
            )


def without_spots(strokes: Strokes) -> Strokes:
    """The strokes that follow something, with their own moves alone."""
    kept = np.zeros(len(strokes.moves), dtype=bool)
    each = [s for s in strokes.each if s.process != "spot"]
    for stroke in each:
        kept[stroke.first : stroke.last] = True
    return strokes.kept(each, kept)


# --- hatches --------------------------------------------------------------------------------------

# Check that the lines of a hatch are those that fill its contours, each in its place.
#
# What an odd number of closed contours of a look enclose is drawn as polygons and cut by lines a
# distance apart, the first half of it above the lowest point of the contours:
#
#     required   every piece of a cut line that is longer than two distances, without half a
#                distance at both ends
#     allowed    nothing else; a piece that is as long as that but for the slack may be there or
#                not
#
# Nothing of this is taken from `model.hatch`, by which the lines are made.


HATCH_CHORD = 0.1  #: mm
SLACK = 0.05  #: mm that an end may be elsewhere, where lines run flat into a contour
#: mm from a line, where it is looked what lies above and below an edge on it, or one so near that
#: chords in place of the curve may lie on its other side.
ASIDE = (0.0, 1e-6, -1e-6, 0.01, -0.01)
HATCH = "hatch"  #: where the input's reader says that a line of a hatch is


Spans = tuple[float, float]  #: where a piece of a line begins and ends along x
Fault = tuple[str, Point]  #: what, and where if the lines lay along x
#: The rings of the filled area of one look, and its lines; turned so that these lie along x.
Filled = tuple[list[Floats], list[Floats]]


def hatch_faults(need: Need, torch: Torch, name: str) -> list[Diagnostic]:
    """Hatches with a line too few or too many, or one that is elsewhere than it has to be."""
    diagnostics: list[Diagnostic] = []
    keys = {look: process for process in need.curves for look in need.looks[process]}
    for key in dict.fromkeys([*keys, *need.filled]):
        own = torch.settings.get(key)
        if own is None or own.hatch is None:
            continue
        for what, (x, y) in _hatch_faults(*_filled(need, keys.get(key), key, own), own.hatch):
            c, s = cos(radians(own.hatch_angle)), sin(radians(own.hatch_angle))
            diagnostics.append(
                rules.HATCH.at(
                    Source(name), key=key, found=what, x=f"{c * x - s * y:.3f}",
                    y=f"{s * x + c * y:.3f}", expected=f"{own.hatch:g}",
                    angle=f"{own.hatch_angle:g}",
                )
            )  # fmt: skip
            break
    return diagnostics


def overscan_faults(work: Work) -> list[Diagnostic]:
    """Lines of a hatch without their overscan, and other strokes with one."""
    over = work.torch.overscan if work.torch.laser_mode else 0.0
    if not over or not work.strokes or not work.need.count:
        return []
    firsts = np.searchsorted(work.of_way, np.arange(len(work.strokes)))
    middles = (work.path.starts[firsts] + work.path.ends[firsts]) / 2
    _, nearest = work.need.nearest(middles, work.tolerance)
    diagnostics: list[Diagnostic] = []
    for stroke, way, middle in zip(work.strokes, nearest.tolist(), middles, strict=True):
        is_line = work.required.source(work.process, way).where == HATCH
        expected = over if is_line else 0.0
        if max(abs(length - expected) for length in stroke.overscan) <= 2 * work.tolerance:
            continue
        found, line = "{:.3f} and {:.3f}".format(*stroke.overscan), stroke.line
        diagnostics.append(
            work.fault(rules.OVERSCAN, line, middle, found=found, expected=f"{expected:g}")
        )
    return diagnostics[:SHOWN]


def _hatch_faults(rings: list[Floats], lines: list[Floats], distance: float) -> Iterator[Fault]:
    """Where lines differ from those that fill the area.

    Where an edge lies on a line or grazes it, that may fill what is above it, what is below it, or
    both.
    """
    if not rings:
        return
    low = float(np.concatenate(rings)[:, 1].min())
    spans: dict[int, list[Spans]] = {}
    for line in lines:
        (x0, y), (x1, y1) = line[0].tolist(), line[-1].tolist()
        k = round((y - low) / distance - 0.5)
        expected = low + (k + 0.5) * distance
        if abs(y - y1) > SLACK / 10 or abs(y - expected) > SLACK / 10:
            yield "a line between those that fill it, or at another angle", (x0, y)
        else:
            span = min(x0, x1) - distance / 2, max(x0, x1) + distance / 2
            spans.setdefault(k, []).append(span)
    wrong: dict[int, Fault] | None = None
    for aside in ASIDE:
        pieces = _spans_in(rings, distance, aside)
        still: dict[int, Fault] = {}
        for k in sorted({*spans, *pieces} if wrong is None else wrong):
            y = low + (k + 0.5) * distance
            fault = _line_fault(spans.get(k, []), pieces.get(k, []), distance, y)
            if fault is not None:
                still[k] = fault if wrong is None else wrong[k]
        wrong = still
        if not wrong:
            return
    yield from (wrong or {}).values()


def _line_fault(
    found: Sequence[Spans], pieces: Sequence[Spans], distance: float, y: float
) -> Fault | None:
    """Where what is found of one line differs from the pieces that it should have."""
    slack = max(SLACK, distance / 4)
    left = list(pieces)
    for a, b in found:
        fits = [span for span in left if max(abs(span[0] - a), abs(span[1] - b)) <= slack]
        if not fits:
            return "a line that ends elsewhere, or is there twice", (a, y)
        left.remove(fits[0])
    for a, b in left:
        if b - a > 2 * distance + 2 * slack:
            return "no line", ((a + b) / 2, y)
    return None


def _spans_in(rings: list[Floats], distance: float, aside: float) -> dict[int, list[Spans]]:
    """The pieces of each line in the area, by the number of the line; lines are `aside` higher."""
    inside: shapely.Geometry = shapely.Polygon()
    for ring in rings:
        inside = shapely.symmetric_difference(inside, shapely.make_valid(shapely.Polygon(ring)))
    points = np.concatenate(rings)
    (x0, low), (x1, high) = points.min(axis=0).tolist(), points.max(axis=0).tolist()
    count = int((high - low) / distance + 0.5) + 1
    ys = low + (np.arange(count) + 0.5) * distance + aside
    ends = np.stack((np.full(count, x0 - 1), ys, np.full(count, x1 + 1), ys), axis=1)
    cut = shapely.intersection(shapely.linestrings(ends.reshape(-1, 2, 2)), inside)
    parts, number = shapely.get_parts(cut, return_index=True)
    spans: dict[int, list[Spans]] = {}
    for (a, _, b, _), k in zip(shapely.bounds(parts).tolist(), number.tolist(), strict=True):
        spans.setdefault(k, []).append((a, b))
    return spans


def _filled(need: Need, process: TorchProcess | None, key: str, own: LayerSettings) -> Filled:
    """The closed contours and the lines of a look, turned."""
    c, s = cos(radians(own.hatch_angle)), sin(radians(own.hatch_angle))

    def turned(curves: Iterable[Curve]) -> Floats:
        points = [p for curve in curves for p in _points(curve, HATCH_CHORD)]
        return np.asarray(np.array(points) @ np.array([[c, -s], [s, c]]))

    rings = [turned(contour.curves) for contour in need.filled.get(key, [])]
    lines: list[Floats] = []
    if process is None:
        return rings, lines
    rows = zip(need.features[process], need.looks[process], need.curves[process], strict=True)
    for feature, group in groupby(rows, key=lambda row: row[0]):
        mine = [curve for _, look, curve in group if look == key]
        if mine and need.sources[feature].where == HATCH:
            lines.append(turned(mine))
        elif mine and mine[0].start == mine[-1].end and len(points := turned(mine)) > 3:
            rings.append(points)
    return rings, lines


def one_way_faults(work: Work) -> list[Diagnostic]:
    """The first line of a hatch that is followed backwards where all are to run one way."""
    torch, need, required = work.torch, work.need, work.required
    looks = required.looks[work.process]
    lines = [
        k for k, look in enumerate(looks)
        if look in torch.settings and torch.settings[look].hatch_one_way
        and required.source(work.process, k).where == HATCH
    ]  # fmt: skip
    if not lines or not work.strokes:
        return []
    ways = np.array(lines)
    points = need.point(ways, need.lengths[ways] / 2)
    pairs = work.path.near(points, work.most_slack)
    legs = work.path.elements.directions(pairs.element, np.zeros(len(pairs.element)))
    angles = np.radians([torch.settings[looks[k]].hatch_angle for k in lines])[pairs.point]
    along = legs[:, 0] * np.cos(angles) + legs[:, 1] * np.sin(angles)
    # What crosses a line is not part of it.
    back = np.flatnonzero(along < -0.99)[:1]
    way, at = work.path.owner[pairs.element[back]], pairs.point[back]
    return [
        work.fault(rules.HATCH_WAY, line, points[k], key=looks[lines[k]])
        for line, k in zip(work.moves.line[way].tolist(), at.tolist(), strict=True)
    ]
