"""Part and waste regions of a sheet.

The part is the set of points that an odd number of closed cut contours enclose, curves that are
drawn twice counted once. A contour that an even number of others enclose is an outline, its waste
outside; one that an odd number enclose is a hole, its waste inside.

Which contours are closed says `joining`. All other curves are open and have no inside: no side and
no order is asked of them, they bound no part, and the beam stays centred on them.
"""

from collections.abc import Sequence

import numpy as np
import shapely
from msgspec import Struct
from numpy.typing import NDArray

from beamcam.geometry.array_types import Counts, Flags, Floats
from beamcam.geometry.near import first_equal
from beamcam.verify.sheets.grid import Elements, Pairs
from beamcam.verify.sheets.joining import (
    SLACK,
    WRITTEN_SAME,
    Chain,
    closed_features,
    closed_rings,
    rings_of,
)
from beamcam.verify.sheets.overlaps import Stretches, trim, whole
from beamcam.verify.sheets.toolpaths import Samples, Toolpaths

SAME_PLACE = 5e-3  #: curves as near as this are drawn twice
SAME_POINT = 1e-6  #: of a gap, what its last digits may be
WIDEST_LOOP = 4.0  #: gaps, corner to corner, of a ring that crosses itself by a hair
MIN_WIDTH = 1e-3  #: half the width, on an average, of what has an inside
#: Of a curve, where it is asked whether it lies on another; most are out after the first.
SHARES = (0.5, 0.29, 0.71, 0.13, 0.87)


class Region(Struct, frozen=True):
    """The closed contours of a sheet; ways are numbered as those that it was made of."""

    polygons: NDArray[np.object_]  #: of each ring
    rings: list[Chain]
    closed: Flags  #: ways of a ring, and those that lie on one
    twins: Flags  #: ways that lie on others
    apart: Floats  #: how far a way may be from where it is cut: from its twin, from its neighbours

    def depth(self, points: Floats) -> Counts:
        """Number of contours that enclose each point (n, 2)."""
        asked, _ = shapely.STRtree(self.polygons).query(shapely.points(points), "within")
        return np.bincount(asked, minlength=len(points))

    def in_part(self, points: Floats) -> Flags:
        """Which points (n, 2) lie in the part."""
        found: Flags = self.depth(points) % 2 == 1
        return found


def region_of(toolpaths: Toolpaths, features: Counts, gap: float, fine: float) -> Region:
    """The region of ways whose features are known by their numbers.

    Ends at most `gap` apart meet, and rings no farther from one another are the same. Outlines are
    chords at most `fine` off.
    """
    real = np.flatnonzero(toolpaths.lengths > 0.0)
    own = closed_features(toolpaths, features, real)
    rank = _ranks(toolpaths, own)
    twins = _lie_on(toolpaths, rank, SAME_PLACE)
    drawn = whole(toolpaths, fine)
    rings = closed_rings(drawn, [k for k in real.tolist() if own[k]], features)
    loose = [k for k in real.tolist() if not own[k] and not twins[k]]
    once = [ring for ring in rings if not all(twins[k] for k, _ in ring)]
    trim(drawn, toolpaths, loose, np.where(twins, toolpaths.count, rank), WRITTEN_SAME)
    once += rings_of(drawn, loose, gap)
    sizes = np.diff(drawn.begins)
    once = [ring for ring in once if sizes[[k for k, _ in ring]].sum() > 3]
    polygons = _polygons(drawn, once)
    # A line there and back again has no inside.
    wide = shapely.area(polygons) > MIN_WIDTH * shapely.length(polygons)
    again, under = _same_rings(polygons, gap)
    closed, apart = np.zeros(toolpaths.count, dtype=bool), _joined(drawn, once) + SAME_PLACE * twins
    closed[[k for ring, is_wide in zip(once, wide, strict=True) if is_wide for k, _ in ring]] = True
    closed |= twins & _on(toolpaths, closed, SAME_PLACE)
    twins[[k for r in again for k, _ in once[r]]] = True
    apart = np.maximum(apart, np.where(closed, 0.0, _loose_ends(toolpaths, gap)))
    apart[[k for r in again | under for k, _ in once[r]]] += gap
    wide[list(again)] = False
    apart[[k for r in _looped(polygons, gap) for k, _ in once[r]]] += gap
    once = [ring for ring, is_kept in zip(once, wide.tolist(), strict=True) if is_kept]
    polygons = polygons[wide]
    return Region(polygons, once, closed, twins, apart)


def small_ways(toolpaths: Toolpaths, gap: float) -> Flags:
    """Toolpaths that are no larger than the gap, with all that they are joined to.

    Between two ends as near as that the tool does not move, so nothing cuts them.
    """
    low, high = toolpaths.boxes
    sizes: Floats = np.hypot(*(high - low).T)
    most = gap + SAME_POINT
    if not (sizes <= most).any():
        return np.zeros(toolpaths.count, dtype=bool)
    every = np.arange(toolpaths.count)
    places = shapely.points(np.concatenate((toolpaths.starts, toolpaths.ends)))
    a, b = shapely.STRtree(places).query(places, "dwithin", distance=gap + SAME_POINT)
    group = every.copy()
    while True:
        least = group.copy()
        np.minimum.at(least, a % toolpaths.count, group[b % toolpaths.count])
        if np.array_equal(least, group):
            break
        group = least[least]  # a name of the group may have a lesser one by now
    wide_low, wide_high = low.copy(), high.copy()
    np.minimum.at(wide_low, group, low)
    np.maximum.at(wide_high, group, high)
    small: Flags = np.hypot(*(wide_high - wide_low)[group].T) <= most
    return small


def _looped(polygons: NDArray[np.object_], gap: float) -> list[int]:
    """Rings that cross themselves by a hair and so have a loop there, which nothing can follow."""
    alike = shapely.set_precision(polygons, SAME_POINT, mode="pointwise")
    found = []
    for k in np.flatnonzero(~shapely.is_valid(alike)).tolist():
        boxes = shapely.bounds(shapely.get_parts(shapely.make_valid(polygons[k])))
        sizes = np.hypot(*(boxes[:, 2:] - boxes[:, :2]).T)
        if np.any((sizes > SAME_POINT) & (sizes <= WIDEST_LOOP * gap)):
            found.append(k)
    return found


def _ranks(toolpaths: Toolpaths, own: Flags) -> Counts:
    """Which ways count where they lie on one another: of closed features first, then the longer."""
    rank = np.empty(toolpaths.count, dtype=np.int64)
    rank[np.lexsort((np.arange(toolpaths.count), -toolpaths.lengths, ~own))] = np.arange(
        toolpaths.count
    )
    return rank


def _on(toolpaths: Toolpaths, which: Flags, same: float) -> Flags:
    """Toolpaths that lie on some of them."""
    return _lie_on(toolpaths, np.where(which, 0, 1), same)


def _loose_ends(toolpaths: Toolpaths, gap: float) -> Floats:
    """How far the ends of each way are from other ends that they may be joined to, at most."""
    found = np.zeros(toolpaths.count)
    ends = np.concatenate((toolpaths.starts, toolpaths.ends))
    places = shapely.points(ends)
    a, b = shapely.STRtree(places).query(places, "dwithin", distance=gap + SAME_POINT)
    np.maximum.at(found, a % max(toolpaths.count, 1), np.hypot(*(ends[a] - ends[b]).T))
    return found


def _same_rings(polygons: NDArray[np.object_], gap: float) -> tuple[set[int], set[int]]:
    """Rings that are nowhere farther than a gap from an earlier one, and those earlier ones."""
    # Rings that are equal to the last digit are told apart from the others without measuring.
    texts = shapely.to_wkb(shapely.normalize(polygons)).tolist()
    first: dict[bytes, int] = {}
    copy_of = [first.setdefault(text, k) for k, text in enumerate(texts)]
    copies = {k for k, own in enumerate(copy_of) if own != k}
    kept = np.array(sorted(first.values()), dtype=np.int64)
    boxes = shapely.bounds(polygons[kept]).reshape(-1, 4)
    corners = shapely.points(boxes[:, :2])
    a, b = shapely.STRtree(corners).query(corners, "dwithin", distance=2 * gap)
    near = (a < b) & (np.abs(boxes[a] - boxes[b]).max(axis=1) <= gap + SAME_POINT)
    a, b = kept[a[near]], kept[b[near]]
    rings = shapely.get_exterior_ring(polygons)
    same = shapely.hausdorff_distance(rings[a], rings[b]) <= gap + SAME_POINT
    again = set(b[same].tolist()) | copies
    return again, (set(a[same].tolist()) | {copy_of[k] for k in copies}) - again


def _lie_on(toolpaths: Toolpaths, rank: Counts, same: float) -> Flags:
    """Toolpaths of which each place lies no farther than `same` from a way of lower rank.

    Lines and arcs are known exactly, and have to lie on one another as `WRITTEN_SAME` says. Of
    ways that are equal in each of these places one is asked, which has the lowest rank.
    """
    order = np.argsort(rank, kind="stable")
    exact = toolpaths.kinds < 2
    # Its ends are known; along the way the last place of one is the first of the next.
    ends = toolpaths.starts[order], toolpaths.ends[order]
    places = [
        *(toolpaths.point(order, share * toolpaths.lengths[order]) for share in SHARES),
        *ends,
    ]
    first = first_equal(np.concatenate(places, axis=1))
    left = np.flatnonzero(first == np.arange(len(first)))
    on = np.zeros(len(first), dtype=bool)
    for points in places:
        hit = np.zeros(len(left), dtype=bool)
        for pairs in toolpaths.batches(points[left], same):
            own, other = order[left][pairs.point], toolpaths.owner[pairs.element]
            near = np.where(exact[own] & exact[other], min(same, WRITTEN_SAME * SLACK), same)
            hit[pairs.point[(rank[other] < rank[own]) & (pairs.away <= near)]] = True
        left = left[hit]
    on[left] = True
    found = np.empty(len(first), dtype=bool)
    found[order] = on[first] | (rank[order] > rank[order[first]])
    return found


def _joined(toolpaths: Stretches, rings: Sequence[Chain]) -> Floats:
    """The greater of the gaps at both ends of each way, between it and its neighbours in a ring."""
    found = np.zeros(len(toolpaths.starts))
    for ring in rings:
        numbers = np.array([k for k, _ in ring])
        turned = np.array([back for _, back in ring])[:, None]
        begins = np.where(turned, toolpaths.ends[numbers], toolpaths.starts[numbers])
        ends = np.where(turned, toolpaths.starts[numbers], toolpaths.ends[numbers])
        gaps = np.hypot(*(np.roll(begins, -1, axis=0) - ends).T)
        if gaps.any():
            found[numbers] = np.maximum(gaps, np.roll(gaps, 1))
    return found


def _polygons(toolpaths: Stretches, rings: Sequence[Chain]) -> NDArray[np.object_]:
    """The inside of each ring."""
    if not rings:
        return np.zeros(0, dtype=object)
    rows, sizes = [], []
    for ring in rings:
        own = [toolpaths.rows(k)[:: -1 if turned else 1] for k, turned in ring]
        rows += own
        sizes.append(sum(map(len, own)))
    indices = np.repeat(np.arange(len(rings)), sizes)
    polygons: NDArray[np.object_] = shapely.polygons(
        shapely.linearrings(toolpaths.points[np.concatenate(rows)], indices=indices)
    )
    return polygons


# --- alignment ------------------------------------------------------------------------------------

# Curves that run along one another, not only near one another at the places that were asked.
#
# Places at equal distances on a line may all lie on lines that cross it at equal distances, or on
# the dashes of a broken line. So a place on one of two sets of curves counts as on the other only
# where that runs in the same direction, or back; and the first is asked on both sides of each place
# where the other ends or bends, since nowhere else one can leave the other unseen.


MAX_TURN_RAD = 0.02  #: between lines and arcs that run along one another, of any length
SMOOTH_RAD = 0.26  #: from one way to the next, where they do not bend
NEAR_BEND = 4.0  #: slacks from an end or a bend, within which any direction is right
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
    found: Flags = across <= np.sin(MAX_TURN_RAD)
    asked = np.flatnonzero(~found)
    if len(asked):
        pairs = pairs.kept(asked)
        most = (
            _most_turns(own, slack)[element[pairs.point]] + _most_turns(other, slack)[pairs.element]
        )
        found[asked] = across[asked] <= np.sin(np.minimum(MAX_TURN_RAD + most, np.pi / 2))
        found[asked] |= _near_bend(other, pairs, slack)
    return found


def _most_turns(toolpaths: Toolpaths, slack: float) -> Floats:
    """Angles in rad by which curves within the slack of elements may differ from their directions.

    A chord of length L, at its middle within the slack s of an arc on one side and at its ends on
    the other, is 8 s / L off the direction of that at its ends; an arc of radius r is
    2 sqrt(s / r) off that of such a chord. A chord that the next one leaves at the angle b is one
    of an arc of radius L / b; of short chords, such as those between whole steps, some may go on
    straight, so that the next bend counts.
    """
    elements = toolpaths.elements
    turns = _turns(elements, slack)
    bend = _most_near(turns, elements.length, NEAR_BEND * slack)
    radius = elements.arcs[elements.is_arc, 2]
    with np.errstate(divide="ignore", over="ignore", invalid="ignore"):  # absurdly short or long
        share = slack / elements.length
        found: Floats = np.fmin(8.0 * share, bend / 2 + 2.0 * np.sqrt(bend * share))
        found[elements.is_arc] += 2.0 * np.sqrt(slack / radius)
    return found


def _most_near(turns: Floats, lengths: Floats, reach: float) -> Floats:
    """The greatest turn at an element or no farther from it than `reach`, for each."""
    places = np.append(0.0, np.cumsum(lengths))
    first = np.searchsorted(places, places[:-1] - reach)
    behind = np.searchsorted(places, places[1:] + reach, "right")
    windows = np.column_stack((first, behind)).ravel()
    found: Floats = np.maximum.reduceat(np.append(turns, 0.0), windows)[::2]
    return found


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
    found: Flags = begins[way] & (at <= reach)
    return found | (ends[way] & (at >= toolpaths.lengths[way] - reach))


def _bends(toolpaths: Toolpaths, slack: float) -> tuple[Flags, Flags, Flags]:
    """The ways that begin at a bend, those that end at one, and those that end at the next one."""
    turns, every = _turns(toolpaths.elements, slack), np.arange(toolpaths.count)
    before, behind = turns[toolpaths.first(every)], turns[toolpaths.last(every) + 1]
    return before > SMOOTH_RAD, behind > SMOOTH_RAD, np.isfinite(behind)


def _turns(elements: Elements, slack: float) -> Floats:
    """Angles in rad before each element and behind the last, (n + 1,).

    Infinite where nothing goes on, or only what does not come next.
    """
    every = np.arange(len(elements))
    ahead = elements.directions(every, np.zeros(len(every)))
    behind = elements.directions(every, np.ones(len(every)))
    meets = np.hypot(*(elements.end[:-1] - elements.start[1:]).T) <= slack
    turns = np.arccos(np.clip(np.sum(behind[:-1] * ahead[1:], axis=1), -1.0, 1.0))
    found = np.full(len(every) + 1, np.inf)
    found[1:-1] = np.where(meets, turns, np.inf)
    return found
