"""Lengths of Bezier curves, many of one degree at once, by Gauss-Legendre over arrays."""

from collections.abc import Sequence

import numpy as np

from beamcam.geometry.array_types import Floats

Homogeneous = tuple[float, float, float]  #: w x, w y, w

#: How far a length may be off, relative; the estimate is the gain of the last halving.
RELATIVE_ERROR = 1e-10
_MOST_HALVINGS = 24
_RULE = np.polynomial.legendre.leggauss(12)
#: Control points of all pieces together, beyond those given, that may be in the work at once: 30
#: MB. A curve that wants more swings beyond all measure, and keeps the error of its last halving.
_MOST_POINTS = 100_000


def bezier_length(curves: Sequence[Sequence[Homogeneous]]) -> float:
    """Summed length of Bezier curves of one degree, by Gauss-Legendre with 12 points.

    Each is given by its control points. A curve is halved until both halves together say the same
    as the whole: a smooth curve needs one halving, one with a cusp some twenty.
    """
    nodes, weights = _RULE
    rows = np.array(curves)  # (n, degree + 1, 3)
    most = len(rows) + _MOST_POINTS // rows.shape[1]
    with np.errstate(all="ignore"):
        whole = _gauss_lengths(rows, (nodes + 1) / 2, weights / 2)
        total = 0.0
        for _ in range(_MOST_HALVINGS):
            left, right = halved(rows)
            first = _gauss_lengths(left, (nodes + 1) / 2, weights / 2)
            second = _gauss_lengths(right, (nodes + 1) / 2, weights / 2)
            done = np.abs(first + second - whole) <= RELATIVE_ERROR * (first + second)
            total += float(np.sum((first + second)[done]))
            if done.all():
                return total
            rows = np.concatenate((left[~done], right[~done]))
            whole = np.concatenate((first[~done], second[~done]))
            if len(rows) > most:
                break
        return total + float(np.sum(whole))


def _gauss_lengths(rows: Floats, t: Floats, weights: Floats) -> Floats:
    """Length of each curve of `rows` (n, degree + 1, 3) by one rule: an array (n,)."""
    values = rows[:, :, :, None] * np.ones_like(t)
    degree = rows.shape[1] - 1
    while values.shape[1] > 2:
        values = (1 - t) * values[:, :-1] + t * values[:, 1:]
    slope = degree * (values[:, 1] - values[:, 0])
    value = (1 - t) * values[:, 0] + t * values[:, 1]
    w, dw = value[:, 2], slope[:, 2]
    dx = (slope[:, 0] - value[:, 0] / w * dw) / w
    dy = (slope[:, 1] - value[:, 1] / w * dw) / w
    lengths: Floats = np.hypot(dx, dy) @ weights
    return lengths


def halved(rows: Floats) -> tuple[Floats, Floats]:
    """Both halves of each curve, by de Casteljau."""
    left, right = np.empty_like(rows), np.empty_like(rows)
    row = rows
    for k in range(rows.shape[1]):
        left[:, k], right[:, -1 - k] = row[:, 0], row[:, -1]
        row = (row[:, :-1] + row[:, 1:]) / 2
    return left, right
