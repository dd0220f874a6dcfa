"""Trigger programs, of SIMOTION or plain: their fixed part compared, the job in them read.

text -> fixed part, byte by byte -> operations (job)
machine -> fixed part, parsed, checked and run with simulated axes, once (trial)
Structured Text: lexer -> parser, or plain (syntax) -> names, types, bounds (checker) -> interpreter
commands of axes: cutting_table, or motion_blocks where they are function blocks of PLCopen
"""

from beamcam.controllers.simotion.job import JobRead, read_job
from beamcam.errors import Diagnostic, VerifyError
from beamcam.machine.machine import Machine


def read_program(
    text: str, machine: Machine, name: str = "program"
) -> tuple[JobRead | None, list[Diagnostic]]:
    """The job of a program; None and what is wrong where it cannot be read."""
    try:
        return read_job(text, machine, name), []
    except VerifyError as error:
        return None, list(error.diagnostics)
