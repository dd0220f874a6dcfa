"""Duplicate holes, and flange holes that two spindles drill in one stroke.

Two holes of one face that are the same in every figure are one hole that was written twice; it
is drilled once, and the second is listed. Two holes on the two faces of a pair of spindles are
one stroke if both are there with the same x, y, diameter, depth, kind and cone: 49.95 and 50.00
are the same place, since that is what two exports of one model leave (`merge_tolerance`).

The holes are walked in order of x, so that each looks only at those a tolerance further on.
"""

from collections import defaultdict
from collections.abc import Collection, Iterator, Mapping
from math import floor
from operator import itemgetter

from beamcam.machine.drill import Drill
from beamcam.model.part import Face, Hole

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
    reach, limit = drill.merge_tolerance + ROUNDING, drill.twin + ROUNDING
    x, _, hole = holes[i]
    best: tuple[float, int] | None = None
    found: Placed | None = None
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
                best, found = rank, holes[j]
    return found


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
    if abs(hole.diameter - other.diameter) > drill.twin + ROUNDING:
        return f"diameter {hole.diameter:g} and {other.diameter:g}"
    if not alike(hole, other, drill.twin + ROUNDING):
        return f"depth {_shown(hole.depth)} and {_shown(other.depth)}"
    return None


NEAR_MISS = 10.0  #: mm; holes further apart than this are not expected to merge


def _shown(depth: float | None) -> str:
    return "through" if depth is None else f"{depth:g}"
