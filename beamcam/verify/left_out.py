"""Features that a program leaves out as the user allowed, reported one by one."""

from collections.abc import Iterable, Iterator

from beamcam.errors import Diagnostic, Rule, Severity
from beamcam.model.description import description
from beamcam.model.part import Part

LEFT_OUT = Rule(
    "verify-left-out",
    Severity.WARNING,
    "found nothing that makes the {what} of {mark}; it may be left out, and is not made",
    "The machine cannot make it and its kind is allowed to be missing, by `--allow-skips` or the "
    "head of the program. It has to be made manually or on another machine.",
)
LEDGER = Rule(
    "verify-ledger",
    Severity.ERROR,
    "found {found} feature(s) missing from the program; expected {expected}, as planned",
    "What is missing from a program has to be what the plan left out by name, and nothing else. It "
    "is a fault of beamcam; send in the part.",
)
TEXT_TOLD = Rule(
    "verify-text-told",
    Severity.ERROR,
    "found a text lettered {found}; expected it {expected}, as planned",
    "The plan reports where a text is moved or made smaller, the read-back finds it in the "
    "program, and both have to agree. It is a fault of beamcam; send in the part.",
)
RULES = (LEFT_OUT, LEDGER, TEXT_TOLD)


def left_out(part: Part, features: Iterable[int]) -> Iterator[Diagnostic]:
    """A warning for each of the features of a part, by their indices, that a program leaves out."""
    for index in sorted(features):
        feature = part.features[index]
        yield LEFT_OUT.at(feature.source, what=description(feature), mark=part.mark)
