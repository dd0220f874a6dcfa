"""Bezier curves of any degree, with weights or without."""

import itertools
from collections.abc import Sequence
from math import comb, hypot, inf

from msgspec import Struct

from beamcam.caches import cached
from beamcam.geometry.plane import Box, Matrix, Point, box_around, cross, mapped, normalized

# --- bernstein ------------------------------------------------------------------------------------

# Polynomials of one variable on [0, 1], held by their Bernstein coefficients.
#
# The Bernstein form is the one of Bezier curves. Its coefficients enclose the values, and the
# number of their sign changes is at least the number of roots: that finds every root.
# Source: Farouki, "The Bernstein polynomial basis: a centennial retrospective", 2012.


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
    parameters: list[float] = []
    _collect_roots(clean, 0.0, 1.0, parameters)
    kept: list[float] = []
    for t in sorted(parameters):
        if 0.0 < t < 1.0 and (not kept or t - kept[-1] > 10 * ROOT_WIDTH):
            kept.append(t)
    return kept


def _collect_roots(c: Coefficients, low: float, high: float, parameters: list[float]) -> None:
    signs = [v > 0 for v in c if v != 0.0]
    changes = sum(a != b for a, b in itertools.pairwise(signs))
    if c[0] == 0.0:
        parameters.append(low)
    if c[-1] == 0.0:
        parameters.append(high)
    if changes == 0:
        return
    if changes == 1 and c[0] * c[-1] < 0.0:
        parameters.append(low + (high - low) * _bracketed_root(c))
    elif high - low <= ROOT_WIDTH:
        parameters.append((low + high) / 2)
    else:
        middle = (low + high) / 2
        left, right = halves(c, 0.5)
        _collect_roots(left, low, middle, parameters)
        _collect_roots(right, middle, high, parameters)


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


#: No CAD program writes more (ACIS and Parasolid stop there); a point takes degree^2 steps.
MAX_DEGREE = 25

Homogeneous = tuple[float, float, float]  #: (w x, w y, w)


class Bezier(Struct, frozen=True, gc=False):
    """A curve in Bernstein form: one point is not a curve, two are a line, four a cubic."""

    points: tuple[Point, ...]
    weights: tuple[float, ...] | None = None  #: one above 0 for each point; None is all 1

    def __post_init__(self) -> None:
        if len(self.points) < 2:
            raise ValueError(f"a Bezier curve needs 2 points or more, found {len(self.points)}")
        if len(self.points) > MAX_DEGREE + 1:
            raise ValueError(
                f"a Bezier curve has degree {MAX_DEGREE} at most, found {len(self.points) - 1}"
            )
        if self.weights is not None:
            check_weights(self.weights, len(self.points))

    @property
    def degree(self) -> int:
        return len(self.points) - 1

    @property
    def start(self) -> Point:
        return self.points[0]

    @property
    def end(self) -> Point:
        return self.points[-1]

    @property
    def homogeneous(self) -> tuple[Homogeneous, ...]:
        """Points as (w x, w y, w)."""
        return homogeneous(self.points, self.weights)

    @property
    def length(self) -> float:
        """Length by numerical integration, to about 1e-10 relative."""
        from beamcam.geometry.free_lengths import bezier_length

        return bezier_length((self.homogeneous,))

    @property
    def bbox(self) -> Box:
        """Least box around the curve."""
        return box_around([self.start, self.end, *(self.point(t) for t in self.extremes())])

    def point(self, t: float) -> Point:
        """The point at parameter `t`; 0 and 1 give the ends exactly."""
        if t == 0.0:
            return self.start
        if t == 1.0:
            return self.end
        x, y, w = (value(c, t) for c in zip(*self.homogeneous, strict=True))
        return x / w, y / w

    def derivatives(self, t: float) -> tuple[Point, Point, Point]:
        """The point, the first and the second derivative at `t`."""
        rows = [list(c) for c in zip(*self.homogeneous, strict=True)]
        firsts = [derivative(c) for c in rows]
        x, y, w = (value(c, t) for c in rows)
        dx, dy, dw = (value(c, t) for c in firsts)
        ddx, ddy, ddw = (value(derivative(c), t) for c in firsts)
        px, py = x / w, y / w
        vx, vy = (dx - px * dw) / w, (dy - py * dw) / w
        ax = (ddx - 2 * vx * dw - px * ddw) / w
        ay = (ddy - 2 * vy * dw - py * ddw) / w
        return (px, py), (vx, vy), (ax, ay)

    def tangent(self, t: float) -> Point:
        """Direction of travel, length 1; where the curve stands still, its limit.

        Raises ValueError if all points are one.
        """
        velocity = self.derivatives(t)[1]
        box = box_around(self.points)
        size = max(box[2] - box[0], box[3] - box[1])
        if hypot(*velocity) > 1e-12 * size:
            return normalized(velocity)
        # The curve stands still: the next control point that is another one gives the limit.
        ahead = self.split(t)[1] if 0.0 < t < 1.0 else self if t <= 0.0 else self.reversed()
        sign = -1.0 if t >= 1.0 else 1.0
        for x, y in ahead.points[1:]:
            step = (x - ahead.start[0], y - ahead.start[1])
            if hypot(*step) > 1e-9 * size:
                return normalized((sign * step[0], sign * step[1]))
        raise ValueError("a curve whose points are one has no direction")

    def curvature(self, t: float) -> float:
        """Signed curvature, positive to the left; inf where the curve stands still."""
        _, velocity, acceleration = self.derivatives(t)
        speed = hypot(*velocity)
        return cross(velocity, acceleration) / speed**3 if speed else inf

    def extremes(self) -> tuple[float, ...]:
        """Parameters inside (0, 1) where x or y turns, ascending."""
        return _extremes(self)

    def split(self, t: float) -> "tuple[Bezier, Bezier]":
        """The parts before and after parameter `t`; they share the point there."""
        sides = [halves(c, t) for c in zip(*self.homogeneous, strict=True)]
        left = from_homogeneous(tuple(zip(*(side[0] for side in sides), strict=True)))
        right = from_homogeneous(tuple(zip(*(side[1] for side in sides), strict=True)))
        middle = left.end
        return (
            Bezier((self.start, *left.points[1:-1], middle), left.weights),
            Bezier((middle, *right.points[1:-1], self.end), right.weights),
        )

    def reversed(self) -> "Bezier":
        return Bezier(self.points[::-1], self.weights and self.weights[::-1])

    def transformed(self, matrix: Matrix) -> "Bezier":
        return Bezier(tuple(mapped(matrix, p) for p in self.points), self.weights)


@cached("curves.extremes")
def _extremes(curve: Bezier) -> tuple[float, ...]:
    x, y, w = (list(c) for c in zip(*curve.homogeneous, strict=True))
    values: set[float] = set()
    for c in (x, y):
        slope = derivative(c)
        if curve.weights is not None:
            # (c / w)' = 0 where c' w - c w' is 0.
            down = product(c, derivative(w))
            up = product(slope, w)
            slope = [a - b for a, b in zip(up, down, strict=True)]
        values.update(roots(slope))
    return tuple(sorted(values))


def homogeneous(
    points: tuple[Point, ...], weights: tuple[float, ...] | None
) -> tuple[Homogeneous, ...]:
    """Points as (w x, w y, w); without weights each is 1."""
    weights = weights or (1.0,) * len(points)
    return tuple((w * x, w * y, w) for (x, y), w in zip(points, weights, strict=True))


def from_homogeneous(points: tuple[Homogeneous, ...]) -> Bezier:
    """The Bezier curve of points (w x, w y, w)."""
    weights = tuple(w for _, _, w in points)
    plain = all(w == 1.0 for w in weights)
    return Bezier(tuple((x / w, y / w) for x, y, w in points), None if plain else weights)


def check_weights(weights: tuple[float, ...], count: int) -> None:
    """Raises ValueError unless there are `count` weights, all above 0."""
    if len(weights) != count:
        raise ValueError(f"expected {count} weights, one for each point, found {len(weights)}")
    if not min(weights) > 0.0:
        raise ValueError(f"weights must be above 0, found {min(weights):g}")
