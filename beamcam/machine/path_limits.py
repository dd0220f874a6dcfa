"""Limits of a cutting table's two axes along a path of any direction.

Running up along the path and being turned across it share the acceleration of the axes: what the
machine's file gives along the path, `a` of `A`, leaves sqrt(A^2 - a^2) across. Where it gives
nothing, half is taken along, as LinuxCNC's planner does.
"""

from math import inf, sqrt

from msgspec import Struct

from beamcam.machine.machine import ControlledAxis, Machine

ALONG_SHARE = 0.5


class PathLimits(Struct, frozen=True):
    """Limits of a path in mm and seconds; infinite where the machine's file gives none."""

    speed_x_mm_s: float
    speed_y_mm_s: float
    along_mm_s2: float
    straight_mm_s2: float  #: along a line, where nothing is turned
    across_mm_s2: float
    jerk_mm_s3: float
    corner: float  #: of a circle from a corner that is passed as fast; 0 stops at each

    @property
    def speed_mm_s(self) -> float:
        """The speed of the slower axis, which is possible in every direction."""
        return min(self.speed_x_mm_s, self.speed_y_mm_s)


def path_limits(machine: Machine) -> PathLimits | None:
    """The limits of a machine's path; None where its file has no axes X and Y."""
    axes = {axis.moves: axis for axis in machine.axes}
    torch = machine.torch
    if torch is None or "X" not in axes or "Y" not in axes:
        return None
    x, y = axes["X"], axes["Y"]
    whole = min(x.acceleration, y.acceleration)
    along = torch.acceleration or ALONG_SHARE * whole
    return PathLimits(
        x.speed,
        y.speed,
        along,
        torch.acceleration or whole,
        sqrt(whole * whole - along * along),
        min(_jerk(x), _jerk(y)),
        torch.corner,
    )


def _jerk(axis: ControlledAxis) -> float:
    return inf if axis.jerk is None else axis.jerk
