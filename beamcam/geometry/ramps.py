r"""Fastest motion over a distance of 1 from rest to rest, within limits of its derivatives.

speed        ______________          the acceleration grows by the jerk, stays, and falls back;
          .'                '.       the same to brake, mirrored. Without a limit of the jerk
        /                    \      that is a trapezoid, and a triangle where the way is short.
 _____.'                      '.__
 jerk steady jerk   cruise   jerk ...
"""

from math import cbrt, inf, sqrt

from msgspec import Struct


class Ramp(Struct, frozen=True):
    """Times in s; speed and acceleration in shares of the way per second, and per second squared.

    All of it is 0 for a way that takes no time.
    """

    jerk_s: float  #: in which the acceleration grows, and in which it falls back
    steady_s: float  #: at maximum acceleration
    cruise_s: float  #: at maximum speed
    speed: float
    acceleration: float

    @property
    def rise_s(self) -> float:
        """From rest to maximum speed."""
        return 2 * self.jerk_s + self.steady_s

    @property
    def duration_s(self) -> float:
        """From rest to rest."""
        return 2 * self.rise_s + self.cruise_s

    def share(self, t: float) -> float:
        """Share of the distance covered `t` seconds after the start."""
        if t >= self.duration_s:
            return 1.0
        left = self.duration_s - t
        if t < self.rise_s:
            return self._risen(t)
        if left < self.rise_s:
            return 1.0 - self._risen(left)
        return self.speed * (t - self.rise_s / 2)

    def _risen(self, t: float) -> float:
        """The way in the first `t` seconds, none of them at the greatest speed."""
        if t < self.jerk_s:
            return self.acceleration * t**3 / (6 * self.jerk_s)
        left = self.rise_s - t
        if left < self.jerk_s:
            # The rise is as symmetrical as its speed: half of the greatest in the middle.
            lost = self.acceleration * left**3 / (6 * self.jerk_s)
            return self.speed * (self.rise_s / 2 - left) + lost
        steady = t - self.jerk_s
        grown = self.acceleration * self.jerk_s / 2  # the speed when the jerk is over
        return grown * (self.jerk_s / 3 + steady) + self.acceleration * steady * steady / 2


STANDING = Ramp(0.0, 0.0, 0.0, 0.0, 0.0)


def ramp(speed: float, acceleration: float, jerk: float = inf) -> Ramp:
    """The fastest from rest to rest within limits above 0; the speed may be infinite."""
    jerk_s = acceleration / jerk
    steady_s = speed / acceleration - jerk_s
    if steady_s < 0.0:  # the speed is reached before the acceleration is
        jerk_s, steady_s = sqrt(speed / jerk), 0.0
    if speed * (2 * jerk_s + steady_s) > 1.0:  # the distance ends before the speed is reached
        # acceleration (jerk_s + steady_s) (2 jerk_s + steady_s) = 1
        jerk_s = acceleration / jerk
        steady_s = (sqrt(jerk_s * jerk_s + 4 / acceleration) - 3 * jerk_s) / 2
        if steady_s < 0.0:
            jerk_s, steady_s = cbrt(1 / (2 * jerk)), 0.0
    greatest = acceleration if steady_s > 0.0 else jerk * jerk_s
    reached = greatest * (jerk_s + steady_s)
    rise_s = 2 * jerk_s + steady_s
    return Ramp(jerk_s, steady_s, max(1 / reached - rise_s, 0.0), reached, greatest)


# --- moves ----------------------------------------------------------------------------------------

# Minimum times of moves along a line under limits of velocity, acceleration and jerk.
#
#       v |    ______          A ramp changes the velocity by `change`, from and to acceleration 0.
#         |   /      \         It takes change / a + a / j, or 2 sqrt(change / j) where it is too
#         |  /        \        small to reach a; its way is the mean velocity times the time.
#         |_/__________\__ t   An infinite jerk makes trapezoids of it.
#
# All in closed form and plain numbers, so that a thousand holes cost no numpy. Units are the
# caller's: mm, mm/s, mm/s2, mm/s3, or degrees.


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
