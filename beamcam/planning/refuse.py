"""What a line cannot make of a bar or a part, and why."""

from collections.abc import Collection, Iterator, Mapping, Sequence
from math import dist, inf

from msgspec import Struct

from beamcam.caches import BoundedCache, PerObject
from beamcam.errors import Diagnostic
from beamcam.machine.machine import Drill, Layout, Machine, Saw
from beamcam.model.part import (
    Bend,
    Camber,
    Contour,
    EndPlane,
    Face,
    Feature,
    Hole,
    Part,
    Profile,
    Slot,
    TextMark,
)
from beamcam.model.section import NO_PLATE, OTHER_SIDE, section_fault
from beamcam.planning import rules
from beamcam.planning.ends import End, leaves_stock
from beamcam.planning.merging import Group, too_near
from beamcam.planning.operations.rules import SECTION_SHAPE
from beamcam.planning.tools import Rack


def refuse_stock(
    parts: Sequence[Part], machine: Machine, saw: Saw, drill: Drill, layout: Layout
) -> Iterator[Diagnostic]:
    """What is wrong with the section of the bar."""
    profile = parts[0].profile
    for part in parts:
        mine = part.profile
        if mine.code not in layout.profiles or mine.code not in machine.sections:
            yield rules.STOCK.at(
                part.source, found=mine.code, machine=machine.name,
                expected=", ".join(layout.profiles),
            )  # fmt: skip
        elif mine is not profile and mine != profile:
            yield rules.MIXED_PROFILES.at(part.source, found=mine.name, expected=profile.name)
        fault = section_fault(mine)
        if fault is not None:
            yield SECTION_SHAPE.at(part.source, found=fault, code=mine.code)
        for station, size in (("saw", saw), ("drill", drill)):
            if mine.height > size.max_height or mine.width > size.max_width:
                yield rules.SECTION_SIZE.at(
                    part.source, found=f"{mine.height:g} x {mine.width:g}", station=station,
                    expected=f"{size.max_height:g} x {size.max_width:g}",
                )  # fmt: skip


class Reach(Struct, frozen=True):
    """What a spindle comes to on a face of a section."""

    spindle: int  #: number
    width: float  #: of the face
    least: float  #: y between which nothing is in the tool's way
    greatest: float


def _no_reaches(_: Machine) -> BoundedCache[Profile, Mapping[Face, Reach]]:
    return BoundedCache("planning.reaches")


_reaches = PerObject("planning.machines", _no_reaches)


def reach_of(profile: Profile, machine: Machine) -> Mapping[Face, Reach]:
    """The faces of a section that the machine's spindles reach."""
    known = _reaches(machine)
    found = known.get(profile)
    if found is None:
        out = NO_PLATE.get(profile.code, ())
        found = {
            s.face: Reach(s.number, profile.face_width(s.face), *clear_between(profile, s.face))
            for s in machine.spindles
            if s.face not in out
        }
        known.keep(profile, found)
    return found


def face_at_work(face: Face, is_through: bool, profile: Profile, reached: Collection[Face]) -> Face:
    """The face that a hole is made from: its own, or for a through hole the plate's other side."""
    if face in reached or not is_through:
        return face
    behind = OTHER_SIDE.get(profile.code, {}).get(face, face)
    return behind if behind in reached else face


def refuse_place(
    hole: Hole | Slot, face: Face, part: Part, reached: Collection[Face]
) -> Diagnostic | None:
    """Why no spindle comes to a hole; None if one does. A slot's corner circles count."""
    if face not in reached:
        kind = "slot" if isinstance(hole, Slot) else hole.kind
        return rules.NO_SPINDLE.at(
            hole.source, kind=f"{kind} hole", found=hole.face, expected=", ".join(reached) or "none"
        )
    width = part.profile.face_width(face)
    if not (0 <= hole.x <= part.length and 0 <= hole.y <= width):
        return rules.OFF_FACE.at(
            hole.source, x=f"{hole.x:g}", y=f"{hole.y:g}", face=hole.face,
            length=f"{part.length:g}", width=f"{width:g}",
        )  # fmt: skip
    radius = hole.diameter / 2
    least, greatest = clear_between(part.profile, face)
    if not least <= hole.y - radius or not hole.y + radius <= greatest:
        return rules.IN_THE_WAY.at(
            hole.source, what=f"a hole of diameter {hole.diameter:g}", y=f"{hole.y:g}",
            face=hole.face, least=f"{least + radius:g}", greatest=f"{greatest - radius:g}",
        )  # fmt: skip
    return None


def refuse_too_near(holes: Group, machine: Machine) -> Iterator[tuple[int, Diagnostic]]:
    """The holes beside one that a program cannot tell them apart from, by their indices."""
    resolution, drill = machine.format.resolution, machine.drill
    if drill is not None and 2 * resolution <= drill.duplicate_tolerance:
        return  # what is as near as that is one hole, and there once
    for (_, f, hole), (_, _, first) in too_near(holes, resolution):
        apart = dist((hole.x, hole.y), (first.x, first.y))
        yield f, rules.TOO_NEAR.at(
            hole.source, found=f"{hole.diameter:g}", face=hole.face, x=f"{hole.x:g}",
            y=f"{hole.y:g}", apart=f"{apart:.3g}", first=first.source,
            expected=f"{2 * resolution:g}",
        )  # fmt: skip


def clear_between(profile: Profile, face: Face) -> tuple[float, float]:
    """y between which a tool reaches a face; without bounds where no flange stands beside it."""
    if face != "v" or profile.code not in ("I", "U", "C", "L"):
        return -inf, inf
    flange = profile.flange_thickness
    return flange, (inf if profile.code == "L" else profile.height - flange)


def refuse_slot(slot: Slot, face: Face, rack: Rack) -> Diagnostic | None:
    """Why no mill makes a slot; None if one does."""
    size = f"{slot.length + slot.diameter:g} x {slot.height + slot.diameter:g}"
    if slot.kind not in ("through", "blind"):
        return rules.SLOT.at(
            slot.source, found=size, face=slot.face, expected=f"a slot without a {slot.kind}"
        )
    if not rack.slot_mill(slot.diameter, (face,)):
        mills = rack.of_kind("mill", (face,))
        expected = "no slot, the machine has no mill"
        if mills:
            expected = f"one at least {mills[0].diameter:g} wide, as the smallest mill"
        return rules.SLOT.at(slot.source, found=size, face=slot.face, expected=expected)
    return None


def refuse_other(
    feature: Feature, part: Part, ends: tuple[End, End], rack: Rack, reached: Collection[Face]
) -> Diagnostic | None:
    """Why the line cannot make a feature that is no hole or slot; None if it can."""
    match feature:
        case TextMark():
            return _refuse_mark(f"the text {feature.text!r}", feature, rack, reached, True)
        case Contour():
            return _refuse_contour(feature, part, ends, rack, reached)
        case Bend() | EndPlane() | Camber():
            names = {Bend: "a bend", EndPlane: "an end plane", Camber: "a camber"}
            return rules.OTHER.at(feature.source, found=names[type(feature)])
        case Hole() | Slot():
            return None


def _refuse_mark(
    found: str, mark: TextMark | Contour, rack: Rack, reached: Collection[Face], is_text: bool
) -> Diagnostic | None:
    if mark.face not in reached or not rack.of_kind("scribe", (mark.face,)):
        return rules.MARK.at(mark.source, found=found, face=mark.face, tool="scribe")
    if is_text:
        return rules.MARK.at(mark.source, found=found, face=mark.face, tool="stamp")
    return None


def _refuse_line(found: str, line: Contour, part: Part) -> Diagnostic | None:
    """Why a scribe does not come to all of a line; None if it does."""
    least, greatest = clear_between(part.profile, line.face)
    ys = [y for curve in line.curves for y in curve.bbox[1::2]]
    out = next((y for y in (min(ys), max(ys)) if not least <= y <= greatest), None)
    if out is None:
        return None
    return rules.IN_THE_WAY.at(
        line.source, what=found, y=f"{out:g}", face=line.face, least=f"{least:g}",
        greatest=f"{greatest:g}",
    )  # fmt: skip


def _refuse_contour(
    contour: Contour, part: Part, ends: tuple[End, End], rack: Rack, reached: Collection[Face]
) -> Diagnostic | None:
    if contour.process != "cut":
        length = f"{sum(curve.length for curve in contour.curves):g} mm of line"
        return _refuse_mark(length, contour, rack, reached, False) or _refuse_line(
            f"{length} to mark", contour, part
        )
    if contour.kind != "outer":
        boxes = [curve.bbox for curve in contour.curves]
        size = (
            f"{max(b[2] for b in boxes) - min(b[0] for b in boxes):g} x "
            f"{max(b[3] for b in boxes) - min(b[1] for b in boxes):g}"
        )
        return rules.CUTOUT.at(contour.source, found=size, face=contour.face)
    corner = leaves_stock(contour, part, ends)
    if corner is not None:
        return rules.COPE.at(
            contour.source, face=contour.face, x=f"{corner[0]:g}", y=f"{corner[1]:g}"
        )
    for bevel in contour.bevels:
        if not _is_sawn(bevel.angle, contour.face, ends):
            return rules.BEVEL.at(contour.source, found=f"{bevel.angle:g}", face=contour.face)
    return None


def _is_sawn(bevel_deg: float, face: Face, ends: tuple[End, End]) -> bool:
    """Whether an end cut leaves this bevel: a web's mitre on the flanges, a flange's on the web."""
    on_web = face in ("v", "h")
    leaves = (end.flange_deg if on_web else end.web_deg for end in ends)
    return any(angle and abs(abs(bevel_deg) - abs(angle)) <= 0.2 for angle in leaves)
