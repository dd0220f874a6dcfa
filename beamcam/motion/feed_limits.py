"""The feed of each move that the axes of a table can follow.

A controller that is given accelerations takes the feed for granted: it turns the head on the
smallest arc as fast as commanded. So the feed is lowered where a move asks for too much:

    along a line       v |cos| <= speed of X, v |sin| <= speed of Y
    around a radius r  v^2 / r <= acceleration across, v^3 / r^2 <= jerk, v <= both speeds
"""

from collections.abc import Iterator, Sequence
from itertools import groupby, repeat
from math import cos, hypot, inf, radians, sin, sqrt
from operator import itemgetter

import numpy as np

from beamcam.geometry.array_types import Floats
from beamcam.geometry.plane import Point, cross
from beamcam.machine.machine import PathLimits
from beamcam.model.program import ArcFeed, EllipseFeed, Feed, Movement, ParabolaFeed, SetFeed

# --- bending --------------------------------------------------------------------------------------

# Minimum radii of curves, which limit the speed along them.


def min_radius_of_parabola(start: Point, vertex: Point, end: Point) -> float:
    """Minimum radius of the parabola whose tangent at `vertex` is parallel to its chord.

    As a quadratic Bezier curve with the legs p and q its velocity is twice w = p + t (q - p) and
    its curvature p x q / (2 |w|^3): greatest where w is shortest, at the place of the segment
    from p to q that is nearest to the origin. inf for a straight line.
    """
    control = 2 * vertex[0] - (start[0] + end[0]) / 2, 2 * vertex[1] - (start[1] + end[1]) / 2
    px, py = control[0] - start[0], control[1] - start[1]
    dx, dy = end[0] - control[0] - px, end[1] - control[1] - py
    turn = abs(cross((px, py), (dx, dy)))
    if turn == 0.0:
        return inf
    t = min(1.0, max(0.0, -(px * dx + py * dy) / (dx * dx + dy * dy)))
    return 2.0 * hypot(px + t * dx, py + t * dy) ** 3 / turn


def min_radius_of_ellipse(on_it: Point, angle_deg: float, ratio: float) -> float:
    """Minimum radius of an ellipse through a point relative to its centre: b^2 / a.

    `angle_deg` is the direction of its main axis, `ratio` is b / a.
    """
    c, s = cos(radians(angle_deg)), sin(radians(angle_deg))
    major = hypot(c * on_it[0] + s * on_it[1], (c * on_it[1] - s * on_it[0]) / ratio)
    return major * ratio * ratio


SECONDS_PER_MINUTE = 60.0

TINY = 1e-300  #: in place of a length that is divided by

#: A feed is not lowered by less than this share: no machine shows it.
WORTH_LOWERING = 1e-3


def paced(
    start: Point, moves: Sequence[Movement], feed_mm_min: float, shares: Sequence[float],
    limits: PathLimits | None,
) -> Iterator[Movement | SetFeed]:  # fmt: skip
    """The moves from `start`, and before each whose feed differs from the last one its own.

    `shares` are those of the feed that are asked of each move; without `limits` that is its feed.
    """
    now = feed_mm_min / SECONDS_PER_MINUTE
    for share, group in groupby(zip(moves, shares, strict=True), key=itemgetter(1)):
        stretch = [move for move, _ in group]
        feed_mm_s = feed_mm_min * share / SECONDS_PER_MINUTE
        feeds = repeat(feed_mm_s) if limits is None else _feeds(start, stretch, feed_mm_s, limits)
        for move, feed in zip(stretch, feeds, strict=False):
            if feed != now:
                yield SetFeed(feed * SECONDS_PER_MINUTE)
                now = feed
            yield move
        start = stretch[-1].x, stretch[-1].y


def _feeds(
    start: Point, moves: Sequence[Movement], feed_mm_s: float, limits: PathLimits
) -> Iterator[float]:
    """The speed of each move, at most what is asked."""
    worth = feed_mm_s * (1.0 - WORTH_LOWERING)
    calm = calm_radius(feed_mm_s, limits)
    unbounded = feed_mm_s <= limits.speed_mm_s
    here = start
    for move in moves:
        if unbounded and (
            type(move) is Feed
            or (type(move) is ArcFeed and move.i * move.i + move.j * move.j >= calm * calm)
        ):
            feed = feed_mm_s
        else:
            feed = min(feed_mm_s, _feasible_mm_s(here, move, limits))
            feed = feed_mm_s if feed > worth else feed
        yield feed
        here = move.x, move.y


def calm_radius(speed_mm_s: float, limits: PathLimits) -> float:
    """The minimum radius that the head can follow at a speed."""
    by_jerk = sqrt(speed_mm_s**3 / limits.jerk_mm_s3)
    return max(speed_mm_s * speed_mm_s / limits.across_mm_s2, by_jerk)


def straight_mm_s(steps: Floats, limits: PathLimits) -> Floats:
    """The maximum speeds at which the axes can follow lines by their steps (n, 2) in X and Y."""
    along = np.abs(steps) / np.maximum(np.hypot(steps[:, 0], steps[:, 1]), TINY)[:, None]
    speeds: Floats = np.min((limits.speed_x_mm_s, limits.speed_y_mm_s) / np.maximum(along, TINY), 1)
    return speeds


def turning_mm_s(radii: Floats, limits: PathLimits) -> Floats:
    """The maximum speeds around radii; the inverse of `calm_radius`."""
    by_jerk = np.cbrt(limits.jerk_mm_s3 * radii * radii)
    by_acceleration = np.sqrt(limits.across_mm_s2 * radii)
    speeds: Floats = np.minimum(limits.speed_mm_s, np.minimum(by_acceleration, by_jerk))
    return speeds


def _feasible_mm_s(here: Point, move: Movement, limits: PathLimits) -> float:
    """The maximum speed at which the axes can follow a move that starts `here`."""
    if isinstance(move, Feed):
        steps = np.array([(move.x - here[0], move.y - here[1])])
        return float(straight_mm_s(steps, limits)[0])
    return float(turning_mm_s(np.array(min_radius(here, move)), limits))


def min_radius(here: Point, move: ArcFeed | ParabolaFeed | EllipseFeed) -> float:
    """Minimum radius of curvature of a curve that starts `here`; for an ellipse, of all of it."""
    if isinstance(move, ArcFeed):
        return hypot(move.i, move.j)
    if isinstance(move, ParabolaFeed):
        vertex = here[0] + move.i, here[1] + move.j
        return min_radius_of_parabola(here, vertex, (move.x, move.y))
    return min_radius_of_ellipse((-move.i, -move.j), move.angle, move.ratio)
