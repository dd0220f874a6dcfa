"""Two programs of a machine compared by what they mean."""

from msgspec import Struct

from beamcam.controllers import rules
from beamcam.diff.pairing import Difference
from beamcam.errors import Diagnostic, Severity, VerifyError
from beamcam.machine import Machine
from beamcam.pipeline import read_back
from beamcam.posts import Request
from beamcam.verify.head import head_of

#: Faults that make a program's meaning unknown.
NOT_UNDERSTOOD = {r.code for r in (rules.SYNTAX, rules.WORD, rules.ARC)}


class Compared(Struct, frozen=True):
    """What the second of two programs or parts makes otherwise, and what is wrong with them."""

    differences: tuple[Difference, ...]
    diagnostics: tuple[Diagnostic, ...]


def compared(texts: list[tuple[str, str]], machine: Machine) -> Compared:
    """What the second of two programs, each with its name, makes otherwise.

    Raises VerifyError where their blocks are not understood.
    """
    (name, first), (_, second) = texts
    if machine.stock == "sheet":
        from beamcam.diff.statements import diff_sheets

        found, said = diff_sheets(first, second, machine, name)
        if said:
            raise VerifyError(said)
        alone = [one for name, text in texts for one in _alone(text, machine, name)]
        return Compared((*found, *_left_to_hand(first, second)), tuple(alone))
    from beamcam.diff.differ import diff_programs
    from beamcam.verify.bars import run

    runs = [run(text, machine, None, name) for name, text in texts]
    faults = tuple(d for done in runs for d in done.diagnostics)
    if any(d.code in NOT_UNDERSTOOD for d in faults):
        raise VerifyError(faults)
    old, new = (done.made for done in runs)
    different = diff_programs(old, new, machine.format.resolution)
    return Compared((*different, *_left_to_hand(first, second)), faults)


def _alone(text: str, machine: Machine, name: str) -> list[Diagnostic]:
    said = read_back(text, Request((), machine, name=name))
    return [d for d in said if d.severity is not Severity.NOTE]


def _left_to_hand(first: str, second: str) -> tuple[Difference, ...]:
    """Whether the heads of two programs leave different numbers of marks for manual work."""
    heads = [head_of(text) for text in (first, second)]
    old, new = (0 if head is None else head.by_hand for head in heads)
    if old == new:
        return ()
    text = f"marks left for manual work: {old} in A, {new} in B"
    return (Difference("feature", "changed", text),)
