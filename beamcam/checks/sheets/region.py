"""Part and waste regions of a sheet.

The part is the set of points that an odd number of closed cut contours enclose, curves that are
drawn twice counted once. A contour that an even number of others enclose is an outline, its waste
outside; one that an odd number enclose is a hole, its waste inside.

A feature whose curves follow one another and end where they begin is closed; which others are says
`joining`. All other curves are open and have no inside: no side and no order is asked of them, they
bound no part, and the beam stays centred on them.
"""

from collections.abc import Iterable, Sequence
from itertools import chain
from math import atan2, cos, degrees, hypot, radians, sin

import numpy as np
import shapely
from msgspec import Struct
from msgspec.structs import replace
from numpy.typing import NDArray

from beamcam.checks.sheets.joining import SLACK, WRITTEN_SAME, rings_of, trim
from beamcam.checks.sheets.toolpaths import Chain, DrawnWays, Toolpaths
from beamcam.geometry.array_types import Counts, Flags, Floats
from beamcam.geometry.arrays import first_equal
from beamcam.geometry.curves import Curve
from beamcam.geometry.plane import Box, Point, groups_of, join_boxes
from beamcam.model.part import Contour, Feature, Hole, Slot, extent

SAME_PLACE = 5e-3  #: curves as near as this are drawn twice
SAME_POINT = 1e-6  #: of a gap, what its last digits may be
FOLLOWS = 1e-9  #: mm between curves of one feature that follow one another
PASSED_AGAIN = 1e-6  #: a place of a contour, to its last digits
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
    anticlockwise: Flags  #: rings that run so
    ring_of: Counts  #: that each way is of; -1 of none

    @classmethod
    def none(cls, count: int) -> "Region":
        """Of so many ways that enclose nothing."""
        no, apart = np.zeros(count, dtype=bool), np.zeros(count)
        ring_of = np.full(count, -1)
        return cls(np.zeros(0, dtype=object), [], no, no, apart, np.zeros(0, dtype=bool), ring_of)

    def moved(self, shift: Point) -> "Region":
        """The same elsewhere."""
        return replace(self, polygons=shapely.transform(self.polygons, lambda at: at + shift))

    def in_part(self, points: Floats) -> Flags:
        """Which points (n, 2) lie in the part."""
        which, _ = shapely.STRtree(self.polygons).query(shapely.points(points), "within")
        return np.asarray(np.bincount(which, minlength=len(points)) % 2 == 1)


def region_of(toolpaths: Toolpaths, features: Counts, gap: float, fine: float) -> Region:
    """The region of ways whose features are known by their numbers.

    Ends at most `gap` apart meet, and rings no farther from one another are the same. Outlines are
    chords at most `fine` off.
    """
    real = np.flatnonzero(toolpaths.lengths > 0.0)
    own = closed_features(toolpaths, features, real)
    # Where ways lie on one another, those of closed features count first, then the longer ones.
    rank = np.empty(toolpaths.count, dtype=np.int64)
    every = np.arange(toolpaths.count)
    rank[np.lexsort((every, -toolpaths.lengths, ~own))] = every
    twins = _lie_on(toolpaths, rank, SAME_PLACE)
    drawn = toolpaths.whole(fine)
    drawn_so = closed_rings(drawn, [k for k in real.tolist() if own[k]], features)
    loose = [k for k in real.tolist() if not own[k] and not twins[k]]
    once = [ring for ring in drawn_so if not all(twins[k] for k, _ in ring)]
    if loose:
        trim(drawn, toolpaths, loose, np.where(twins, toolpaths.count, rank), WRITTEN_SAME)
        once += rings_of(drawn, loose, gap)
    sizes = np.diff(drawn.begins).tolist()
    once = [ring for ring in once if sum(sizes[k] for k, _ in ring) > 3]
    rings = Rings.of(once)
    polygons = rings.polygons(drawn) if once else np.zeros(0, dtype=object)
    # A line there and back again has no inside.
    wide = shapely.area(polygons) > MIN_WIDTH * shapely.length(polygons)
    again, under = _same_rings(polygons, gap)
    closed, apart = np.zeros(toolpaths.count, dtype=bool), rings.gaps(drawn) + SAME_PLACE * twins
    closed[rings.ways[wide[rings.ring]]] = True
    if twins.any():
        closed |= twins & _lie_on(toolpaths, np.where(closed, 0, 1), SAME_PLACE)
    twins[rings.ways_of(again)] = True
    if len(opened := np.flatnonzero(~closed)):
        # Their ends may be joined to others.
        ends = np.concatenate((toolpaths.starts, toolpaths.ends)) + 0.0
        own = np.concatenate((opened, opened + toolpaths.count))
        tree, points = shapely.STRtree(shapely.points(ends)), shapely.points(ends[own])
        a, b = tree.query(points, "dwithin", distance=gap + SAME_POINT)
        np.maximum.at(apart, own[a] % toolpaths.count, np.hypot(*(ends[own[a]] - ends[b]).T))
    apart[rings.ways_of(again | under)] += gap
    wide[list(again)] = False
    # Nothing can follow the loop of a ring that crosses itself by a hair.
    alike = shapely.set_precision(polygons, SAME_POINT, mode="pointwise")
    for k in np.flatnonzero(~shapely.is_valid(alike)).tolist():
        boxes = shapely.bounds(shapely.get_parts(shapely.make_valid(polygons[k])))
        sizes = np.hypot(*(boxes[:, 2:] - boxes[:, :2]).T)
        if np.any((sizes > SAME_POINT) & (sizes <= WIDEST_LOOP * gap)):
            apart[rings.ways_of([k])] += gap
    once = [ring for ring, is_kept in zip(once, wide.tolist(), strict=True) if is_kept]
    polygons = polygons[wide]
    points, ring = shapely.get_coordinates(polygons, return_index=True)
    turned = signed_areas(points, np.searchsorted(ring, np.arange(len(once) + 1)))[0] > 0.0
    ring_of, rings = np.full(toolpaths.count, -1), Rings.of(once)
    ring_of[rings.ways] = rings.ring
    return Region(polygons, once, closed, twins, apart, turned, ring_of)


def closed_features(toolpaths: Toolpaths, features: Counts, real: Counts) -> Flags:
    """The ways of features whose curves follow one another and end where they begin."""
    found = np.zeros(toolpaths.count, dtype=bool)
    if not len(real):
        return found
    own = features[real]
    begins = np.flatnonzero(np.append(True, own[1:] != own[:-1]))
    after = np.arange(1, len(real) + 1)
    after[np.append(begins[1:], len(real)) - 1] = begins
    apart = np.abs(toolpaths.ends[real] - toolpaths.starts[real[after]]).max(axis=1)
    closed = np.logical_and.reduceat(apart <= FOLLOWS, begins)
    found[real] = np.repeat(closed, np.diff(begins, append=len(real)))
    return found


def closed_rings(toolpaths: DrawnWays, which: Sequence[int], features: Counts) -> list[Chain]:
    """The contours of closed features, taken apart where one passes a place again."""
    if not which:
        return []
    numbers = np.array(which, dtype=np.int64)
    own = features[numbers]
    begins = np.flatnonzero(np.append(True, own[1:] != own[:-1]))
    keys = np.column_stack((own, np.rint(toolpaths.starts[numbers] / PASSED_AGAIN)))
    _, place = np.unique(keys, axis=0, return_inverse=True)
    again = np.bincount(place.ravel())[place.ravel()] > 1
    twice = np.logical_or.reduceat(again, begins).tolist()
    rings: list[Chain] = []
    for k, end in enumerate(np.append(begins[1:], len(which)).tolist()):
        rows = range(int(begins[k]), end)
        ring = [(which[row], False) for row in rows]
        rings += _apart(ring, place.ravel()[rows.start : end].tolist()) if twice[k] else [ring]
    return rings


def _apart(ring: Chain, places: Sequence[int]) -> list[Chain]:
    """The rings that one is made of which passes some of its places again."""
    rings: list[Chain] = []
    chain: Chain = []
    passed: list[int] = []
    for way, place in zip(ring, places, strict=True):
        if place in passed:
            at = passed.index(place)
            rings.append(chain[at:])
            del chain[at:], passed[at:]
        passed.append(place)
        chain.append(way)
    return [*rings, chain]


def signed_areas(points: Floats, begins: Counts) -> tuple[Floats, Floats]:
    """What rings of points (n, 2) enclose, above 0 counter-clockwise, and how long they are.

    `begins` tells where the points of each begin, and where the last end.
    """
    if len(begins) < 2:
        return np.zeros(0), np.zeros(0)
    after = np.arange(1, len(points) + 1)
    after[begins[1:] - 1] = begins[:-1]
    x, y = (points - np.repeat(points[begins[:-1]], np.diff(begins), axis=0)).T
    areas = np.add.reduceat(x * y[after] - x[after] * y, begins[:-1]) / 2
    return areas, np.add.reduceat(np.hypot(x[after] - x, y[after] - y), begins[:-1])


def small_ways(toolpaths: Toolpaths, gap: float) -> Flags:
    """Toolpaths that are no larger than the gap, with all that they are joined to.

    Between two ends as near as that the tool does not move, so nothing cuts them.
    """
    (low, high), most, count = toolpaths.boxes, gap + SAME_POINT, toolpaths.count
    is_small = np.zeros(count, dtype=bool)
    small = np.flatnonzero(np.hypot(*(high - low).T) <= most)
    if len(small):
        places = shapely.points(np.concatenate((toolpaths.starts, toolpaths.ends)))
        own = np.concatenate((small, small + count))
        a, b = shapely.STRtree(places).query(places[own], "dwithin", distance=most)
        for group in groups_of((np.column_stack((own[a], b)) % count).tolist()):
            size = np.hypot(*(high[group].max(axis=0) - low[group].min(axis=0)))
            is_small[group] = size <= most
    return is_small


def _same_rings(polygons: NDArray[np.object_], gap: float) -> tuple[set[int], set[int]]:
    """Rings that are nowhere farther than a gap from an earlier one, and those earlier ones."""
    boxes = shapely.bounds(polygons).reshape(-1, 4)
    # Rings that are equal to the last digit are told apart from the others without measuring.
    _, box, count = np.unique(boxes, axis=0, return_inverse=True, return_counts=True)
    alike = np.flatnonzero(count[box.ravel()] > 1)
    texts = shapely.to_wkb(shapely.normalize(polygons[alike])).tolist()
    first: dict[bytes, int] = {}
    copy_of = {k: first.setdefault(text, k) for k, text in zip(alike.tolist(), texts, strict=True)}
    copies = {k for k, own in copy_of.items() if own != k}
    kept = np.delete(np.arange(len(polygons)), list(copies))
    boxes = boxes[kept]
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

    def place(of: Counts, k: int) -> Floats:
        # Its ends are known; along the way the last place of one is the first of the next.
        if k < len(SHARES):
            return toolpaths.point(of, SHARES[k] * toolpaths.lengths[of])
        ends: Floats = (toolpaths.starts, toolpaths.ends)[k - len(SHARES)][of]
        return ends

    every = range(len(SHARES) + 2)
    first = first_equal(np.hstack([place(order, k) for k in (0, *every[-2:])]))
    alike = np.flatnonzero(np.bincount(first, minlength=len(first))[first] > 1)
    first[alike] = alike[first_equal(np.hstack([place(order[alike], k) for k in every]))]
    left = np.flatnonzero(first == np.arange(len(first)))
    on = np.zeros(len(first), dtype=bool)
    for k in every:
        points = place(order[left], k)
        hit = np.zeros(len(left), dtype=bool)
        for pairs in toolpaths.batches(points, same):
            own, other = order[left][pairs.point], toolpaths.owner[pairs.element]
            near = np.where(exact[own] & exact[other], min(same, WRITTEN_SAME * SLACK), same)
            hit[pairs.point[(rank[other] < rank[own]) & (pairs.away <= near)]] = True
        left = left[hit]
    on[left] = True
    found = np.empty(len(first), dtype=bool)
    found[order] = on[first] | (rank[order] > rank[order[first]])
    return found


class Rings(Struct, frozen=True):
    """Rings as arrays, one behind the other."""

    ways: Counts
    turned: Flags  #: of each way
    ring: Counts  #: that each way is of
    begins: Counts  #: of each ring, and where the last ends

    @classmethod
    def of(cls, rings: Sequence[Chain]) -> "Rings":
        begins = np.cumsum([0, *map(len, rings)])
        flat = chain.from_iterable(chain.from_iterable(rings))
        columns = np.fromiter(flat, dtype=np.int64, count=2 * begins[-1]).reshape(-1, 2)
        ring = np.repeat(np.arange(len(rings)), np.diff(begins))
        return cls(columns[:, 0], columns[:, 1] == 1, ring, begins)

    def ways_of(self, rings: Iterable[int]) -> Counts:
        """The ways of some rings."""
        found: Counts = self.ways[np.isin(self.ring, list(rings))]
        return found

    def polygons(self, drawn: DrawnWays) -> NDArray[np.object_]:
        """The inside of each ring."""
        begins, sizes = drawn.begins[self.ways], np.diff(drawn.begins)[self.ways]
        step = np.where(self.turned, -1, 1)
        first = begins + np.where(self.turned, sizes - 1, 0)
        number = np.arange(sizes.sum()) - np.repeat(np.cumsum(sizes) - sizes, sizes)
        rows = np.repeat(first, sizes) + np.repeat(step, sizes) * number
        outlines = shapely.linearrings(drawn.points[rows], indices=np.repeat(self.ring, sizes))
        polygons: NDArray[np.object_] = shapely.polygons(outlines)
        return polygons

    def gaps(self, drawn: DrawnWays) -> Floats:
        """The greater of the gaps at both ends of each way, to its neighbours in the ring."""
        after = np.arange(1, len(self.ways) + 1)
        after[self.begins[1:] - 1] = self.begins[:-1]
        back = self.turned[:, None]
        starts, ends = drawn.starts[self.ways], drawn.ends[self.ways]
        apart = np.hypot(*(np.where(back, ends, starts)[after] - np.where(back, starts, ends)).T)
        found = np.zeros(len(drawn.starts))
        found[self.ways] = apart
        found[self.ways[after]] = np.maximum(apart, found[self.ways[after]])
        return found


def box_of(features: Sequence[Feature]) -> Box | None:
    """The box around the contours, holes and slots of a part; None if there are none."""
    boxes: list[Box] = []
    curves: list[Curve] = []
    for feature in features:
        if isinstance(feature, Contour):
            curves += feature.curves
        elif isinstance(feature, Hole | Slot):
            # A slot reaches as far as the diagonals between the centres of its corners, and the
            # radius.
            r, x, y, dx, dy = feature.diameter / 2, feature.x, feature.y, 0.0, 0.0
            if isinstance(feature, Slot):
                half = hypot(feature.length, feature.height) / 2
                own = degrees(atan2(feature.height, feature.length))
                turns = [radians(feature.angle + by) for by in (own, -own)]
                dx, dy = (half * max(abs(f(turn)) for turn in turns) for f in (cos, sin))
            boxes.append((x - dx - r, y - dy - r, x + dx + r, y + dy + r))
    drawn = extent(curves)
    return join_boxes(boxes if drawn is None else [drawn, *boxes])
