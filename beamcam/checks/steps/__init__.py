"""Tables for stepping motors read back: steps one by one, or the velocities of segments.

Written from docs/step-tables.md and the machine file; nothing is shared with motion or emitters.

    .steps .bin .h  -> rows -> motors followed (follow, pace) -> strokes
    .csv            -> segments, each by itself (velocities) -> strokes -> compared (outline)

All goes block by block, so that a table of any length takes the memory of its drawing.
"""

from collections.abc import Callable, Collection, Iterable, Iterator, Sequence
from math import sqrt
from typing import Any

from beamcam.checks.steps.follow import Followed
from beamcam.checks.steps.outline import OutlineCheck
from beamcam.checks.steps.velocities import ROUND, Velocities, table_rows
from beamcam.controllers.step_table import (
    Rows,
    Stream,
    binary_rows,
    header_rows,
    text_rows,
)
from beamcam.errors import Diagnostic, VerifyError, errors_in
from beamcam.machine.machine import Machine
from beamcam.machine.tables import Stepper
from beamcam.model.part import Part

__all__ = ["FORMS", "verify_table"]

#: Steps that a path of single steps may be simplified by before it is compared as a whole.
SIMPLIFY = 0.75

_STEPS: dict[str, Callable[[Stream, Stepper], Iterator[Rows]]] = {
    ".steps": text_rows, ".bin": binary_rows, ".h": header_rows,
}  # fmt: skip
VELOCITIES = ".csv"
FORMS = (*_STEPS, VELOCITIES)


def verify_table(
    form: str, pieces: Iterable[bytes], parts: Sequence[Part], machine: Machine,
    skips: Collection[str] = (), name: str = "program", head: str = "",
) -> tuple[Diagnostic, ...]:  # fmt: skip
    """All faults of a table, by itself and against its part.

    `form` is the suffix of its file, one of `FORMS`; `pieces` are its bytes in any cut; `head` is
    the text whose head has to say where sound parts lie, if one has to. Without parts it is
    checked by itself. Raises ValueError for another form.
    """
    stepper = machine.needed(machine.stepper, "stepping motors")
    if form not in FORMS:
        raise ValueError(f"found a table of form {form!r}; expected one of {', '.join(FORMS)}")
    stream = Stream(pieces, name)
    part, sheet, whole_machine = None, None, machine
    if parts:
        from beamcam.checks.sheets.compare import with_head_faults
        from beamcam.checks.sheets.required_layout import as_one

        sheet = as_one(parts, machine, skips)
        part, machine = sheet.part, sheet.machine
    table: Any  # each takes rows of its own form
    rows: Iterator[Any]
    if form == VELOCITIES:
        outline = OutlineCheck(part, machine, skips, sqrt(2.0) * ROUND, 0.0, name)
        table, rows = Velocities(machine, name, outline), table_rows(stream, stepper.step)
    else:
        half, simplify = stepper.step * sqrt(0.5), stepper.step * SIMPLIFY
        outline = OutlineCheck(part, machine, skips, half, simplify, name)
        table, rows = Followed(machine, name, outline), _STEPS[form](stream, stepper)
    try:
        for row in rows:
            table.follow(row)
    except VerifyError as fault:  # what cannot be read ends a table
        return (*table.diagnostics, *fault.diagnostics)
    table.finish()
    if errors_in(table.diagnostics):
        return (*table.diagnostics, *outline.diagnostics)
    if sheet is None:
        return (*table.diagnostics, *outline.compare())
    diagnostics = (*table.diagnostics, *sheet.diagnostics, *outline.compare())
    return with_head_faults(diagnostics, head, parts, sheet.places, whole_machine, skips, name)
