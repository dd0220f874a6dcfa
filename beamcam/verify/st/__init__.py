"""Trigger programs of either dialect verified: what their operations do, compared with the part.

text -> operations (controllers/simotion) -> strokes (execution) -> compared with the contours
"""

from collections.abc import Collection, Sequence

from msgspec.structs import replace

from beamcam.controllers.simotion import read_program
from beamcam.controllers.simotion.trial import trial
from beamcam.errors import Diagnostic, errors_in
from beamcam.machine.machine import Machine
from beamcam.model.part import Part
from beamcam.verify.polylines import DrawnPath
from beamcam.verify.st.execution import Execution, HeadStroke


def verify_triggers(
    text: str,
    parts: Sequence[Part],
    machine: Machine,
    skips: Collection[str] = (),
    name: str = "program",
    head: str = "",
) -> tuple[Diagnostic, ...]:
    """All faults of a trigger program, by itself and against its part.

    `head` is the text whose head has to say where sound parts lie, if one has to. Nothing comes
    back for a program that makes exactly the part.
    """
    from beamcam.verify.sheets.need import rows_of, thickness_of

    torch = machine.needed(machine.torch, "trigger program")
    triggers = machine.needed(machine.triggers, "trigger program")
    job, said = read_program(text, machine, name)
    if job is None:
        if not parts:
            return tuple(said)
        from beamcam.verify.st.contour_names import unread, with_contours

        return tuple(with_contours(said, unread(text, said), parts[0], machine, skips))
    execution = Execution(job, machine, rows_of(parts[0], torch) if parts else torch.rows, name)
    if parts and triggers.z is not None:
        execution.lie_on(thickness_of(parts[0], torch))
    execution.follow()
    said = [*trial(machine), *execution.said]
    if not parts:
        return tuple(said)
    if errors_in(said):
        from beamcam.verify.st.contour_names import with_contours

        return tuple(with_contours(said, job.operations, parts[0], machine, skips))
    from beamcam.verify.polylines import compare_polylines
    from beamcam.verify.sheets.controller_state import as_one, with_told

    sheet = as_one(parts, machine, skips)
    ways = _ways(execution.strokes, any(row.passes > 1 for row in rows_of(sheet.part, torch)))
    more = compare_polylines(ways, sheet.part, sheet.machine, skips, triggers.in_position, name)
    return with_told((*said, *sheet.said, *more), head, parts, sheet.places, machine, skips, name)


def _ways(strokes: Sequence[HeadStroke], counts_passes: bool) -> list[DrawnPath]:
    """What the head draws; a stroke that repeats the one before it is another pass of that."""
    ways: list[DrawnPath] = []
    for k, stroke in enumerate(strokes):
        if counts_passes and k and stroke.repeats(strokes[k - 1]):
            ways[-1] = replace(ways[-1], passes=ways[-1].passes + 1)
        else:
            ways.append(DrawnPath(stroke.process, stroke.points, stroke.feeds_mm_min))
    return ways
