"""Rules for the rows of a step table."""

from beamcam.errors import error

# fmt: off


ROW = error("steps-row",
    "found {found}; expected {expected}",
    "The micro-controller would stop there, or read something else.")
HEAD = error("steps-head",
    "found {found} in the head of the table; expected {expected}",
    "The table is for motors or lead screws that this machine does not have.")
