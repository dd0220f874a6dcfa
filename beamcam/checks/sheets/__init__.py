"""Programs of cutting tables read back and compared with the sheet that they should make.

Written from the controllers' documentation and the machine file; nothing is shared with planning,
motion or the emitters.

    text -> events (controllers) -> strokes -> compared with the contours
"""

from collections.abc import Collection, Sequence

from msgspec.structs import replace

from beamcam.controllers import table_events, table_run
from beamcam.errors import Diagnostic, errors_in
from beamcam.machine.machine import Machine
from beamcam.model.part import Part


def verify_sheet(
    text: str, parts: Sequence[Part], machine: Machine, skips: Collection[str] = (),
    name: str = "program", head: str = "",
) -> tuple[Diagnostic, ...]:  # fmt: skip
    """All faults of a program, by itself and against the part of its sheet.

    `skips` are the kinds of features that may be missing, as `--allow-skips` names them; `head` is
    the text whose head has to say where sound parts lie, if one has to. Nothing comes back for a
    program that makes exactly the part. Raises TypeError for a machine without a torch.
    """
    from beamcam.checks.sheets.chart_rows import rows_of
    from beamcam.checks.sheets.compare import compare_part
    from beamcam.checks.sheets.compensation import radius_faults
    from beamcam.checks.sheets.controller_state import as_one, with_told
    from beamcam.checks.sheets.heights import switching_faults
    from beamcam.checks.sheets.need import need_of, shift_of
    from beamcam.checks.sheets.remainder import link_faults, passes_folded, unchained
    from beamcam.checks.sheets.strokes import is_far, strokes_of
    from beamcam.checks.sheets.work import told_apart, with_contours

    torch = machine.needed(machine.torch, "torch")
    done, diagnostics = table_run(text, machine, name)
    diagnostics = [*diagnostics, *radius_faults(done.moves, machine, torch, name)]
    if errors_in(diagnostics) or not parts:
        return tuple(diagnostics)
    sheet, asked = as_one(parts, machine, skips), machine
    part, machine = sheet.part, sheet.machine
    torch, diagnostics = machine.torch or torch, [*diagnostics, *sheet.diagnostics]
    rows = rows_of(part, torch)
    torch = torch.by(next((row for row in rows if row.process == "cut"), None))
    machine = machine if torch is machine.torch else replace(machine, torch=torch)
    # In laser mode a word by itself switches nothing; here it is looked at what it says.
    telling = replace(machine, torch=replace(torch, laser_mode=False))
    strokes, more = strokes_of(
        done, machine, torch, rows, lambda blocks: table_events(blocks, telling)[0], name
    )
    diagnostics += more
    diagnostics += switching_faults(done, strokes, machine, torch, name)
    if is_far(strokes.moves, torch):
        return tuple(diagnostics)
    strokes = passes_folded(strokes, rows)
    need = need_of(part, machine, torch, skips)
    shift = shift_of(need, torch)
    strokes = told_apart(strokes, need, torch, shift)
    strokes, links = unchained(strokes, torch, machine.format.resolution)
    diagnostics += link_faults(links, strokes, need, torch, shift, name)
    places = sheet.places or ([shift] if need.curves else [])
    diagnostics += compare_part(strokes, need, part, machine, torch, name)
    diagnostics = with_contours(diagnostics, done.moves, need, shift, torch.tolerance / 8)
    return with_told(diagnostics, head, parts, places, asked, skips, name)
