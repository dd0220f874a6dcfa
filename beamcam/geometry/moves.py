r"""Minimum times of moves along a line under limits of velocity, acceleration and jerk.

      v |    ______          A ramp changes the velocity by `change`, from and to acceleration 0.
        |   /      \         It takes change / a + a / j, or 2 sqrt(change / j) where it is too
        |  /        \        small to reach a; its way is the mean velocity times the time.
        |_/__________\__ t   An infinite jerk makes trapezoids of it.

All in closed form and plain numbers, so that a thousand holes cost no numpy. Units are the
caller's: mm, mm/s, mm/s2, mm/s3, or degrees.
"""

from math import inf, sqrt

from beamcam.geometry.ramps import ramp

#: Halvings of the root of a rise; below that no second shows it.
HALVINGS = 40


def ramp_seconds(change: float, acceleration: float, jerk: float = inf) -> float:
    """Least time in which the velocity changes by `change`, from and to acceleration 0."""
    if change <= 0.0:
        return 0.0
    if jerk == inf:
        return change / acceleration
    if change * jerk >= acceleration * acceleration:
        return change / acceleration + acceleration / jerk
    return 2.0 * sqrt(change / jerk)


def move_seconds(distance: float, velocity: float, acceleration: float, jerk: float = inf) -> float:
    """Minimum time from rest to rest over `distance`, which may be negative."""
    way = abs(distance)
    return ramp(velocity / way, acceleration / way, jerk / way).duration_s if way else 0.0


def stretch_seconds(
    way: float, first: float, last: float, cap: float, acceleration: float, jerk: float = inf
) -> float:
    """Time over `way` that is entered at velocity `first` and left at `last`, at most at `cap`.

    It rises to a peak and falls. The ramps have to fit: `last` can be reached from `first`.
    """
    low, high = min(first, last), max(first, last)
    cap = max(cap, high)

    def ways(peak: float) -> tuple[float, float]:
        """Distance and time of both ramps."""
        up = ramp_seconds(peak - first, acceleration, jerk)
        down = ramp_seconds(peak - last, acceleration, jerk)
        return (peak + first) / 2 * up + (peak + last) / 2 * down, up + down

    used, seconds = ways(cap)
    if used <= way:
        return seconds + (way - used) / cap if cap > 0.0 else seconds
    if jerk == inf:
        peak = sqrt(acceleration * way + (first * first + last * last) / 2)
        return (2.0 * max(peak, high) - low - high) / acceleration
    a, b = 0.0, sqrt(cap - high)
    for _ in range(HALVINGS):
        root = (a + b) / 2
        if ways(high + root * root)[0] <= way:
            a = root
        else:
            b = root
    peak = high + a * a
    used, seconds = ways(peak)
    return seconds + max(0.0, way - used) / peak if peak > 0.0 else seconds
