"""Functions given as text, as polynomials that stay within a tolerance of them."""

from collections.abc import Callable
from math import cos, isfinite, pi

from msgspec import Struct

from beamcam.geometry.curves import Bezier, Curve, Line
from beamcam.geometry.expression import compile_expression
from beamcam.geometry.newton import NewtonCurve

#: Nodes of each polynomial.
NODES = 4

#: Between two nodes the distance to the function is measured at so many places.
PROBES = 8

#: A stretch that is halved so often and is still off has a jump or a pole in it.
MAX_HALVINGS = 24


class Fit(Struct, frozen=True):
    """Curves that follow one another, and how far they are from what they stand for."""

    curves: tuple[Curve, ...]
    deviation: float  #: greatest distance that was measured


def curves_of_function(text: str, low: float, high: float, tolerance: float) -> Fit:
    """The graph of y = `text`, a function of x, from x = `low` to x = `high`.

    Polynomials of degree three through nodes on the graph, cut in halves until the greatest
    distance in y, measured at `PROBES` places between neighbouring nodes, is at most half of
    `tolerance`. `low` may be above `high`: the graph then runs backwards.

    Raises ValueError where the text is no function of x, has no value, or cannot be followed
    (a jump, a pole), with the x where that is.
    """
    if low == high or not (isfinite(low) and isfinite(high)):
        raise ValueError(f"a graph needs two different ends, found {low:g} and {high:g}")
    if not tolerance > 0.0:
        raise ValueError(f"tolerance must be above 0, found {tolerance:g}")
    expression = compile_expression(text, ("x",))

    def value(x: float) -> float:
        try:
            y = expression({"x": x})
        except (ArithmeticError, ValueError) as error:
            raise ValueError(f"{text!r} has no value at x = {x:g}: {error}") from error
        if not isfinite(y):
            raise ValueError(f"{text!r} has no value at x = {x:g}: {y}")
        return y

    pieces: list[tuple[Curve, float]] = []
    _follow(value, low, high, tolerance / 2, pieces, MAX_HALVINGS, text)
    return Fit(tuple(c for c, _ in pieces), max(d for _, d in pieces))


def _follow(
    value: Callable[[float], float],
    low: float,
    high: float,
    tolerance: float,
    pieces: list[tuple[Curve, float]],
    halvings: int,
    text: str,
) -> None:
    xs = [low + (high - low) * k / (NODES - 1) for k in range(NODES - 1)] + [high]
    nodes = tuple((x, value(x)) for x in xs)
    curve: Curve = Line(nodes[0], nodes[-1])
    off = _distance(value, curve, low, high)
    if off > tolerance * 1e-3:
        curve = NewtonCurve(nodes)
        off = _distance(value, curve, low, high)
    if off <= tolerance:
        pieces.append((curve, off))
        return
    if halvings == 0:
        raise ValueError(f"{text!r} jumps near x = {low:g}; expected a smooth function")
    middle = (low + high) / 2
    _follow(value, low, middle, tolerance, pieces, halvings - 1, text)
    _follow(value, middle, high, tolerance, pieces, halvings - 1, text)


def _distance(value: Callable[[float], float], curve: Curve, low: float, high: float) -> float:
    count = PROBES * (NODES - 1)
    # Chebyshev's places lie denser at the ends, where polynomials through nodes err most, and
    # on none of the nodes.
    shares = [(1 - cos(pi * (k + 0.5) / count)) / 2 for k in range(count)]
    return max(abs(curve.point(t)[1] - value(low + t * (high - low))) for t in shares)


def bezier_of_monomial(coefficients: tuple[float, ...], low: float, high: float) -> Bezier:
    """y = a0 + a1 x + a2 x^2 + ... between two x, exactly, in Bezier form."""
    degree = max(len(coefficients) - 1, 1)
    xs = [low + (high - low) * k / degree for k in range(degree)] + [high]

    def value(x: float) -> float:
        total = 0.0
        for a in reversed(coefficients):
            total = total * x + a
        return total

    return NewtonCurve(tuple((x, value(x)) for x in xs)).as_bezier()
