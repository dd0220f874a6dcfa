"""What can be wrong with an output."""

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

RULES = (OUTPUT_FORMAT, ONE_PART)
