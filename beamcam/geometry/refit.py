"""Lines and arcs found again in the corners of a polygon."""

import itertools
from collections.abc import Sequence
from math import hypot

from beamcam.geometry.conics import arc_by_points
from beamcam.geometry.curves import Arc, Line
from beamcam.geometry.plane import Point, cross, distance, dot

#: So many corners, at least, make an arc.
MIN_CORNERS = 5

#: No chord of an arc turns it by more than this: a square is not a circle.
MOST_SWEEP_DEG = 350.0


def refit_ring(points: Sequence[Point], tolerance: float) -> tuple[Line | Arc, ...]:
    """A closed chain of lines and arcs through some of the corners of a polygon, which no
    corner and no side's middle lies farther from than `tolerance` (and the sagitta of a chord).

    Greedy: from each corner the longest arc, or else the longest line. It starts at the corner
    with the sharpest turn, so that an arc is not cut in two where it needs not be.
    """
    count = len(points)
    start = max(range(count), key=lambda k: (_turn(points, k), -k))
    ring = [points[(start + k) % count] for k in range(count)] + [points[start]]
    found: list[Line | Arc] = []
    at = 0
    while at < count:
        arc, reach = _longest_arc(ring, at, tolerance)
        if arc is None:
            reach = _longest_line(ring, at, tolerance)
            found.append(Line(ring[at], ring[reach]))
        else:
            found.append(arc)
        at = reach
    return tuple(found)


def _turn(points: Sequence[Point], k: int) -> float:
    """1 - cosine of the turn at a corner."""
    a, b, c = points[k - 1], points[k], points[(k + 1) % len(points)]
    u, v = (b[0] - a[0], b[1] - a[1]), (c[0] - b[0], c[1] - b[1])
    size = hypot(*u) * hypot(*v)
    return 1.0 - dot(u, v) / size if size else 0.0


def _longest_arc(ring: list[Point], at: int, tolerance: float) -> tuple[Arc | None, int]:
    """The arc from corner `at` over the most corners; doubles its reach, then halves the step."""
    best: Arc | None = None
    reach, step = at, MIN_CORNERS - 1
    growing = True
    while step >= 1:
        wished = reach + step
        arc = _arc_over(ring[at : wished + 1], tolerance) if wished < len(ring) else None
        if arc is not None:
            best, reach = arc, wished
            step = step * 2 if growing else step
        else:
            if best is None:
                break
            growing = False
            step //= 2
    return best, reach


def _arc_over(points: list[Point], tolerance: float) -> Arc | None:
    arc = arc_by_points(points[0], points[len(points) // 2], points[-1])
    if arc is None or abs(arc.sweep_deg) > MOST_SWEEP_DEG:
        return None
    centre, side = arc.centre, 1.0 if arc.sweep_deg > 0 else -1.0
    for p, q in itertools.pairwise(points):
        middle = ((p[0] + q[0]) / 2, (p[1] + q[1]) / 2)
        if (
            abs(distance(q, centre) - arc.radius) > tolerance
            or arc.radius - distance(middle, centre) > 4 * tolerance
        ):
            return None
        # Corners follow one another round the centre, never back.
        from_centre = (p[0] - centre[0], p[1] - centre[1])
        if side * cross(from_centre, (q[0] - p[0], q[1] - p[1])) <= 0.0:
            return None
    return arc


def _longest_line(ring: list[Point], at: int, tolerance: float) -> int:
    reach = at + 1
    while reach + 1 < len(ring) and _is_straight(ring[at : reach + 2], tolerance / 4):
        reach += 1
    return reach


def _is_straight(points: list[Point], tolerance: float) -> bool:
    a, b = points[0], points[-1]
    chord = (b[0] - a[0], b[1] - a[1])
    size = hypot(*chord)
    return size > 0.0 and all(
        abs(cross(chord, (p[0] - a[0], p[1] - a[1]))) <= tolerance * size
        and dot(chord, (p[0] - a[0], p[1] - a[1])) >= 0.0
        for p in points
    )
