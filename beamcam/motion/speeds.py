"""Speeds that the axes of a table can follow: the feed of each move, and ramps between speeds.

A controller that is given accelerations takes the feed for granted: it turns the head on the
smallest arc as fast as commanded. So the feed is lowered where a move asks for too much:

    along a line       v |cos| <= speed of X, v |sin| <= speed of Y
    around a radius r  v^2 / r <= acceleration across, v^3 / r^2 <= jerk, v <= both speeds
"""

from collections.abc import Iterator, Sequence
from itertools import groupby, repeat
from math import cbrt, cos, hypot, inf, radians, sin, sqrt
from operator import itemgetter

import numpy as np
from numpy.typing import NDArray

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


# --- jerk ramps -----------------------------------------------------------------------------------

# Jerk-limited ramps for many stretches at once.
#
# A ramp changes the speed by `change` from and to acceleration 0. It takes change / a + a / j, or
# 2 sqrt(change / j) where it is too small to reach the acceleration a, and it is symmetric: the
# way is the mean speed times the time.


#: A reached speed is lowered by this share, so that rounding never leaves a ramp without room.
REACH_SLACK = 1e-12


def reachable_speed(speed: float, way: float, acceleration: float, jerk: float) -> float:
    """The highest speed at the far end of `way` of a ramp from `speed`; the same backwards.

    In the root s of the change the way of a short ramp is s (2 speed + s^2) / sqrt(jerk): solved
    by Newton's method from above, where it converges without overshooting. A long ramp is a
    quadratic in the change.
    """
    if way <= 0.0:
        return speed
    if jerk == inf:
        return sqrt(speed * speed + 2 * acceleration * way) * (1 - REACH_SLACK)
    bound = acceleration / sqrt(jerk)
    scaled = way * sqrt(jerk)
    if bound * (2 * speed + bound * bound) >= scaled:
        s = cbrt(scaled)
        if speed > 0.0:
            s = min(s, scaled / (2 * speed))
        for _ in range(50):
            step = (s * (2 * speed + s * s) - scaled) / (2 * speed + 3 * s * s)
            s -= step
            if step <= 1e-14 * s:
                break
        return speed + s * s * (1 - REACH_SLACK)
    # change^2 / 2a + change (speed / a + a / 2j) + speed a / j - way = 0
    half = speed + acceleration * acceleration / (2 * jerk)
    rest = 2 * acceleration * (way - speed * acceleration / jerk)
    return speed + (sqrt(half * half + rest) - half) * (1 - REACH_SLACK)


def ramp_seconds(change: Floats, acceleration: Floats, jerk: Floats) -> Floats:
    """Time of ramps that change the speed by `change` >= 0."""
    with np.errstate(invalid="ignore"):
        long = change * jerk >= acceleration * acceleration
    seconds: Floats = np.where(
        long, change / acceleration + acceleration / jerk, 2 * np.sqrt(change / jerk)
    )
    return np.where(change > 0.0, seconds, 0.0)


def peak_rises(
    way: Floats, low: Floats, high: Floats, cap: Floats, acceleration: Floats, jerk: Floats
) -> Floats:
    """How far the peaks of stretches lie above their higher end speeds, at most cap - high.

    Halves the root of the rise, of which the way is a smooth function, to neighbouring floats.
    """
    rises = np.maximum(cap - high, 0.0)
    roots = np.sqrt(rises)
    some = np.flatnonzero(~_fits(roots * roots, way, low, high, acceleration, jerk))
    if len(some):
        limits = [values[some] for values in (way, low, high, acceleration, jerk)]
        a, b = np.zeros(len(some)), roots[some]
        for _ in range(54):
            middle = (a + b) / 2
            fits = _fits(middle * middle, *limits)
            a, b = np.where(fits, middle, a), np.where(fits, b, middle)
        rises[some] = a * a
    return rises


def _fits(
    rise: Floats, way: Floats, low: Floats, high: Floats, acceleration: Floats, jerk: Floats
) -> NDArray[np.bool_]:
    """Whether the ramps to peaks so far above the higher end speeds fit into the way."""
    change = high - low + rise
    up = (high + rise / 2) * ramp_seconds(rise, acceleration, jerk)
    down = (low + change / 2) * ramp_seconds(change, acceleration, jerk)
    return np.asarray(up + down <= way)


def stretch_seconds(
    way: Floats, first: Floats, last: Floats, cap: Floats, acceleration: Floats, jerk: Floats
) -> Floats:
    """Times over ways that are entered at speeds `first` and left at `last`, at most at `cap`.

    The speed rises to a peak and falls. The ramps have to fit: `last` can be reached from `first`.
    """
    low, high = np.minimum(first, last), np.maximum(first, last)
    peak = high + peak_rises(way, low, high, cap, acceleration, jerk)
    up, down = (ramp_seconds(peak - end, acceleration, jerk) for end in (first, last))
    cruise = np.maximum(0.0, way - (peak + first) / 2 * up - (peak + last) / 2 * down)
    seconds: Floats = up + down + cruise / np.where(peak > 0.0, peak, 1.0)
    return seconds


def ramp_phases(
    change: Floats, acceleration: Floats, jerk: Floats
) -> tuple[Floats, Floats, Floats]:
    """Durations, accelerations at the start and jerks of the three phases of ramps: (n, 3)."""
    size = np.abs(change)
    time_s = ramp_seconds(size, acceleration, jerk)
    # Never more than the limit, and never more than the time allows.
    with np.errstate(invalid="ignore"):
        peak = np.where(size > 0.0, np.minimum(acceleration, np.sqrt(size * jerk)), 0.0)
    rise = np.where(time_s > 0.0, peak / jerk, 0.0)
    stay = time_s - 2 * rise
    stay = np.where(stay > 1e-12 * time_s, stay, 0.0)
    sign = np.sign(change)
    zero = np.zeros_like(size)
    durations = np.column_stack((rise, stay, rise))
    starts = np.column_stack((zero, sign * peak, sign * peak))
    held = sign * np.where(np.isinf(jerk), 0.0, jerk)
    return durations, starts, np.column_stack((held, zero, -held))
