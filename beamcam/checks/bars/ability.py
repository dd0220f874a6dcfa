"""Which features of a part the machine cannot make, and what `--allow-skips` calls each reason.

Told from part and machine alone: a feature may be missing from a program only if it stands here
under a name that the user gave.
"""

from bisect import bisect_left, bisect_right
from collections.abc import Collection, Iterator, Mapping, Sequence
from math import cos, radians, sin
from operator import attrgetter

from beamcam.checks.bars.holes import REACHES
from beamcam.checks.bars.pieces import ends_of
from beamcam.checks.bars.stations import (
    Station,
    choices_of,
    in_stem,
    lip_length,
    stroke_values,
    wall_thickness,
)
from beamcam.checks.bars.targets import (
    THREADS,
    MarkingPath,
    RequiredPocket,
    RequiredRound,
    Target,
    Unmakeable,
    from_behind,
    is_same,
    slot_corners,
    targets_of,
)
from beamcam.checks.bars.tools import ToolCatalogue
from beamcam.machine.machine import Machine, drill_of, saw_of
from beamcam.machine.stations import Spindle
from beamcam.model.part import Contour, Hole, Part, Slot

FeatureRef = tuple[int, int]  #: index of the part, index of its feature
#: A mill that is led round a hole is smaller than it by this at least.
ROUND_SHARE = 0.98


def skippable(
    parts: Sequence[Part], machine: Machine, names: Collection[str]
) -> frozenset[FeatureRef]:
    """The features that may be left out under the names that `--allow-skips` takes.

    Raises TypeError for a machine without saw and drill.
    """
    saw = saw_of(machine)
    tools = ToolCatalogue(machine, drill_of(machine))
    return frozenset(
        (p, f)
        for p, part in enumerate(parts)
        for f in may_be_missing(part, targets_of(part, ends_of(part, saw), tools), tools, names)
    )


def may_be_missing(
    part: Part, targets: Sequence[Target], tools: ToolCatalogue, names: Collection[str]
) -> frozenset[int]:
    """The features of a part, by their indices, that may be left out under some names."""
    left = {t.feature for t in targets if isinstance(t, Unmakeable) and t.name in names}
    spindles: dict[str, Spindle] = {s.face: s for s in tools.machine.spindles}
    choices = choices_of(tools.machine, part.profile, lip_length(part))
    stations: dict[str, Station] = {
        s.face: choices[s.number].stations[0] for s in tools.machine.spindles
    }
    if "off-face" in names or "reach" in names:
        left |= {f for f, own in _ill_placed(part, tools, stations) if own in names}
    if "axis" in names:
        left |= {*_off_axis(part, targets, tools, spindles, stations)}
    if "stroke" in names:
        left |= {*_off_stroke(part, targets, tools, spindles, stations)}
    left |= {*repeats(left, part, tools)}
    if "countersink" in names:
        left |= {*_sinks(left, part, tools)}
    return frozenset(left)


def repeats(left: Collection[int], part: Part, tools: ToolCatalogue) -> Iterator[int]:
    """The holes that are the same as one that is left out, written again."""
    holes = [(f, hole) for f, hole in enumerate(part.features) if isinstance(hole, Hole)]
    gone = [from_behind(hole, part, tools) for f, hole in holes if f in left]
    gone.sort(key=attrgetter("x"))
    along = [hole.x for hole in gone]
    for f, hole in holes:
        if f not in left:
            again = from_behind(hole, part, tools)
            first = bisect_left(along, again.x - tools.twice)
            last = bisect_right(along, again.x + tools.twice)
            if any(
                again.face == one.face and is_same(again, one, tools.twice)
                for one in gone[first:last]
            ):
                yield f


def _sinks(left: Collection[int], part: Part, tools: ToolCatalogue) -> Iterator[int]:
    """The countersinks whose holes are all left out."""
    near = tools.drill.merge_tolerance + 1e-9
    for f, sink in enumerate(part.features):
        if not isinstance(sink, Hole) or sink.kind != "countersink":
            continue
        below = [
            g for g, h in enumerate(part.features)
            if isinstance(h, Hole) and h.kind != "countersink" and h.face == sink.face
            and h.diameter < sink.diameter
            and abs(h.x - sink.x) <= near and abs(h.y - sink.y) <= near
        ]  # fmt: skip
        if below and all(g in left for g in below):
            yield f


def _ill_placed(
    part: Part, tools: ToolCatalogue, stations: Mapping[str, Station]
) -> Iterator[tuple[int, str]]:
    """The features that lie where no tool comes, and what such a place is called."""
    for f, feature in enumerate(part.features):
        if isinstance(feature, Contour) and feature.process != "cut":
            scribed = tools.works_on(feature.face, part) and any(tools.of("scribe", feature.face))
            if scribed and (
                in_stem(feature.curves, part.profile, feature.face)
                or not _is_clear(feature, stations[feature.face])
            ):
                yield f, "reach"
            continue
        if not isinstance(feature, Hole | Slot):
            continue
        made = from_behind(feature, part, tools)
        if not tools.works_on(made.face, part):
            continue
        places = [(made.x, made.y), *(slot_corners(made) if isinstance(made, Slot) else ())]
        station = stations[made.face]
        name = next((n for x, y in places if (n := _fault(x, y, made, part, station))), "")
        if name:
            yield f, name


def _fault(x: float, y: float, made: Hole | Slot, part: Part, station: Station) -> str:
    """Faults in the position of a hole, or of one of a slot's corners."""
    if not (0 <= x <= part.length and 0 <= y <= part.profile.face_width(made.face)):
        return "off-face"
    radius = made.diameter / 2
    if not (station.clear_from <= y - radius and y + radius <= station.clear_to):
        return "reach"
    return ""


def _is_clear(line: Contour, station: Station) -> bool:
    """Whether a tool path along a line is clear of the flanges."""
    boxes = [curve.bbox for curve in line.curves]
    lowest, highest = min(box[1] for box in boxes), max(box[3] for box in boxes)
    return station.clear_from <= lowest and highest <= station.clear_to


def _off_stroke(
    part: Part, targets: Sequence[Target], tools: ToolCatalogue, spindles: Mapping[str, Spindle],
    stations: Mapping[str, Station],
) -> Iterator[int]:  # fmt: skip
    """The holes that a stroke which is the same for all of them does not make."""
    slack = tools.machine.format.resolution
    for target in targets:
        if not isinstance(target, RequiredRound):
            continue
        face, kind = target.face, target.kind
        bottom = spindles[face].stroke.bottom
        values = stroke_values(tools.machine, part.profile, face) | {"y": target.y}
        if bottom(values) != bottom(values | {"depth": 1.0}):
            continue
        reach = REACHES[kind.tool](kind, kind.own, wall_thickness(part.profile, face), tools)
        depth = stations[face].tip_depth(bottom(values), target.y)
        through = kind.hole.depth is None and kind.tool in ("drill", "tap")
        if depth < reach.least - slack or (depth > reach.greatest + slack and not through):
            yield target.feature


def _off_axis(
    part: Part, targets: Sequence[Target], tools: ToolCatalogue, spindles: Mapping[str, Spindle],
    stations: Mapping[str, Station],
) -> Iterator[int]:  # fmt: skip
    """The features of which something that they need lies beyond an axis."""
    for target in targets:
        if isinstance(target, Unmakeable):
            continue
        if (
            isinstance(target, RequiredRound)
            and target.optional
            and not _is_drilled(target, part, tools)
        ):
            continue
        face = target.face
        depth, tip = _depth_and_tip(target, wall_thickness(part.profile, face), tools)
        values = stroke_values(tools.machine, part.profile, face) | {"depth": depth, "tip": tip}
        for y in _places(target, tools):
            if not is_within(values | {"y": y}, spindles[face], stations[face], tools.machine):
                yield target.feature


def _is_drilled(end: RequiredRound, part: Part, tools: ToolCatalogue) -> bool:
    """Whether the machine drills the end of a slot before it mills it."""
    slot = part.features[end.feature]
    return (
        isinstance(slot, Slot)
        and not slot.height
        and tools.drill.slots == "drill-mill"
        and bool(tools.fits("drill", slot.diameter, end.face))
    )


def _depth_and_tip(
    target: RequiredRound | RequiredPocket | MarkingPath, thickness: float, tools: ToolCatalogue
) -> tuple[float, float]:
    """Depth of the full diameter, or of the point of another tool than a drill; and its tip."""
    if isinstance(target, MarkingPath):
        return tools.drill.mark_depth, 0.0
    through = thickness + tools.drill.breakthrough
    if isinstance(target, RequiredPocket):
        return (through if target.depth is None else target.depth), 0.0
    kind, hole = target.kind, target.kind.hole
    size = kind.own
    if target.optional:
        size = next(iter(tools.fits("drill", hole.diameter, target.face)), kind.own)
    tip = tools.tip("drill", size, hole.face) if kind.tool == "drill" else 0.0
    if kind.tool in ("drill", "tap") and hole.depth is None:
        return through, tip
    if kind.tool == "drill" and hole.depth is not None and hole.kind in THREADS:
        tap = tools.tap(hole)
        return hole.depth + (tools.drill.runout_pitches * tap[1] if tap else 0.0), tip
    return REACHES[kind.tool](kind, size, thickness, tools).least - tip, tip


def _places(
    target: RequiredRound | RequiredPocket | MarkingPath, tools: ToolCatalogue
) -> tuple[float, ...]:
    """y of the tool; of a path its minimum and maximum."""
    if isinstance(target, RequiredRound):
        return (target.y,)
    if isinstance(target, MarkingPath):
        boxes = [curve.bbox for curve in target.curves]
        return min(box[1] for box in boxes), max(box[3] for box in boxes)
    is_round = isinstance(target.source, Hole)
    widest = target.diameter + tools.drill.same_tool_tolerance
    if is_round:
        widest = ROUND_SHARE * target.diameter
    sizes = [d for d in tools.sizes("mill", target.face) if d <= widest]
    mill = max(sizes, default=target.diameter)
    angle = radians(target.angle)
    half = abs(sin(angle)) * target.length / 2 + abs(cos(angle)) * target.height / 2
    half += max(0.0, (target.diameter - mill) / 2)
    return target.y - half, target.y + half


def is_within(
    values: dict[str, float], spindle: Spindle, station: Station, machine: Machine
) -> bool:
    """Whether the axes of a spindle come to all places of a stroke."""
    stroke = spindle.stroke
    along = [stroke.retract(values), stroke.bottom(values)]
    if stroke.approach is not None:
        along.append(stroke.approach(values))
    places = {station.across: [spindle.across.position(values)], station.stroke: along}
    return all(
        least <= round(place, machine.format.length_decimals) <= greatest
        for index, _, least, greatest in station.limits
        for place in places.get(index, ())
    )
