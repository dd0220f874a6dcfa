"""Leads: the ways of a stroke from where it pierces to the contour, and off it again."""

from collections.abc import Sequence

import numpy as np

from beamcam.errors import Diagnostic, Source
from beamcam.verify.sheets import rules
from beamcam.verify.sheets.elements import Floats
from beamcam.verify.sheets.ways import Ways
from beamcam.verify.sheets.work import Flags, Work

SPACING = 0.2
#: Share of half the kerf that a lead keeps off the part; its last tenth comes to the contour.
KEPT_OFF = 0.85

Bounds = Sequence[tuple[int, int]]


def rings(work: Work, bounds: Bounds, bad: Flags) -> list[tuple[int, int]]:
    """The ways of each stroke along its contour; `bad` are those that follow none."""
    if work.process != "cut" or work.torch.lead == "none":
        return list(bounds)
    shape = _Shape(work)
    wrong = bad.tolist()
    return [shape.ring(first, last, wrong) for first, last in bounds]


class _Shape:
    """The ways of a path as plain numbers, which are quicker to look at one by one."""

    def __init__(self, work: Work) -> None:
        self._starts = work.path.starts.tolist()
        self._ends = work.path.ends.tolist()
        self._lengths = work.path.lengths.tolist()
        self._most_in = work.most(work.torch.lead_in)
        self._most_out = work.most(work.torch.lead_out)
        self._near = (2 * work.step) ** 2

    def _meets(self, low: int, high: int) -> bool:
        """Whether the way before `high` ends where way `low` starts."""
        (x0, y0), (x1, y1) = self._starts[low], self._ends[high - 1]
        dx, dy = x1 - x0, y1 - y0
        return bool(dx * dx + dy * dy <= self._near)

    def ring(self, first: int, last: int, bad: Sequence[bool]) -> tuple[int, int]:
        """The ways that are no leads: those that close, with the longest leads that may be.

        Where nothing closes, what lies off the contours is taken for the leads.
        """
        begin, end = first, last
        size = self._lengths[first]
        while begin < last - 1 and size <= self._most_in:
            begin += 1
            size += self._lengths[begin]
        size = self._lengths[last - 1]
        while end > first + 1 and size <= self._most_out:
            end -= 1
            size += self._lengths[end - 1]
        for low in range(begin, first - 1, -1):
            for high in range(end, last + 1):
                if low < high and self._meets(low, high):
                    return low, high
        while begin > first and not bad[begin - 1]:
            begin -= 1
        while end < last and not bad[end]:
            end += 1
        return (begin, end) if begin < end else (first, last)


def lead_faults(work: Work, bounds: Bounds, kept: Bounds, radii: Floats) -> list[Diagnostic]:
    """The leads that do not keep off the part, their last tenth before the contour aside."""
    reach = KEPT_OFF * float(radii.max(initial=0.0)) - work.tolerance
    leads = [
        (low, high, stroke)
        for stroke, ((first, last), (begin, end)) in enumerate(zip(bounds, kept, strict=True))
        for low, high in ((first, begin), (end, last))
        if low < high
    ]
    if reach <= 0.0 or not leads:
        return []
    rows = np.concatenate([np.arange(low, high) for low, high, _ in leads])
    lead_of = np.repeat(np.arange(len(leads)), [high - low for low, high, _ in leads])
    ways = Ways.of_moves(work.moves.take(rows), work.fine)
    element, share, way = ways.samples(SPACING)
    points = ways.elements.places(element, share)
    away, _, _ = work.need.nearest_of(work.need.near(points, reach), len(points))
    half = radii[[stroke for _, _, stroke in leads]][lead_of[way]]
    bites = np.flatnonzero(away < KEPT_OFF * half - work.tolerance)
    _, firsts = np.unique(lead_of[way[bites]], return_index=True)
    said = []
    for k in bites[firsts].tolist():
        low, high, stroke = leads[lead_of[way[k]]]
        x, y = points[k].tolist()
        length = float(work.path.lengths[low:high].sum())
        said.append(
            rules.LEAD.at(
                Source(work.name, int(work.moves.line[rows[way[k]]])),
                found=f"{length:.3f}", x=f"{x:.3f}", y=f"{y:.3f}",
                expected=f"it at least {radii[stroke]:g} mm off the part",
            )
        )  # fmt: skip
    return said
