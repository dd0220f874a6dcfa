"""Jerk-limited ramps for many stretches at once.

A ramp changes the speed by `change` from and to acceleration 0. It takes change / a + a / j, or
2 sqrt(change / j) where it is too small to reach the acceleration a, and it is symmetric: the
way is the mean speed times the time.
"""

from math import cbrt, inf, sqrt

import numpy as np
from numpy.typing import NDArray

from beamcam.geometry.array_types import Floats

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
    found: Floats = np.where(
        long, change / acceleration + acceleration / jerk, 2 * np.sqrt(change / jerk)
    )
    return np.where(change > 0.0, found, 0.0)


def peak_rises(
    way: Floats, low: Floats, high: Floats, cap: Floats, acceleration: Floats, jerk: Floats
) -> Floats:
    """How far the peaks of stretches lie above their higher end speeds, at most cap - high.

    Halves the root of the rise, of which the way is a smooth function, to neighbouring floats.
    """
    a, b = np.zeros_like(way), np.sqrt(np.maximum(cap - high, 0.0))

    def room(root: Floats) -> NDArray[np.bool_]:
        rise = root * root
        change = high - low + rise
        first = (high + rise / 2) * ramp_seconds(rise, acceleration, jerk)
        return np.asarray(
            first + (low + change / 2) * ramp_seconds(change, acceleration, jerk) <= way
        )

    full = room(b)
    a = np.where(full, b, a)
    for _ in range(54):
        middle = (a + b) / 2
        fits = room(middle)
        a, b = np.where(fits, middle, a), np.where(fits, b, middle)
    return np.where(full, np.maximum(cap - high, 0.0), a * a)


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
