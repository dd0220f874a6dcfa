"""Trigger programs of SIMOTION read back: their fixed part compared, the job in it followed.

Written from the controller's documentation and the machine file; nothing is shared with planning,
motion or the emitters.

    text -> fixed part, byte by byte (frame) -> operations (job) -> strokes (work) -> compared
    machine -> fixed part, checked and run with simulated axes, once (trial)
"""

from collections.abc import Collection, Sequence

from beamcam.errors import Diagnostic, errors_in
from beamcam.machine.machine import Machine
from beamcam.model.part import Part
from beamcam.verify.st.frame import Unreadable, job_of
from beamcam.verify.st.job import JobRead, read_job
from beamcam.verify.st.trial import trial
from beamcam.verify.st.work import Work

__all__ = ["read_program", "verify_triggers"]


def read_program(
    text: str, machine: Machine, name: str = "program"
) -> tuple[JobRead | None, list[Diagnostic]]:
    """The job of a program; None and what is wrong where it cannot be read."""
    try:
        return read_job(job_of(text, machine, name), machine, name), []
    except Unreadable as unreadable:
        return None, [unreadable.diagnostic]


def verify_triggers(
    text: str,
    parts: Sequence[Part],
    machine: Machine,
    skips: Collection[str] = (),
    name: str = "program",
) -> tuple[Diagnostic, ...]:
    """Everything that is wrong with a trigger program, by itself and against its part.

    Nothing comes back for a program that makes exactly the part.
    """
    from beamcam.verify.sheets.need import rows_of

    torch, triggers = machine.torch, machine.triggers
    if torch is None or triggers is None:
        raise TypeError(f"{machine.name} has no trigger program")
    job, said = read_program(text, machine, name)
    if job is None:
        return tuple(said)
    rows = rows_of(parts[0], torch) if parts else torch.rows
    work = Work(job, machine, rows, name)
    work.follow()
    said = [*trial(machine), *work.said]
    if errors_in(said) or not parts:
        return tuple(said)
    from beamcam.verify.polylines import compare_polylines

    (part,) = parts
    ways = [(stroke.process, stroke.points) for stroke in work.strokes]
    said += compare_polylines(ways, part, machine, skips, triggers.in_position, name)
    return tuple(said)
