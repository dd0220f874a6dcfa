"""The controllers of cutting tables that no G-code runs: trigger programs and stepper tables.

The dialects of Structured Text that trigger programs are written in.

Their differences are data, here and in the shipped texts of `runtime`, for the emitter, the reader
and the simulation alike.
"""

from collections.abc import Mapping
from math import floor
from typing import Annotated, Literal

from msgspec import Meta, Struct, field

from beamcam.conversion import Keys, Positive, PositiveCount

#: Names of SIMOTION's library that neither a manual at hand nor a program that ran shows; the
#: package of a project may call them otherwise.
UNCONFIRMED = (
    "_enableAxis", "_move", "_homing", "NEGATIVE", "homingMode", "DIRECT_HOMING",
    "homePositionType", "homePosition", "control", "ACTIVE", "stopMode", "STOP_AND_ABORT",
    "negativeAccelType", "TRAPEZOIDAL", "pathObject", "X_Y", "posAxis", "basicMotion.position",
    "positioningState", "commandPosition", "error", "NO", "_resetAxisError", "errorResetMode",
    "ALL_ERRORS",
)  # fmt: skip

#: Names of PLCopen's blocks; the library of a controller may call them otherwise.
PLCOPEN_NAMES = (
    "AXIS_REF", "MC_Power", "MC_MoveAbsolute", "MC_Halt", "MC_SetPosition", "MC_Stop", "MC_Reset",
    "MC_ReadStatus", "MC_ReadActualPosition", "MC_ReadParameter", "PLC",
)  # fmt: skip


class TableDialect(Struct, frozen=True):
    """What the programs of a family of controllers have of their own besides their text."""

    text: str  #: shipped text
    homing: str  #: shipped text of the homing of an axis
    constants: str  #: section that declares the numbers of a job
    variables: str  #: section that declares its triggers, and its arrays where they have no unit
    has_units: bool  #: whether set-points are units of their own, which the program uses
    address: str  #: form of the address behind %I or %Q
    renamed: tuple[str, ...]  #: names of its library that a machine's file may have another for
    library: str = ""  #: shipped declarations of its library, where they are Structured Text too
    without: tuple[str, ...] = ()  #: keys of [triggers] that mean nothing to it


DIALECTS = {
    "simotion": TableDialect(
        text="cut_part",
        homing="homing",
        constants="VAR_GLOBAL CONSTANT",
        variables="VAR_GLOBAL",
        has_units=True,
        address=r"\d+\.[0-7]",
        renamed=UNCONFIRMED,
    ),
    "plcopen": TableDialect(
        text="plcopen",
        homing="plcopen_homing",
        constants="VAR_OUTPUT",
        variables="VAR",
        has_units=False,
        address=r"X?\d+(\.\d+)*",
        renamed=PLCOPEN_NAMES,
        library="plcopen_blocks",
        without=("path_objects", "path_object", "package", "uses", "max_data"),
    ),
}  #: by the controller of a machine


LateFactor = Annotated[float, Meta(ge=1.0, le=10.0)]  #: no operation is sooner than its time
UnitBytes = Annotated[int, Meta(ge=1024)]  #: a unit has to hold some set-points
#: No task of such a controller comes round sooner.
Cycle = Annotated[float, Meta(ge=0.0005, extra={"unit": "s"})]


READ_ROUNDING = 1e-9  #: of a count; an axis that stands on a count is at it


class HeightAxis(Keys, frozen=True):
    """The axis that lifts the torch. Up is positive; 0 is where the sheet lies on.

    Homing runs up against the high limit switch and backs off, before X and Y move.
    """

    axis: str  #: its name in the project
    limits: tuple[str, str]  #: inputs: low, high
    home_height: Positive  #: of the torch over what the sheet lies on, where homing ends
    clearance: Positive  #: of the torch over the sheet as X and Y move with the tool off
    speed_mm_s: Positive  #: up and down
    back_off: Positive = 5.0  #: from the high limit switch down to where homing ends
    count: Positive = 0.01  #: travel of a count of its encoder
    arrival_window: Positive = 0.05  #: of its actual position about its set position; counts


class Triggers(Keys, frozen=True):
    """A motion controller run by a Structured Text program, one command of an axis per operation.

    Inputs and outputs are addresses such as %I0.0 or names of variables of the project.
    """

    axes: tuple[str, str]  #: names of the axes of X and Y in the project
    limits: tuple[str, str, str, str]  #: inputs: X low, X high, Y low, Y high
    start: str  #: input of the button that starts the work
    outputs: Mapping[str, str]  #: output of each process
    cycle_s: Cycle  #: of the TimerInterruptTask that the program runs in
    acceleration: Positive  #: mm/s2 along the path
    traverse_mm_s: Positive  #: along the path with the tool off
    acknowledge: str = ""  #: input of the button that acknowledges a fault; a variable if absent
    stop: str = ""  #: input of the stop button, not the emergency stop; a variable if absent
    normally_closed: tuple[str, ...] = ()  #: inputs that are off when actuated, or a wire breaks
    fault_lamp: str = ""  #: output that shows a fault
    uses: tuple[str, ...] = ()  #: units of the project that declare named inputs and outputs
    homing_mm_s: Positive = 10.0  #: towards the limit switches
    homing_slow_mm_s: Positive = 1.0  #: off a low switch and against it for the second time
    max_homing_s: Positive = 120.0  #: of homing both axes; longer is a fault
    late_factor: LateFactor = 1.1  #: times the time of its way and ramps an operation may take
    max_late_s: Positive = 0.5  #: and this much more: the end seen, and the lag run down
    back_off: Positive = 30.0  #: from the limit switch to the corner of the work area
    overrun: Positive = 15.0  #: from the end of the work area to its limit switch
    in_position: Positive = 0.005  #: a set position this near to its end has arrived
    standstill: Positive = 0.0001  #: largest move per cycle of an axis at rest
    arrival_window: Positive = 0.26  #: of an actual position about its set position; encoder counts
    following_lag_s: Positive = 0.05  #: times an axis's own speed it may trail its set position
    counts_per_turn: PositiveCount = 512  #: of the encoder: its pulses
    quadrature: bool = False  #: whether both edges of both tracks count: four for each pulse
    #: what is read within a count: its lower end, or the multiple of a count that is nearest
    counted: Literal["floor", "centre"] = "floor"
    travel_per_turn: Positive = 65.0  #: of an axis, for a turn of its encoder
    cycles_per_chord: Positive = 3.0  #: that a chord takes at least; the feed is reduced for it
    package: str = ""  #: technology package; CAM for axes, PATH for path objects if absent
    style: Literal["chain", "table"] = "chain"  #: of its programs, where no job says another
    max_chain: PositiveCount = 500  #: operations of a chain; a longer path has to be a table
    max_data: UnitBytes = 65536  #: bytes of set-points in one unit
    path_objects: bool = False  #: whether the controller interpolates lines and circles
    path_object: str = "Path"  #: its name in the project
    names: Mapping[str, str] = field(default_factory=dict)  #: what the package calls otherwise
    z: HeightAxis | None = None  #: the axis of the torch's height, where the table has one

    @property
    def all_axes(self) -> tuple[str, ...]:
        """Names of the axes of X, Y and, where there is one, Z."""
        return self.axes if self.z is None else (*self.axes, self.z.axis)

    @property
    def inputs(self) -> tuple[str, ...]:
        """Places of X low, X high, Y low, Y high, start, acknowledge and stop; "" if absent.

        Behind them those of Z low and Z high, where there is a Z.
        """
        of_z = () if self.z is None else self.z.limits
        return (*self.limits, self.start, self.acknowledge, self.stop, *of_z)

    @property
    def homing_window(self) -> float:
        """How far apart the fast and the slow approach may see a low switch.

        Two cycles at the fast speed, in which a switch may be seen late, and the encoder's window.
        """
        return self.arrival_window + 2 * self.cycle_s * self.homing_mm_s

    @property
    def lift_window(self) -> float:
        """The same of Z and its high switch; that of X and Y where there is no Z."""
        window = self.arrival_window if self.z is None else self.z.arrival_window
        return window + 2 * self.cycle_s * self.homing_mm_s

    @property
    def technology(self) -> str:
        """The technology package that the program needs."""
        return self.package or ("PATH" if self.path_objects else "CAM")

    @property
    def count(self) -> float:
        """Travel of an encoder's count."""
        return self.travel_per_turn / self.counts_per_turn / (4 if self.quadrature else 1)

    def home_over(self, thickness: float) -> float:
        """Height of the torch over a sheet where homing ends; 0 where it is not lifted."""
        return 0.0 if self.z is None else round(self.z.home_height - thickness, 6)

    def counts(self) -> tuple[float, ...]:
        """Travel of an encoder's count of each axis."""
        return (self.count,) * 2 if self.z is None else (self.count, self.count, self.z.count)

    def read(self, position: float, count: float | None = None) -> float:
        """What the encoder reads of an axis at a position; of X or Y where no count is given."""
        count = count or self.count
        above = 0.0 if self.counted == "floor" else 0.5
        return floor(position / count + above + READ_ROUNDING) * count

    def least_window(self, count: float) -> float:
        """How far what the encoder reads may be from where an axis at rest is: a count, or half."""
        return count if self.counted == "floor" else count / 2


#: Forms of a stepper table, by their suffix.
STEP_FORMS = (".steps", ".csv", ".bin", ".h")


class Stepper(Keys, frozen=True):
    """Two stepping motors with lead screws, each driven by a word of two bits."""

    pitch: Positive  #: of the lead screw, a turn
    steps_per_turn: PositiveCount  #: of the motor
    acceleration: Positive  #: mm/s2 of each axis
    jerk: Positive  #: mm/s3 of each axis
    max_hz: Positive  #: step frequency of an axis
    traverse_mm_s: Positive  #: along the path with the laser off
    corner: Positive = 0.01  #: how far a circle that is as fast may pass from a corner
    sequence: tuple[str, ...] = ("00", "01", "10", "11")  #: words of forward steps
    reversed_axes: tuple[Literal["X", "Y"], ...] = field(default=())  #: whose motor turns back

    @property
    def step(self) -> float:
        """Travel of one step."""
        return self.pitch / self.steps_per_turn


#: Controllers driven by a table or a chain of triggers, which have no words.
TABLE_CONTROLLERS = (*DIALECTS, "stepper")
