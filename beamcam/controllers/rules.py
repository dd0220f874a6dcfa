"""What a controller does not do as a program says."""

from beamcam.errors import Rule, Severity

SYNTAX = Rule(
    "verify-syntax",
    Severity.ERROR,
    "found {found!r}; expected {expected}",
    "The controller would stop at that block, or read something else than was meant.",
)
WORD = Rule(
    "verify-word",
    Severity.ERROR,
    "found {found}; expected {expected}",
    "What the read-back does not know it cannot vouch for, so it refuses the program.",
)
M_QUEUE = Rule(
    "verify-m-queue",
    Severity.ERROR,
    "found {found} M words in a row; expected at most {expected}",
    "CODESYS runs out of its queue (SMC_DEC_OUTQUEUE_RAN_EMPTY); a G75 before resets the count.",
)
ARC = Rule(
    "verify-arc",
    Severity.ERROR,
    "found an arc {found}; expected {expected}",
    "CODESYS replaces an arc that does not fit together by a straight line without a word.",
)

RULES = (SYNTAX, WORD, M_QUEUE, ARC)
