"""The controllers of cutting tables that no G-code runs: trigger programs and stepper tables."""

from collections.abc import Mapping
from typing import Literal

from msgspec import Struct, field

#: Names of SIMOTION's library that neither a manual at hand nor a program that ran shows; the
#: package of a project may call them otherwise.
UNCONFIRMED = (
    "_enableAxis", "_move", "_homing", "NEGATIVE", "homingMode", "DIRECT_HOMING",
    "homePositionType", "homePosition", "control", "ACTIVE", "stopMode", "STOP_AND_ABORT",
    "negativeAccelType", "TRAPEZOIDAL", "pathObject", "X_Y", "posAxis",
)  # fmt: skip


class Triggers(Struct, frozen=True):
    """A motion controller that is told by a Structured Text program, one `_pos` an operation."""

    axes: tuple[str, str]  #: names of the axes of X and Y in the project
    limits: tuple[str, str, str, str]  #: input addresses: X low, X high, Y low, Y high
    start: str  #: input address of the button that starts the work
    outputs: Mapping[str, str]  #: output address of each process
    cycle_s: float  #: of the task that the program runs in
    acceleration: float  #: mm/s2 along the path
    traverse_mm_s: float  #: along the path with the tool off
    homing_mm_s: float = 10.0
    back_off: float = 30.0  #: from the limit switch to the corner of the work area
    overrun: float = 15.0  #: from the end of the work area to its limit switch
    in_position: float = 0.005  #: an axis this near to its end has arrived
    cycles_per_chord: float = 3.0
    package: str = "CAM"  #: technology package of the axes
    style: Literal["chain", "table"] = "chain"
    greatest_chain: int = 500  #: operations of a chain; a longer path has to be a table
    greatest_data: int = 65536  #: bytes of set-points in one unit
    path_objects: bool = False  #: whether the controller interpolates lines and circles
    path_object: str = "Path"  #: its name in the project
    names: Mapping[str, str] = field(default_factory=dict)  #: what the package calls otherwise


class Stepper(Struct, frozen=True):
    """Two stepping motors with lead screws, each driven by a word of two bits."""

    pitch: float  #: of the lead screw, a turn
    steps_per_turn: int
    acceleration: float  #: mm/s2 of each axis
    jerk: float  #: mm/s3 of each axis
    greatest_hz: float  #: step frequency of an axis
    traverse_mm_s: float
    corner: float = 0.01  #: how far a circle that is as fast may pass from a corner
    sequence: tuple[str, ...] = ("00", "01", "10", "11")  #: words of forward steps
    reversed_axes: tuple[Literal["X", "Y"], ...] = field(default=())  #: whose motor turns back

    @property
    def step(self) -> float:
        """Travel of one step."""
        return self.pitch / self.steps_per_turn
