"""Velocity over time as phases of constant jerk, and its position, velocity and acceleration.

Units are the caller's: mm and mm/s; or rpm, whose positions are then sixtieths of revolutions.
Time is seconds.
"""

import numpy as np
from msgspec import Struct
from numpy.typing import ArrayLike

from beamcam.geometry.array_types import Floats


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

    def position(self, t_s: ArrayLike) -> Floats:
        """Way made at times `t_s`, an array of their shape; exact at both ends."""
        return self.sample(t_s)[0]

    def velocity(self, t_s: ArrayLike) -> Floats:
        """Velocity at times `t_s`, an array of their shape; exact at both ends."""
        return self.sample(t_s)[1]

    def acceleration(self, t_s: ArrayLike) -> Floats:
        """Acceleration at times `t_s`; where it jumps, that after the jump."""
        return self.sample(t_s)[2]

    def sample(self, t_s: ArrayLike) -> tuple[Floats, Floats, Floats]:
        """Position, velocity and acceleration at times `t_s`, three arrays of their shape."""
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
