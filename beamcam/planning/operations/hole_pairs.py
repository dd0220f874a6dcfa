"""Holes of one wall that break into each other, or leave too little steel between them.

The holes are walked in order of x, so that each looks only at those that may still touch it.
"""

from collections.abc import Iterator
from math import hypot

from beamcam.errors import Diagnostic
from beamcam.machine.machine import Drill
from beamcam.model.part import Hole
from beamcam.planning.merging import Group, Placed
from beamcam.planning.operations import rules

TOLERANCE = 0.01  #: mm; holes that share no more are tangent
THREADS = ("thread", "left-thread")


def judge_pairs(holes: Group, drill: Drill) -> Iterator[tuple[int, Diagnostic]]:
    """For each hole that is too near an earlier one of the part its index, and what to say."""
    if len(holes) < 2:
        return
    steel = drill.min_edge_distance
    furthest = max(hole.diameter for _, _, hole in holes) / 2 + steel
    for i, (x, f, hole) in enumerate(holes):
        face, y, radius = hole.face, hole.y, hole.diameter / 2
        reach = x + radius + furthest
        for j in range(i + 1, len(holes)):
            other_x, other_f, other = holes[j]
            if other_x >= reach:
                break
            if other.face != face:
                continue
            room = radius + other.diameter / 2
            dy = other.y - y
            if -room - steel < dy < room + steel:
                apart = hypot(other_x - x, dy)
                if apart < room + steel - TOLERANCE:
                    pair = (holes[i], holes[j]) if f < other_f else (holes[j], holes[i])
                    yield from _judge(*pair, apart, room, drill)


def _judge(
    first: Placed, second: Placed, apart: float, room: float, drill: Drill
) -> Iterator[tuple[int, Diagnostic]]:
    """What to say of two holes, at the second of them."""
    (_, _, one), (_, f, hole) = first, second
    if apart <= drill.merge_tolerance and _is_one_work(one, hole):
        return
    values = {"what": named(hole), "x": f"{hole.x:g}", "y": f"{hole.y:g}", "face": hole.face}
    if apart < room - TOLERANCE:
        yield f, rules.OVERLAP.at(
            hole.source, other=named(one), first=one.source, apart=f"{apart:.3g}",
            expected=f"{room:g}", **values,
        )  # fmt: skip
    elif "mark" not in (one.kind, hole.kind):
        yield f, rules.NEAR_EDGE.at(
            hole.source, apart=f"{max(apart - room, 0.0):.3g}",
            where=f"{named(one)} of {one.source}",
            expected=f"{drill.min_edge_distance:g}", **values,
        )  # fmt: skip


def _is_one_work(one: Hole, other: Hole) -> bool:
    """Whether two holes about one middle are meant: a sink, a thread's drill, a stepped hole."""
    if "countersink" in (one.kind, other.kind):
        return True
    narrow, wide = sorted((one, other), key=lambda hole: hole.diameter)
    if narrow.diameter == wide.diameter:
        return False
    if wide.kind in THREADS:
        return narrow.kind in ("through", "blind")
    return wide.depth is not None and (narrow.depth is None or narrow.depth > wide.depth)


def named(hole: Hole) -> str:
    """A hole as messages call it."""
    kind = "" if hole.kind in ("through", "blind") else f"{hole.kind} "
    return f"a {kind}hole of diameter {hole.diameter:g}"
