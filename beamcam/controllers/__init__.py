"""Controllers: what the text of a program means, event by event.

    text -> blocks (lexer) -> events (modal interpreter)        dialect: the machine's own words

Written from the controllers' documentation and the machine file, apart from the emitters, so that
a fault of theirs cannot hide in it. A family of controllers is a lexer, an interpreter and a row of
`INTERPRETERS`; all speak the one vocabulary of `events`.
"""

from collections.abc import Callable

from beamcam.controllers import codesys
from beamcam.controllers.blocks import Block, read_blocks
from beamcam.controllers.dialect import Dialect
from beamcam.controllers.events import BarEvent
from beamcam.errors import Diagnostic
from beamcam.machine.machine import Machine, NumberFormat

#: Interpreter of each controller family that moves bars.
INTERPRETERS: dict[
    str, Callable[[list[Block], str, NumberFormat], tuple[list[BarEvent], list[Diagnostic]]]
] = {
    "codesys": codesys.run,
}


def events_of(
    text: str, machine: Machine, dialect: Dialect, name: str = "program"
) -> tuple[list[BarEvent], list[Diagnostic]]:
    """What a program does, event by event, and what is wrong with its blocks."""
    blocks, said = read_blocks(text, name, dialect.letters)
    events, more = INTERPRETERS[machine.controller](blocks, name, machine.format)
    return events, said + more
