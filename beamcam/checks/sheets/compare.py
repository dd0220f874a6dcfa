r"""Paths travelled with the tool on, compared with the contours of the part.

    waste            *  pierce                  r  half the kerf
                     :  lead
    - - - - - - - - -o- - - - -     - - - -     path of the beam's middle, r off its contour; it
         |r            over         bridge      is on its curve if that is open or marked
    ______________________________________      contour
    part      \    /
               \  /  rest of waste: the beam does not come into the corner

region     closed contours, as `joining` has them, part the sheet into part and waste (`region`)
tracing    a stroke without its leads goes round one closed contour, by itself or with others and
           bridges between (`tracing`); all else is asked of that contour
areas      the beam takes nothing of the part, its leads neither; what it does not reach is a
           corner of the waste (`areas`)
paths      each path runs along a contour but for its leads, and each stretch of a contour has a
           path, and one only, but for bridges (`paths`)
tabs       the bridges are as many and as wide as asked, at places that hold the part (`tabs`)
overcut    a stroke goes on beyond its start as far as asked; open ones end where contours do
leads      the torch pierces where it does no harm, small holes in their middle
direction  a closed cut goes round as it is drawn, or with the material at the right side
order      no contour is cut after one around it, none marked after a cut (`order`)

A controller that keeps off the contour by itself changes nothing but the path (`compensation`).
"""

from collections.abc import Mapping, Sequence

import numpy as np

from beamcam.checks.sheets.areas import band_faults
from beamcam.checks.sheets.compensation import beam_of
from beamcam.checks.sheets.leads import (
    dark_faults,
    edge_faults,
    find_small,
    hole_faults,
    middle_faults,
    pierce_faults,
)
from beamcam.checks.sheets.marks import (
    add_texts,
    hatch_faults,
    one_way_faults,
    overscan_faults,
    spot_faults,
    without_spots,
)
from beamcam.checks.sheets.need import Need, shift_of
from beamcam.checks.sheets.order import (
    OrderPlace,
    direction_faults,
    order_faults,
    settings_faults,
    turn_faults,
)
from beamcam.checks.sheets.overcut import overcut_faults
from beamcam.checks.sheets.paths import cover, follow
from beamcam.checks.sheets.strokes import Strokes
from beamcam.checks.sheets.tabs import tab_faults
from beamcam.checks.sheets.tracing import Traced
from beamcam.checks.sheets.work import Work, work_of
from beamcam.errors import Diagnostic
from beamcam.machine.machine import Machine
from beamcam.machine.torch import Torch, TorchProcess
from beamcam.model.part import Part


def compare_part(
    strokes: Strokes, need: Need, part: Part, machine: Machine, torch: Torch, name: str,
    stepped: bool = False,
) -> list[Diagnostic]:  # fmt: skip
    """All differences of the strokes from a part with its texts, and what its need says itself."""
    if need.spots or any(stroke.process == "spot" for stroke in strokes.each):
        step = machine.format.resolution
        near = torch.tolerance + 2 * step
        need.diagnostics += spot_faults(strokes, need, shift_of(need, torch), near, name)
        strokes = without_spots(strokes)
    add_texts(need, part, machine, torch, strokes)
    if not need.curves and not strokes.each:
        return need.diagnostics
    shift = shift_of(need, torch)
    diagnostics: list[Diagnostic] = []
    traced: list[Traced] = []
    works: dict[TorchProcess, Work] = {}
    if torch.kerf_by == "machine":
        strokes, diagnostics = beam_of(strokes, name)
        if diagnostics:
            return need.diagnostics + diagnostics
    processes = dict.fromkeys([*need.curves, *(s.process for s in strokes.each)])
    for process in processes:
        work = work_of(
            process, strokes, need, machine.format.resolution, torch, shift, name, stepped
        )
        works[process] = work
        mine, more = _compared(work)
        diagnostics += [*more, *dark_faults(work, mine, bool(machine.words.close))]
        traced += mine
        if any(own.hatch_one_way for own in torch.settings.values()) and process in need.curves:
            diagnostics += one_way_faults(work)
        if torch.overscan and not stepped:
            diagnostics += overscan_faults(work)
    if torch.settings or any(row.passes > 1 for row in need.rows.values()):
        diagnostics += _settings(works, traced, name)
    if any(own.hatch for own in torch.settings.values()):
        diagnostics += hatch_faults(need, torch, name)
    diagnostics += order_faults(sorted(traced, key=lambda t: t.stroke.line), works, name)
    return need.diagnostics + diagnostics


def _settings(
    works: Mapping[TorchProcess, Work], traced: Sequence[Traced], name: str
) -> list[Diagnostic]:
    """Strokes whose settings or place in the order differ from their colour or layer."""
    diagnostics: list[Diagnostic] = []
    turns: list[OrderPlace] = []
    for process, work in works.items():
        faults, more = settings_faults(work, [t for t in traced if t.stroke.process == process])
        diagnostics += faults
        turns += more
    return diagnostics + turn_faults(turns, name)


def _compared(work: Work) -> tuple[Sequence[Traced], list[Diagnostic]]:
    """Missing, extra, repeated, open and wrong-side paths of one process."""
    if not work.need.count:
        line, place = work.strokes[0].line, work.moves.start[0]
        away, expected = "on no contour", f"nothing to {work.process}"
        return [], [work.extra(line, place, away, expected)]
    if not work.strokes:
        which = np.flatnonzero(~work.small)
        return [], [work.missing(k, work.need.starts[k]) for k in which[:1].tolist()]
    traced, diagnostics = follow(work)
    find_small(work, traced)
    diagnostics += cover(work, traced)
    diagnostics += overcut_faults(work, traced)
    diagnostics += direction_faults(work, traced)
    diagnostics += hole_faults(work, traced)
    if work.bridged:
        diagnostics += tab_faults(work, traced)
    if work.half_kerf:
        diagnostics += band_faults(work, traced)
    led = work.torch.lead != "none" and work.torch.kerf_by == "offset"
    if work.half_kerf and led and not work.stepped:
        diagnostics += pierce_faults(work, traced)
        diagnostics += middle_faults(work, traced)
        diagnostics += edge_faults(work, traced)
    return traced, diagnostics
