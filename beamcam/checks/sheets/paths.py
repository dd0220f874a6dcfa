"""Paths and contours compared, each at samples along it: what has no other beside it is told.

With r half the kerf of a beam that keeps off, 0 of any other:

    every sample of a path     has a closed contour at most r away, or one along its middle (any
                               contour, with r 0), but for the leads, which lie in waste
    every sample of a contour  has one path, where the beam's middle passes it: r off a closed one,
                               if there is room (see `areas`); bridges are left out

Contours are asked at places `SPACING` apart, or r / 2 but no less than 0.2 mm where the beam keeps
off, three on each or more: no stretch is overlooked that is longer, nor one of more than a third
of its curve. Distances are exact for lines and arcs, and within the machine's tolerance / 8 for
others.
"""

from collections.abc import Sequence

import numpy as np

from beamcam.checks.sheets import rules
from beamcam.checks.sheets.areas import in_corners, left_faults
from beamcam.checks.sheets.grid import Pairs
from beamcam.checks.sheets.overcut import end_faults
from beamcam.checks.sheets.toolpaths import (
    NEAR_BEND,
    Samples,
    Toolpaths,
    joined_samples,
    kept_samples,
    nearest_pairs,
)
from beamcam.checks.sheets.tracing import Near, Traced, close, in_bridges, on_contour, trace
from beamcam.checks.sheets.work import MITRE, SHOWN, SPACING, Work
from beamcam.errors import Diagnostic
from beamcam.geometry.array_types import Counts, Flags, Floats


def follow(work: Work) -> tuple[list[Traced], list[Diagnostic]]:
    """The strokes without their leads, and what follows no contour."""
    path = work.path
    several = [path.samples(SPACING), beside_bends(path, work.need, work.most_slack)]
    if work.half_kerf:  # nothing else would see an end that runs on into the waste
        several.append((path.last, np.ones(path.count), np.arange(path.count)))
    samples = joined_samples(*several)
    points, way = path.elements.places(*samples[:2]), samples[2]
    on, off = _nearest(work, samples, points)
    followed = on[0] <= work.slack[on[1]]
    expected = np.zeros(len(work.strokes))
    if work.half_kerf:
        followed, expected = _on_or_beside(work, points, work.of_way[way], followed, off)
    bad = np.zeros(path.count, dtype=bool)
    bad[way[~followed]] = True
    traced = trace(work, bad, expected, points, way, off)
    wrong = np.flatnonzero(~followed & on_contour(work, traced)[way])
    diagnostics = _off_contours(work, points[wrong], way[wrong], expected)
    return traced, diagnostics + end_faults(work, traced)


def _on_or_beside(
    work: Work, points: Floats, stroke: Counts, on: Flags, off: Near
) -> tuple[Flags, Floats]:
    """Which samples follow what they should, and how far each stroke keeps off its contour.

    `points` are the samples, `stroke` those that they are of, `on` tells which run along a curve
    that the beam stays on, `off` what the beam keeps off there. A stroke of which most samples are
    on such a curve is to stay on it, any other keeps off.
    """
    beside = off[0] <= work.half_kerf + work.slack[off[1]]
    total = np.bincount(stroke, minlength=len(work.strokes))
    on_middle = np.bincount(stroke[on], minlength=len(work.strokes))
    # A path goes round a corner of a curve that it keeps off farther away.
    need, corners = work.need, np.flatnonzero((on_middle < total)[stroke] & ~beside)
    pairs = need.near(points[corners], _reach(work))
    pairs = pairs.kept(work.beside[need.owner[pairs.element]])
    curve = need.owner[pairs.element]
    at = need.at(pairs.element, pairs.along) - need.begins[curve]
    at_end = np.minimum(at, need.lengths[curve] - at) <= work.slack[curve]
    beside[corners[pairs.point[at_end]]] = True
    centred = 2 * on_middle > total
    # A small ring may touch or cross so many open curves that most of its samples are on them.
    at_side = np.bincount(stroke[beside], minlength=len(work.strokes))
    centred &= at_side <= on_middle
    both = np.flatnonzero(centred & (at_side == on_middle))
    centred[both] = ~close(work, both)
    return np.where(centred[stroke], on, beside), np.where(centred, 0.0, work.half_kerf)


def _off_contours(work: Work, points: Floats, way: Counts, expected: Floats) -> list[Diagnostic]:
    """The first place of each stroke at which it follows nothing; `way` is that of each place."""
    diagnostics: list[Diagnostic] = []
    _, firsts = np.unique(work.of_way[way], return_index=True)
    for k in firsts[:SHOWN].tolist():
        apart = float(expected[work.of_way[way[k]]])
        away, nearest = work.need.nearest_to(points[k])
        contour = work.contour(nearest)
        kept_off = f"{apart:g} mm within {work.slack[nearest]:.4f}"
        off_by = f"{away:.4f} mm off the nearest contour to {work.process}, that of {contour}"
        if away <= work.slack[nearest] and not apart:
            off_by, kept_off = f"across the contour of {contour}", "it along one"
        line = int(work.moves.line[way[k]])
        diagnostics.append(work.fault(rules.EXTRA, line, points[k], away=off_by, expected=kept_off))
    return diagnostics


def _nearest(work: Work, samples: Samples, points: Floats) -> tuple[Near, Near]:
    """The nearest curve that the beam stays on at each sample, and the nearest that it keeps off.

    A curve that the beam stays on runs along its path.
    """
    most = work.most_slack

    def along(pairs: Pairs) -> Flags:
        return aligned(work.path, samples, work.need, pairs, most)

    if not work.half_kerf:
        found = work.need.nearest_within(points, (2 * most,), fits=along)
        return found, found
    on = work.need.nearest_within(points, (most,), ~work.beside, along)
    reaches = (work.half_kerf + most, _reach(work))
    return on, work.need.nearest_within(points, reaches, work.beside)


def _reach(work: Work) -> float:
    """Permitted distance of a path from a corner."""
    most = work.most_slack
    return max(MITRE * work.half_kerf + most, 2 * most)


# --- coverage -------------------------------------------------------------------------------------


MIN_SPACING = 0.2
BELOW = 0.1  #: sine of the angle below a contour from which on a path may be behind it
OVER = 6.0  #: how far a stroke may run over its start, by half the kerf

#: Where each of some ways begins and ends, counted along all, and whether it closes.
Loops = tuple[Floats, Floats, Flags]


def cover(work: Work, traced: Sequence[Traced]) -> list[Diagnostic]:
    """Pieces of contours that are missing, and those followed more than once."""
    dense = min(SPACING, max(work.half_kerf / 2, MIN_SPACING))
    samples = work.need.samples(np.where(work.beside, dense, SPACING))
    count = len(samples[2])
    bends = beside_bends(work.need, work.path, work.most_slack)
    bends = kept_samples(bends, ~(work.beside | work.small)[bends[2]])
    samples = joined_samples(samples, bends)
    points, owner = work.need.elements.places(*samples[:2]), samples[2]
    reach = (work.slack + np.where(work.beside, work.half_kerf, 0.0))[owner]
    near = work.path.near(points, float(reach.max(initial=0.0)))
    best = nearest_pairs(_pairs(work, traced, samples, points, near))
    away = np.full(len(points), np.inf)
    away[best.point] = best.away
    missing = np.flatnonzero((away > reach) & ~work.small[owner])
    diagnostics: list[Diagnostic] = []
    if len(missing) and work.half_kerf:
        missing = missing[~work.on_kept_off(points[missing]) | work.beside[owner[missing]]]
        is_left, corners = in_corners(work, traced, missing, samples)
        missing = missing[~is_left]
        diagnostics = left_faults(work, corners) if corners is not None else []
    missing = missing[~in_bridges(work, traced, points[missing])]
    _, firsts = np.unique(owner[missing], return_index=True)
    diagnostics += [work.missing(int(owner[k]), points[k]) for k in missing[firsts[:SHOWN]]]
    covered = np.flatnonzero((away <= reach)[:count])
    if work.half_kerf:
        feet = best.kept((best.point < count) & (best.away <= reach[best.point]))
        points[feet.point] = work.path.places_of(feet)
        near = work.path.near(points[:count], work.most_slack)
    else:
        near = near.kept(near.point < count)
    return diagnostics + _twice(work, traced, points[:count], near, owner[:count], covered)


def _pairs(
    work: Work, traced: Sequence[Traced], samples: Samples, points: Floats, pairs: Pairs
) -> Pairs:
    """Those pairs of a sample and an element of the path that may be of one curve.

    A beam that keeps off is not behind the contour: what is cut from behind a thin wall is not cut
    at this side of it.
    """
    element, share, owner = samples
    beside = work.beside[owner]
    if work.half_kerf:
        keeps_off = np.array([t.half_kerf > 0.0 for t in traced])
        stroke = work.of_way[work.path.owner[pairs.element]]
        pairs = pairs.kept(keeps_off[stroke] == beside[pairs.point])
        to_waste = work.sides[owner][:, None] * work.left_of(element, share)
        way = work.path.places_of(pairs) - points[pairs.point]
        below = np.sum(way * to_waste[pairs.point], axis=1) < -BELOW * pairs.away
        which = np.flatnonzero(below & beside[pairs.point] & (pairs.away > 0.0))
        off = work.off_surely(owner[pairs.point[which]]) / pairs.away[which]
        behind = points[pairs.point[which]] + off[:, None] * way[which]
        pairs = pairs.kept(np.delete(np.arange(len(way)), which[work.region.in_part(behind)]))
    along = aligned(work.need, samples, work.path, pairs, work.most_slack)
    return pairs.kept(along | beside[pairs.point])


def _twice(
    work: Work, traced: Sequence[Traced], points: Floats, pairs: Pairs, owner: Counts,
    covered: Counts,
) -> list[Diagnostic]:  # fmt: skip
    """Pieces of a contour that have more than one path.

    `points` are where it passes, `pairs` these and what of the path is near them.
    """
    slack = work.slack[owner]
    is_long = np.zeros(len(points), dtype=bool)
    is_long[covered] = work.need.lengths[owner[covered]] > 8 * work.tolerance
    reach = float(np.max(slack[is_long], initial=0.0))
    passes = _path_passes(work, traced, pairs, is_long, reach)
    doubtful = np.flatnonzero(passes > 1)
    # Contours side by side have a path each; one that runs back beside itself has a path for each
    # of its passes.
    need, near = work.need, work.half_kerf + 2 * reach
    beside = need.near(points[doubtful], near)
    beside = beside.kept(~work.region.twins[need.owner[beside.element]])
    at, curve = need.at(beside.element, beside.along), need.owner[beside.element]
    loops = need.begins, need.begins + need.lengths, np.all(need.starts == need.ends, axis=1)
    permitted = _passes(beside.point, at, curve, loops, 6 * near, len(doubtful))
    doubtful = doubtful[passes[doubtful] > permitted]
    diagnostics: list[Diagnostic] = []
    for way in sorted(set(owner[doubtful].tolist()))[:SHOWN]:
        mine = doubtful[owner[doubtful] == way]
        if len(mine) < 2 or np.min(np.diff(mine)) > 1:
            continue
        place, times = points[mine[0]] - np.array(work.shift), int(np.max(passes[mine]))
        contour = work.contour(int(way))
        diagnostics.append(work.fault(rules.TWICE, None, place, contour=contour, found=times))
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
    firsts, lasts = np.array([(t.first, t.last - 1) for t in traced]).T
    ends = work.path.begins[lasts] + work.path.lengths[lasts]
    if work.torch.kerf_by == "machine" and work.half_kerf:
        # Such a stroke has to run over its start: half a kerf along the contour at both ends of it.
        over = OVER * work.half_kerf + work.torch.lead_out + work.most_over
        kept &= work.path.at(near.element, near.along) <= (ends - over)[work.of_way[way]]
    at = work.path.at(near.element[kept], near.along[kept])
    loops = work.path.begins[firsts], ends, np.array([t.closed for t in traced])
    return _passes(near.point[kept], at, work.of_way[way[kept]], loops, 6 * reach, len(which))


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


# --- alignment ------------------------------------------------------------------------------------

# Curves that run along one another, not only near one another at the places that were asked.
#
# Places at equal distances on a line may all lie on lines that cross it at equal distances, or on
# the dashes of a broken line. So a place on one of two sets of curves counts as on the other only
# where that runs in the same direction, or back; and the first is asked on both sides of each place
# where the other ends or bends, since nowhere else one can leave the other unseen.


MAX_TURN_RAD = 0.02  #: between lines and arcs that run along one another, of any length
SMOOTH_RAD = 0.26  #: from one way to the next, where they do not bend
ASIDE = 8.0  #: slacks from an end or a bend, where the other curve is asked


def aligned(
    own: Toolpaths, samples: Samples, other: Toolpaths, pairs: Pairs, slack: float
) -> Flags:
    """The pairs of a sample of `own` and an element of `other` in whose direction that runs."""
    element, share, _ = samples
    ahead = own.elements.directions(element[pairs.point], share[pairs.point])
    there = other.elements.directions(pairs.element, other.shares(pairs))
    across = np.abs(ahead[:, 0] * there[:, 1] - ahead[:, 1] * there[:, 0])
    is_aligned: Flags = across <= np.sin(MAX_TURN_RAD)
    which = np.flatnonzero(~is_aligned)
    if len(which):
        pairs = pairs.kept(which)
        most = own.most_turns(slack)[element[pairs.point]] + other.most_turns(slack)[pairs.element]
        is_aligned[which] = across[which] <= np.sin(np.minimum(MAX_TURN_RAD + most, np.pi / 2))
        # Near where its way ends or bends it may run in any direction.
        begins, ends, _ = _bends(other, slack)
        way, reach = other.owner[pairs.element], NEAR_BEND * slack
        at = other.at(pairs.element, pairs.along) - other.begins[way]
        is_aligned[which] |= begins[way] & (at <= reach)
        is_aligned[which] |= ends[way] & (at >= other.lengths[way] - reach)
    return is_aligned


def beside_bends(own: Toolpaths, other: Toolpaths, slack: float) -> Samples:
    """The places of `own` on both sides of where a way of `other` ends or bends beside it.

    Where a way of `own` has no such place inside, the other runs along all of it or nowhere.
    """
    begins, ends, meets = _bends(other, slack)
    places = np.concatenate((other.starts[begins], other.ends[ends & ~meets]))
    pairs = own.near(places, slack)
    way = own.owner[pairs.element]
    at = own.at(pairs.element, pairs.along) - own.begins[way]
    aside = ASIDE * slack
    inside = np.flatnonzero((at > aside) & (at < own.lengths[way] - aside))
    way, at = np.tile(way[inside], 2), at[inside]
    return own.samples_at(way, np.concatenate((at - aside, at + aside)))


def _bends(toolpaths: Toolpaths, slack: float) -> tuple[Flags, Flags, Flags]:
    """The ways that begin at a bend, those that end at one, and those that end at the next one."""
    turns = toolpaths.turns(slack)
    before, behind = turns[toolpaths.first], turns[toolpaths.last + 1]
    return before > SMOOTH_RAD, behind > SMOOTH_RAD, np.isfinite(behind)
