"""The feed that each move should have: what the axes can follow, and less near corners.

It is that of the machine's row, or in programs that set the controller's accelerations the greatest
one that the axes can follow: on the smallest radius of the curve the acceleration across is v^2 / r
and the jerk v^3 / r^2.

Corners are looked for in the path as it is written. A place where it turns by nearly the angle of
the row, or beside moves so short that rounding turns them, may count as one or not; so may what is
as far from a corner as the row's distance.
"""

from collections.abc import Sequence
from math import degrees, inf

import numpy as np

from beamcam.controllers.moves import Moves
from beamcam.geometry.array_types import Flags, Floats
from beamcam.geometry.curves import EllipseArc
from beamcam.machine.machine import PathLimits
from beamcam.machine.torch import TorchRow

SECONDS_PER_MINUTE = 60.0
FLAT = 1e-12


def expected_feeds(moves: Moves, row_mm_min: Floats, limits: PathLimits) -> Floats:
    """The feed in mm/min that each move should have, at most what is asked for it, (n,)."""
    feeds = row_mm_min / SECONDS_PER_MINUTE
    radius = np.where(moves.is_arc, moves.arcs[:, 2], inf)
    for k, curve in moves.curves.items():
        if isinstance(curve, EllipseArc):
            radius[k] = curve.major * curve.ratio**2  # at the ends of its main axis
            continue
        # The curvature |f' x f''| / |f'|^3 of a parabola is greatest where f' = 2 (a + t b) is
        # shortest: at the vertex, or at the end that is nearer to it.
        (x0, y0), (x1, y1), (x2, y2) = curve.points
        ax, ay, bx, by = x1 - x0, y1 - y0, x2 - 2 * x1 + x0, y2 - 2 * y1 + y0
        if ax * by != ay * bx:
            vertex = -(ax * bx + ay * by) / (bx * bx + by * by)
            bend = abs(curve.curvature(min(max(vertex, 0.0), 1.0)))
            radius[k] = 1.0 / bend if bend > FLAT else inf
    turning = np.minimum(
        np.sqrt(limits.across_mm_s2 * radius), np.cbrt(limits.jerk_mm_s3 * radius**2)
    )
    straight = ~moves.is_arc
    straight[list(moves.curves)] = False
    # The maximum speed of both axes along each chord; inf where it has no length.
    ways = np.abs(moves.end - moves.start)
    speeds = np.hypot(*ways.T)[:, None] * np.array([limits.speed_x_mm_s, limits.speed_y_mm_s])
    along = np.divide(speeds, ways, out=np.full(ways.shape, inf), where=ways > 0.0)
    straight_mm_s = along.min(axis=1, initial=inf)
    greatest = np.where(straight, straight_mm_s, np.minimum(limits.speed_mm_s, turning))
    greatest[straight & (feeds <= limits.speed_mm_s)] = inf
    return np.where(greatest < feeds, greatest * SECONDS_PER_MINUTE, row_mm_min)


DOUBT_DEG = 1.0
LONG_MOVE = 0.1  #: mm: the direction of a shorter move is in doubt
EDGE_MM = 0.05  #: mm by which the stretch that is near a corner may be longer or shorter


def near_corners(moves: Moves, row: TorchRow, step: float) -> tuple[Flags, Flags]:
    """Whether each move of one stroke has to be slow, by a corner, and whether it must not be.

    With neither it may be both; `step` is that of the program's numbers, in mm.
    """
    lengths, enters, leaves = _measures(moves)
    real = np.flatnonzero(lengths > 0.0)
    behind = np.cumsum(lengths)
    sure: list[float] = []
    maybe: list[float] = []
    for a, b in zip(real[:-1].tolist(), real[1:].tolist(), strict=True):
        turn = turn_deg(leaves[a], enters[b])
        short = min(lengths[a], lengths[b])
        doubt = DOUBT_DEG + 2 * degrees(2 * step / short)
        if turn > row.corner_angle - doubt:
            maybe.append(float(behind[a]))
        if turn > row.corner_angle + doubt and short >= LONG_MOVE:
            sure.append(float(behind[a]))
    long = real[lengths[real] >= LONG_MOVE]
    for a, b in zip(long[:-1].tolist(), long[1:].tolist(), strict=True):
        if b > a + 1 and turn_deg(leaves[a], enters[b]) > row.corner_angle - 2 * DOUBT_DEG:
            maybe += behind[a:b].tolist()  # round a corner in moves that are too short
    reach = row.corner_distance
    begins = behind - lengths
    inside = _covered(begins, behind, sure, reach - EDGE_MM)
    outside = lengths - _covered(begins, behind, maybe, reach + EDGE_MM)
    return inside > EDGE_MM / 100, outside > EDGE_MM / 100


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
        for angles, angle in ((enters, first), (leaves, first + sweep)):
            rad = np.radians(angle)
            angles[arcs] = np.sign(sweep)[:, None] * np.column_stack((-np.sin(rad), np.cos(rad)))
    for k, curve in moves.curves.items():
        lengths[k], enters[k], leaves[k] = curve.length, curve.tangent(0.0), curve.tangent(1.0)
    return lengths, enters, leaves


def turn_deg(one: Floats, other: Floats) -> float:
    """The angle between two directions."""
    return float(np.degrees(np.arccos(np.clip(np.dot(one, other), -1.0, 1.0))))


def _covered(begins: Floats, ends: Floats, corners: Sequence[float], reach: float) -> Floats:
    """How much of each move, from where it begins to where it ends, is so near to a corner."""
    covered = np.zeros(len(begins))
    last = -np.inf
    for place in sorted(corners):
        low, high = max(place - reach, last), place + reach
        covered += np.clip(np.minimum(ends, high) - np.maximum(begins, low), 0.0, None)
        last = max(last, high)
    return covered
