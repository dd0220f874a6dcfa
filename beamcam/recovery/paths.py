"""Round holes, slots and marked lines from the paths that tools were led along."""

from collections.abc import Iterator, Sequence
from itertools import pairwise
from math import atan2, cos, degrees, dist, radians, sin, sqrt
from statistics import fmean

from msgspec import Struct

from beamcam.errors import Source
from beamcam.geometry.curves import Line, Point
from beamcam.model.part import Contour, Hole, Profile, Slot
from beamcam.recovery.found import plain
from beamcam.verify.bars.machined_features import MachinedPath
from beamcam.verify.bars.paths import pocket_error
from beamcam.verify.bars.targets import Pocket
from beamcam.verify.bars.tools import ToolCatalogue

MIN_CORNERS = 8  #: of a chain of chords that replaces a circle
MOST_SIDES = 64  #: of a path's hull that are tried as the direction of a slot, the longest


class NotAFeature(Struct, frozen=True):
    """A path that makes no feature of a part, and where it begins."""

    x: float
    y: float


def feature_of(
    trail: MachinedPath, shop: ToolCatalogue, profile: Profile, source: Source
) -> Hole | Slot | Contour | NotAFeature:
    """The feature that a path makes; its x counts from the part's start."""
    points = _apart(trail.points)
    if trail.kind == "scribe":
        lines = tuple([Line(a, b) for a, b in pairwise(points)])
        closed = dist(points[0], points[-1]) <= shop.machine.format.resolution
        return Contour(trail.face, "open", lines, source, "punch", closed)
    thickness = profile.thickness(trail.face)
    slack, decimals = shop.machine.format.resolution, shop.machine.format.length_decimals
    through = not thickness or trail.max_depth >= thickness - slack
    depth = None if through else plain(trail.max_depth, slack, decimals)
    allowed = shop.drill.path_tolerance + 2 * slack
    own, least = None, allowed
    for pocket in _pockets(points, trail, depth, slack, decimals):
        error = pocket_error(pocket, trail.points, trail.diameter)
        if error <= least:
            own, least = pocket, error
        if error <= slack:
            break
    if own is None:
        return NotAFeature(*trail.points[0])
    kind = "through" if through else "blind"
    place = trail.face, own.x, own.y, own.diameter
    is_round = not own.length and not own.height
    if is_round and shop.mills_round(own.diameter, trail.face):
        return Hole(*place, source, depth, kind)  # type: ignore[arg-type]
    return Slot(*place, own.length, own.height, own.angle, source, depth, kind)  # type: ignore[arg-type]


def _pockets(
    points: Sequence[Point],
    trail: MachinedPath,
    depth: float | None,
    slack: float,
    decimals: int,
) -> Iterator[Pocket]:
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
            diameter = plain(trail.diameter + 2 * rounding, 5 * slack, decimals)
            round_about = diameter - trail.diameter
            sizes = (plain(max(w - round_about, 0.0), 2 * slack, decimals) for w in (wide, high))
            length, height = sizes
            turned = angle
            if not (length or height):
                radius = fmean(dist(p, (u, v)) for p in own)
                diameter = plain(trail.diameter + 2 * radius, 5 * slack, decimals)
                turned = 0.0
            if height > length:
                length, height, turned = height, length, angle - 90.0 if angle > 0 else angle + 90.0
            x, y = (plain(p, slack, decimals) for p in (c * u - s * v, s * u + c * v))
            yield Pocket(
                0, trail.face, x, y, length, height, turned, diameter, depth, "",
                Hole(trail.face, x, y, diameter, Source("")),
            )  # fmt: skip


def _apart(points: Sequence[Point]) -> list[Point]:
    """The points without those that repeat the one before."""
    return [points[0], *(b for a, b in pairwise(points) if a != b)]


def _hull(points: Sequence[Point]) -> list[Point]:
    """The convex hull, counter-clockwise (Andrew's monotone chain)."""
    ordered = sorted(set(points))
    if len(ordered) < 3:
        return ordered

    def half(line: Sequence[Point]) -> list[Point]:
        kept: list[Point] = []
        for p in line:
            while len(kept) > 1 and _turn(kept[-2], kept[-1], p) <= 0.0:
                kept.pop()
            kept.append(p)
        return kept[:-1]

    return half(ordered) + half(ordered[::-1])


def _turn(a: Point, b: Point, c: Point) -> float:
    return (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])
