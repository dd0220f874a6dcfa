"""The program: commands in order, with every figure that a controller needs and no syntax.

Commands are named after the canonical machining functions of LinuxCNC where it has one.
Lengths are mm in machine coordinates, feeds mm/min, speeds rpm.
"""

from dataclasses import dataclass
from typing import Literal

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
    tilt: float = 0.0  #: of the blade, degrees, in the machine's counting


@dataclass(frozen=True, slots=True)
class DrillCycle:
    """Bring the bar to `x`, choose the spindle and its tool, and make one stroke."""

    spindle: int
    diameter: float
    x: float
    start: tuple[float, float]  #: Y and Z where the spindle may travel
    near: tuple[float, float]  #: Y and Z where the rapid approach ends
    bottom: tuple[float, float]  #: Y and Z at the end of the stroke
    feed_mm_min: float
    speed_rpm: float
    source: Source
    kind: Literal["drill", "tap", "countersink", "punch"] = "drill"
    pitch: float = 0.0  #: of a tap


@dataclass(frozen=True, slots=True)
class PathPoint:
    """A point of a path in machine coordinates, with what stands above it."""

    x: float
    start: tuple[float, float]  #: Y and Z where the spindle may travel
    near: tuple[float, float]
    bottom: tuple[float, float]  #: Y and Z of the tool's point at work


@dataclass(frozen=True, slots=True)
class PathCycle:
    """Choose the spindle and its tool, go down at the first point and along the others."""

    kind: Literal["mill", "scribe"]
    spindle: int
    diameter: float
    points: tuple[PathPoint, ...]
    feed_mm_min: float
    speed_rpm: float
    source: Source


@dataclass(frozen=True, slots=True)
class Comment:
    """A text for whoever reads the program at the machine."""

    text: str


Command = StartBar | SawStroke | DrillCycle | PathCycle | Comment


@dataclass(frozen=True, slots=True)
class Program:
    """A named sequence of commands."""

    job: str
    commands: tuple[Command, ...]
