"""The head of a program, which records how it was made.

    (BEAMCAM 1 MACHINE beamline 5f3a9c2e)        version of the form, machine, checksum of its file
    (ALLOWED TO BE LEFT OUT: cope, slot)         the kinds that --allow-skips named, if any
    (LEFT TO THE HAND: 2)                        marks left for manual work, if any

It is read whatever signs a controller has for comments, and written nowhere in this package: a
program whose head says otherwise than what was asked for is refused.
"""

import re
from collections.abc import Collection, Iterator

from msgspec import Struct

from beamcam.errors import Diagnostic, Rule, Severity, Source
from beamcam.machine.machine import Machine

VERSION = 1  #: newest form that is known
MOST_BEFORE = 65_536  #: characters of a program before its head
MOST_CHARACTERS = 1024  #: of the head itself; all kinds that there are take 300

_MADE = re.compile(r"BEAMCAM ([0-9]{1,6}) MACHINE (\S+)(?: ([0-9a-f]{8})\b)?")
_ALLOWED = re.compile(r"ALLOWED TO BE LEFT OUT: ([a-z-]+(?:, [a-z-]+)*)")
_BY_HAND = re.compile(r"LEFT TO THE HAND: ([0-9]{1,9})")

HEAD = Rule(
    "verify-head",
    Severity.ERROR,
    "found {found} in the head of the program; expected {expected}",
    "The head says which kinds of features may be missing, how many marks are left for manual "
    "work, and for which machine file the program was made. A wrong head would mislead a later "
    "check.",
)
NEWER = Rule(
    "verify-head-newer",
    Severity.WARNING,
    "found a program of form {found}; expected {expected} at most, this beamcam is older",
    "A newer beamcam may say things in a program that this one does not look for.",
)
MACHINE_CHANGED = Rule(
    "verify-machine-changed",
    Severity.WARNING,
    "found a program for the machine {found}; the machine file is now {expected}",
    "The machine's file has changed since the program was made: offsets, tools or limits may be "
    "others. Post the part again.",
)
RULES = (HEAD, NEWER, MACHINE_CHANGED)


class Head(Struct, frozen=True):
    """The head of a program."""

    version: int
    machine: str
    checksum: str  #: "" where the machine did not come from a file
    allowed: tuple[str, ...]  #: kinds of features that may be left out, sorted
    by_hand: int = 0  #: marks left for manual work


def head_of(text: str) -> Head | None:
    """The head of a program; None for one without a head, such as a handwritten one."""
    made = _MADE.search(text, 0, MOST_BEFORE)
    if made is None:
        return None
    lines = _ALLOWED.finditer(text, made.end(), made.end() + MOST_CHARACTERS)
    kinds = {kind for found in lines for kind in found[1].split(", ")}
    hand = _BY_HAND.search(text, made.end(), made.end() + MOST_CHARACTERS)
    by_hand = int(hand[1]) if hand else 0
    return Head(int(made[1]), made[2], made[3] or "", tuple(sorted(kinds)), by_hand)


def head_faults(
    head: Head | None, machine: Machine, allowed: Collection[str], name: str, by_hand: int = 0
) -> Iterator[Diagnostic]:
    """All differences of a head from the request and from the read-back.

    `by_hand` is the number of marks that the read-back found left for manual work.
    """
    source = Source(name)
    kinds = ", ".join(sorted(allowed)) or "none"
    if head is None:
        yield HEAD.at(source, found="no head", expected=f"one that allows {kinds}")
    elif head.allowed != tuple(sorted(allowed)):
        found = ", ".join(head.allowed) or "none"
        yield HEAD.at(source, found=f"a head that allows {found}", expected=kinds)
    elif head.by_hand != by_hand:
        yield HEAD.at(source, found=f"{head.by_hand} left for manual work", expected=by_hand)
    elif head.version != VERSION or head.checksum != machine.checksum:
        found = f"the form {head.version} and the checksum {head.checksum or 'none'}"
        expected = f"{VERSION} and {machine.checksum or 'none'}"
        yield HEAD.at(source, found=found, expected=expected)


def head_remarks(head: Head | None, machine: Machine, name: str) -> Iterator[Diagnostic]:
    """A warning where a program was made by a newer beamcam, or for another machine file."""
    if head is None:
        return
    if head.version > VERSION:
        yield NEWER.at(Source(name), found=head.version, expected=VERSION)
    if head.checksum and machine.checksum and head.checksum != machine.checksum:
        yield MACHINE_CHANGED.at(
            Source(name), found=f"{head.machine} {head.checksum}",
            expected=f"{machine.name} {machine.checksum}",
        )  # fmt: skip
