"""Messages about an operation, with the contour of the input that the operation is beside."""

from collections.abc import Collection, Sequence

import numpy as np
from msgspec.structs import replace

from beamcam.controllers.simotion.job import Operation
from beamcam.errors import Diagnostic
from beamcam.machine.machine import Machine
from beamcam.model.part import Part


def with_contours(
    said: Sequence[Diagnostic],
    operations: Sequence[Operation],
    part: Part,
    machine: Machine,
    skips: Collection[str],
) -> list[Diagnostic]:
    """The messages; to those about an operation the contour nearest to its end is added."""
    from beamcam.verify.sheets.need import need_of, shift_of
    from beamcam.verify.sheets.ways import Ways

    torch = machine.torch
    ends = {operation.line: (operation.x, operation.y) for operation in operations}
    found = list(said)
    asked = [k for k, one in enumerate(found) if one.source.line in ends]
    if torch is None or not asked:
        return found
    need = need_of(part, machine, torch, skips)
    shift, fine = shift_of(need, torch), torch.tolerance / 8
    ways = {process: Ways(curves, fine, shift) for process, curves in need.curves.items()}
    for k in asked if ways else ():
        place = np.array(ends[found[k].source.line or 0])
        _, way, process = min((*ways[p].nearest_to(place), p) for p in ways)
        contour = f", beside the contour of {need.source(process, way)}"
        found[k] = replace(found[k], message=found[k].message + contour)
    return found
