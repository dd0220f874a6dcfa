"""What of a path is near its corners, where the tool has to be slower.

Corners are looked for in the path as it is written. A place where it turns by nearly the angle of
the row, or beside moves so short that rounding turns them, may count as one or not; so may what is
as far from a corner as the row's distance.
"""

from collections.abc import Sequence
from math import degrees

import numpy as np
from msgspec import Struct

from beamcam.controllers.moves import Moves
from beamcam.geometry.array_types import Flags, Floats
from beamcam.machine.torch import TorchRow

DOUBT_DEG = 1.0
LONG = 0.1  #: mm: the direction of a shorter move is in doubt
EDGE = 0.05  #: mm by which the stretch that is near a corner may be longer or shorter


class NearCorners(Struct, frozen=True):
    """Of each move, whether it has to be slow, and whether it must not be; neither: either way."""

    slow: Flags
    fast: Flags


def near_corners(moves: Moves, row: TorchRow, step: float) -> NearCorners:
    """What of the moves of one stroke is near a corner; `step` is that of its numbers, in mm."""
    lengths, enters, leaves = _measures(moves)
    real = np.flatnonzero(lengths > 0.0)
    behind = np.cumsum(lengths)
    sure: list[float] = []
    maybe: list[float] = []
    for a, b in zip(real[:-1].tolist(), real[1:].tolist(), strict=True):
        turn = _turn_deg(leaves[a], enters[b])
        short = min(lengths[a], lengths[b])
        doubt = DOUBT_DEG + 2 * degrees(2 * step / short)
        if turn > row.corner_angle - doubt:
            maybe.append(float(behind[a]))
        if turn > row.corner_angle + doubt and short >= LONG:
            sure.append(float(behind[a]))
    long = real[lengths[real] >= LONG]
    for a, b in zip(long[:-1].tolist(), long[1:].tolist(), strict=True):
        if b > a + 1 and _turn_deg(leaves[a], enters[b]) > row.corner_angle - 2 * DOUBT_DEG:
            maybe += behind[a:b].tolist()  # round a corner in moves that are too short
    reach = row.corner_distance
    begins = behind - lengths
    inside = _covered(begins, behind, sure, reach - EDGE)
    outside = lengths - _covered(begins, behind, maybe, reach + EDGE)
    return NearCorners(inside > EDGE / 100, outside > EDGE / 100)


def _measures(moves: Moves) -> tuple[Floats, Floats, Floats]:
    """The length of each move, and its directions where it begins and where it ends."""
    way = moves.end - moves.start
    lengths = np.hypot(way[:, 0], way[:, 1])
    size = np.where(lengths > 0.0, lengths, 1.0)[:, None]
    enters, leaves = way / size, way / size
    arcs = np.flatnonzero(moves.is_arc)
    if len(arcs):
        radius, first, sweep = moves.arcs[arcs, 2:5].T
        lengths[arcs] = radius * np.abs(np.radians(sweep))
        for found, angle in ((enters, first), (leaves, first + sweep)):
            rad = np.radians(angle)
            found[arcs] = np.sign(sweep)[:, None] * np.column_stack((-np.sin(rad), np.cos(rad)))
    for k, curve in moves.curves.items():
        lengths[k], enters[k], leaves[k] = curve.length, curve.tangent(0.0), curve.tangent(1.0)
    return lengths, enters, leaves


def _turn_deg(one: Floats, other: Floats) -> float:
    return float(np.degrees(np.arccos(np.clip(np.dot(one, other), -1.0, 1.0))))


def _covered(begins: Floats, ends: Floats, corners: Sequence[float], reach: float) -> Floats:
    """How much of each move, from where it begins to where it ends, is so near to a corner."""
    found = np.zeros(len(begins))
    last = -np.inf
    for place in sorted(corners):
        low, high = max(place - reach, last), place + reach
        found += np.clip(np.minimum(ends, high) - np.maximum(begins, low), 0.0, None)
        last = max(last, high)
    return found
