r"""Velocity over time as phases of constant jerk, and its position, velocity and acceleration.

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
from math import inf, isfinite

import numpy as np
from msgspec import Struct
from numpy.typing import ArrayLike

from beamcam.geometry.array_types import Floats
from beamcam.model.cell_motion import ramp


class Phase(Struct, frozen=True):
    """A stretch of constant jerk; position, velocity and acceleration are those at its start."""

    start_s: float
    duration_s: float
    position: float
    velocity: float
    acceleration: float
    jerk: float


class VelocityProfile(Struct, frozen=True):
    """Phases that follow one another from time 0, and the state that they end in.

    Before its start and after its end a profile goes on at its first and last velocity.
    """

    phases: tuple[Phase, ...]
    duration_s: float
    distance: float
    start_velocity: float
    end_velocity: float

    def sample(self, t_s: ArrayLike) -> tuple[Floats, Floats, Floats]:
        """Position, velocity and acceleration at times `t_s`, three arrays of their shape.

        Exact at both ends; where the acceleration jumps, that after the jump.
        """
        t = np.asarray(t_s, dtype=np.float64)
        before, after = t <= 0.0, t >= self.duration_s
        x, v, a = self.distance + 0.0 * t, self.end_velocity + 0.0 * t, 0.0 * t
        if self.phases:
            start, x0, v0, a0, j = np.array(
                [(p.start_s, p.position, p.velocity, p.acceleration, p.jerk) for p in self.phases],
                dtype=np.float64,
            ).T
            k = np.clip(np.searchsorted(start, t, side="right") - 1, 0, len(start) - 1)
            s = t - start[k]
            x = x0[k] + s * (v0[k] + s * (a0[k] / 2 + s * (j[k] / 6)))
            v = v0[k] + s * (a0[k] + s * (j[k] / 2))
            a = a0[k] + s * j[k]
        late = t - self.duration_s
        x = np.where(after, self.distance + late * self.end_velocity, x)
        v = np.where(after, self.end_velocity, v)
        x = np.where(before & ~after, t * self.start_velocity, x)
        v = np.where(before & ~after, self.start_velocity, v)
        a = np.where((t < 0.0) | (t > self.duration_s), 0.0, a)
        return x, v, a


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
    start_velocity: float, pieces: Sequence[Piece], distance: float, end_velocity: float
) -> VelocityProfile:
    """The profile of pieces that follow one another.

    `distance` and `end_velocity` stand in for the sums of the pieces, which are off by rounding.
    """
    t = x = 0.0
    v = start_velocity
    phases = []
    for duration, a, j in pieces:
        phases.append(Phase(t, duration, x, v, a, j))
        t += duration
        x += duration * (v + duration * (a / 2 + duration * j / 6))
        v += duration * (a + duration * j / 2)
    return VelocityProfile(tuple(phases), t, distance, start_velocity, end_velocity)


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
        return build_profile(0.0, [], 0.0, 0.0)
    way = abs(distance)
    fastest = ramp(limits.velocity / way, limits.acceleration / way, limits.jerk / way)
    jerk_percent = min(100.0, 200.0 * fastest.jerk_s / fastest.rise_s)
    return _there(distance, fastest.rise_s, fastest.cruise_s, jerk_percent)


def _there(distance: float, ramp_s: float, cruise_s: float, jerk_percent: float) -> VelocityProfile:
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
