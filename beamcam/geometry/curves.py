"""Exact curves in the plane.

Every curve is an immutable record with `start`, `end`, `length`, `bbox`, `point(t)` for t in
[0, 1], `reversed()` and `transformed(matrix)`. Angles of records are degrees, counter-clockwise
from +x, because files and the JSON form hold degrees and a quarter turn shall stay exact.
"""

from dataclasses import dataclass
from math import atan2, ceil, cos, degrees, floor, hypot, radians, sin

Point = tuple[float, float]
Box = tuple[float, float, float, float]  #: least x, least y, greatest x, greatest y


@dataclass(frozen=True, slots=True)
class Line:
    """A straight stretch."""

    start: Point
    end: Point

    @property
    def length(self) -> float:
        return hypot(self.end[0] - self.start[0], self.end[1] - self.start[1])

    @property
    def bbox(self) -> Box:
        (x0, y0), (x1, y1) = self.start, self.end
        return min(x0, x1), min(y0, y1), max(x0, x1), max(y0, y1)

    def point(self, t: float) -> Point:
        """The point at parameter `t`; 0 and 1 give the ends exactly."""
        if t == 1.0:
            return self.end
        (x0, y0), (x1, y1) = self.start, self.end
        return x0 + t * (x1 - x0), y0 + t * (y1 - y0)

    def reversed(self) -> "Line":
        return Line(self.end, self.start)


@dataclass(frozen=True, slots=True)
class Arc:
    """A stretch of a circle; a sweep of 360 or -360 is the whole of it."""

    centre: Point
    radius: float
    start_deg: float
    sweep_deg: float  #: positive counter-clockwise

    @property
    def start(self) -> Point:
        return self._at(self.start_deg)

    @property
    def end(self) -> Point:
        return self._at(self.start_deg + self.sweep_deg)

    def _at(self, angle_deg: float) -> Point:
        x, y = unit_vector(angle_deg)
        return self.centre[0] + self.radius * x, self.centre[1] + self.radius * y

    @property
    def length(self) -> float:
        return abs(radians(self.sweep_deg)) * self.radius

    @property
    def bbox(self) -> Box:
        """Least box around the arc: its ends and the quadrant points that it passes."""
        low = min(self.start_deg, self.start_deg + self.sweep_deg)
        high = max(self.start_deg, self.start_deg + self.sweep_deg)
        quadrants = range(ceil(low / 90 - 1e-12), floor(high / 90 + 1e-12) + 1)
        points = [self.start, self.end, *(self._at(90.0 * k) for k in quadrants)]
        xs = [p[0] for p in points]
        ys = [p[1] for p in points]
        return min(xs), min(ys), max(xs), max(ys)

    def point(self, t: float) -> Point:
        """The point at parameter `t`."""
        return self._at(self.start_deg + t * self.sweep_deg)

    def reversed(self) -> "Arc":
        return Arc(self.centre, self.radius, self.start_deg + self.sweep_deg, -self.sweep_deg)


Curve = Line | Arc


def unit_vector(angle_deg: float) -> Point:
    """Cosine and sine of an angle in degrees, exact at multiples of 90."""
    turns, rest = divmod(angle_deg, 90.0)
    c, s = (1.0, 0.0) if rest == 0.0 else (cos(radians(rest)), sin(radians(rest)))
    return ((c, s), (-s, c), (-c, -s), (s, -c))[int(turns) % 4]


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


def join_boxes(boxes: list[Box]) -> Box | None:
    """The box around all `boxes`; None if there are none."""
    if not boxes:
        return None
    x0, y0, x1, y1 = zip(*boxes, strict=True)
    return min(x0), min(y0), max(x1), max(y1)


def signed_area(curves: tuple[Curve, ...]) -> float:
    """Area inside a closed chain of curves in mm2, positive if it runs counter-clockwise.

    Green's theorem: the polygon of the ends, plus each arc's segment r2/2 (s - sin s).
    """
    total = 0.0
    for curve in curves:
        (x0, y0), (x1, y1) = curve.start, curve.end
        total += x0 * y1 - x1 * y0
        if isinstance(curve, Arc):
            sweep = radians(curve.sweep_deg)
            total += curve.radius**2 * (sweep - sin(sweep))
    return total / 2
