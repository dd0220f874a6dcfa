"""What a program is read back by: its part and machine, and the rows of the cut chart for both."""

from collections.abc import Iterator
from itertools import pairwise

from msgspec import Struct
from msgspec.structs import replace

from beamcam.errors import Source
from beamcam.machine.coper import Coper
from beamcam.machine.machine import Machine
from beamcam.machine.torch import TorchRow, is_row_for, material_said
from beamcam.model.part import Part

SAME_FEED = 0.01  #: mm/min by which a program's feed may differ from that of its row
SAME = 1e-6  #: mm of thickness


class CoperJob(Struct, frozen=True):
    """A part, the machine that makes it, the rows of its chart for the steel, and a program."""

    part: Part
    machine: Machine
    coper: Coper
    rows: tuple[TorchRow, ...]
    name: str  #: of the program

    def at(self, line: int | None = None) -> Source:
        """A line of the program."""
        return Source(self.name, line)

    def row_for(self, thickness: float) -> TorchRow | None:
        """The row for so much steel, or at a feed between two; None for more than any cuts."""
        fits = [row for row in self.rows if row.up_to >= thickness - SAME]
        if not fits:
            return None
        row = min(fits, key=lambda one: one.up_to)
        for thin, thick in self._neighbours():
            if thick == row and thin.up_to < thickness < row.up_to - SAME:
                share = (thickness - thin.up_to) / (row.up_to - thin.up_to)
                feed = thin.feed_mm_min + share * (row.feed_mm_min - thin.feed_mm_min)
                return replace(row, feed_mm_min=feed, up_to=thickness)
        return row

    def row_at(self, feed: float) -> TorchRow | None:
        """The row of a feed, as deep as that cuts; None if it is of none."""
        for row in self.rows:
            if abs(row.feed_mm_min - feed) < SAME_FEED:
                return row
        for thin, thick in self._neighbours():
            if thick.feed_mm_min < feed < thin.feed_mm_min:
                share = (thin.feed_mm_min - feed) / (thin.feed_mm_min - thick.feed_mm_min)
                deep = thin.up_to + share * (thick.up_to - thin.up_to)
                return replace(thick, feed_mm_min=feed, up_to=deep)
        return None

    def _neighbours(self) -> Iterator[tuple[TorchRow, TorchRow]]:
        """Rows of one chart, each with the next one; none where feeds are not interpolated."""
        if self.coper.between_rows == "interpolate":
            alike = {(r.process, r.material, r.amps, r.nozzle) for r in self.rows}
            for key in alike:
                own = [r for r in self.rows if (r.process, r.material, r.amps, r.nozzle) == key]
                yield from pairwise(sorted(own, key=lambda r: r.up_to))


def job_of(part: Part, machine: Machine, name: str) -> CoperJob:
    """Raises TypeError for a machine without a coper."""
    coper = machine.needed(machine.coper, "coper")
    material = material_said(part.grade, coper.material)
    rows = tuple(row for row in coper.rows if is_row_for(row.material, material))
    return CoperJob(part, machine, coper, rows, name)
