"""Rows of a coper's cut chart, by the steel that they go through and by their speed."""

from collections.abc import Iterator, Sequence
from itertools import pairwise

from msgspec.structs import replace

from beamcam.machine.coper import Coper
from beamcam.machine.torch import TorchRow

SAME_FEED = 0.01  #: mm/min by which a program's feed may differ from that of its row
SAME = 1e-6  #: mm of thickness


def row_for(rows: Sequence[TorchRow], coper: Coper, thickness: float) -> TorchRow | None:
    """The row for so much steel, at a feed between two where the file says so; None for more than
    any cuts."""
    fits = [row for row in rows if row.up_to >= thickness - SAME]
    if not fits:
        return None
    row = min(fits, key=lambda one: one.up_to)
    for thin, thick in _neighbours(rows, coper):
        if thick == row and thin.up_to < thickness < row.up_to - SAME:
            share = (thickness - thin.up_to) / (row.up_to - thin.up_to)
            feed = thin.feed_mm_min + share * (row.feed_mm_min - thin.feed_mm_min)
            return replace(row, feed_mm_min=feed, up_to=thickness)
    return row


def row_at(rows: Sequence[TorchRow], coper: Coper, feed: float) -> TorchRow | None:
    """The row of a feed, as deep as that cuts; None if it is of none."""
    for row in rows:
        if abs(row.feed_mm_min - feed) < SAME_FEED:
            return row
    for thin, thick in _neighbours(rows, coper):
        if thick.feed_mm_min < feed < thin.feed_mm_min:
            share = (thin.feed_mm_min - feed) / (thin.feed_mm_min - thick.feed_mm_min)
            deep = thin.up_to + share * (thick.up_to - thin.up_to)
            return replace(thick, feed_mm_min=feed, up_to=deep)
    return None


def _neighbours(rows: Sequence[TorchRow], coper: Coper) -> Iterator[tuple[TorchRow, TorchRow]]:
    """Rows of one chart that differ in their thickness, each with the next one; none where each
    stands for all thinner steel."""
    if coper.between_rows == "interpolate":
        alike = {(r.process, r.material, r.amps, r.nozzle) for r in rows}
        for key in alike:
            own = [r for r in rows if (r.process, r.material, r.amps, r.nozzle) == key]
            yield from pairwise(sorted(own, key=lambda r: r.up_to))
