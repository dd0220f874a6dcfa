"""Holes of one wall that break into each other, or leave too little steel between them.

The holes are walked in order of x, so that each looks only at those that may still touch it.
"""

from bisect import bisect_right
from collections import defaultdict
from collections.abc import Iterator
from math import dist, hypot
from operator import itemgetter

from beamcam.errors import Rule, Severity
from beamcam.machine.drill import Drill
from beamcam.model.description import named
from beamcam.model.part import Face, Hole
from beamcam.planning.operations.finished_part import NEAR_EDGE, TOLERANCE
from beamcam.planning.operations.merging import ROUNDING, Group, Placed, runs
from beamcam.planning.operations.working_step import Said

OVERLAP = Rule(
    "plan-hole-overlap",
    Severity.ERROR,
    "found {what} at x {x}, y {y} on face {face}, {apart} mm from {other} of {first}; "
    "expected at least {expected} mm between their middles",
    "A drill that breaks into another hole runs off or breaks. Two diameters at one place may be "
    "a stepped hole, of which the wider one is blind.",
)
TOO_NEAR = Rule(
    "plan-too-near",
    Severity.ERROR,
    "found a hole of diameter {found} on face {face} at x {x}, y {y}, {apart} mm from that of "
    "{first}; expected the same place, or one more than {expected} mm away",
    "Holes closer than the program's decimals can distinguish are one hole that was drawn twice, "
    "not quite at the same place.",
)
CROWD = Rule(
    "plan-hole-crowd",
    Severity.ERROR,
    "found {found} pairs of holes that stand within {reach} mm of each other along the part, most "
    "of them about this one; expected at most {expected}",
    "So many holes do not stand beside each other on a wall: they are a drawing that was written "
    "again and again. Nothing else is said of them.",
)
RULES = (OVERLAP, TOO_NEAR, CROWD)
MOST_PAIRS = (
    2_000_000  #: that are compared; 20,000 holes of 18 mm all over a bar of 12 m have 1 of 2
)
THREADS = ("thread", "left-thread")


def refuse_crowd(holes: Group, drill: Drill) -> Iterator[Said]:
    """The hole with most others behind it, where comparing each two of them would take minutes.

    The pairs are counted and not looked at.
    """
    of_face: dict[Face, list[Placed]] = defaultdict(list)
    for placed in holes:
        of_face[placed[2].face].append(placed)
    for group in of_face.values():
        reach = max(hole.diameter for _, _, hole in group) + drill.min_edge_distance
        along = [x for x, _, _ in group]
        counts = [bisect_right(along, x + reach) - i - 1 for i, x in enumerate(along)]
        if sum(counts) > MOST_PAIRS:
            _, f, hole = group[counts.index(max(counts))]
            yield (
                f,
                CROWD.at(hole.source, found=sum(counts), reach=f"{reach:g}", expected=MOST_PAIRS),
            )


def judge_pairs(holes: Group, drill: Drill) -> Iterator[Said]:
    """For each hole that is too near an earlier one of the part its index, and what to say."""
    if len(holes) < 2:
        return
    steel = drill.min_edge_distance
    overlapping: set[int] = set()  # the first error about a hole is the one that refuses it
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
                if apart < room + steel - TOLERANCE and max(f, other_f) not in overlapping:
                    pair = (holes[i], holes[j]) if f < other_f else (holes[j], holes[i])
                    for said in _judge_pair(*pair, apart, room, drill):
                        yield said
                        if said[1].severity is Severity.ERROR:
                            overlapping.add(said[0])


def _judge_pair(
    first: Placed, second: Placed, apart: float, room: float, drill: Drill
) -> Iterator[Said]:
    """Remarks on two holes, at the second of them."""
    (_, _, one), (_, f, hole) = first, second
    if apart <= drill.merge_tolerance and _is_one_work(one, hole):
        return
    values = {"what": named(hole), "x": f"{hole.x:g}", "y": f"{hole.y:g}", "face": hole.face}
    if apart < room - TOLERANCE:
        yield f, OVERLAP.at(
            hole.source, other=named(one), first=one.source, apart=f"{apart:.3g}",
            expected=f"{room:g}", **values,
        )  # fmt: skip
    elif "mark" not in (one.kind, hole.kind):
        yield f, NEAR_EDGE.at(
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


def refuse_too_near(holes: Group, resolution: float, drill: Drill) -> Iterator[Said]:
    """The holes beside one that a program cannot tell them apart from, by their indices."""
    if 2 * resolution <= drill.duplicate_tolerance:
        return  # what is as near as that is one hole, and there once
    for (_, f, hole), (_, _, first) in _too_near(holes, resolution):
        apart = dist((hole.x, hole.y), (first.x, first.y))
        yield f, TOO_NEAR.at(
            hole.source, found=f"{hole.diameter:g}", face=hole.face, x=f"{hole.x:g}",
            y=f"{hole.y:g}", apart=f"{apart:.3g}", first=first.source,
            expected=f"{2 * resolution:g}",
        )  # fmt: skip


def _too_near(holes: Group, resolution: float) -> Iterator[tuple[Placed, Placed]]:
    """Of `holes`, sorted, those beside one of the same size that a program cannot tell apart.

    Each with the first such one before it among the part's features. Written places are off by
    up to one `resolution` (a hole's, and that of the cut which the part starts at), so that of two
    places less than two of them apart either may be meant. Holes at the very same place are told
    apart by their depths.
    """
    limit = 2 * resolution + ROUNDING
    for run in runs(holes, limit):
        if len(run) == 1:
            continue
        seen: list[Placed] = []
        for placed in sorted(run, key=itemgetter(1)):
            first = next((p for p in seen if _is_hard_to_tell(p[2], placed[2], limit)), None)
            if first is not None:
                yield placed, first
            seen.append(placed)


def _is_hard_to_tell(a: Hole, b: Hole, limit: float) -> bool:
    """Whether two holes are of one size, near each other and not at the very same place."""
    alike = (a.face, a.diameter) == (b.face, b.diameter)
    return alike and 0.0 < max(abs(a.x - b.x), abs(a.y - b.y)) <= limit
