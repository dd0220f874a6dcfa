"""How deep each kind of tool has to go: from the part's figures to the place of the tool's tip.

drill         through: its full diameter beyond the far side, at most as the machine strokes;
              blind: the full diameter at the depth; before a thread at least the thread's
tap           through: its tip beyond the far side; blind: its tip at the depth
countersink   the cone as wide as the sink where it is to be, the flat at its depth
punch         as deep as the machine file says
mill, scribe  through: beyond the far side; else at the depth
"""

from collections.abc import Callable
from math import inf, radians, tan
from typing import NamedTuple

from beamcam.machine.machine import FLAT_DEG
from beamcam.verify.needs import THREADS, Stroke
from beamcam.verify.rack import Rack


class Reach(NamedTuple):
    """Where the tip may turn back, from the surface of the face."""

    least: float
    greatest: float


def _drill(need: Stroke, diameter: float, thickness: float, rack: Rack) -> Reach:
    hole = need.hole
    tip = rack.tip("drill", diameter, hole.face)
    if hole.depth is None:
        return Reach(thickness + tip, thickness + rack.drill.breakthrough + tip)
    if hole.kind in THREADS:
        return Reach(hole.depth + tip, max(hole.depth + tip, thickness or inf))
    return Reach(hole.depth + tip, hole.depth + tip)


def _tap(need: Stroke, diameter: float, thickness: float, rack: Rack) -> Reach:
    if need.hole.depth is None:
        tip = rack.tip("tap", diameter, need.hole.face)
        return Reach(thickness, thickness + rack.drill.breakthrough + tip)
    return Reach(need.hole.depth, need.hole.depth)


def _sink(need: Stroke, diameter: float, thickness: float, rack: Rack) -> Reach:
    hole = need.hole
    cone = hole.angle or FLAT_DEG
    if cone >= FLAT_DEG:
        depth = hole.depth or 0.0
        return Reach(depth, depth)
    slope = tan(radians(cone) / 2)
    alone = (hole.diameter - need.pilot) / 2 / slope
    deep = hole.depth or alone
    if deep > alone + rack.drill.sink_tolerance:
        point = deep + need.pilot / 2 / slope
    else:
        point = hole.diameter / 2 / slope
    return Reach(point, point)


def _punch(need: Stroke, diameter: float, thickness: float, rack: Rack) -> Reach:
    depth = need.hole.depth or rack.drill.punch_depth
    return Reach(depth, depth)


#: By the kind of tool.
REACHES: dict[str, Callable[[Stroke, float, float, Rack], Reach]] = {
    "drill": _drill,
    "tap": _tap,
    "countersink": _sink,
    "punch": _punch,
}


def path_reach(depth: float | None, thickness: float, rack: Rack) -> Reach:
    """Of a mill: through, or at a depth."""
    if depth is None:
        return Reach(thickness, thickness + rack.drill.breakthrough)
    return Reach(depth, depth)
