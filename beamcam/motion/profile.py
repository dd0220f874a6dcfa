r"""Velocity over time, in stretches of constant jerk.

       velocity    ______                     A ramp: acceleration rises for t1, stays for t2,
                  /      \                    falls for t3. Jerk in percent says how much of
                 /        \                   the ramp is rounded: t1 = t3 = J/2 T and
       _________/          \________          t2 = (1 - J) T. 0 % is a trapezoid, 100 % has
                t1 t2 t3                      no stretch of constant acceleration.

Units are the caller's: mm and mm/s; or rpm, whose positions are then sixtieths of revolutions.
Time is seconds.
"""

import itertools
from collections.abc import Sequence
from math import cbrt, inf, isfinite, sqrt

import numpy as np
from msgspec import Struct
from numpy.typing import NDArray

from beamcam.geometry.array_types import Floats
from beamcam.geometry.ramps import ramp
from beamcam.geometry.velocity_profile import Phase, VelocityProfile

#: A ramp that is rounded by less than this share is not rounded.
MIN_SHARE = 1e-12


class AxisLimits(Struct, frozen=True):
    """Limits of an axis; an infinite jerk allows steps of the acceleration."""

    velocity: float
    acceleration: float
    jerk: float = inf

    def __post_init__(self) -> None:
        for name in ("velocity", "acceleration", "jerk"):
            if not getattr(self, name) > 0.0:
                raise ValueError(f"the limit of {name} must be above 0, found {self!r}")


Piece = tuple[float, float, float]  #: duration, acceleration at its start, jerk


def ramp_pieces(change: float, time_s: float, jerk_percent: float) -> list[Piece]:
    """A ramp over `time_s` seconds that changes the velocity by `change`."""
    if time_s == 0.0:
        return []
    share = jerk_percent / 100.0
    if share < MIN_SHARE:
        return [(time_s, change / time_s, 0.0)]
    peak = change / (time_s * (1.0 - share / 2))
    rise, stay = share / 2 * time_s, (1.0 - share) * time_s
    jerk = peak / rise
    middle = [(stay, peak, 0.0)] if stay > 0.0 else []
    return [(rise, 0.0, jerk), *middle, (rise, peak, -jerk)]


def build_profile(
    start_velocity: float,
    pieces: Sequence[Piece],
    distance: float | None = None,
    end_velocity: float | None = None,
) -> VelocityProfile:
    """The profile of pieces that follow one another.

    `distance` and `end_velocity`, where they are known, stand in for the sums of the pieces,
    which are off by rounding.
    """
    t = x = 0.0
    v = start_velocity
    phases = []
    for duration, a, j in pieces:
        phases.append(Phase(t, duration, x, v, a, j))
        t += duration
        x += duration * (v + duration * (a / 2 + duration * j / 6))
        v += duration * (a + duration * j / 2)
    return VelocityProfile(
        tuple(phases), t, x if distance is None else distance, start_velocity,
        v if end_velocity is None else end_velocity,
    )  # fmt: skip


def profile_to_velocity(velocity: float, time_s: float, jerk_percent: float) -> VelocityProfile:
    """A ramp from rest to `velocity` in `time_s`.

    Raises ValueError unless the time is above 0 and the jerk is 0 to 100 %.
    """
    _check(time_s, jerk_percent)
    pieces = ramp_pieces(velocity, time_s, jerk_percent)
    return build_profile(0.0, pieces, velocity * time_s / 2, velocity)


def profile_by_acceleration(
    acceleration: float, time_s: float, jerk_percent: float
) -> VelocityProfile:
    """A ramp from rest of `time_s`, whose maximum acceleration is `acceleration`."""
    velocity = acceleration * time_s * (1.0 - jerk_percent / 200.0)
    return profile_to_velocity(velocity, time_s, jerk_percent)


def profile_over_distance(
    distance: float, time_s: float, jerk_percent: float, cruise_s: float = 0.0
) -> VelocityProfile:
    """From rest to rest over `distance` in `time_s`: a ramp, a cruise and the mirrored ramp.

    Without a cruise the greatest velocity is 2 distance / time.
    Raises ValueError if the cruise leaves no time for the ramps.
    """
    _check(time_s, jerk_percent)
    if not 0.0 <= cruise_s < time_s:
        raise ValueError(f"a cruise of {cruise_s:g} s leaves no ramps in {time_s:g} s")
    return _there(distance, (time_s - cruise_s) / 2, cruise_s, jerk_percent)


def fastest_profile(distance: float, limits: AxisLimits) -> VelocityProfile:
    """From rest to rest over `distance` in the least time; backwards if that is negative.

    Raises ValueError for a distance that is not a number.
    """
    if not isfinite(distance):
        raise ValueError(f"the distance must be a number of mm, found {distance:g}")
    if distance == 0.0:
        return build_profile(0.0, [])
    way = abs(distance)
    fastest = ramp(limits.velocity / way, limits.acceleration / way, limits.jerk / way)
    jerk_percent = min(100.0, 200.0 * fastest.jerk_s / fastest.rise_s)
    return _there(distance, fastest.rise_s, fastest.cruise_s, jerk_percent)


def _there(distance: float, ramp_s: float, cruise_s: float, jerk_percent: float) -> VelocityProfile:
    """A ramp, a cruise and the mirrored ramp."""
    velocity = distance / (ramp_s + cruise_s)
    pieces = [
        *ramp_pieces(velocity, ramp_s, jerk_percent),
        *([(cruise_s, 0.0, 0.0)] if cruise_s > 0.0 else []),
        *ramp_pieces(-velocity, ramp_s, jerk_percent),
    ]
    return build_profile(0.0, pieces, distance, 0.0)


def profile_through(points: Sequence[tuple[float, float]], jerk_percent: float) -> VelocityProfile:
    """Ramps that join (time, velocity) points; equal velocities are a cruise.

    Time 0 of the profile is that of the first point. Raises ValueError for fewer than two
    points or times that do not rise.
    """
    if len(points) < 2:
        raise ValueError(f"a profile needs 2 points or more, found {len(points)}")
    pieces: list[Piece] = []
    distance = 0.0
    for (t0, v0), (t1, v1) in itertools.pairwise(points):
        if not t1 > t0:
            raise ValueError(f"times must rise, found {t1:g} s after {t0:g} s")
        _check(t1 - t0, jerk_percent)
        same = v0 == v1
        pieces += [(t1 - t0, 0.0, 0.0)] if same else ramp_pieces(v1 - v0, t1 - t0, jerk_percent)
        distance += (v0 + v1) / 2 * (t1 - t0)
    return build_profile(points[0][1], pieces, distance, points[-1][1])


def _check(time_s: float, jerk_percent: float) -> None:
    if not time_s > 0.0:
        raise ValueError(f"time must be above 0 s, found {time_s:g}")
    if not 0.0 <= jerk_percent <= 100.0:
        raise ValueError(f"jerk must be 0 to 100 %, found {jerk_percent:g}")


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
