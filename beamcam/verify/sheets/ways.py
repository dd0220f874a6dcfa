"""Many curves as elements, and questions about many points at once."""

from collections.abc import Iterable, Sequence
from functools import cached_property
from itertools import chain
from typing import cast

import numpy as np

from beamcam.geometry.curves import Arc, BSpline, Curve, Line
from beamcam.geometry.polylines import polylines
from beamcam.verify.sheets.elements import Counts, Elements, Flags, Floats
from beamcam.verify.sheets.grid import Grid, Pairs
from beamcam.verify.sheets.moves import Moves
from beamcam.verify.sheets.splines import spline_points

WIDER = 4.0  #: how much farther is looked where nothing was near
MOST_TURN_RAD = 0.8  #: between points of an outline


class Ways:
    """Curves one behind the other; lines and arcs are exact, chords of others off by `tolerance`.

    `shift` moves all of them.
    """

    def __init__(
        self, curves: Sequence[Curve], tolerance: float, shift: tuple[float, float] = (0.0, 0.0)
    ) -> None:
        kinds = [type(curve) for curve in curves]
        is_line = np.array([kind is Line for kind in kinds], dtype=bool)
        is_arc = np.array([kind is Arc for kind in kinds], dtype=bool)
        lines = [c for c in curves if isinstance(c, Line)]
        arcs = [c for c in curves if isinstance(c, Arc)]
        others = [c for c, kind in zip(curves, kinds, strict=True) if kind not in (Line, Arc)]
        rows = ((*c.centre, c.radius, c.start_deg, c.sweep_deg) for c in arcs)
        self._build(
            is_line, _rows((c.start for c in lines), 2), _rows((c.end for c in lines), 2),
            is_arc, _rows(rows, 5), _chains(others, tolerance),
        )  # fmt: skip
        if shift != (0.0, 0.0):
            self._put(self.elements.moved(shift))

    @classmethod
    def of_moves(cls, moves: Moves, tolerance: float) -> "Ways":
        """The ways of moves."""
        found = cls.__new__(cls)
        is_line = ~moves.is_arc
        is_line[list(moves.curves)] = False
        curves = [moves.curves[k] for k in sorted(moves.curves)]
        found._build(
            is_line, moves.start[is_line], moves.end[is_line], moves.is_arc,
            moves.arcs[moves.is_arc], _chains(curves, tolerance),
        )  # fmt: skip
        return found

    def moved(self, shift: tuple[float, float]) -> "Ways":
        """The same elsewhere."""
        found = Ways.__new__(Ways)
        found.count, found._first, found._behind = self.count, self._first, self._behind
        found.owner = self.owner
        found._put(self.elements.moved(shift))
        return found

    def _build(
        self,
        is_line: Flags,
        line_starts: Floats,
        line_ends: Floats,
        is_arc: Flags,
        arcs: Floats,
        chains: list[Floats],
    ) -> None:
        """From one row a line, one an arc, and the points of each other curve."""
        self.count = len(is_line)
        counts = np.ones(self.count, dtype=np.int64)
        is_chain = ~(is_line | is_arc)
        counts[is_chain] = [len(points) - 1 for points in chains]
        self._behind = np.cumsum(counts)  #: the element behind the last of each way
        self._first = self._behind - counts
        self.owner: Counts = np.repeat(np.arange(self.count), counts)
        total = len(self.owner)
        start, end, rows = np.empty((total, 2)), np.empty((total, 2)), np.zeros((total, 5))
        at = self._first[is_line]
        start[at], end[at] = line_starts, line_ends
        at = self._first[is_arc]
        start[at], end[at] = _arc_ends(arcs)
        rows[at, :3], rows[at, 3:] = arcs[:, :3], np.radians(arcs[:, 3:])
        if chains:
            inner = is_chain[self.owner]
            start[inner] = np.concatenate([points[:-1] for points in chains])
            end[inner] = np.concatenate([points[1:] for points in chains])
        bent = np.zeros(total, dtype=bool)
        bent[at] = True
        self._put(Elements(start, end, bent, rows))

    def _put(self, elements: Elements) -> None:
        self.elements = elements
        #: How far along all ways, one behind the other, each element begins.
        self._reached: Floats = np.concatenate(([0.0], np.cumsum(elements.length)))
        self.begins: Floats = self._reached[self._first]
        self.lengths: Floats = self._reached[self._behind] - self.begins
        self.starts: Floats = elements.start[self._first]
        self.ends: Floats = elements.end[self._behind - 1]
        self._grids: list[Grid] = []

    def near(self, points: Floats, reach: float) -> Pairs:
        """All pairs of a point (n, 2) and an element no farther than `reach` from it."""
        for grid in self._grids:
            if reach <= grid.reach <= WIDER * reach:
                return grid.near(points, reach)
        self._grids.append(Grid(self.elements, reach))
        return self._grids[-1].near(points, reach)

    def by_way(self, pairs: Pairs) -> Pairs:
        """Of the elements of one way near one point, the nearest; the first of several."""
        return _nearest(pairs, pairs.point * self.count + self.owner[pairs.element])

    def nearest_of(self, pairs: Pairs, count: int) -> tuple[Floats, Counts, Floats]:
        """Of each of `count` points the nearest way: how far it is, which, how far along it.

        Infinitely far where there is no pair; the first of several that are as near.
        """
        away, who, along = np.full(count, np.inf), np.zeros(count, dtype=np.int64), np.zeros(count)
        best = _nearest(pairs, pairs.point)
        owner = self.owner[best.element]
        away[best.point], who[best.point] = best.away, owner
        along[best.point] = self.at(best.element, best.along) - self.begins[owner]
        return away, who, along

    def at(self, element: Counts, along: Floats) -> Floats:
        """How far along all ways, one behind the other, places on elements lie."""
        found: Floats = self._reached[element] + along
        return found

    def nearest(self, points: Floats, likely: float = 0.0) -> tuple[Floats, Counts]:
        """Distance to the nearest way, and which one that is, for points (n, 2).

        `likely` is a distance that most have a way within, which is quicker to look for.
        """
        reach = likely or max(float(self._reached[-1]) / max(4 * len(self.elements), 1), 1e-3)
        away, who = np.full(len(points), np.inf), np.zeros(len(points), dtype=np.int64)
        left = np.arange(len(points))
        while len(left) and self.count:
            found = self.near(points[left], reach)
            away[left], who[left], _ = self.nearest_of(found, len(left))
            left = left[np.isinf(away[left])]
            reach *= WIDER
        return away, who

    def nearest_to(self, point: Floats) -> tuple[float, int]:
        """How far one point is from the nearest way, and which one that is."""
        every = np.arange(len(self.elements))
        x, y = np.full(len(every), point[0]), np.full(len(every), point[1])
        away, _ = self.elements.distances(x, y, every)
        best = int(np.argmin(away))
        return float(away[best]), int(self.owner[best])

    @cached_property
    def boxes(self) -> tuple[Floats, Floats]:
        """Least and greatest corner of the box around each way, (n, 2) each."""
        low, high = self.elements.boxes()
        if not self.count:
            return low, high
        return np.minimum.reduceat(low, self._first), np.maximum.reduceat(high, self._first)

    def outline(self, first: int, last: int, tolerance: float) -> Floats:
        """Points along the ways from `first` up to `last`, both ends of each among them, (n, 2).

        No chord of an arc is farther from it than `tolerance`.
        """
        low, high = int(self._first[first]), int(self._behind[last - 1])
        arcs = self.elements.arcs[low:high]
        # The sagitta of a chord is r (1 - cos(turn / 2)), which is below r turn^2 / 8.
        steps = np.abs(arcs[:, 4]) * np.sqrt(arcs[:, 2] / (8 * tolerance))
        steps = np.maximum(steps, np.abs(arcs[:, 4]) / MOST_TURN_RAD)
        count = np.maximum(1, np.ceil(steps)).astype(np.int64)
        owner = np.repeat(np.arange(low, high), count + 1)
        number = np.arange(len(owner)) - np.repeat(np.cumsum(count + 1) - count - 1, count + 1)
        return self.elements.places(owner, number / np.repeat(count, count + 1))

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

    def samples(self, spacing: float) -> tuple[Counts, Floats, Counts]:
        """Places inside each way, three or more, at most `spacing` apart.

        The element of each and the share of it, for `places` and `directions`; and the way of
        each. Ends are left out, since ways meet there.
        """
        count = np.maximum(3, np.ceil(self.lengths / spacing)).astype(np.int64)
        owner = np.repeat(np.arange(self.count), count)
        number = np.arange(len(owner)) - np.repeat(np.cumsum(count) - count, count)
        part = np.repeat(self.lengths / count, count)
        element, share = self._element(np.repeat(self.begins, count) + (number + 0.5) * part)
        return element, share, owner


def _rows(values: Iterable[Sequence[float]], width: int) -> Floats:
    """Records of equally many numbers as the rows of an array."""
    return np.fromiter(chain.from_iterable(values), dtype=np.float64).reshape(-1, width)


def _nearest(pairs: Pairs, group: Counts) -> Pairs:
    """The nearest pair of each group, whose pairs follow one another; the first of several."""
    first = np.flatnonzero(np.diff(group, prepend=-1))
    if len(first) == len(group):
        return pairs
    least = np.minimum.reduceat(pairs.away, first)
    best = np.flatnonzero(pairs.away == np.repeat(least, np.diff(first, append=len(group))))
    return pairs.kept(best[np.flatnonzero(np.diff(group[best], prepend=-1))])


def _arc_ends(arcs: Floats) -> tuple[Floats, Floats]:
    """Both ends of arcs whose angles are in degrees; exact on the axes, and circles close."""
    found = []
    for angle in (arcs[:, 3], arcs[:, 3] + arcs[:, 4]):
        turn = np.radians(angle)
        unit = np.column_stack((np.cos(turn), np.sin(turn)))
        quarter = angle % 90.0 == 0.0
        unit[quarter] = np.rint(unit[quarter])
        found.append(arcs[:, :2] + arcs[:, 2:3] * unit)
    start, end = found
    whole = np.abs(arcs[:, 4]) == 360.0
    end[whole] = start[whole]
    return start, end


def _chains(curves: Sequence[Curve], tolerance: float) -> list[Floats]:
    """Points along curves that are neither lines nor arcs."""
    plain = [isinstance(c, BSpline) and c.weights is None for c in curves]
    splines = [c for c, is_plain in zip(curves, plain, strict=True) if is_plain]
    drawn = iter(spline_points(cast("list[BSpline]", splines), tolerance))
    rest = [c for c, is_plain in zip(curves, plain, strict=True) if not is_plain]
    lines = polylines(rest, tolerance) if rest else None
    others = iter(np.split(lines.points, lines.begins[1:-1]) if lines is not None else [])
    return [next(drawn) if is_plain else next(others) for is_plain in plain]
