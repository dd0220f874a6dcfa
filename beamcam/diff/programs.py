"""Two programs compared by what they mean, each read by its own machine."""

from typing import NamedTuple

from beamcam.diff.bars import diff_programs
from beamcam.diff.pairing import Difference
from beamcam.diff.statements import diff_statements, statements
from beamcam.errors import Diagnostic
from beamcam.machine.machine import Machine


class ProgramText(NamedTuple):
    """A program, and the machine that reads it."""

    name: str  #: in messages
    text: str
    machine: Machine


def diff_texts(
    a: ProgramText, b: ProgramText
) -> tuple[tuple[Difference, ...], tuple[Diagnostic, ...]]:
    """What program B makes otherwise than A, both for bars, sheets or profiles; and what is wrong
    with the blocks of either, at its own file and line."""
    if a.machine.stock in ("sheet", "profile"):
        (first, said), (second, more) = (statements(*one) for one in (a, b))
        return diff_statements(first, second, a.machine.format.length_decimals), (*said, *more)
    from beamcam.verify.bars import run

    old, new = (run(one.text, one.machine, None, one.name) for one in (a, b))
    step = max(a.machine.format.resolution, b.machine.format.resolution)
    return diff_programs(old.made, new.made, step), (*old.diagnostics, *new.diagnostics)
