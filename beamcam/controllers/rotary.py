"""The axis that turns a round tube, where programs give it in mm of the surface."""

from collections.abc import Iterable
from math import degrees

from msgspec.structs import replace

from beamcam.controllers.events import BarEvent, Move
from beamcam.machine.coper import Coper


def in_degrees(events: Iterable[BarEvent], coper: Coper, diameter: float) -> list[BarEvent]:
    """Events whose A is in degrees, of a machine on which it may count mm of the surface.

    There A is the arc u of the place on top, from the lowest line of the tube towards face v;
    turned by A degrees the place at 90 - A from that line is on top.
    """
    if coper.a_unit == "deg":
        return [*events]
    found: list[BarEvent] = []
    for event in events:
        if isinstance(event, Move):
            first, last = (90.0 - degrees(2 * a / diameter) for a in event.a_deg)
            event = replace(event, a_deg=(first, last))
        found.append(event)
    return found
