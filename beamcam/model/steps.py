"""Tables for stepping motors: stretches with their velocities, and single steps."""

from collections.abc import Callable, Iterator
from typing import TYPE_CHECKING, NamedTuple

from msgspec import Struct

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

LASER_BIT = 4  #: of a row's bits; 0 and 1 are the word of X, 2 and 3 that of Y


class StepRows(NamedTuple):
    """Some rows of a step table that follow one another: at a time the words are so."""

    time_us: "NDArray[np.int64]"
    bits: "NDArray[np.uint8]"


class VelocityRow(NamedTuple):
    """A stretch on which the velocity is a smooth function: one row of a velocity table."""

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

    `rows` and `stretches` compute again what they give, piece by piece, so that a table of any
    length takes no memory.
    """

    job: str
    step: float  #: travel of one step, mm
    sequence: tuple[str, ...]  #: words of forward steps
    rows: Callable[[], Iterator[StepRows]]
    stretches: Callable[[], Iterator[VelocityRow]]
    remarks: tuple[str, ...] = ()  #: for the operator
