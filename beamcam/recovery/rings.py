"""Holes, slots and contours from the borders of what a torch leaves, which are chords.

    places, the steel on their left -> a circle, a slot, or else corners -> arcs and lines

A torch goes round the steel at half a kerf, so that at a corner of it the border is a fan of chords
a few hundredths of a millimetre long: it ends where the long chords on either side meet.
"""

from collections.abc import Sequence
from itertools import pairwise
from math import asin, atan2, cos, degrees, dist, hypot, inf, radians, sin, sqrt
from typing import Any

import numpy as np

from beamcam.checks.coping.stock import EDGE_NOISE
from beamcam.geometry.conics import arc_by_points
from beamcam.geometry.curves import Arc, Curve, Line
from beamcam.geometry.plane import Point
from beamcam.geometry.polylines import arcs_and_lines
from beamcam.recovery.recovered import plain

Shape = Any  #: of shapely

FAN = 0.3  #: mm that the chords of a fan are long together
FAN_DEEP = 0.03  #: mm from a fan to where the long chords beside it meet, at most
STRAIGHT = 0.002  #: mm that a place may lie off a line through its neighbours
LEAST_ROUND = 12  #: places of a circle
PLACE = 0.003  #: mm to which corners and middles are known
SIZE = 0.005  #: mm to which radii are known
DECIMALS = 3
SLOT_SHARE = 0.5  #: of the shorter side of a slot that its round corners take, at least


Circle = tuple[float, float, float]  #: x, y and diameter
#: x, y, diameter of the corners, length and height from centre to centre of these, and angle.
Pocket = tuple[float, float, float, float, float, float]


def round_of(ring: Sequence[Point], within: float) -> Circle | None:
    """The circle that a ring of chords replaces, everywhere within some mm of it."""
    if len(ring) < LEAST_ROUND:
        return None
    points = np.array(ring)
    # Least squares of x^2 + y^2 + a x + b y + c, from the middle (Kasa).
    middle = points.mean(axis=0)
    own = points - middle
    system = np.column_stack((own, np.ones(len(own))))
    (a, b, _), *_ = np.linalg.lstsq(system, -(own**2).sum(axis=1), rcond=None)
    x, y = (plain(float(v), PLACE, DECIMALS) for v in (middle[0] - a / 2, middle[1] - b / 2))
    # The corners of chords lie on their circle, their middles within it.
    away = np.hypot(points[:, 0] - x, points[:, 1] - y)
    half = (points + np.roll(points, -1, axis=0)) / 2
    inside = np.hypot(half[:, 0] - x, half[:, 1] - y)
    diameter = _plain_size(2 * float(away.max()))
    off = max(float(np.abs(away - diameter / 2).max()), diameter / 2 - float(inside.min()))
    return (x, y, diameter) if off <= within else None


def drilled_of(ring: Sequence[Point], tube_radius: float, within: float) -> Circle | None:
    """The hole through the axis of a tube that a ring on its unrolled outside is cut along."""
    us = [u for _, u in ring]
    middle = (min(us) + max(us)) / 2
    if max(us) - middle >= tube_radius * radians(90.0):
        return None
    flat = [(x, tube_radius * sin((u - middle) / tube_radius)) for x, u in ring]
    x, y, diameter = round_of(flat, within) or (0.0, 0.0, inf)
    if diameter >= 2 * tube_radius:
        return None
    return x, plain(middle + tube_radius * asin(y / tube_radius), PLACE, DECIMALS), diameter


def pocket_of(ring: Sequence[Point], within: float) -> Pocket | None:
    """The slot that a ring of chords replaces, everywhere within some mm of it."""
    from shapely import Polygon

    corners = list(Polygon(ring).minimum_rotated_rectangle.exterior.coords)[:4]
    (ax, ay), (bx, by) = max(pairwise(corners), key=lambda side: dist(*side))
    angle = plain(90.0 - (90.0 - degrees(atan2(by - ay, bx - ax))) % 180.0, SIZE, DECIMALS)
    c, s = cos(radians(angle)), sin(radians(angle))
    own = [(c * x + s * y, c * y - s * x) for x, y in ring]
    us, vs = [u for u, _ in own], [v for _, v in own]
    wide, high = (plain(max(w) - min(w), 2 * PLACE, DECIMALS) for w in (us, vs))
    u, v = (min(us) + max(us)) / 2, (min(vs) + max(vs)) / 2
    off = min(dist(p, corner) for p in own for corner in ((max(us), max(vs)), (min(us), min(vs))))
    diameter = 2 * off / (sqrt(2) - 1)
    # Of a plain slot the width is its diameter, which is known better.
    diameter = high if abs(diameter - high) <= 8 * within else _plain_size(diameter)
    length, height = wide - diameter, high - diameter
    if length <= 0.0 or height < 0.0 or diameter < SLOT_SHARE * high:
        return None

    def off_it(place: Point) -> float:
        du = max(abs(place[0] - u) - length / 2, 0.0)
        dv = max(abs(place[1] - v) - height / 2, 0.0)
        return abs(hypot(du, dv) - diameter / 2)

    halves = [((p + r) / 2, (q + t) / 2) for (p, q), (r, t) in pairwise(own)]
    if max(map(off_it, (*own, *halves))) > within:
        return None
    x, y = (plain(w, PLACE, DECIMALS) for w in (c * u - s * v, s * u + c * v))
    return x, y, diameter, round(length, DECIMALS), round(height, DECIMALS), angle


def curves_of(
    ring: Sequence[Point], within: float, edges: Sequence[float] = ()
) -> tuple[Curve, ...]:
    """A closed ring as lines and arcs within some mm, figures as plain as they are known.

    `edges` are the y of a wall's edges. What ends at one does so with a line: places of an arc
    that are as near to an edge as EDGE_NOISE would be taken for it.
    """
    from shapely import LineString
    from shapely import Point as Place

    ring = _with_corners(ring)
    # Without the places that lie on a line between their neighbours.
    places = [(x, y) for x, y in LineString([*ring, ring[0]]).simplify(STRAIGHT).coords[:-1]]
    through = LineString((places[-1], places[1]))
    if len(places) > 3 and through.distance(Place(places[0])) <= STRAIGHT:
        del places[0]
    sides = list(zip(places, [*places[1:], places[0]], strict=True))
    first = max(range(len(sides)), key=lambda k: dist(*sides[k]))
    places = _clear_of_edges([*places[first:], *places[: first + 1]], within, edges)
    on_edge = [any(abs(y - edge) <= PLACE for edge in edges) for _, y in places]
    curves: list[Line | Arc] = []
    begin = 0
    for k, (a, b) in enumerate(pairwise(places)):
        if on_edge[k] or on_edge[k + 1]:
            curves += arcs_and_lines(places[begin : k + 1], within)
            curves.append(Line(a, b))
            begin = k + 1
    curves += arcs_and_lines(places[begin:], within)
    if not any(isinstance(curve, Line) for curve in curves):
        return tuple(curves)
    around = zip([curves[-1], *curves[:-1]], curves, strict=True)
    joints = [_joint(before, curve, within) for before, curve in around]
    ends = [(plain(x, PLACE, DECIMALS), plain(y, PLACE, DECIMALS)) for x, y in joints]
    spans = zip(curves, ends, [*ends[1:], ends[0]], strict=True)
    return tuple([_between(curve, a, b, within) for curve, a, b in spans if a != b])


def _clear_of_edges(places: list[Point], within: float, edges: Sequence[float]) -> list[Point]:
    """Places without those between an edge and EDGE_NOISE off it, where a line does as well."""
    from shapely import LineString
    from shapely import Point as Place

    for edge in edges:
        off = [abs(y - edge) for _, y in places]
        near = [PLACE < d <= EDGE_NOISE + PLACE for d in off]
        kept = [places[0]]
        k = 1
        while k < len(places):
            last = k
            while last + 1 < len(places) and near[last]:
                last += 1
            line = LineString((kept[-1], places[last]))
            at_edge = min(off[k - 1], off[last]) <= PLACE < max(off[k - 1], off[last])
            if last > k and at_edge and all(
                line.distance(Place(p)) <= within for p in places[k:last]
            ):  # fmt: skip
                k = last
            kept.append(places[k])
            k += 1
        places = kept
    return places


def _with_corners(ring: Sequence[Point]) -> list[Point]:
    """A ring in which each fan of chords is the place where the long chords beside it meet."""
    from shapely import LineString
    from shapely import Point as Place

    sides = [dist(a, b) for a, b in zip(ring, [*ring[1:], ring[0]], strict=True)]
    count = len(ring)
    first = max(range(count), key=sides.__getitem__)
    order = [(first + k) % count for k in range(count)]
    points: list[Point] = []
    k = 0
    while k < count:
        i, total, more = order[k], 0.0, 0  # the fan begins at the i-th place
        while k + more < count and total + sides[order[k + more]] <= FAN:
            total += sides[order[k + more]]
            more += 1
        fan = [ring[(i + j) % count] for j in range(more + 1)]
        behind = ring[(i + more + 1) % count]
        corner = _meeting(ring[i - 1], fan[0], fan[-1], behind) if more else None
        if corner is not None and LineString(fan).distance(Place(corner)) <= FAN_DEEP:
            points.append(corner)
            k += more + 1
        else:
            points.append(ring[i])
            k += 1
    return points


def _meeting(a: Point, b: Point, c: Point, d: Point) -> Point | None:
    """Where the lines a b and c d meet; None if they are about parallel."""
    (ux, uy), (vx, vy) = (b[0] - a[0], b[1] - a[1]), (d[0] - c[0], d[1] - c[1])
    turn = ux * vy - uy * vx
    if abs(turn) <= 1e-6 * hypot(ux, uy) * hypot(vx, vy):
        return None
    t = ((c[0] - a[0]) * vy - (c[1] - a[1]) * vx) / turn
    return a[0] + t * ux, a[1] + t * uy


def _joint(before: Line | Arc, after: Line | Arc, within: float) -> Point:
    """Where two curves meet; of a line and an arc that touch, where they do."""
    line, arc = (before, after) if isinstance(after, Arc) else (after, before)
    if isinstance(line, Line) and isinstance(arc, Arc):
        (ax, ay), (dx, dy), (x, y) = line.start, line.tangent(0.0), arc.centre
        along = (x - ax) * dx + (y - ay) * dy
        foot = ax + along * dx, ay + along * dy
        touches = abs(dist(foot, arc.centre) - arc.radius) <= within
        # At d along a line from where an arc touches it they are about d^2 / 2R apart. A chord
        # of the arc has its own foot in its middle.
        most = min(sqrt(2 * arc.radius * within), line.length / 4)
        if touches and dist(foot, after.start) <= most:
            return foot
    return after.start


def _between(curve: Line | Arc, a: Point, b: Point, within: float) -> Curve:
    """A line or an arc from one place to another, of a plain radius where it is as near."""
    if isinstance(curve, Line):
        return Line(a, b)
    middle = curve.point(0.5)
    own = arc_by_points(a, middle, b)
    if own is None:
        return Line(a, b)
    half, side = dist(a, b) / 2, 1.0 if own.sweep_deg > 0.0 else -1.0
    to_right = (b[1] - a[1]) / (2 * half), (a[0] - b[0]) / (2 * half)
    radius = _plain_size(own.radius)
    if radius <= half:
        return own
    rise = radius - sqrt(radius * radius - half * half)
    if abs(own.sweep_deg) > 180.0:
        rise = 2 * radius - rise
    on = ((a[0] + b[0]) / 2 + side * rise * to_right[0],
          (a[1] + b[1]) / 2 + side * rise * to_right[1])  # fmt: skip
    plainer = arc_by_points(a, on, b)
    if plainer is None or abs(dist(middle, plainer.centre) - plainer.radius) > within:
        return own
    return plainer


def _plain_size(value: float) -> float:
    """A diameter or a radius: of those with one decimal at most the one that it is near to."""
    for places, slack in ((0, 4 * SIZE), (1, 2 * SIZE)):
        if abs(round(value, places) - value) <= slack:
            return round(value, places) + 0.0
    return round(value, DECIMALS)


def rounded_corners(curves: Sequence[Curve], radius: float, within: float) -> int:
    """How many re-entrant corners of a contour, steel on its left, have the machine's radius."""
    return sum(
        isinstance(c, Arc) and -170.0 < c.sweep_deg < 0.0 and abs(c.radius - radius) <= within
        for c in curves
    )
