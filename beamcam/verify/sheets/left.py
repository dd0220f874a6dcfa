"""Waste that stays on the part, where the beam comes no nearer."""

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from beamcam.errors import Diagnostic
from beamcam.verify.left_out import UNCUT
from beamcam.verify.sheets.work import Work

if TYPE_CHECKING:
    from beamcam.verify.sheets.corners import UncutCorner

#: By the kerf, deeper than which it is told what stays in a corner, as in one of 39 degrees.
TOLD = 1.0


def left_faults(work: Work, corners: "Sequence[UncutCorner]") -> list[Diagnostic]:
    """Of each contour the deepest of its corners, if it is deep enough to be told."""
    if work.region is None:
        return []
    ring_of = np.full(work.need.count, -1)
    firsts = [min(k for k, _ in ring) for ring in work.region.rings]
    for number, ring in enumerate(work.region.rings):
        ring_of[[k for k, _ in ring]] = number
    deepest: dict[int, UncutCorner] = {}
    for corner in sorted(corners, key=lambda one: one.depth):
        if corner.depth > TOLD * 2 * work.half_kerf:
            deepest[int(ring_of[corner.way])] = corner
    said = []
    for number, corner in sorted(deepest.items()):
        way = firsts[number] if number >= 0 else corner.way
        x, y = (np.array(corner.place) - np.array(work.shift)).tolist()
        source = work.asked.source(work.process, way)
        said.append(UNCUT.at(source, found=f"{corner.depth:.3f}", x=f"{x:.3f}", y=f"{y:.3f}"))
    return said
