"""Whether a path makes a pocket, or follows a line.

A mill of radius m leaves a pocket if its path never leaves the pocket drawn in by m, and if every
point of the outline lies within m of the path; a blind pocket has to be cleared inside as well.
Both are measured on points so close that what lies between them cannot matter.
"""

from collections.abc import Iterator, Sequence
from itertools import pairwise
from math import ceil, cos, dist, hypot, pi, radians, sin, sqrt

from beamcam.geometry.curves import Curve, Point
from beamcam.verify.bars.targets import Pocket

STEP = 1.0  #: mm between the points that are measured, where a line is not too tight for it
FLAT = 0.001  #: mm between a line and the chords that it is measured by
MOST_CHORDS = 4096


def pocket_error(pocket: Pocket, path: Sequence[Point], mill: float) -> float:
    """Deviation of the pocket that a path makes, in mm, on the part's x and y.

    The greater of what is cut beyond the outline and what of it is left standing.
    """
    c, s = cos(radians(pocket.angle)), sin(radians(pocket.angle))
    own = [
        (c * (x - pocket.x) + s * (y - pocket.y), c * (y - pocket.y) - s * (x - pocket.x))
        for x, y in path
    ]
    half_x, half_y = pocket.length / 2, pocket.height / 2
    radius, cutter = pocket.diameter / 2, mill / 2
    beyond = max(_from_core(p, half_x, half_y) for p in own) + cutter - radius
    left = max(
        distance_to(p, own) - cutter
        for p in _to_clear(half_x, half_y, radius, cutter, pocket.depth is not None)
    )
    return max(beyond, left, 0.0)


def _from_core(point: Point, half_x: float, half_y: float) -> float:
    """Distance from the rectangle of the corner circles' centres; 0 inside."""
    return hypot(max(abs(point[0]) - half_x, 0.0), max(abs(point[1]) - half_y, 0.0))


def _to_clear(
    half_x: float, half_y: float, radius: float, cutter: float, blind: bool
) -> Iterator[Point]:
    """Points of the outline; of a blind pocket those inside too."""
    insets = [radius]
    if blind:
        depth = radius + max(half_x, half_y)
        count = max(1, ceil(depth / max(cutter / 2, STEP)))
        insets += [radius - depth * (i + 1) / count for i in range(count)]
    for inset in insets:
        yield from _outline(
            max(0.0, half_x + min(inset, 0.0)), max(0.0, half_y + min(inset, 0.0)), max(inset, 0.0)
        )


def _outline(half_x: float, half_y: float, radius: float) -> Iterator[Point]:
    """Points of a rectangle with round corners about 0, 0."""
    corners = [(half_x, half_y), (-half_x, half_y), (-half_x, -half_y), (half_x, -half_y)]
    count = max(1, ceil(radius * pi / 2 / STEP))
    points = [
        (x + radius * cos(pi / 2 * (quarter + i / count)),
         y + radius * sin(pi / 2 * (quarter + i / count)))
        for quarter, (x, y) in enumerate(corners)
        for i in range(count + 1)
    ]  # fmt: skip
    for a, b in pairwise([*points, points[0]]):
        yield a
        steps = ceil(dist(a, b) / (2 * STEP))
        for i in range(1, steps):
            yield a[0] + (b[0] - a[0]) * i / steps, a[1] + (b[1] - a[1]) * i / steps


def line_error(curves: Sequence[Curve], path: Sequence[Point]) -> float:
    """Maximum distance between a path and a chain of curves, in mm.

    Measured both ways, and at both ends, whichever way round the path is gone.
    """
    drawn = [curves[0].start]
    for curve in curves:
        drawn += _points(curve)[1:]
    off = max(distance_to(p, path) for p in drawn)
    back = max(distance_to(p, drawn) for p in _between(path))
    (a, b), (c, d) = (drawn[0], drawn[-1]), (path[0], path[-1])
    ends = min(max(dist(a, c), dist(b, d)), max(dist(a, d), dist(b, c)))
    return max(off, back, ends)


def _points(curve: Curve) -> list[Point]:
    """Points of a curve, so close that its chords lie within `FLAT` of it."""
    count = max(4, min(400, ceil(curve.length / STEP)))
    while True:
        points = [curve.point(i / count) for i in range(count + 1)]
        middles = (curve.point((i + 0.5) / count) for i in range(count))
        pairs = zip(middles, pairwise(points), strict=True)
        if count >= MOST_CHORDS or all(distance_to(m, chord) <= FLAT for m, chord in pairs):
            return points
        count *= 2


def _between(path: Sequence[Point]) -> Iterator[Point]:
    for a, b in pairwise(path):
        yield a
        yield (a[0] + b[0]) / 2, (a[1] + b[1]) / 2
    yield path[-1]


def distance_to(point: Point, path: Sequence[Point]) -> float:
    """Distance of a point from a polyline."""
    x, y = point
    ax, ay = path[0]
    best = (ax - x) ** 2 + (ay - y) ** 2
    for bx, by in path:
        dx, dy, px, py = bx - ax, by - ay, x - ax, y - ay
        along = px * dx + py * dy
        square = dx * dx + dy * dy
        if along >= square:  # nearest to the segment's end, or it has no length
            off = (bx - x) ** 2 + (by - y) ** 2
        elif along > 0.0:
            off = (px * dy - py * dx) ** 2 / square
        else:
            off = px * px + py * py
        if off < best:
            best = off
        ax, ay = bx, by
    return sqrt(best)
