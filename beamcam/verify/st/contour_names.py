"""Messages about an operation, with the contour of the input that the operation is beside."""

import re
from collections.abc import Collection, Sequence

import numpy as np
from msgspec.structs import replace

from beamcam.controllers.simotion.job import Operation
from beamcam.errors import Diagnostic
from beamcam.machine.machine import Machine
from beamcam.model.part import Part

#: Where the head goes, as the operations of a chain say it.
_GOES_TO = re.compile(r"x := LREAL#(-?[\d.]+), y := LREAL#(-?[\d.]+)")
BLOCK = 10  #: lines of a program in which the operation is that a line belongs to


def unread(text: str, said: Sequence[Diagnostic]) -> list[Operation]:
    """For messages about lines that cannot be read the operation there, or the one before it."""
    lines = text.splitlines()
    found = []
    for line in {one.source.line for one in said if one.source.line}:
        near = [lines[line - 1 : line + 1], lines[max(line - BLOCK, 0) : line][::-1]]
        places = (_GOES_TO.search(row) for rows in near for row in rows)
        if (place := next(filter(None, places), None)) is not None:
            found.append(Operation(line, 0, float(place[1]), float(place[2]), 0.0, None))
    return found


def with_contours(
    said: Sequence[Diagnostic],
    operations: Sequence[Operation],
    part: Part,
    machine: Machine,
    skips: Collection[str],
) -> list[Diagnostic]:
    """The messages; to those about an operation the contour nearest to its end is added."""
    from beamcam.verify.sheets.need import need_of, shift_of
    from beamcam.verify.sheets.toolpaths import Toolpaths

    torch = machine.torch
    ends = {operation.line: (operation.x, operation.y) for operation in operations}
    found = list(said)
    asked = [k for k, one in enumerate(found) if one.source.line in ends]
    if torch is None or not asked:
        return found
    need = need_of(part, machine, torch, skips)
    shift, fine = shift_of(need, torch), torch.tolerance / 8
    toolpaths = {process: Toolpaths(curves, fine, shift) for process, curves in need.curves.items()}
    for k in asked if toolpaths else ():
        place = np.array(ends[found[k].source.line or 0])
        _, way, process = min((*toolpaths[p].nearest_to(place), p) for p in toolpaths)
        contour = f", beside the contour of {need.source(process, way)}"
        found[k] = replace(found[k], message=found[k].message + contour)
    return found
