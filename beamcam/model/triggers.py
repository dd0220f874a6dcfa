"""A chain of operations, each started by the arrival of the one before it.

Lengths are mm in machine coordinates, counted from where homing ends.
"""

from typing import Literal

from msgspec import Struct

from beamcam.errors import Source

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


class Lift(Struct, frozen=True):
    """The torch up or down to a height over the sheet, while X and Y rest."""

    height: float
    speed_mm_s: float
    source: Source | None = None


class Switch(Struct, frozen=True):
    """The tool of a process on or off; the next operation waits for it."""

    process: SwitchProcess
    on: bool
    wait_s: float = 0.0
    source: Source | None = None


TriggerOp = Travel | ArcTravel | Lift | Switch


class TriggerTable(Struct, frozen=True):
    """The operations of a job, in order, from the corner of the work area and back to it."""

    job: str
    operations: tuple[TriggerOp, ...]
    remarks: tuple[str, ...] = ()  #: for the operator
    thickness: float = 0.0  #: of the sheet, for a table that lifts its torch
