"""How long a sheet takes: along the contours, between them, and to pierce."""

from math import dist

from beamcam.machine.machine import Machine
from beamcam.model.lengths import total_length
from beamcam.model.plan import SheetPlan

SECONDS_PER_MINUTE = 60.0


def sheet_time_s(plan: SheetPlan, machine: Machine) -> float:
    """Seconds of work at full speed, without what corners and ramps take.

    Raises TypeError for a machine without a torch.
    """
    if machine.torch is None:
        raise TypeError(f"{machine.name} has no torch")
    minutes = pierced = 0.0
    here = (0.0, 0.0)
    for op in plan.operations:
        for one in op.passes:
            curves = (*one.lead_in, *one.curves, *one.lead_out)
            minutes += dist(here, curves[0].start) / machine.torch.traverse_mm_min
            minutes += total_length(curves) / op.row.feed_mm_min
            pierced += op.row.pierce_s
            here = curves[-1].end
    minutes += dist(here, (0.0, 0.0)) / machine.torch.traverse_mm_min
    return minutes * SECONDS_PER_MINUTE + pierced
