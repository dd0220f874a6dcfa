"""Closed chains moved outwards or inwards as polygons, and their arcs found again.

It replaces the exact form of `offset` where parts of a moved chain run into each other.
"""

import itertools
from collections.abc import Sequence
from math import degrees, hypot, sqrt
from typing import Any

import numpy as np
from numpy.typing import NDArray

from beamcam.geometry.conics import arc_by_points
from beamcam.geometry.curves import Arc, Curve, Line, signed_area
from beamcam.geometry.plane import Point, cross, distance, dot
from beamcam.geometry.polylines import chords_of, longest_arc, longest_line, points_at


def flat_offset(
    curves: tuple[Curve, ...], amount: float, tolerance: float
) -> tuple[tuple[Curve, ...], ...]:
    """The rings of a chain moved by `amount` mm, outwards if above 0; none if it vanishes.

    They are lines and arcs within `tolerance`, and run as the chain does, holes the other way.
    Corners that open are rounded: a mitre would close places where there is room.
    """
    drawn = []
    for curve in curves:
        chords = 1 if isinstance(curve, Line) else chords_of(curve, tolerance / 8)
        drawn.append(points_at(curve, np.linspace(0.0, 1.0, chords + 1))[:-1])
    ring = np.concatenate(drawn)
    quarter = max(8, int(90 / max(1.0, degrees(2 * sqrt(tolerance / 4 / abs(amount))))))
    moved = _moved(ring, amount, quarter, tolerance)
    parts = [p for p in getattr(moved, "geoms", [moved]) if p.area > tolerance * tolerance]
    turned = signed_area(curves) < 0
    chains = []
    for part in parts:
        for place, loop in enumerate((part.exterior, *part.interiors)):
            points = [(float(x), float(y)) for x, y in loop.coords[:-1]]
            fitted = refit_ring(points, tolerance / 4)
            backwards = (signed_area(fitted) < 0) != (turned != (place > 0))
            chains.append(tuple(c.reversed() for c in reversed(fitted)) if backwards else fitted)
    return tuple(chains)


def _moved(ring: NDArray[np.float64], amount: float, quarter: int, tolerance: float) -> Any:
    """The inside of a ring moved by `amount` mm, with so many chords to a quarter of a circle.

    In a corner that closes, made of sides much shorter than the amount, GEOS leaves out where the
    long sides beside them meet, and may be off by a sixth of the amount. Then every side is moved
    by itself.
    """
    import shapely

    inside = shapely.make_valid(shapely.Polygon(ring))
    moved = inside.buffer(amount, quad_segs=quarter)
    edge = shapely.linearrings(ring)
    shapely.prepare(edge)
    places = shapely.get_coordinates(shapely.segmentize(moved.boundary, abs(amount) / 4))
    if shapely.dwithin(edge, shapely.points(places), abs(amount) + tolerance).all():
        return moved
    corners = shapely.get_coordinates(edge)
    sides = shapely.linestrings(np.stack((corners[:-1], corners[1:]), axis=1))
    band = shapely.union_all(shapely.buffer(sides, abs(amount), quad_segs=quarter))
    whole = inside.buffer(0.0)  # without lines
    return whole.union(band) if amount > 0.0 else whole.difference(band)


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

    def turn(k: int) -> float:
        """1 - cosine of the turn at a corner."""
        a, b, c = points[k - 1], points[k], points[(k + 1) % count]
        u, v = (b[0] - a[0], b[1] - a[1]), (c[0] - b[0], c[1] - b[1])
        size = hypot(*u) * hypot(*v)
        return 1.0 - dot(u, v) / size if size else 0.0

    start = max(range(count), key=lambda k: (turn(k), -k))
    ring = [points[(start + k) % count] for k in range(count)] + [points[start]]
    curves: list[Line | Arc] = []
    at = 0
    while at < count:
        arc, reach = longest_arc(ring, at, MIN_CORNERS - 1, lambda run: _arc_over(run, tolerance))
        if arc is None:
            reach = longest_line(ring, at, lambda run: _is_straight(run, tolerance / 4))
            curves.append(Line(ring[at], ring[reach]))
        else:
            curves.append(arc)
        at = reach
    return tuple(curves)


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


def _is_straight(points: list[Point], tolerance: float) -> bool:
    a, b = points[0], points[-1]
    chord = (b[0] - a[0], b[1] - a[1])
    size = hypot(*chord)
    return size > 0.0 and all(
        abs(cross(chord, (p[0] - a[0], p[1] - a[1]))) <= tolerance * size
        and dot(chord, (p[0] - a[0], p[1] - a[1])) >= 0.0
        for p in points
    )
