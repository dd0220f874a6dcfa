"""The moves along many curves at once, where no last digit decides what they are.

`sheet.Pen` and `arcs.arc_feeds` say what is written for a curve; here the same sums are made in
arrays. Those of numpy may differ from those of `math` in their last digits. So a move is sure only
if nothing that is rounded lies near the middle of two steps and nothing that is compared lies near
its limit; then both give the same move, and whatever is not sure is left to them.
"""

from collections.abc import Iterator, Sequence

import numpy as np

from beamcam.geometry.array_types import Flags, Floats
from beamcam.geometry.arrays import CurveTable, unit_vectors
from beamcam.geometry.curves import Arc, Curve, Line
from beamcam.model.program import ArcFeed, Feed
from beamcam.motion.arcs import BISECTOR_SHARE, KEEP_SWEEP_DEG, MAX_SWEEP_DEG, Numbers

SureMoves = Sequence[Feed | ArcFeed | None]

#: What the sums may be off, as a share of the greatest number in them.
SUM_ERROR = 1e-14
#: A number as near to the middle of two steps, in steps, may be rounded either way.
DOUBT = 1e-5
#: What is compared shall keep off its limit by this share of it.
SURE = 1e-6


def sure_moves(chains: Sequence[Sequence[Curve]], numbers: Numbers) -> Iterator[SureMoves]:
    """For each chain, none of them empty, the moves along its curves; None where one is not sure.

    A curve is followed from where the one before it was written to end. None stands as well for a
    curve that needs no move, for a flat arc that may become a line, and for a free curve.
    """
    table = CurveTable([curve for chain in chains for curve in chain])
    lines, arcs = table.where(Line), table.where(Arc)
    if not table.curves:
        return
    lasts = np.cumsum([len(chain) for chain in chains])
    size = np.abs(table.ends).max(axis=1, initial=0.0)
    size[arcs] = np.abs(table.arcs[:, :3]).sum(axis=1)
    written, sure = _rounded(table.ends, size, numbers.decimals)
    follows = np.ones(len(table.curves), dtype=bool)
    follows[[0, *lasts[:-1].tolist()]] = False
    after = np.flatnonzero(follows)
    written[after, :2], sure[after, :2] = written[after - 1, 2:], sure[after - 1, 2:]
    start, end = written[:, :2], written[:, 2:]
    moving = sure.all(axis=1) & (start != end).any(axis=1)
    moves: list[Feed | ArcFeed | None] = [None] * len(table.curves)
    lines = lines[moving[lines]]
    for k, feed in zip(lines.tolist(), map(Feed, *end[lines].T.tolist()), strict=True):
        moves[k] = feed
    found, offset = _sure_arcs(table.arcs, start[arcs], end[arcs], moving[arcs], numbers)
    arcs, clockwise = arcs[found], table.arcs[found, 4] < 0
    columns = (*end[arcs].T.tolist(), *offset[found].T.tolist(), clockwise.tolist())
    for k, arc in zip(arcs.tolist(), map(ArcFeed, *columns), strict=True):
        moves[k] = arc
    for chain, last in zip(chains, lasts.tolist(), strict=True):
        yield moves[last - len(chain) : last]


def _rounded(values: Floats, size: Floats, decimals: int) -> tuple[Floats, Flags]:
    """Rows of numbers (n, m) as they are written, never -0, and which of them are sure.

    `size` (n,) is the greatest number in the sums that each row comes from.
    """
    scaled = values * 10.0**decimals
    whole = np.rint(scaled)
    error = SUM_ERROR * size[:, None] * 10.0**decimals
    sure: Flags = np.abs(scaled - whole) < 0.5 - DOUBT - error
    return whole / 10.0**decimals + 0.0, sure


def _sure_arcs(
    arcs: Floats, start: Floats, end: Floats, asked: Flags, numbers: Numbers
) -> tuple[Flags, Floats]:
    """Which of the arcs `asked` are surely written as such between their ends, and the way (n, 2)
    from the start of each to its centre."""
    radius, sweep = arcs[:, 2], np.abs(arcs[:, 4])
    sagitta = radius * (1 - np.cos(np.radians(sweep) / 2))
    sure = asked & (sweep <= MAX_SWEEP_DEG)
    sure &= (numbers.min_radius <= radius) & (radius <= numbers.max_radius)
    sure &= sagitta > numbers.step / 2 * (1 + SURE)
    chord = np.hypot(*(end - start).T)
    half = np.where(sure, chord / 2, 0.0)
    keeps_radius = sweep < KEEP_SWEEP_DEG
    sure &= ~keeps_radius | (half < radius * (1 - SURE))
    square = np.where(keeps_radius & sure, radius * radius - half * half, 0.0)
    height = np.where(
        keeps_radius, np.sqrt(square), half / np.tan(np.radians(np.maximum(sweep, 1.0)) / 2)
    )
    side = np.where(arcs[:, 4] > 0, 1.0, -1.0)
    along = (end - start) / np.where(chord > 0.0, chord, 1.0)[:, None]
    across = (side * height)[:, None] * np.column_stack((-along[:, 1], along[:, 0]))
    offset, sure_numbers = _rounded((end - start) / 2 + across, radius, numbers.decimals)
    sure &= sure_numbers.all(axis=1)
    sure &= _is_same_arc(arcs, start, end, along, offset, numbers)
    return sure, offset


def _is_same_arc(
    arcs: Floats, start: Floats, end: Floats, along: Floats, offset: Floats, numbers: Numbers
) -> Flags:
    """Which arcs a controller surely takes for what they are, by the rules of `arcs`."""
    centre = start + offset
    near, far = np.hypot(*offset.T), np.hypot(*(end - centre).T)
    same: Flags = np.abs(near - far) < numbers.arc_limit * (1 - SURE)
    same &= near > numbers.min_radius * (1 + SURE)
    beside = np.abs(np.sum((centre - (start + end) / 2) * along, axis=1))
    same &= beside < BISECTOR_SHARE * near * (1 - SURE)
    side = np.where(arcs[:, 4] > 0, 1.0, -1.0)
    first, last = (np.arctan2(p[:, 1], p[:, 0]) for p in (start - centre, end - centre))
    half_rad = first + side * (side * (last - first) % (2 * np.pi)) / 2
    middle = centre + near[:, None] * np.column_stack((np.cos(half_rad), np.sin(half_rad)))
    drawn = arcs[:, :2] + arcs[:, 2:3] * unit_vectors(arcs[:, 3] + 0.5 * arcs[:, 4])
    same &= np.hypot(*(middle - drawn).T) < 3 * numbers.step * (1 - SURE)
    return same
