"""Numeric data of many curves, as float64 arrays: ends, hulls, areas.

A drawing has tens of thousands of curves. Questions about all of them at once (which ends meet,
which lie outermost) are asked of these arrays; the curves stay what they are.
"""

from collections import defaultdict
from collections.abc import Iterable, Sequence
from functools import cached_property
from itertools import chain

import numpy as np
from msgspec.structs import astuple

from beamcam.geometry.array_types import Counts, Floats
from beamcam.geometry.curves import Arc, Bezier, BSpline, Curve, Line, signed_area
from beamcam.geometry.plane import Box, Point, box_around, join_boxes


def by_kind(curves: Iterable[Curve]) -> dict[type, list[int]]:
    """The indices of the curves of each kind, ascending."""
    indices: defaultdict[type, list[int]] = defaultdict(list)
    for k, kind in enumerate(map(type, curves)):
        indices[kind].append(k)
    return indices


def rows(values: Iterable[Sequence[float]], width: int) -> Floats:
    """Rows of `width` numbers as an array (n, width)."""
    found: Floats = np.fromiter(chain.from_iterable(values), dtype=np.float64)
    return found.reshape(-1, width)


class CurveTable:
    """Many curves, the numbers of the lines and arcs among them, and what follows from these.

    Each array is made when it is first asked for and kept; none may be written to.
    """

    def __init__(self, curves: Sequence[Curve]) -> None:
        self.curves = curves
        self._kinds = by_kind(curves)

    def where(self, kind: type[Curve]) -> Counts:
        """The indices of the curves of a kind, ascending."""
        return np.array(self._kinds.get(kind, []), dtype=np.int64)

    def free(self) -> list[int]:
        """The indices of the curves that are neither lines nor arcs, ascending."""
        kinds = self._kinds.items()
        return sorted(k for kind, which in kinds if kind not in (Line, Arc) for k in which)

    @cached_property
    def lines(self) -> Floats:
        """Start and end of the lines, (n, 4)."""
        lines = [self.curves[k] for k in self._kinds.get(Line, [])]
        return rows(chain.from_iterable(map(astuple, lines)), 4)

    @cached_property
    def arcs(self) -> Floats:
        """Centre, radius, start and sweep in degrees of the arcs, (n, 5)."""
        arcs: list[Arc] = [self.curves[k] for k in self._kinds.get(Arc, [])]  # type: ignore[misc]
        return rows([(*a.centre, a.radius, a.start_deg, a.sweep_deg) for a in arcs], 5)

    @cached_property
    def ends(self) -> Floats:
        """Start and end of every curve, (n, 4); those of arcs to the last digits but one or two."""
        ends = np.empty((len(self.curves), 4))
        for kind, which in self._kinds.items():
            some = [self.curves[k] for k in which]
            if kind is Line:
                ends[which] = self.lines
            elif kind is Arc:
                ends[which] = arc_ends(self.arcs)
            elif kind is Bezier:
                points = [_control(curve) for curve in some]
                ends[which] = rows([(*p[0], *p[-1]) for p in points], 4)
            else:
                ends[which] = [(*curve.start, *curve.end) for curve in some]
        return ends

    @cached_property
    def hulls(self) -> Floats:
        """A box around every curve, (n, 4): minimum x and y, maximum x and y; tight for lines.

        Arcs have the box of their circle, free curves that of their control points.
        """
        hulls = np.empty((len(self.curves), 4))
        for kind, which in self._kinds.items():
            if kind is Line:
                start, end = self.lines[:, :2], self.lines[:, 2:]
                hulls[which] = np.hstack((np.minimum(start, end), np.maximum(start, end)))
            elif kind is Arc:
                centre, radius = self.arcs[:, :2], self.arcs[:, 2:3]
                hulls[which] = np.hstack((centre - radius, centre + radius))
            elif kind is Bezier or kind is BSpline:
                hulls[which] = [box_around(_control(self.curves[k])) for k in which]
            else:
                hulls[which] = [self.curves[k].bbox for k in which]
        return hulls

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


def _control(curve: Curve) -> Sequence[Point]:
    return curve.control if isinstance(curve, BSpline) else curve.points  # type: ignore[union-attr]
