"""A saw and drilling line: a machine file of which saw, drill and layout are known to be there."""

from msgspec import Struct

from beamcam.machine.drill import Drill
from beamcam.machine.machine import Layout, Machine
from beamcam.machine.saw import Saw
from beamcam.planning.operations.tools import Rack, rack_of


class Line(Struct, frozen=True):
    """What planning a bar takes from its machine."""

    machine: Machine
    saw: Saw
    drill: Drill
    layout: Layout
    rack: Rack


def line_of(machine: Machine) -> Line:
    """The line of a machine. Raises TypeError if it has no saw, drill and layout."""
    saw, drill, layout = machine.saw, machine.drill, machine.layout
    if saw is None or drill is None or layout is None:
        raise TypeError(f"{machine.name} has no saw, drill and layout")
    return Line(machine, saw, drill, layout, rack_of(machine))
