"""The picture of any program, from what the interpreter of its machine finds in it."""

from typing import TYPE_CHECKING

from beamcam.errors import VerifyError, errors_in
from beamcam.pictures import ReadProgram
from beamcam.pictures.scene import Scene, Unit

if TYPE_CHECKING:
    from beamcam.pictures.bar_made import BarMade
    from beamcam.pictures.table import TableMade
    from beamcam.simulation.program import Simulated


def program_scene(program: ReadProgram, unit: Unit = "mm") -> Scene:
    """What a program makes.

    Raises VerifyError for a program that cannot be understood.
    """
    if program.machine.stock == "profile":
        from beamcam.pictures.coper import coper_scene

        return coper_scene(program, unit)
    if program.machine.stock == "beam":
        from beamcam.pictures.bar import bar_scene

        return bar_scene(bar_made(program), unit)
    from beamcam.pictures.table import table_scene

    return table_scene(table_made(program), unit)


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
