"""Cubic B-splines without weights, many at once, as cubics."""

from collections import defaultdict
from collections.abc import Sequence

import numpy as np

from beamcam.geometry.array_types import Counts, Floats
from beamcam.geometry.bspline import BSpline


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


def _numbers(splines: Sequence[BSpline]) -> tuple[Floats, Floats]:
    """The control points (n, size, 2) and the knots of splines of one size."""
    points = np.array([s.control for s in splines], dtype=np.float64)
    return points, np.array([s.knots for s in splines], dtype=np.float64)


def _of_one_size(splines: Sequence[BSpline], names: Sequence[int]) -> tuple[Floats, Counts]:
    """Span by span, all splines at once; `names` come back for the splines.

    Control point j of the span [a, b] is the blossom of (a, ..., b, ...) with b taken j times.
    """
    points, knots = _numbers(splines)
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
                _blossoms(points[some, k - 3 : k + 1], mine[:, k - 2 : k + 4], us)
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
        owner.append(np.array(names, dtype=np.int64)[some])
    return np.concatenate(found), np.concatenate(owner)


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
