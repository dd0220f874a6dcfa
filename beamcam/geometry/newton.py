"""Polynomials through nodes, in Newton's form.

p(u) = c0 + c1 (u - u0) + c2 (u - u0)(u - u1) + ..., where c_k are the divided differences of
the nodes: any spacing is right, and the curve passes through every node, the last included.
"""

import itertools
from collections.abc import Sequence
from math import hypot

from msgspec import Struct

from beamcam.caches import cached
from beamcam.geometry import bezier
from beamcam.geometry.bezier import MAX_DEGREE, Bezier
from beamcam.geometry.plane import Box, Matrix, Point, box_around, distance, mapped

#: Polynomials through more nodes than this swing between them more often than not.
CALM_NODES = 5

#: Rounding has swallowed a polynomial long before; the work grows with the square of the nodes.
MOST_NODES = MAX_DEGREE + 1

#: A polynomial may leave the band between two nodes by this share of the extent of all of them.
CALM_SHARE = 0.25


def divided_differences(u: Sequence[float], values: Sequence[float]) -> tuple[float, ...]:
    """Newton's coefficients of the polynomial through (u, values). The `u` must all differ."""
    row = list(values)
    differences = [row[0]]
    for order in range(1, len(u)):
        row = [(b - a) / (u[i + order] - u[i]) for i, (a, b) in enumerate(itertools.pairwise(row))]
        differences.append(row[0])
    return tuple(differences)


def newton_derivatives(
    coefficients: Sequence[float], u: Sequence[float], at: float
) -> tuple[float, float]:
    """Value and first derivative at `at`, by Horner's scheme derived term by term."""
    value, first = coefficients[-1], 0.0
    for c, node in zip(coefficients[-2::-1], u[-2::-1], strict=True):
        step = at - node
        first = first * step + value
        value = value * step + c
    return value, first


class NewtonCurve(Struct, frozen=True):
    """The polynomial through two nodes or more.

    Where x rises (or falls) from node to node it is the function y = p(x) and t is the share of
    the way in x; else x and y are polynomials of the length of the chords between the nodes,
    and t is the share of their sum.
    """

    nodes: tuple[Point, ...]

    def __post_init__(self) -> None:
        if len(self.nodes) < 2:
            raise ValueError(f"a polynomial needs 2 nodes or more, found {len(self.nodes)}")
        for a, b in zip(self.nodes, self.nodes[1:], strict=False):
            if a == b:
                raise ValueError(f"node ({a[0]:g}, {a[1]:g}) is there twice in a row")

    @property
    def is_function(self) -> bool:
        """Whether x rises, or falls, from every node to the next."""
        steps = [b[0] - a[0] for a, b in zip(self.nodes, self.nodes[1:], strict=False)]
        return all(s > 0 for s in steps) or all(s < 0 for s in steps)

    @property
    def parameters(self) -> tuple[float, ...]:
        """The parameter t of each node, from 0 to 1."""
        return _newton_form(self)[0]

    @property
    def start(self) -> Point:
        return self.nodes[0]

    @property
    def end(self) -> Point:
        return self.nodes[-1]

    @property
    def length(self) -> float:
        return self.as_bezier().length

    @property
    def bbox(self) -> Box:
        """Least box around the curve."""
        return box_around([self.start, self.end, *(self.point(t) for t in self.extremes())])

    def point(self, t: float) -> Point:
        """The point at parameter `t`; the parameters of the nodes give the nodes exactly."""
        u, _, ys = _newton_form(self)
        if t in u:
            return self.nodes[u.index(t)]
        if self.is_function:
            (x0, _), (x1, _) = self.nodes[0], self.nodes[-1]
            return x0 + t * (x1 - x0), newton_derivatives(ys, u, t)[0]
        return self.derivatives(t)[0]

    def derivatives(self, t: float) -> tuple[Point, Point]:
        """The point and the first derivative at `t`."""
        u, xs, ys = _newton_form(self)
        x, y = newton_derivatives(xs, u, t), newton_derivatives(ys, u, t)
        return (x[0], y[0]), (x[1], y[1])

    def tangent(self, t: float) -> Point:
        """Direction of travel, length 1."""
        _, (x, y) = self.derivatives(t)
        size = hypot(x, y)
        return (x / size, y / size) if size else self.as_bezier().tangent(t)

    def extremes(self) -> tuple[float, ...]:
        """Parameters inside (0, 1) where x or y turns, ascending."""
        return self.as_bezier().extremes()

    def split(self, t: float) -> tuple[Bezier, Bezier]:
        """The parts before and after parameter `t`, in Bezier form."""
        return self.as_bezier().split(t)

    def reversed(self) -> "NewtonCurve":
        return NewtonCurve(self.nodes[::-1])

    def transformed(self, matrix: Matrix) -> "NewtonCurve | Bezier":
        """The image: a polynomial through the images of the nodes where that is the same curve
        (a function of x whose x stays free of y), else its Bezier form."""
        image = tuple(mapped(matrix, node) for node in self.nodes)
        if self.is_function and matrix[0][1] == 0.0 and matrix[0][0] != 0.0:
            return NewtonCurve(image)
        return self.as_bezier().transformed(matrix)

    def as_bezier(self) -> Bezier:
        """The same curve in Bezier form, exact but for rounding."""
        return _bezier_form(self)


def newton_through(nodes: tuple[Point, ...]) -> NewtonCurve:
    """The polynomial through `nodes`; ValueError where two of them are too near to differ, or
    where there are so many that no digit would be left of it."""
    if len(nodes) > MOST_NODES:
        raise ValueError(f"a polynomial has at most {MOST_NODES} nodes, found {len(nodes)}")
    curve = NewtonCurve(nodes)
    _newton_form(curve)
    return curve


@cached("curves.newton")
def _newton_form(
    curve: NewtonCurve,
) -> tuple[tuple[float, ...], tuple[float, ...], tuple[float, ...]]:
    """Parameters of the nodes in [0, 1], Newton's coefficients of x and of y."""
    nodes = curve.nodes
    if curve.is_function:
        along = [node[0] - nodes[0][0] for node in nodes]
    else:
        legs = (distance(a, b) for a, b in itertools.pairwise(nodes))
        along = list(itertools.accumulate(legs, initial=0.0))
    u = (*(a / along[-1] for a in along[:-1]), 1.0)
    for k, (here, there) in enumerate(itertools.pairwise(u)):
        if not here < there:
            x, y = nodes[k + 1]
            raise ValueError(f"node ({x:g}, {y:g}) is too near to the one before")
    xs = divided_differences(u, [node[0] for node in nodes])
    return u, xs, divided_differences(u, [node[1] for node in nodes])


@cached("curves.newton_bezier")
def _bezier_form(curve: NewtonCurve) -> Bezier:
    u, *coordinates = _newton_form(curve)
    rows = []
    for coefficients in coordinates:
        # Horner's scheme with the factors (t - u_k) = -u_k B0 + (1 - u_k) B1.
        total = [coefficients[-1]]
        for k in range(len(u) - 2, -1, -1):
            total = bezier.product(total, [-u[k], 1 - u[k]])
            total = [a + coefficients[k] for a in total]
        rows.append(total)
    if curve.is_function:
        (x0, _), (x1, _), n = curve.start, curve.end, len(u) - 1
        rows[0] = [x0 + i * (x1 - x0) / n for i in range(n + 1)]
    inner = list(zip(*rows, strict=True))[1:-1]
    return Bezier((curve.start, *inner, curve.end))


class Oscillation(Struct, frozen=True):
    """A polynomial that swings between its nodes."""

    nodes: int  #: number of nodes
    overshoot: float  #: how far it leaves the band between two neighbouring nodes, at most
    near: Point  #: where

    def __str__(self) -> str:
        return (
            f"the polynomial through {self.nodes} nodes leaves them by {self.overshoot:.3f} near "
            f"({self.near[0]:.3f}, {self.near[1]:.3f}); expected at most {CALM_NODES} nodes"
        )


def find_oscillation(curve: NewtonCurve) -> Oscillation | None:
    """The measured overshoot of a curve with more than five nodes that turns more often than its
    nodes do, or leaves them by more than `CALM_SHARE` of their extent; None if it is calm."""
    if len(curve.nodes) <= CALM_NODES:
        return None
    turns = [(t, curve.point(t)) for t in curve.extremes()]
    low_x, low_y, high_x, high_y = box_around(curve.nodes)
    size = max(high_x - low_x, high_y - low_y)
    overshoot, near, parameters = 0.0, curve.start, curve.parameters
    for t, point in turns:
        k = max(i for i, u in enumerate(parameters) if u <= t)
        for i in (0, 1):
            low, high = sorted((curve.nodes[k][i], curve.nodes[k + 1][i]))
            excess = max(low - point[i], point[i] - high)
            if excess > overshoot:
                overshoot, near = excess, point
    of_nodes = sum(_count_turns([node[i] for node in curve.nodes]) for i in (0, 1))
    least = 1e-9 if len(turns) > of_nodes else CALM_SHARE
    return Oscillation(len(curve.nodes), overshoot, near) if overshoot > least * size else None


def node_error(curve: NewtonCurve) -> float:
    """How far the curve misses its nodes by rounding: its Bezier form loses a digit a node or so,
    and what follows the curve follows that form."""
    form = curve.as_bezier()
    pairs = zip(curve.parameters, curve.nodes, strict=True)
    return max(distance(form.point(t), node) for t, node in pairs)


def _count_turns(values: Sequence[float]) -> int:
    steps = [b - a for a, b in itertools.pairwise(values) if b != a]
    return sum(a * b < 0 for a, b in itertools.pairwise(steps))
