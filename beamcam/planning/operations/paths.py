"""Paths of mills and scribes on a face, as points so close that the chords keep a tolerance.

Every pocket of a line is a rectangle with round corners, of which a slot has no height and a
circle neither length nor height. A mill follows it inside by its own radius:

      ________________            corner radius of the path: (diameter - mill) / 2
    /  ____________   \\           blind pockets: further paths inside, `STEP` of a mill's
    | (____________)  |           diameter apart, until nothing is left to clear
    \\_________________/

The path begins at the end of the pocket that lies furthest along x, since that one is at the
machine last (and drilled before, where a slot's ends are drilled), and comes back to it.
"""

from collections.abc import Iterable, Iterator, Sequence
from math import acos, ceil, cos, dist, pi, sin

from beamcam.geometry.curves import Curve, Line, Point
from beamcam.geometry.plane import unit_vector

STEP = 0.6  #: of a mill's diameter between the paths that clear a blind pocket
MIN_RADIUS = 1e-6


def pocket_path(
    centre: Point,
    size: tuple[float, float],
    angle_deg: float,
    diameter: float,
    mill: float,
    tolerance: float,
    is_blind: bool,
) -> tuple[Point, ...]:
    """Points of the path that mills a pocket, first and last the same one.

    `size` is the distance of the corner circles' centres along and across `angle_deg`, `diameter`
    that of the corner circles. The chords lie within `tolerance` of the path.
    """
    radius = max(0.0, (diameter - mill) / 2)
    rings = [_ring(size, radius, 0.0, tolerance)]
    inset = STEP * mill
    while is_blind and inset < radius + max(size) / 2:
        rings.append(_ring(size, radius, inset, tolerance))
        inset += STEP * mill
    c, s = unit_vector(angle_deg)
    placed = [
        [(centre[0] + c * x - s * y, centre[1] + s * x + c * y) for x, y in ring] for ring in rings
    ]
    # The ends of a slot that were drilled are the places where a mill may go in.
    ends = [(k * size[0] / 2, m * size[1] / 2) for k in (-1, 1) for m in (-1, 1)]
    entry = max((centre[0] + c * x - s * y, centre[1] + s * x + c * y) for x, y in ends)
    points = [entry]
    for ring in placed:
        nearest = min(range(len(ring)), key=lambda i: (dist(ring[i], points[-1]), i))
        points += [*ring[nearest:], *ring[:nearest], ring[nearest]]
    points.append(entry)
    return tuple(_without_repeats(points))


def _ring(size: tuple[float, float], radius: float, inset: float, tolerance: float) -> list[Point]:
    """Points of the rounded rectangle, `inset` inside of the outermost path, about 0, 0."""
    corner = radius - inset
    half_x, half_y = size[0] / 2, size[1] / 2
    if corner < 0:
        half_x, half_y = max(0.0, half_x + corner), max(0.0, half_y + corner)
        corner = 0.0
    points: list[Point] = []
    for quarter, (x, y) in enumerate(((1, 1), (-1, 1), (-1, -1), (1, -1))):
        count = arc_steps(corner, pi / 2, tolerance)
        for i in range(count + 1):
            t = pi / 2 * (quarter + i / count)
            points.append((x * half_x + corner * cos(t), y * half_y + corner * sin(t)))
    return list(_without_repeats(points))


def arc_steps(radius: float, sweep_rad: float, tolerance: float) -> int:
    """How many chords keep a circle's stretch within `tolerance` of it.

    The chord of a step t lies radius * (1 - cos(t / 2)) from the arc (the sagitta).
    """
    if radius <= MIN_RADIUS:
        return 1
    step = 2 * acos(max(0.0, 1 - tolerance / radius)) if tolerance < radius else pi / 2
    return max(1, ceil(abs(sweep_rad) / min(step, pi / 2) - 1e-9))


def _without_repeats(points: Iterable[Point]) -> Iterator[Point]:
    last: Point | None = None
    for point in points:
        if last is None or dist(point, last) > MIN_RADIUS:
            yield point
            last = point


def line_points(curves: Sequence[Curve], tolerance: float) -> tuple[Point, ...]:
    """Points of a chain of curves, whose chords lie within `tolerance` of it."""
    points = [curves[0].start]
    for curve in curves:
        if not isinstance(curve, Line):
            points += _halved(curve, 0.0, 1.0, tolerance, 12)
        points.append(curve.end)
    return tuple(_without_repeats(points))


def _halved(curve: Curve, low: float, high: float, tolerance: float, depth: int) -> list[Point]:
    """Points strictly between two parameters, by halves until two tests of the sagitta hold.

    Between places where x or y turns nothing is tested, so a first cut is always made.
    """
    middle = (low + high) / 2
    a, b = curve.point(low), curve.point(high)
    tests = (curve.point(low + (high - low) * share) for share in (0.25, 0.5, 0.75))
    is_flat = all(_off_chord(point, a, b) <= tolerance / 2 for point in tests)
    if depth == 0 or (is_flat and high - low <= 0.25):
        return []
    return [
        *_halved(curve, low, middle, tolerance, depth - 1),
        curve.point(middle),
        *_halved(curve, middle, high, tolerance, depth - 1),
    ]


def _off_chord(point: Point, a: Point, b: Point) -> float:
    length = dist(a, b)
    if length <= MIN_RADIUS:
        return dist(point, a)
    return abs((b[0] - a[0]) * (point[1] - a[1]) - (b[1] - a[1]) * (point[0] - a[0])) / length
