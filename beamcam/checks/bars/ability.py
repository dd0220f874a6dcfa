"""Which features of a part the machine cannot make, and what `--allow-skips` calls each reason.

Told from part and machine alone: a feature may be missing from a program only if it stands here
under a name that the user gave.
"""

from bisect import bisect_left, bisect_right
from collections.abc import Collection, Iterator, Mapping, Sequence
from math import cos, radians, sin
from operator import attrgetter

from beamcam.checks.bars.holes import reach_of
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
)
from beamcam.checks.bars.tools import ToolCatalogue
from beamcam.geometry.curves import Curve
from beamcam.machine.machine import Machine
from beamcam.model.part import Contour, Hole, Part, Slot

FeatureRef = tuple[int, int]  #: index of the part, index of its feature
#: A mill that cuts round a hole is smaller than it by this at least.
ROUND_SHARE = 0.98


def may_be_missing(
    part: Part, targets: Sequence[Target], tools: ToolCatalogue, names: Collection[str]
) -> frozenset[int]:
    """The features of a part, by their indices, that may be left out under some names."""
    left = {t.feature for t in targets if isinstance(t, Unmakeable) and t.name in names}
    choices = choices_of(tools.machine, part.profile, lip_length(part))
    stations: dict[str, Station] = {
        s.face: choices[s.number].stations[0] for s in tools.machine.spindles
    }
    if "off-face" in names or "reach" in names:
        left |= {f for f, own in _ill_placed(part, tools, stations) if own in names}
    if "axis" in names or "stroke" in names:
        left |= {f for f, own in _out_of_reach(part, targets, tools, stations) if own in names}
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
            face, curves = feature.face, feature.curves
            if tools.works_on(face, part) and any(tools.of("scribe", face)):
                own, (low, high) = stations[face], _least_and_greatest_y(curves)
                is_clear = own.clear_from <= low and high <= own.clear_to
                if in_stem(curves, part.profile, face) or not is_clear:
                    yield f, "reach"
            continue
        if not isinstance(feature, Hole | Slot):
            continue
        made = from_behind(feature, part, tools)
        if not tools.works_on(made.face, part):
            continue
        places = [(made.x, made.y), *(slot_corners(made) if isinstance(made, Slot) else ())]
        station = stations[made.face]
        size, radius = (part.length, part.profile.face_width(made.face)), made.diameter / 2
        for x, y in places:
            if not (0 <= x <= size[0] and 0 <= y <= size[1]):
                yield f, "off-face"
                break
            if not (station.clear_from <= y - radius and y + radius <= station.clear_to):
                yield f, "reach"
                break


def _out_of_reach(
    part: Part, targets: Sequence[Target], tools: ToolCatalogue, stations: Mapping[str, Station]
) -> Iterator[tuple[int, str]]:
    """The features of which something lies beyond an axis, and the holes that a stroke which is the
    same for all of them does not make."""
    machine = tools.machine
    slack = machine.format.resolution
    for target in targets:
        if isinstance(target, Unmakeable):
            continue
        station, thickness = stations[target.face], wall_thickness(part.profile, target.face)
        values = stroke_values(machine, part.profile, target.face)
        is_end = isinstance(target, RequiredRound) and target.optional
        if not is_end or tools.drills_ends(part.features[target.feature], target.face):
            depth, tip, ys = _tool_places(target, thickness, tools)
            own = values | {"depth": depth, "tip": tip}
            if not all(is_within(own | {"y": y}, station, machine) for y in ys):
                yield target.feature, "axis"
        if isinstance(target, RequiredRound):
            kind, bottom = target.kind, station.spindle.stroke.bottom
            values |= {"y": target.y}
            if bottom(values) == bottom(values | {"depth": 1.0}):
                reach = reach_of(kind, kind.own, thickness, tools)
                depth = station.tip_depth(bottom(values), target.y)
                through = kind.hole.depth is None and kind.tool in ("drill", "tap")
                if depth < reach.least - slack or (depth > reach.greatest + slack and not through):
                    yield target.feature, "stroke"


def _tool_places(
    target: RequiredRound | RequiredPocket | MarkingPath, thickness: float, tools: ToolCatalogue
) -> tuple[float, float, tuple[float, ...]]:
    """Depth of the full diameter, or of the point of another tool than a drill; its tip; and its y,
    of a path the least and the greatest."""
    if isinstance(target, MarkingPath):
        return tools.drill.mark_depth, 0.0, _least_and_greatest_y(target.curves)
    through = thickness + tools.drill.breakthrough
    if isinstance(target, RequiredPocket):
        slot = target.slot
        widest = slot.diameter + tools.drill.same_tool_tolerance
        if isinstance(target.source, Hole):
            widest = ROUND_SHARE * slot.diameter
        sizes = [d for d in tools.sizes("mill", target.face) if d <= widest]
        mill = max(sizes, default=slot.diameter)
        angle = radians(slot.angle)
        half = abs(sin(angle)) * slot.length / 2 + abs(cos(angle)) * slot.height / 2
        half += max(0.0, (slot.diameter - mill) / 2)
        depth = through if slot.depth is None else slot.depth
        return depth, 0.0, (slot.y - half, slot.y + half)
    kind, hole = target.kind, target.kind.hole
    size = kind.own
    if target.optional:
        size = next(iter(tools.fits("drill", hole.diameter, target.face)), kind.own)
    tip = tools.tip("drill", size, hole.face) if kind.tool == "drill" else 0.0
    if kind.tool in ("drill", "tap") and hole.depth is None:
        depth = through
    elif kind.tool == "drill" and hole.depth is not None and hole.kind in THREADS:
        tap = tools.tap(hole)
        depth = hole.depth + (tools.drill.runout_pitches * tap[1] if tap else 0.0)
    else:
        depth = reach_of(kind, size, thickness, tools).least - tip
    return depth, tip, (target.y,)


def _least_and_greatest_y(curves: Sequence[Curve]) -> tuple[float, float]:
    boxes = [curve.bbox for curve in curves]
    return min(box[1] for box in boxes), max(box[3] for box in boxes)


def is_within(values: dict[str, float], station: Station, machine: Machine) -> bool:
    """Whether the axes of a spindle come to all places of a stroke."""
    across, stroke = station.spindle.across, station.spindle.stroke
    along = [stroke.retract(values), stroke.bottom(values)]
    if stroke.approach is not None:
        along.append(stroke.approach(values))
    places = {station.across: [across.position(values)], station.stroke: along}
    return all(
        least <= round(place, machine.format.length_decimals) <= greatest
        for index, _, least, greatest in station.limits
        for place in places.get(index, ())
    )
