"""Shape of a closed chain of curves: a circle, a slot, or a polygon with rounded corners.

Exporters write arcs as polygons whose vertices lie on the circle; `with_arcs` takes such runs
back to arcs before anything is measured.
"""

from collections.abc import Sequence
from math import atan2, copysign, dist, hypot, pi, radians, sin, tan

from msgspec import Struct

from beamcam.geometry.conics import arc_by_points
from beamcam.geometry.curves import Arc, Curve, Line, Point, circle_of, slot_of
from beamcam.geometry.plane import Box, cross, dot

Chain = tuple[Curve, ...]

MIN_CORNERS = 12  #: of a polygon that stands for a circle; fewer are meant as they are
MIN_RUN = 3  #: chords of a polygon that stand for an arc
STEEPEST_RAD = 2 * pi / MIN_CORNERS + 0.02  #: between chords of one arc
COARSE_RAD = radians(2)  #: between chords that are no straight line
FINEST_RAD = radians(0.2)
MANY_CHORDS = 45  #: of a quarter circle, where they turn less than that
ON_CIRCLE = 0.02  #: mm that a vertex may lie off its circle
ROUND_DEG = 0.5  #: that arcs may turn more or less than a circle or a half
PARALLEL_RAD = 1e-4
NO_SIDE = 1e-6  #: mm of a line that is none
STRAIGHT = 0.002  #: mm that a point may lie off the line between its neighbours
LONGER = 4.0  #: times the chords beside it, a line is a side and no chord of a rounding
GENTLE_RAD = 0.55  #: between the chords of a rounding
MIN_ROUND = 0.5  #: mm of a corner that is rounded off
UNEVEN = 0.1  #: share by which a rounding may reach further along one side
SHARP_RAD = 0.3  #: by which a rounding may be off the side it runs into


class Round(Struct, frozen=True, gc=False, cache_hash=True):
    """A circle."""

    centre: Point
    diameter: float


class Slotted(Struct, frozen=True, gc=False, cache_hash=True):
    """A slot: two half circles and the lines between them."""

    centre: Point
    diameter: float
    length: float  #: centre to centre, along `angle`
    angle: float  #: degrees, from 0 to below 180


def box_around(chain: Chain) -> Box:
    """The bounding box of a chain that is not empty."""
    x0, y0, x1, y1 = zip(*(curve.bbox for curve in chain), strict=True)
    return min(x0), min(y0), max(x1), max(y1)


def with_arcs(chain: Chain) -> Chain:
    """The chain with polygon runs on a circle as arcs, and pieces of one curve joined."""
    if not all(isinstance(c, Line) for c in chain):
        return joined(chain)
    # Chords that turn less than this lie on one line for `joined`, two by two.
    fine = _arcs_of_runs(chain, FINEST_RAD, COARSE_RAD) if len(chain) >= MANY_CHORDS else chain
    lines = joined(fine)
    if len(lines) < MIN_RUN + 1:
        return lines
    whole = _regular(lines if fine is chain else joined(chain))
    return _arcs_of_runs(lines, COARSE_RAD, STEEPEST_RAD) if whole is None else whole


def _arcs_of_runs(lines: Chain, least: float, most: float) -> Chain:
    """The chain with an arc for each run of chords, which turn by `least` to `most` radians."""
    n = len(lines)
    fits = [_alike(lines[i - 1], lines[i], least, most) for i in range(n)]
    breaks = [i for i in range(n) if not fits[i]]
    if not breaks or len(breaks) == n:
        return lines
    out: list[Curve] = []
    for k, first in enumerate(breaks):
        last = breaks[(k + 1) % len(breaks)]
        run = [lines[(first + j) % n] for j in range((last - first - 1) % n + 1)]
        points = [*(c.start for c in run), run[-1].end]
        arc = _through(points, 0, len(run) // 2, -1) if len(run) >= MIN_RUN else None
        out += [arc] if arc is not None else run
    return tuple(out)


def joined(chain: Chain) -> Chain:
    """The chain with neighbours joined that lie on one line or on one circle."""
    out: list[Curve] = []
    for curve in chain:
        both = _join(out[-1], curve) if out else None
        if both is not None:
            out[-1] = both
        else:
            out.append(curve)
    both = _join(out[-1], out[0]) if len(out) > 1 else None
    return tuple(out if both is None else [both, *out[1:-1]])


def _join(a: Curve, b: Curve) -> Curve | None:
    """Two neighbours as one curve, where they are one."""
    if isinstance(a, Line) and isinstance(b, Line):
        (px, py), (qx, qy), (rx, ry) = a.start, a.end, b.end
        dx, dy, ex, ey = qx - px, qy - py, rx - b.start[0], ry - b.start[1]
        angle = abs(atan2(dx * ey - dy * ex, dx * ex + dy * ey))
        if angle >= SHARP_RAD:
            return None
        if angle >= PARALLEL_RAD:
            long, longer = hypot(dx, dy), hypot(ex, ey)
            if angle * long * longer >= STRAIGHT * (long + longer):
                return None
        return Line(a.start, b.end)
    if isinstance(a, Arc) and isinstance(b, Arc):
        same = dist(a.centre, b.centre) < 1e-3 and abs(a.radius - b.radius) < 1e-3
        sweep = a.sweep_deg + b.sweep_deg
        if same and a.sweep_deg * b.sweep_deg > 0 and abs(sweep) <= 360.0 + 1e-6:
            return Arc(a.centre, a.radius, a.start_deg, max(-360.0, min(360.0, sweep)))
    return None


def turn(a: Curve, b: Curve) -> float:
    """Angle from the end of `a` to the start of `b` in radians, from -pi to pi."""
    ahead, way = a.tangent(1.0), b.tangent(0.0)
    return atan2(cross(ahead, way), dot(ahead, way))


def _alike(a: Curve, b: Curve, least: float, most: float) -> bool:
    """Whether two lines may be neighbouring chords of one circle."""
    return (
        isinstance(a, Line)
        and isinstance(b, Line)
        and least < abs(turn(a, b)) < most
        and abs(a.length - b.length) < 0.02 * a.length + 0.01
    )


def _regular(lines: Chain) -> Chain | None:
    """The full circle that all vertices of a polygon lie on."""
    if len(lines) < MIN_CORNERS:
        return None
    points, n = [c.start for c in lines], len(lines)
    third, longest = _through(points, 0, n // 3, 2 * n // 3), max(c.length for c in lines)
    if third is None or longest > 2 * third.radius * sin(pi / MIN_CORNERS) + ON_CIRCLE:
        return None
    return (Arc(third.centre, third.radius, third.start_deg, copysign(360.0, third.sweep_deg)),)


def _through(points: Sequence[Point], *picked: int) -> Arc | None:
    """The arc by three of some points, if all of them lie on its circle."""
    arc = arc_by_points(*(points[k] for k in picked))
    if arc is None or any(abs(dist(p, arc.centre) - arc.radius) >= ON_CIRCLE for p in points):
        return None
    return arc


def shape_of(chain: Chain) -> Round | Slotted | None:
    """A circle or a slot where the chain is one; None for everything else."""
    # A radius that rounding makes a hair less than half a slot's width leaves no side.
    curves = with_arcs(tuple(c for c in chain if c.length > NO_SIDE))
    if (circle := circle_of(curves, ON_CIRCLE, ROUND_DEG)) is not None:
        return Round(circle[0], 2 * circle[1])
    if (slot := slot_of(curves, ON_CIRCLE, ROUND_DEG)) is not None:
        middle, length, width, angle = slot
        return Slotted(middle, width, length - width, round(angle, 9) % 180.0)
    return None


class Corner(Struct, frozen=True, gc=False):
    """A corner of a polygon, counter-clockwise, and the rounding it had."""

    at: Point
    radius: float
    reflex: bool  #: an inner corner, as where web and flange meet


def sharpened(chain: Chain) -> Chain:
    """The chain with every run of gentle turns as one arc, or as the corner that it rounds off.

    Meshes have roundings whose chords are of any length, so that no circle is found again.
    """
    lines = [c for c in joined(chain) if isinstance(c, Line)]
    n = len(lines)
    turns = [turn(lines[i - 1], lines[i]) for i in range(n)]  # before line i
    gentle = [abs(t) < GENTLE_RAD for t in turns]
    sides: list[Line] = []
    for i, line in enumerate(lines):
        beside = max(lines[i - 1].length, lines[(i + 1) % n].length)
        sharp = not (gentle[i] and gentle[(i + 1) % n])
        if sharp or line.length > LONGER * beside:
            sides.append(line)
    corners = list(map(_rounded, sides, [*sides[1:], *sides[:1]]))
    met = [corner for corner in corners if corner is not None]
    if len(sides) < 4 or len(met) < len(sides):
        return chain
    out: list[Curve] = []
    for (*_, leave), (enter, rounding, _) in zip([met[-1], *met], met, strict=False):
        out += [Line(leave, enter), *rounding]
    return tuple(out)


def _rounded(before: Line, after: Line) -> tuple[Point, tuple[Arc, ...], Point] | None:
    """Where the corner of two sides begins, the arc that rounds it off, if any, and where it ends.

    None where the sides never meet.
    """
    at = _meet(_side(before), _side(after))
    if at is None:
        return None
    (ax, ay), (bx, by), (x, y) = before.end, after.start, at
    first, second = hypot(ax - x, ay - y), hypot(bx - x, by - y)
    half = abs(turn(before, after)) / 2
    if min(first, second) < MIN_ROUND or abs(first - second) > UNEVEN * max(first, second):
        return at, (), at
    reach = (first + second) / 2
    ux, uy = before.tangent(0.5)
    vx, vy = after.tangent(0.5)
    deep = reach * tan(half / 2)
    wx, wy = vx - ux, vy - uy
    long = hypot(wx, wy)
    middle = (x + wx / long * deep, y + wy / long * deep)
    start, end = (x - ux * reach, y - uy * reach), (x + vx * reach, y + vy * reach)
    arc = arc_by_points(start, middle, end)
    return (at, (), at) if arc is None else (arc.start, (arc,), arc.end)


def corners_of(curves: Chain) -> tuple[Corner, ...] | None:
    """The sharp corners of a chain of lines and roundings; None if it is not such a polygon.

    The chain has its arcs already. Chamfers at inner corners, as coarse tessellations have them,
    count as roundings.
    """
    kinds = [type(c) for c in curves]
    if Line not in kinds or kinds.count(Line) + kinds.count(Arc) != len(kinds):
        return None
    start = kinds.index(Line)
    curves = curves[start:] + curves[:start]
    sides: list[_Side] = []
    for i, curve in enumerate(curves):
        if not isinstance(curve, Arc):
            sides.append(_Side(curve.start, curve.tangent(0.0)))
            continue
        # A toe as round as the leg is thick starts at a sharp edge: its tip is a side of length 0.
        if abs(turn(curves[i - 1], curve)) > SHARP_RAD:
            sides.append(_Side(curve.start, curve.tangent(0.0)))
        sides[-1].radius = max(sides[-1].radius, curve.radius)
        if abs(turn(curve, curves[(i + 1) % len(curves)])) > SHARP_RAD:
            sides.append(_Side(curve.end, curve.tangent(1.0)))
    met = map(_meet, sides, [*sides[1:], *sides[:1]])
    points, radii = [at for at in met if at is not None], [side.radius for side in sides]
    if len(points) < len(sides):
        return None
    if sum(map(cross, points, [*points[1:], points[0]])) < 0:
        points, radii = points[::-1], radii[::-1]
    return _unchamfered(list(map(Corner, points, radii, reflex(points))))


def reflex(points: Sequence[Point]) -> tuple[bool, ...]:
    """Whether each corner of a polygon, counter-clockwise, is an inner one."""
    ways = [(b[0] - a[0], b[1] - a[1]) for a, b in zip([points[-1], *points], points, strict=False)]
    return tuple(cross(a, b) < 0 for a, b in zip(ways, [*ways[1:], ways[0]], strict=True))


class _Side(Struct, gc=False):
    """A side of a polygon, and the radius of the rounding that follows it."""

    at: Point
    way: Point
    radius: float = 0.0


def _side(line: Line) -> _Side:
    return _Side(line.start, line.tangent(0.5))


def _meet(a: _Side, b: _Side) -> Point | None:
    """Intersection of two sides when both are extended."""
    (px, py), (qx, qy) = a.at, b.at
    (dx, dy), (ex, ey) = a.way, b.way
    det = dx * ey - dy * ex
    if abs(det) < 0.02:
        return None
    t = ((qx - px) * ey - (qy - py) * ex) / det
    return px + t * dx, py + t * dy


def _unchamfered(corners: list[Corner]) -> tuple[Corner, ...]:
    """The corners with each pair of inner ones that a chamfer joins as the corner it cuts off."""
    n = len(corners)
    for i in range(n if n >= 8 else 0):
        before, a, b, after = (corners[(i + k) % n] for k in (-1, 0, 1, 2))
        if not (a.reflex and b.reflex):
            continue
        legs = Line(before.at, a.at), Line(a.at, b.at), Line(b.at, after.at)
        first, second = turn(legs[0], legs[1]), turn(legs[1], legs[2])
        at = _meet(_side(legs[0]), _side(legs[2]))
        if at is not None and abs(first - second) < 0.02 and abs(first + pi / 4) < 0.25:
            rest = [*corners, *corners][i + 2 : i + n]
            return _unchamfered([Corner(at, dist(at, a.at), True), *rest])
    return tuple(corners)
