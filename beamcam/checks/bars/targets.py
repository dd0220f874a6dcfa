"""Features required by a part: the result at the end, not how it is made.

hole               a drilled hole of a size that fits; larger than any drill: one milled round
thread             a tapped hole, and below it that of the drill
countersink        a sink in the hole that it widens
mark of a punch    a punch mark
slot               a pocket; holes at its ends may be in it
line to mark       a scribed line
outer contour      nothing, where the ends of the stock give it
end plane          nothing, where it is the start or the end

What nothing of the machine makes is a `Unmakeable`.
"""

from collections.abc import Collection, Iterator
from math import cos, floor, hypot, inf, radians, sin, tan
from typing import TypeVar

from msgspec import Struct
from msgspec.structs import replace

from beamcam.checks.bars.cuts import off_outline
from beamcam.checks.bars.pieces import ANGLE_TOLERANCE_DEG, Ends
from beamcam.checks.bars.stations import wall_thickness
from beamcam.checks.bars.tools import ToolCatalogue
from beamcam.checks.job import is_manual_work
from beamcam.checks.within import needless
from beamcam.geometry.curves import Curve, Point
from beamcam.machine.machine import saw_of
from beamcam.machine.stations import FLAT_DEG
from beamcam.model.description import description
from beamcam.model.part import (
    Bend,
    Camber,
    Contour,
    EndPlane,
    Face,
    Feature,
    Hole,
    Part,
    Slot,
    TextMark,
)
from beamcam.model.request import policy_on
from beamcam.model.section import OTHER_SIDE, corners

PLAIN_KINDS = ("through", "blind")  #: of a hole that a drill alone makes
PLANE_TOLERANCE = 0.1  #: mm between an end plane and the end that it states, at any corner
THREADS = ("thread", "left-thread")


class RoundKind(Struct, frozen=True, gc=False):
    """A round thing that a tool of one kind leaves, wherever it is."""

    tool: str  #: kind of the tool
    what: str  #: for messages
    least: float  #: diameters of the tool that leave it
    most: float
    own: float  #: the tool's diameter, for messages
    hole: Hole  #: of which it is, or a part of it; a slot's end as a hole
    pitch: float = 0.0
    pilot: float = 0.0  #: diameter of the hole that a countersink widens


class RequiredRound(Struct, frozen=True, gc=False):
    """A round thing at its place on the part."""

    feature: int
    x: float
    y: float
    face: Face
    kind: RoundKind
    optional: bool = False  #: whether it may be there or not


class RequiredPocket(Struct, frozen=True, gc=False):
    """A hole or slot that a mill goes round in: a rectangle with round corners."""

    feature: int
    face: Face
    slot: Slot  #: the same as `source`; of a hole one without length
    what: str
    source: Hole | Slot


class MarkingPath(Struct, frozen=True, gc=False):
    """A line that a scribe follows."""

    feature: int
    face: Face
    curves: tuple[Curve, ...]
    source: Contour | TextMark
    what: str = "line to mark"


class Unmakeable(Struct, frozen=True, gc=False):
    """A feature, or a part of one, that the machine cannot make."""

    feature: int
    what: str
    name: str  #: that `--allow-skips` calls it by
    source: Feature
    place: Point | None = None  #: of an outline


Target = RequiredRound | RequiredPocket | MarkingPath | Unmakeable


def targets_of(part: Part, ends: Ends, tools: ToolCatalogue) -> list[Target]:
    """Requirements of every feature of a part; duplicate holes count once."""
    kinds: dict[tuple[object, ...], RoundKind | None] = {}
    targets: list[Target] = []
    works = {face for face in tools.faces if tools.works_on(face, part)}
    for f, feature in _once(part, works, tools):
        if type(feature) is Hole and feature.kind in PLAIN_KINDS:
            face, diameter = feature.face, feature.diameter
            key = face, diameter, feature.depth
            if key not in kinds:
                kinds[key] = None
                fitting, limits = tools.fits("drill", diameter, face), tools.fit(diameter)
                if fitting and limits is not None and face in works:
                    what = f"hole {diameter:g}"
                    kinds[key] = RoundKind("drill", what, *limits, fitting[0], feature)
            if (kind := kinds[key]) is not None:
                targets.append(RequiredRound(f, feature.x, feature.y, face, kind))
                continue
        targets += _targets(f, feature, part, ends, tools)
    return targets


Either = TypeVar("Either", bound=Hole | Slot)


def from_behind(hole: Either, part: Part, tools: ToolCatalogue) -> Either:
    """A through hole or slot on the plate's other side, if it is only there that it is made."""
    if tools.works_on(hole.face, part):
        return hole
    other = OTHER_SIDE.get(part.profile.code, {}).get(hole.face)
    through = hole.kind == "through" and hole.depth is None
    return replace(hole, face=other) if through and other in tools.faces else hole


def _once(
    part: Part, works: Collection[Face], tools: ToolCatalogue
) -> Iterator[tuple[int, Feature]]:
    """The features, those made from the plate's other side there, holes written twice once."""
    tolerance = tools.twice
    seen: dict[tuple[Face, int], list[Hole]] = {}  # by the millimetres of x that they are near to
    gone = needless(part)
    for f, feature in enumerate(part.features):
        if f in gone:
            continue
        if type(feature) is not Hole:
            yield f, from_behind(feature, part, tools) if type(feature) is Slot else feature
            continue
        hole = feature if feature.face in works else from_behind(feature, part, tools)
        # Most x are whole millimetres, in the middle of their own.
        face, x = hole.face, hole.x + 0.5
        near = seen.get((face, floor(x)))
        if near and any(is_same(hole, other, tolerance) for other in near):
            continue
        for place in range(floor(x - tolerance), floor(x + tolerance) + 1):
            seen.setdefault((face, place), []).append(hole)
        yield f, hole


def is_same(hole: Hole, other: Hole, tolerance: float) -> bool:
    """Whether two holes of one face are one that was written twice."""
    return (
        abs(hole.x - other.x) <= tolerance
        and abs(hole.y - other.y) <= tolerance
        and hole.diameter == other.diameter
        and (hole.kind, hole.depth, hole.angle) == (other.kind, other.depth, other.angle)
    )


def _targets(
    f: int,
    feature: Feature,
    part: Part,
    ends: Ends,
    tools: ToolCatalogue,
) -> Iterator[Target]:
    if is_manual_work(feature, tools.machine):
        return
    if policy_on(feature, tools.machine.marks) == "refuse":
        yield Unmakeable(f, f"the {description(feature)}", "mark", feature)
        return
    match feature:
        case Hole():
            yield from _hole(f, feature, part, tools)
        case Slot():
            yield from _slot(f, feature, part, tools)
        case Contour(process="cut", kind="outer"):
            off = off_outline(feature, part, ends)
            if off is not None:
                yield Unmakeable(f, "the outline", "cope", feature, off)
            elif _unsawn_bevel(feature, ends, saw_of(tools.machine).min_mitre):
                yield Unmakeable(f, "the bevel", "bevel", feature)
        case Contour(process="cut"):
            yield Unmakeable(f, "the cut-out", "cutout", feature)
        case Contour():
            if tools.works_on(feature.face, part) and any(tools.of("scribe", feature.face)):
                yield MarkingPath(f, feature.face, feature.curves, feature)
            else:
                yield Unmakeable(f, "the line to mark", "mark", feature)
        case TextMark():
            return  # its position is taken from the program: see texts.py
        case Bend():
            yield Unmakeable(f, "the bend", "other", feature)
        case EndPlane():
            if _takes_more(feature, part, ends):
                yield Unmakeable(f, "the end plane", "other", feature)
        case Camber():
            yield Unmakeable(f, "the camber", "other", feature)


def _takes_more(plane: EndPlane, part: Part, ends: Ends) -> bool:
    """Whether a plane takes off steel that the ends leave, by the part's angles and length."""
    places, end = corners(part.profile, part.section), ends[plane.normal[0] > 0]
    if all(abs(plane.x(y, z) - end.x(y, z)) <= PLANE_TOLERANCE for y, z in places):
        return False
    (px, py, pz), (a, b, c) = plane.point, plane.normal
    within = PLANE_TOLERANCE * hypot(a, b, c)
    return any(
        a * (end.x(y, z) - px) + b * (y - py) + c * (z - pz) > within
        for end in ends
        for y, z in places
    )


def _unsawn_bevel(contour: Contour, ends: Ends, least_deg: float) -> bool:
    """Whether a contour has a weld preparation that no skew end of the part makes.

    Below the least angle that a saw is turned by it is a rounding error of the file.
    """
    angles = [e.flange if contour.face in ("v", "h") else e.web for e in ends]
    return any(
        all(not a or abs(abs(bevel.angle) - abs(a)) > ANGLE_TOLERANCE_DEG for a in angles)
        for bevel in contour.bevels
        if abs(bevel.angle) >= least_deg
    )


def _hole(f: int, hole: Hole, part: Part, tools: ToolCatalogue) -> Iterator[Target]:
    size = f"{hole.diameter:g}"
    if not tools.works_on(hole.face, part):
        yield Unmakeable(f, f"the hole {size}", "face", hole)
    elif hole.kind in PLAIN_KINDS:
        # Drilled ones are known by now.
        if tools.mills_round(hole.diameter, hole.face):
            slot = Slot(
                hole.face, hole.x, hole.y, hole.diameter, 0.0, 0.0, 0.0, hole.source, hole.depth
            )
            yield RequiredPocket(f, hole.face, slot, f"hole {size}", hole)
        else:
            yield Unmakeable(f, f"the hole {size}", "tool", hole)
    elif hole.kind in THREADS:
        yield from _thread(f, hole, part, tools)
    elif hole.kind == "countersink":
        yield from _countersink(f, hole, part, tools)
    elif any(tools.of("punch", hole.face)):
        own = next(iter(tools.sizes("punch", hole.face)), 0.0)
        kind = RoundKind("punch", "punch mark", 0.0, inf, own, hole)
        yield RequiredRound(f, hole.x, hole.y, hole.face, kind)
    else:
        yield Unmakeable(f, "the punch mark", "mark", hole)


def _thread(f: int, hole: Hole, part: Part, tools: ToolCatalogue) -> Iterator[Target]:
    name = f"thread M{hole.diameter:g}"
    tap = tools.tap(hole)
    drills = tools.fits("drill", tap[2], hole.face) if tap else ()
    if tap is None or not drills:
        yield Unmakeable(f, f"the {name}", "tool", hole)
        return
    size, pitch, before = tap
    thickness = wall_thickness(part.profile, hole.face)
    if hole.depth is not None and thickness:
        runout = tools.drill.runout_pitches * pitch + tools.tip("drill", drills[0], hole.face)
        if hole.depth + runout > thickness + 1e-9:  # the drill would come out on the other side
            yield Unmakeable(f, f"the {name}", "thread-depth", hole)
            return
    least, most = tools.fit(before) or (before, before)
    place = (f, hole.x, hole.y, hole.face)
    yield RequiredRound(
        *place, RoundKind("drill", f"hole before the {name}", least, most, drills[0], hole)
    )
    yield RequiredRound(*place, RoundKind("tap", name, size, size, size, hole, pitch))


def _countersink(f: int, sink: Hole, part: Part, tools: ToolCatalogue) -> Iterator[Target]:
    name, diameter = f"countersink {sink.diameter:g}", sink.diameter
    cone, pilot, reason = sink.angle or FLAT_DEG, _pilot(sink, part, tools), ""
    least, most = tools.fit(diameter) or (diameter, diameter)
    if pilot is None:
        reason = "countersink"
    elif cone < FLAT_DEG:
        alone = (diameter - pilot) / 2 / tan(radians(cone) / 2)
        deep = sink.depth or alone
        if deep < alone - tools.drill.sink_tolerance:
            reason = "sink-depth"
        elif deep <= alone + tools.drill.sink_tolerance:  # its rim lies on the surface
            least, most = diameter - 1e-6, inf
    elif not sink.depth:
        reason = "tool"
    sizes = [d for t in tools.of("countersink", sink.face) if t.point_deg == cone for d in t.sizes]
    if not reason and not any(least <= d <= most for d in sizes):
        reason = "tool"
    if pilot is None or reason:
        yield Unmakeable(f, f"the {name}", reason, sink)
        return
    kind = RoundKind("countersink", name, least, most, diameter, sink, pilot=pilot)
    yield RequiredRound(f, sink.x, sink.y, sink.face, kind)


def _pilot(sink: Hole, part: Part, tools: ToolCatalogue) -> float | None:
    """Diameter of the widest hole made that a countersink stands on; None if there is none."""
    tolerance, gone = tools.drill.merge_tolerance + 1e-9, needless(part)
    near = (
        from_behind(h, part, tools) for f, h in enumerate(part.features)
        if isinstance(h, Hole) and f not in gone
        and abs(h.x - sink.x) <= tolerance and abs(h.y - sink.y) <= tolerance
    )  # fmt: skip
    below = [
        h.diameter
        for h in near
        if h.kind in (*PLAIN_KINDS, *THREADS) and h.face == sink.face and h.diameter < sink.diameter
    ]
    return max(below, default=None)


def _slot(f: int, slot: Slot, part: Part, tools: ToolCatalogue) -> Iterator[Target]:
    along, across = slot.length + slot.diameter, slot.height + slot.diameter
    what = f"slot {along:g} x {across:g}"
    mills = tools.sizes("mill", slot.face)
    fits = bool(mills) and mills[0] <= slot.diameter + tools.drill.same_tool_tolerance
    if slot.kind not in PLAIN_KINDS or not fits:
        yield Unmakeable(f, f"the {what}", "slot", slot)
        return
    if not tools.works_on(slot.face, part):
        yield Unmakeable(f, f"the {what}", "face", slot)
        return
    yield RequiredPocket(f, slot.face, slot, what, slot)
    _, most = tools.fit(slot.diameter) or (0.0, slot.diameter)
    for x, y in slot_corners(slot):
        end = Hole(slot.face, x, y, slot.diameter, slot.source, slot.depth)
        kind = RoundKind("drill", f"end of the {what}", 0.0, most, slot.diameter, end)
        yield RequiredRound(f, x, y, slot.face, kind, True)


def slot_corners(slot: Slot) -> Iterator[Point]:
    """Centres of the corner circles of a slot: two, or four of a rectangle."""
    c, s = cos(radians(slot.angle)), sin(radians(slot.angle))
    corners = dict.fromkeys(
        (a * slot.length / 2, b * slot.height / 2) for a in (-1, 1) for b in (-1, 1)
    )
    for a, b in corners:
        yield slot.x + c * a - s * b, slot.y + s * a + c * b
