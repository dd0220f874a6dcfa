"""Which features of a part may be left out by leave, computed without the planner."""

from collections.abc import Collection, Iterator, Sequence

from beamcam.machine.machine import Machine, Spindle
from beamcam.model.part import Hole, Part
from beamcam.verify.depths import REACHES
from beamcam.verify.ends import ends_of
from beamcam.verify.needs import FeatureRef, Lack, Need, Stroke, needs_of
from beamcam.verify.rack import Rack
from beamcam.verify.stations import choices_of, stroke_values


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
    if "off-face" in names:
        left |= {
            (p, f)
            for p, part in enumerate(parts)
            for f, hole in enumerate(part.features)
            if isinstance(hole, Hole)
            and not (
                0 <= hole.x <= part.length and 0 <= hole.y <= part.profile.face_width(hole.face)
            )
        }
    if "stroke" in names:
        left.update(_off_stroke(parts, machine, rack, needs))
    return frozenset(left)


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
        depth = station.tip_depth(bottom(values))
        through = need.hole.depth is None and need.kind in ("drill", "tap")
        if depth < reach.least - slack or (depth > reach.greatest + slack and not through):
            yield p, f
