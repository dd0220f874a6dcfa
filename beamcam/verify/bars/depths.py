"""Required depth of each kind of tool: from the part's dimensions to the position of the tip.

drill         through: its full diameter beyond the far side, at most as the machine strokes;
              blind: the full diameter at the depth; before a thread at least the thread's
tap           through: its tip beyond the far side; blind: its tip at the depth
countersink   the cone as wide as the sink where it is to be, the flat at its depth
punch         as deep as the part or the machine file says
mill, scribe  through: beyond the far side; else at the depth
"""

from collections.abc import Callable
from math import inf, radians, tan

from msgspec import Struct

from beamcam.machine.tools import FLAT_DEG
from beamcam.verify.bars.targets import THREADS, RoundKind
from beamcam.verify.bars.tools import ToolCatalogue


class DepthRange(Struct, frozen=True, gc=False):
    """Permitted range of the tip's depth, from the surface of the face."""

    least: float
    greatest: float


def _drill(kind: RoundKind, diameter: float, thickness: float, shop: ToolCatalogue) -> DepthRange:
    hole = kind.hole
    tip = shop.tip("drill", diameter, hole.face)
    if hole.depth is None:
        return DepthRange(thickness + tip, thickness + shop.drill.breakthrough + tip)
    if hole.kind in THREADS:
        return DepthRange(hole.depth + tip, max(hole.depth + tip, thickness or inf))
    return DepthRange(hole.depth + tip, hole.depth + tip)


def _tap(kind: RoundKind, diameter: float, thickness: float, shop: ToolCatalogue) -> DepthRange:
    if kind.hole.depth is None:
        tip = shop.tip("tap", diameter, kind.hole.face)
        return DepthRange(thickness, thickness + shop.drill.breakthrough + tip)
    return DepthRange(kind.hole.depth, kind.hole.depth)


def _sink(kind: RoundKind, diameter: float, thickness: float, shop: ToolCatalogue) -> DepthRange:
    hole = kind.hole
    cone = hole.angle or FLAT_DEG
    if cone >= FLAT_DEG:
        depth = hole.depth or 0.0
        return DepthRange(depth, depth)
    slope = tan(radians(cone) / 2)
    alone = (hole.diameter - kind.pilot) / 2 / slope
    deep = hole.depth or alone
    if deep > alone + shop.drill.sink_tolerance:
        point = deep + kind.pilot / 2 / slope
    else:
        point = hole.diameter / 2 / slope
    return DepthRange(point, point)


def _punch(kind: RoundKind, diameter: float, thickness: float, shop: ToolCatalogue) -> DepthRange:
    depth = kind.hole.depth or shop.drill.punch_depth
    return DepthRange(depth, depth)


#: By the kind of tool.
REACHES: dict[str, Callable[[RoundKind, float, float, ToolCatalogue], DepthRange]] = {
    "drill": _drill,
    "tap": _tap,
    "countersink": _sink,
    "punch": _punch,
}


def path_reach(depth: float | None, thickness: float, shop: ToolCatalogue) -> DepthRange:
    """Of a mill: through, or at a depth."""
    if depth is None:
        return DepthRange(thickness, thickness + shop.drill.breakthrough)
    return DepthRange(depth, depth)
