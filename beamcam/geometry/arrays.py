"""What many curves have in numbers, as float64 arrays: their ends, their hulls, their cubics.

A drawing has tens of thousands of curves. Questions about all of them at once (which ends meet,
which lie outermost) are asked of these arrays; the curves stay what they are.
"""

from collections import defaultdict
from collections.abc import Iterable, Sequence
from itertools import chain

import numpy as np
from numpy.typing import NDArray

from beamcam.geometry.curves import (
    Arc,
    Bezier,
    BSpline,
    Curve,
    Line,
    NewtonCurve,
    signed_area,
)
from beamcam.geometry.plane import Point

Floats = NDArray[np.float64]
Counts = NDArray[np.int64]

#: How far, relative to the size of all, a curve may lie inside a box and count as touching it.
TOUCH = 1e-9


def by_kind(curves: Sequence[Curve]) -> dict[type, list[int]]:
    """The indices of the curves of each kind, ascending."""
    found: defaultdict[type, list[int]] = defaultdict(list)
    for k, curve in enumerate(curves):
        found[type(curve)].append(k)
    return found


def rows(values: Iterable[Sequence[float]], width: int) -> Floats:
    """Rows of `width` numbers as an array (n, width)."""
    found: Floats = np.fromiter(chain.from_iterable(values), dtype=np.float64)
    return found.reshape(-1, width)


def line_rows(curves: Sequence[Curve], which: Sequence[int]) -> Floats:
    """Start and end of the lines among `curves` with the indices `which`: (n, 4)."""
    lines: list[Line] = [curves[k] for k in which]  # type: ignore[misc]
    return rows([(*line.start, *line.end) for line in lines], 4)


def arc_rows(curves: Sequence[Curve], which: Sequence[int]) -> Floats:
    """Centre, radius, start and sweep in degrees of the arcs with the indices `which`: (n, 5)."""
    arcs: list[Arc] = [curves[k] for k in which]  # type: ignore[misc]
    return rows([(*a.centre, a.radius, a.start_deg, a.sweep_deg) for a in arcs], 5)


def ends_of(curves: Sequence[Curve]) -> Floats:
    """Start and end of every curve, (n, 4); those of arcs to the last digits but one or two."""
    found = np.empty((len(curves), 4))
    for kind, which in by_kind(curves).items():
        if kind is Line:
            found[which] = line_rows(curves, which)
        elif kind is Arc:
            found[which] = arc_ends(arc_rows(curves, which))
        elif kind is Bezier:
            points = [_control(curves[k]) for k in which]
            found[which] = rows([(*p[0], *p[-1]) for p in points], 4)
        else:
            found[which] = [(*curves[k].start, *curves[k].end) for k in which]
    return found


def arc_ends(arcs: Floats) -> Floats:
    """Start and end (n, 4) of arcs in rows as `arc_rows` gives them; of a circle one point."""
    centre, radius = arcs[:, :2], arcs[:, 2:3]
    start, sweep = arcs[:, 3], arcs[:, 4]
    first = centre + radius * unit_vectors(start)
    last = centre + radius * unit_vectors(start + np.where(np.abs(sweep) == 360.0, 0.0, sweep))
    return np.hstack((first, last))


def signed_areas(chains: Sequence[Sequence[Curve]]) -> Floats:
    """The areas (n,) inside closed chains in mm2, as `curves.signed_area` of each."""
    curves = [curve for chain in chains for curve in chain]
    ends = ends_of(curves)
    shares = (ends[:, 0] * ends[:, 3] - ends[:, 1] * ends[:, 2]) / 2
    for kind, which in by_kind(curves).items():
        if kind is Arc:
            arcs = arc_rows(curves, which)
            sweep = np.radians(arcs[:, 4])
            shares[which] += arcs[:, 2] * arcs[:, 2] * (sweep - np.sin(sweep)) / 2
        elif kind is not Line:
            shares[which] = [signed_area((curves[k],)) for k in which]
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


def hulls_of(curves: Sequence[Curve]) -> Floats:
    """A box around every curve, (n, 4), of lines the least one: x and y, least and greatest.

    Arcs have the box of their circle, free curves that of their control points.
    """
    found = np.empty((len(curves), 4))
    for kind, which in by_kind(curves).items():
        if kind is Line:
            found[which] = _sorted_ends(line_rows(curves, which))
        elif kind is Arc:
            arcs = arc_rows(curves, which)
            found[which] = np.hstack((arcs[:, :2] - arcs[:, 2:3], arcs[:, :2] + arcs[:, 2:3]))
        elif kind is Bezier or kind is BSpline:
            of_size: defaultdict[int, list[int]] = defaultdict(list)
            for k in which:
                of_size[len(_control(curves[k]))].append(k)
            for size, some in of_size.items():
                flat = chain.from_iterable(_control(curves[k]) for k in some)
                points = rows(flat, 2 * size).reshape(-1, size, 2)
                found[some] = np.hstack((points.min(axis=1), points.max(axis=1)))
        else:
            found[which] = [curves[k].bbox for k in which]
    return found


def _sorted_ends(ends: Floats) -> Floats:
    return np.hstack((np.minimum(ends[:, :2], ends[:, 2:]), np.maximum(ends[:, :2], ends[:, 2:])))


def _control(curve: Curve) -> Sequence[Point]:
    return curve.control if isinstance(curve, BSpline) else curve.points  # type: ignore[union-attr]


def outermost(curves: Sequence[Curve]) -> list[Curve]:
    """Those curves, few as a rule, that may touch the box around all: it is the box around them.

    A curve whose hull lies inside a box around ends of curves touches nothing. Raises ValueError
    if there are no curves.
    """
    if not curves:
        raise ValueError("no curves have no box")
    hulls = hulls_of(curves)
    inner = _some_box(curves)
    slack = TOUCH * (1.0 + np.abs(inner))
    out = (hulls[:, :2] <= (inner + slack)[:2]) | (hulls[:, 2:] >= (inner - slack)[2:])
    return [curves[k] for k in np.flatnonzero(out.any(axis=1)).tolist()]


def _some_box(curves: Sequence[Curve]) -> Floats:
    """A box (4,) that the one around all curves holds: around the ends of what is quickly asked."""
    quick = [c for c in curves if type(c) in (Line, Arc, Bezier)] or curves[:1]
    ends = _sorted_ends(ends_of(quick))
    return np.concatenate((ends[:, :2].min(axis=0), ends[:, 2:].max(axis=0)))


def cubics_of(curves: Sequence[Curve]) -> tuple[Floats, Counts, list[int]]:
    """The control points (n, 4, 2) of all cubics without weights, and the curve of each (n,).

    They come in the order of the curves, those of a spline from its start to its end, and are the
    same numbers as `bezier_pieces` gives. The third value names the curves that are none.
    """
    kinds = by_kind(curves)
    plain: list[int] = []
    splines: list[int] = []
    others: list[int] = []
    for kind, which in kinds.items():
        if kind is Bezier:
            for k in which:
                curve = curves[k]
                assert isinstance(curve, Bezier)
                is_cubic = curve.weights is None and len(curve.points) == 4
                (plain if is_cubic else others).append(k)
        elif kind is BSpline:
            for k in which:
                curve = curves[k]
                assert isinstance(curve, BSpline)
                is_cubic = curve.weights is None and curve.degree == 3
                (splines if is_cubic else others).append(k)
        elif kind is NewtonCurve:
            for k in which:
                curve = curves[k]
                assert isinstance(curve, NewtonCurve)
                piece = curve.as_bezier()
                (plain if piece.weights is None and piece.degree == 3 else others).append(k)
        else:
            others += which
    points = chain.from_iterable(_cubic_points(curves[k]) for k in plain)
    control, owner = spline_cubics([curves[k] for k in splines])  # type: ignore[misc]
    control = np.concatenate((rows(points, 8).reshape(-1, 4, 2), control))
    owners = np.concatenate((_counts(plain), _counts(splines)[owner]))
    order = np.argsort(owners, kind="stable")
    return control[order], owners[order], sorted(others)


def _cubic_points(curve: Curve) -> Sequence[Point]:
    piece = curve.as_bezier() if isinstance(curve, NewtonCurve) else curve
    assert isinstance(piece, Bezier)
    return piece.points


def _counts(values: Sequence[int]) -> Counts:
    return np.array(values, dtype=np.int64)


def spline_cubics(splines: Sequence[BSpline]) -> tuple[Floats, Counts]:
    """The cubics (n, 4, 2) of cubic splines without weights, and the number of each one's spline.

    As `BSpline.pieces`, for splines with equally many control points together.
    """
    groups: defaultdict[int, list[int]] = defaultdict(list)
    for number, spline in enumerate(splines):
        groups[len(spline.control)].append(number)
    found = [_of_one_size([splines[k] for k in group], group) for group in groups.values()]
    if not found:
        return np.empty((0, 4, 2)), _counts([])
    control = np.concatenate([part[0] for part in found])
    owner = np.concatenate([part[1] for part in found])
    order = np.argsort(owner, kind="stable")
    return control[order], owner[order]


def _of_one_size(splines: Sequence[BSpline], names: Sequence[int]) -> tuple[Floats, Counts]:
    """Span by span, all splines at once; `names` come back for the splines.

    Control point j of the span [a, b] is the blossom of (a, ..., b, ...) with b taken j times.
    """
    points = np.array([s.control for s in splines], dtype=np.float64)
    knots = np.array([s.knots for s in splines], dtype=np.float64)
    count = points.shape[1]
    last = points[:, 0].copy()
    begun = np.zeros(len(splines), dtype=bool)
    found, owner = [], []
    for k in range(3, count):
        some = np.flatnonzero(knots[:, k] < knots[:, k + 1])
        mine = knots[some]
        a, b = mine[:, k], mine[:, k + 1]
        cubic = np.stack(
            [
                _blossoms(points[some], mine, k, us)
                for us in ((a, a, a), (a, a, b), (a, b, b), (b, b, b))
            ],
            axis=1,
        )
        # The first piece of a clamped spline begins on its control point, each other one where
        # the one before it ended.
        clamped = begun[some] | (mine[:, 1] == mine[:, 3])
        cubic[:, 0] = np.where(clamped[:, None], last[some], cubic[:, 0])
        # The last piece of a clamped spline ends on its control point.
        at_end = (mine[:, k + 1] == mine[:, count]) & (mine[:, -2] == mine[:, count])
        cubic[at_end, 3] = points[some[at_end], -1]
        last[some], begun[some] = cubic[:, 3], True
        found.append(cubic)
        owner.append(_counts(names)[some])
    return np.concatenate(found), np.concatenate(owner)


def _blossoms(points: Floats, knots: Floats, k: int, arguments: Sequence[Floats]) -> Floats:
    """The blossom of each spline (n, count, 2) in its span `k`: an array (n, 2)."""
    row = points[:, k - 3 : k + 1].copy()
    for r, u in enumerate(arguments, start=1):
        for i in range(3, r - 1, -1):
            low, high = knots[:, k - 3 + i], knots[:, k + 1 + i - r]
            share = ((u - low) / (high - low))[:, None]
            row[:, i] = row[:, i - 1] + share * (row[:, i] - row[:, i - 1])
    found: Floats = row[:, 3]
    return found
