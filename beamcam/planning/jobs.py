"""The programs that make some parts: a job for each bar, or for each sheet."""

from collections.abc import Collection, Sequence

from beamcam.machine.machine import Machine
from beamcam.model.part import Part
from beamcam.planning.bar_jobs import BarJob, Quantity, bar_jobs


def jobs_of(
    parts: Sequence[Part],
    machine: Machine,
    quantity: Quantity,
    lengths: tuple[float, ...],
    skips: Collection[str],
) -> tuple[BarJob, ...]:
    """The jobs that make `parts`, each as often as `quantity` says, in the order given.

    `lengths` are those of the bars in stock, in mm. Raises PlanError for a part that fits on no
    bar.
    """
    if machine.torch is None:
        return bar_jobs(parts, machine, quantity, lengths)
    if len(parts) == 1 and quantity is None:
        return (BarJob(tuple(parts), ()),)
    from beamcam.planning.sheet_rows import sheet_jobs

    return sheet_jobs(parts, machine, quantity, skips)
