"""Lead-ins, lead-outs and overcuts of strokes."""

from collections.abc import Sequence
from math import pi

import numpy as np
import shapely

from beamcam.errors import Diagnostic, Source
from beamcam.geometry.array_types import Flags, Floats
from beamcam.verify.sheets import rules
from beamcam.verify.sheets.work import SHOWN, Traced, Work

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
        self._most_lead, self._from_middle = work.most_lead, work.most_from_middle
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
        if begin == first < last - 1 and self._lengths[first] <= self._from_middle:
            begin += 1
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


# --- pierces --------------------------------------------------------------------------------------

# Where the torch pierces: as far from the part as the hole that it burns is wide, if it can.
#
# Asked of programs that keep the kerf off and lead in by themselves: a controller's own
# compensation has a rule of its own for its entry, and stairs of steps do not tell how a path
# begins. There is room where the machine's lead, in all its length, would keep half a kerf off
# every contour where the program joins this one, and its far end the radius of that hole.
#
#           S   line: square to the path          .-  arc: a quarter circle, tangent to it
#           |                                    S
#         --C--->  path                        --C--->


ALONG = 33  #: corners of the line that stands for a lead


def pierce_faults(work: Work, traced: Sequence[Traced]) -> list[Diagnostic]:
    """Strokes round a contour that pierce too near to one although there is room for a lead."""
    row = work.asked.rows.get(work.process)
    rings = [
        t
        for t in traced
        if t.half_kerf
        and t.ring
        and not t.joined
        and t.bridge_to is None
        and not t.stroke.is_linked
    ]
    if row is None or not rings or not row.pierce_radius:
        return []
    points, begins = work.need.outlines(work.fine)
    owner = np.repeat(np.arange(work.need.count), np.diff(begins))
    contours = shapely.STRtree(shapely.linestrings(points, indices=owner))
    firsts = [int(np.searchsorted(work.of_way, work.of_way[t.first])) for t in rings]
    pierced = work.path.starts[firsts]
    away, nearest = _distances(contours, pierced)
    said: list[Diagnostic] = []
    near = row.pierce_radius - work.slack[nearest] - 2 * work.fine
    for k in np.flatnonzero(away < near).tolist():
        lead = _whole_lead(work, rings[k], contours)
        # A planner keeps off by a hair less; where that decides, either may be right.
        kept = work.half_kerf - work.fine
        blocked = contours.query(shapely.LineString(lead), "dwithin", distance=kept)
        far = row.pierce_radius + work.tolerance
        if len(blocked) or _distances(contours, lead[-1:])[0][0] < far:
            continue
        x, y = pierced[k].tolist()
        said.append(
            rules.PIERCE.at(
                Source(work.name, rings[k].stroke.line), x=f"{x:.3f}", y=f"{y:.3f}",
                found=f"{away[k]:.3f}", contour=work.contour(int(nearest[k])),
                expected=f"{row.pierce_radius:g}", lead=f"{work.torch.lead_in:g}",
            )
        )  # fmt: skip
    return said[:SHOWN]


def edge_faults(work: Work, traced: Sequence[Traced]) -> list[Diagnostic]:
    """Open strokes beside a contour that begin on no path that was cut before.

    They are what is left of contours whose other edges are cut with those of another part.
    """
    said: list[Diagnostic] = []
    firsts = np.searchsorted(work.of_way, np.arange(len(work.strokes)))
    for t in traced:
        if not t.half_kerf or t.members or t.joined or t.closed:
            continue
        number = int(work.of_way[t.first])
        begin = work.path.starts[firsts[number]].reshape(1, 2)
        near = work.path.near(begin, 2 * work.tolerance)
        if (work.of_way[work.path.owner[near.element]] < number).any():
            continue
        x, y = begin[0].tolist()
        contour = work.contour_at(begin[0])
        source = Source(work.name, t.stroke.line)
        said.append(rules.EDGE.at(source, contour=contour, x=f"{x:.3f}", y=f"{y:.3f}"))
    return said[:SHOWN]


def _distances(contours: shapely.STRtree, points: Floats) -> tuple[Floats, Floats]:
    """How far each point is from the nearest contour, and which one that is."""
    places = shapely.points(points)
    nearest = contours.nearest(places)
    return shapely.distance(places, contours.geometries[nearest]), nearest


def _whole_lead(work: Work, t: Traced, contours: shapely.STRtree) -> Floats:
    """Places of the machine's lead from where a stroke joins its contour to its far end, (n, 2)."""
    at, (tx, ty) = work.path.starts[t.first], work.heading(t, at_end=False)
    place = shapely.Point(at)
    nearest = contours.geometries[contours.nearest(place)]
    foot = shapely.get_coordinates(shapely.shortest_line(place, nearest))[1]
    normal = np.array((-ty, tx))
    if np.dot(normal, at - foot) < 0.0:  # the waste is where the path keeps off to
        normal = -normal
    share = np.linspace(0.0, 1.0, ALONG)[:, None]
    length = work.torch.lead_in
    if work.torch.lead == "line":
        found: Floats = at + share * length * normal
        return found
    radius, turn = length / (pi / 2), share * pi / 2
    back = np.array((-tx, -ty))
    found = at + radius * ((1.0 - np.cos(turn)) * normal + np.sin(turn) * back)
    return found
