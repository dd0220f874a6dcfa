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
)
from beamcam.checks.bars.targets import MarkingPath, slot_corners
from beamcam.checks.bars.tools import ToolCatalogue
from beamcam.checks.drawn_texts import DrawnPieces, DrawnText, RequiredText, Segment, told, wanted
from beamcam.checks.job import is_manual_work, manual_work
from beamcam.checks.text_assignment import (
    TEXT,
    TEXT_EXTRA,
    TEXT_MISSING,
    Places,
    Steel,
    assigned,
    box_of,
    judge,
    steel_within,
    text_positions,
)
from beamcam.errors import Diagnostic, Source
from beamcam.geometry.curves import Line, Point
from beamcam.machine.machine import text_x
from beamcam.model.part import Face, Hole, Part, Profile, Slot, TextMark
from beamcam.model.request import policy_on
from beamcam.model.section import NO_PLATE, OTHER_SIDE

ANGLE_DEG = 0.01  #: that a told angle may differ
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
    courses: list[MarkingPath] = []
    diagnostics: list[Diagnostic] = []
    texts: dict[Face, list[tuple[int, TextMark]]] = {}
    for f, feature in enumerate(part.features):
        if (
            isinstance(feature, TextMark)
            and policy_on(feature, tools.machine.marks) == "make"
            and not is_manual_work(feature, tools.machine)
        ):
            texts.setdefault(feature.face, []).append((f, feature))
    for face, group in texts.items():
        if tools.works_on(face, part) and any(tools.of("scribe", face)):
            marking_paths, more = _on_face(face, group, part, ends, paths, from_x, tools)
            courses += marking_paths
            diagnostics += more
        else:
            diagnostics += (manual_work(feature, part, tools.machine) for _, feature in group)
    return courses, diagnostics


class PrintedTexts:
    """What a program tells a stamp or printer, of which each text of the parts takes its own."""

    def __init__(self, texts: Sequence[StampedText], tools: ToolCatalogue, name: str) -> None:
        self.tools, self.name = tools, name
        self.at = text_x(tools.machine)
        self.left = list(texts)
        #: the number of a part, and the text that it has there
        self.taken: list[tuple[int, StampedText]] = []

    def check(self, p: int, part: Part, ends: Ends, start: float) -> Iterator[Diagnostic]:
        """What is wrong with the texts of a part that begins at a bar x."""
        by_face: dict[Face, list[RequiredText]] = {}
        for feature in part.texts:
            machine = self.tools.machine
            if policy_on(feature, machine.marks) != "make":
                continue
            text = told(feature, machine.marks) if self._comes_to(feature.face, part) else None
            if text is None:
                yield manual_work(feature, part, machine)
                continue
            by_face.setdefault(feature.face, []).append(text)
        for face, texts in by_face.items():
            steel = _steel(face, part, ends, _sides(face, part))
            found = self._take(p, (part, ends), texts, start, steel)
            yield from self._judge(face, [*zip(texts, found, strict=True)], part, steel)

    def _comes_to(self, face: Face, part: Part) -> bool:
        missing = NO_PLATE.get(part.profile.code, ())
        return face in self.tools.machine.marks.faces and face not in missing

    def _take(
        self, p: int, of: tuple[Part, Ends],
        texts: Sequence[RequiredText], start: float,
        steel: Steel,
    ) -> list[DrawnText | None]:  # fmt: skip
        """The texts of a part's face as they are told over it."""
        from_x, face = self.at + start, texts[0].feature.face
        over = [one for one in self.left if one.face == face]
        founds = [
            DrawnText(one.x - from_x, one.y, one.height, (), (k,)) for k, one in enumerate(over)
        ]
        options = [
            [
                drawn if _is_told_as(text, one) and _is_over(text, drawn, *of) else None
                for one, drawn in zip(over, founds, strict=True)
            ]
            for text in texts
        ]
        result = assigned(texts, options, steel, self.tools.machine.marks)
        for k in (k for drawn in result if drawn is not None for k in drawn.taken):
            self.left.remove(over[k])
            self.taken.append((p, over[k]))
        return result

    def _judge(
        self, face: Face, group: Sequence[tuple[RequiredText, DrawnText | None]], part: Part,
        steel: Steel,
    ) -> Iterator[Diagnostic]:  # fmt: skip
        marks = self.tools.machine.marks
        smallest = replace(marks, min_height=min(marks.heights, default=marks.min_height))
        boxes = [box_of(t, f.x, f.y, f.height) if f is not None else None for t, f in group]
        places = Places(steel, [box for box in boxes if box is not None], smallest)
        for k, (text, drawn) in enumerate(group):
            others = [box for j, box in enumerate(boxes) if j != k and box is not None]
            feature = text.feature
            if drawn is not None:
                if marks.heights and drawn.height not in marks.heights:
                    expected = "a height that the machine has"
                    yield TEXT.at(
                        feature.source, text=text.text, x=f"{drawn.x:.1f}", y=f"{drawn.y:.1f}",
                        height=f"{drawn.height:g}", expected=expected,
                    )  # fmt: skip
                yield from judge(text, drawn, steel, others, marks)
            elif places.has(text):
                yield TEXT_MISSING.at(
                    feature.source, text=text.text, face=face, mark=part.mark,
                    angle=f"{feature.angle:g}", x=f"{feature.x:g}", y=f"{feature.y:g}",
                )  # fmt: skip
            else:
                yield manual_work(feature, part, self.tools.machine)

    def extra(self) -> Iterator[Diagnostic]:
        """The texts that no part has."""
        for t in self.left:
            yield TEXT_EXTRA.at(
                Source(self.name, t.line), text=t.text, face=t.face, x=f"{t.x:g}", y=f"{t.y:g}"
            )


def _is_told_as(text: RequiredText, one: StampedText) -> bool:
    """Whether a text that is told is of the characters and at the angle of one that is wanted."""
    apart = abs((one.angle - text.feature.angle + 180.0) % 360.0 - 180.0)
    return one.text == text.text and apart < ANGLE_DEG


def _is_over(text: RequiredText, drawn: DrawnText, part: Part, ends: Ends) -> bool:
    """Whether the middle of a text lies between the ends of a part; others of the bar may too."""
    middle = box_of(text, drawn.x, drawn.y, drawn.height).centroid
    first, last = (_ends_at(end, text.feature.face, part.profile, middle.y) for end in ends)
    return bool(min(first) - OVER <= middle.x <= max(last) + OVER)


def _on_face(
    face: Face, texts: Sequence[tuple[int, TextMark]], part: Part,
    ends: Ends,
    paths: Sequence[MachinedPath], from_x: float, tools: ToolCatalogue,
) -> tuple[list[MarkingPath], list[Diagnostic]]:  # fmt: skip
    marks = tools.machine.marks
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
    drawn = DrawnPieces(pieces, tools.drill.path_tolerance + 2 * tools.machine.format.resolution)
    required = [wanted(feature, marks) for _, feature in texts]
    orientations = text_positions(
        required, drawn, steel, sure, marks, lambda text, one: _is_over(text, one, part, ends)
    )
    courses: list[MarkingPath] = []
    diagnostics: list[Diagnostic] = []
    for (f, feature), text, one in zip(texts, required, orientations, strict=True):
        if one is None:
            diagnostics.append(manual_work(feature, part, tools.machine))
        else:
            diagnostics += one.diagnostics
            courses += _strokes(f, text, one.x, one.y, one.height)
    return courses, diagnostics


def _strokes(
    f: int, text: RequiredText, x: float, y: float, height: float
) -> Iterator[MarkingPath]:
    for pieces in text.strokes(x, y, height):
        lines = tuple(Line(a, b) for a, b in pieces)
        yield MarkingPath(
            f, text.feature.face, lines, text.feature, f"stroke of the text {text.text!r}"
        )


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
    """y that a spindle's axes come to with something to spare; None if they come to none."""
    (spindle,) = (s for s in tools.machine.spindles if s.face == face)
    station = choices_of(tools.machine, part.profile)[spindle.number].stations[0]
    values = stroke_values(tools.machine, part.profile, face)
    values |= {"depth": tools.drill.mark_depth, "tip": 0.0}
    low, high = _sides(face, part)
    steps = [low + k * (high - low) / 256 for k in range(257)]
    ys = [y for y in steps if is_within(values | {"y": y}, spindle, station, tools.machine)]
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
        pieces += _stem(part.profile, [x for x, _ in corners])
    behind = OTHER_SIDE.get(part.profile.code, {}).get(face)
    for feature in part.features:
        if isinstance(feature, (Hole, Slot)) and feature.face in (face, behind):
            pieces += pairwise(_rim(feature))
    return steel_within(pieces)


def _stem(profile: Profile, xs: Sequence[float]) -> Iterator[Segment]:
    """The foot of a T's stem with its fillets, in the middle of the face that it stands on."""
    half = profile.flange_thickness / 2 + profile.radius
    low, high = profile.height / 2 - half, profile.height / 2 + half
    yield (min(xs), low), (max(xs), low)
    yield (max(xs), low), (max(xs), high)
    yield (max(xs), high), (min(xs), high)
    yield (min(xs), high), (min(xs), low)


def _ends_at(end: RequiredEnd, face: Face, profile: Profile, q: float) -> tuple[float, float]:
    """x at which an end leaves both surfaces of the wall behind a face, at its coordinate q."""
    height, width = profile.height, profile.width
    web, flange = profile.web_thickness or 0.0, profile.flange_thickness
    if face in ("o", "u"):
        stem = (height - flange) / 2, (height + flange) / 2
        ys = (height - flange, height) if face == "o" else (0.0, flange)
        ys = stem if profile.code == "T" else ys
        return end.x(ys[0], q), end.x(ys[1], q)
    if profile.code in ("M", "SO", "RO", "RU"):
        near = width - web if face == "v" else 0.0
    else:
        near = (width - web) / 2 if profile.code == "I" else 0.0
    return end.x(q, near), end.x(q, near + web)


def _rim(hole: Hole | Slot) -> list[Point]:
    """Points round a hole; round a slot those of its box."""
    radius = hole.diameter / 2
    if isinstance(hole, Hole):
        steps = [2 * pi * k / CHORDS for k in range(CHORDS)]
        rim = [(hole.x + radius * cos(t), hole.y + radius * sin(t)) for t in steps]
        return [*rim, rim[0]]
    box = Slot(
        hole.face, hole.x, hole.y, 0.0, hole.length + hole.diameter, hole.height + hole.diameter,
        hole.angle, hole.source,
    )  # fmt: skip
    a, b, c, d = slot_corners(box)
    return [a, b, d, c, a]
