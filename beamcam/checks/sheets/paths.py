"""Check that every path runs along a contour, and that its strokes close.

With r half the kerf of a beam that keeps off, 0 of any other:

    every sample of a path   has a closed contour at most r away, or one along its middle (any
                             contour, with r 0), but for the leads, which lie in waste
    every stroke             closes, or ends where a contour ends
"""

from collections.abc import Sequence

import numpy as np
import shapely

from beamcam.checks.sheets.grid import Pairs
from beamcam.checks.sheets.leads import Bounds, rings
from beamcam.checks.sheets.overcut import end_faults, restart_faults
from beamcam.checks.sheets.tabs import join_bridged
from beamcam.checks.sheets.toolpaths import NEAR_BEND, Samples, Toolpaths, joined_samples
from beamcam.checks.sheets.work import MITRE, SHOWN, SPACING, Traced, Work
from beamcam.errors import Diagnostic
from beamcam.geometry.array_types import Counts, Flags, Floats

Near = tuple[Floats, Counts, Floats]  #: how far the nearest way is, which, how far along it


def follow(work: Work) -> tuple[list[Traced], list[Diagnostic]]:
    """The strokes without their leads, and what follows no contour."""
    samples = _samples(work)
    points, way = work.path.elements.places(*samples[:2]), samples[2]
    stroke = work.of_way[way]
    on, off = _nearest(work, samples, points)
    followed = on[0] <= work.slack[on[1]]
    ends = np.cumsum(np.bincount(work.of_way, minlength=len(work.strokes))).tolist()
    bounds = list(zip([0, *ends[:-1]], ends, strict=True))
    expected = np.zeros(len(work.strokes))
    if work.half_kerf:
        followed, expected = _on_or_beside(work, points, stroke, bounds, followed, off)
    bad = np.zeros(work.path.count, dtype=bool)
    bad[way[~followed]] = True
    traced = _traced(work, rings(work, bounds, bad), expected)
    if work.half_kerf:
        _round_contours(work, traced, points, stroke, off)
    join_bridged(work, bounds, traced)
    for t in traced:
        t.members = t.members or ([t] if t.closed else [])
    _overs(work, bounds, traced, points, way)
    wrong = np.flatnonzero(~followed & on_contour(work, traced)[way])
    diagnostics = _strays(work, points[wrong], way[wrong], expected)
    return traced, diagnostics + end_faults(work, traced) + restart_faults(work, traced)


def _on_or_beside(
    work: Work, points: Floats, stroke: Counts, bounds: Bounds, on: Flags, off: Near
) -> tuple[Flags, Floats]:
    """Which samples follow what they should, and how far each stroke keeps off its contour.

    `points` are the samples, `stroke` those that they are of, `on` tells which run along a curve
    that the beam stays on, `off` what the beam keeps off there. A stroke of which most samples are
    on such a curve is to stay on it, any other keeps off.
    """
    beside = off[0] <= work.half_kerf + work.slack[off[1]]
    total = np.bincount(stroke, minlength=len(work.strokes))
    on_middle = _count(work, stroke, on)
    corners = np.flatnonzero((on_middle < total)[stroke] & ~beside)
    beside[corners] = _round_corners(work, points[corners])
    centred = 2 * on_middle > total
    # A small ring may touch or cross so many open curves that most of its samples are on them.
    at_side = _count(work, stroke, beside)
    centred &= at_side <= on_middle
    both = np.flatnonzero(centred & (at_side == on_middle))
    centred[both] = ~_close(work, [bounds[k] for k in both.tolist()])
    return np.where(centred[stroke], on, beside), np.where(centred, 0.0, work.half_kerf)


def _strays(work: Work, points: Floats, way: Counts, expected: Floats) -> list[Diagnostic]:
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
        diagnostics.append(work.extra(int(work.moves.line[way[k]]), points[k], off_by, kept_off))
    return diagnostics


def _close(work: Work, bounds: Bounds) -> Flags:
    """Which strokes close, but for their leads."""
    if not bounds:
        return np.zeros(0, dtype=bool)
    lows, highs = np.array(rings(work, bounds, np.zeros(work.path.count, dtype=bool))).T
    apart = np.hypot(*(work.path.ends[highs - 1] - work.path.starts[lows]).T)
    return np.asarray(apart <= work.meeting)


def _count(work: Work, stroke: Counts, which: Flags) -> Counts:
    """How many of the samples of each stroke are `which`."""
    return np.bincount(stroke[which], minlength=len(work.strokes))


def _overs(
    work: Work, bounds: Bounds, traced: Sequence[Traced], points: Floats, way: Counts
) -> None:
    """Tell each stroke the length of other strokes that run along its ring.

    `points` are places of the path, `way` those that they lie on.
    """
    on_ring = on_contour(work, traced)
    outside = np.zeros(work.path.count, dtype=bool)
    for t, (first, last) in zip(traced, bounds, strict=True):
        if t.members or t.joined:
            outside[first : t.first] = outside[t.last : last] = True
    which = np.flatnonzero(outside[way])
    if not len(which):
        return
    number = np.arange(len(traced))
    for k, t in enumerate(traced):
        if len(t.members) > 1:
            number[k : k + len(t.members)] = k
    pairs = work.path.near(points[which], work.tolerance)
    other = work.path.owner[pairs.element]
    own = number[work.of_way[way[which[pairs.point]]]] == number[work.of_way[other]]
    missed = np.ones(len(which), dtype=bool)
    missed[pairs.point[own & on_ring[other]]] = False
    outside[way[which[missed]]] = False
    for t, (first, _) in zip(traced, bounds, strict=True):
        if not t.members:
            continue
        # A lead may come along the contour; what begins where the contour has an end is not a lead.
        heads = [work.path.starts[m.first : m.last] for m in t.members]
        for k in np.flatnonzero(outside[first : t.first]).tolist():
            away = np.hypot(*(np.concatenate(heads) - work.path.starts[first + k]).T)
            outside[first + k] = bool(away.min() <= work.meeting)
    reached = np.concatenate(([0.0], np.cumsum(np.where(outside, work.path.lengths, 0.0))))
    for t, (first, last) in zip(traced, bounds, strict=True):
        t.over = float(reached[last] - reached[first])
        t.before = float(reached[t.first] - reached[first])
        t.beyond = float(work.path.lengths[t.last : last].sum() - reached[last] + reached[t.last])


def _samples(work: Work) -> Samples:
    """Where the path is asked what it follows."""
    path = work.path
    samples = [path.samples(SPACING), beside_bends(path, work.need, _most(work))]
    if work.half_kerf:  # nothing else would see an end that runs on into the waste
        every = np.arange(path.count)
        samples.append((path.last(every), np.ones(path.count), every))
    return joined_samples(*samples)


def _most(work: Work) -> float:
    return float(work.slack.max(initial=0.0))


def _nearest(work: Work, samples: Samples, points: Floats) -> tuple[Near, Near]:
    """The nearest curve that the beam stays on at each sample, and the nearest that it keeps off.

    A curve that the beam stays on runs along its path.
    """
    most = _most(work)

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
    most = _most(work)
    return max(MITRE * work.half_kerf + most, 2 * most)


def _round_corners(work: Work, points: Floats) -> Flags:
    """Points where a path goes round a corner of a curve that it keeps off."""
    need, round_corners = work.need, np.zeros(len(points), dtype=bool)
    pairs = need.near(points, _reach(work))
    pairs = pairs.kept(work.beside[need.owner[pairs.element]])
    way = need.owner[pairs.element]
    at = need.at(pairs.element, pairs.along) - need.begins[way]
    at_end = np.minimum(at, need.lengths[way] - at) <= work.slack[way]
    round_corners[pairs.point[at_end]] = True
    return round_corners


def on_contour(work: Work, traced: Sequence[Traced]) -> Flags:
    """The ways of the path that are not leads."""
    on = np.zeros(work.path.count, dtype=bool)
    for t in traced:
        on[t.first : t.last] = True
    return on


def _traced(work: Work, kept: Bounds, radii: Floats) -> list[Traced]:
    rows = np.array(kept, dtype=np.int64).reshape(-1, 2)
    starts, ends = work.path.starts[rows[:, 0]], work.path.ends[rows[:, 1] - 1]
    closed = np.hypot(*(ends - starts).T) <= 2 * work.tolerance
    closed &= ~_gaping(work, starts, ends, closed & (radii == 0.0))
    sizes = np.array([s.last - s.first for s in work.strokes], dtype=np.int64)
    middles = work.moves.end[np.cumsum(sizes) - sizes + sizes // 2]
    boxes = _boxes(work, rows).tolist()
    columns = (work.strokes, kept, radii.tolist(), closed.tolist(), middles.tolist(), boxes)
    return [
        Traced(
            stroke, first, last, half_kerf, is_closed, work.path, work.fine,
            [(first, last)] if is_closed else [], (x, y), box, stroke.line, is_closed,
        )
        for stroke, (first, last), half_kerf, is_closed, (x, y), box in zip(*columns, strict=True)
    ]  # fmt: skip


def _gaping(work: Work, starts: Floats, ends: Floats, which: Flags) -> Flags:
    """Strokes that end beside their start because the contour has a gap there, wider than `gap`."""
    gaping = np.zeros(len(starts), dtype=bool)
    which = which & (np.hypot(*(ends - starts).T) > 2 * work.step)
    if not which.any():
        return gaping
    stops = shapely.points(np.concatenate((work.need.starts, work.need.ends)))
    tree = shapely.STRtree(stops)
    first, second = tree.query(stops, "dwithin", distance=work.torch.gap)
    free = np.ones(len(stops), dtype=bool)
    free[first[first != second]] = False
    open_ends = stops[free]
    tree = shapely.STRtree(open_ends)
    for k in np.flatnonzero(which).tolist():
        near = [
            set(tree.query(shapely.Point(place), "dwithin", distance=2 * work.tolerance).tolist())
            for place in (starts[k], ends[k])
        ]
        gaping[k] = len(near[0] | near[1]) > 1 and all(near)
    return gaping


def _round_contours(
    work: Work, traced: Sequence[Traced], points: Floats, stroke: Counts, beside: Near
) -> None:
    """Gives the strokes that keep off a contour the one that most of their samples are beside.

    Of contours on one another only the first is a ring, whichever of them is the nearest.
    """
    assert work.region is not None
    ring_of = work.region.ring_of
    is_near = np.isfinite(beside[0])
    rings = np.where(is_near, ring_of[beside[1]], -1)
    twin = np.flatnonzero(is_near & (rings < 0))
    if len(twin):
        reach = beside[0][twin].max() + float(work.slack.max(initial=0.0))
        away, nearest, _ = work.need.nearest_within(points[twin], (reach,), ring_of >= 0)
        rings[twin] = np.where(np.isfinite(away), ring_of[nearest], -1)
    known = rings >= 0
    count = len(work.region.rings)
    pairs, times = np.unique(stroke[known] * max(count, 1) + rings[known], return_counts=True)
    order = np.argsort(times, kind="stable")
    most = dict(zip((pairs[order] // max(count, 1)).tolist(), pairs[order].tolist(), strict=True))
    for k, t in enumerate(traced):
        if t.half_kerf and k in most:
            ring = most[k] % count
            polygon = work.region.polygons[ring]
            t.contour, t.box, t.group, t.goes_round = polygon, polygon.bounds, -1 - ring, True
            t.middle = polygon.exterior.coords[0]


def _boxes(work: Work, kept: Counts) -> Floats:
    """The box around the ways of each stroke: least x and y, greatest x and y, (n, 4)."""
    low, high = work.path.boxes
    # Every other stretch is that between two strokes.
    bounds = np.minimum(kept.ravel(), work.path.count - 1)
    lasts = kept[:, 1] - 1
    least = np.minimum(np.minimum.reduceat(low, bounds)[::2], low[lasts])
    greatest = np.maximum(np.maximum.reduceat(high, bounds)[::2], high[lasts])
    return np.concatenate((least, greatest), axis=1)


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
    ahead = own.elements.directions(element, share)[pairs.point]
    length = other.elements.length[pairs.element]
    at = np.divide(pairs.along, length, out=np.zeros(len(length)), where=length > 0.0)
    there = other.elements.directions(pairs.element, at)
    across = np.abs(ahead[:, 0] * there[:, 1] - ahead[:, 1] * there[:, 0])
    is_aligned: Flags = across <= np.sin(MAX_TURN_RAD)
    which = np.flatnonzero(~is_aligned)
    if len(which):
        pairs = pairs.kept(which)
        most = own.most_turns(slack)[element[pairs.point]] + other.most_turns(slack)[pairs.element]
        is_aligned[which] = across[which] <= np.sin(np.minimum(MAX_TURN_RAD + most, np.pi / 2))
        is_aligned[which] |= _near_bend(other, pairs, slack)
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


def _near_bend(toolpaths: Toolpaths, pairs: Pairs, slack: float) -> Flags:
    """Pairs whose place on the element is near where its way ends or bends."""
    begins, ends, _ = _bends(toolpaths, slack)
    way = toolpaths.owner[pairs.element]
    at, reach = toolpaths.at(pairs.element, pairs.along) - toolpaths.begins[way], NEAR_BEND * slack
    is_near: Flags = begins[way] & (at <= reach)
    return is_near | (ends[way] & (at >= toolpaths.lengths[way] - reach))


def _bends(toolpaths: Toolpaths, slack: float) -> tuple[Flags, Flags, Flags]:
    """The ways that begin at a bend, those that end at one, and those that end at the next one."""
    turns, every = toolpaths.turns(slack), np.arange(toolpaths.count)
    before, behind = turns[toolpaths.first(every)], turns[toolpaths.last(every) + 1]
    return before > SMOOTH_RAD, behind > SMOOTH_RAD, np.isfinite(behind)
