"""Coverage of the part: every stretch of every contour has exactly one path.

With r half the kerf of a beam that keeps off, each sample of a closed contour has a path at most r
away, or lies in a corner that no beam of that width reaches; each of any other has one on it.

Curves are asked at places `SPACING` apart, or r / 2 but no less than 0.2 mm where the beam keeps
off, three on each or more: no stretch is overlooked that is longer, nor one of more than a third
of its curve. At these places distances are exact for lines and arcs, and within the machine's
tolerance / 8 for others.
"""

from collections.abc import Sequence

import numpy as np

from beamcam.checks.sheets import rules
from beamcam.checks.sheets.areas import in_corners, left_faults, on_own_side
from beamcam.checks.sheets.grid import Pairs
from beamcam.checks.sheets.paths import aligned, beside_bends, on_contour
from beamcam.checks.sheets.tabs import in_bridges
from beamcam.checks.sheets.toolpaths import Samples, Toolpaths, kept_samples
from beamcam.checks.sheets.work import SHOWN, SPACING, Traced, Work
from beamcam.errors import Diagnostic, Source
from beamcam.geometry.array_types import Counts, Flags, Floats

#: Where each of some ways begins and ends, counted along all, and whether it closes.
Loops = tuple[Floats, Floats, Flags]

MIN_SPACING = 0.2
OVER = 6.0  #: how far a stroke may run over its start, by half the kerf


def cover(work: Work, traced: Sequence[Traced]) -> list[Diagnostic]:
    """Stretches that are missing, and those followed more than once."""
    beside = work.beside
    dense = min(SPACING, max(work.half_kerf / 2, MIN_SPACING))
    samples = work.need.samples(np.where(beside, dense, SPACING))
    points, owner = work.need.elements.places(*samples[:2]), samples[2]
    reach = _reaches(work)[owner]
    pairs = _pairs(work, traced, samples, points)
    away, feet = work.path.feet(pairs, len(points))
    missing = np.flatnonzero((away > reach) & ~work.small[owner])
    diagnostics: list[Diagnostic] = []
    if len(missing) and work.half_kerf:
        missing = missing[~work.on_kept_off(points[missing]) | beside[owner[missing]]]
        is_left, corners = in_corners(work, traced, missing, samples)
        missing = missing[~is_left]
        diagnostics = left_faults(work, corners)
    bends, lost = _left_at_bends(work, traced)
    diagnostics += _missing(
        work,
        traced,
        np.concatenate((points[missing], bends)),
        np.concatenate((owner[missing], lost)),
    )
    covered = np.flatnonzero(away <= reach)
    places = points
    if work.half_kerf:
        places = np.where((away <= reach)[:, None], feet, points)
    pairs = work.path.near(places, float(work.slack.max(initial=0.0)))
    return diagnostics + _twice(work, traced, places, owner, work.slack[owner], covered, pairs)


def _reaches(work: Work) -> Floats:
    """How far each curve may be from its path."""
    reaches: Floats = work.slack + np.where(work.beside, work.half_kerf, 0.0)
    return reaches


def _pairs(work: Work, traced: Sequence[Traced], samples: Samples, points: Floats) -> Pairs:
    """The samples and the elements of the path that may be of their curve."""
    owner = samples[2]
    pairs = work.path.near(points, float(_reaches(work)[owner].max(initial=0.0)))
    if work.half_kerf:
        pairs = _own(work, traced, pairs, work.beside[owner])
        pairs = on_own_side(work, samples, points, pairs)
    along = aligned(work.need, samples, work.path, pairs, float(work.slack.max(initial=0.0)))
    return pairs.kept(along | work.beside[owner][pairs.point])


def _left_at_bends(work: Work, traced: Sequence[Traced]) -> tuple[Floats, Counts]:
    """Where the path leaves a curve that the beam stays on, (n, 2), and the curve."""
    samples = beside_bends(work.need, work.path, float(work.slack.max(initial=0.0)))
    samples = kept_samples(samples, ~(work.beside | work.small)[samples[2]])
    points, owner = work.need.elements.places(*samples[:2]), samples[2]
    away, _ = work.path.feet(_pairs(work, traced, samples, points), len(points))
    lost = away > work.slack[owner]
    if work.half_kerf:
        lost &= ~work.on_kept_off(points)
    return points[lost], owner[lost]


def _missing(
    work: Work, traced: Sequence[Traced], places: Floats, owner: Counts
) -> list[Diagnostic]:
    """That some curves have no path at some places, but for those in bridges."""
    left = ~in_bridges(work, traced, places)
    places, owner = places[left], owner[left]
    _, firsts = np.unique(owner, return_index=True)
    return [work.missing(int(owner[k]), places[k]) for k in firsts[:SHOWN]]


def _own(work: Work, traced: Sequence[Traced], pairs: Pairs, beside: Flags) -> Pairs:
    """Pairs of a sample that the beam keeps off and a path that does so, or of neither."""
    keeps_off = np.array([t.half_kerf > 0.0 for t in traced])
    stroke = work.of_way[work.path.owner[pairs.element]]
    return pairs.kept(keeps_off[stroke] == beside[pairs.point])


def _twice(
    work: Work, traced: Sequence[Traced], points: Floats, owner: Counts, slack: Floats,
    covered: Counts, pairs: Pairs,
) -> list[Diagnostic]:  # fmt: skip
    """Stretches of a contour that have more than one path.

    `points` are places of the path, or of the contour where the beam stays on that; `pairs` are
    they and the path.
    """
    is_long = np.zeros(len(points), dtype=bool)
    is_long[covered] = work.need.lengths[owner[covered]] > 8 * work.tolerance
    reach = float(np.max(slack[is_long], initial=0.0))
    passes = _path_passes(work, traced, pairs, is_long, reach)
    doubtful = np.flatnonzero(passes > 1)
    doubtful = doubtful[passes[doubtful] > _permitted(work, points[doubtful], reach)]
    diagnostics: list[Diagnostic] = []
    for way in sorted(set(owner[doubtful].tolist()))[:SHOWN]:
        mine = doubtful[owner[doubtful] == way]
        if len(mine) < 2 or np.min(np.diff(mine)) > 1:
            continue
        x, y = (points[mine[0]] - np.array(work.shift)).tolist()
        worst = int(np.max(passes[mine]))
        diagnostics.append(
            rules.TWICE.at(
                Source(work.name), contour=work.contour(int(way)),
                x=f"{x:.3f}", y=f"{y:.3f}", found=worst,
            )
        )  # fmt: skip
    return diagnostics


def _path_passes(
    work: Work, traced: Sequence[Traced], pairs: Pairs, which: Flags, reach: float
) -> Counts:
    """How often the path passes each sample; 0 of those that are none of `which`, or passed once.

    `pairs` are the samples and the path.
    """
    near = work.path.by_way(pairs)
    way = work.path.owner[near.element]
    kept = which[near.point] & on_contour(work, traced)[way] & (near.away <= reach)
    kept &= np.bincount(near.point[kept], minlength=len(which))[near.point] > 1
    if not kept.any():
        return np.zeros(len(which), dtype=np.int64)
    kept &= ~_overlap(work, traced, near)
    at = work.path.at(near.element[kept], near.along[kept])
    stroke = work.of_way[way[kept]]
    loops = _loops(work.path, traced)
    return _passes(near.point[kept], at, stroke, loops, 6 * reach, len(which))


def _permitted(work: Work, points: Floats, reach: float) -> Counts:
    """How many passes places may have.

    Contours side by side have a path each; one that runs back beside itself has a path for each of
    its passes.
    """
    need = work.need
    beside = need.near(points, work.half_kerf + 2 * reach)
    if work.region is not None:
        beside = beside.kept(~work.region.twins[need.owner[beside.element]])
    at, way = need.at(beside.element, beside.along), need.owner[beside.element]
    toolpaths = need.begins, need.begins + need.lengths, np.all(need.starts == need.ends, axis=1)
    return _passes(beside.point, at, way, toolpaths, 6 * (work.half_kerf + 2 * reach), len(points))


def _overlap(work: Work, traced: Sequence[Traced], near: Pairs) -> Flags:
    """Which pairs are of the end of a stroke that has to run over its start.

    A controller that keeps off takes up half a kerf along the contour at both ends of it.
    """
    if work.torch.kerf_by != "machine" or not work.half_kerf:
        return np.zeros(len(near.point), dtype=bool)
    path = work.path
    lasts = np.array([t.last for t in traced]) - 1
    ends = path.begins[lasts] + path.lengths[lasts]
    stroke = work.of_way[path.owner[near.element]]
    over = OVER * work.half_kerf + work.torch.lead_out + work.most_over
    overlap: Flags = path.at(near.element, near.along) > ends[stroke] - over
    return overlap


def _loops(path: Toolpaths, traced: Sequence[Traced]) -> Loops:
    firsts, lasts = np.array([(t.first, t.last - 1) for t in traced]).T
    closed = np.array([t.closed for t in traced])
    return path.begins[firsts], path.begins[lasts] + path.lengths[lasts], closed


def _passes(
    sample: Counts, at: Floats, stroke: Counts, loops: Loops, apart: float, count: int
) -> Counts:
    """How many separate ways of the path are near each sample.

    Places on the path that are farther apart along it than `apart` belong to different ways; the
    way over the start of a closed stroke counts too.
    """
    if not len(sample):
        return np.zeros(count, dtype=np.int64)
    order = np.lexsort((at, stroke, sample))
    sample, at, stroke = sample[order], at[order], stroke[order]
    new = np.ones(len(sample), dtype=bool)
    new[1:] = (sample[1:] != sample[:-1]) | (stroke[1:] != stroke[:-1])
    new[1:] |= at[1:] - at[:-1] > apart
    passes: Counts = np.bincount(sample[new], minlength=count)
    change = np.flatnonzero((sample[1:] != sample[:-1]) | (stroke[1:] != stroke[:-1])) + 1
    first, last = np.append(0, change), np.append(change, len(sample)) - 1
    begins, ends, closed = (column[stroke[first]] for column in loops)
    over = closed & (at[first] - begins + ends - at[last] <= apart)
    over &= np.add.reduceat(new, first) > 1
    np.subtract.at(passes, sample[first[over]], 1)
    return passes
