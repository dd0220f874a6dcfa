"""Polynomials of one variable on [0, 1], held by their Bernstein coefficients.

The Bernstein form is the one of Bezier curves. Its coefficients enclose the values, and the
number of their sign changes is at least the number of roots: that finds every root.
Source: Farouki, "The Bernstein polynomial basis: a centennial retrospective", 2012.
"""

import itertools
from collections.abc import Sequence
from math import comb

Coefficients = Sequence[float]

#: Width of an interval of the parameter that is given back as a root.
ROOT_WIDTH = 1e-14


def value(c: Coefficients, t: float) -> float:
    """The polynomial at `t`, by de Casteljau."""
    row = list(c)
    while len(row) > 1:
        row = [a + t * (b - a) for a, b in itertools.pairwise(row)]
    return row[0]


def halves(c: Coefficients, t: float) -> tuple[list[float], list[float]]:
    """The coefficients over [0, t] and over [t, 1]."""
    row = list(c)
    left, right = [row[0]], [row[-1]]
    while len(row) > 1:
        row = [a + t * (b - a) for a, b in itertools.pairwise(row)]
        left.append(row[0])
        right.append(row[-1])
    return left, right[::-1]


def derivative(c: Coefficients) -> list[float]:
    """The first derivative, one degree lower; [0] for a constant."""
    degree = len(c) - 1
    return [degree * (b - a) for a, b in itertools.pairwise(c)] or [0.0]


def product(a: Coefficients, b: Coefficients) -> list[float]:
    """The product; the degrees add."""
    m, n = len(a) - 1, len(b) - 1
    return [
        sum(
            comb(m, i) * comb(n, k - i) * a[i] * b[k - i]
            for i in range(max(0, k - n), min(m, k) + 1)
        )
        / comb(m + n, k)
        for k in range(m + n + 1)
    ]


def roots(c: Coefficients) -> list[float]:
    """Where the polynomial is zero inside (0, 1), ascending; none if it is zero everywhere."""
    scale = max(abs(v) for v in c)
    if scale == 0.0:
        return []
    clean = [0.0 if abs(v) <= 1e-15 * scale else v / scale for v in c]
    found: list[float] = []
    _collect_roots(clean, 0.0, 1.0, found)
    kept: list[float] = []
    for t in sorted(found):
        if 0.0 < t < 1.0 and (not kept or t - kept[-1] > 10 * ROOT_WIDTH):
            kept.append(t)
    return kept


def _collect_roots(c: Coefficients, low: float, high: float, found: list[float]) -> None:
    signs = [v > 0 for v in c if v != 0.0]
    changes = sum(a != b for a, b in itertools.pairwise(signs))
    if c[0] == 0.0:
        found.append(low)
    if c[-1] == 0.0:
        found.append(high)
    if changes == 0:
        return
    if changes == 1 and c[0] * c[-1] < 0.0:
        found.append(low + (high - low) * _bracketed_root(c))
    elif high - low <= ROOT_WIDTH:
        found.append((low + high) / 2)
    else:
        middle = (low + high) / 2
        left, right = halves(c, 0.5)
        _collect_roots(left, low, middle, found)
        _collect_roots(right, middle, high, found)


def _bracketed_root(c: Coefficients) -> float:
    """The one root of a polynomial whose ends differ in sign, by the Illinois rule."""
    a, b, fa, fb = 0.0, 1.0, c[0], c[-1]
    side = 0
    for _ in range(200):
        if b - a <= ROOT_WIDTH:
            break
        t = (a * fb - b * fa) / (fb - fa)
        if not a < t < b:
            t = (a + b) / 2
        ft = value(c, t)
        if ft == 0.0:
            return t
        if ft * fb > 0.0:
            b, fb = t, ft
            fa = fa / 2 if side == -1 else fa
            side = -1
        else:
            a, fa = t, ft
            fb = fb / 2 if side == 1 else fb
            side = 1
    return (a + b) / 2
