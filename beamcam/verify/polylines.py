"""Paths of points compared with the contours of a sheet: of tables that no G-code runs."""

from collections.abc import Collection, Sequence

from msgspec.structs import replace

from beamcam.errors import Diagnostic
from beamcam.machine.machine import Machine
from beamcam.machine.torch import TorchProcess
from beamcam.model.part import Part

Points = Sequence[tuple[float, float]]


def compare_polylines(
    ways: Sequence[tuple[TorchProcess, Points]],
    part: Part,
    machine: Machine,
    skips: Collection[str],
    slack: float,
    name: str,
) -> list[Diagnostic]:
    """All differences of paths from the part.

    `slack` is what the controller may miss each point by, beside the machine's tolerance.
    """
    import numpy as np

    from beamcam.controllers.moves import straight_moves
    from beamcam.verify.sheets.compare import compare
    from beamcam.verify.sheets.need import need_of, rows_on, shift_of
    from beamcam.verify.sheets.strokes import Stroke, Strokes
    from beamcam.verify.sheets.texts import add_texts

    torch = machine.needed(machine.torch, "torch")
    rows = {row.process: row for row in reversed(rows_on(part, torch))}
    need = need_of(part, machine, torch, skips)
    strokes: list[Stroke] = []
    chains = []
    count = 0
    for number, (process, points) in enumerate(ways, 1):
        places = np.array(points, dtype=np.float64).reshape(-1, 2)
        moved = np.any(places[1:] != places[:-1], axis=1)
        if moved.any():
            chains.append((number, places[:-1][moved], places[1:][moved]))
            last = count + int(moved.sum())
            strokes.append(Stroke(number, rows[process], "on", 0.0, count, last))
            count = last
    done = Strokes(strokes, straight_moves(chains))
    loose = replace(torch, tolerance=torch.tolerance + slack)
    add_texts(need, part, machine, loose, done)
    if not need.curves and not strokes:
        return need.said
    return need.said + compare(done, need, machine, loose, shift_of(need, torch), name, True)
