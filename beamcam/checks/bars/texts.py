"""The texts of a part on a bar, found in the paths of a program's scribe."""

from collections.abc import Iterator, Sequence
from itertools import pairwise
from math import cos, pi, sin

from msgspec.structs import replace

from beamcam.checks.bars.ability import is_within
from beamcam.checks.bars.pieces import Ends, RequiredEnd
from beamcam.checks.bars.stations import (
    MachinedPath,
    StampedText,
    choices_of,
    lip_length,
    stroke_values,
    wall_between,
)
from beamcam.checks.bars.targets import MarkingPath, slot_corners
from beamcam.checks.bars.tools import ToolCatalogue
from beamcam.checks.drawn_texts import (
    DrawnPieces,
    DrawnText,
    RequiredText,
    Segment,
    text_to_letter,
    text_to_print,
)
from beamcam.checks.job import is_manual_work, manual_work
from beamcam.checks.text_assignment import (
    TEXT,
    TEXT_EXTRA,
    TEXT_MISSING,
    Steel,
    assigned,
    box_of,
    found_texts,
    steel_within,
    text_positions,
)
from beamcam.errors import Diagnostic, Source
from beamcam.geometry.curves import Line, Point
from beamcam.machine.machine import text_x
from beamcam.model.part import Face, Hole, Part, Profile, Slot, TextMark
from beamcam.model.request import policy_on
from beamcam.model.section import NO_PLATE, OTHER_SIDE

ANGLE_DEG = 0.01  #: that the angle of a printed text may differ
MARGIN = 1.5  #: mm by which a place is surely within the reach of an axis
OVER = 0.5  #: mm beyond the ends of a part that a text may be found
CHORDS = 48  #: of a hole


def texts_of(
    part: Part, ends: Ends, paths: Sequence[MachinedPath], from_x: float,
    tools: ToolCatalogue,
) -> tuple[list[MarkingPath], list[Diagnostic]]:  # fmt: skip
    """The strokes of a part's texts where a program letters them, and what is wrong with them.

    One that it does not letter is needed where the part has it, unless it can stand nowhere: then
    it is left for manual work.
    """
    strokes: list[MarkingPath] = []
    diagnostics: list[Diagnostic] = []
    machine, marks = tools.machine, tools.machine.marks
    by_face: dict[Face, list[tuple[int, RequiredText]]] = {}
    for f, feature in enumerate(part.features):
        if not isinstance(feature, TextMark) or policy_on(feature, marks) != "make":
            continue
        if not is_manual_work(feature, machine):
            by_face.setdefault(feature.face, []).append((f, text_to_letter(feature, marks)))
    for face, group in by_face.items():
        if not tools.works_on(face, part) or not any(tools.of("scribe", face)):
            diagnostics += (manual_work(text.feature, part, machine) for _, text in group)
            continue
        steel = _steel(face, part, ends, _sides(face, part))
        bounds = _within_axes(face, part, tools)
        sure = None if bounds is None else _steel(face, part, ends, bounds)
        pieces = [
            ((a[0] - from_x, a[1]), (b[0] - from_x, b[1]))
            for path in paths
            if path.kind == "scribe" and path.face == face
            for a, b in pairwise(path.points)
            if all(-OVER <= x - from_x <= part.length + OVER for x in (a[0], b[0]))
        ]
        drawn = DrawnPieces(pieces, tools.drill.path_tolerance + 2 * machine.format.resolution)
        texts = [text for _, text in group]
        found = found_texts(
            texts, drawn, sure or steel, marks, lambda text, one: _is_over(text, one, part, ends)
        )
        positions = text_positions(texts, found, steel, sure, marks)
        for (f, text), one in zip(group, positions, strict=True):
            if one is None:
                diagnostics.append(manual_work(text.feature, part, machine))
                continue
            at, faults = one
            diagnostics += faults
            what = f"stroke of the text {text.text!r}"
            for stroke in text.strokes(at.x, at.y, at.height):
                lines = tuple([Line(a, b) for a, b in stroke])
                strokes.append(MarkingPath(f, face, lines, text.feature, what))
    return strokes, diagnostics


class PrintedTexts:
    """What a stamp or printer letters, of which each text of the parts takes its own."""

    def __init__(self, texts: Sequence[StampedText], tools: ToolCatalogue, name: str) -> None:
        self.machine, self.name = tools.machine, name
        self.left = list(texts)
        #: the number of a part, and the text that it has there
        self.taken: list[tuple[int, StampedText]] = []

    def check(self, p: int, part: Part, ends: Ends, start: float) -> Iterator[Diagnostic]:
        """What is wrong with the texts of a part that begins at a bar x."""
        marks, missing = self.machine.marks, NO_PLATE.get(part.profile.code, ())
        by_face: dict[Face, list[RequiredText]] = {}
        for feature in part.texts:
            if policy_on(feature, marks) == "make":
                comes_to = feature.face in marks.faces and feature.face not in missing
                if comes_to and (text := text_to_print(feature, marks)) is not None:
                    by_face.setdefault(feature.face, []).append(text)
                else:
                    yield manual_work(feature, part, self.machine)
        smallest = replace(marks, min_height=min(marks.heights, default=marks.min_height))
        for face, texts in by_face.items():
            steel = _steel(face, part, ends, _sides(face, part))
            found = self._take(p, part, ends, texts, start, steel)
            positions = text_positions(texts, found, steel, steel, smallest)
            for text, drawn, position in zip(texts, found, positions, strict=True):
                feature = text.feature
                if position is None:
                    yield manual_work(feature, part, self.machine)
                    continue
                if drawn is None:
                    yield TEXT_MISSING.at(
                        feature.source, text=text.text, face=face, mark=part.mark,
                        angle=f"{feature.angle:g}", x=f"{feature.x:g}", y=f"{feature.y:g}",
                    )  # fmt: skip
                elif marks.heights and drawn.height not in marks.heights:
                    yield TEXT.at(
                        feature.source, text=text.text, x=f"{drawn.x:.1f}", y=f"{drawn.y:.1f}",
                        height=f"{drawn.height:g}", expected="a height that the machine has",
                    )  # fmt: skip
                yield from position[1]

    def _take(
        self, p: int, part: Part, ends: Ends, texts: Sequence[RequiredText], start: float,
        steel: Steel,
    ) -> list[DrawnText | None]:  # fmt: skip
        """The texts of a part's face as they are printed over it."""
        from_x, face = text_x(self.machine) + start, texts[0].feature.face
        over = [one for one in self.left if one.face == face]
        printed = [DrawnText(one.x - from_x, one.y, one.height, (k,)) for k, one in enumerate(over)]
        options: list[list[DrawnText | None]] = []
        for text in texts:
            options.append([])
            for one, drawn in zip(over, printed, strict=True):
                apart = abs((one.angle - text.feature.angle + 180.0) % 360.0 - 180.0)
                is_it = one.text == text.text and apart < ANGLE_DEG
                options[-1].append(drawn if is_it and _is_over(text, drawn, part, ends) else None)
        result = assigned(texts, options, steel, self.machine.marks)
        for k in (k for drawn in result if drawn is not None for k in drawn.taken):
            self.left.remove(over[k])
            self.taken.append((p, over[k]))
        return result

    def extra(self) -> Iterator[Diagnostic]:
        """The texts that no part has."""
        for t in self.left:
            yield TEXT_EXTRA.at(
                Source(self.name, t.line), text=t.text, face=t.face, x=f"{t.x:g}", y=f"{t.y:g}"
            )


def _is_over(text: RequiredText, drawn: DrawnText, part: Part, ends: Ends) -> bool:
    """Whether the middle of a text lies between the ends of a part; others of the bar may too."""
    middle = box_of(text, drawn.x, drawn.y, drawn.height).centroid
    first, last = (_ends_at(end, text.feature.face, part.profile, middle.y) for end in ends)
    return bool(min(first) - OVER <= middle.x <= max(last) + OVER)


def _sides(face: Face, part: Part) -> tuple[float, float]:
    """Range of y that is free for a scribe, between edges, flanges and their fillets."""
    profile = part.profile
    width = profile.face_width(face)
    if profile.code == "M":
        return profile.radius, width - profile.radius
    if profile.code == "T" and face in ("o", "u"):  # its stem, from the fillet of the flange on
        return (profile.web_thickness or 0.0) + profile.radius, width
    walled = ("v", "h") if profile.code == "I" else ("v",)
    if face not in walled or profile.code not in ("I", "U", "C", "L"):
        return 0.0, width
    beside = max(profile.flange_thickness + profile.radius, lip_length(part))
    return beside, (width if profile.code == "L" else width - beside)


def _within_axes(face: Face, part: Part, tools: ToolCatalogue) -> tuple[float, float] | None:
    """y that a spindle's axes surely come to; None if they come to none."""
    (number,) = (s.number for s in tools.machine.spindles if s.face == face)
    station = choices_of(tools.machine, part.profile)[number].stations[0]
    values = stroke_values(tools.machine, part.profile, face)
    values |= {"depth": tools.drill.mark_depth, "tip": 0.0}
    low, high = _sides(face, part)
    steps = [low + k * (high - low) / 256 for k in range(257)]
    ys = [y for y in steps if is_within(values | {"y": y}, station, tools.machine)]
    if not ys or ys[-1] - ys[0] <= 2 * MARGIN:
        return None
    margin = (high - low) / 256 + MARGIN
    return (
        low if ys[0] == low else ys[0] + margin,
        high if ys[-1] == steps[-1] else ys[-1] - margin,
    )


def _steel(face: Face, part: Part, ends: Ends, sides: tuple[float, float]) -> Steel:
    """The steel of a face between two y, its holes taken out."""
    low, high = sides
    corners: list[Point] = []
    # Where an end is skew through the wall, the surface counts that leaves less.
    corners += ((max(_ends_at(ends[0], face, part.profile, y)), y) for y in (high, low))
    corners += ((min(_ends_at(ends[1], face, part.profile, y)), y) for y in (low, high))
    pieces: list[Segment] = [*pairwise([*corners, corners[0]])]
    if part.profile.code == "T" and face == "v":
        # The foot of the stem with its fillets, in the middle of the face that it stands on.
        half = part.profile.flange_thickness / 2 + part.profile.radius
        middle, xs = part.profile.height / 2, [x for x, _ in corners]
        low, high = middle - half, middle + half
        foot = [(min(xs), low), (max(xs), low), (max(xs), high), (min(xs), high)]
        pieces += pairwise([*foot, foot[0]])
    behind = OTHER_SIDE.get(part.profile.code, {}).get(face)
    for feature in part.features:
        if isinstance(feature, (Hole, Slot)) and feature.face in (face, behind):
            pieces += pairwise(_rim(feature))
    return steel_within(pieces)


def _ends_at(end: RequiredEnd, face: Face, profile: Profile, q: float) -> tuple[float, float]:
    """x at which an end leaves both surfaces of the wall behind a face, at its coordinate q."""
    wall = wall_between(profile, face)
    if face == "v" and profile.code in ("SO", "RO", "RU"):
        wall = profile.width - wall[1], profile.width
    return end.at_wall(face, q, wall)


def _rim(hole: Hole | Slot) -> list[Point]:
    """Points round a hole; round a slot those of its box."""
    radius = hole.diameter / 2
    if isinstance(hole, Hole):
        steps = [2 * pi * k / CHORDS for k in range(CHORDS)]
        rim = [(hole.x + radius * cos(t), hole.y + radius * sin(t)) for t in steps]
        return [*rim, rim[0]]
    length, height = hole.length + hole.diameter, hole.height + hole.diameter
    box = replace(hole, diameter=0.0, length=length, height=height)
    a, b, c, d = slot_corners(box)
    return [a, b, d, c, a]
