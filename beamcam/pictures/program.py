"""The picture of any program, from what the interpreter of its machine finds in it."""

from hashlib import sha256
from typing import TYPE_CHECKING

from msgspec import Struct

from beamcam.errors import VerifyError, errors_in
from beamcam.machine.machine import Machine
from beamcam.model.part import Part
from beamcam.pictures.scene import Scene, Unit

if TYPE_CHECKING:
    from beamcam.pictures.bar_made import BarMade
    from beamcam.pictures.coper import CoperProgram
    from beamcam.pictures.table import TableMade
    from beamcam.simulation.program import Simulated


class ReadProgram(Struct, frozen=True):
    """A program as bytes, and what is known of the job besides."""

    data: bytes
    machine: Machine
    name: str
    style: str = ""  #: suffix of a step table
    parts: tuple[Part, ...] = ()  #: in their order along the bar, as far as they are known
    bar: float | None = None  #: its length

    @property
    def text(self) -> str:
        """The program; bytes that are not text become U+FFFD."""
        return self.data.decode("utf-8", "replace")

    @property
    def sha256(self) -> str:
        """Of the bytes, in hexadecimal digits."""
        return sha256(self.data).hexdigest()

    @property
    def marks(self) -> tuple[str, ...]:
        """Names of the parts."""
        return tuple(part.mark or f"part {k}" for k, part in enumerate(self.parts, 1))


def program_scene(
    program: ReadProgram, unit: Unit = "mm", done: "Simulated | None" = None
) -> Scene:
    """What a program makes; `done` is its own run, where it is known already.

    Raises VerifyError for a program that cannot be understood.
    """
    if program.machine.stock == "profile":
        from beamcam.pictures.coper import coper_scene

        return coper_scene(coper_program(program), unit)
    if program.machine.stock == "beam":
        from beamcam.pictures.bar import bar_scene

        return bar_scene(bar_made(program), unit)
    from beamcam.pictures.table import table_scene

    return table_scene(table_made(program, done), unit)


def coper_program(program: ReadProgram) -> "CoperProgram":
    """A coper's program as its picture takes it."""
    from beamcam.pictures.coper import CoperProgram

    return CoperProgram(program.text, program.machine, program.name, program.sha256, program.parts)


def table_made(program: ReadProgram, done: "Simulated | None" = None) -> "TableMade":
    """The path of a table's program; `done` is its own run, where it is known already.

    Raises VerifyError for a program that cannot be understood.
    """
    from beamcam.pictures.table import TableMade
    from beamcam.simulation.program import simulate_program

    if done is None:
        done = simulate_program(
            program.data, program.machine, program.name, program.style, program.parts
        )
    return TableMade(done.trace, program.machine, program.name, program.sha256, done.kerf_offset)


def bar_made(program: ReadProgram) -> "BarMade":
    """What a program for bars makes. Raises VerifyError for one that cannot be understood."""
    from beamcam.checks.bars import run, section_stated
    from beamcam.controllers.dialect import ARC, SYNTAX, WORD
    from beamcam.pictures.bar_made import BarMade

    machine = program.machine
    profile = program.parts[0].profile if program.parts else None
    done = run(program.text, machine, profile, program.name)
    not_understood = {r.code for r in (SYNTAX, WORD, ARC)}
    if any(d.code in not_understood for d in errors_in(done.diagnostics)):
        raise VerifyError(done.diagnostics)
    return BarMade(
        done.made, profile or section_stated(done.events, done.dialect, machine), machine,
        program.name, program.sha256, program.bar, program.marks,
    )  # fmt: skip
