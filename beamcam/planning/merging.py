"""Which holes are one hole, and which flange holes are one stroke of two spindles.

Two holes of one face that are the same in every figure are one hole that was written twice; it
is drilled once, and the second is listed. Two holes on the two faces of a pair of spindles are
one stroke if both are there with the same x, y, diameter, depth, kind and cone: 49.95 and 50.00
are the same place, since that is what two exports of one model leave (`merge_tolerance`).

The holes are walked in order of x, so that each looks only at those a tolerance further on.
"""

from collections.abc import Iterator, Sequence
from math import floor

from beamcam.machine.machine import Drill, Machine
from beamcam.model.part import Hole
from beamcam.model.plan import FeatureRef

Placed = tuple[FeatureRef, Hole]
Group = tuple[Placed, ...]  #: one hole, or two on the two faces of a pair
ROUNDING = 1e-9


def drop_duplicates(
    holes: Sequence[Placed], tolerance: float
) -> tuple[list[Placed], dict[FeatureRef, Placed]]:
    """The holes in order of piece and x, each once; and for each dropped one which it repeats.

    Of holes that are the same the first in the order given stays.
    """
    kept: list[Placed] = []
    repeats: dict[FeatureRef, Placed] = {}
    limit = tolerance + ROUNDING
    known: dict[tuple[int, str, int], list[Placed]] = {}  # by piece, face and nearest mm of x
    for placed in holes:
        (piece, _), hole = placed
        # Most x are whole millimetres, in the middle of their own.
        face, x = hole.face, hole.x + 0.5
        low, high = floor(x - limit), floor(x + limit)
        if low == high:
            near = known.get((piece, face, low))
        else:
            near = [p for at in range(low, high + 1) for p in known.get((piece, face, at), ())]
        before = next((p for p in near if _is_same(p[1], hole, limit)), None) if near else None
        if before is not None:
            repeats[placed[0]] = before
            continue
        kept.append(placed)
        if near is not None and low == high:
            near.append(placed)
        else:
            known.setdefault((piece, face, floor(x)), []).append(placed)
    kept.sort(key=_along)
    return kept, repeats


def _is_same(a: Hole, b: Hole, limit: float) -> bool:
    """Whether two holes of one face are the same in every figure."""
    return (
        abs(a.x - b.x) <= limit
        and abs(a.y - b.y) <= limit
        and a.diameter == b.diameter
        and (a.kind, a.depth, a.angle) == (b.kind, b.depth, b.angle)
    )


def _along(placed: Placed) -> tuple[int, float]:
    return placed[0][0], placed[1].x


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


def merge_pairs(holes: Sequence[Placed], machine: Machine, drill: Drill) -> Iterator[Group]:
    """The holes, sorted along x, those that are the same on both faces of a pair two by two.

    Each hole finds at most one partner, the nearest.
    """
    partner_face = {a: b for pair in machine.pairs for a, b in (pair.faces, pair.faces[::-1])}
    reach, limit = drill.merge_tolerance + ROUNDING, drill.twin + ROUNDING
    count = len(holes)
    taken: set[FeatureRef] = set()
    for i, placed in enumerate(holes):
        ref, hole = placed
        if ref in taken:
            continue
        wanted = partner_face.get(hole.face)
        best: tuple[float, FeatureRef] | None = None
        found = placed
        if wanted is not None:
            x, y = hole.x, hole.y
            for j in range(i + 1, count):
                key, other = holes[j]
                dx = other.x - x
                if dx > reach or key[0] != ref[0]:
                    break
                if other.face != wanted or key in taken:
                    continue
                dy = abs(other.y - y)
                if dy <= reach and alike(hole, other, limit):
                    rank = dx + dy, key
                    if best is None or rank < best:
                        best, found = rank, holes[j]
        if best is None:
            yield (placed,)
        else:
            taken.add(best[1])
            yield (placed, found) if hole.face < found[1].face else (found, placed)


def unmerged_because(hole: Hole, other: Hole, drill: Drill) -> str | None:
    """What keeps two holes on the faces of a pair, near each other, from being one stroke.

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
