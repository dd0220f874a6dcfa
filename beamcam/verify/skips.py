"""Which features of a part may be left out by leave, computed without the planner."""

from collections.abc import Collection, Iterator, Sequence

from beamcam.machine.machine import Machine, Spindle
from beamcam.model.part import Contour, Hole, Part, Slot
from beamcam.verify.beyond import led_beyond
from beamcam.verify.depths import REACHES
from beamcam.verify.ends import ends_of
from beamcam.verify.needs import (
    FeatureRef,
    Lack,
    Need,
    Stroke,
    from_behind,
    is_same,
    needs_of,
    slot_corners,
    works_on,
)
from beamcam.verify.rack import Rack
from beamcam.verify.stations import Station, choices_of, stroke_values


def skippable(
    parts: Sequence[Part], machine: Machine, names: Collection[str]
) -> frozenset[FeatureRef]:
    """The features that may be left out under the names that `--allow-skips` takes.

    Raises TypeError for a machine without saw and drill.
    """
    if machine.saw is None or machine.drill is None:
        raise TypeError(f"{machine.name} has no saw and drill")
    rack = Rack(machine, machine.drill)
    ends = [ends_of(part, machine.saw) for part in parts]
    needs = needs_of(parts, ends, rack, ())
    left = {ref for ref, need in needs if isinstance(need, Lack) and need.name in names}
    if not {"off-face", "reach"}.isdisjoint(names):
        left |= {ref for ref, name in _ill_placed(parts, machine, rack) if name in names}
    if "axis" in names:
        left.update(led_beyond(parts, machine, rack, needs))
    if "stroke" in names:
        left.update(_off_stroke(parts, machine, rack, needs))
    return frozenset(left.union(_repeats(left, parts, rack)))


def _repeats(
    left: Collection[FeatureRef], parts: Sequence[Part], rack: Rack
) -> Iterator[FeatureRef]:
    """The holes that are the same as one that is left out, written again."""
    for p, f in left:
        part = parts[p]
        works = {face for face in rack.faces if works_on(face, part, rack)}
        first = part.features[f]
        if isinstance(first, Hole):
            made = from_behind(first, part, rack, works)
            for g, other in enumerate(part.features):
                if isinstance(other, Hole) and is_same(
                    from_behind(other, part, rack, works), made, rack.twice
                ):
                    yield p, g


def _ill_placed(
    parts: Sequence[Part], machine: Machine, rack: Rack
) -> Iterator[tuple[FeatureRef, str]]:
    """The features that lie where no tool comes, and what such a place is called."""
    spindles: dict[str, int] = {s.face: s.number for s in machine.spindles}
    for p, part in enumerate(parts):
        choices = choices_of(machine, part.profile)
        works = {face for face in rack.faces if works_on(face, part, rack)}
        for f, feature in enumerate(part.features):
            if isinstance(feature, Contour) and feature.process != "cut":
                if feature.face in works and any(rack.of("scribe", feature.face)):
                    (station,) = choices[spindles[feature.face]].stations
                    if not _is_clear(feature, station):
                        yield (p, f), "reach"
                continue
            if not isinstance(feature, Hole | Slot):
                continue
            made = from_behind(feature, part, rack, works)
            if made.face not in works:
                continue
            (station,) = choices[spindles[made.face]].stations
            places = [(made.x, made.y), *(slot_corners(made) if isinstance(made, Slot) else ())]
            name = next((n for x, y in places if (n := _fault(x, y, made, part, station))), "")
            if name:
                yield (p, f), name


def _fault(x: float, y: float, made: Hole | Slot, part: Part, station: Station) -> str:
    """What is wrong with the place of a hole, or of one of a slot's corners."""
    if not (0 <= x <= part.length and 0 <= y <= part.profile.face_width(made.face)):
        return "off-face"
    radius = made.diameter / 2
    if not (station.clear_from <= y - radius and y + radius <= station.clear_to):
        return "reach"
    return ""


def _is_clear(line: Contour, station: Station) -> bool:
    """Whether no flange stands in the way of a tool that is led along a line."""
    boxes = [curve.bbox for curve in line.curves]
    lowest, highest = min(box[1] for box in boxes), max(box[3] for box in boxes)
    return station.clear_from <= lowest and highest <= station.clear_to


def _off_stroke(
    parts: Sequence[Part],
    machine: Machine,
    rack: Rack,
    needs: Sequence[tuple[FeatureRef, Need]],
) -> Iterator[FeatureRef]:
    """The holes that a stroke which is the same for all of them does not make."""
    spindles: dict[str, Spindle] = {s.face: s for s in machine.spindles}
    slack = machine.format.resolution
    for (p, f), need in needs:
        if not isinstance(need, Stroke):
            continue
        profile, face = parts[p].profile, need.hole.face
        bottom = spindles[face].stroke.bottom
        values = stroke_values(machine, profile, face) | {"y": need.hole.y}
        if bottom(values) != bottom(values | {"depth": 1.0}):
            continue
        (station,) = choices_of(machine, profile)[spindles[face].number].stations
        reach = REACHES[need.kind](need, need.diameter, profile.thickness(face), rack)
        depth = station.tip_depth(bottom(values), need.hole.y)
        through = need.hole.depth is None and need.kind in ("drill", "tap")
        if depth < reach.least - slack or (depth > reach.greatest + slack and not through):
            yield p, f
