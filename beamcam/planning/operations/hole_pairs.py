"""Holes of one wall that break into each other, or leave too little steel between them.

The holes are walked in order of x, so that each looks only at those that may still touch it.
"""

from bisect import bisect_right
from collections import defaultdict
from collections.abc import Collection, Iterator, Mapping
from math import dist, floor, hypot
from operator import itemgetter

from beamcam.errors import Severity, error
from beamcam.machine.stations import Drill
from beamcam.model.description import named
from beamcam.model.part import Face, Hole
from beamcam.planning.operations.finished_part import NEAR_EDGE, TOLERANCE
from beamcam.planning.operations.tools import Said

# --- merging --------------------------------------------------------------------------------------

# Duplicate holes, and flange holes that two spindles drill in one stroke.
#
# Two holes of one face that are the same in every figure are one hole that was written twice; it
# is drilled once, and the second is listed. Two holes on the two faces of a pair of spindles are
# one stroke if both are there with the same x, y, diameter, depth, kind and cone: 49.95 and 50.00
# are the same place, since that is what two exports of one model leave (`merge_tolerance`).
#
# The holes are walked in order of x, so that each looks only at those a tolerance further on.


Placed = tuple[float, int, Hole]  #: x, index of the feature, and the hole: they sort along the part
Group = tuple[Placed, ...]
ROUNDING = 1e-9
_NEAR = (-1, 0, 1)


def drop_duplicates(holes: Group, tolerance: float) -> tuple[Group, dict[int, Placed]]:
    """Of `holes`, sorted, each once; and for the index of each dropped one which it repeats.

    Of holes that are the same the first of the part's features stays.
    """
    repeats: dict[int, Placed] = {}
    limit = tolerance + ROUNDING
    width = 2 * limit  # of a cell: holes that are the same lie in neighbours
    kept: defaultdict[tuple[int, int], list[Placed]] = defaultdict(list)
    for run in runs(holes, limit):
        if len(run) == 1:
            continue
        for placed in sorted(run, key=itemgetter(1)):
            x, f, hole = placed
            column, row = floor(x / width), floor(hole.y / width)
            near = [cell for i in _NEAR for j in _NEAR if (cell := kept.get((column + i, row + j)))]
            like = [p for cell in near for p in cell if _is_same(p[2], hole, limit)]
            if like:
                repeats[f] = min(like, key=itemgetter(1))
            else:
                kept[column, row].append(placed)
    if not repeats:
        return holes, repeats
    return tuple([p for p in holes if p[1] not in repeats]), dict(sorted(repeats.items()))


def runs(holes: Group, limit: float) -> Iterator[Group]:
    """All holes, together those that lie within `limit` of the one before along x."""
    start = 0
    before = holes[0][0] if holes else 0.0
    for i, (x, _, _) in enumerate(holes):
        if x - before > limit:
            yield holes[start:i]
            start = i
        before = x
    if holes:
        yield holes[start:]


def _is_same(a: Hole, b: Hole, limit: float) -> bool:
    """Whether two holes are on one face and the same in every figure."""
    return (
        a.face == b.face
        and abs(a.y - b.y) <= limit
        and abs(a.x - b.x) <= limit
        and a.diameter == b.diameter
        and (a.kind, a.depth, a.angle) == (b.kind, b.depth, b.angle)
    )


def alike(a: Hole, b: Hole, limit: float) -> bool:
    """Whether two holes are the same but for face and place."""
    return (
        a.kind == b.kind
        and abs(a.diameter - b.diameter) <= limit
        and (a.depth == b.depth or _near(a.depth, b.depth, limit))
        and (a.angle or 0.0) == (b.angle or 0.0)
    )


def _near(a: float | None, b: float | None, limit: float) -> bool:
    return a is not None and b is not None and abs(a - b) <= limit


def merge_pairs(holes: Group, partners: Mapping[Face, Face], drill: Drill) -> Iterator[Group]:
    """The holes, sorted, one by one, or two that are the same on a face and its partner.

    Each hole finds at most one partner, the nearest.
    """
    for run in runs(holes, drill.merge_tolerance + ROUNDING):
        if len(run) == 1:
            yield run
            continue
        taken: set[int] = set()
        for i, placed in enumerate(run):
            _, f, hole = placed
            if f in taken:
                continue
            face = partners.get(hole.face)
            found = None if face is None else _partner(run, i, face, taken, drill)
            if found is None:
                yield (placed,)
            else:
                taken.add(found[1])
                yield (placed, found) if hole.face < found[2].face else (found, placed)


def _partner(
    holes: Group, i: int, face: Face, taken: Collection[int], drill: Drill
) -> Placed | None:
    """The nearest hole behind `holes[i]` that is the same on `face` and has no partner yet."""
    reach, limit = drill.merge_tolerance + ROUNDING, drill.same_tool_tolerance + ROUNDING
    x, _, hole = holes[i]
    best: tuple[float, int] | None = None
    partner: Placed | None = None
    for j in range(i + 1, len(holes)):
        other_x, f, other = holes[j]
        dx = other_x - x
        if dx > reach:
            break
        if other.face != face or f in taken:
            continue
        dy = abs(other.y - hole.y)
        if dy <= reach and alike(hole, other, limit):
            rank = dx + dy, f
            if best is None or rank < best:
                best, partner = rank, holes[j]
    return partner


def unmerged_because(hole: Hole, other: Hole, drill: Drill) -> str | None:
    """Why two nearby holes on the faces of a pair are not one stroke.

    None if nothing does, or if they are too far apart for the question.
    """
    if abs(hole.x - other.x) > NEAR_MISS or abs(hole.y - other.y) > NEAR_MISS:
        return None
    for name in ("x", "y"):
        mine, theirs = getattr(hole, name), getattr(other, name)
        if abs(mine - theirs) > drill.merge_tolerance + ROUNDING:
            return f"{name} {mine:g} and {theirs:g}"
    if hole.kind != other.kind:
        return f"kind {hole.kind} and {other.kind}"
    if abs(hole.diameter - other.diameter) > drill.same_tool_tolerance + ROUNDING:
        return f"diameter {hole.diameter:g} and {other.diameter:g}"
    if not alike(hole, other, drill.same_tool_tolerance + ROUNDING):
        return f"depth {_shown(hole.depth)} and {_shown(other.depth)}"
    return None


NEAR_MISS = 10.0  #: mm; holes further apart than this are not expected to merge


def _shown(depth: float | None) -> str:
    return "through" if depth is None else f"{depth:g}"


OVERLAP = error("plan-hole-overlap",
    "found {what} at x {x}, y {y} on face {face}, {apart} mm from {other} of {first}; expected at "
    "least {expected} mm between their middles",
    "A drill that breaks into another hole runs off or breaks. Two diameters at one place may be a "
    "stepped hole, of which the wider one is blind.")  # fmt: skip
TOO_NEAR = error("plan-too-near",
    "found a hole of diameter {found} on face {face} at x {x}, y {y}, {apart} mm from that of "
    "{first}; expected the same place, or one more than {expected} mm away",
    "Holes closer than the program's decimals can distinguish are one hole that was drawn twice, "
    "not quite at the same place.")  # fmt: skip
MANY_PAIRS = error("plan-hole-crowd",
    "found {found} pairs of holes that stand within {reach} mm of each other along the part, most "
    "of them about this one; expected at most {expected}",
    "So many holes do not stand beside each other on a wall: they are a drawing that was written "
    "again and again. Nothing else is said of them.")  # fmt: skip
#: that are compared; 20,000 holes of 18 mm all over a bar of 12 m have 1 of 2
MOST_PAIRS = 2_000_000
THREADS = ("thread", "left-thread")


def refuse_many_pairs(holes: Group, drill: Drill) -> Iterator[Said]:
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
                MANY_PAIRS.at(
                    hole.source, found=sum(counts), reach=f"{reach:g}", expected=MOST_PAIRS
                ),
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
                    for refusal in _judge_pair(*pair, apart, room, drill):
                        yield refusal
                        if refusal[1].severity is Severity.ERROR:
                            overlapping.add(refusal[0])


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
