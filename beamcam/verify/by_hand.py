"""Marks that a program leaves for manual work or makes elsewhere, reported one by one."""

from collections.abc import Iterator

from beamcam.errors import Diagnostic, Rule, Severity
from beamcam.machine.machine import Machine
from beamcam.model.description import description
from beamcam.model.marks import policy_on
from beamcam.model.part import Feature, Part, TextMark

BY_HAND = Rule(
    "verify-by-hand",
    Severity.WARNING,
    "found nothing that makes the {what} of {mark}; it is left for manual work, as {machine} says",
    "`[marks]` in the machine's file says which kinds of marks are made by the machine, and which "
    "are left for manual work.",
)
TEXT_MOVED = Rule(
    "verify-text-moved",
    Severity.WARNING,
    "found the text {text!r} at x {x}, y {y}, {height} mm high; at x {wanted_x}, y {wanted_y}, "
    "{wanted_height} mm high it would not be clear",
    "A text that would stand on an edge or over a hole is moved, or made smaller.",
)
RULES = (BY_HAND, TEXT_MOVED)


def is_by_hand(feature: Feature, machine: Machine) -> bool:
    """Whether a feature is not the machine's work."""
    policy = policy_on(feature, machine.marks)
    if policy == "make" and isinstance(feature, TextMark):
        return machine.marks.unit == "none"
    return policy == "list"


def left_to_hand(part: Part, machine: Machine) -> Iterator[Diagnostic]:
    """A warning for each feature of a part that is not the machine's work."""
    for feature in part.features:
        if is_by_hand(feature, machine):
            yield by_hand(feature, part, machine)


def by_hand(feature: Feature, part: Part, machine: Machine) -> Diagnostic:
    """The remark that a feature is left for manual work."""
    return BY_HAND.at(
        feature.source, what=description(feature), mark=part.mark, machine=machine.name
    )
