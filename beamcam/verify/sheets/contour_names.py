"""Messages about a block of a program, with the contour of the input that the block is beside."""

from collections.abc import Iterable

import numpy as np
from msgspec.structs import replace

from beamcam.controllers.moves import Moves
from beamcam.errors import Diagnostic
from beamcam.verify.sheets import rules
from beamcam.verify.sheets.need import Need

#: Rules that know a line of the program only.
NAMELESS = {
    rule.code
    for rule in (
        rules.FEED, rules.RAMP, rules.TOOL, rules.RAPID, rules.IDLE, rules.AREA,
        rules.COMPENSATION,
    )
}  # fmt: skip


def with_contours(
    said: Iterable[Diagnostic], moves: Moves, need: Need, shift: tuple[float, float], fine: float
) -> list[Diagnostic]:
    """The messages; to those of `NAMELESS` the nearest contour is added.

    The place of a block that does not move is the end of the next move.
    """
    found = list(said)
    asked = [
        (k, one.source.line)
        for k, one in enumerate(found)
        if one.code in NAMELESS and one.source.line is not None
    ]
    if not asked or not need.curves or not len(moves):
        return found
    toolpaths = {process: need.toolpaths(process, fine) for process in need.curves}
    lines = np.maximum.accumulate(moves.line)
    for k, line in asked:
        row = min(int(np.searchsorted(lines, line)), len(lines) - 1)
        place = moves.end[row] - np.array(shift)
        _, way, process = min((*toolpaths[p].nearest_to(place), p) for p in toolpaths)
        contour = f", beside the contour of {need.source(process, way)}"
        found[k] = replace(found[k], message=found[k].message + contour)
    return found
