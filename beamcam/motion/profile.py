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
from math import inf, isfinite, sqrt

from msgspec import Struct

from beamcam.geometry.moves import ramp_seconds
from beamcam.geometry.velocity_profile import Phase, Profile

#: A ramp that is rounded by less than this share is not rounded.
MIN_SHARE = 1e-12


class Limits(Struct, frozen=True):
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


def fastest_ramp(change: float, limits: Limits) -> list[Piece]:
    """The ramp that changes the velocity by `change` in the least time."""
    if change == 0.0:
        return []
    peak = min(limits.acceleration, sqrt(abs(change) * limits.jerk))
    time_s = ramp_seconds(abs(change), limits.acceleration, limits.jerk)
    return ramp_pieces(change, time_s, min(100.0, 200.0 * peak / limits.jerk / time_s))


def build_profile(
    start_velocity: float,
    pieces: Sequence[Piece],
    distance: float | None = None,
    end_velocity: float | None = None,
) -> Profile:
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
    return Profile(
        tuple(phases),
        t,
        x if distance is None else distance,
        start_velocity,
        v if end_velocity is None else end_velocity,
    )


def profile_to_velocity(velocity: float, time_s: float, jerk_percent: float) -> Profile:
    """A ramp from rest to `velocity` in `time_s`.

    Raises ValueError unless the time is above 0 and the jerk is 0 to 100 %.
    """
    _check(time_s, jerk_percent)
    pieces = ramp_pieces(velocity, time_s, jerk_percent)
    return build_profile(0.0, pieces, velocity * time_s / 2, velocity)


def profile_by_acceleration(acceleration: float, time_s: float, jerk_percent: float) -> Profile:
    """A ramp from rest of `time_s`, whose maximum acceleration is `acceleration`."""
    _check(time_s, jerk_percent)
    velocity = acceleration * time_s * (1.0 - jerk_percent / 200.0)
    return profile_to_velocity(velocity, time_s, jerk_percent)


def profile_over_distance(
    distance: float, time_s: float, jerk_percent: float, cruise_s: float = 0.0
) -> Profile:
    """From rest to rest over `distance` in `time_s`: a ramp, a cruise and the mirrored ramp.

    Without a cruise the greatest velocity is 2 distance / time.
    Raises ValueError if the cruise leaves no time for the ramps.
    """
    _check(time_s, jerk_percent)
    if not 0.0 <= cruise_s < time_s:
        raise ValueError(f"a cruise of {cruise_s:g} s leaves no ramps in {time_s:g} s")
    ramp_s = (time_s - cruise_s) / 2
    velocity = distance / (ramp_s + cruise_s)
    pieces = [
        *ramp_pieces(velocity, ramp_s, jerk_percent),
        *([(cruise_s, 0.0, 0.0)] if cruise_s > 0.0 else []),
        *ramp_pieces(-velocity, ramp_s, jerk_percent),
    ]
    return build_profile(0.0, pieces, distance, 0.0)


def profile_through(points: Sequence[tuple[float, float]], jerk_percent: float) -> Profile:
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


def fastest_profile(
    distance: float, limits: Limits, start_velocity: float = 0.0, end_velocity: float = 0.0
) -> Profile:
    """The profile over `distance` that takes the least time, from and to acceleration 0.

    It rises to a peak, cruises there if that is the limit, and falls: up to seven phases. A
    negative distance runs backwards; the velocities then are 0 or negative too.

    Raises ValueError for velocities against the distance or above the limit, and for a
    distance that is too short to get from one velocity to the other.
    """
    side = -1.0 if distance < 0.0 else 1.0
    v0, v1, way = side * start_velocity, side * end_velocity, side * distance
    if not (min(v0, v1) >= 0.0 and max(v0, v1) <= limits.velocity and isfinite(way)):
        raise ValueError(
            f"velocities must lie between 0 and {side * limits.velocity:g} for a distance of "
            f"{distance:g}, found {start_velocity:g} and {end_velocity:g}"
        )
    least = ramp_distance(v0, v1, limits)
    if way < least * (1.0 - 1e-12):
        raise ValueError(
            f"a change from {start_velocity:g} to {end_velocity:g} takes {side * least:g}, "
            f"found a distance of {distance:g}"
        )
    low, high = min(v0, v1), max(v0, v1)
    rise, cruises = _peak_rise(way, low, high, limits)
    up, down = (rise, high - low + rise) if v0 > v1 else (high - low + rise, rise)
    left = way - _ramp_way(v0, up, limits) - _ramp_way(v1, down, limits)
    cruise = max(0.0, left) / limits.velocity if cruises else 0.0
    pieces = [
        *fastest_ramp(up, limits),
        *([(cruise, 0.0, 0.0)] if cruise > 0.0 else []),
        *fastest_ramp(-down, limits),
    ]
    mirrored = [(t, side * a, side * j) for t, a, j in pieces]
    return build_profile(start_velocity, mirrored, distance, end_velocity)


def ramp_distance(v0: float, v1: float, limits: Limits) -> float:
    """Distance covered while the velocity changes from `v0` to `v1` in minimum time."""
    return (v0 + v1) / 2 * ramp_seconds(abs(v1 - v0), limits.acceleration, limits.jerk)


def _ramp_way(slow: float, change: float, limits: Limits) -> float:
    return (slow + change / 2) * ramp_seconds(change, limits.acceleration, limits.jerk)


def _peak_rise(way: float, low: float, high: float, limits: Limits) -> tuple[float, bool]:
    """How far the peak lies above the higher end velocity, so that both ramps fill `way`, and
    whether the limit leaves way for a cruise.

    The root of rise is looked for: the way is a smooth function of it even where the rise is
    next to nothing. Halving ends on neighbouring floats, after some 60 steps.
    """
    top = limits.velocity - high

    def excess(root: float) -> float:
        rise = root * root
        return _ramp_way(high, rise, limits) + _ramp_way(low, high - low + rise, limits) - way

    a, b = 0.0, sqrt(top)
    if excess(b) <= 0.0:
        return top, True
    for _ in range(200):
        root = (a + b) / 2
        if root in (a, b):
            break
        if excess(root) > 0.0:
            b = root
        else:
            a = root
    return a * a, False


def _check(time_s: float, jerk_percent: float) -> None:
    if not time_s > 0.0:
        raise ValueError(f"time must be above 0 s, found {time_s:g}")
    if not 0.0 <= jerk_percent <= 100.0:
        raise ValueError(f"jerk must be 0 to 100 %, found {jerk_percent:g}")
