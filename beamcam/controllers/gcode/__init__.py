"""What the G-code of a cutting table means, event by event.

    text -> plain moves as arrays, other blocks one by one (scan) -> events and moves

`rs274` is the interpreter for LinuxCNC and grbl, `codesys` that for CODESYS SoftMotion CNC; what
they have in common stands in `controller`.
"""

from typing import TYPE_CHECKING

from beamcam.errors import Diagnostic
from beamcam.machine.machine import Machine

if TYPE_CHECKING:
    from beamcam.controllers.events import TableEvent
    from beamcam.controllers.gcode.moves import Run


def events_of(
    text: str, machine: Machine, name: str = "program"
) -> "tuple[list[TableEvent], list[Diagnostic]]":
    """What a program does, event by event, and what is wrong with its blocks."""
    done, said = run(text, machine, name)
    return done.events(), said


def run(text: str, machine: Machine, name: str = "program") -> "tuple[Run, list[Diagnostic]]":
    """What a program does, its moves as arrays, and what is wrong with its blocks."""
    if machine.controller == "codesys":
        from beamcam.controllers.gcode import codesys

        per_minute = 60.0 if machine.format.feed_unit == "mm/s" else 1.0
        return codesys.run(text, name, machine.format.resolution, per_minute)
    from beamcam.controllers.gcode import rs274
    from beamcam.controllers.gcode.grbl import GRBL
    from beamcam.controllers.gcode.linuxcnc import LINUXCNC

    dialect = {"linuxcnc": LINUXCNC, "grbl": GRBL}[machine.controller]
    return rs274.run(text, name, dialect)
