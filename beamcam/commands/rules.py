"""What can be wrong with an output, and what a command tells of its work."""

from beamcam.errors import Rule, Severity

OUTPUT_FORMAT = Rule(
    "write-format",
    Severity.ERROR,
    "found {found!r} for the output's format; expected one of {expected}, or --to",
    "The suffix of the output says how it is written.",
)
ONE_PART = Rule(
    "write-one-part",
    Severity.ERROR,
    "found {found} parts to write to {output!r}; expected one, or a folder/ for a file a part",
    "A DSTV file, a JSON part and a drawing of faces hold one part each.",
)
CANNOT_WRITE = Rule(
    "write-file",
    Severity.ERROR,
    "{found!r} cannot be written ({reason}); expected a place with room that may be written to",
    "The disk is full, or the folder is not there or may not be written to. An old file still "
    "stands.",
)
ACCOUNT = Rule(
    "account",
    Severity.NOTE,
    "{found}",
    "What was done and how long it took, under `--verbose` with `--json`.",
)

RULES = (OUTPUT_FORMAT, ONE_PART, CANNOT_WRITE, ACCOUNT)
