"""Rules for the rows of a step table."""

from beamcam.errors import Rule, Severity

_E = Severity.ERROR

ROW = Rule(
    "steps-row",
    _E,
    "found {found}; expected {expected}",
    "The micro-controller would stop there, or read something else.",
)
HEAD = Rule(
    "steps-head",
    _E,
    "found {found} in the head of the table; expected {expected}",
    "The table is for motors or lead screws that this machine does not have.",
)

RULES = (ROW, HEAD)
