"""What a program follows: every path runs along a contour, and its strokes close.

With r half the kerf that the program keeps off:

    every sample of a path   has a contour r beside it, but for the leads, which lie in waste
    every stroke             closes, or ends where a contour ends
"""

from collections.abc import Sequence

import numpy as np

from beamcam.errors import Diagnostic
from beamcam.verify.sheets.bridges import join_bridged
from beamcam.verify.sheets.elements import Counts, Floats
from beamcam.verify.sheets.ends import end_faults
from beamcam.verify.sheets.leads import Bounds, lead_faults, rings
from beamcam.verify.sheets.work import MITRE, SHOWN, SPACING, Flags, Traced, Work


def follow(work: Work) -> tuple[list[Traced], Counts, list[Diagnostic]]:
    """The strokes without their leads, the leader of each, and what follows no contour.

    The leader is the first of the strokes that go round one contour with bridges between them.
    """
    element, share, way = work.path.samples(SPACING)
    points = work.path.elements.places(element, share)
    stroke = work.of_way[way]
    most = work.tolerance + float(work.free.max(initial=0.0))
    reach = max(MITRE * work.most_half_kerf() + most, 2 * most)
    away, who, at = work.need.nearest_of(work.need.near(points, reach), len(points))
    radii = _half_kerfs(work, away, stroke)
    mine = radii[stroke]
    slack = work.tolerance + work.free[who]
    good = np.abs(away - mine) <= slack
    corner = ~good & (mine > 0.0) & (away > mine) & (away <= MITRE * mine + slack)
    if corner.any():
        good |= corner & ((at <= slack) | (work.need.lengths[who] - at <= slack))
    bad = np.zeros(work.path.count, dtype=bool)
    bad[way[~good]] = True
    ends = np.cumsum(np.bincount(work.of_way, minlength=len(work.strokes))).tolist()
    bounds = list(zip([0, *ends[:-1]], ends, strict=True))
    kept = rings(work, bounds, bad)
    said = lead_faults(work, bounds, kept, radii)
    traced = _traced(work, kept, radii)
    leader = join_bridged(work, bounds, traced)
    wrong = np.flatnonzero(~good & on_contour(work, traced)[way])
    _, firsts = np.unique(stroke[wrong], return_index=True)
    for k in wrong[firsts][:SHOWN].tolist():
        off, nearest = work.need.nearest_to(points[k])
        expected = f"{mine[k]:g} mm within {work.tolerance + work.free[nearest]:.4f}"
        said.append(work.extra(int(work.moves.line[way[k]]), points[k], f"{off:.4f}", expected))
    return traced, leader, said + end_faults(work, traced)


def on_contour(work: Work, traced: Sequence[Traced]) -> Flags:
    """The ways of the path that are no leads."""
    found = np.zeros(work.path.count, dtype=bool)
    for t in traced:
        found[t.first : t.last] = True
    return found


def _half_kerfs(work: Work, away: Floats, stroke: Counts) -> Floats:
    """What each stroke keeps off its contours: half the kerf, or nothing."""
    kerfs = np.array([s.row.kerf / 2 if work.offset else 0.0 for s in work.strokes])
    if not kerfs.any():
        return kerfs
    order = np.lexsort((away, stroke))
    counts = np.bincount(stroke, minlength=len(work.strokes))
    middle = away[order][np.cumsum(counts) - counts + counts // 2]
    return np.where(np.abs(middle) < np.abs(middle - kerfs), 0.0, kerfs)


def _traced(work: Work, kept: Bounds, radii: Floats) -> list[Traced]:
    rows = np.array(kept, dtype=np.int64).reshape(-1, 2)
    starts, ends = work.path.starts[rows[:, 0]], work.path.ends[rows[:, 1] - 1]
    closed = np.hypot(*(ends - starts).T) <= 2 * work.tolerance
    sizes = np.array([s.last - s.first for s in work.strokes], dtype=np.int64)
    middles = work.moves.end[np.cumsum(sizes) - sizes + sizes // 2]
    boxes = _boxes(work, rows).tolist()
    columns = (work.strokes, kept, radii.tolist(), closed.tolist(), middles.tolist(), boxes)
    return [
        Traced(
            stroke, first, last, half_kerf, is_closed, (x, y), work.path, work.fine,
            [(first, last)] if is_closed else [], box, stroke.line,
        )
        for stroke, (first, last), half_kerf, is_closed, (x, y), box in zip(*columns, strict=True)
    ]  # fmt: skip


def _boxes(work: Work, kept: Counts) -> Floats:
    """The box around the ways of each stroke: least x and y, greatest x and y, (n, 4)."""
    low, high = work.path.boxes
    # Every other stretch is that between two strokes.
    bounds = np.minimum(kept.ravel(), work.path.count - 1)
    lasts = kept[:, 1] - 1
    least = np.minimum(np.minimum.reduceat(low, bounds)[::2], low[lasts])
    greatest = np.maximum(np.maximum.reduceat(high, bounds)[::2], high[lasts])
    return np.concatenate((least, greatest), axis=1)
