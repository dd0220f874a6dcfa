"""A saw and drilling line, of which a station that is not there is one that does nothing."""

from msgspec import Struct

from beamcam.machine.absent import drill_of, saw_of
from beamcam.machine.machine import Layout, Machine
from beamcam.machine.stations import Drill, Saw
from beamcam.planning.operations.tools import ToolLibrary, library_of


class BarLine(Struct, frozen=True):
    """The machine data used in planning a bar."""

    machine: Machine
    saw: Saw
    drill: Drill
    layout: Layout
    library: ToolLibrary


def line_of(machine: Machine) -> BarLine:
    """The line of a machine. Raises TypeError if it has no layout."""
    layout = machine.needed(machine.layout, "layout")
    return BarLine(machine, saw_of(machine), drill_of(machine), layout, library_of(machine))
