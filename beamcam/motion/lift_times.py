"""Times of a torch that the program moves up and down, each move from rest to rest by itself."""

from collections.abc import Iterable
from math import inf, isfinite

from beamcam.controllers.events import Lift, Pause, TableEvent, Touch
from beamcam.geometry.ramps import move_seconds
from beamcam.machine.machine import Machine

SECONDS_PER_MINUTE = 60.0


class LiftTimes:
    """The height of a torch while its program runs, and how long its moves take.

    It begins at the clearance. At a height that nothing says, and at the top of its axis, it counts
    as there too.
    """

    def __init__(self, machine: Machine) -> None:
        torch = machine.needed(machine.torch, "torch")
        self.height = self._clearance = torch.clearance
        self._rapid_mm_min = torch.traverse_mm_min
        self._axis = next((axis for axis in machine.axes if axis.moves == "Z"), None)

    def seconds(self, event: Lift | Touch) -> float:
        """How long a move takes; the torch is where it ends."""
        height = event.height if isinstance(event, Touch) else event.end
        height = height if isfinite(height) else self._clearance
        is_fed = not (isinstance(event, Lift) and event.rapid) and event.feed_mm_min > 0.0
        speed = (event.feed_mm_min if is_fed else self._rapid_mm_min) / SECONDS_PER_MINUTE
        way, self.height = abs(height - self.height), height
        if self._axis is None:
            return way / speed
        jerk = inf if self._axis.jerk is None else self._axis.jerk
        return move_seconds(way, min(speed, self._axis.speed), self._axis.acceleration, jerk)


def standing_seconds(events: Iterable[TableEvent], machine: Machine) -> float:
    """How long the head stands for some events: moves of the torch in Z, and pauses."""
    times = LiftTimes(machine)
    return sum(
        event.seconds if isinstance(event, Pause) else times.seconds(event)
        for event in events
        if isinstance(event, Pause | Lift | Touch)
    )
