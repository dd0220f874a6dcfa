"""Arcs of a program that its controller does not take."""

from collections.abc import Iterator

import numpy as np

from beamcam.controllers.moves import Moves
from beamcam.errors import Diagnostic, Source
from beamcam.machine.machine import Machine
from beamcam.machine.torch import Torch
from beamcam.verify.sheets.rules import RADIUS

EPSILON = 1e-6
ROUNDED_STEPS = 4  #: of the program's numbers, by which three rounded places change a radius


def radius_faults(moves: Moves, machine: Machine, torch: Torch, name: str) -> Iterator[Diagnostic]:
    """Arcs below the least radius of the machine or above its greatest.

    The radius is that from the start to the centre. An arc of just the greatest comes out larger
    by what both ends and the centre are rounded to.
    """
    radius, slack = moves.arcs[:, 2], ROUNDED_STEPS * machine.format.resolution
    odd = (radius < torch.min_radius - EPSILON) | (radius > torch.max_radius + slack)
    for k in np.flatnonzero(moves.is_arc & odd).tolist():
        x, y = moves.end[k].tolist()
        yield RADIUS.at(
            Source(name, int(moves.line[k])), found=f"{radius[k]:.6g}", x=f"{x:g}", y=f"{y:g}",
            least=f"{torch.min_radius:g}", greatest=f"{torch.max_radius:g}",
        )  # fmt: skip
