"""What a program leaves to the hand as the machine's file says: told mark by mark."""

from collections.abc import Iterator

from beamcam.errors import Diagnostic, Rule, Severity
from beamcam.machine.machine import Machine
from beamcam.model.description import description
from beamcam.model.marks import policy_on
from beamcam.model.part import Feature, Part, TextMark

BY_HAND = Rule(
    "verify-by-hand",
    Severity.WARNING,
    "found nothing that makes the {what} of {mark}; it is left to the hand, as {machine} says",
    "`[marks]` in the machine's file says which kinds of marks are made by the machine, and which "
    "are left to the hand.",
)
RULES = (BY_HAND,)


def is_by_hand(feature: Feature, machine: Machine) -> bool:
    """Whether a feature is no work of the machine."""
    policy = policy_on(feature, machine.marks)
    return policy == "list" or (policy == "make" and isinstance(feature, TextMark))


def left_to_hand(part: Part, machine: Machine) -> Iterator[Diagnostic]:
    """A warning for each feature of a part that is no work of the machine."""
    for feature in part.features:
        if is_by_hand(feature, machine):
            yield BY_HAND.at(
                feature.source, what=description(feature), mark=part.mark, machine=machine.name
            )
