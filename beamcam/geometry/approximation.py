"""Functions given as text, as polynomials that stay within a tolerance of them.

    y = f(x)           cubics through nodes on the graph, in Newton's form
    x = f(t), y = g(t) cubics through places of the way, in Bezier form

Each stretch is cut in halves until the measured distance is small enough.
"""

from collections.abc import Callable
from math import cos, hypot, isfinite, pi

from msgspec import Struct

from beamcam.conversion import compile_expression
from beamcam.geometry.curves import Bezier, Curve, Line
from beamcam.geometry.newton import NewtonCurve
from beamcam.geometry.plane import MAX_COORDINATE, Point

#: Nodes of each polynomial.
NODES = 4

#: Between two nodes the distance to the function is measured at so many places.
PROBES = 8

#: A stretch that is halved so often and is still off has a jump or a pole in it.
MAX_HALVINGS = 24


#: More curves than this are an oscillation that no machine cuts.
MOST_CURVES = 1000


class Approximation(Struct, frozen=True):
    """Consecutive curves, and their distance from the function that they approximate."""

    curves: tuple[Curve, ...]
    deviation: float  #: maximum measured distance


def curves_of_function(text: str, low: float, high: float, tolerance: float) -> Approximation:
    """The graph of y = `text`, a function of x, from x = `low` to x = `high`.

    Polynomials of degree three through nodes on the graph, cut in halves until the greatest
    distance in y, measured at `PROBES` places between neighbouring nodes, is at most half of
    `tolerance`. `low` may be above `high`: the graph then runs backwards.

    Raises ValueError where the text is not a function of x, has no value, or cannot be followed
    (a jump, a pole), with the x where that is.
    """
    y = _value_of(text, "x")
    return _followed(lambda x: (x, y(x)), low, high, tolerance, NewtonCurve, f"{text!r}", "x")


def curves_of_way(
    x_text: str, y_text: str, low: float, high: float, tolerance: float
) -> Approximation:
    """The way of the point (`x_text`, `y_text`), functions of t, from t = `low` to t = `high`.

    As `curves_of_function`, in cubic Bezier curves; the distance is that of the two places at the
    same t, which is no less than that of the curves.
    """
    x, y = _value_of(x_text, "t"), _value_of(y_text, "t")
    shown = f"({x_text!r}, {y_text!r})"
    return _followed(lambda t: (x(t), y(t)), low, high, tolerance, cubic_through, shown, "t")


def _value_of(text: str, name: str) -> Callable[[float], float]:
    """The function that `text` is of the variable `name`; it raises ValueError for no value."""
    expression = compile_expression(text, (name,))

    def value(at: float) -> float:
        try:
            number = expression({name: at})
        except (ArithmeticError, ValueError) as error:
            raise ValueError(f"{text!r} has no value at {name} = {at:g}: {error}") from error
        if not isfinite(number):
            raise ValueError(f"{text!r} has no value at {name} = {at:g}: {number}")
        if abs(number) > MAX_COORDINATE:
            raise ValueError(f"{text!r} is {number:g} at {name} = {at:g}, beyond every part")
        return number

    return value


def _followed(
    point: Callable[[float], Point], low: float, high: float, tolerance: float,
    shape: Callable[[tuple[Point, ...]], Curve], text: str, name: str,
) -> Approximation:  # fmt: skip
    if low == high or not (isfinite(low) and isfinite(high)):
        raise ValueError(f"a graph needs two different ends, found {low:g} and {high:g}")
    if not tolerance > 0.0:
        raise ValueError(f"tolerance must be above 0, found {tolerance:g}")
    pieces: list[tuple[Curve, float]] = []
    waiting = [(low, high, MAX_HALVINGS)]
    while waiting:
        low, high, halvings = waiting.pop()
        places = [low + (high - low) * k / (NODES - 1) for k in range(NODES - 1)] + [high]
        nodes = tuple(map(point, places))
        curve: Curve = Line(nodes[0], nodes[-1])
        off = _distance(point, curve, low, high)
        if off > tolerance / 2 * 1e-3:  # else a line is as good
            curve = shape(nodes)
            off = _distance(point, curve, low, high)
        if isinstance(curve, Line) and curve.start == curve.end:
            raise ValueError(f"{text} stands still near {name} = {low:g}; expected a way")
        if off <= tolerance / 2:
            pieces.append((curve, off))
        elif halvings == 0:
            raise ValueError(f"{text} jumps near {name} = {low:g}; expected a smooth function")
        else:
            middle = (low + high) / 2
            waiting += [(middle, high, halvings - 1), (low, middle, halvings - 1)]
        if len(pieces) > MOST_CURVES:
            raise ValueError(
                f"{text} takes more than {MOST_CURVES} curves up to {name} = {high:g}; "
                "expected fewer swings or a greater tolerance"
            )
    return Approximation(tuple(c for c, _ in pieces), max(d for _, d in pieces))


def _distance(point: Callable[[float], Point], curve: Curve, low: float, high: float) -> float:
    count = PROBES * (NODES - 1)
    # Chebyshev's places lie denser at the ends, where polynomials through nodes err most, and
    # on none of the nodes.
    shares = [(1 - cos(pi * (k + 0.5) / count)) / 2 for k in range(count)]
    worst = 0.0
    for t in shares:
        (x, y), (fx, fy) = curve.point(t), point(low + t * (high - low))
        worst = max(worst, hypot(x - fx, y - fy))
    return worst


def cubic_through(nodes: tuple[Point, ...]) -> Bezier:
    """The cubic that passes its four nodes at t = 0, 1/3, 2/3 and 1."""
    (ax, ay), (bx, by), (cx, cy), (dx, dy) = nodes

    def legs(a: float, b: float, c: float, d: float) -> tuple[float, float]:
        return (-5 * a + 18 * b - 9 * c + 2 * d) / 6, (2 * a - 9 * b + 18 * c - 5 * d) / 6

    (x1, x2), (y1, y2) = legs(ax, bx, cx, dx), legs(ay, by, cy, dy)
    return Bezier((nodes[0], (x1, y1), (x2, y2), nodes[3]))
