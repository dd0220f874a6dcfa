"""Two programs of a machine compared by what they mean."""

from msgspec import Struct

from beamcam.asked import ASK_TYPE, AnyMachine, AskError, machine_of
from beamcam.controllers import rules
from beamcam.diff.pairing import Difference
from beamcam.diff.programs import ProgramText, diff_texts
from beamcam.errors import Diagnostic, Severity, Source, VerifyError
from beamcam.machine.names import DEFAULT_MACHINE
from beamcam.model.request import Request
from beamcam.pipeline import read_back
from beamcam.verify.head import head_of

#: Faults that make a program's meaning unknown.
NOT_UNDERSTOOD = {r.code for r in (rules.SYNTAX, rules.WORD, rules.ARC)}


class Compared(Struct, frozen=True):
    """What the second of two programs or parts makes otherwise, and what is wrong with them."""

    differences: tuple[Difference, ...]
    diagnostics: tuple[Diagnostic, ...]


def compared(a: ProgramText, b: ProgramText) -> Compared:
    """What the second of two programs makes otherwise.

    Raises VerifyError where their blocks are not understood; AskError for a program of bars and one
    of sheets.
    """
    if a.machine.stock != b.machine.stock:
        one, other = (f"a program for {p.machine.name}, a {p.machine.stock}" for p in (b, a))
        raise AskError(ASK_TYPE.at(Source(b.name), name="b", found=one, expected=f"one as {other}"))
    different, said = diff_texts(a, b)
    is_sheet = a.machine.stock == "sheet"
    if (is_sheet and said) or any(one.code in NOT_UNDERSTOOD for one in said):
        raise VerifyError(said)
    if is_sheet:
        said = tuple(fault for one in (a, b) for fault in _alone(one))
    return Compared((*different, *_left_to_hand(a.text, b.text)), said)


def _alone(program: ProgramText) -> list[Diagnostic]:
    said = read_back(program.text, Request((), program.machine, name=program.name))
    return [d for d in said if d.severity is not Severity.NOTE]


def program_text(name: str, text: str, machine: AnyMachine | None) -> ProgramText:
    """A program and the machine that reads it: the one given, else the one that its head names.

    Raises MachineError.
    """
    if machine is None:
        head = head_of(text)
        machine = DEFAULT_MACHINE if head is None else head.machine
    return ProgramText(name, text, machine_of(machine))


def _left_to_hand(first: str, second: str) -> tuple[Difference, ...]:
    """Whether the heads of two programs leave different numbers of marks for manual work."""
    heads = [head_of(text) for text in (first, second)]
    old, new = (0 if head is None else head.by_hand for head in heads)
    if old == new:
        return ()
    text = f"marks left for manual work: {old} in A, {new} in B"
    return (Difference("feature", "changed", text),)
