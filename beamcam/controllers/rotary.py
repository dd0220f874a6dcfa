"""What turns a tube below its torch, where programs do not give it as A in degrees and with Y."""

from collections.abc import Iterable
from math import degrees, isnan

from msgspec.structs import replace

from beamcam.controllers.events import BarEvent, Move
from beamcam.machine.coper import Coper


def in_degrees(events: Iterable[BarEvent], coper: Coper, diameter: float) -> list[BarEvent]:
    """Events whose A is in degrees, of a machine on which it may count mm of the surface.

    There A is the arc u of the place on top, from the lowest line of the tube towards face v;
    turned by A degrees the place at 90 - A from that line is on top. A torch without Y is over the
    axis, Y 0.
    """
    if coper.a_unit == "deg" and coper.y == "follows":
        return [*events]
    found: list[BarEvent] = []
    for event in events:
        if isinstance(event, Move) and coper.a_unit == "mm":
            first, last = (90.0 - degrees(2 * a / diameter) for a in event.a_deg)
            event = replace(event, a_deg=(first, last))
        if isinstance(event, Move) and coper.y == "fixed":
            (x0, y0, z0), (x1, y1, z1) = event.start, event.end
            y0, y1 = (0.0 if isnan(y) else y for y in (y0, y1))
            event = replace(event, start=(x0, y0, z0), end=(x1, y1, z1))
        found.append(event)
    return found
