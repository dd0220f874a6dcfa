"""Rules for what a controller does not execute as programmed.

Programs of bars and of sheets have codes of their own for the same fault, because scripts know
them.
"""

from typing import Literal

from msgspec import Struct

from beamcam.errors import Rule, Severity, error

# fmt: off

_E = Severity.ERROR

SYNTAX = error("verify-syntax",
    "found {found!r}; expected {expected}",
    "The controller would stop at that block, or read something else than was meant.")
WORD = error("verify-word",
    "found {found}; expected {expected}",
    "What the read-back does not know it cannot vouch for, so it refuses the program.")
M_QUEUE = error("verify-m-queue",
    "found {found} M words in a row; expected at most {expected}",
    "CODESYS runs out of its queue (SMC_DEC_OUTQUEUE_RAN_EMPTY); a G75 before resets the count.")
ARC = error("verify-arc",
    "found an arc {found}; expected one that start, end and centre agree on",
    "CODESYS silently replaces an inconsistent arc by a straight line.")
SETTING = error("verify-setting",
    "found a move before {found}; expected it to be set at the beginning",
    "Units, plane and the way of counting are what the last program left, if this one is silent.")
END = error("verify-end",
    "found {found}; expected M30 once, as the last command",
    "A program that was cut off in the middle looks like a whole one up to its last line.")
SHEET_SYNTAX = Rule("verify-sheet-syntax", _E, SYNTAX.message, SYNTAX.reason)
SHEET_WORD = Rule("verify-sheet-word", _E, WORD.message, WORD.reason)
SHEET_ARC = error("verify-sheet-arc",
    "found an arc {found}; expected one that {controller} reads as meant",
    "Controllers refuse an arc whose ends and centre disagree, or make a line or a circle of it.")
SHEET_SETTING = Rule("verify-sheet-setting", _E, SETTING.message, SETTING.reason)
SHEET_END = Rule(
    "verify-sheet-end",
    _E,
    "found {found}; expected M2 or M30 once, as the last command, the tool off",
    END.reason,
)


class ProgramRules(Struct, frozen=True):
    """The rules of all controllers' programs, as they are called for one kind of stock."""

    syntax: Rule
    word: Rule
    arc: Rule
    setting: Rule
    end: Rule


_BARS = ProgramRules(SYNTAX, WORD, ARC, SETTING, END)
#: A profile that is coped is a bar.
BY_STOCK: dict[Literal["beam", "sheet", "profile"], ProgramRules] = {
    "beam": _BARS,
    "profile": _BARS,
    "sheet": ProgramRules(SHEET_SYNTAX, SHEET_WORD, SHEET_ARC, SHEET_SETTING, SHEET_END),
}
BAR_RULES = (SYNTAX, WORD, M_QUEUE, ARC, SETTING, END)
SHEET_RULES = (SHEET_SYNTAX, SHEET_WORD, SHEET_ARC, SHEET_SETTING, SHEET_END)
RULES = (*BAR_RULES, *SHEET_RULES)
