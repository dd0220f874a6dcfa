"""Paths of points compared with the contours of a sheet: of tables that no G-code runs."""

from collections.abc import Collection, Sequence
from typing import TYPE_CHECKING

from msgspec import Struct
from msgspec.structs import replace

from beamcam.errors import Diagnostic
from beamcam.machine.machine import Machine
from beamcam.machine.torch import Torch, TorchProcess, TorchRow
from beamcam.model.part import Part

if TYPE_CHECKING:
    from beamcam.checks.sheets.strokes import Strokes
    from beamcam.geometry.array_types import Floats

#: Tolerances between two places of a path whose corners are not known, where two count as meeting.
SPACING = 2.5

Points = Sequence[tuple[float, float]]


class DrawnPath(Struct, frozen=True):
    """What the head draws between tool on and tool off."""

    process: TorchProcess
    points: Points
    feeds_mm_min: tuple[float, ...]  #: the speeds of a sheet that it may be of
    passes: int = 1  #: how often, one after the other


def compare_polylines(
    drawn: Sequence[DrawnPath], part: Part, machine: Machine, skips: Collection[str], slack: float,
    name: str, is_simplified: bool = False,
) -> list[Diagnostic]:  # fmt: skip
    """All differences of paths from the part.

    `slack` is what the controller may miss each point by, beside the machine's tolerance. Points
    are simplified where those that lay nearly straight between two others are left out.
    """
    from beamcam.checks.sheets.asked_sheet import rows_on
    from beamcam.checks.sheets.compare import compare_part
    from beamcam.checks.sheets.need import need_of

    torch = machine.needed(machine.torch, "torch")
    loose = replace(torch, tolerance=torch.tolerance + slack)
    strokes = _strokes(drawn, rows_on(part, torch), loose if is_simplified else None)
    need = need_of(part, machine, torch, skips)
    return compare_part(strokes, need, part, machine, loose, name, True)


def _strokes(
    drawn: Sequence[DrawnPath], rows: Sequence[TorchRow], simplified_by: Torch | None
) -> "Strokes":
    """Paths that move, as strokes, each with the rows that it may be of."""
    import numpy as np

    from beamcam.checks.sheets.strokes import HeadStroke, Strokes
    from beamcam.controllers.moves import straight_moves

    paths: Sequence[Floats] = [
        np.array(way.points, dtype=np.float64).reshape(-1, 2) for way in drawn
    ]
    if simplified_by is not None:
        paths = _with_places(paths, simplified_by)
    row_of = {row.process: row for row in reversed(rows)}
    each: list[HeadStroke] = []
    chains = []
    count = 0
    for number, (way, places) in enumerate(zip(drawn, paths, strict=True), 1):
        moved = np.any(places[1:] != places[:-1], axis=1)
        if moved.any():
            chains.append((number, places[:-1][moved], places[1:][moved]))
            last = count + int(moved.sum())
            feeds = way.feeds_mm_min
            row, *others = [replace(row_of[way.process], feed_mm_min=feed) for feed in feeds]
            alike = tuple(others)
            each.append(
                HeadStroke(number, row, "on", 0.0, count, last, passes=way.passes, alike=alike)
            )
            count = last
    return Strokes(each, straight_moves(chains))


def _with_places(paths: "Sequence[Floats]", torch: Torch) -> "Sequence[Floats]":
    """Paths that lost points between which they lie straight, with places at both of their ends.

    Where such a path leaves its lead or comes back to its start it has no corner, and the
    comparison expects that where one way ends and the next begins.
    """
    import numpy as np

    own = [layer.overcut for layer in torch.settings.values() if layer.overcut is not None]
    over = max([torch.overcut, *own])
    leads = 0.0 if torch.lead == "none" else max(torch.lead_in, torch.lead_out)
    if not over + leads:
        return paths
    most, spacing = over + leads + 8 * torch.tolerance, SPACING * torch.tolerance
    denser: list[Floats] = []
    for path in paths:
        reached = np.concatenate(([0.0], np.cumsum(np.hypot(*np.diff(path, axis=0).T))))
        total = float(reached[-1])
        at = np.arange(spacing, min(most, total / 2), spacing)
        every = np.unique(np.concatenate((reached, at, total - at)))
        denser.append(np.column_stack([np.interp(every, reached, path[:, k]) for k in (0, 1)]))
    return denser
