"""Paths of points compared with the contours of a sheet: of tables that no G-code runs."""

import itertools
from collections.abc import Collection, Sequence

from msgspec.structs import replace

from beamcam.errors import Diagnostic
from beamcam.machine.machine import Machine, TorchProcess
from beamcam.model.part import Part

FeatureRef = tuple[int, int]
Points = Sequence[tuple[float, float]]


def compare_polylines(
    ways: Sequence[tuple[TorchProcess, Points]],
    part: Part,
    machine: Machine,
    skipped: Collection[FeatureRef],
    slack: float,
    name: str,
) -> list[Diagnostic]:
    """Everything in which paths differ from what the part needs.

    `slack` is what the controller may miss each point by, beside the machine's tolerance.
    """
    from beamcam.verify.sheets.compare import compare
    from beamcam.verify.sheets.events import Leg
    from beamcam.verify.sheets.need import need_of, rows_of, shift_of
    from beamcam.verify.sheets.strokes import Stroke

    torch = machine.torch
    if torch is None:
        raise TypeError(f"{machine.name} has no torch")
    rows = {row.process: row for row in reversed(rows_of(part, torch))}
    need = need_of(part, torch, {feature for _, feature in skipped})
    strokes = []
    for number, (process, points) in enumerate(ways, 1):
        legs = [
            Leg(number, False, a, b, None, rows[process].feed_mm_min)
            for a, b in itertools.pairwise(points)
            if a != b
        ]
        if legs:
            strokes.append(Stroke(number, rows[process], "on", 0.0, legs))
    if not need.curves and not strokes:
        return need.said
    loose = replace(torch, tolerance=torch.tolerance + slack)
    return need.said + compare(strokes, need, machine, loose, shift_of(need, torch), name)
