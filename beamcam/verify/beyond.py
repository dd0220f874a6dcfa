"""The features that lead a spindle's axis beyond its limits, computed without the planner."""

from collections.abc import Iterator, Sequence
from math import cos, radians, sin

from beamcam.machine.machine import Machine, Spindle
from beamcam.model.part import Hole, Part, Slot
from beamcam.verify.depths import REACHES
from beamcam.verify.needs import THREADS, Course, FeatureRef, Lack, Need, Pocket, Stroke
from beamcam.verify.rack import Rack
from beamcam.verify.stations import Station, choices_of, stroke_values

#: A mill that is led round a hole is smaller than it by this at least.
ROUND_SHARE = 0.98


def led_beyond(
    parts: Sequence[Part],
    machine: Machine,
    rack: Rack,
    needs: Sequence[tuple[FeatureRef, Need]],
) -> Iterator[FeatureRef]:
    """The features of which something that they need lies beyond an axis."""
    spindles: dict[str, Spindle] = {s.face: s for s in machine.spindles}
    for ref, need in needs:
        part = parts[ref[0]]
        if isinstance(need, Lack) or not _is_done(need, part.features[ref[1]], rack):
            continue
        face = need.hole.face if isinstance(need, Stroke) else need.face
        spindle = spindles[face]
        (station,) = choices_of(machine, part.profile)[spindle.number].stations
        depth, tip = _depth_and_tip(need, part.profile.thickness(face), rack)
        values = stroke_values(machine, part.profile, face) | {"depth": depth, "tip": tip}
        for y in _places(need, rack):
            if not _is_within(values | {"y": y}, spindle, station, machine):
                yield ref


def _is_done(need: Need, feature: object, rack: Rack) -> bool:
    """Whether the machine does what may be left: drill the two ends of a slot before it mills."""
    if not (isinstance(need, Stroke) and need.optional):
        return True
    return rack.drill.slots == "drill-mill" and isinstance(feature, Slot) and not feature.height


def _depth_and_tip(
    need: Stroke | Pocket | Course, thickness: float, rack: Rack
) -> tuple[float, float]:
    """Depth of the full diameter, or of the point of another tool than a drill; and its tip."""
    if isinstance(need, Course):
        return rack.drill.mark_depth, 0.0
    through = thickness + rack.drill.breakthrough
    if isinstance(need, Pocket):
        return (through if need.depth is None else need.depth), 0.0
    hole = need.hole
    tip = rack.tip("drill", need.diameter, hole.face) if need.kind == "drill" else 0.0
    if need.kind in ("drill", "tap") and hole.depth is None:
        return through, tip
    if need.kind == "drill" and hole.depth is not None and hole.kind in THREADS:
        tap = rack.tap(hole)
        return hole.depth + (rack.drill.runout_pitches * tap[1] if tap else 0.0), tip
    return REACHES[need.kind](need, need.diameter, thickness, rack).least - tip, tip


def _places(need: Stroke | Pocket | Course, rack: Rack) -> tuple[float, ...]:
    """y that the tool is brought to; of a path the least and the greatest."""
    if isinstance(need, Stroke):
        return (need.hole.y,)
    if isinstance(need, Course):
        boxes = [curve.bbox for curve in need.curves]
        return min(box[1] for box in boxes), max(box[3] for box in boxes)
    is_round = isinstance(need.source, Hole)
    widest = ROUND_SHARE * need.diameter if is_round else need.diameter + rack.drill.twin
    mill = max((d for d in rack.sizes("mill", need.face) if d <= widest), default=need.diameter)
    angle = radians(need.angle)
    half = abs(sin(angle)) * need.length / 2 + abs(cos(angle)) * need.height / 2
    half += max(0.0, (need.diameter - mill) / 2)
    return need.y - half, need.y + half


def _is_within(
    values: dict[str, float], spindle: Spindle, station: Station, machine: Machine
) -> bool:
    """Whether the axes of a spindle come to all places of a stroke."""
    stroke = spindle.stroke
    along = [stroke.start(values), stroke.bottom(values)]
    if stroke.near is not None:
        along.append(stroke.near(values))
    places = {station.across: [spindle.across.position(values)], station.stroke: along}
    return all(
        least <= round(place, machine.format.length_decimals) <= greatest
        for index, _, least, greatest in station.limits
        for place in places.get(index, ())
    )
