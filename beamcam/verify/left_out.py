"""Features that a program leaves out as the user allowed, reported one by one."""

from collections.abc import Iterable, Iterator

from beamcam.errors import Diagnostic, error, warning
from beamcam.machine.machine import Machine
from beamcam.model.description import description, policy_on
from beamcam.model.part import Feature, Part, TextMark

LEFT_OUT = warning("verify-left-out",
    "found nothing that makes the {what} of {mark}; it may be left out, and is not made",
    "The machine cannot make it and its kind is allowed to be missing, by `--allow-skips` or the "
    "head of the program. It has to be made manually or on another machine.")  # fmt: skip
LEDGER = error("verify-ledger",
    "found {found} feature(s) missing from the program; expected {expected}, as planned",
    "What is missing from a program has to be what the plan left out by name, and nothing else. It "
    "is a fault of beamcam; send in the part.")  # fmt: skip
TEXT_TOLD = error("verify-text-told",
    "found a text lettered {found}; expected it {expected}, as planned",
    "The plan reports where a text is moved or made smaller, the read-back finds it in the "
    "program, and both have to agree. It is a fault of beamcam; send in the part.")  # fmt: skip


def left_out(part: Part, features: Iterable[int]) -> Iterator[Diagnostic]:
    """A warning for each of the features of a part, by their indices, that a program leaves out."""
    for index in sorted(features):
        feature = part.features[index]
        yield LEFT_OUT.at(feature.source, what=description(feature), mark=part.mark)


# --- by hand --------------------------------------------------------------------------------------

# Marks that a program leaves for manual work or makes elsewhere, reported one by one.


BY_HAND = warning("verify-by-hand",
    "found nothing that makes the {what} of {mark}; it is left for manual work, as {machine} says",
    "`[marks]` in the machine's file says which kinds of marks are made by the machine, and which "
    "are left for manual work.")  # fmt: skip
TEXT_MOVED = warning("verify-text-moved",
    "found the text {text!r} at x {x}, y {y}, {height} mm high; at x {wanted_x}, y {wanted_y}, "
    "{wanted_height} mm high it would not be clear",
    "A text that would stand on an edge or over a hole is moved, or made smaller.")  # fmt: skip


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


# --- uncut ----------------------------------------------------------------------------------------

# Waste of sheets that no beam reaches, and that stays on the part.


UNCUT = warning("verify-sheet-left",
    "found {found} mm of waste in a corner at x {x}, y {y} that the beam does not reach; it stays "
    "on the part",
    "A round beam stops before a sharp corner. Where that matters, the place is finished by "
    "hand.")  # fmt: skip
UNCUT_TOLD = error("verify-sheet-untold",
    "found {found} mm of waste in a corner at x {x}, y {y} that the beam does not reach; expected "
    "it to be reported by the plan",
    "The plan reports what stays on a part, the read-back finds it in the program, and both have "
    "to agree. It is a fault of beamcam; send in the part.")  # fmt: skip


RULES = (LEFT_OUT, LEDGER, TEXT_TOLD, BY_HAND, TEXT_MOVED, UNCUT, UNCUT_TOLD)
