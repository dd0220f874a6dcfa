"""The program: commands in order, with every figure that a controller needs and no syntax.

Commands are named after the canonical machining functions of LinuxCNC where it has one.
Lengths are mm in machine coordinates, feeds mm/min, speeds rpm.
"""

from collections.abc import Callable, Iterator, Mapping
from typing import TYPE_CHECKING, Literal, NamedTuple

from msgspec import Struct

from beamcam.errors import Source
from beamcam.machine.torch import TorchRow

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray


class StartBar(Struct, frozen=True):
    """The section that the following commands work on."""

    section: int  #: the controller's code of the profile
    width: float
    height: float


class SawStroke(Struct, frozen=True, gc=False):
    """Bring the bar to `x` and cut through it."""

    x: float
    angle: float  #: degrees, in the machine's counting
    feed_mm_min: float
    source: Source
    tilt: float = 0.0  #: of the blade, degrees, in the machine's counting


class SpindleStroke(Struct, frozen=True, cache_hash=True):
    """What a spindle does at a place of the bar, wherever that is; most places share it."""

    spindle: int
    diameter: float
    retract: tuple[float, float]  #: Y and Z where the spindle may travel
    approach: tuple[float, float]  #: Y and Z where the rapid approach ends
    bottom: tuple[float, float]  #: Y and Z at the end of the stroke
    feed_mm_min: float
    speed_rpm: float
    kind: Literal["drill", "tap", "countersink", "punch"] = "drill"
    pitch: float = 0.0  #: of a tap
    peck: float = 0.0  #: depth fed at a time; 0 to the bottom at once
    tool_name: str = ""
    station: int = 0  #: from 1; 0 where the machine's words do not say it


class DrillCycle(Struct, frozen=True, gc=False):
    """Bring the bar to `x`, choose the spindle and its tool, and make one stroke."""

    x: float
    stroke: SpindleStroke
    source: Source


class PathPoint(Struct, frozen=True):
    """A point of a path in machine coordinates, with the tool positions above it."""

    x: float
    retract: tuple[float, float]  #: Y and Z where the spindle may travel
    approach: tuple[float, float]
    bottom: tuple[float, float]  #: Y and Z of the tool's point at work


class PathCycle(Struct, frozen=True):
    """Choose the spindle and its tool, go down at the first point and along the others."""

    kind: Literal["mill", "scribe"]
    spindle: int
    diameter: float
    points: tuple[PathPoint, ...]
    feed_mm_min: float
    speed_rpm: float
    source: Source
    tool_name: str = ""
    station: int = 0


class OfPart(Struct, frozen=True):
    """The work that follows is on this part; where the machine's words say anything of it."""

    about: Mapping[str, str]  #: by the names of `description.PART_DATA`


class BeginPart(Struct, frozen=True):
    """Work on another part of the bar begins."""

    text: str  #: for the operator


class PrintText(Struct, frozen=True):
    """Bring the bar to `x` and have a stamp or printer letter a text."""

    kind: str  #: of the unit
    x: float
    y: float  #: on the face
    text: str
    height: float
    angle: float  #: degrees
    face: int  #: what the program calls the unit on that face
    source: Source


class ChangeTool(Struct, frozen=True):
    """Program stop for a manual tool change."""

    spindle: int  #: what the program calls it
    station: int  #: counted from 1
    diameter: float
    text: str  #: tool to load, for the operator


class Comment(Struct, frozen=True):
    """A text for the operator."""

    text: str


class StartSheet(Struct, frozen=True):
    """The sheet that the following commands work on."""

    thickness: float


class ToolOn(Struct, frozen=True, gc=False):
    """Start the tool of a process where the head stands, and wait until it is through."""

    process: Literal["cut", "mark", "engrave", "spot"]
    feed_mm_min: float
    power: float
    pierce_s: float
    source: Source
    pierce_height: float = 0.0  #: over the sheet
    cut_height: float = 0.0
    preheat_s: float = 0.0
    amps: float = 0.0
    volts: float = 0.0
    number: int = 0  #: of the row in the controller's table of materials


class ChooseTool(Struct, frozen=True, gc=False):
    """From here on places are those of the tool that a process works with."""

    process: Literal["cut", "mark", "engrave", "spot"]


class ChooseMaterial(Struct, frozen=True, gc=False):
    """From here on the controller works with the data of a row, which the sheet is cut by."""

    row: TorchRow
    thickness: float


class CloseCut(Struct, frozen=True, gc=False):
    """The contour is closed; what of its path follows is run with the arc out."""


class ToolOff(Struct, frozen=True, gc=False):
    """Stop the tool of a process."""

    process: Literal["cut", "mark", "engrave", "spot"]


class SetFeed(Struct, frozen=True, gc=False):
    """From the next move on the tool moves at this feed: what its axes can follow there."""

    feed_mm_min: float


class Power(Struct, frozen=True, gc=False):
    """From the next move on the tool works with this power; 0 is dark. In laser mode only."""

    power: float


class PassEnd(Struct, frozen=True, gc=False):
    """A pass ends and the tool stays on: in laser mode it is dark in traverses."""


class Compensate(Struct, frozen=True):
    """From the next move on the controller keeps beside the contour by half the kerf."""

    side: Literal["left", "right", "on"]
    kerf: float


class Traverse(Struct, frozen=True, gc=False):
    """The head to a place, its tool off."""

    x: float
    y: float


class Feed(Struct, frozen=True, gc=False):
    """The tool along a line to a place."""

    x: float
    y: float


class ArcFeed(Struct, frozen=True, gc=False):
    """The tool along an arc; its centre counts from where the arc starts."""

    x: float
    y: float
    i: float
    j: float
    clockwise: bool


class ParabolaFeed(Struct, frozen=True, gc=False):
    """The tool along a parabola, whose tangent is parallel to the chord at the vertex (i, j)."""

    x: float
    y: float
    i: float  #: from where the parabola starts
    j: float


class EllipseFeed(Struct, frozen=True, gc=False):
    """The tool along an ellipse; its centre counts from where it starts."""

    x: float
    y: float
    i: float
    j: float
    angle: float  #: of the major axis, degrees
    ratio: float  #: minor by major axis
    clockwise: bool


class StartProfile(Struct, frozen=True):
    """The section that a torch goes round."""

    height: float
    width: float


class TurnTorch(Struct, frozen=True, gc=False):
    """The torch of a coper to an angle about the bar and a tilt along it, its tool off."""

    x: float
    y: float
    z: float
    a_deg: float
    b_deg: float = 0.0


class TorchTo(Struct, frozen=True, gc=False):
    """The torch of a coper along a line to a place, in rapid or with its tool on."""

    x: float
    y: float
    z: float
    rapid: bool


class TorchRound(Struct, frozen=True, gc=False):
    """The torch along a line while the bar turns below it, or while it turns and tilts itself."""

    x: float
    y: float
    z: float
    a_deg: float
    per_minute: float  #: inverse of the time that it takes
    b_deg: float | None = None  #: of a torch that tilts


Movement = Feed | ArcFeed | ParabolaFeed | EllipseFeed
Command = (
    StartBar | BeginPart | OfPart | SawStroke | DrillCycle | PathCycle | PrintText | ChangeTool
    | Comment | StartSheet | StartProfile | TurnTorch | TorchTo | TorchRound | ChooseTool
    | ChooseMaterial | ToolOn | CloseCut | ToolOff | SetFeed | Power | PassEnd | Compensate
    | Traverse | Movement
)  # fmt: skip


class Program(Struct, frozen=True):
    """A named sequence of commands."""

    job: str
    commands: tuple[Command, ...]
    #: of its parts, by the names of `description.PART_DATA`, for words of the head
    about: Mapping[str, str] = {}


# A chain of operations, each started by the arrival of the one before it.
#
# Lengths are mm in machine coordinates, counted from where homing ends.


SwitchProcess = Literal["cut", "mark", "engrave"]


class Travel(Struct, frozen=True):
    """Both axes to a place, so that they arrive together."""

    x: float
    y: float
    speed_mm_s: float  #: along the path
    source: Source | None = None


class ArcTravel(Struct, frozen=True):
    """Both axes along an arc of at most half a circle, through a place in its middle."""

    x: float
    y: float
    middle_x: float
    middle_y: float
    speed_mm_s: float
    source: Source | None = None


class LiftTorch(Struct, frozen=True):
    """The torch up or down to a height over the sheet, while X and Y rest."""

    height: float
    speed_mm_s: float
    source: Source | None = None


class SwitchTool(Struct, frozen=True):
    """The tool of a process on or off; the next operation waits for it."""

    process: SwitchProcess
    on: bool
    wait_s: float = 0.0
    source: Source | None = None


TriggerOp = Travel | ArcTravel | LiftTorch | SwitchTool


class TriggerTable(Struct, frozen=True):
    """The operations of a job, in order, from the corner of the work area and back to it."""

    job: str
    operations: tuple[TriggerOp, ...]
    remarks: tuple[str, ...] = ()  #: for the operator
    thickness: float = 0.0  #: of the sheet, for a table that lifts its torch


LASER_BIT = 4  #: of a row's bits; 0 and 1 are the word of X, 2 and 3 that of Y


class StepRows(NamedTuple):
    """Some rows of a step table that follow one another: at a time the words are so."""

    time_us: "NDArray[np.int64]"
    bits: "NDArray[np.uint8]"


class VelocityRow(NamedTuple):
    """A segment on which the velocity is a smooth function: one row of a velocity table."""

    x: float  #: end point
    y: float
    velocity_x: float  #: mm/s
    velocity_y: float
    laser: bool
    steps_x: int
    steps_y: int
    hz_x: float  #: step frequency
    hz_y: float


class StepTable(Struct, frozen=True):
    """A job for two stepping motors, from the shielded corner and back to it.

    `rows` and `segments` compute again what they give, piece by piece, so that a table of any
    length takes no memory.
    """

    job: str
    step: float  #: travel of one step, mm
    sequence: tuple[str, ...]  #: words of forward steps
    rows: Callable[[], Iterator[StepRows]]
    segments: Callable[[], Iterator[VelocityRow]]
    remarks: tuple[str, ...] = ()  #: for the operator
