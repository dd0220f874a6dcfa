"""Exact curves in the plane, B-splines (NURBS when they have weights) among them.

Every curve is an immutable record with `start`, `end`, `length`, `bbox`, `point(t)`,
`tangent(t)` and `split(t)` for t in [0, 1], `reversed()` and `transformed(matrix)`. Nothing here
needs numpy; many points at once are `sampling`'s.
"""

from bisect import bisect_left, bisect_right
from collections.abc import Sequence
from itertools import pairwise
from math import atan2, degrees, dist

from msgspec import Struct

from beamcam.caches import cached
from beamcam.geometry.bezier import (
    MAX_DEGREE,
    Bezier,
    Homogeneous,
    check_weights,
    from_homogeneous,
    homogeneous,
)
from beamcam.geometry.conics import Arc, EllipseArc, Line, arc_through, segment_area
from beamcam.geometry.newton import NewtonCurve
from beamcam.geometry.plane import (
    Box,
    Matrix,
    Point,
    cross,
    integrate,
    join_boxes,
    mapped,
    unit_vector,
)

#: Taking a spline apart takes (degree + 1)^3 steps a control point, a second for so many.
MAX_STEPS = 1_000_000
MIN_SPAN = 1e-30  #: between knots that are not one; derivatives divide by its third power


class BSpline(Struct, frozen=True, gc=False):
    """A spline; it is drawn from knot number `degree` to the last but `degree`.

    The parameter t in [0, 1] of all methods is the share of that range of knots.
    """

    degree: int
    control: tuple[Point, ...]
    knots: tuple[float, ...]  #: ascending, as many as control points + degree + 1
    weights: tuple[float, ...] | None = None  #: one above 0 for each point; None is all 1

    def __post_init__(self) -> None:
        expected = len(self.control) + self.degree + 1
        if self.degree < 1:
            raise ValueError(f"a spline has degree 1 or more, found {self.degree}")
        if self.degree > MAX_DEGREE:
            raise ValueError(f"a spline has degree {MAX_DEGREE} at most, found {self.degree}")
        if len(self.control) > (most := MAX_STEPS // (self.degree + 1) ** 3):
            raise ValueError(
                f"a spline of degree {self.degree} has at most {most} control points, "
                f"found {len(self.control)}"
            )
        if len(self.control) <= self.degree:
            raise ValueError(
                f"a spline of degree {self.degree} needs {self.degree + 1} control points "
                f"or more, found {len(self.control)}"
            )
        if len(self.knots) != expected:
            raise ValueError(f"expected {expected} knots, found {len(self.knots)}")
        if any(b < a for a, b in pairwise(self.knots)):
            raise ValueError("the knots of a spline must not fall")
        if any(0.0 < b - a < MIN_SPAN for a, b in pairwise(self.knots)):
            raise ValueError(f"two knots of a spline differ by less than {MIN_SPAN:g}")
        low, high = self.knots[self.degree], self.knots[len(self.control)]
        if not low < high:
            raise ValueError(f"the knots of a spline span nothing: {low:g} to {high:g}")
        if any(a == b for a, b in zip(self.knots, self.knots[self.degree + 1 :], strict=False)):
            raise ValueError(
                f"a knot of a spline of degree {self.degree} is there {self.degree + 1} times at "
                "most: of one that is there more often not all control points count"
            )
        inner = [k for k in self.knots if low < k < high]
        # They do not fall, so that equal ones stand side by side.
        if any(a == b for a, b in zip(inner, inner[self.degree :], strict=False)):
            raise ValueError(f"a knot inside a spline of degree {self.degree} is there too often")
        if self.weights is not None:
            check_weights(self.weights, len(self.control))

    @property
    def start(self) -> Point:
        degree, knots = self.degree, self.knots
        if knots[1] == knots[degree]:
            return self.control[0]
        first = next(k for k in range(degree, len(self.control)) if knots[k] < knots[k + 1])
        return self._at_knot(first, knots[first])

    @property
    def end(self) -> Point:
        degree, knots, count = self.degree, self.knots, len(self.control)
        if knots[-2] == knots[count]:
            return self.control[-1]
        last = next(k for k in range(count - 1, degree - 1, -1) if knots[k] < knots[k + 1])
        return self._at_knot(last, knots[last + 1])

    def _at_knot(self, span: int, knot: float) -> Point:
        """The point at an end of a span of knots: the same numbers as its piece has there."""
        row = homogeneous(self.control, self.weights)[span - self.degree : span + 1]
        x, y, w = _blossom(row, self.knots, span, [knot] * self.degree)
        return x / w, y / w

    @property
    def length(self) -> float:
        return sum(piece.length for piece in self.pieces())

    @property
    def bbox(self) -> Box:
        """The smallest box around the curve."""
        box = join_boxes([piece.bbox for piece in self.pieces()])
        assert box is not None
        return box

    def pieces(self) -> tuple[Bezier, ...]:
        """The spline as Bezier curves, one for each span of knots; neighbours share ends."""
        return _decomposed(self)[0]

    def breaks(self) -> tuple[float, ...]:
        """Parameters in [0, 1] where one piece ends and the next begins, both ends included."""
        return _decomposed(self)[1]

    def _locate(self, t: float) -> tuple[Bezier, float]:
        pieces, breaks = _decomposed(self)
        k = min(max(bisect_right(breaks, t) - 1, 0), len(pieces) - 1)
        return pieces[k], (t - breaks[k]) / (breaks[k + 1] - breaks[k])

    def point(self, t: float) -> Point:
        """The point at parameter `t`; 0 and 1 give the ends exactly."""
        piece, local = self._locate(t)
        return piece.point(local)

    def tangent(self, t: float) -> Point:
        """Direction of travel, length 1; at a knot with a corner, that of the next piece."""
        piece, local = self._locate(t)
        return piece.tangent(local)

    def split(self, t: float) -> "tuple[BSpline, BSpline]":
        """The parts before and after parameter `t`; they share the point there.

        de Boor's algorithm makes that point; the sides of its triangle are the control points next
        to it. Raises ValueError at the ends: a spline cannot be a point.
        """
        if not 0.0 < t < 1.0:
            raise ValueError(f"a spline is split inside (0, 1), not at {t:g}")
        degree, knots = self.degree, self.knots
        points = homogeneous(self.control, self.weights)
        low, high = knots[degree], knots[len(points)]
        u = next((k for k in knots if (k - low) / (high - low) == t), low + t * (high - low))
        span = bisect_right(knots, u) - 1
        row = list(points[span - degree : span + 1])
        before, behind = [*points[: span - degree], row[0]], [row[-1], *points[span + 1 :]]
        for r in range(1, degree + 1):
            row = [
                _between(row[i], row[i + 1], u, knots[span - degree + i + r], knots[span + 1 + i])
                for i in range(degree + 1 - r)
            ]
            before.append(row[0])
            behind.insert(0, row[-1])
        ends = [u] * (degree + 1)
        first = [*knots[: bisect_left(knots, u)], *ends]
        # Where `u` is a knot, the last of the points before it are one.
        return (
            _spline(degree, before[: len(first) - degree - 1], first),
            _spline(degree, behind, [*ends, *knots[span + 1 :]]),
        )

    def reversed(self) -> "BSpline":
        both = self.knots[0] + self.knots[-1]
        return BSpline(
            self.degree,
            self.control[::-1],
            tuple(both - k for k in self.knots[::-1]),
            self.weights and self.weights[::-1],
        )

    def transformed(self, matrix: Matrix) -> "BSpline":
        points = tuple(mapped(matrix, p) for p in self.control)
        return BSpline(self.degree, points, self.knots, self.weights)


@cached("curves.spline")
def _decomposed(spline: BSpline) -> tuple[tuple[Bezier, ...], tuple[float, ...]]:
    """The Bezier curves of a spline and the parameters between them.

    Control point j of the span [a, b] is the blossom of the spline with b taken j times and a
    for the rest. Source: Ramshaw, "Blossoms are polar forms", 1989.
    """
    degree, knots = spline.degree, spline.knots
    points = homogeneous(spline.control, spline.weights)
    low, high = knots[degree], knots[len(points)]
    pieces: list[Bezier] = []
    breaks = [0.0]
    polars: tuple[Homogeneous, ...] = ()
    for k in range(degree, len(points)):
        a, b = knots[k], knots[k + 1]
        if a == b:
            continue
        row = points[k - degree : k + 1]
        first = polars[-1] if polars else _blossom(row, knots, k, [a] * degree)
        polars = (
            first,
            *(_blossom(row, knots, k, [a] * (degree - j) + [b] * j) for j in range(1, degree + 1)),
        )
        pieces.append(from_homogeneous(polars))
        breaks.append((b - low) / (high - low))
    breaks[-1] = 1.0
    # A clamped spline begins and ends on its control points, to the last bit.
    if knots[1] == low:
        pieces[0] = Bezier((spline.control[0], *pieces[0].points[1:]), pieces[0].weights)
    if knots[-2] == high:
        pieces[-1] = Bezier((*pieces[-1].points[:-1], spline.control[-1]), pieces[-1].weights)
    return tuple(pieces), tuple(breaks)


def _blossom(
    points: Sequence[Homogeneous], knots: tuple[float, ...], k: int, arguments: list[float]
) -> Homogeneous:
    """The blossom in span `k`, whose control points are given."""
    degree = len(arguments)
    row = list(points)
    for r, u in enumerate(arguments, start=1):
        for i in range(degree, r - 1, -1):
            low, high = knots[k - degree + i], knots[k + 1 + i - r]
            row[i] = _between(row[i - 1], row[i], u, low, high)
    return row[degree]


def _between(a: Homogeneous, b: Homogeneous, u: float, low: float, high: float) -> Homogeneous:
    """The place of `u` between two points, of which one is at `low` and the other at `high`."""
    share = (u - low) / (high - low)
    (x0, y0, w0), (x1, y1, w1) = a, b
    return x0 + share * (x1 - x0), y0 + share * (y1 - y0), w0 + share * (w1 - w0)


def _spline(degree: int, points: Sequence[Homogeneous], knots: Sequence[float]) -> BSpline:
    weights = tuple([w for _, _, w in points])
    plain = all(w == 1.0 for w in weights)
    control = tuple([(x / w, y / w) for x, y, w in points])
    return BSpline(degree, control, tuple(knots), None if plain else weights)


Curve = Line | Arc | EllipseArc | Bezier | BSpline | NewtonCurve

__all__ = [
    "Arc", "BSpline", "Bezier", "Box", "Curve", "EllipseArc", "Line", "Matrix", "NewtonCurve",
    "Point", "arc_through", "bezier_pieces", "circle_of", "join_boxes", "signed_area", "slot_of",
    "unit_vector",
]  # fmt: skip


def bezier_pieces(curve: Bezier | BSpline | NewtonCurve) -> tuple[Bezier, ...]:
    """A free curve as Bezier curves that follow one another."""
    match curve:
        case Bezier():
            return (curve,)
        case BSpline():
            return curve.pieces()
        case NewtonCurve():
            return (curve.as_bezier(),)


SAME = 1e-6  #: mm and degrees between what is one


def circle_of(
    curves: Sequence[Curve], off: float = SAME, off_deg: float = SAME
) -> tuple[Point, float] | None:
    """Centre and radius of a chain that is a whole circle, within some mm and degrees."""
    if not curves or not all(isinstance(curve, Arc) for curve in curves):
        return None
    arcs = [curve for curve in curves if isinstance(curve, Arc)]
    first = arcs[0]
    same = all(
        dist(a.centre, first.centre) < off and abs(a.radius - first.radius) < off for a in arcs
    )
    is_whole = abs(abs(sum(a.sweep_deg for a in arcs)) - 360.0) < off_deg
    return (first.centre, first.radius) if same and is_whole else None


def slot_of(
    curves: Sequence[Curve], off: float = SAME, off_deg: float = SAME
) -> tuple[Point, float, float, float] | None:
    """Middle, length, width and angle in degrees of a chain of two lines and two half circles."""
    lines = [curve for curve in curves if isinstance(curve, Line)]
    ends = [curve for curve in curves if isinstance(curve, Arc)]
    if not len(lines) == len(ends) == 2 or len(curves) != 4:
        return None
    (x0, y0), (x1, y1) = (end.centre for end in ends)
    apart, radius = dist(ends[0].centre, ends[1].centre), ends[0].radius
    alike = all(
        abs(end.radius - radius) < off and abs(abs(end.sweep_deg) - 180.0) < off_deg for end in ends
    )
    if not alike or any(abs(line.length - apart) > off for line in lines):
        return None
    angle = degrees(atan2(y1 - y0, x1 - x0)) % 180.0
    return ((x0 + x1) / 2, (y0 + y1) / 2), apart + 2 * radius, 2 * radius, angle


def signed_area(curves: tuple[Curve, ...]) -> float:
    """Area inside a closed chain of curves in mm2, positive if it runs counter-clockwise.

    Green's theorem: the polygon of the ends, plus the area between each curve and its chord.
    """
    total = 0.0
    for curve in curves:
        total += cross(curve.start, curve.end) / 2
        match curve:
            case Line():
                pass
            case Arc():
                total += segment_area(curve.sweep_deg, curve.radius, curve.radius)
            case EllipseArc():
                total += segment_area(curve.sweep_deg, curve.major, curve.minor)
            case _:
                total += sum(_area_beside_chord(piece) for piece in bezier_pieces(curve))
                points = [piece.start for piece in bezier_pieces(curve)]
                ends = zip(points, [*points[1:], curve.end], strict=True)
                total += sum(cross(a, b) for a, b in ends) / 2 - cross(curve.start, curve.end) / 2
    return total


def _area_beside_chord(curve: Bezier) -> float:
    """Half of the integral of r x r' about the start of the curve, less the chord's share (0)."""
    x0, y0 = curve.start

    def swept(t: float) -> float:
        (x, y), velocity, _ = curve.derivatives(t)
        return cross((x - x0, y - y0), velocity)

    reach = max(abs(x - x0) + abs(y - y0) for x, y in curve.points)
    return integrate(swept, floor=1e-13 * (reach + abs(x0) + abs(y0)) * reach) / 2


HALVINGS = 40


def parameter_at(curve: Curve, length: float) -> float:
    """The parameter of the place so far along a curve, by bisection where its speed is uneven."""
    if isinstance(curve, Line | Arc):
        return length / curve.length
    low, high = 0.0, 1.0
    for _ in range(HALVINGS):
        middle = (low + high) / 2
        if curve.split(middle)[0].length < length:
            low = middle
        else:
            high = middle
    return (low + high) / 2
