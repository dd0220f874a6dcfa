"""Toolpaths, made or required, as elements, and questions about many points at once.

A way is one of the curves that they were given as.
"""

from collections.abc import Callable, Iterator, Mapping, Sequence
from functools import cached_property

import numpy as np
import shapely
from msgspec import Struct
from msgspec.structs import replace
from numpy.typing import NDArray

from beamcam.checks.sheets.grid import LARGER, LEAST_REACH, Elements, Grid, Pairs
from beamcam.controllers.moves import Moves
from beamcam.geometry.array_types import Counts, Flags, Floats
from beamcam.geometry.arrays import arc_ends, table_of
from beamcam.geometry.curves import Arc, Curve, Line
from beamcam.geometry.polylines import polylines

#: Element, share of it and way of each of some places.
Samples = tuple[Counts, Floats, Counts]

WIDER = 4.0  #: how much farther is looked where nothing was near
NEAR_BEND = 4.0  #: slacks from an end or a bend, within which any direction is right
MOST_TURN_RAD = 0.8  #: between points of an outline


#: Ways one after the other, and whether each is turned round.
Chain = list[tuple[int, bool]]


class DrawnWays(Struct):
    """What of each way counts: its ends, and points along it."""

    starts: Floats  #: (n, 2)
    ends: Floats
    points: Floats  #: of all ways, chords between them
    begins: Counts  #: where the points of each way begin, (n + 1,)

    def line(self, way: int) -> shapely.LineString:
        """A way as a line."""
        return shapely.LineString(self.points[self.begins[way] : self.begins[way + 1]])


class Toolpaths:
    """Curves one after the other; lines and arcs are exact, chords of others off by `tolerance`."""

    def __init__(self, curves: Sequence[Curve], tolerance: float) -> None:
        table = table_of(tuple(curves))
        rest = {k: curves[k] for k in table.free()}
        lines, arcs = table.where(Line), table.where(Arc)
        self._build(len(curves), lines, table.lines, arcs, table.arcs, rest, tolerance)

    @classmethod
    def of_moves(cls, moves: Moves, tolerance: float) -> "Toolpaths":
        """The ways of moves."""
        toolpaths = cls.__new__(cls)
        rest = dict(sorted(moves.curves.items()))
        is_line = ~moves.is_arc
        is_line[list(rest)] = False
        lines, arcs = np.flatnonzero(is_line), np.flatnonzero(moves.is_arc)
        toolpaths._build(
            len(moves), lines, np.column_stack((moves.start[lines], moves.end[lines])),
            arcs, moves.arcs[arcs], rest, tolerance,
        )  # fmt: skip
        return toolpaths

    def moved(self, shift: tuple[float, float]) -> "Toolpaths":
        """The same elsewhere."""
        toolpaths = Toolpaths.__new__(Toolpaths)
        toolpaths.count, toolpaths.first, toolpaths.last = self.count, self.first, self.last
        toolpaths.owner, toolpaths.rest = self.owner, self.rest
        toolpaths._put(self.elements.moved(shift))
        toolpaths._grids = [grid.moved(toolpaths.elements, shift) for grid in self._grids]
        return toolpaths

    def _build(
        self, count: int, lines: Counts, line_rows: Floats, arcs: Counts, arc_rows: Floats,
        rest: Mapping[int, Curve], tolerance: float,
    ) -> None:  # fmt: skip
        """From the numbers and rows of the lines and the arcs among `count`, and the other curves.

        These by their numbers, ascending. Rows of lines are start and end, those of arcs centre,
        radius, start and sweep in degrees.
        """
        self.count = count
        self.rest: Counts = np.array(list(rest), dtype=np.int64)  #: neither lines nor arcs
        drawn = polylines(list(rest.values()), tolerance)
        counts = np.ones(count, dtype=np.int64)
        counts[self.rest] = np.diff(drawn.begins) - 1
        self.last: Counts = np.cumsum(counts) - 1  #: the last element of each way
        self.first: Counts = self.last + 1 - counts
        self.owner: Counts = np.repeat(np.arange(count), counts)
        ends = np.empty((len(self.owner), 4))
        is_arc, rows = np.zeros(len(ends), dtype=bool), np.zeros((len(ends), 5))
        ends[self.first[lines]] = line_rows
        at = self.first[arcs]
        ends[at], is_arc[at] = arc_ends(arc_rows), True
        rows[at] = np.column_stack((arc_rows[:, :3], np.radians(arc_rows[:, 3:])))
        is_rest = np.zeros(count, dtype=bool)
        is_rest[self.rest] = True
        starts = np.delete(np.arange(len(drawn.points)), drawn.begins[1:] - 1)
        chords = np.hstack((drawn.points[starts], drawn.points[starts + 1]))
        ends[is_rest[self.owner]] = chords
        self._put(Elements(ends[:, :2].copy(), ends[:, 2:].copy(), is_arc, rows))

    def _put(self, elements: Elements) -> None:
        self.elements = elements
        self._turns: dict[float, Floats] = {}
        self._most_turns: dict[float, Floats] = {}
        #: How far along all ways, one after the other, each element begins.
        self._reached: Floats = np.concatenate(([0.0], np.cumsum(elements.length)))
        self.begins: Floats = self._reached[self.first]
        self.lengths: Floats = self._reached[self.last + 1] - self.begins
        self.starts: Floats = elements.start[self.first]
        self.ends: Floats = elements.end[self.last]
        self._grids: list[Grid] = []

    @property
    def kinds(self) -> Counts:
        """0 for each way that is a line, 1 for an arc, 2 for any other."""
        kinds: Counts = self.elements.is_arc[self.first].astype(np.int64)
        kinds[self.rest] = 2
        return kinds

    def near(self, points: Floats, reach: float) -> Pairs:
        """All pairs of a point (n, 2) and an element no farther than `reach` from it."""
        return self._grid(reach).near(points, reach)

    def batches(self, points: Floats, reach: float) -> Iterator[Pairs]:
        """The same pairs, point by point in batches that fit into the memory."""
        return self._grid(reach).batches(points, reach)

    def _grid(self, reach: float) -> Grid:
        for grid in self._grids:
            if reach * LARGER <= grid.reach <= max(WIDER * reach, LEAST_REACH * grid.size):
                return grid
        self._grids.append(Grid(self.elements, reach))
        return self._grids[-1]

    def nearest_within(
        self, points: Floats, reaches: Sequence[float], which: Flags | None = None,
        fits: Callable[[Pairs], Flags] | None = None,
    ) -> tuple[Floats, Counts]:  # fmt: skip
        """Of each point the nearest way, of some of them: how far it is, and which one.

        Of the ways `which`, and the pairs that `fits`. Infinitely far where there is none within
        the greatest of the `reaches`, which ascend: what is nearer is not looked for farther out,
        where curves may lie close together.
        """
        away, who = np.full(len(points), np.inf), np.zeros(len(points), dtype=np.int64)
        left = np.arange(len(points) if which is None or which.any() else 0)
        for reach in reaches:
            if not len(left):
                break
            for pairs in self._grid(reach).batches(points[left], reach):
                best = pairs if which is None else pairs.kept(which[self.owner[pairs.element]])
                best = replace(best, point=left[best.point])
                if fits is not None:
                    best = best.kept(fits(best))
                best = nearest_pairs(best)
                away[best.point], who[best.point] = best.away, self.owner[best.element]
            left = left[np.isinf(away[left])]
        return away, who

    def by_way(self, pairs: Pairs) -> Pairs:
        """Of the elements of one way near one point, the nearest; the first of several."""
        return _nearest(pairs, pairs.point * self.count + self.owner[pairs.element])

    def nearest_of(self, pairs: Pairs, count: int) -> tuple[Floats, Counts]:
        """Of each of `count` points the nearest way: how far it is, and which one.

        Infinitely far where there is no pair; the first of several that are as near.
        """
        away, who = np.full(count, np.inf), np.zeros(count, dtype=np.int64)
        best = nearest_pairs(pairs)
        away[best.point], who[best.point] = best.away, self.owner[best.element]
        return away, who

    def places_of(self, pairs: Pairs) -> Floats:
        """The place of each pair on its element, (n, 2)."""
        return self.elements.places(pairs.element, self.shares(pairs))

    def shares(self, pairs: Pairs) -> Floats:
        """The share of its element at which the place of each pair lies."""
        length = self.elements.length[pairs.element]
        shares = np.divide(pairs.along, length, out=np.zeros(len(length)), where=length > 0.0)
        return np.asarray(shares)

    def at(self, element: Counts, along: Floats) -> Floats:
        """How far along all ways, one after the other, places on elements lie."""
        return self._reached[element] + along

    def nearest(self, points: Floats, likely: float = 0.0) -> tuple[Floats, Counts]:
        """Distance to the nearest way, and which one that is, for points (n, 2).

        `likely` is a distance that most have a way within, which is quicker to look for.
        """
        reach = likely or max(float(self._reached[-1]) / max(4 * len(self.elements), 1), 1e-3)
        away, who = np.full(len(points), np.inf), np.zeros(len(points), dtype=np.int64)
        left = np.arange(len(points))
        while len(left) and self.count:
            away[left], who[left] = self.nearest_of(self.near(points[left], reach), len(left))
            left = left[np.isinf(away[left])]
            reach *= WIDER
        return away, who

    def nearest_to(self, point: Floats) -> tuple[float, int]:
        """How far one point is from the nearest way, and which one that is."""
        every = np.arange(len(self.elements))
        x, y = (np.full(len(every), at) for at in point)
        away, _ = self.elements.from_chords(x, y, every)
        bent = np.flatnonzero(self.elements.is_arc)
        away[bent], _ = self.elements.from_arcs(x[bent], y[bent], bent)
        best = int(np.argmin(away))
        return float(away[best]), int(self.owner[best])

    @cached_property
    def boxes(self) -> tuple[Floats, Floats]:
        """Minimum and maximum corner of the box around each way, (n, 2) each."""
        low, high = self.elements.boxes()
        if not self.count:
            return low, high
        return np.minimum.reduceat(low, self.first), np.maximum.reduceat(high, self.first)

    def turns(self, slack: float) -> Floats:
        """Angles in rad before each element and behind the last, (n + 1,).

        Infinite where nothing goes on within `slack`, or only what does not come next.
        """
        if slack not in self._turns:
            elements, every = self.elements, np.arange(len(self.elements))
            ahead = elements.directions(every, np.zeros(len(every)))
            behind = elements.directions(every, np.ones(len(every)))
            meets = np.hypot(*(elements.end[:-1] - elements.start[1:]).T) <= slack
            turn = np.arccos(np.clip(np.sum(behind[:-1] * ahead[1:], axis=1), -1.0, 1.0))
            turns = np.full(len(every) + 1, np.inf)
            turns[1:-1] = np.where(meets, turn, np.inf)
            self._turns[slack] = turns
        return self._turns[slack]

    def most_turns(self, slack: float) -> Floats:
        """Angles in rad by which curves within the slack of elements may differ from them.

        A chord of length L, at its middle within the slack s of an arc on one side and at its ends
        on the other, is 8 s / L off the direction of that at its ends; an arc of radius r is
        2 sqrt(s / r) off that of such a chord. A chord that the next one leaves at the angle b is
        one of an arc of radius L / b; of short chords, such as those between whole steps, some may
        go on straight, so that the next bend counts.
        """
        if slack not in self._most_turns:
            elements = self.elements
            # The greatest turn at each element or near it.
            reach = NEAR_BEND * slack
            first = np.searchsorted(self._reached, self._reached[:-1] - reach)
            behind = np.searchsorted(self._reached, self._reached[1:] + reach, "right")
            windows = np.column_stack((first, behind)).ravel()
            bend = np.maximum.reduceat(np.append(self.turns(slack), 0.0), windows)[::2]
            radius = elements.arcs[elements.is_arc, 2]
            # Of elements that are absurdly short or long.
            with np.errstate(divide="ignore", over="ignore", invalid="ignore"):
                share = slack / elements.length
                most: Floats = np.fmin(8.0 * share, bend / 2 + 2.0 * np.sqrt(bend * share))
                most[elements.is_arc] += 2.0 * np.sqrt(slack / radius)
            self._most_turns[slack] = most
        return self._most_turns[slack]

    def outline(self, first: int, last: int, tolerance: float) -> Floats:
        """Points along the ways from `first` up to `last`, both ends of each among them, (n, 2).

        No chord of an arc is farther from it than `tolerance`.
        """
        return self._points(int(self.first[first]), int(self.last[last - 1]) + 1, tolerance)[0]

    def outlines(self, tolerance: float) -> tuple[Floats, Counts]:
        """The points of all ways as `outline` has them, and where each begins, (count + 1,)."""
        points, counts = self._points(0, len(self.elements), tolerance)
        behind = np.concatenate(([0], np.cumsum(counts)))
        return points, behind[np.concatenate(([0], self.last + 1))]

    def whole(self, fine: float) -> DrawnWays:
        """All ways from end to end; chords are at most `fine` off."""
        return DrawnWays(self.starts.copy(), self.ends.copy(), *self.outlines(fine))

    def lines(self, tolerance: float, owner: Counts | None = None) -> NDArray[np.object_]:
        """A line along each way, or along all ways of each owner, as `outline` has them."""
        points, begins = self.outlines(tolerance)
        own = np.arange(self.count) if owner is None else owner
        lines: NDArray[np.object_] = shapely.linestrings(
            points, indices=np.repeat(own, np.diff(begins))
        )
        return lines

    def _points(self, low: int, high: int, tolerance: float) -> tuple[Floats, Counts]:
        """Points along some elements, and how many of each."""
        arcs = self.elements.arcs[low:high]
        # The sagitta of a chord is r (1 - cos(turn / 2)), which is below r turn^2 / 8.
        steps = np.abs(arcs[:, 4]) * np.sqrt(arcs[:, 2] / (8 * tolerance))
        steps = np.maximum(steps, np.abs(arcs[:, 4]) / MOST_TURN_RAD)
        count = np.maximum(1, np.ceil(steps)).astype(np.int64) + 1
        owner = np.repeat(np.arange(low, high), count)
        number = np.arange(len(owner)) - np.repeat(np.cumsum(count) - count, count)
        return self.elements.places(owner, number / np.repeat(count - 1, count)), count

    def point(self, way: Counts, at: Floats) -> Floats:
        """The places so far along ways, (n, 2)."""
        return self.elements.places(*self._element(self.begins[way] + at))

    def _element(self, place: Floats) -> tuple[Counts, Floats]:
        """The element that a place along all ways lies on, and the share of it."""
        length = self.elements.length
        element = np.searchsorted(self._reached, place, "right") - 1
        element = np.clip(element, 0, len(length) - 1)
        safe = np.where(length[element] > 0.0, length[element], 1.0)
        share: Floats = (place - self._reached[element]) / safe
        return element, share

    def samples_at(self, way: Counts, at: Floats) -> Samples:
        """The places so far along ways."""
        return (*self._element(self.begins[way] + at), way)

    def samples(self, spacing: float | Floats) -> Samples:
        """Places inside each way, three or more, at most `spacing` (or that of each) apart.

        The element of each and the share of it, for `places` and `directions`; and the way of
        each. Ends are left out, since ways meet there.
        """
        count = np.maximum(3, np.ceil(self.lengths / spacing)).astype(np.int64)
        owner = np.repeat(np.arange(self.count), count)
        number = np.arange(len(owner)) - np.repeat(np.cumsum(count) - count, count)
        part = np.repeat(self.lengths / count, count)
        element, share = self._element(np.repeat(self.begins, count) + (number + 0.5) * part)
        return element, share, owner


def joined_samples(*several: Samples) -> Samples:
    """Samples one behind the other."""
    element, share, way = (np.concatenate(column) for column in zip(*several, strict=True))
    return element, share, way


def kept_samples(samples: Samples, which: Flags | Counts) -> Samples:
    """Some of the samples."""
    element, share, way = samples
    return element[which], share[which], way[which]


def nearest_pairs(pairs: Pairs) -> Pairs:
    """The nearest element of each point that has one; the first of several that are as near."""
    return _nearest(pairs, pairs.point)


def _nearest(pairs: Pairs, group: Counts) -> Pairs:
    """The nearest pair of each group, whose pairs follow one another; the first of several."""
    first = np.flatnonzero(np.diff(group, prepend=-1))
    if len(first) == len(group):
        return pairs
    least = np.minimum.reduceat(pairs.away, first)
    best = np.flatnonzero(pairs.away == np.repeat(least, np.diff(first, append=len(group))))
    return pairs.kept(best[np.flatnonzero(np.diff(group[best], prepend=-1))])
