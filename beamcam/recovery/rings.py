"""The closed contour in the path of a tool, between its leads and over its bridges."""

from collections.abc import Sequence
from math import dist, hypot

from msgspec.structs import replace

from beamcam.geometry.curves import Arc, Curve, Line, Point
from beamcam.geometry.plane import cross

Curves = tuple[Curve, ...]


def ring_of(curves: Sequence[Curve], fine: float, near: float) -> tuple[int, int] | None:
    """The first curve of a path and the one behind the last, between which it is closed.

    One curve leads in and one leads out, or none, or else it is the longest ring there is. Ends
    within `fine` are one place; only where none are, those within `near` count, as the ends of a
    drawing that belong together do.
    """
    ends = [curves[0].start, *(c.end for c in curves)]
    count = len(curves)
    for limit in (fine, near):
        for first, last in ((1, count - 1), (1, count), (0, count - 1), (0, count)):
            if first < last and dist(ends[first], ends[last]) <= limit:
                return first, last
    done = [0.0]
    for curve in curves:
        done.append(done[-1] + curve.length)
    places: dict[tuple[int, int], int] = {}  #: the first end in each cell
    best = (4 * near, 0, 0)
    for last, (x, y) in enumerate(ends):
        column, row = round(x / near), round(y / near)
        for cell in [(column + a, row + b) for a in (-1, 0, 1) for b in (-1, 0, 1)]:
            first = places.get(cell, last)
            if first < last and dist(ends[first], ends[last]) <= near:
                best = max(best, (done[last] - done[first], first, last))
        places.setdefault((column, row), last)
    return best[1:] if best[2] else None


def whole(ring: Sequence[Curve], near: float) -> Curves:
    """A ring whose first and last curve are one where it was begun amid a line or an arc."""
    first, last = ring[0], ring[-1]
    between = tuple(ring[1:-1])
    if len(ring) < 2:
        return tuple(ring)
    if isinstance(first, Line) and isinstance(last, Line):
        if len(ring) > 3 and _off(first.start, last.start, first.end) <= near / 2:
            return (Line(last.start, first.end), *between)
    elif (
        isinstance(first, Arc)
        and isinstance(last, Arc)
        and _is_one_circle(first, last, near)
        and first.sweep_deg * last.sweep_deg > 0.0
    ):
        sweep = max(-360.0, min(360.0, first.sweep_deg + last.sweep_deg))
        return (replace(last, sweep_deg=sweep), *between)
    return tuple(ring)


def bridge(before: Curve, after: Curve) -> Curves:
    """Curves that join two stretches of a contour over the bridge between them."""
    if isinstance(before, Arc) and isinstance(after, Arc) and _is_one_circle(before, after, 0.01):
        end = before.start_deg + before.sweep_deg
        turn = 360.0 if before.sweep_deg > 0.0 else -360.0
        return (replace(before, start_deg=end, sweep_deg=(after.start_deg - end) % turn),)
    corner = None
    if isinstance(before, Line) and isinstance(after, Line):
        corner = _corner(before, after)
    if corner is None:
        return (Line(before.end, after.start),)
    return Line(before.end, corner), Line(corner, after.start)


def _is_one_circle(a: Arc, b: Arc, near: float) -> bool:
    return dist(a.centre, b.centre) <= near and abs(a.radius - b.radius) <= near


def _off(point: Point, a: Point, b: Point) -> float:
    """Distance of a point from the line through a and b; far where it is not between them."""
    long = dist(a, b)
    if long <= max(dist(a, point), dist(point, b)):
        return long
    return abs(cross((b[0] - a[0], b[1] - a[1]), (point[0] - a[0], point[1] - a[1]))) / long


def _corner(before: Line, after: Line) -> Point | None:
    """Intersection of two lines between the end of one and the start of the other."""
    (x, y), (u, v) = before.end, after.start
    along, back = before.tangent(1.0), after.tangent(0.0)
    turn = cross(along, back)
    gap = hypot(u - x, v - y)
    if abs(turn) < 1e-3:
        return None
    t = cross((u - x, v - y), back) / turn
    s = cross((u - x, v - y), along) / turn
    if not (0.0 < t <= 2 * gap and -2 * gap <= s < 0.0):
        return None
    return x + t * along[0], y + t * along[1]
