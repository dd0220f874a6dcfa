"""Corners of the waste that no round beam reaches.

    part      |
              |  e        The beam stands at c and touches both sides at e. What lies between them
        ______|.·¯¯.      along the contour stays, and is left out of what is asked for.
        part  e   c |

A stretch that has no path is such a corner if no place of the waste has room for the beam and
touches it, if the beam touches both of its ends from one place, and if it grows narrow: a slot
that is too narrow for the beam does not, and both ends of a neck are touched from two places.
"""

from collections.abc import Iterator, Sequence

import numpy as np
from msgspec import Struct

from beamcam.geometry.array_types import Counts, Flags, Floats
from beamcam.geometry.plane import Point
from beamcam.verify.sheets.sides import Samples, is_behind, off
from beamcam.verify.sheets.touching import waste_rings
from beamcam.verify.sheets.work import Traced, Work

HALVINGS = 24  #: of the way between a place that has a path and one that has none
SHALLOW = 2.0  #: by half the kerf; what is less deep need not grow narrow
NARROWS = 0.75  #: width half way down, by that of the mouth


class Corner(Struct, frozen=True):
    """Samples that no beam reaches, between two that one beam touches."""

    samples: Counts
    depth: float  #: of the farthest place from the beam
    place: Point
    way: int  #: that the place is on


def in_corners(
    work: Work, traced: Sequence[Traced], missing: Counts, samples: Samples
) -> tuple[Flags, list[Corner]]:
    """Which of the samples without a path lie in a corner, and these corners."""
    element, share, owner = samples
    found = np.zeros(len(missing), dtype=bool)
    corners: list[Corner] = []
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
        stretches = [s for s in _stretches(work, some[2], gone) if left[_own(rows, s[1:-1])].all()]
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


def _stretches(work: Work, owner: Counts, missing: Flags) -> Iterator[Counts]:
    """Samples of a ring that have no path, one behind the other, between two that have one."""
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
        steps = np.flatnonzero(np.diff(gone.astype(np.int8)))
        for low, high in zip(steps[::2].tolist(), steps[1::2].tolist(), strict=True):
            yield order[low : high + 2]


class _Beam:
    """The beam along its path, asked where it touches contours."""

    def __init__(self, work: Work, traced: Sequence[Traced]) -> None:
        self._work = work
        self._keeps_off = np.array([t.half_kerf > 0.0 for t in traced])

    def with_ends(self, samples: Samples, missing: Flags) -> tuple[Counts, Samples, Flags]:
        """The samples, with both ends of each way that lacks a path somewhere.

        Also which of those given each is, -1 for an end; and which of all are missing.
        """
        element, share, owner = samples
        work = self._work
        lost = np.unique(owner[missing])
        ways = np.concatenate((lost, lost))
        # The end of a way stands before the start of the following one.
        at = np.concatenate((np.searchsorted(owner, lost, "right"), np.searchsorted(owner, lost)))
        ends = np.repeat([1.0, 0.0], len(lost))
        first = np.concatenate((work.need.last(lost), work.need.first(lost)))
        reach = work.half_kerf + work.slack[ways]
        gone = self._nearest(work.need.elements.places(first, ends), ways)[0] > reach
        rows = np.insert(np.arange(len(owner)), at, -1)
        full = np.insert(element, at, first), np.insert(share, at, ends), np.insert(owner, at, ways)
        return rows, full, np.insert(missing, at, gone)

    def corners(self, stretches: Sequence[Counts], samples: Samples) -> Iterator[Corner]:
        """Those of some stretches that are corners.

        Each stretch has the samples that have a path before and behind it.
        """
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
            most = np.array([reach[stretch[end]] for stretch in stretches])
            both = ~same & (np.hypot(*(other - own).T) <= most)
            middles[both] = own[both]
            same |= both
        for k in np.flatnonzero(same).tolist():
            inner = stretches[k][1:-1]
            points = work.need.elements.places(element[inner], share[inner])
            if self._narrows(points, firsts[k], lasts[k], middles[k]):
                yield self._corner(inner, points, owner, middles[k])

    def _corner(self, inner: Counts, points: Floats, owner: Counts, middle: Floats) -> Corner:
        """The corner that some samples lie in, as deep as the farthest of them and of the ends
        between them."""
        ways, ends = owner[inner], points[:0]
        if len(turns := np.flatnonzero(np.diff(ways))):
            starts, ends = self._work.need.starts[ways[turns]], self._work.need.ends[ways[turns]]
            to_start = np.hypot(*(starts - points[turns + 1]).T)
            to_end = np.hypot(*(ends - points[turns + 1]).T)
            ends = np.where((to_start < to_end)[:, None], starts, ends)
        places = np.concatenate((points, ends))
        away = np.hypot(*(places - middle).T)
        deepest = int(np.argmax(away))
        x, y = places[deepest].tolist()
        way = int(np.concatenate((ways, ways[turns]))[deepest])
        return Corner(inner, float(away[deepest]) - self._work.half_kerf, (x, y), way)

    def _touched(
        self, stretches: Sequence[Counts], samples: Samples, have: int, lack: int
    ) -> tuple[Floats, Floats]:
        """The end of each stretch, and where the middle of the beam is that touches it.

        It is looked for along the contour between a sample that has a path and one that has none:
        they are half a beam apart or less, with one end of a curve between them at most.
        """
        element, share, owner = samples
        work = self._work
        near = np.array([stretch[have] for stretch in stretches])
        far = np.array([stretch[lack] for stretch in stretches])
        places = work.need.elements.places
        a, b = places(element[near], share[near]), places(element[far], share[far])
        way = owner[far]
        starts, ends = work.need.starts[way], work.need.ends[way]
        to_start = np.hypot(*(starts - a).T) + np.hypot(*(starts - b).T)
        to_end = np.hypot(*(ends - a).T) + np.hypot(*(ends - b).T)
        between = np.where((to_start <= to_end)[:, None], starts, ends)
        between = np.where((owner[near] == way)[:, None], (a + b) / 2, between)
        reach = work.half_kerf + work.slack[way]
        for _ in range(HALVINGS):
            on = (self._nearest(between, way)[0] <= reach)[:, None]
            a, b = np.where(on, between, a), np.where(on, b, between)
            between = (a + b) / 2
        return a, self._nearest(a, way)[1]

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
