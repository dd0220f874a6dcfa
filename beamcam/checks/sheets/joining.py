"""Which loose curves of a sheet make closed contours together.

Said once for planner and checker in docs/drawings.md, "What is joined", and written here apart from
the planner:

1. A feature whose curves follow one another and end where they begin is a contour as it is drawn.
2. Of all other curves, two ends that lie within `WRITTEN_SAME` of one another and of no third one
   meet. All ends that are left meet if they are within the gap, also by way of others; but such as
   meet one another over more than twice the gap only within `WRITTEN_SAME`.
3. Where two ends meet, one curve goes on into the other. Where more meet, what leads back to that
   place is a contour of its own, and what leads to nowhere is a branch. Without these, two that are
   left go on into one another; and so on, until nothing changes. What is left is open.
"""

from collections.abc import Sequence

import numpy as np
import shapely
from shapely import STRtree
from shapely.ops import substring

from beamcam.checks.sheets.toolpaths import Chain, DrawnWays, Toolpaths
from beamcam.geometry.array_types import Counts, Flags, Floats
from beamcam.geometry.arrays import first_equal
from beamcam.geometry.plane import groups_of

# --- overlaps -------------------------------------------------------------------------------------

# Curves that lie on others in part: there they are drawn twice, and count once.


def trim(
    drawn: DrawnWays, toolpaths: Toolpaths, loose: Sequence[int], rank: Counts, same: float
) -> None:
    """Trim the ends of loose lines and arcs where they lie on a way of lower rank.

    W overlaps V where both are of one line or circle, an end of W lies on V and an end of V on W.
    Neither is cut where a third loose way ends at one of these two: there it may go on along W.
    """
    numbers = np.array(loose, dtype=np.int64)
    places = np.concatenate((toolpaths.starts[numbers], toolpaths.ends[numbers]))
    pairs = toolpaths.by_way(toolpaths.near(places, same))
    own = np.tile(numbers, 2)[pairs.point]
    other = toolpaths.owner[pairs.element]
    at_end = np.minimum(
        np.hypot(*(toolpaths.starts[other] - places[pairs.point]).T),
        np.hypot(*(toolpaths.ends[other] - places[pairs.point]).T),
    )
    which = np.flatnonzero((rank[other] < rank[own]) & (at_end > same))
    if not len(which):
        return
    which = which[_collinear(toolpaths, own[which], other[which], same)]
    ends = STRtree(shapely.points(places))

    def is_lost(place: Floats, w: int, v: int) -> bool:
        """Whether a third way, of another line or circle, ends at a place."""
        near = numbers[ends.query(shapely.Point(place), "dwithin", distance=same) % len(numbers)]
        third = near[(near != w) & (near != v)]
        return not _collinear(toolpaths, third, np.full(len(third), w), same).all()

    spans: dict[int, list[float]] = {}
    for k in which.tolist():
        w, v, place = int(own[k]), int(other[k]), places[pairs.point[k]]
        at_start = bool(pairs.point[k] < len(numbers))
        for end in (toolpaths.starts[v], toolpaths.ends[v]):
            # How far along w an end of v lies, if w lies on v from its own end up to there.
            line, point = drawn.line(w), shapely.Point(end)
            at = line.project(point)
            if line.distance(point) > same or not same < at < line.length - same:
                continue
            middle = line.interpolate(at / 2 if at_start else (at + line.length) / 2)
            lies_on = drawn.line(v).distance(middle) <= same
            if lies_on and not is_lost(end, w, v) and not is_lost(place, w, v):
                spans.setdefault(w, [0.0, line.length])[0 if at_start else 1] = at
    for w, (low, high) in spans.items():
        if low < high:
            points, begins = np.array(substring(drawn.line(w), low, high).coords), drawn.begins
            drawn.points = np.concatenate(
                (drawn.points[: begins[w]], points, drawn.points[begins[w + 1] :])
            )
            drawn.begins = begins.copy()
            drawn.begins[w + 1 :] += len(points) - (begins[w + 1] - begins[w])
            drawn.starts[w], drawn.ends[w] = points[0], points[-1]


def _collinear(toolpaths: Toolpaths, some: Counts, others: Counts, same: float) -> Flags:
    """Which of some ways lie on the line or the circle of another one each, but for `same`."""
    kinds, elements = toolpaths.kinds, toolpaths.elements
    alike = (kinds[some] == kinds[others]) & (kinds[some] < 2)
    first, second = toolpaths.first[some], toolpaths.first[others]
    arcs, on = elements.arcs[first], elements.arcs[second]
    off = np.hypot(*(arcs[:, :2] - on[:, :2]).T) + np.abs(arcs[:, 2] - on[:, 2])
    along = np.column_stack([column[second] for column in elements.along])
    for ends in (toolpaths.starts, toolpaths.ends):
        away = ends[some] - toolpaths.starts[others]
        aside = np.abs(along[:, 0] * away[:, 1] - along[:, 1] * away[:, 0])
        off = np.where(kinds[some] == 0, np.maximum(off, aside), off)
    is_same: Flags = alike & (off <= same)
    return is_same


# --- rings ----------------------------------------------------------------------------------------

WRITTEN_SAME = 1e-3  #: ends that are written as one point: coordinates of three decimals
WIDEST_PLACE = 2.0  #: gaps that ends which meet may meet one another over
SLACK = 1 + 1e-6  #: of the gap, for the last digits of ends that are as far apart


def rings_of(toolpaths: DrawnWays, which: Sequence[int], gap: float) -> list[Chain]:
    """The closed contours that some loose ways make together."""
    numbers = np.array(which, dtype=np.int64)
    if len(numbers):
        low, high = (
            f.reduceat(toolpaths.points, toolpaths.begins[:-1]) for f in (np.minimum, np.maximum)
        )
        numbers = numbers[np.hypot(*(high - low)[numbers].T) > min(gap, WRITTEN_SAME)]
    if not len(numbers):
        return []
    # A number for the place of each end.
    ends = np.concatenate((toolpaths.starts[numbers], toolpaths.ends[numbers]))
    written = _hanging(ends, min(gap, WRITTEN_SAME))
    left = np.flatnonzero(np.bincount(written)[written] != 2)
    places = written + len(ends)
    near = left[_hanging(ends[left], gap * SLACK)]
    low, high = np.full((len(ends), 2), np.inf), np.full((len(ends), 2), -np.inf)
    np.minimum.at(low, near, ends[left])
    np.maximum.at(high, near, ends[left])
    is_place = np.hypot(*(high - low)[near].T) <= WIDEST_PLACE * gap * SLACK
    places[left[is_place]] = near[is_place]
    net = _Net(places.reshape(2, -1).T.tolist())
    return [[(int(numbers[k]), turned) for k, turned in ring] for ring in net.rings()]


def _hanging(points: Floats, reach: float) -> Counts:
    """For each point the number of the first that it hangs together with.

    Those are no farther apart than `reach`, or have others between them that are not.
    """
    first = first_equal(points)
    once = np.unique(first)
    places = shapely.points(points[once])
    pairs = shapely.STRtree(places).query(places, "dwithin", distance=reach)
    lowest = np.arange(len(points))
    for group in groups_of(once[pairs[:, pairs[0] < pairs[1]]].T.tolist()):
        lowest[group] = min(group)
    return lowest[first]


#: A run of ways: one of them, or two runs and whether each is turned round.
_Run = int | tuple["_Run", bool, "_Run", bool]


class _Net:
    """Runs of ways between places, drawn together until only places where many meet are left."""

    def __init__(self, ends: Sequence[Sequence[int]]) -> None:
        self._ends = [tuple(pair) for pair in ends]
        self._runs: list[_Run] = list(range(len(ends)))
        self._at: dict[int, set[int]] = {}
        for k, pair in enumerate(ends):
            for place in pair:
                self._at.setdefault(place, set()).add(k)

    def rings(self) -> list[Chain]:
        """What leads back to where it began, each as its ways one after the other."""
        rings: list[Chain] = []
        nodes = list(self._at)
        while nodes:
            place = nodes.pop()
            own = self._at[place]
            for k in sorted(own):
                if self._ends[k] == (place, place):
                    own.discard(k)
                    rings.append(_ways_of(self._runs[k]))
            if len(own) == 1:  # a run with a free end is taken away
                k = own.pop()
                nodes.append(self._other(k, place))
                self._at[nodes[-1]].discard(k)
            elif len(own) == 2:
                nodes += self._draw_together(place, *sorted(own))
        return rings

    def _other(self, k: int, place: int) -> int:
        a, b = self._ends[k]
        return b if a == place else a

    def _draw_together(self, place: int, a: int, b: int) -> tuple[int, ...]:
        """One run for the two that meet at a place; the places of its ends."""
        before, after = self._other(a, place), self._other(b, place)
        k = len(self._runs)
        self._runs.append(
            (self._runs[a], self._ends[a][1] != place, self._runs[b], self._ends[b][0] != place)
        )
        self._ends.append((before, after))
        self._at[place].clear()
        self._at[before].discard(a)
        self._at[after].discard(b)
        self._at[before].add(k)
        self._at[after].add(k)
        return before, after


def _ways_of(run: _Run) -> Chain:
    """The ways of a run, one after the other."""
    ways: Chain = []
    waiting: list[tuple[_Run, bool]] = [(run, False)]
    while waiting:
        part, turned = waiting.pop()
        if isinstance(part, int):
            ways.append((part, turned))
            continue
        first, first_turned, second, second_turned = part
        two = [(first, first_turned != turned), (second, second_turned != turned)]
        waiting += two if turned else two[::-1]
    return ways
