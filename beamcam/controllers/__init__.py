"""Controllers: what the text of a program means, event by event.

    text -> blocks (each family's lexer) -> modal interpreter -> events
    dialect: the axes, numbers and words of a machine, as its file defines them

Written from the controllers' documentation and the machine file, apart from the emitters, so that
a fault of theirs cannot hide in it. A family of controllers is a package with a lexer and an
`Interpreter`, and a row of `interpreter_of`; all speak the one vocabulary of `events`, so that
cells and tables may be run by any of them.
"""

from typing import TYPE_CHECKING

from beamcam.controllers.dialect import dialect_of
from beamcam.controllers.events import BarEvent, TableEvent
from beamcam.controllers.interpreter import Interpreter
from beamcam.errors import Diagnostic
from beamcam.machine.machine import Machine

if TYPE_CHECKING:
    from beamcam.controllers.moves import TableRun


def interpreter_of(machine: Machine, name: str) -> Interpreter:
    """The interpreter of a machine's controller, at the beginning of a program."""
    dialect = dialect_of(machine)
    if machine.controller == "codesys":
        from beamcam.controllers.codesys.interpreter import Codesys

        return Codesys(dialect, name)
    from beamcam.controllers.rs274.interpreter import Rs274
    from beamcam.controllers.rs274.variants import VARIANTS

    return Rs274(VARIANTS[machine.controller], dialect, name)


def longest_line(machine: Machine) -> int | None:
    """The characters that a line may have for a machine's controller; None: no limit is known."""
    if machine.controller not in ("linuxcnc", "grbl", "mach3"):
        return None
    from beamcam.controllers.rs274.variants import VARIANTS

    return VARIANTS[machine.controller].longest_line


def cell_events(
    text: str, machine: Machine, name: str = "program"
) -> tuple[list[BarEvent], list[Diagnostic]]:
    """The events of a program, block by block, and the faults of its blocks.

    So are the short programs of bars read, and what is tried of a machine's words; `table_run`
    gives the same of a table's program in arrays.
    """
    events: list[BarEvent] = []
    interpreter = interpreter_of(machine, name)
    interpreter.record(events.append, events.append)
    lines = interpreter.lines_of(text.rstrip())
    interpreter.begin(len(lines))
    interpreter.lines(lines)
    interpreter.finish()
    return events, interpreter.diagnostics


def table_run(
    text: str, machine: Machine, name: str = "program"
) -> "tuple[TableRun, list[Diagnostic]]":
    """The events of a program for a table, its moves as arrays, and the faults of its blocks."""
    from beamcam.controllers import track

    return track.table_run(text, interpreter_of(machine, name))


def table_events(
    text: str, machine: Machine, name: str = "program"
) -> tuple[list[TableEvent], list[Diagnostic]]:
    """The events of a program for a table, and the faults of its blocks."""
    done, diagnostics = table_run(text, machine, name)
    return done.events(), diagnostics
