"""The curves of a part to cut and mark, exact, each with its process and its feature."""

from collections import Counter, defaultdict
from collections.abc import Collection, Iterable, Iterator, Mapping, Sequence
from itertools import pairwise
from typing import Literal, cast

from msgspec import Struct, field
from msgspec.structs import replace

from beamcam.errors import Diagnostic, Source
from beamcam.geometry.curves import Curve, Line
from beamcam.geometry.plane import Point, join_boxes
from beamcam.machine.machine import Machine
from beamcam.machine.torch import Torch, TorchProcess
from beamcam.model.colour import colour_name, key_of, process_of
from beamcam.model.hatch import is_filled_only
from beamcam.model.part import (
    PLATE_FACES,
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
from beamcam.model.request import policy_on
from beamcam.planning import rules as bar_rules
from beamcam.planning.contours import rules
from beamcam.planning.contours.outline import (
    centres_of,
    cross_at,
    curves_of,
    outline_of,
)
from beamcam.planning.contours.plate import outermost
from beamcam.planning.contours.plate_edges import notches_in
from beamcam.planning.left_out import BEVEL, DRILL, FACE, NO_ROOM, NOT_MOVED, listed_by, refuse_mark
from beamcam.planning.lettering import place_text, remarks
from beamcam.planning.lettering_room import Room
from beamcam.planning.within import idle_planes, within_larger

Meaning = Literal["cut", "mark", "engrave", "ignore"]
Look = tuple[str | None, str | None]  #: layer and colour
NO_LOOK: Look = (None, None)

TOP_FACES = ("v",)  #: that a head comes to
OUTLINE = -1  #: stands for the rectangle of a plate that has no contour of its own

#: What a table does for the processes of DSTV: a punched or powdered line is marked.
_MEANINGS: dict[Process, TorchProcess] = {
    "cut": "cut", "mark": "mark", "engrave": "engrave", "punch": "mark", "powder": "mark",
}  # fmt: skip


class AssignedCurve(Struct, frozen=True, gc=False):
    """One curve to follow."""

    curve: Curve
    process: TorchProcess
    feature: int  #: index into the part's features, or `OUTLINE`
    source: Source
    look: str = ""  #: key of the settings that it is worked with; empty for those of its process


class Assigned(Struct):
    """All work that a part requires."""

    curves: list[AssignedCurve] = field(default_factory=list)
    rings: set[int] = field(default_factory=set)  #: features that are closed by what they say
    skipped: dict[int, str] = field(default_factory=dict)  #: feature: the code it is left out by
    filled: dict[int, str] = field(default_factory=dict)  #: hatched, not followed: the process
    stated: set[int] = field(default_factory=set)  #: end planes that the outline makes
    within: dict[int, Diagnostic] = field(default_factory=dict)  #: openings in larger ones
    listed: dict[int, str] = field(default_factory=dict)  #: marks left for manual work, and why
    #: places that the torch spots where it stands, and the features whose centres they are
    spots: dict[Point, list[int]] = field(default_factory=dict)
    refusals: list[Diagnostic] = field(default_factory=list)
    remarks: list[Diagnostic] = field(default_factory=list)


def assign_processes(
    part: Part, torch: Torch, machine: Machine, skips: Collection[str]
) -> Assigned:
    """The curves of a part by process; what the machine cannot make is refused or skipped."""
    assigned = Assigned(within=within_larger(part))
    thickness = part.profile.web_thickness or torch.thickness or 0.0
    table = cast("Mapping[str, Process]", torch.colours)
    looks: dict[Look, tuple[Meaning | None, str]] = {}
    unmapped: dict[Look, list[Contour]] = defaultdict(list)
    idle = dict(idle_planes(part, outermost(part, thickness)))
    outline = outline_of(part)
    notches = notches_in(part, outline, OUTLINE, assigned.within)
    assigned.stated, assigned.remarks = {*idle}, [*idle.values(), *notches.notes]
    for index, feature in enumerate(part.features):
        if index in assigned.within or index in idle:
            continue
        if _is_out(index, feature, torch, thickness, machine, skips, assigned):
            continue
        if isinstance(feature, Contour):
            look = feature.layer, feature.colour
            if look not in looks:  # what both stand for, and the key of their settings
                key = key_of(feature, table) or ""
                meant = cast("Meaning | None", process_of(feature, table))
                looks[look] = meant, key if key in torch.settings else ""
            meaning, key = looks[look] if look != NO_LOOK else (_MEANINGS[feature.process], "")
            if meaning is None:
                unmapped[look].append(feature)
            elif meaning == "ignore":
                assigned.skipped[index] = IGNORED
            elif torch.settings and is_filled_only(feature, torch):
                assigned.filled[index] = meaning
            else:
                if feature.closed and index not in notches.curves:
                    assigned.rings.add(index)
                assigned.curves += [
                    AssignedCurve(curve, meaning, index, feature.source, key)
                    for curve in notches.curves.get(index, feature.curves)
                ]
        elif isinstance(feature, TextMark):
            continue  # its place follows from all else that is cut
        elif torch.drilled == "spot" and cast("Hole | Slot", feature).kind == "mark":
            spot(centres_of(cast("Hole | Slot", feature)), [index], assigned)
        else:
            hole = cast("Hole | Slot", feature)
            process: TorchProcess = "mark" if hole.kind == "mark" else "cut"  # a centre's cross
            curves = curves_of(hole, torch.cross)
            assigned.curves += [AssignedCurve(c, process, index, feature.source) for c in curves]
    assigned.refusals += (_unmapped(contours, torch.colours) for contours in unmapped.values())
    assigned.remarks += [*assigned.within.values(), *_noise(part, torch)]
    assigned.curves += (
        AssignedCurve(curve, "cut", OUTLINE, part.source)
        for curve in notches.curves.get(OUTLINE, outline)
    )
    letter(part, machine, assigned)
    assigned.refusals += _unknown_processes(assigned.curves, torch, machine.name)
    return assigned


def _is_out(
    index: int, feature: Feature, torch: Torch, thickness: float, machine: Machine,
    skips: Collection[str], assigned: Assigned,
) -> bool:  # fmt: skip
    """Whether a feature is refused, left out or left for manual work; `assigned` records why."""
    policy = policy_on(feature, machine.marks)
    if policy is not None and (why := listed_by(feature, machine.marks)) is not None:
        assigned.listed[index] = why
        return True
    diagnostic = refuse_mark(feature, machine.marks) if policy == "refuse" else None
    diagnostic = diagnostic or refusal(feature, torch, thickness)
    if diagnostic is None:
        return False
    if (
        torch.drilled != "refuse" and isinstance(feature, Hole | Slot)
        and feature.kind != "mark" and feature.face in PLATE_FACES
    ):  # fmt: skip
        assigned.listed[index] = DRILL
        if torch.drilled == "spot":
            spot(centres_of(feature), [index], assigned)
            return True
        assigned.curves += [
            AssignedCurve(curve, "mark", index, feature.source)
            for at in centres_of(feature) for curve in cross_at(at, torch.cross)
        ]  # fmt: skip
        return True
    if diagnostic.code == bar_rules.BEVEL.code and torch.bevel == "square":
        assigned.listed[index] = BEVEL
        return False
    if diagnostic.code == bar_rules.BEVEL.code and "bevel" in skips:
        assigned.remarks.append(rules.SQUARE.at(feature.source))
        return False
    if diagnostic.code.removeprefix("plan-") in skips:
        assigned.skipped[index] = diagnostic.code
    else:
        assigned.refusals.append(diagnostic)
    return True


def spot(places: Iterable[Point], features: Iterable[int], assigned: Assigned) -> None:
    """Have places spotted for features, each place once."""
    for x, y in places:
        assigned.spots.setdefault((round(x, 6), round(y, 6)), []).extend(features)


def _noise(part: Part, torch: Torch) -> Iterator[Diagnostic]:
    """A note, once for a part, on bevels that are too small to be meant."""
    bevels = [b for c in part.contours for b in c.bevels if abs(b.angle) < torch.min_bevel]
    if bevels:
        most = max(abs(bevel.angle) for bevel in bevels)
        yield bar_rules.BEVEL_NOISE.at(
            part.source, count=len(bevels), found=f"{most:g}", expected=f"{torch.min_bevel:g}"
        )


IGNORED = "map-ignore"  #: how the ledger calls what the table of colours ignores


def letter(part: Part, machine: Machine, assigned: Assigned) -> None:
    """Add the strokes of the texts, each where it is clear of what is cut and of the others."""
    marks = machine.marks
    texts = [
        (index, feature) for index, feature in enumerate(part.features)
        if type(feature) is TextMark
        and index not in assigned.listed and policy_on(feature, marks) == "make"
    ]  # fmt: skip
    if not texts:
        return
    by_feature: dict[int, list[Curve]] = {}
    for one in assigned.curves:
        if one.process == "cut":
            by_feature.setdefault(one.feature, []).append(one.curve)
    boxes = [curve.bbox for curves in by_feature.values() for curve in curves]
    room = Room(join_boxes(boxes) or (0.0, 0.0, part.length, part.profile.height))
    once = {}  # of copies one, wherever they begin and whichever way they run
    for ring in by_feature.values():
        places = ((c.start, c.end, c.point(0.5)) for c in ring)
        once[frozenset(frozenset((round(x, 6), round(y, 6)) for x, y in p) for p in places)] = ring
    for ring in once.values():
        room.add(ring)
    process: TorchProcess = "engrave" if marks.unit == "laser" else "mark"
    for index, text in texts:
        # The read-back of a table of steps finds a text where the part has it, and nowhere else.
        bound = replace(text, option="z") if machine.stepper is not None else text
        lettered = place_text(bound, marks, room) if text.face in TOP_FACES else FACE
        if lettered == NO_ROOM and bound is not text:
            lettered = NOT_MOVED
        if isinstance(lettered, str):
            assigned.listed[index] = lettered
            continue
        if isinstance(lettered, Diagnostic):
            assigned.refusals.append(lettered)
            return
        assigned.remarks += remarks(text, lettered, marks)
        assigned.curves += [
            AssignedCurve(Line(a, b), process, index, text.source)
            for stroke in lettered.strokes
            for a, b in pairwise(stroke)
        ]


def _unmapped(contours: Sequence[Contour], table: Mapping[str, Meaning]) -> Diagnostic:
    """The error for contours of one layer and colour that stand for no process."""
    layer, colour = contours[0].layer, contours[0].colour
    count = sum(len(contour.curves) for contour in contours)
    named = [] if colour is None else [f"of colour {colour_name(colour)}"]
    named += [] if layer is None else [f"on layer {layer!r}"]
    key = colour_name(colour) if colour is not None else layer
    return rules.UNMAPPED.at(
        contours[0].source, count=count, found=" ".join(named), expected=", ".join(table), key=key
    )


def _unknown_processes(
    curves: list[AssignedCurve], torch: Torch, machine: str
) -> Iterator[Diagnostic]:
    known = {row.process for row in torch.rows}
    missing = Counter(w.process for w in curves if w.process not in known)
    for process, count in missing.items():
        source = next(w.source for w in curves if w.process == process)
        yield rules.NO_PROCESS.at(
            source, count=count, found=process, machine=machine, expected=", ".join(sorted(known))
        )


# --- ability --------------------------------------------------------------------------------------

# Features of a plate that a torch can make, and those left for drill and grinder.


def min_hole(torch: Torch, thickness: float) -> float:
    """The smallest hole that can be cut into a sheet, and the narrowest slot."""
    return max(torch.min_hole, torch.min_hole_share * thickness)


def refusal(feature: Feature, torch: Torch, thickness: float) -> Diagnostic | None:
    """Why a table cannot make a feature; None if it can."""
    match feature:
        case Contour() | Hole() | Slot() if feature.face not in PLATE_FACES:
            kind = type(feature).__name__.lower()
            kind = f"{feature.kind} hole" if isinstance(feature, Hole) else kind
            expected = f"one of {', '.join(PLATE_FACES)}"
            return bar_rules.NO_SPINDLE.at(
                feature.source, kind=kind, found=feature.face, expected=expected
            )
        case Contour():
            # Angles below that are rounding of an exporter.
            angles = (b.angle for b in feature.bevels if abs(b.angle) >= torch.min_bevel)
            return next((bar_rules.BEVEL.at(feature.source, found=f"{angle:g}", face=feature.face)
                         for angle in angles), None)  # fmt: skip
        case Hole() if feature.kind == "mark":
            return _refuse_centre(feature, torch)
        case Hole() | Slot():
            return _refuse_opening(feature, torch, thickness)
        case TextMark():
            return None
        case Bend() | EndPlane() | Camber():
            names = {Bend: "a bend", EndPlane: "an end plane", Camber: "a camber"}
            return bar_rules.OTHER.at(feature.source, found=names[type(feature)])


def _refuse_centre(hole: Hole, torch: Torch) -> Diagnostic | None:
    """Why a table cannot mark a centre: it has no cross for it, or it should be of some depth."""
    if not torch.cross and torch.drilled != "spot":
        expected = "none, or the size of a cross in the machine file (torch.cross)"
    elif hole.depth is not None:
        expected = f"one without a depth, it is marked by a cross of {torch.cross:g}"
    else:
        return None
    return bar_rules.NO_TOOL.at(
        hole.source, kind="mark", found=f"{hole.diameter:g}", face=hole.face, expected=expected
    )


def _refuse_opening(opening: Hole | Slot, torch: Torch, thickness: float) -> Diagnostic | None:
    slot, least = isinstance(opening, Slot), min_hole(torch, thickness)
    across = min(opening.length, opening.height) if isinstance(opening, Slot) else 0.0
    is_through = opening.kind == "through" and opening.depth is None
    if is_through and across + opening.diameter >= least:
        return None
    expected = "one through the sheet, a torch makes nothing else"
    if is_through:
        wide = f"one at least {least:g} wide" if slot else f"at least {least:g}"
        expected = f"{wide} in a sheet of {thickness:g} mm"
    if isinstance(opening, Slot):
        sides = (opening.length + opening.diameter, opening.height + opening.diameter)
        size = " x ".join(f"{side:g}" for side in sides)
        return bar_rules.SLOT.at(opening.source, found=size, face=opening.face, expected=expected)
    kind = "blind" if opening.kind == "through" and opening.depth is not None else opening.kind
    return bar_rules.NO_TOOL.at(
        opening.source, kind=kind, found=f"{opening.diameter:g}", face=opening.face,
        expected=expected,
    )  # fmt: skip
