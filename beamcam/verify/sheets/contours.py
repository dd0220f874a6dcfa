"""What the part needs: every stretch of every contour has a path beside it, and one only.

With r half the kerf that the program keeps off, each sample of a contour has the path r beside
it, or no tool of that width can come there.
"""

from collections.abc import Sequence

import numpy as np
from msgspec import Struct

from beamcam.errors import Diagnostic, Source
from beamcam.verify.sheets import rules
from beamcam.verify.sheets.bridges import in_bridges
from beamcam.verify.sheets.elements import Counts, Floats
from beamcam.verify.sheets.grid import Pairs
from beamcam.verify.sheets.paths import on_contour
from beamcam.verify.sheets.work import SHOWN, SPACING, Flags, Traced, Work

ROOM = 4.0  #: how far from a place that no tool can reach a path is, by half the kerf


class Covered(Struct, frozen=True):
    """Samples of contours that have a path."""

    points: Floats  #: (n, 2)
    way: Counts  #: of the path


def cover(work: Work, traced: Sequence[Traced]) -> tuple[Covered, list[Diagnostic]]:
    """The samples that have a path, what is missing, and what is followed more than once."""
    element, share, owner = work.need.samples(SPACING)
    points = work.need.elements.places(element, share)
    slack = work.tolerance + work.free[owner]
    most = float(slack.max(initial=0.0))
    pairs = work.path.near(points, most)
    away, way, _ = work.path.nearest_of(pairs, len(points))
    done = away <= slack
    blocked = np.zeros(len(points), dtype=bool)
    chosen = points
    radii = sorted({t.half_kerf for t in traced if t.half_kerf > 0.0})
    ahead = work.need.elements.directions(element, share) if radii else points
    normal = np.column_stack((-ahead[:, 1], ahead[:, 0]))
    for radius in radii:
        place, near, best = _beside(work, points, normal, radius, most)
        new = ~done & (best <= slack)
        chosen = np.where(new[:, None], place, chosen)
        way[new] = near[new]
        done |= new
        rest = np.flatnonzero(~done & ~blocked)
        blocked[rest] = _is_blocked(work, points[rest], normal[rest], radius, slack[rest])
    missing = np.flatnonzero(~done & ~blocked)
    missing = missing[~in_bridges(work, traced, points[missing])]
    _, firsts = np.unique(owner[missing], return_index=True)
    said = [work.missing(points[k]) for k in missing[firsts][:SHOWN]]
    covered = np.flatnonzero(done)
    if chosen is not points:
        pairs = work.path.near(chosen, most)
    said += _twice(work, traced, points, owner, slack, covered, pairs)
    return Covered(points[covered], way[covered]), said


def _beside(
    work: Work, points: Floats, normal: Floats, radius: float, reach: float
) -> tuple[Floats, Counts, Floats]:
    """The place a radius beside each point that is nearer to the path, which way, and how near."""
    sides = [points + sign * radius * normal for sign in (1.0, -1.0)]
    (left, way, _), (right, other, _) = (
        work.path.nearest_of(work.path.near(side, reach), len(side)) for side in sides
    )
    nearer = right < left
    place = np.where(nearer[:, None], sides[1], sides[0])
    return place, np.where(nearer, other, way), np.minimum(left, right)


def _is_blocked(work: Work, points: Floats, normal: Floats, radius: float, slack: Floats) -> Flags:
    """Where another contour is so near that no tool of that radius comes beside a point."""
    if not len(points):
        return np.zeros(0, dtype=bool)
    near = work.path.nearest_of(work.path.near(points, ROOM * radius), len(points))[0]
    place, _, _ = _beside(work, points, normal, radius, (ROOM + 1) * radius)
    room = work.need.nearest_of(work.need.near(place, radius), len(place))[0]
    found: Flags = (room < radius - slack / 2) & np.isfinite(near)
    return found


def _twice(
    work: Work,
    traced: Sequence[Traced],
    points: Floats,
    owner: Counts,
    slack: Floats,
    covered: Counts,
    pairs: Pairs,
) -> list[Diagnostic]:
    """Stretches of a contour that have more than one path; `pairs` are samples and the path."""
    need, path = work.need, work.path
    is_long = np.zeros(len(points), dtype=bool)
    is_long[covered] = need.lengths[owner[covered]] > 8 * work.tolerance
    reach = float(np.max(slack[is_long], initial=0.0))
    near = path.by_way(pairs)
    near_way = path.owner[near.element]
    kept = is_long[near.point] & on_contour(work, traced)[near_way] & (near.away <= reach)
    counts = np.bincount(near.point[kept], minlength=len(points))
    kept &= counts[near.point] > 1
    if not kept.any():
        return []
    at = path.at(near.element[kept], near.along[kept])
    stroke = work.of_way[near_way[kept]]
    passes = _passes(near.point[kept], at, stroke, 6 * reach, len(points))
    doubtful = np.flatnonzero(passes > 1)
    # Contours that run beside one another have a path each.
    beside = need.by_way(need.near(points[doubtful], 2 * reach))
    allowed = np.bincount(beside.point, minlength=len(doubtful))
    doubtful = doubtful[passes[doubtful] > allowed]
    said: list[Diagnostic] = []
    for way in np.unique(owner[doubtful])[:SHOWN]:
        mine = doubtful[owner[doubtful] == way]
        if len(mine) < 2 or np.min(np.diff(mine)) > 1:
            continue
        x, y = (points[mine[0]] - np.array(work.shift)).tolist()
        worst = int(np.max(passes[mine]))
        said.append(rules.TWICE.at(Source(work.name), x=f"{x:.3f}", y=f"{y:.3f}", found=worst))
    return said


def _passes(sample: Counts, at: Floats, stroke: Counts, apart: float, count: int) -> Counts:
    """How many separate ways of the path are near each sample.

    Places on the path that are farther apart along it than `apart` belong to different ways.
    """
    order = np.lexsort((at, stroke, sample))
    sample, at, stroke = sample[order], at[order], stroke[order]
    new = np.ones(len(sample), dtype=bool)
    new[1:] = (sample[1:] != sample[:-1]) | (stroke[1:] != stroke[:-1])
    new[1:] |= at[1:] - at[:-1] > apart
    found: Counts = np.bincount(sample[new], minlength=count)
    return found
