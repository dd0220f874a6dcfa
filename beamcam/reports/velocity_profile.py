"""A velocity profile as a table, in the units that were asked for."""

from math import floor

import numpy as np
from msgspec import Struct

from beamcam.geometry.array_types import Floats
from beamcam.motion.velocity_profile import VelocityProfile


class VelocityUnit(Struct, frozen=True):
    """Unit of velocities; positions are velocity times its seconds."""

    name: str
    seconds: float  #: in which a velocity of 1 makes a way of 1
    way: str  #: unit of positions

    def labels(self) -> tuple[str, str, str]:
        """Names of the curves of position, velocity and acceleration."""
        return f"position, {self.way}", f"velocity, {self.name}", f"acceleration, {self.name}/s"


RPM = VelocityUnit("rpm", 60.0, "revolutions")
MM_S = VelocityUnit("mm/s", 1.0, "mm")


class Encoder(Struct, frozen=True):
    """Readings of a pulse counter on the shaft."""

    pulses: int  #: a revolution
    travel: float | None = None  #: way of one revolution; None where velocities are rpm already

    def __post_init__(self) -> None:
        if self.pulses <= 0 or (self.travel is not None and not self.travel > 0.0):
            raise ValueError(f"an encoder needs pulses and travel above 0, found {self!r}")

    def rpm(self, velocity: Floats) -> Floats:
        """Revolutions a minute."""
        return velocity * 1.0 if self.travel is None else velocity / self.travel * 60.0

    def hz(self, velocity: Floats) -> Floats:
        """Pulses a second: rpm = Hz 60 / pulses."""
        return self.rpm(velocity) * self.pulses / 60.0


class ProfileTable(Struct, frozen=True):
    """Rows of numbers under the names of their columns."""

    columns: tuple[str, ...]
    rows: Floats  #: (n, number of columns)


def profile_table(
    profile: VelocityProfile,
    step_s: float,
    encoder: Encoder | None = None,
    unit: VelocityUnit = MM_S,
) -> ProfileTable:
    """Time, position, velocity and acceleration every `step_s`, the end always included; with
    an encoder its frequency and speed too.

    Raises ValueError if the step is not above 0.
    """
    if not step_s > 0.0:
        raise ValueError(f"the step of a table must be above 0 s, found {step_s:g}")
    count = floor(profile.duration_s / step_s * (1 + 1e-12))
    t = np.arange(count + 1) * step_s
    if profile.duration_s - t[-1] > 1e-9 * step_s:
        t = np.append(t, profile.duration_s)
    else:
        t[-1] = profile.duration_s
    x, v, a = profile.sample(t)
    columns, names = [t, x / unit.seconds, v, a], ["t_s", "position", "velocity", "acceleration"]
    if encoder is not None:
        columns += [encoder.hz(v), encoder.rpm(v)]
        names += ["encoder_hz", "encoder_rpm"]
    return ProfileTable(tuple(names), np.column_stack(columns))
