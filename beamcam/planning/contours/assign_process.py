"""What is to be cut and marked of a part: exact curves, each with its process and its feature."""

from collections import Counter
from collections.abc import Collection, Iterator, Mapping
from itertools import pairwise
from typing import Literal, cast

from msgspec import Struct, field

from beamcam.errors import Diagnostic, Source
from beamcam.geometry.curves import Arc, Curve, Line, unit_vector
from beamcam.geometry.plane import Point, join_boxes
from beamcam.machine.machine import Machine
from beamcam.machine.marking import Marks
from beamcam.machine.torch import Torch, TorchProcess
from beamcam.model.colour import colour_name, process_of
from beamcam.model.marks import policy_on
from beamcam.model.part import (
    Bend,
    Camber,
    Contour,
    EndPlane,
    Feature,
    Hole,
    Part,
    Process,
    Slot,
    TextMark,
)
from beamcam.planning import rules as bar_rules
from beamcam.planning.by_hand import FACE, listed_by, refuse_mark
from beamcam.planning.contours import rules
from beamcam.planning.lettering import Room, place_text, remarks

Meaning = Literal["cut", "mark", "engrave", "ignore"]

#: The faces of a plate: through features stand in the same numbers on both.
PLATE_FACES = ("v", "h")
TOP_FACES = ("v",)  #: that a head comes to
OUTLINE = -1  #: stands for the rectangle of a plate that has no contour of its own

#: What a table does for the processes of DSTV: a punched or powdered line is marked.
_MEANINGS: dict[Process, TorchProcess] = {
    "cut": "cut", "mark": "mark", "engrave": "engrave", "punch": "mark", "powder": "mark",
}  # fmt: skip


class Wanted(Struct, frozen=True, gc=False):
    """One curve to follow."""

    curve: Curve
    process: TorchProcess
    feature: int  #: index into the part's features, or `OUTLINE`
    source: Source


class Assigned(Struct):
    """All that is asked of a part."""

    wanted: list[Wanted] = field(default_factory=list)
    rings: set[int] = field(default_factory=set)  #: features that are closed by what they say
    skipped: dict[int, str] = field(default_factory=dict)  #: feature: the code it is left out by
    listed: dict[int, str] = field(default_factory=dict)  #: marks left to the hand, and why
    refusals: list[Diagnostic] = field(default_factory=list)
    remarks: list[Diagnostic] = field(default_factory=list)


def assign_processes(
    part: Part, torch: Torch, machine: Machine, skips: Collection[str]
) -> Assigned:
    """The curves of a part by process; what the machine cannot make is refused or skipped."""
    found = Assigned()
    meanings = _Meanings(torch.colours)
    unmapped: Counter[tuple[str | None, str | None]] = Counter()
    first: dict[tuple[str | None, str | None], Source] = {}
    for index, feature in enumerate(part.features):
        if _is_out(index, feature, torch, machine, skips, found):
            continue
        if isinstance(feature, TextMark):
            continue  # its place follows from all else that is cut
        if isinstance(feature, Contour):
            look = feature.layer, feature.colour
            meaning = meanings(feature)
            if meaning is None:
                unmapped[look] += len(feature.curves)
                first.setdefault(look, feature.source)
            elif meaning == "ignore":
                found.skipped[index] = IGNORED
            else:
                source = feature.source
                if feature.closed:
                    found.rings.add(index)
                found.wanted += [Wanted(c, meaning, index, source) for c in feature.curves]
        else:
            hole = cast("Hole | Slot", feature)
            process: TorchProcess = "mark" if hole.kind == "mark" else "cut"  # a centre's cross
            curves = curves_of(hole, torch.cross)
            found.wanted += [Wanted(c, process, index, feature.source) for c in curves]
    for look, count in unmapped.items():
        found.refusals.append(_unmapped(look, count, first[look], torch.colours))
    if _needs_outline(part):
        found.wanted += (Wanted(c, "cut", OUTLINE, part.source) for c in _rectangle(part))
    letter(part, machine.marks, found)
    found.refusals += _unknown_processes(found.wanted, torch, machine.name)
    return found


def _is_out(
    index: int, feature: Feature, torch: Torch, machine: Machine, skips: Collection[str],
    found: Assigned,
) -> bool:  # fmt: skip
    """Whether a feature is refused, left out or left to the hand; `found` is told why."""
    why = listed_by(feature, machine.marks)
    if why is not None:
        found.listed[index] = why
        return True
    said = refuse_mark(feature, machine.marks) or _refusal(feature, torch)
    if said is None:
        return False
    if said.code == bar_rules.BEVEL.code and "bevel" in skips:
        found.remarks.append(rules.SQUARE.at(feature.source))
        return False
    if said.code.removeprefix("plan-") in skips:
        found.skipped[index] = said.code
    else:
        found.refusals.append(said)
    return True


IGNORED = "map-ignore"  #: how the ledger calls what the table of colours ignores


class _Meanings:
    """What a contour is for, asked once for each layer and colour."""

    def __init__(self, colours: Mapping[str, Meaning]) -> None:
        self._table = cast("Mapping[str, Process]", colours)
        self._known: dict[tuple[str | None, str | None], Meaning | None] = {}

    def __call__(self, contour: Contour) -> Meaning | None:
        look = contour.layer, contour.colour
        if look == (None, None):
            return _MEANINGS[contour.process]
        if look not in self._known:
            self._known[look] = cast("Meaning | None", process_of(contour, self._table))
        return self._known[look]


def letter(part: Part, marks: Marks, found: Assigned) -> None:
    """Add the strokes of the texts, each where it is clear of what is cut and of the others."""
    texts = [
        (index, feature) for index, feature in enumerate(part.features)
        if isinstance(feature, TextMark)
        and index not in found.listed and policy_on(feature, marks) == "make"
    ]  # fmt: skip
    if not texts:
        return
    by_feature: dict[int, list[Curve]] = {}
    for wanted in found.wanted:
        if wanted.process == "cut":
            by_feature.setdefault(wanted.feature, []).append(wanted.curve)
    boxes = [curve.bbox for curves in by_feature.values() for curve in curves]
    room = Room(join_boxes(boxes) or (0.0, 0.0, part.length, part.profile.height))
    for curves in by_feature.values():
        room.add(curves)
    process: TorchProcess = "engrave" if marks.unit == "laser" else "mark"
    for index, text in texts:
        lettered = place_text(text, marks, room) if text.face in TOP_FACES else FACE
        if isinstance(lettered, str):
            found.listed[index] = lettered
            continue
        found.remarks += remarks(text, lettered, marks)
        found.wanted += [
            Wanted(Line(a, b), process, index, text.source)
            for stroke in lettered.strokes
            for a, b in pairwise(stroke)
        ]


def _unmapped(
    look: tuple[str | None, str | None], count: int, source: Source, table: Mapping[str, Meaning]
) -> Diagnostic:
    layer, colour = look
    named = [] if colour is None else [f"of colour {colour_name(colour)}"]
    named += [] if layer is None else [f"on layer {layer!r}"]
    key = colour_name(colour) if colour is not None else layer
    return rules.UNMAPPED.at(
        source, count=count, found=" ".join(named), expected=", ".join(table), key=key
    )


def _unknown_processes(wanted: list[Wanted], torch: Torch, machine: str) -> Iterator[Diagnostic]:
    known = {row.process for row in torch.rows}
    missing = Counter(w.process for w in wanted if w.process not in known)
    for process, count in missing.items():
        source = next(w.source for w in wanted if w.process == process)
        yield rules.NO_PROCESS.at(
            source, count=count, found=process, machine=machine, expected=", ".join(sorted(known))
        )


def _refusal(feature: Feature, torch: Torch) -> Diagnostic | None:
    """Why a table cannot make a feature; None if it can."""
    match feature:
        case Contour():
            if feature.face not in PLATE_FACES:
                return bar_rules.NO_SPINDLE.at(
                    feature.source, kind="contour", found=feature.face,
                    expected=", ".join(PLATE_FACES),
                )  # fmt: skip
            if feature.bevels:
                angle = f"{feature.bevels[0].angle:g}"
                return bar_rules.BEVEL.at(feature.source, found=angle, face=feature.face)
            return None
        case Hole() | Slot() if feature.face not in PLATE_FACES:
            return bar_rules.NO_SPINDLE.at(
                feature.source,
                kind="slot" if isinstance(feature, Slot) else f"{feature.kind} hole",
                found=feature.face,
                expected=", ".join(PLATE_FACES),
            )
        case Hole() if feature.kind == "mark":
            return _refuse_centre(feature, torch)
        case Hole():
            return _refuse_hole(feature, torch)
        case Slot():
            return _refuse_slot(feature, torch)
        case TextMark():
            return None
        case Bend() | EndPlane() | Camber():
            names = {Bend: "a bend", EndPlane: "an end plane", Camber: "a camber"}
            return bar_rules.OTHER.at(feature.source, found=names[type(feature)])


def _refuse_centre(hole: Hole, torch: Torch) -> Diagnostic | None:
    """Why a table cannot mark a centre: it has no cross for it, or it should be of some depth."""
    expected = None
    if not torch.cross:
        expected = "none, or the size of a cross in the machine file (torch.cross)"
    elif hole.depth is not None:
        expected = f"one without a depth, it is marked by a cross of {torch.cross:g}"
    if expected is None:
        return None
    return bar_rules.NO_TOOL.at(
        hole.source, kind="mark", found=f"{hole.diameter:g}", face=hole.face, expected=expected
    )


def _refuse_hole(hole: Hole, torch: Torch) -> Diagnostic | None:
    expected = None
    if hole.kind != "through" or hole.depth is not None:
        expected = "one through the sheet, a torch makes nothing else"
    elif hole.diameter < torch.min_hole:
        expected = f"at least {torch.min_hole:g}"
    if expected is None:
        return None
    kind = "blind" if hole.kind == "through" and hole.depth is not None else hole.kind
    return bar_rules.NO_TOOL.at(
        hole.source, kind=kind, found=f"{hole.diameter:g}", face=hole.face, expected=expected
    )


def _refuse_slot(slot: Slot, torch: Torch) -> Diagnostic | None:
    expected = None
    if slot.kind != "through" or slot.depth is not None:
        expected = "one through the sheet, a torch makes nothing else"
    elif min(slot.length, slot.height) + slot.diameter < torch.min_hole:
        expected = f"one at least {torch.min_hole:g} wide"
    if expected is None:
        return None
    size = f"{slot.length + slot.diameter:g} x {slot.height + slot.diameter:g}"
    return bar_rules.SLOT.at(slot.source, found=size, face=slot.face, expected=expected)


def curves_of(feature: Hole | Slot, cross: float) -> tuple[Curve, ...]:
    """The closed contour of a hole or a slot, counter-clockwise; of a centre mark its cross."""
    if feature.kind == "mark":
        x, y, half = feature.x, feature.y, cross / 2
        return Line((x - half, y), (x + half, y)), Line((x, y - half), (x, y + half))
    if isinstance(feature, Hole):
        return (Arc((feature.x, feature.y), feature.diameter / 2, 0.0, 360.0),)
    return tuple(_slot_curves(feature))


def _slot_curves(slot: Slot) -> Iterator[Curve]:
    """Lines joined by corner arcs of the slot's diameter: half circles where it has no height."""
    radius, (c, s) = slot.diameter / 2, unit_vector(slot.angle)
    half_x, half_y = slot.length / 2, slot.height / 2

    def at(x: float, y: float) -> Point:
        return slot.x + c * x - s * y, slot.y + s * x + c * y

    corners = ((half_x, half_y), (-half_x, half_y), (-half_x, -half_y), (half_x, -half_y))
    arcs = [Arc(at(x, y), radius, slot.angle + 90.0 * k, 90.0) for k, (x, y) in enumerate(corners)]
    for k, arc in enumerate(arcs):
        if radius > 0.0:
            yield arc
        start, end = arc.end, arcs[(k + 1) % 4].start
        if (slot.length, slot.height)[k % 2] > 0.0:
            yield Line(start, end)


def _needs_outline(part: Part) -> bool:
    """Whether a plate is described by its length and width alone; a drawing never is."""
    if part.measures is not None:
        return False
    return not any(
        c.kind == "outer" and c.process == "cut" and c.face in PLATE_FACES for c in part.contours
    )


def _rectangle(part: Part) -> Iterator[Line]:
    length, width = part.length, part.profile.height
    corners = [(0.0, 0.0), (length, 0.0), (length, width), (0.0, width)]
    for k, corner in enumerate(corners):
        yield Line(corner, corners[(k + 1) % 4])
