"""Speeds that the axes of a table can follow: along lines and curves, ramps, sections of a path.

A controller that is given accelerations takes the feed for granted: it turns the head on the
smallest arc as fast as commanded. So the feed is lowered where a move asks for too much:

    along a line       v |cos| <= speed of X, v |sin| <= speed of Y
    around a radius r  v^2 / r <= acceleration across, v^3 / r^2 <= jerk, v <= both speeds
"""

from math import cbrt, cos, hypot, inf, radians, sin, sqrt

import numpy as np
from msgspec import Struct
from numpy.typing import NDArray

from beamcam.geometry.array_types import Floats
from beamcam.geometry.plane import Point, cross
from beamcam.machine.machine import PathLimits
from beamcam.model import cell_motion
from beamcam.model.program import ArcFeed, EllipseFeed, ParabolaFeed


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


TINY = 1e-300  #: in place of a length that is divided by


def calm_radius(speed_mm_s: float, limits: PathLimits) -> float:
    """The minimum radius that the head can follow at a speed."""
    by_jerk = sqrt(speed_mm_s**3 / limits.jerk_mm_s3)
    return max(speed_mm_s * speed_mm_s / limits.across_mm_s2, by_jerk)


def straight_mm_s(steps: Floats, limits: PathLimits) -> Floats:
    """The maximum speeds at which the axes can follow lines by their steps (n, 2) in X and Y."""
    along = np.abs(steps) / np.maximum(np.hypot(steps[:, 0], steps[:, 1]), TINY)[:, None]
    axes = (limits.speed_x_mm_s, limits.speed_y_mm_s)
    return np.asarray(np.min(axes / np.maximum(along, TINY), axis=1))


def turning_mm_s(radii: Floats, limits: PathLimits) -> Floats:
    """The maximum speeds around radii; the inverse of `calm_radius`."""
    by_jerk = np.cbrt(limits.jerk_mm_s3 * radii * radii)
    by_acceleration = np.sqrt(limits.across_mm_s2 * radii)
    return np.asarray(np.minimum(limits.speed_mm_s, np.minimum(by_acceleration, by_jerk)))


def min_radius(here: Point, move: ArcFeed | ParabolaFeed | EllipseFeed) -> float:
    """Minimum radius of curvature of a curve that starts `here`; for an ellipse, of all of it."""
    if isinstance(move, ArcFeed):
        return hypot(move.i, move.j)
    if isinstance(move, ParabolaFeed):
        vertex = here[0] + move.i, here[1] + move.j
        return min_radius_of_parabola(here, vertex, (move.x, move.y))
    return min_radius_of_ellipse((-move.i, -move.j), move.angle, move.ratio)


# --- jerk ramps -----------------------------------------------------------------------------------

# Jerk-limited ramps for many sections at once.
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
    """How far the peaks of sections lie above their higher end speeds, at most cap - high.

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
    return np.asarray(up + down + cruise / np.where(peak > 0.0, peak, 1.0))


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


# --- sections ------------------------------------------------------------------------------------

# Segments of a path joined to sections that are passed with one rise and one fall of speed.
#
# At the joints of sections the acceleration is 0, so a ramp cannot reach across them. A curve
# that was cut in short chords would therefore never gain speed if every chord were a section of
# its own:
#
#     speed limit   ____      ____________      The limits of segments and of the junctions
#                  |    |_ _ |            |     between them are a skyline. A tower that is too
#                  |      | |             |     short to be climbed  is levelled with its higher
#               ___|      |_|             |__   neighbour; small steps in one direction are taken
#                    too short worth it         together.


#: A tower is worth climbing if the speed rises by this share of its foot in half its width.
WORTH_RISE = 0.1

#: Limits nearer to each other than this share are one.
SAME_SPEED = 1e-3

#: Short steps of a stair are one section while their limits lie within this ratio.
STAIR_RATIO = 1.25


class SpeedSection(Struct, gc=False):
    """Segments `first` to `last` (excluded) under one limit; a junction has none."""

    limit: float
    length: float
    first: int
    last: int
    acceleration: float
    jerk: float


def _is_worth(tower: SpeedSection, foot: float) -> bool:
    """Whether a section is long enough to rise above `foot` and come down again."""
    gain = tower.limit - foot
    if gain <= SAME_SPEED * foot:
        return False
    change = min(gain, WORTH_RISE * foot)
    ramp_s = cell_motion.ramp_seconds(change, tower.acceleration, tower.jerk)
    return tower.length >= 2 * (foot + change / 2) * ramp_s


def _absorb(into: SpeedSection, other: SpeedSection) -> None:
    into.length += other.length
    into.first, into.last = min(into.first, other.first), max(into.last, other.last)
    into.acceleration = min(into.acceleration, other.acceleration)
    into.jerk = min(into.jerk, other.jerk)


def join_segments(
    lengths: Floats, limits: Floats, junctions: Floats, accelerations: Floats, jerks: Floats
) -> list[SpeedSection]:
    """The sections of a path with n segments and n + 1 junctions, its ends included.

    Sections without length are junctions whose limit stands for itself. Each segment is looked
    at a bounded number of times on average: a level tower is never looked at again.
    """
    count = len(junctions)
    # Junctions and segments in turns; those of one limit that follow one another are one.
    skyline_limits = _in_turns(junctions, limits)
    begins = np.flatnonzero(np.append(True, skyline_limits[1:] != skyline_limits[:-1]))
    behind = np.append(begins[1:], 2 * count - 1)
    level = zip(
        skyline_limits[begins].tolist(),
        np.add.reduceat(_in_turns(np.zeros(count), lengths), begins).tolist(),
        (begins // 2).tolist(),
        (behind // 2).tolist(),
        np.minimum.reduceat(_in_turns(np.full(count, inf), accelerations), begins).tolist(),
        np.minimum.reduceat(_in_turns(np.full(count, inf), jerks), begins).tolist(),
        strict=True,
    )
    skyline: list[SpeedSection] = []
    for section in level:
        new = SpeedSection(*section)
        # Level the towers that it leaves too short.
        while len(skyline) > 1 and skyline[-1].limit > new.limit:
            before, tower = skyline[-2], skyline[-1]
            if before.limit >= tower.limit or _is_worth(tower, max(before.limit, new.limit)):
                break
            skyline.pop()
            _absorb(before if before.limit >= new.limit else new, tower)
        if skyline and skyline[-1].limit == new.limit:
            _absorb(skyline[-1], new)
        else:
            skyline.append(new)
    # Joins neighbours too short for a rise of their own while their limits are near.
    speed_sections: list[SpeedSection] = []
    lowest = highest = 0.0
    for new in skyline:
        is_short = new.length > 0.0 and not _is_worth(new, new.limit / STAIR_RATIO)
        if is_short and lowest > 0.0:
            low, high = min(lowest, new.limit), max(highest, new.limit)
            if high <= STAIR_RATIO * low:
                _absorb(speed_sections[-1], new)
                speed_sections[-1].limit = lowest = low
                highest = high
                continue
        speed_sections.append(new)
        lowest, highest = (new.limit, new.limit) if is_short else (0.0, 0.0)
    return speed_sections


def _in_turns(junctions: Floats, segments: Floats) -> Floats:
    """Numbers of n + 1 junctions and of the n segments between them, in turns."""
    both = np.empty(len(junctions) + len(segments))
    both[::2], both[1::2] = junctions, segments
    return both


def joint_speeds(sections: list[SpeedSection]) -> tuple[list[SpeedSection], list[float]]:
    """The sections that have a length, and the speeds at their n + 1 joints."""
    moving: list[SpeedSection] = []
    speeds: list[float] = []
    limit = sections[0].limit
    for section in sections:
        limit = min(limit, section.limit)
        if section.length > 0.0:
            moving.append(section)
            speeds.append(limit)
            limit = section.limit
    speeds.append(limit)
    for k in range(len(moving) - 1, -1, -1):
        s = moving[k]
        if speeds[k] > speeds[k + 1]:
            reach = reachable_speed(speeds[k + 1], s.length, s.acceleration, s.jerk)
            speeds[k] = min(speeds[k], reach)
    for k, s in enumerate(moving):
        if speeds[k + 1] > speeds[k]:
            reach = reachable_speed(speeds[k], s.length, s.acceleration, s.jerk)
            speeds[k + 1] = min(speeds[k + 1], reach)
    return moving, speeds
