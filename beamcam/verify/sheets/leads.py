"""Lead-ins, lead-outs and overcuts of strokes."""

from collections.abc import Sequence

from beamcam.geometry.array_types import Flags
from beamcam.verify.sheets.work import Work

Bounds = Sequence[tuple[int, int]]

SHORTEST = 4.0  #: by how near ends have to be that meet, of a ring of stairs
LEAST = 16.0  #: squares of two steps that a ring of one curve is longer than


def rings(work: Work, bounds: Bounds, bad: Flags) -> list[tuple[int, int]]:
    """The ways of each stroke along its contour; `bad` are those that follow none."""
    if work.process != "cut" or (work.torch.lead == "none" and not work.most_over):
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
        self._begins = work.path.begins.tolist()
        #: Places of stairs are nearer to each other than their ends have to be.
        self._shortest = SHORTEST * work.meeting if work.stepped else 0.0
        self._most_in, self._most_out = work.most_in, work.most_out
        self._most_lead = work.most_lead
        self._near = work.meeting**2

    def _meets(self, low: int, high: int) -> bool:
        """Whether the way before `high` ends where way `low` starts, and went round something."""
        (x0, y0), (x1, y1) = self._starts[low], self._ends[high - 1]
        dx, dy = x1 - x0, y1 - y0
        if (
            dx * dx + dy * dy > self._near
            or self._begins[high - 1] + self._lengths[high - 1] - self._begins[low] < self._shortest
        ):
            return False
        return high - low > 1 or self._lengths[low] ** 2 > LEAST * self._near

    def _before(self, first: int, last: int, most: float) -> int:
        """The way behind which no more than `most` is left."""
        end, size = last, self._lengths[last - 1]
        while end > first + 1 and size <= most:
            end -= 1
            size += self._lengths[end - 1]
        return end

    def ring(self, first: int, last: int, bad: Sequence[bool]) -> tuple[int, int]:
        """The ways that are not leads: those that close, with the longest leads that may be.

        Where nothing closes, what lies off the contours is taken for the leads.
        """
        begin = first
        size = self._lengths[first]
        while begin < last - 1 and size <= self._most_in:
            begin += 1
            size += self._lengths[begin]
        end = self._before(first, last, self._most_out)
        for low in range(begin, first - 1, -1):
            for high in range(end, last + 1):
                if low < high and self._meets(low, high):
                    return low, high
        end = self._before(first, last, self._most_lead)
        while begin > first and not bad[begin - 1]:
            begin -= 1
        while end < last and not bad[end]:
            end += 1
        return (begin, end) if begin < end else (first, last)
