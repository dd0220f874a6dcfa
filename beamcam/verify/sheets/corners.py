"""Corners of the waste that no round beam reaches.

    part      |
              |  e        The beam stands at c and touches both sides at e. What lies between them
        ______|.·¯¯.      along the contour stays, and is left out of what is asked for.
        part  e   c |

A stretch that has no path is such a corner if no place of the waste has room for the beam and
touches it, if the beam touches both of its ends from one place, and if it grows narrow: a slot
that is too narrow for the beam does not, and both ends of a neck are touched from two places.

A needle of the part that is thinner than what paths may be off is touched through from behind.
There a corner ends where the beam touches the needle from the corner's own side, which is farther
along the contour, at the needle's tip or short of it.
"""

from collections.abc import Iterator, Sequence

import numpy as np
import shapely
from msgspec import Struct

from beamcam.geometry.array_types import Counts, Flags, Floats
from beamcam.geometry.plane import Point
from beamcam.verify.sheets.sides import is_behind, off, waste_rings, waste_sides
from beamcam.verify.sheets.toolpaths import Samples, Toolpaths
from beamcam.verify.sheets.work import Traced, Work

HALVINGS = 24  #: of the way between a place that has a path and one that has none
SHALLOW = 2.0  #: by half the kerf; what is less deep need not grow narrow
NARROWS = 0.75  #: width half way down, by that of the mouth
BEYOND = 64  #: samples behind the end of a stretch among which the beam may touch a needle


class Stretch(Struct, frozen=True):
    """Samples of a ring that have no path, one after the other."""

    samples: Counts  #: they, with the one before and the one behind them, which have a path
    before: Counts  #: those before them, from the first of them that has none on
    behind: Counts  #: and behind them, from the last


class UncutCorner(Struct, frozen=True):
    """Samples that no beam reaches, between two that one beam touches."""

    samples: Counts
    depth: float  #: of the farthest place from the beam
    place: Point
    way: int  #: that the place is on


def in_corners(
    work: Work, traced: Sequence[Traced], missing: Counts, samples: Samples
) -> tuple[Flags, list[UncutCorner]]:
    """Which of the samples without a path lie in a corner, and these corners."""
    element, share, owner = samples
    found = np.zeros(len(missing), dtype=bool)
    corners: list[UncutCorner] = []
    if work.region is None or not len(missing):
        return found, corners
    which = np.flatnonzero(work.beside[owner[missing]])
    which = which[_no_room(work, element[missing[which]], share[missing[which]])]
    beam = _Beam(work, traced)
    left = np.zeros(len(owner), dtype=bool)
    left[missing[which]] = True
    is_missing = np.zeros(len(owner), dtype=bool)
    is_missing[missing] = True
    good = np.zeros(len(owner), dtype=bool)
    # The tip of a needle may be all of it that the beam touches: it parts two corners. Where the
    # beam touches a tip from behind, both sides are one.
    whole = np.arange(len(owner)), samples, is_missing
    for rows, some, gone in (whole, beam.with_ends(samples, is_missing)):
        stretches = [
            s for s in _stretches(work, some[2], gone) if left[_own(rows, s.samples[1:-1])].all()
        ]
        for corner in beam.corners(stretches, some):
            good[_own(rows, corner.samples)] = True
            corners.append(corner)
    # A curve that lies on another is where that one is.
    found[:] = good[missing] | (left[missing] & work.region.twins[owner[missing]])
    return found, corners


def _own(rows: Counts, some: Counts) -> Counts:
    """Some samples by the numbers that they had before ends were put between them."""
    found: Counts = rows[some]
    return found[found >= 0]


def _no_room(work: Work, element: Counts, share: Floats) -> Flags:
    """Places of contours beside which no beam has room in the waste."""
    assert work.region is not None
    elements, half = work.need.elements, work.half_kerf
    points = elements.places(element, share)
    ahead = elements.directions(element, share)
    normal = np.column_stack((-ahead[:, 1], ahead[:, 0]))
    closed = work.beside
    found = np.ones(len(points), dtype=bool)
    for sign in (1.0, -1.0):
        middle = points + sign * half * normal
        pairs = work.need.near(middle, half)
        pairs = pairs.kept(closed[work.need.owner[pairs.element]])
        away, _, _ = work.need.nearest_of(pairs, len(middle))
        room = away >= half - 2 * work.fine
        # Behind a thin wall there may be waste as well, from which the beam cuts its other side.
        aside = off(work, work.need.owner[element])[:, None]
        is_waste = ~work.region.in_part(points + sign * aside * normal)
        found &= ~(room & is_waste & ~work.region.in_part(middle))
    return found


def _stretches(work: Work, owner: Counts, missing: Flags) -> Iterator[Stretch]:
    """The stretches of all rings that have no path, as samples of the ways `owner`."""
    firsts = np.searchsorted(owner, np.arange(work.need.count + 1))
    lost = np.add.reduceat(missing, firsts[:-1]) > 0
    for ring in waste_rings(work):
        if not lost[[k for k, _ in ring]].any():
            continue
        rows = [np.arange(firsts[k], firsts[k + 1])[:: -1 if turned else 1] for k, turned in ring]
        order = np.concatenate(rows)
        gone = missing[order]
        if gone.all():
            continue
        begin = int(np.argmin(gone))  # one that has a path
        order, gone = np.roll(order, -begin), np.roll(gone, -begin)
        order, gone = np.append(order, order[0]), np.append(gone, False)
        steps = np.flatnonzero(np.diff(gone.astype(np.int8))).tolist()
        lows, highs = steps[::2], [high + 1 for high in steps[1::2]]
        lap = len(order) - 1
        most = np.arange(min(lap, BEYOND))
        for low, high in zip(lows, highs, strict=True):
            yield Stretch(
                order[low : high + 1],
                order[(low + 1 - most) % lap],
                order[(high - 1 + most) % lap],
            )


class _Beam:
    """The beam along its path, asked where it touches contours."""

    def __init__(self, work: Work, traced: Sequence[Traced]) -> None:
        self._work = work
        self._keeps_off = np.array([t.half_kerf > 0.0 for t in traced])
        self._sides = waste_sides(work)

    def with_ends(self, samples: Samples, missing: Flags) -> tuple[Counts, Samples, Flags]:
        """The samples, with both ends of each way that lacks a path somewhere.

        Also which of those given each is, -1 for an end; and which of all are missing.
        """
        element, share, owner = samples
        work = self._work
        lost = np.unique(owner[missing])
        toolpaths = np.concatenate((lost, lost))
        # The end of a way stands before the start of the following one.
        at = np.concatenate((np.searchsorted(owner, lost, "right"), np.searchsorted(owner, lost)))
        ends = np.repeat([1.0, 0.0], len(lost))
        first = np.concatenate((work.need.last(lost), work.need.first(lost)))
        reach = work.half_kerf + work.slack[toolpaths]
        gone = self._nearest(work.need.elements.places(first, ends), toolpaths)[0] > reach
        rows = np.insert(np.arange(len(owner)), at, -1)
        full = (
            np.insert(element, at, first),
            np.insert(share, at, ends),
            np.insert(owner, at, toolpaths),
        )
        return rows, full, np.insert(missing, at, gone)

    def corners(self, stretches: Sequence[Stretch], samples: Samples) -> Iterator[UncutCorner]:
        """Those of some stretches that are corners."""
        if not stretches:
            return
        work = self._work
        firsts, first_middles = self._touched(stretches, samples, 0, 1)
        lasts, last_middles = self._touched(stretches, samples, -1, -2)
        element, share, owner = samples
        # A touch is found where the tip is thicker than the part's outline is fine. No more waste
        # is let pass by the tolerance that this takes: beside none of the samples is there room.
        reach = work.half_kerf + work.slack[owner] + work.tolerance
        apart = np.hypot(*(last_middles - first_middles).T)
        same = apart <= work.half_kerf / 4 + 4 * work.tolerance
        middles = (first_middles + last_middles) / 2
        # Round a tip the beam touches it from many places, one of which touches the other end too.
        for own, other, end in ((first_middles, lasts, -1), (last_middles, firsts, 0)):
            most = np.array([reach[stretch.samples[end]] for stretch in stretches])
            both = ~same & (np.hypot(*(other - own).T) <= most)
            for k in np.flatnonzero(~same & ~both).tolist():
                beyond = stretches[k].behind if end else stretches[k].before
                both[k] = self._comes_near(own[k], other[k], beyond, samples) <= most[k]
            middles[both] = own[both]
            same |= both
        for k in np.flatnonzero(same).tolist():
            inner = stretches[k].samples[1:-1]
            points = work.need.elements.places(element[inner], share[inner])
            if self._narrows(points, firsts[k], lasts[k], middles[k]):
                yield self._corner(inner, points, owner, middles[k])

    def _comes_near(self, middle: Floats, end: Floats, beyond: Counts, samples: Samples) -> float:
        """How near a contour comes to the middle of the beam behind the end of a stretch.

        It is followed to the first place that the beam touches from the waste's side.
        """
        element, share, owner = samples[0][beyond], samples[1][beyond], samples[2][beyond]
        elements = self._work.need.elements
        points = elements.places(element, share)
        ahead = elements.directions(element, share)
        to_waste = self._sides[owner][:, None] * np.column_stack((-ahead[:, 1], ahead[:, 0]))
        away, feet = self._nearest(points, owner)
        reach = self._work.half_kerf + self._work.slack[owner]
        touched = (away <= reach) & (np.sum((feet - points) * to_waste, axis=1) > 0.0)
        last = int(np.argmax(touched)) if touched.any() else len(points) - 1
        way = [end]
        for k in range(1, last + 1):
            way += [*self._between(element, owner, points, k), points[k]]
        return float(shapely.distance(shapely.linestrings(way), shapely.points(middle)))

    def _between(self, element: Counts, owner: Counts, points: Floats, k: int) -> Floats:
        """Places of the contour between a sample and the one before it: ends of elements."""
        if owner[k] != owner[k - 1]:
            return self._turns(points[k - 1 : k + 1], owner[k - 1 : k + 1])[1]
        a, b = int(element[k - 1]), int(element[k])
        ends: Floats = self._work.need.elements.end
        return ends[a:b] if a < b else ends[b:a][::-1]

    def _turns(self, points: Floats, toolpaths: Counts) -> tuple[Counts, Floats]:
        """Behind which of some samples, one after the other, a way ends, and where."""
        turns = np.flatnonzero(np.diff(toolpaths))
        starts, ends = (
            self._work.need.starts[toolpaths[turns]],
            self._work.need.ends[toolpaths[turns]],
        )
        to_start = np.hypot(*(starts - points[turns + 1]).T)
        to_end = np.hypot(*(ends - points[turns + 1]).T)
        return turns, np.where((to_start < to_end)[:, None], starts, ends)

    def _corner(self, inner: Counts, points: Floats, owner: Counts, middle: Floats) -> UncutCorner:
        """The corner that some samples lie in, as deep as the farthest of them and of the ends
        between them."""
        toolpaths = owner[inner]
        turns, ends = self._turns(points, toolpaths)
        places = np.concatenate((points, ends))
        away = np.hypot(*(places - middle).T)
        deepest = int(np.argmax(away))
        x, y = places[deepest].tolist()
        way = int(np.concatenate((toolpaths, toolpaths[turns]))[deepest])
        return UncutCorner(inner, float(away[deepest]) - self._work.half_kerf, (x, y), way)

    def _touched(
        self, stretches: Sequence[Stretch], samples: Samples, have: int, lack: int
    ) -> tuple[Floats, Floats]:
        """The end of each stretch, and where the middle of the beam is that touches it.

        It is looked for along the contour between a sample that has a path and one that has none:
        they are half a beam apart or less, with one end of a curve between them at most.
        """
        element, share, owner = samples
        need = self._work.need
        near = np.array([stretch.samples[have] for stretch in stretches])
        far = np.array([stretch.samples[lack] for stretch in stretches])
        at = need.at(element, share * need.elements.length[element]) - need.begins[owner]
        way, a, b = owner[far], at[near], at[far]
        parted = owner[near] != way
        # The end of the one way that the other one begins or ends at.
        own_end, place = self._end_towards(way, need.point(owner[near], a))
        touched = self._nearest(place, way)[0] <= self._work.half_kerf + self._work.slack[way]
        other_end, _ = self._end_towards(owner[near], place)
        a = np.where(parted & touched, own_end, a)
        b = np.where(parted & ~touched, other_end, b)
        way = np.where(parted & ~touched, owner[near], way)
        size = need.lengths[way]
        over = np.all(need.starts[way] == need.ends[way], axis=1) & (np.abs(b - a) > size / 2)
        b = np.where(over, b + np.copysign(size, a - b), b)
        reach = self._work.half_kerf + self._work.slack[way]
        for _ in range(HALVINGS):
            middle = (a + b) / 2
            on = self._nearest(_point(need, way, middle), way)[0] <= reach
            a, b = np.where(on, middle, a), np.where(on, b, middle)
        places = _point(need, way, a)
        return places, self._nearest(places, way)[1]

    def _end_towards(self, way: Counts, places: Floats) -> tuple[Floats, Floats]:
        """The end of each way that is nearer to a place: how far along it is, and where."""
        need = self._work.need
        starts, ends = need.starts[way], need.ends[way]
        to_start, to_end = (np.hypot(*(some - places).T) for some in (starts, ends))
        first = to_start <= to_end
        return np.where(first, 0.0, need.lengths[way]), np.where(first[:, None], starts, ends)

    def _narrows(self, points: Floats, first: Floats, last: Floats, middle: Floats) -> bool:
        """Whether a stretch is shallow, or narrower half way down than at its mouth."""
        depth = np.hypot(*(points - middle).T) - self._work.half_kerf
        deepest = int(np.argmax(depth))
        if depth[deepest] <= SHALLOW * self._work.half_kerf:
            return True
        half = depth[deepest] / 2
        one = points[int(np.argmin(np.abs(depth[: deepest + 1] - half)))]
        other = points[deepest + int(np.argmin(np.abs(depth[deepest:] - half)))]
        mouth = float(np.hypot(*(last - first)))
        return bool(np.hypot(*(other - one)) <= NARROWS * mouth)

    def _nearest(self, points: Floats, way: Counts) -> tuple[Floats, Floats]:
        """How far the path is from each point of some ways, and its place that is nearest."""
        work = self._work
        pairs = work.path.near(points, 2 * work.half_kerf + 2 * float(work.slack.max()))
        pairs = pairs.kept(self._keeps_off[work.of_way[work.path.owner[pairs.element]]])
        away, feet = work.path.feet(pairs, len(points))
        behind = is_behind(work, points, way, away, feet - points)
        return np.where(behind, np.inf, away), feet


def _point(toolpaths: Toolpaths, way: Counts, at: Floats) -> Floats:
    """Places so far along ways, round those that close."""
    size = toolpaths.lengths[way]
    return toolpaths.point(way, np.where((at < 0.0) | (at > size), np.mod(at, size), at))
