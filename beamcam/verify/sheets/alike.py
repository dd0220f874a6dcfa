"""Strokes that two processes make by the same words, distinguished by the curves they follow."""

from collections.abc import Callable, Mapping
from math import inf
from typing import TYPE_CHECKING

import numpy as np
from msgspec.structs import replace

from beamcam.geometry.array_types import Floats
from beamcam.machine.torch import Torch, TorchProcess, TorchRow
from beamcam.verify.sheets.need import Need
from beamcam.verify.sheets.strokes import HeadStroke, Strokes

if TYPE_CHECKING:
    from beamcam.verify.sheets.toolpaths import Toolpaths

PLACES = 9  #: of a stroke that are looked at

Away = Callable[[Floats], float]


def told_apart(strokes: Strokes, need: Need, torch: Torch, shift: tuple[float, float]) -> Strokes:
    """The strokes with the rows of what they follow, where word and feed leave several.

    What follows no contour, as a text does, is taken for a mark: its place is not known yet.
    """
    if not any(stroke.alike for stroke in strokes.each):
        return strokes
    fine = torch.tolerance / 8
    known: dict[TorchProcess, Away] = {
        process: _away(need.toolpaths(process, fine).moved(shift)) for process in need.curves
    }
    each = [_settled(s, strokes, known, torch) if s.alike else s for s in strokes.each]
    return Strokes(each, strokes.moves)


def _away(toolpaths: "Toolpaths") -> Away:
    """Median distance of points from the nearest curve."""

    def measured(places: Floats) -> float:
        return float(np.median([toolpaths.nearest_to(place)[0] for place in places]))

    return measured


def _settled(
    stroke: HeadStroke, strokes: Strokes, known: Mapping[TorchProcess, Away], torch: Torch
) -> HeadStroke:
    options: dict[TorchProcess, TorchRow] = {}
    for row in (stroke.row, *stroke.alike):
        options.setdefault(row.process, row)
    if len(options) == 1:
        return stroke
    span = slice(stroke.first, stroke.last)
    ends = strokes.moves.end[span]
    places = ends[:: max(1, len(ends) // PLACES)]
    away = {process: known[process](places) for process in options if process in known}
    nearest = min(away, key=lambda process: away[process], default=stroke.process)
    if away.get(nearest, inf) > stroke.row.kerf + 8 * torch.tolerance:
        nearest = next((process for process in options if process != "cut"), stroke.process)
    return replace(stroke, row=options[nearest])
