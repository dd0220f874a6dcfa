"""Trigger programs of SIMOTION verified: what their operations do, compared with the part.

text -> operations (controllers/simotion) -> strokes (work) -> compared with the contours
"""

from collections.abc import Collection, Sequence

from msgspec.structs import replace

from beamcam.controllers.simotion import read_program
from beamcam.controllers.simotion.trial import trial
from beamcam.errors import Diagnostic, errors_in
from beamcam.machine.machine import Machine
from beamcam.model.part import Part
from beamcam.verify.st.work import Work


def verify_triggers(
    text: str,
    parts: Sequence[Part],
    machine: Machine,
    skips: Collection[str] = (),
    name: str = "program",
) -> tuple[Diagnostic, ...]:
    """All faults of a trigger program, by itself and against its part.

    Nothing comes back for a program that makes exactly the part.
    """
    from beamcam.verify.sheets.need import rows_of

    torch = machine.needed(machine.torch, "trigger program")
    triggers = machine.needed(machine.triggers, "trigger program")
    job, said = read_program(text, machine, name)
    if job is None:
        if not parts:
            return tuple(said)
        from beamcam.verify.st.contour_names import unread, with_contours

        return tuple(with_contours(said, unread(text, said), parts[0], machine, skips))
    work = Work(job, machine, rows_of(parts[0], torch) if parts else torch.rows, name)
    work.follow()
    said = [*trial(machine), *work.said]
    if not parts:
        return tuple(said)
    if errors_in(said):
        from beamcam.verify.st.contour_names import with_contours

        return tuple(with_contours(said, job.operations, parts[0], machine, skips))
    from beamcam.verify.polylines import Drawn, compare_polylines
    from beamcam.verify.sheets.shared import as_one

    part, machine, faults = as_one(parts, machine, skips)
    said += faults
    ways: list[Drawn] = []
    counts_passes = any(row.passes > 1 for row in rows_of(part, torch))
    for k, stroke in enumerate(work.strokes):
        if counts_passes and k and stroke.repeats(work.strokes[k - 1]):
            ways[-1] = replace(ways[-1], passes=ways[-1].passes + 1)
        else:
            ways.append(Drawn(stroke.process, stroke.points, stroke.feeds_mm_min))
    said += compare_polylines(ways, part, machine, skips, triggers.in_position, name)
    return tuple(said)
