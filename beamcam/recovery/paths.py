"""Round holes, slots and marked lines from the paths of tools."""

from collections.abc import Iterator, Sequence
from itertools import pairwise
from math import atan2, cos, degrees, dist, hypot, radians, sin, sqrt
from statistics import fmean

from msgspec.structs import replace

from beamcam.checks.bars.paths import pocket_error
from beamcam.checks.bars.stations import MachinedPath
from beamcam.checks.bars.tools import ToolCatalogue
from beamcam.errors import Source
from beamcam.geometry.curves import Arc, Curve, Line, Point
from beamcam.geometry.plane import cross
from beamcam.model.part import Contour, Hole, HoleKind, Profile, Slot
from beamcam.recovery.recovered import plain

MIN_CORNERS = 8  #: of a chain of chords that replaces a circle
MOST_SIDES = 64  #: of a path's hull that are tried as the direction of a slot, the longest


def feature_of(
    path: MachinedPath, tools: ToolCatalogue, profile: Profile, source: Source
) -> Hole | Slot | Contour | None:
    """The feature that a path makes, its x from the part's start; None where it makes none."""
    points = [path.points[0], *(b for a, b in pairwise(path.points) if a != b)]
    slack, decimals = tools.machine.format.resolution, tools.machine.format.length_decimals
    if path.kind == "scribe":
        lines = tuple([Line(a, b) for a, b in pairwise(points)])
        closed = dist(points[0], points[-1]) <= slack
        return Contour(path.face, "open", lines, source, "punch", closed)
    thickness = profile.thickness(path.face)
    through = not thickness or path.max_depth >= thickness - slack
    depth = None if through else plain(path.max_depth, slack, decimals)
    own, least = None, tools.drill.path_tolerance + 2 * slack
    for pocket in _pockets(points, path, depth, slack, decimals, source):
        error = pocket_error(pocket, path.points, path.diameter)
        if error <= least:
            own, least = pocket, error
        if error <= slack:
            break
    if own is None:
        return None
    kind: HoleKind = "through" if through else "blind"
    is_round = not own.length and not own.height
    if is_round and tools.mills_round(own.diameter, path.face):
        return Hole(own.face, own.x, own.y, own.diameter, source, depth, kind)
    return replace(own, kind=kind)


def _pockets(
    points: Sequence[Point], path: MachinedPath, depth: float | None, slack: float, decimals: int,
    source: Source,
) -> Iterator[Slot]:  # fmt: skip
    """Possible pockets of a mill's path: a circle, or rectangles with round corners.

    The path's hull is the pocket drawn in by the mill: a side of it is the pocket's direction, the
    longest most likely, and its extents are those of the pocket less the mill's diameter. How round
    its corners are is tried: as much as there is room for, not at all, and by how far the hull
    stays off the corners. A circle is as large as the corners of its chords are far apart.
    """
    hull = _hull(points)
    turns = [0.0] if len(hull) >= MIN_CORNERS else []
    sides = sorted(zip(hull, [*hull[1:], hull[0]], strict=True), key=lambda side: -dist(*side))
    # A short slot's own sides may be shorter than the chords of its ends.
    for a, b in sides[:MOST_SIDES]:
        raw = degrees(atan2(b[1] - a[1], b[0] - a[0]))
        slant = degrees(1.5 * slack / max(dist(a, b), slack))
        turns.append(plain(90.0 - (90.0 - raw) % 180.0, slant, 3))
    for angle in dict.fromkeys(turns):
        c, s = cos(radians(angle)), sin(radians(angle))
        own = [(c * x + s * y, c * y - s * x) for x, y in hull]
        xs, ys = [x for x, _ in own], [y for _, y in own]
        u, v = (min(xs) + max(xs)) / 2, (min(ys) + max(ys)) / 2
        wide, high = max(xs) - min(xs), max(ys) - min(ys)
        off = min(dist(p, (max(xs), max(ys))) for p in own)
        for rounding in (min(wide, high) / 2, 0.0, off / (sqrt(2) - 1)):
            diameter = plain(path.diameter + 2 * rounding, 5 * slack, decimals)
            cut = diameter - path.diameter
            length, height = (plain(max(w - cut, 0.0), 2 * slack, decimals) for w in (wide, high))
            turned = angle
            if not (length or height):
                radius = fmean(dist(p, (u, v)) for p in own)
                diameter = plain(path.diameter + 2 * radius, 5 * slack, decimals)
                turned = 0.0
            if height > length:
                length, height, turned = height, length, angle - 90.0 if angle > 0 else angle + 90.0
            x, y = (plain(p, slack, decimals) for p in (c * u - s * v, s * u + c * v))
            yield Slot(path.face, x, y, diameter, length, height, turned, source, depth)


def _hull(points: Sequence[Point]) -> list[Point]:
    """The convex hull, counter-clockwise (Andrew's monotone chain)."""
    ordered = sorted(set(points))
    if len(ordered) < 3:
        return ordered

    def half(line: Sequence[Point]) -> list[Point]:
        kept: list[Point] = []
        for p in line:
            while len(kept) > 1 and cross(_way(kept[-2], kept[-1]), _way(kept[-2], p)) <= 0.0:
                kept.pop()
            kept.append(p)
        return kept[:-1]

    return half(ordered) + half(ordered[::-1])


def _way(a: Point, b: Point) -> Point:
    return b[0] - a[0], b[1] - a[1]


# --- rings ----------------------------------------------------------------------------------------

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
    """A ring whose first and last curve are one where it was begun within a line or an arc."""
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
    """Curves that join two pieces of a contour over the bridge between them."""
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
    is_between = long > max(dist(a, point), dist(point, b))
    return abs(cross(_way(a, b), _way(a, point))) / long if is_between else long


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
