"""The program: commands in order, with every figure that a controller needs and no syntax.

Commands are named after the canonical machining functions of LinuxCNC where it has one.
Lengths are mm in machine coordinates, feeds mm/min, speeds rpm.
"""

from dataclasses import dataclass

from beamcam.errors import Source


@dataclass(frozen=True, slots=True)
class StartBar:
    """The section that the following commands work on."""

    section: int  #: the controller's code of the profile
    width: float
    height: float


@dataclass(frozen=True, slots=True)
class SawStroke:
    """Bring the bar to `x` and cut through it."""

    x: float
    angle: float  #: degrees, in the machine's counting
    feed_mm_min: float
    source: Source


@dataclass(frozen=True, slots=True)
class DrillCycle:
    """Bring the bar to `x`, choose the spindle and drill one stroke."""

    spindle: int
    diameter: float
    x: float
    start: tuple[float, float]  #: Y and Z where the spindle may travel
    near: tuple[float, float]  #: Y and Z where the rapid approach ends
    bottom: tuple[float, float]  #: Y and Z at the end of the stroke
    feed_mm_min: float
    speed_rpm: float
    source: Source


@dataclass(frozen=True, slots=True)
class Comment:
    """A text for whoever reads the program at the machine."""

    text: str


Command = StartBar | SawStroke | DrillCycle | Comment


@dataclass(frozen=True, slots=True)
class Program:
    """A named sequence of commands."""

    job: str
    commands: tuple[Command, ...]
