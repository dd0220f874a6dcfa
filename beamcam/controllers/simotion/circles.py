"""Arcs of path objects, by a place that they go over."""

from math import atan2, cos, hypot, pi, sin

Place = tuple[float, float]

CIRCLE_STEPS = 256  #: chords of half a circle


def circle_points(start: Place, middle: Place, end: Place) -> list[Place]:
    """Points of the arc from start over middle to end; nothing if they lie in a line.

    The centre is where the perpendicular bisectors of both chords meet.
    """
    ax, ay = middle[0] - start[0], middle[1] - start[1]
    bx, by = end[0] - start[0], end[1] - start[1]
    det = 2 * (ax * by - ay * bx)
    if abs(det) < 1e-9:
        return []
    a2, b2 = ax * ax + ay * ay, bx * bx + by * by
    cx, cy = (by * a2 - ay * b2) / det, (ax * b2 - bx * a2) / det
    radius = hypot(cx, cy)
    centre = (start[0] + cx, start[1] + cy)
    first = atan2(-cy, -cx)
    last = atan2(end[1] - centre[1], end[0] - centre[0])
    sweep = (last - first) % (2 * pi) if det > 0 else -((first - last) % (2 * pi))
    count = max(2, round(CIRCLE_STEPS * abs(sweep) / pi))
    inner = [
        (centre[0] + radius * cos(first + sweep * k / count),
         centre[1] + radius * sin(first + sweep * k / count))
        for k in range(1, count)
    ]  # fmt: skip
    return [start, *inner, end]
