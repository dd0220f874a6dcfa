"""Simulated axes: they go to a place with a trapezoid of velocity, from whatever they do now."""

from collections.abc import Callable
from itertools import pairwise
from math import dist, inf, sqrt
from typing import Any

Phase = tuple[float, float]  #: seconds and acceleration


def phases_to(way: float, velocity: float, greatest: float, up: float, down: float) -> list[Phase]:
    """The phases that make `way` and end at rest, from a velocity, as fast as limits allow.

    An axis that is too fast to stop in time, or moves away, brakes and comes back.
    """
    found: list[Phase] = []
    stop = velocity * abs(velocity) / (2 * down)
    side = 1.0 if way - stop >= 0.0 else -1.0
    left, speed = way * side, velocity * side
    if speed < 0.0:
        found.append((-speed / down, down * side))
        left, speed = left + speed * speed / (2 * down), 0.0
    if speed > greatest:
        found.append(((speed - greatest) / down, -down * side))
        left, speed = left - (speed * speed - greatest * greatest) / (2 * down), greatest
    peak = sqrt(max(0.0, (2 * up * down * left + down * speed * speed) / (up + down)))
    peak = max(min(peak, greatest), speed)
    if peak <= 0.0:
        return found
    rise = (peak * peak - speed * speed) / (2 * up)
    fall = peak * peak / (2 * down)
    found.append(((peak - speed) / up, up * side))
    found.append((max(0.0, left - rise - fall) / peak, 0.0))
    found.append((peak / down, -down * side))
    return found


class Axis:
    """An axis with its drive: `place` counts from its low limit switch, `position` from zero."""

    def __init__(self, name: str, place: float, stop: float) -> None:
        self.name = name
        self.place, self.velocity = place, 0.0
        self.origin = 0.0
        self.enabled = False
        self.error = False
        self.lag = 0.0  #: by which the axis is off its set position
        self.reads: Callable[[float], float] = float  #: what its encoder reads where it is
        self.brake = stop  #: mm/s2 of a stop
        self.commanded_by: Any = None  #: the function block that commanded it last
        self.held_by: Any = None  #: the function block that stopped it and holds it
        self._phases: list[Phase] = []
        self._end: float | None = None  #: place at which it stops

    @property
    def position(self) -> float:
        return self.place - self.origin

    @property
    def actual(self) -> float:
        """The position that the encoder reads."""
        return self.reads(self.position + self.lag)

    @property
    def still(self) -> bool:
        return not self._phases

    def enable(self) -> int:
        """0 if the drive is on then."""
        self.enabled = not self.error
        return 0 if self.enabled else 1

    def reset(self) -> int:
        """An error is acknowledged."""
        self.error = False
        return 0

    def go(self, position: float, velocity: float, up: float, down: float) -> None:
        """To a position."""
        self._end = position + self.origin
        self._phases = phases_to(position - self.position, self.velocity, velocity, up, down)

    def run(self, velocity: float, acceleration: float) -> None:
        """On and on."""
        change = velocity - self.velocity
        ramp = abs(change) / acceleration, acceleration if change > 0 else -acceleration
        self._end, self._phases = None, [ramp, (inf, 0.0)]

    def stop(self) -> None:
        """Stop as fast as the axis can."""
        speed = self.velocity
        ramp = abs(speed) / self.brake, -self.brake if speed > 0 else self.brake
        self._end, self._phases = None, [ramp]

    def home(self, position: float) -> None:
        """Call the place where the axis stands so."""
        self.origin = self.place - position

    def put(self, position: float, velocity: float) -> None:
        """Set the axis position from a path object."""
        self.place, self.velocity = position + self.origin, velocity
        self._end, self._phases = None, []

    def advance(self, seconds: float) -> None:
        """Move for a while."""
        while seconds > 0.0 and self._phases:
            lasts, acceleration = self._phases[0]
            t = min(seconds, lasts)
            self.place += t * (self.velocity + acceleration * t / 2)
            self.velocity += acceleration * t
            seconds -= t
            if lasts - t > 1e-12:
                self._phases[0] = (lasts - t, acceleration)
                return
            del self._phases[0]
        if not self._phases:
            self.velocity = 0.0
            if self._end is not None:
                self.place, self._end = self._end, None


class Path:
    """A path object: the lines and arcs that it leads both axes along."""

    def __init__(self, x: Axis, y: Axis) -> None:
        self.x, self.y = x, y
        self._points: list[tuple[float, float]] = []
        self._drive = Axis("path", 0.0, 1.0)

    @property
    def still(self) -> bool:
        return self._drive.still

    def go(self, points: list[tuple[float, float]], speed: float, up: float, down: float) -> None:
        """Along points, from rest to rest."""
        self._points, self._drive = points, Axis("path", 0.0, down)
        self._drive.go(sum(dist(a, b) for a, b in pairwise(points)), speed, up, down)

    def stop(self) -> None:
        if not self.still:
            self._drive.stop()

    def advance(self, seconds: float) -> None:
        if self.still:
            return
        self._drive.advance(seconds)
        (x, y), (dx, dy) = self._at(self._drive.position)
        self.x.put(x, dx * self._drive.velocity)
        self.y.put(y, dy * self._drive.velocity)

    def _at(self, way: float) -> tuple[tuple[float, float], tuple[float, float]]:
        direction = (0.0, 0.0)
        for a, b in pairwise(self._points):
            length = dist(a, b)
            if length == 0.0:
                continue
            direction = ((b[0] - a[0]) / length, (b[1] - a[1]) / length)
            if way <= length:
                return (a[0] + way * direction[0], a[1] + way * direction[1]), direction
            way -= length
        return self._points[-1], direction
