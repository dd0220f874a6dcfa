"""Tables for stepping motors read back: steps one by one, or velocities stretch by stretch.

Written from docs/step-tables.md and the machine file; nothing is shared with motion or emitters.

    .steps .bin .h  -> rows -> motors followed (follow, pace) -> strokes
    .csv            -> stretches, each by itself (velocities) -> strokes -> compared (outline)

All goes block by block, so that a table of any length takes the memory of its drawing.
"""

from collections.abc import Callable, Collection, Iterable, Iterator, Sequence
from math import sqrt
from typing import Any

from beamcam.checks.steps.follow import Followed
from beamcam.checks.steps.outline import OutlineCheck
from beamcam.checks.steps.velocities import ROUND, Velocities, stretches
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
    looked at by itself. Raises ValueError for another form.
    """
    stepper = machine.needed(machine.stepper, "stepping motors")
    if form not in FORMS:
        raise ValueError(f"found a table of form {form!r}; expected one of {', '.join(FORMS)}")
    stream = Stream(pieces, name)
    part, sheet, asked = None, None, machine
    if parts:
        from beamcam.checks.sheets.compare import with_told
        from beamcam.checks.sheets.shared_sheet import as_one

        sheet = as_one(parts, machine, skips)
        part, machine = sheet.part, sheet.machine
    table: Followed | Velocities
    if form == VELOCITIES:
        outline = OutlineCheck(part, machine, skips, sqrt(2.0) * ROUND, 0.0, name)
        table = Velocities(machine, name, outline)
        fault = _read(table.follow, stretches(stream, stepper.step))
    else:
        half, simplify = stepper.step * sqrt(0.5), stepper.step * SIMPLIFY
        outline = OutlineCheck(part, machine, skips, half, simplify, name)
        table = Followed(machine, name, outline)
        fault = _read(table.follow, _STEPS[form](stream, stepper))
    if fault is not None:
        return (*table.diagnostics, fault)
    table.finish()
    if errors_in(table.diagnostics):
        return (*table.diagnostics, *outline.diagnostics)
    if sheet is None:
        return (*table.diagnostics, *outline.compare())
    diagnostics = (*table.diagnostics, *sheet.diagnostics, *outline.compare())
    return with_told(diagnostics, head, parts, sheet.places, asked, skips, name)


def _read(follow: Callable[[Any], None], rows: Iterator[Any]) -> Diagnostic | None:
    """Follow all rows; what cannot be read ends a table."""
    try:
        for row in rows:
            follow(row)
    except VerifyError as fault:
        return fault.diagnostics[0]
    return None
