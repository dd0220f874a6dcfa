"""Lines, circle arcs and ellipse arcs.

Angles of records are degrees, counter-clockwise from +x, because files and the JSON form hold
degrees and a quarter turn shall stay exact.

The records of curves (`gc=False`) hold numbers and tuples of numbers, so that no cycle can pass
through them: the garbage collector need not walk over the tens of thousands that a drawing has.
"""

from math import atan2, ceil, degrees, floor, hypot, radians, sin, sqrt
from typing import Self

from msgspec import Struct
from msgspec.structs import replace

from beamcam.geometry.plane import (
    Box,
    Matrix,
    Point,
    between,
    box_around,
    cross,
    determinant,
    dot,
    integrate,
    is_similarity,
    mapped,
    mapped_vector,
    normalized,
    refuse_singular,
    unit_vector,
)


class Line(Struct, frozen=True, gc=False):
    """A straight stretch."""

    start: Point
    end: Point

    @property
    def length(self) -> float:
        return hypot(self.end[0] - self.start[0], self.end[1] - self.start[1])

    @property
    def bbox(self) -> Box:
        return box_around((self.start, self.end))

    def point(self, t: float) -> Point:
        """The point at parameter `t`; 0 and 1 give the ends exactly."""
        return between(self.start, self.end, t)

    def tangent(self, t: float) -> Point:
        """Direction of travel, length 1. Raises ValueError if the ends are one point."""
        return normalized((self.end[0] - self.start[0], self.end[1] - self.start[1]))

    def split(self, t: float) -> "tuple[Line, Line]":
        """The parts before and after parameter `t`."""
        middle = self.point(t)
        return Line(self.start, middle), Line(middle, self.end)

    def reversed(self) -> "Line":
        return Line(self.end, self.start)

    def transformed(self, matrix: Matrix) -> "Line":
        return Line(mapped(matrix, self.start), mapped(matrix, self.end))


class _Swept:
    """What arcs of circles and of ellipses share: a sweep from a start, in degrees."""

    __slots__ = ()
    start_deg: float
    sweep_deg: float

    def _at(self, angle_deg: float) -> Point:
        raise NotImplementedError

    @property
    def start(self) -> Point:
        return self._at(self.start_deg)

    @property
    def end(self) -> Point:
        whole = abs(self.sweep_deg) == 360.0
        return self._at(self.start_deg if whole else self.start_deg + self.sweep_deg)

    def point(self, t: float) -> Point:
        """The point at parameter `t`; 0 and 1 give the ends exactly."""
        return self.end if t == 1.0 else self._at(self.start_deg + t * self.sweep_deg)

    def split(self, t: float) -> tuple[Self, Self]:
        """The parts before and after parameter `t`."""
        first = t * self.sweep_deg
        rest = self.sweep_deg - first
        return (
            replace(self, sweep_deg=first),  # type: ignore[type-var]
            replace(self, start_deg=self.start_deg + first, sweep_deg=rest),  # type: ignore[type-var]
        )

    def reversed(self) -> Self:
        end_deg = self.start_deg + self.sweep_deg
        return replace(self, start_deg=end_deg, sweep_deg=-self.sweep_deg)  # type: ignore[type-var]


class Arc(_Swept, Struct, frozen=True, gc=False):
    """A stretch of a circle; a sweep of 360 or -360 is the whole of it."""

    centre: Point
    radius: float
    start_deg: float
    sweep_deg: float  #: positive counter-clockwise

    def _at(self, angle_deg: float) -> Point:
        x, y = unit_vector(angle_deg)
        return self.centre[0] + self.radius * x, self.centre[1] + self.radius * y

    @property
    def length(self) -> float:
        return abs(radians(self.sweep_deg)) * self.radius

    @property
    def bbox(self) -> Box:
        """Least box around the arc: its ends and the quadrant points that it passes."""
        quadrants = _quadrants(self.start_deg, self.sweep_deg)
        return box_around([self.start, self.end, *(self._at(a) for a in quadrants)])

    def tangent(self, t: float) -> Point:
        """Direction of travel, length 1."""
        x, y = unit_vector(self.start_deg + t * self.sweep_deg)
        return (-y, x) if self.sweep_deg > 0 else (y, -x)

    def transformed(self, matrix: Matrix) -> "Arc | EllipseArc":
        """The image: an `Arc` if circles stay circles under `matrix`, else an `EllipseArc`."""
        if not is_similarity(matrix):
            whole = EllipseArc(self.centre, (self.radius, 0.0), 1.0, self.start_deg, self.sweep_deg)
            return whole.transformed(matrix)
        refuse_singular(matrix)
        mirror = -1.0 if determinant(matrix) < 0 else 1.0
        axis = mapped_vector(matrix, (1.0, 0.0))
        return Arc(
            mapped(matrix, self.centre),
            self.radius * sqrt(abs(determinant(matrix))),
            direction_deg(axis) + mirror * self.start_deg,
            mirror * self.sweep_deg,
        )


class EllipseArc(_Swept, Struct, frozen=True, gc=False):
    """A stretch of an ellipse; a sweep of 360 or -360 is the whole of it.

    Point at eccentric angle p: centre + cos(p) axis + ratio sin(p) axis turned left.
    """

    centre: Point
    axis: Point  #: from the centre to the end of the major axis
    ratio: float  #: minor / major axis, above 0, at most 1
    start_deg: float  #: eccentric angle, counter-clockwise from the major axis
    sweep_deg: float  #: positive counter-clockwise

    @property
    def major(self) -> float:
        """Half of the major axis."""
        return hypot(*self.axis)

    @property
    def minor(self) -> float:
        """Half of the minor axis."""
        return self.ratio * hypot(*self.axis)

    def _offset(self, angle_deg: float) -> Point:
        (ax, ay), (c, s) = self.axis, unit_vector(angle_deg)
        return c * ax - self.ratio * s * ay, c * ay + self.ratio * s * ax

    def _at(self, angle_deg: float) -> Point:
        x, y = self._offset(angle_deg)
        return self.centre[0] + x, self.centre[1] + y

    def _derivative(self, t: float) -> Point:
        x, y = self._offset(self.start_deg + t * self.sweep_deg + 90.0)
        speed = radians(self.sweep_deg)
        return speed * x, speed * y

    @property
    def length(self) -> float:
        """Length by numerical integration, to about 1e-12 relative."""
        steps = max(1, ceil(abs(self.sweep_deg) / 90.0))
        return sum(
            integrate(lambda t: hypot(*self._derivative(t)), k / steps, (k + 1) / steps)
            for k in range(steps)
        )

    @property
    def bbox(self) -> Box:
        """Least box around the arc."""
        return box_around([self.start, self.end, *(self.point(t) for t in self.extremes())])

    def tangent(self, t: float) -> Point:
        """Direction of travel, length 1."""
        return normalized(self._derivative(t))

    def extremes(self) -> tuple[float, ...]:
        """Parameters inside (0, 1) where x or y turns, ascending."""
        ax, ay = self.axis
        # dx/dp = 0 at tan p = -ratio ay / ax, dy/dp = 0 at tan p = ratio ax / ay.
        of_x = 0.0 if ay == 0.0 else degrees(atan2(-self.ratio * ay, ax))
        of_y = 90.0 if ay == 0.0 else degrees(atan2(self.ratio * ax, ay))
        angles = {
            (multiple - shift) / self.sweep_deg
            for shift in (self.start_deg - of_x, self.start_deg - of_y)
            for multiple in _quadrants(shift, self.sweep_deg, inside=True, every=180.0)
        }
        return tuple(sorted(angles))

    def transformed(self, matrix: Matrix) -> "EllipseArc":
        """The image under `matrix`. Raises ValueError if that flattens the plane."""
        refuse_singular(matrix)
        ax, ay = self.axis
        u = mapped_vector(matrix, (ax, ay))
        v = mapped_vector(matrix, (-self.ratio * ay, self.ratio * ax))
        return ellipse_of(mapped(matrix, self.centre), u, v, self.start_deg, self.sweep_deg)


def ellipse_of(centre: Point, u: Point, v: Point, start_deg: float, sweep_deg: float) -> EllipseArc:
    """The arc centre + cos(p) u + sin(p) v for p over a sweep; `u` and `v` need not be at right
    angles.

    The axes of that ellipse are the extremes of its distance from the centre, at
    tan(2 p) = 2 u.v / (u.u - v.v). Raises ValueError if `u` and `v` are parallel.
    """
    uu, vv, uv = dot(u, u), dot(v, v), dot(u, v)
    square = abs(uv) <= 1e-15 * (uu + vv)
    turn_deg = (0.0 if uu >= vv else 90.0) if square else degrees(atan2(2 * uv, uu - vv)) / 2
    c, s = unit_vector(turn_deg)
    major = (c * u[0] + s * v[0], c * u[1] + s * v[1])
    minor = (c * v[0] - s * u[0], c * v[1] - s * u[1])
    left = cross(major, minor)
    if left == 0.0:
        raise ValueError("the axes of an ellipse may not be parallel")
    side = 1.0 if left > 0 else -1.0
    ratio = min(1.0, hypot(*minor) / hypot(*major))
    return EllipseArc(centre, major, ratio, side * (start_deg - turn_deg), side * sweep_deg)


def direction_deg(vector: Point) -> float:
    """Angle of a vector in degrees, exact along the axes."""
    x, y = vector
    if y == 0.0:
        return 0.0 if x >= 0.0 else 180.0
    if x == 0.0:
        return 90.0 if y > 0.0 else 270.0
    return degrees(atan2(y, x))


def _quadrants(
    start_deg: float, sweep_deg: float, inside: bool = False, every: float = 90.0
) -> list[float]:
    """The multiples of `every` degrees in a sweep; `inside` leaves out those at its ends."""
    low, high = sorted((start_deg, start_deg + sweep_deg))
    slack = (-1e-12 if inside else 1e-12) * max(1.0, abs(low), abs(high))
    steps = range(ceil((low - slack) / every), floor((high + slack) / every) + 1)
    return [every * k for k in steps]


def arc_through(start: Point, end: Point, radius: float) -> Arc:
    """The arc of at most 180 degrees from `start` to `end`; counter-clockwise if `radius` > 0.

    A chord longer than the diameter by no more than rounding gives the half circle over it.
    Raises ValueError if the points are one, or further apart than that allows (0.1 % or 0.02 mm).
    """
    chord_x, chord_y = end[0] - start[0], end[1] - start[1]
    chord = hypot(chord_x, chord_y)
    size = abs(radius)
    if chord == 0.0:
        raise ValueError("an arc needs two different points")
    if chord > 2 * size + max(0.02, 0.002 * size):
        raise ValueError(f"points {chord:.3f} apart do not lie on a circle of radius {size:g}")
    half = chord / 2
    if half >= size * (1 - 1e-9):
        size, rise = half, 0.0
    else:
        rise = (size * size - half * half) ** 0.5
    # Counter-clockwise, the centre of an arc under 180 degrees lies left of its chord.
    side = 1.0 if radius > 0 else -1.0
    centre = (
        (start[0] + end[0]) / 2 - side * rise * chord_y / chord,
        (start[1] + end[1]) / 2 + side * rise * chord_x / chord,
    )
    start_deg = degrees(atan2(start[1] - centre[1], start[0] - centre[0]))
    end_deg = degrees(atan2(end[1] - centre[1], end[0] - centre[0]))
    sweep = (end_deg - start_deg) * side % 360.0 * side if rise else 180.0 * side
    return Arc(centre, size, start_deg, sweep)


def arc_between(start: Point, end: Point, centre: Point, side: float) -> Arc:
    """The arc about `centre` from `start` to `end`; counter-clockwise if `side` > 0.

    Its radius is the mean of both distances. One point for start and end gives the full circle.
    """
    radius = (
        hypot(start[0] - centre[0], start[1] - centre[1])
        + hypot(end[0] - centre[0], end[1] - centre[1])
    ) / 2
    start_deg = direction_deg((start[0] - centre[0], start[1] - centre[1]))
    end_deg = direction_deg((end[0] - centre[0], end[1] - centre[1]))
    sign = 1.0 if side > 0 else -1.0
    sweep = (end_deg - start_deg) * sign % 360.0 or 360.0
    return Arc(centre, radius, start_deg, sign * sweep)


def arc_by_points(a: Point, m: Point, b: Point) -> Arc | None:
    """The arc from `a` over `m` to `b`; None if they lie on a line."""
    ux, uy, wx, wy = m[0] - a[0], m[1] - a[1], b[0] - a[0], b[1] - a[1]
    area = 2 * (ux * wy - uy * wx)
    uu, ww = ux * ux + uy * uy, wx * wx + wy * wy
    if abs(area) <= 1e-9 * (uu + ww):
        return None
    centre = (a[0] + (wy * uu - uy * ww) / area, a[1] + (ux * ww - wx * uu) / area)
    return arc_between(a, b, centre, area)


def segment_area(sweep_deg: float, major: float, minor: float) -> float:
    """Signed area between an (ellipse) arc and its chord: a b / 2 (s - sin s)."""
    sweep = radians(sweep_deg)
    return major * minor * (sweep - sin(sweep)) / 2
