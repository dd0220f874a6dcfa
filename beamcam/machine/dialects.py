"""The dialects of Structured Text that trigger programs are written in.

Their differences are data, here and in the shipped texts of `runtime`, for the emitter, the reader
and the simulation alike.
"""

from msgspec import Struct

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


class Dialect(Struct, frozen=True):
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
    "simotion": Dialect(
        text="cut_part",
        homing="homing",
        constants="VAR_GLOBAL CONSTANT",
        variables="VAR_GLOBAL",
        has_units=True,
        address=r"\d+\.[0-7]",
        renamed=UNCONFIRMED,
    ),
    "plcopen": Dialect(
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
