"""Intersections of lines and circles, and curves trimmed there."""

from math import hypot, sqrt

from beamcam.geometry.conics import direction_deg
from beamcam.geometry.curves import Arc, Line
from beamcam.geometry.plane import Point, cross, distance, dot

BEYOND = 1e-9  #: mm beyond its end that a line may reach by the last digits


def meeting(a: Line | Arc, b: Line | Arc, corner: Point) -> Point | None:
    """Where two curves meet, nearest to the corner that both are cut at."""
    points = [p for p in intersections(a, b) if between(a, a.start, p) and between(b, p, b.end)]
    return min(points, key=lambda p: distance(p, corner), default=None)


def intersections(a: Line | Arc, b: Line | Arc) -> list[Point]:
    """Points where the whole lines or circles of two curves meet."""
    if isinstance(a, Line) and isinstance(b, Line):
        (ux, uy), (vx, vy) = a.tangent(0.0), b.tangent(0.0)
        det = cross((ux, uy), (vx, vy))
        if abs(det) < 1e-12:
            return []
        s = cross((b.start[0] - a.start[0], b.start[1] - a.start[1]), (vx, vy)) / det
        return [(a.start[0] + s * ux, a.start[1] + s * uy)]
    if isinstance(a, Arc) and isinstance(b, Line):
        a, b = b, a
    if isinstance(a, Line) and isinstance(b, Arc):
        ux, uy = a.tangent(0.0)
        to = (b.centre[0] - a.start[0], b.centre[1] - a.start[1])
        foot, away = dot((ux, uy), to), cross((ux, uy), to)
        if abs(away) > b.radius:
            return []
        half = sqrt(b.radius**2 - away**2)
        return [(a.start[0] + s * ux, a.start[1] + s * uy) for s in (foot - half, foot + half)]
    assert isinstance(a, Arc)
    assert isinstance(b, Arc)
    d = (b.centre[0] - a.centre[0], b.centre[1] - a.centre[1])
    gap = hypot(*d)
    if gap < 1e-12 or gap > a.radius + b.radius or gap < abs(a.radius - b.radius):
        return []
    along = (gap * gap + a.radius**2 - b.radius**2) / (2 * gap)
    height = sqrt(max(0.0, a.radius**2 - along**2))
    ux, uy = d[0] / gap, d[1] / gap
    x, y = a.centre[0] + along * ux, a.centre[1] + along * uy
    return [(x - h * uy, y + h * ux) for h in (height, -height)]


def between(part: Line | Arc, start: Point, end: Point) -> Line | Arc | None:
    """The stretch of a line or circle between two of its points.

    None if it would run back, or reach beyond either end: cutting shortens.
    """
    if part.start == start and part.end == end:
        return part
    if isinstance(part, Line):
        ahead = part.tangent(0.0)
        first, last, length = (
            dot((p[0] - part.start[0], p[1] - part.start[1]), ahead) for p in (start, end, part.end)
        )
        is_on = first >= -BEYOND and last <= length + BEYOND
        return Line(start, end) if is_on and first < last else None
    sign = 1.0 if part.sweep_deg > 0 else -1.0
    angles = [direction_deg((p[0] - part.centre[0], p[1] - part.centre[1])) for p in (start, end)]
    sweep = (angles[1] - angles[0]) * sign % 360.0
    # What sweeps further has turned inside out.
    if sweep > abs(part.sweep_deg) + 1e-6 or sweep == 0.0:
        return None
    return Arc(part.centre, part.radius, angles[0], sign * sweep)
