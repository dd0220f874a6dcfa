"""Circles that touch two curves and have a radius, or that touch three.

A line stands here for all of it, beyond its ends, and an arc for its whole circle. A circle of
radius r about c touches

    a line n.c = d         where n.c - d = s r           s = +1 left of it, -1 right of it
    a circle (p, R)        where |c - p| = |R + s r|     s = +1 outside, -1 within or around it

so that two curves and r leave the crossings of two lines or circles for each pair of signs. With r
unknown, a circle's condition is |c|^2 - r^2 - 2 p.c - 2 s R r + |p|^2 - R^2 = 0: the difference
of two of them is linear in x, y and r. Three curves so leave two planes, whose line meets the
third condition at most twice (problem of Apollonius: at most eight circles). The planes coincide
where the three curves touch each other at one point, and only there.
"""

from collections.abc import Iterator, Sequence
from itertools import combinations, product
from math import hypot, inf, sqrt

from msgspec import Struct

from beamcam.geometry.conics import Arc, Line
from beamcam.geometry.plane import Point, box_around, cross, distance, dot, normalized

#: Of the size of the figure: lengths that differ by less are one, and a circle touches within it.
NEAR = 1e-9
#: Of a condition's terms: two roots so near to each other are one, as 1e-9 of a length is.
DOUBLE = 1e-12
MAX_RADIUS = 1e6  #: in sizes of the figure; a circle beyond is a straight line to its numbers


class Circle(Struct, frozen=True):
    """A whole circle."""

    centre: Point
    radius: float


class _Straight(Struct, frozen=True):
    """The points p with n.p = d, n the normal to the left."""

    normal: Point
    offset: float


_Carrier = _Straight | Circle
_Row = tuple[float, float, float, float, float]  #: of k (x^2 + y^2 - r^2) + a x + b y + c r + e


class NoTangentCircle(ValueError):
    """No circle, or endlessly many; the text says which case it is."""


def tangent_circles(
    curves: Sequence[Line | Arc], radius: float | None = None
) -> tuple[Circle, ...]:
    """All circles that touch two curves and have `radius`, or that touch three curves.

    They stand from left to right, then upward, the smaller first. Each touches within `NEAR` of
    the size of the figure. A circle that is one of the curves touches nothing and is left out.

    Raises NoTangentCircle (a ValueError) if there is none or no end of them.
    """
    expected = 3 if radius is None else 2
    if len(curves) != expected:
        with_ = "without a radius" if radius is None else "with a radius"
        raise NoTangentCircle(f"{len(curves)} curves {with_}, where there have to be {expected}")
    points: list[Point] = []
    for curve in curves:
        if isinstance(curve, Line):
            points += (curve.start, curve.end)
        else:
            (x, y), r = curve.centre, curve.radius
            points += ((x - r, y - r), (x + r, y + r))
    x0, y0, x1, y1 = box_around(points)
    middle, size = ((x0 + x1) / 2, (y0 + y1) / 2), max(x1 - x0, y1 - y0, radius or 0.0)
    if size == 0.0:
        raise NoTangentCircle("curves without a length")
    carriers = [_carrier(curve, middle, size) for curve in curves]
    for a, b in combinations(carriers, 2):
        if isinstance(a, _Straight) and isinstance(b, _Straight):
            if _parallel(a, b) and abs(_gap(a, b)) <= NEAR:
                raise NoTangentCircle("the same line twice, which endlessly many circles touch")
        elif _same(a, b):
            raise NoTangentCircle("the same circle twice, which endlessly many circles touch")
    if radius is None:
        circles = list(_of_three(carriers))
    else:
        circles = list(_of_two(carriers[0], carriers[1], radius / size))
    kept: list[Circle] = []
    for circle in circles:
        slack = NEAR * max(1.0, circle.radius)
        if (
            NEAR < circle.radius < MAX_RADIUS
            and not any(_same(circle, c) for c in carriers)
            and not any(_same(circle, one, slack) for one in kept)
        ):
            kept.append(circle)
    if not kept:
        raise NoTangentCircle(_why_none(carriers, radius))
    x, y = middle
    whole = (
        Circle((x + size * c.centre[0], y + size * c.centre[1]), radius or size * c.radius)
        for c in kept
    )
    return tuple(sorted(whole, key=lambda circle: (*circle.centre, circle.radius)))


def nearest_circle(circles: Sequence[Circle], point: Point) -> Circle | None:
    """The circle whose centre is nearest to a point; None if that is true of two."""
    ranked = sorted(circles, key=lambda circle: distance(circle.centre, point))
    if len(ranked) > 1:
        first, second = (distance(circle.centre, point) for circle in ranked[:2])
        if second - first <= NEAR * max(second, ranked[0].radius, ranked[1].radius):
            return None
    return ranked[0]


def _carrier(curve: Line | Arc, middle: Point, size: float) -> _Carrier:
    """The whole line or circle of a curve, moved to the middle and brought to size 1."""

    def at(point: Point) -> Point:
        return (point[0] - middle[0]) / size, (point[1] - middle[1]) / size

    if isinstance(curve, Arc):
        return Circle(at(curve.centre), curve.radius / size)
    start, end = at(curve.start), at(curve.end)
    if distance(start, end) <= NEAR:
        raise NoTangentCircle("a line without a length")
    x, y = normalized((end[0] - start[0], end[1] - start[1]))
    normal = (-y, x)
    return _Straight(normal, (dot(normal, start) + dot(normal, end)) / 2)


def _same(a: _Carrier, b: _Carrier, slack: float = NEAR) -> bool:
    if isinstance(a, _Straight) or isinstance(b, _Straight):
        return False
    return distance(a.centre, b.centre) <= slack and abs(a.radius - b.radius) <= slack


def _parallel(a: _Straight, b: _Straight) -> bool:
    return abs(cross(a.normal, b.normal)) <= NEAR


def _gap(a: _Straight, b: _Straight) -> float:
    """Distance of two parallel lines, with a sign."""
    return a.offset - (b.offset if dot(a.normal, b.normal) > 0 else -b.offset)


def _concentric(a: _Carrier, b: _Carrier) -> bool:
    return isinstance(a, Circle) and isinstance(b, Circle) and distance(a.centre, b.centre) <= NEAR


# --- two curves and a radius ----------------------------------------------------------------------


def _of_two(a: _Carrier, b: _Carrier, radius: float) -> Iterator[Circle]:
    """Raises NoTangentCircle where circles of that radius roll between two curves."""
    if isinstance(a, _Straight) and isinstance(b, _Straight):
        if _parallel(a, b) and abs(abs(_gap(a, b)) - 2 * radius) <= NEAR:
            raise NoTangentCircle("parallel lines a diameter apart, with endlessly many circles")
    elif isinstance(a, Circle) and isinstance(b, Circle) and _concentric(a, b):
        for reach in (abs(a.radius - b.radius), a.radius + b.radius):
            if abs(reach - 2 * radius) <= NEAR:
                raise NoTangentCircle("concentric circles with endlessly many between them")
    for s, t in product((1.0, -1.0), repeat=2):
        for centre in _crossings(_beside(a, s * radius), _beside(b, t * radius)):
            yield Circle(centre, radius)


def _beside(carrier: _Carrier, by: float) -> _Carrier:
    """Where the centres of circles lie that touch it, `by` their radius with its sign."""
    if isinstance(carrier, _Straight):
        return _Straight(carrier.normal, carrier.offset + by)
    return Circle(carrier.centre, abs(carrier.radius + by))


def _crossings(a: _Carrier, b: _Carrier) -> tuple[Point, ...]:
    """The points that lie on both, one where they touch."""
    if isinstance(a, _Straight) and isinstance(b, _Straight):
        if _parallel(a, b):
            return ()
        area = cross(a.normal, b.normal)
        (ax, ay), (bx, by) = a.normal, b.normal
        x = (a.offset * by - b.offset * ay) / area
        y = (b.offset * ax - a.offset * bx) / area
        return ((x, y),)
    if isinstance(a, _Straight):
        return _crossings(b, a)
    if isinstance(b, _Straight):
        line = b
    elif _concentric(a, b):
        return ()
    else:  # on the line of equal power: 2 (q - p).c = |q|^2 - S^2 - |p|^2 + R^2
        apart = distance(a.centre, b.centre)
        normal = ((b.centre[0] - a.centre[0]) / apart, (b.centre[1] - a.centre[1]) / apart)
        reach = (apart + (a.radius - b.radius) * (a.radius + b.radius) / apart) / 2
        line = _Straight(normal, dot(normal, a.centre) + reach)
    off = line.offset - dot(line.normal, a.centre)
    half = (a.radius - off) * (a.radius + off)
    if half < -NEAR * (a.radius + abs(off)):
        return ()
    (nx, ny), (cx, cy) = line.normal, a.centre
    foot = cx + off * nx, cy + off * ny
    if half <= NEAR * (a.radius + abs(off)):
        return (foot,)
    along = sqrt(half)
    return tuple((foot[0] - t * ny, foot[1] + t * nx) for t in (along, -along))


# --- three curves ---------------------------------------------------------------------------------


def _of_three(carriers: Sequence[_Carrier]) -> Iterator[Circle]:
    """The circles of all signs; those of the first stay, as r may come out negative."""
    for signs in product((1.0, -1.0), repeat=2):
        rows = [_row(c, s) for c, s in zip(carriers, (1.0, *signs), strict=True)]
        for x, y, r in _solved(rows):
            circle = Circle((x, y), abs(r))
            near = NEAR * max(1.0, circle.radius)  # rounding has left some that do not touch
            if circle.radius > NEAR and all(_off(circle, c) <= near for c in carriers):
                yield circle


def _row(carrier: _Carrier, s: float) -> _Row:
    if isinstance(carrier, _Straight):
        return 0.0, *carrier.normal, -s, -carrier.offset
    (x, y), r = carrier.centre, carrier.radius
    return 1.0, -2 * x, -2 * y, -2 * s * r, x * x + y * y - r * r


def _solved(rows: list[_Row]) -> Iterator[tuple[float, float, float]]:
    """The x, y and r of three conditions."""
    round_ = next((row for row in rows if row[0]), None)
    planes = [
        _minus(row, round_) if row[0] and round_ else row for row in rows if row is not round_
    ]
    if round_ is None:  # three lines: three planes meet in a point
        normal = _cross3(planes[0], planes[1])
        height = sum(n * c for n, c in zip(normal, planes[2][1:4], strict=True))
        if abs(height) > NEAR:
            at, along = _common_line(planes[0], planes[1], normal)
            t = (
                -(sum(c * v for c, v in zip(planes[2][1:4], at, strict=True)) + planes[2][4])
                / height
            )
            yield _on(at, along, t)
        return
    normal = _cross3(planes[0], planes[1])
    length = hypot(*normal)
    if length <= NEAR * hypot(*planes[0][1:4]) * hypot(*planes[1][1:4]):
        # Two parallel planes that are one: all circles of a pencil touch.
        p, q = planes
        size = sum(a * b for a, b in zip(p[1:4], q[1:4], strict=True))
        square = sum(a * a for a in p[1:4])
        if square and abs(q[4] - size / square * p[4]) <= NEAR:
            raise NoTangentCircle(
                "curves that touch at one point, where endlessly many touch them all"
            )
        return
    at, along = _common_line(planes[0], planes[1], normal)
    along = (along[0] / length, along[1] / length, along[2] / length)
    _, a, b, c, e = round_
    (x, y, r), (u, v, w) = at, along
    for t in _roots(
        u * u + v * v - w * w,
        2 * (x * u + y * v - r * w) + a * u + b * v + c * w,
        x * x + y * y - r * r + a * x + b * y + c * r + e,
    ):
        yield _on(at, along, t)


def _minus(row: _Row, other: _Row) -> _Row:
    k, a, b, c, e = (p - q for p, q in zip(row, other, strict=True))
    return k, a, b, c, e


def _cross3(p: _Row, q: _Row) -> tuple[float, float, float]:
    (_, a, b, c, _), (_, d, e, f, _) = p, q
    return b * f - c * e, c * d - a * f, a * e - b * d


def _common_line(
    p: _Row, q: _Row, normal: tuple[float, float, float]
) -> tuple[tuple[float, float, float], tuple[float, float, float]]:
    """A point of two planes that is nearest to the origin, and the direction of their line."""
    square = sum(n * n for n in normal)
    a, b, c = (q[4] * u - p[4] * v for u, v in zip(p[1:4], q[1:4], strict=True))
    x, y, r = _cross3((0.0, a, b, c, 0.0), (0.0, *normal, 0.0))
    return (x / square, y / square, r / square), normal


def _on(
    at: tuple[float, float, float], along: tuple[float, float, float], t: float
) -> tuple[float, float, float]:
    x, y, r = (a + t * b for a, b in zip(at, along, strict=True))
    return x, y, r


def _roots(a: float, b: float, c: float) -> tuple[float, ...]:
    """The roots of a t^2 + b t + c, one where they are (nearly) double, without cancellation."""
    square, product_ = b * b, 4 * a * c
    under = square - product_
    if abs(under) <= DOUBLE * (square + abs(product_)):
        return (-b / (2 * a),) if a else ()
    if under < 0.0:
        return ()
    q = -(b + sqrt(under) * (1.0 if b >= 0 else -1.0)) / 2
    return tuple(t for t in (q / a if a else inf, c / q if q else inf) if abs(t) < MAX_RADIUS)


def _off(circle: Circle, carrier: _Carrier) -> float:
    if isinstance(carrier, _Straight):
        return abs(abs(dot(carrier.normal, circle.centre) - carrier.offset) - circle.radius)
    apart = distance(circle.centre, carrier.centre)
    outside, inside = carrier.radius + circle.radius, abs(carrier.radius - circle.radius)
    return min(abs(apart - outside), abs(apart - inside))


def _why_none(carriers: Sequence[_Carrier], radius: float | None) -> str:
    lines = [c for c in carriers if isinstance(c, _Straight)]
    if len(lines) == len(carriers) and all(_parallel(lines[0], line) for line in lines[1:]):
        return "parallel lines, between which no circle" + (
            " of that radius fits" if radius else ""
        )
    if len(lines) == 3:
        return "three lines through one point"
    if len(lines) == 0 and all(_concentric(carriers[0], c) for c in carriers[1:]):
        fits = " of that radius" if radius else ""
        return f"concentric circles, between which no circle{fits} touches all"
    if radius:
        return "curves too far apart for a circle of that radius, or one so within the other"
    return "curves so within or across each other that no circle touches all three"
