"""Numeric data of many curves, as float64 arrays: ends, hulls, areas, what is near, cubics.

A drawing has tens of thousands of curves. Questions about all of them at once (which ends meet,
which lie outermost) are asked of these arrays; the curves stay what they are.
"""

from collections import defaultdict
from collections.abc import Iterator, Sequence
from functools import cached_property
from itertools import chain, compress
from operator import attrgetter
from typing import Any

import numpy as np
from numpy.lib.stride_tricks import sliding_window_view
from numpy.typing import NDArray

from beamcam.caches import PerMembers
from beamcam.geometry.array_types import Counts, Floats
from beamcam.geometry.curves import (
    Arc,
    Bezier,
    BSpline,
    Curve,
    EllipseArc,
    Line,
    NewtonCurve,
    signed_area,
)
from beamcam.geometry.plane import Box, Point, box_around, join_boxes


def rows(values: Sequence[Sequence[float]], width: int) -> Floats:
    """Rows of `width` numbers as an array (n, width)."""
    numbers = chain.from_iterable(values)
    table: Floats = np.fromiter(numbers, dtype=np.float64, count=len(values) * width)
    return table.reshape(-1, width)


def numbered(counts: Counts) -> tuple[Counts, Counts]:
    """For runs of so many: the run of each member, and its number in it from 0."""
    owner = np.repeat(np.arange(len(counts)), counts)
    return owner, np.arange(len(owner)) - (np.cumsum(counts) - counts)[owner]


#: Lines and arcs first, behind them the free curves.
_KINDS: tuple[type[Curve], ...] = (Line, Arc, EllipseArc, Bezier, BSpline, NewtonCurve)


class CurveTable:
    """Many curves, the numbers of the lines and arcs among them, and what follows from these.

    Each array is made when it is first asked for and kept. None can be written to: planner and
    read-back have one table of the same curves, and what one of them changed the other would see.
    """

    def __init__(self, curves: Sequence[Curve]) -> None:
        self.curves = curves
        kinds = map(_KINDS.index, map(type, curves))
        self._kinds = np.fromiter(kinds, dtype=np.int8, count=len(curves))

    def where(self, kind: type[Curve]) -> Counts:
        """The indices of the curves of a kind, ascending."""
        return np.flatnonzero(self._kinds == _KINDS.index(kind))

    def free(self) -> list[int]:
        """The indices of the curves that are neither lines nor arcs, ascending."""
        which: list[int] = np.flatnonzero(self._kinds > _KINDS.index(Arc)).tolist()
        return which

    def _of(self, kind: type[Curve]) -> Iterator[Any]:
        return compress(self.curves, (self._kinds == _KINDS.index(kind)).tolist())

    @cached_property
    def lines(self) -> Floats:
        """Start and end of the lines, (n, 4)."""
        return _fixed(rows([(*a.start, *a.end) for a in self._of(Line)], 4))

    @cached_property
    def arcs(self) -> Floats:
        """Centre, radius, start and sweep in degrees of the arcs, (n, 5)."""
        arcs = [(*a.centre, a.radius, a.start_deg, a.sweep_deg) for a in self._of(Arc)]
        return _fixed(rows(arcs, 5))

    @cached_property
    def ends(self) -> Floats:
        """Start and end of every curve, (n, 4); those of arcs to the last digits but one or two."""
        ends = np.empty((len(self.curves), 4))
        ends[self.where(Line)], ends[self.where(Arc)] = self.lines, arc_ends(self.arcs)
        if free := self.free():
            ends[free] = [(*self.curves[k].start, *self.curves[k].end) for k in free]
        return _fixed(ends)

    @cached_property
    def hulls(self) -> Floats:
        """A box around every curve, (n, 4): minimum x and y, maximum x and y; tight for lines.

        Arcs have the box of their circle, free curves that of their control points.
        """
        hulls = np.empty((len(self.curves), 4))
        start, end = self.lines[:, :2], self.lines[:, 2:]
        hulls[self.where(Line)] = np.hstack((np.minimum(start, end), np.maximum(start, end)))
        centre, radius = self.arcs[:, :2], self.arcs[:, 2:3]
        hulls[self.where(Arc)] = np.hstack((centre - radius, centre + radius))
        if free := self.free():
            control = {Bezier: attrgetter("points"), BSpline: attrgetter("control")}
            some = [(control.get(type(self.curves[k])), self.curves[k]) for k in free]
            hulls[free] = [box_around(of(one)) if of else one.bbox for of, one in some]
        return _fixed(hulls)

    @cached_property
    def box(self) -> Box | None:
        """The bounding box of all curves; None if there are none.

        On each side those are measured whose hulls may reach beyond all others, outermost first.
        """
        if not self.curves:
            return None
        hulls = self.hulls * (1.0, 1.0, -1.0, -1.0)
        bent = np.ones(len(hulls), dtype=bool)
        bent[self.where(Line)] = False
        box: Box = self.curves[0].bbox
        if not bent.all():
            x0, y0, x1, y1 = hulls[~bent].min(axis=0).tolist()
            box = (x0, y0, -x1, -y1)
        which = np.flatnonzero(bent)
        for side, sign in enumerate((1, 1, -1, -1)):
            for k in which[np.argsort(hulls[which, side], kind="stable")].tolist():
                if hulls[k, side] >= sign * box[side]:
                    break
                box = join_boxes([box, self.curves[k].bbox]) or box
        return box


def _fixed(array: Floats) -> Floats:
    """The array, read-only from now on."""
    array.setflags(write=False)
    return array


#: The table of a tuple of curves, made once for the same curves.
table_of = PerMembers("curves.table", CurveTable)


def arc_ends(arcs: Floats) -> Floats:
    """Start and end (n, 4) of arcs in rows as `CurveTable.arcs`; of a circle one point."""
    centre, radius = arcs[:, :2], arcs[:, 2:3]
    start, sweep = arcs[:, 3], arcs[:, 4]
    first = centre + radius * unit_vectors(start)
    last = centre + radius * unit_vectors(start + np.where(np.abs(sweep) == 360.0, 0.0, sweep))
    return np.hstack((first, last))


def signed_areas(chains: Sequence[Sequence[Curve]], table: CurveTable | None = None) -> Floats:
    """The areas (n,) inside closed chains in mm2, as `curves.signed_area` of each.

    `table` is that of their curves, if it was made already.
    """
    if table is None:
        table = CurveTable([curve for chain in chains for curve in chain])
    ends, arcs = table.ends, table.arcs
    shares = (ends[:, 0] * ends[:, 3] - ends[:, 1] * ends[:, 2]) / 2
    sweep = np.radians(arcs[:, 4])
    shares[table.where(Arc)] += arcs[:, 2] * arcs[:, 2] * (sweep - np.sin(sweep)) / 2
    free = table.free()
    shares[free] = [signed_area((table.curves[k],)) for k in free]
    owner = np.repeat(np.arange(len(chains)), [len(chain) for chain in chains])
    return np.bincount(owner, weights=shares, minlength=len(chains)).astype(np.float64)


def unit_vectors(angles_deg: Floats) -> Floats:
    """Cosine and sine of angles in degrees, (n, 2), exact at multiples of 90."""
    turns, rest = np.divmod(angles_deg, 90.0)
    c = np.where(rest == 0.0, 1.0, np.cos(np.radians(rest)))
    s = np.where(rest == 0.0, 0.0, np.sin(np.radians(rest)))
    quarter = turns.astype(np.int64) % 4
    x = np.choose(quarter, (c, -s, -c, s))
    y = np.choose(quarter, (s, c, -s, -c))
    return np.column_stack((x, y))


# --- what is near or equal ------------------------------------------------------------------------

# Points near one another, rows that are equal and curves that overlap, in near-linear time.

#: A row of cells in the number of a cell; there are less than half as many rows and columns.
ROW = 2**31
MOST_CELLS = 2.0**29

#: The digits of the golden ratio; the powers of an odd number mix rows to their keys.
ODD = np.uint64(0x9E3779B97F4A7C15)

#: From a cell to itself and to half of its neighbours; the other half looks from over there.
_STEPS = (0, 1, ROW - 1, ROW, ROW + 1)


def near_pairs(points: Floats, reach: float) -> tuple[Counts, Counts]:
    """Indices a < b of all points (n, 2) no farther apart than `reach`, ascending.

    The cells are as wide as the reach, so that it is enough to look into neighbouring ones.
    Raises ValueError if the reach is not above 0.
    """
    if not reach > 0.0:
        raise ValueError(f"reach must be above 0, found {reach:g}")
    if len(points) < 2:
        none = np.empty(0, dtype=np.int64)
        return none, none
    low = points.min(axis=0)
    extent = float((points.max(axis=0) - low).max())
    # A little wider, so that rounding puts no two near points two cells apart.
    cell = max(reach * (1 + 1e-6), extent / MOST_CELLS)
    column_row = np.floor((points - low) / cell).astype(np.int64)
    key = column_row[:, 0] * ROW + column_row[:, 1]
    order = np.argsort(key, kind="stable")
    key = key[order]
    firsts, seconds = [], []
    for step in _STEPS:
        begin = np.searchsorted(key, key + step)
        if step == 0:
            begin = np.arange(1, len(key) + 1)
        end = np.searchsorted(key, key + step, side="right")
        counts = np.maximum(end - begin, 0)
        first = np.repeat(np.arange(len(key)), counts)
        second = np.arange(len(first)) + np.repeat(begin - (np.cumsum(counts) - counts), counts)
        firsts.append(order[first])
        seconds.append(order[second])
    a, b = np.concatenate(firsts), np.concatenate(seconds)
    away = points[a] - points[b]
    near = np.hypot(away[:, 0], away[:, 1]) <= reach
    a, b = np.minimum(a[near], b[near]), np.maximum(a[near], b[near])
    order = np.lexsort((b, a))
    return a[order], b[order]


def first_equal(rows: Floats) -> Counts:
    """For each row (n, m) the first one that is equal to it in every digit, itself if none is."""
    bits = np.ascontiguousarray(rows + 0.0).view(np.uint64)  # -0.0 becomes 0.0
    factors = np.cumprod(np.full(rows.shape[1], ODD))
    key = (bits * factors).sum(axis=1, dtype=np.uint64)
    order = np.argsort(key, kind="stable")
    # Rows of one key that differ all the same are just not told apart as well as they could be.
    new = np.ones(len(rows), dtype=bool)
    new[1:] = np.any(bits[order][1:] != bits[order][:-1], axis=1)
    firsts = np.empty(len(rows), dtype=np.int64)
    firsts[order] = order[np.maximum.accumulate(np.where(new, np.arange(len(rows)), 0))]
    return firsts


#: Curves nearer than this coincide; exports round to 1e-4 and finer.
SAME_PLACE = 1e-3


def overlapping(curves: CurveTable, processes: Sequence[str]) -> list[tuple[int, int]]:
    """Pairs of curves of the same process that may lie on one another, ascending.

    Lines have to be collinear, arcs on one circle, and other curves to have the same ends.
    """
    lines, arcs, others = curves.where(Line), curves.where(Arc), np.array(curves.free(), dtype=int)
    ends, circles = curves.ends[others], np.array(near_pairs(curves.arcs[:, :2], SAME_PLACE))
    radii = curves.arcs[circles, 2]
    pairs = [
        lines[np.array(_collinear(curves.lines))],
        arcs[circles[:, np.abs(radii[0] - radii[1]) <= SAME_PLACE]],
        others[np.array(near_pairs((ends[:, :2] + ends[:, 2:]) / 2, SAME_PLACE))],
    ]
    first, second = np.sort(np.concatenate(pairs, axis=1), axis=0)
    numbers = {name: k for k, name in enumerate(dict.fromkeys(processes))}
    process = np.array([numbers[name] for name in processes], dtype=np.int64)
    alike = np.flatnonzero(process[first] == process[second])
    alike = alike[np.lexsort((second[alike], first[alike]))]
    return list(zip(first[alike].tolist(), second[alike].tolist(), strict=True))


def _collinear(ends: NDArray[np.float64]) -> tuple[Counts, Counts]:
    """Pairs of lines (n, 4) that lie on one line and overlap by more than `SAME_PLACE`."""
    import shapely

    if len(ends) < 2:
        none = np.empty(0, dtype=np.int64)
        return none, none
    low = np.minimum(ends[:, :2], ends[:, 2:])
    high = np.maximum(ends[:, :2], ends[:, 2:])
    # The box around a line is that around the diagonal of the box.
    diagonals = shapely.linestrings(np.stack((low - SAME_PLACE, high + SAME_PLACE), axis=1))
    a, b = shapely.STRtree(diagonals).query(diagonals)
    a, b = a[a < b], b[a < b]
    lengths = np.hypot(*(ends[:, 2:] - ends[:, :2]).T)
    # The longer of both gives the direction.
    swap = lengths[b] > lengths[a]
    long, short = np.where(swap, b, a), np.where(swap, a, b)
    real = lengths[long] > SAME_PLACE
    long, short = long[real], short[real]
    unit = (ends[long, 2:] - ends[long, :2]) / lengths[long][:, None]
    away, along = [], []
    for part in (ends[short, :2], ends[short, 2:]):
        rest = part - ends[long, :2]
        away.append(np.abs(unit[:, 0] * rest[:, 1] - unit[:, 1] * rest[:, 0]))
        along.append(np.sum(unit * rest, axis=1))
    shared = np.minimum(np.maximum(*along), lengths[long]) - np.maximum(np.minimum(*along), 0.0)
    same = (np.maximum(*away) <= SAME_PLACE) & (shared > SAME_PLACE)
    return long[same], short[same]


def cubics_of(curves: Sequence[Curve]) -> tuple[Floats, Counts, list[int]]:
    """The control points (n, 4, 2) of all cubics without weights, and the curve of each (n,).

    They come in the order of the curves, those of a spline from its start to its end, and are the
    same numbers as `bezier_pieces` gives. The third value names the curves that are not cubics.
    """
    plain: list[int] = []
    splines: defaultdict[int, list[int]] = defaultdict(list)  #: by how many control points
    others: list[int] = []
    points: list[Point] = []
    for k, curve in enumerate(curves):
        piece = curve.as_bezier() if isinstance(curve, NewtonCurve) else curve
        if not isinstance(piece, Bezier | BSpline) or piece.weights or piece.degree != 3:
            others.append(k)
        elif isinstance(piece, BSpline):
            splines[len(piece.control)].append(k)
        else:
            plain.append(k)
            points += piece.points
    alike = [([curves[k] for k in some], some) for some in splines.values()]
    cubics = [_spline_cubics(*some) for some in alike]  # type: ignore[arg-type]
    control = np.concatenate([rows(points, 2).reshape(-1, 4, 2), *(part for part, _ in cubics)])
    owners = np.concatenate([np.array(plain, dtype=np.int64), *(owner for _, owner in cubics)])
    order = np.argsort(owners, kind="stable")
    return control[order], owners[order], others


def _spline_cubics(splines: Sequence[BSpline], names: Sequence[int]) -> tuple[Floats, Counts]:
    """All spans of all splines at once; `names` come back for the splines.

    Control point j of the span [a, b] is the blossom of (a, ..., b, ...) with b taken j times.
    """
    points = np.array([s.control for s in splines], dtype=np.float64)  # (n, size, 2)
    knots = np.array([s.knots for s in splines], dtype=np.float64)
    owner, span = np.nonzero(knots[:, 3:-4] < knots[:, 4:-3])
    around = sliding_window_view(knots[:, 1:-1], 6, axis=1)[owner, span]
    control = sliding_window_view(points, 4, axis=1)[owner, span].transpose(0, 2, 1)
    a, b = around[:, 2], around[:, 3]
    cubics = np.stack(
        [_blossoms(control, around, us) for us in ((a, a, a), (a, a, b), (a, b, b), (b, b, b))],
        axis=1,
    )
    # Each piece begins where the one before it ended; a clamped spline begins and ends on its
    # control points.
    first = np.diff(owner, prepend=-1) > 0
    last = np.append(first[1:], True)
    cubics[1:, 0] = np.where(first[1:, None], cubics[1:, 0], cubics[:-1, 3])
    begins, ends = (knots[:, k] == knots[:, k + 2] for k in (1, -4))
    cubics[first & begins[owner], 0] = points[begins, 0]
    cubics[last & ends[owner], 3] = points[ends, -1]
    return cubics, np.array(names, dtype=np.int64)[owner]


def _blossoms(points: Floats, knots: Floats, arguments: Sequence[Floats]) -> Floats:
    """The blossom of each spline in a span of its knots: an array (n, 2).

    `points` (n, 4, 2) are the control points of the span, `knots` (n, 6) its ends and two more on
    each side.
    """
    row = points.copy()
    for r, u in enumerate(arguments, start=1):
        for i in range(3, r - 1, -1):
            low, high = knots[:, i - 1], knots[:, i - r + 3]
            share = ((u - low) / (high - low))[:, None]
            row[:, i] = row[:, i - 1] + share * (row[:, i] - row[:, i - 1])
    return row[:, 3]
