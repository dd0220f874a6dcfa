"""What the controller of a cutting table does not do as a program says."""

from beamcam.errors import Rule, Severity

_E = Severity.ERROR

SYNTAX = Rule(
    "verify-sheet-syntax",
    _E,
    "found {found!r}; expected {expected}",
    "The controller would stop at that block, or read something else than was meant.",
)
WORD = Rule(
    "verify-sheet-word",
    _E,
    "found {found}; expected {expected}",
    "What the read-back does not know it cannot vouch for, so it refuses the program.",
)
SETTING = Rule(
    "verify-sheet-setting",
    _E,
    "found a move before {found}; expected it to be set at the beginning",
    "Units, plane and the way of counting are what the last program left, if this one is silent.",
)
END = Rule(
    "verify-sheet-end",
    _E,
    "found {found}; expected M2 or M30 once, as the last command, the tool off",
    "A program that was cut off in the middle looks like a whole one up to its last line.",
)
ARC = Rule(
    "verify-sheet-arc",
    _E,
    "found an arc {found}; expected one that {controller} takes for what it is",
    "Controllers refuse an arc whose ends and centre disagree, or make a line or a circle of it.",
)
RULES = (SYNTAX, WORD, SETTING, END, ARC)
