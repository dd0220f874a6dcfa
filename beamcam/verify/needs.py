"""What the features of a part need, feature by feature, computed without the planner.

hole               drill; larger than any drill: a mill led round
thread             the drill before the tap, and the tap
countersink        a sink in the hole that it widens
mark of a punch    a punch
slot               a mill led round; its ends may be drilled before
line to mark       a scribe led along it
outer contour      nothing, where the ends of the stock give it
"""

from collections.abc import Collection, Iterator, Sequence
from math import cos, floor, radians, sin, tan
from typing import NamedTuple, TypeVar

from msgspec import Struct
from msgspec.structs import replace

from beamcam.geometry.curves import Curve, Point
from beamcam.machine.machine import FLAT_DEG
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
from beamcam.verify.ends import ANGLE_TOLERANCE_DEG, End, off_outline
from beamcam.verify.rack import Rack

FeatureRef = tuple[int, int]  #: index of the part on the bar, index of its feature

#: Faces that are the other side of one plate; an angle's only flange has its outside on u.
OTHER_SIDE = {
    **{code: {"h": "v"} for code in ("I", "U", "C", "T", "B")},
    "L": {"h": "v", "o": "u"},
}
#: Faces that no spindle works on, by section: what would stand there is not, or not in its way.
NO_PLATE = {"L": ("o",), "T": ("o", "u")}
PLAIN_KINDS = ("through", "blind")  #: of a hole that a drill alone makes
THREADS = ("thread", "left-thread")


class Stroke(NamedTuple):
    """A stroke of a tool that a feature needs."""

    part: int
    hole: Hole  #: that it makes or helps to make; a slot's end as a hole
    kind: str  #: of the tool
    x: float  #: on the part; of two that are made at once each its own
    what: str  #: for messages
    diameter: float  #: of the tool wanted
    pilot: float = 0.0  #: diameter of the hole that a countersink widens
    optional: bool = False


class Pocket(Struct, frozen=True):
    """A hole or slot that a mill is led round in: a rectangle with round corners."""

    part: int
    face: Face
    x: float  #: of the centre, on the part
    y: float
    length: float  #: between the corner circles' centres, along the angle
    height: float  #: and across
    angle: float  #: degrees
    diameter: float  #: of the corner circles
    depth: float | None
    what: str
    source: Hole | Slot


class Course(Struct, frozen=True):
    """A line that a scribe is led along."""

    part: int
    face: Face
    curves: tuple[Curve, ...]
    source: Contour


class Lack(Struct, frozen=True):
    """A feature, or something of it, that the machine's program has no way to make."""

    part: int
    what: str
    name: str  #: that `--allow-skips` calls it by
    feature: Feature
    place: tuple[float, float] | None = None  #: of an outline


Need = Stroke | Pocket | Course | Lack


def needs_of(
    parts: Sequence[Part],
    ends: Sequence[tuple[End, End]],
    rack: Rack,
    skipped: Collection[FeatureRef],
    holes: bool = True,
) -> list[tuple[FeatureRef, Need]]:
    """What every feature needs that is not skipped, part by part; a hole written twice once.

    Without `holes` it is what all else needs.
    """
    found: list[tuple[FeatureRef, Need]] = []
    seen: dict[int, list[tuple[int, Need]]] = {}
    for p, part in enumerate(parts):
        known = seen.get(id(part))
        if known is None or skipped:
            left = [*enumerate(part.features)]
            if not holes:
                left = [(f, x) for f, x in left if type(x) is not Hole]
            if skipped:
                left = [(f, x) for f, x in left if (p, f) not in skipped]
            known = _part_needs(left, p, part, ends[p], rack) if left else []
            seen[id(part)] = known
            found += [((p, f), need) for f, need in known]
        else:  # the same part again
            found += [((p, f), _moved(need, p)) for f, need in known]
    return found


def _moved(need: Need, part: int) -> Need:
    """The same need of another piece."""
    return need._replace(part=part) if isinstance(need, Stroke) else replace(need, part=part)


def _part_needs(
    features: Sequence[tuple[int, Feature]], p: int, part: Part, ends: tuple[End, End], rack: Rack
) -> list[tuple[int, Need]]:
    """What the features of a part need, by their indices."""
    found: list[tuple[int, Need]] = []
    works = {face for face in rack.faces if works_on(face, part, rack)}
    for f, feature in _once(features, part, rack, works):
        if type(feature) is Hole and feature.kind in PLAIN_KINDS:
            # Most features are plain holes, and most of those like one before.
            plain = rack.plain(feature.diameter, feature.face)
            if plain is not None and feature.face in works:
                found.append((f, Stroke(p, feature, "drill", feature.x, *plain)))
                continue
        found += [(f, need) for need in _needs(feature, p, part, ends, rack)]
    return found


def _once(
    features: Sequence[tuple[int, Feature]], part: Part, rack: Rack, works: Collection[Face]
) -> Iterator[tuple[int, Feature]]:
    """The features, those made from the plate's other side there, holes written twice once."""
    tolerance = rack.twice
    seen: dict[tuple[Face, int], list[Hole]] = {}  # by the nearest millimetre of x
    for f, feature in features:
        if type(feature) is Slot:
            yield f, from_behind(feature, part, rack, works)
            continue
        if type(feature) is not Hole:
            yield f, feature
            continue
        hole = feature if feature.face in works else from_behind(feature, part, rack, works)
        # Most x are whole millimetres, in the middle of their own.
        face, x = hole.face, hole.x + 0.5
        low, high = floor(x - tolerance), floor(x + tolerance)
        if low == high:
            near = seen.get((face, low), ())
        else:
            near = [h for place in range(low, high + 1) for h in seen.get((face, place), ())]
        if near and any(is_same(hole, other, tolerance) for other in near):
            continue
        seen.setdefault((face, floor(x)), []).append(hole)
        yield f, hole


Round = TypeVar("Round", bound=Hole | Slot)


def from_behind(hole: Round, part: Part, rack: Rack, works: Collection[Face]) -> Round:
    """A through hole or slot on the plate's other side, if it is only there that it is made."""
    other = OTHER_SIDE.get(part.profile.code, {}).get(hole.face)
    through = hole.kind == "through" and hole.depth is None
    if hole.face in works or not through or other not in rack.faces:
        return hole
    return replace(hole, face=other)


def is_same(hole: Hole, other: Hole, tolerance: float) -> bool:
    """Whether two holes of one face are one that was written twice."""
    return (
        abs(hole.x - other.x) <= tolerance
        and abs(hole.y - other.y) <= tolerance
        and hole.diameter == other.diameter
        and (hole.kind, hole.depth, hole.angle) == (other.kind, other.depth, other.angle)
    )


def works_on(face: Face, part: Part, rack: Rack) -> bool:
    """Whether a spindle works on a face of a part."""
    return face in rack.faces and face not in NO_PLATE.get(part.profile.code, ())


def _needs(
    feature: Feature, p: int, part: Part, ends: tuple[End, End], rack: Rack
) -> Iterator[Need]:
    match feature:
        case Hole():
            yield from _hole(feature, p, part, rack)
        case Slot():
            yield from _slot(feature, p, part, rack)
        case Contour(process="cut", kind="outer"):
            off = off_outline(feature, part, ends)
            if off is not None:
                yield Lack(p, "the outline", "cope", feature, off)
            elif _unsawn_bevel(feature, ends):
                yield Lack(p, "the bevel", "bevel", feature)
        case Contour(process="cut"):
            yield Lack(p, "the cut-out", "cutout", feature)
        case Contour():
            if works_on(feature.face, part, rack) and any(rack.of("scribe", feature.face)):
                yield Course(p, feature.face, feature.curves, feature)
            else:
                yield Lack(p, "the line to mark", "mark", feature)
        case TextMark():
            yield Lack(p, f"the text {feature.text!r}", "mark", feature)
        case Bend():
            yield Lack(p, "the bend", "other", feature)
        case EndPlane():
            yield Lack(p, "the end plane", "other", feature)
        case Camber():
            yield Lack(p, "the camber", "other", feature)


def _unsawn_bevel(contour: Contour, ends: tuple[End, End]) -> bool:
    """Whether a contour has a weld preparation that no skew end of the part makes."""
    angles = [e.flange if contour.face in ("v", "h") else e.web for e in ends]
    return any(
        all(not a or abs(abs(bevel.angle) - abs(a)) > ANGLE_TOLERANCE_DEG for a in angles)
        for bevel in contour.bevels
    )


def _hole(hole: Hole, p: int, part: Part, rack: Rack) -> Iterator[Need]:
    size = f"{hole.diameter:g}"
    if not works_on(hole.face, part, rack):
        yield Lack(p, f"the hole {size}", "face", hole)
    elif hole.kind in PLAIN_KINDS:
        plain = rack.plain(hole.diameter, hole.face)
        if plain is not None:
            yield Stroke(p, hole, "drill", hole.x, *plain)
        elif rack.milled(hole.diameter, hole.face):
            yield Pocket(
                p, hole.face, hole.x, hole.y, 0.0, 0.0, 0.0, hole.diameter, hole.depth,
                f"hole {size}", hole,
            )  # fmt: skip
        else:
            yield Lack(p, f"the hole {size}", "tool", hole)
    elif hole.kind in THREADS:
        tap = rack.tap(hole)
        drill = tap and rack.drills(tap[2], hole.face)
        if tap is None or not drill:
            yield Lack(p, f"the thread M{size}", "tool", hole)
        elif _too_deep(hole, part, tap, drill, rack):
            yield Lack(p, f"the thread M{size}", "thread-depth", hole)
        else:
            yield Stroke(p, hole, "drill", hole.x, f"hole before the thread M{size}", drill)
            yield Stroke(p, hole, "tap", hole.x, f"thread M{size}", tap[0])
    elif hole.kind == "countersink":
        pilot = _pilot(hole, part, rack)
        lack = _no_sink(hole, pilot, rack)
        if pilot is None or lack:
            yield Lack(p, f"the countersink {size}", lack, hole)
        else:
            yield Stroke(
                p, hole, "countersink", hole.x, f"countersink {size}", hole.diameter, pilot
            )
    elif any(rack.of("punch", hole.face)):
        yield Stroke(p, hole, "punch", hole.x, "punch mark", 0.0)
    else:
        yield Lack(p, "the punch mark", "mark", hole)


def _too_deep(
    hole: Hole, part: Part, tap: tuple[float, float, float], drill: float, rack: Rack
) -> bool:
    """Whether the drill before a blind thread would come out on the other side."""
    thickness = part.profile.thickness(hole.face)
    if hole.depth is None or not thickness:
        return False
    reach = hole.depth + rack.drill.runout_pitches * tap[1] + rack.tip("drill", drill, hole.face)
    return reach > thickness + 1e-9


def _no_sink(hole: Hole, pilot: float | None, rack: Rack) -> str:
    """Why a countersink cannot be made, as `--allow-skips` calls it; "" if it can."""
    if pilot is None:
        return "countersink"
    cone = hole.angle or FLAT_DEG
    fit = rack.fit(hole.diameter)
    sizes = [d for t in rack.of("countersink", hole.face) if t.point_deg == cone for d in t.sizes]
    exact = fit is not None and any(fit[0] <= d <= fit[1] for d in sizes)
    if cone >= FLAT_DEG:
        return "" if exact and hole.depth else "tool"
    alone = (hole.diameter - pilot) / 2 / tan(radians(cone) / 2)
    deep = hole.depth or alone
    if deep < alone - rack.drill.sink_tolerance:
        return "sink-depth"
    below = deep > alone + rack.drill.sink_tolerance
    return "" if (exact if below else any(d >= hole.diameter - 1e-9 for d in sizes)) else "tool"


def _pilot(sink: Hole, part: Part, rack: Rack) -> float | None:
    """Diameter of the widest hole that a countersink stands on; None if there is none."""
    tolerance = rack.drill.merge_tolerance + 1e-9
    works = {face for face in rack.faces if works_on(face, part, rack)}
    near = (
        from_behind(h, part, rack, works) for h in part.holes
        if abs(h.x - sink.x) <= tolerance and abs(h.y - sink.y) <= tolerance
    )  # fmt: skip
    below = [
        h.diameter for h in near
        if h.kind in ("through", "blind", *THREADS)
        and h.face == sink.face
        and h.diameter < sink.diameter
    ]  # fmt: skip
    return max(below, default=None)


def _slot(slot: Slot, p: int, part: Part, rack: Rack) -> Iterator[Need]:
    along, across = slot.length + slot.diameter, slot.height + slot.diameter
    what = f"slot {along:g} x {across:g}"
    mills = [d for t in rack.of("mill", slot.face) for d in t.sizes]
    fits = min(mills, default=slot.diameter + 1) <= slot.diameter + rack.drill.twin
    if slot.kind not in ("through", "blind") or not works_on(slot.face, part, rack) or not fits:
        yield Lack(p, f"the {what}", "slot", slot)
        return
    yield Pocket(
        p, slot.face, slot.x, slot.y, slot.length, slot.height, slot.angle, slot.diameter,
        slot.depth, what, slot,
    )  # fmt: skip
    drill = rack.drills(slot.diameter, slot.face)
    if drill is None:
        return
    for x, y in slot_corners(slot):
        end = Hole(slot.face, x, y, slot.diameter, slot.source, slot.depth)
        yield Stroke(p, end, "drill", x, f"end of the {what}", drill, 0.0, True)


def slot_corners(slot: Slot) -> Iterator[Point]:
    """Centres of the corner circles of a slot: two, or four of a rectangle."""
    c, s = cos(radians(slot.angle)), sin(radians(slot.angle))
    corners = dict.fromkeys(
        (a * slot.length / 2, b * slot.height / 2) for a in (-1, 1) for b in (-1, 1)
    )
    for a, b in corners:
        yield slot.x + c * a - s * b, slot.y + s * a + c * b
