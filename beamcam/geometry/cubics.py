"""The free curves of a drawing as cubics, all of them together."""

from collections import defaultdict
from collections.abc import Sequence
from itertools import chain

import numpy as np
from numpy.lib.stride_tricks import sliding_window_view

from beamcam.geometry.array_types import Counts, Floats
from beamcam.geometry.arrays import rows
from beamcam.geometry.curves import Bezier, BSpline, Curve, NewtonCurve
from beamcam.geometry.plane import Point

# --- splines --------------------------------------------------------------------------------------

# Cubic B-splines without weights, many at once, as cubics.


def spline_cubics(splines: Sequence[BSpline]) -> tuple[Floats, Counts]:
    """The cubics (n, 4, 2) of cubic splines without weights, and the number of each one's spline.

    As `BSpline.pieces`, for splines with equally many control points together.
    """
    groups: defaultdict[int, list[int]] = defaultdict(list)
    for number, spline in enumerate(splines):
        groups[len(spline.control)].append(number)
    found = [_of_one_size([splines[k] for k in group], group) for group in groups.values()]
    if not found:
        return np.empty((0, 4, 2)), np.empty(0, dtype=np.int64)
    control = np.concatenate([part[0] for part in found])
    owner = np.concatenate([part[1] for part in found])
    order = np.argsort(owner, kind="stable")
    return control[order], owner[order]


def _of_one_size(splines: Sequence[BSpline], names: Sequence[int]) -> tuple[Floats, Counts]:
    """All spans of all splines at once; `names` come back for the splines.

    Control point j of the span [a, b] is the blossom of (a, ..., b, ...) with b taken j times.
    """
    points = np.array([s.control for s in splines], dtype=np.float64)  # (n, size, 2)
    knots = np.array([s.knots for s in splines], dtype=np.float64)
    owner, span = np.nonzero(knots[:, 3:-4] < knots[:, 4:-3])
    around = sliding_window_view(knots[:, 1:-1], 6, axis=1)[owner, span]
    control = sliding_window_view(points, 4, axis=1)[owner, span].transpose(0, 2, 1)
    a, b = around[:, 2], around[:, 3]
    found = np.stack(
        [_blossoms(control, around, us) for us in ((a, a, a), (a, a, b), (a, b, b), (b, b, b))],
        axis=1,
    )
    # Each piece begins where the one before it ended; a clamped spline begins and ends on its
    # control points.
    first = np.diff(owner, prepend=-1) > 0
    last = np.append(first[1:], True)
    found[1:, 0] = np.where(first[1:, None], found[1:, 0], found[:-1, 3])
    begins, ends = (knots[:, k] == knots[:, k + 2] for k in (1, -4))
    found[first & begins[owner], 0] = points[begins, 0]
    found[last & ends[owner], 3] = points[ends, -1]
    return found, np.array(names, dtype=np.int64)[owner]


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


def cubics_of(curves: Sequence[Curve]) -> tuple[Floats, Counts, list[int]]:
    """The control points (n, 4, 2) of all cubics without weights, and the curve of each (n,).

    They come in the order of the curves, those of a spline from its start to its end, and are the
    same numbers as `bezier_pieces` gives. The third value names the curves that are not cubics.
    """
    plain: list[int] = []
    splines: list[int] = []
    others: list[int] = []
    points: list[Sequence[Point]] = []
    for k, curve in enumerate(curves):
        piece = curve.as_bezier() if isinstance(curve, NewtonCurve) else curve
        if not isinstance(piece, Bezier | BSpline) or piece.weights or piece.degree != 3:
            others.append(k)
        elif isinstance(piece, BSpline):
            splines.append(k)
        else:
            plain.append(k)
            points.append(piece.points)
    control, owner = spline_cubics([curves[k] for k in splines])  # type: ignore[misc]
    control = np.concatenate((rows(chain.from_iterable(points), 8).reshape(-1, 4, 2), control))
    owners = np.concatenate((plain, np.array(splines, dtype=np.int64)[owner])).astype(np.int64)
    order = np.argsort(owners, kind="stable")
    return control[order], owners[order], others
