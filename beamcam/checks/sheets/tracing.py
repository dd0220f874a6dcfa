"""Strokes without their leads, and which closed contour each goes round, by itself or with others.

    pierce   lead-in      ring          overcut   lead-out
      o - - - - - - ===================== = = = - - - - -     ways `first` to `last` are the ring

A ring ends where it began, with the longest leads that may be; of a stroke that ends nowhere so,
what follows no contour is lead. Several strokes go round a contour together if there is a bridge
between each and the next.
"""

from collections.abc import Sequence

import numpy as np
import shapely
from msgspec import Struct, field

from beamcam.checks.sheets.strokes import HeadStroke
from beamcam.checks.sheets.work import MITRE, Work
from beamcam.geometry.array_types import Counts, Flags, Floats

Bounds = Sequence[tuple[int, int]]
Near = tuple[Floats, Counts]  #: how far the nearest way is, and which one that is

SHORTEST = 4.0  #: by how near ends have to be that meet, of a ring of stairs
LEAST = 16.0  #: squares of two steps that a ring of one curve is longer than
WIDEST = 1.5  #: of a bridge that is told to be too wide, by the width of one
BETWEEN = np.array([0.25, 0.5, 0.75])  #: shares of a bridge where it is asked whether it is cut
MOST_ALONG = 1.75  #: of the contour in a bridge, by the distance of its ends


class Traced(Struct):
    """A stroke whose leads are known, and what it goes round."""

    stroke: HeadStroke
    begin: int  #: the first of its ways, leads among them
    first: int  #: of those along the contour
    last: int  #: behind the last of those
    end: int  #: behind the last of its ways
    half_kerf: float  #: that the path keeps off the contour
    closed: bool
    contour: int = -1  #: closed contour that it runs along, by its number; -1 of none
    over: float = 0.0  #: mm of its ways that are not part of the ring, and run along a contour
    before: float = 0.0  #: of `over`, what lies before the ring
    beyond: float = 0.0  #: mm behind the ring that do not run along it
    bridge_to: tuple[float, float] | None = None  #: start of the stroke behind a bridge at its end
    members: list["Traced"] = field(default_factory=list)  #: strokes of its contour, it first
    joined: bool = False  #: whether it goes round a contour together with others
    small: bool | None = False  #: whether it goes round a small hole; None: as good as either


def trace(
    work: Work, bad: Flags, half_kerfs: Floats, points: Floats, way: Counts, near: Near
) -> list[Traced]:
    """The strokes without their leads.

    `bad` ways follow no contour, and `half_kerfs` tell how far each stroke keeps off. `points` are
    places of the path, `way` those that they lie on, `near` the contours that they follow.
    """
    bounds = _bounds(work)
    rings = _rings(work, bounds, bad)
    rows = np.array(rings, dtype=np.int64).reshape(-1, 2)
    starts, ends = work.path.starts[rows[:, 0]], work.path.ends[rows[:, 1] - 1]
    closed = np.hypot(*(ends - starts).T) <= 2 * work.tolerance
    closed &= ~_gaping(work, starts, ends, closed & (half_kerfs == 0.0))
    contours = _contours(work, half_kerfs, points, work.of_way[way], near)
    columns = (column.tolist() for column in (half_kerfs, closed, contours))
    traced = [
        Traced(stroke, begin, first, last, end, *values)
        for stroke, (begin, end), (first, last), *values in zip(
            work.strokes, bounds, rings, *columns, strict=True
        )
    ]
    if work.bridged:
        _join_bridged(work, traced)
    for t in traced:
        t.members = t.members or ([t] if t.closed else [])
    _overs(work, traced, points, way)
    return traced


def close(work: Work, which: Counts) -> Flags:
    """Which of some strokes close, but for their leads."""
    every, follows = _bounds(work), np.zeros(work.path.count, dtype=bool)
    rings = _rings(work, [every[k] for k in which.tolist()], follows)
    lows, highs = np.array(rings, dtype=np.int64).reshape(-1, 2).T
    apart = np.hypot(*(work.path.ends[highs - 1] - work.path.starts[lows]).T)
    return np.asarray(apart <= work.meeting)


def _bounds(work: Work) -> Bounds:
    """The ways of each stroke, leads among them: the first, and what is behind the last."""
    ends = np.cumsum(np.bincount(work.of_way, minlength=len(work.strokes))).tolist()
    return list(zip([0, *ends[:-1]], ends, strict=True))


def _rings(work: Work, bounds: Bounds, bad: Flags) -> list[tuple[int, int]]:
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
        if dx * dx + dy * dy > self._near:
            return False
        length = self._begins[high - 1] + self._lengths[high - 1] - self._begins[low]
        is_long: bool = high - low > 1 or self._lengths[low] ** 2 > LEAST * self._near
        return is_long and bool(length >= self._shortest)

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
        begin, size = first, self._lengths[first]
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


def _gaping(work: Work, starts: Floats, ends: Floats, which: Flags) -> Flags:
    """Strokes that end beside their start because the contour has a gap there, wider than `gap`."""
    gaping = np.zeros(len(starts), dtype=bool)
    which = which & (np.hypot(*(ends - starts).T) > 2 * work.step)
    if not which.any():
        return gaping
    stops = shapely.points(np.concatenate((work.need.starts, work.need.ends)))
    first, second = shapely.STRtree(stops).query(stops, "dwithin", distance=work.torch.gap)
    free = np.delete(stops, first[first != second])
    tree, reach = shapely.STRtree(free), 2 * work.tolerance
    for k in np.flatnonzero(which).tolist():
        begin, end = (
            set(tree.query(shapely.Point(place), "dwithin", distance=reach).tolist())
            for place in (starts[k], ends[k])
        )
        gaping[k] = len(begin | end) > 1 and bool(begin and end)
    return gaping


def _contours(work: Work, half_kerfs: Floats, points: Floats, stroke: Counts, near: Near) -> Counts:
    """The closed contour that most of the places of each stroke follow, by its number; -1 of none.

    Of contours on one another only the first is one, whichever of them is the nearest.
    """
    region = work.region
    found = np.full(len(work.strokes), -1)
    if not region.rings:
        return found
    away, nearest = near
    known = np.isfinite(away) & ((half_kerfs > 0.0)[stroke] | (work.half_kerf == 0.0))
    ring = np.where(known, region.ring_of[nearest], -1)
    twin = np.flatnonzero(known & (ring < 0) & region.closed[nearest])
    if len(twin):
        reach = away[twin].max() + work.most_slack
        far, other = work.need.nearest_within(points[twin], (reach,), region.ring_of >= 0)
        ring[twin] = np.where(np.isfinite(far), region.ring_of[other], -1)
    count = len(region.rings) + 1
    pairs, times = np.unique(stroke[known] * count + ring[known] + 1, return_counts=True)
    order = np.argsort(times, kind="stable")
    found[pairs[order] // count] = pairs[order] % count - 1
    return found


def _overs(work: Work, traced: Sequence[Traced], points: Floats, way: Counts) -> None:
    """Tell each stroke the length of other strokes that run along its ring.

    `points` are places of the path, `way` those that they lie on.
    """
    on_ring = on_contour(work, traced)
    outside = np.zeros(work.path.count, dtype=bool)
    for t in traced:
        if t.members or t.joined:
            outside[t.begin : t.first] = outside[t.last : t.end] = True
    which = np.flatnonzero(outside[way])
    if not len(which):
        return
    number = np.arange(len(traced))
    for k, t in enumerate(traced):
        if len(t.members) > 1:
            number[k : k + len(t.members)] = k
    pairs = work.path.near(points[which], work.tolerance)
    other = work.path.owner[pairs.element]
    own = number[work.of_way[way[which[pairs.point]]]] == number[work.of_way[other]]
    missed = np.ones(len(which), dtype=bool)
    missed[pairs.point[own & on_ring[other]]] = False
    outside[way[which[missed]]] = False
    for t in traced:
        if not t.members:
            continue
        # A lead may come along the contour; what begins where the contour has an end is not a lead.
        heads = [work.path.starts[m.first : m.last] for m in t.members]
        for k in np.flatnonzero(outside[t.begin : t.first]).tolist():
            away = np.hypot(*(np.concatenate(heads) - work.path.starts[t.begin + k]).T)
            outside[t.begin + k] = bool(away.min() <= work.meeting)
    reached = np.concatenate(([0.0], np.cumsum(np.where(outside, work.path.lengths, 0.0))))
    for t in traced:
        t.over = float(reached[t.end] - reached[t.begin])
        t.before = float(reached[t.first] - reached[t.begin])
        behind = float(work.path.lengths[t.last : t.end].sum())
        t.beyond = behind - float(reached[t.end] - reached[t.last])


def on_contour(work: Work, traced: Sequence[Traced]) -> Flags:
    """The ways of the path that are not leads."""
    on = np.zeros(work.path.count, dtype=bool)
    for t in traced:
        on[t.first : t.last] = True
    return on


# --- bridges --------------------------------------------------------------------------------------


def _join_bridged(work: Work, traced: Sequence[Traced]) -> None:
    """Puts the strokes together that go round a contour with bridges, one after the other."""
    first = 0
    while first < len(traced):
        last = first
        while not traced[last].closed:
            if last > first and _close(work, traced[first], traced[last]):
                break
            goes_on = last + 1 < len(traced) and not traced[last + 1].closed
            if not goes_on or not _is_bridge(work, traced[last], traced[last + 1]):
                if not _is_bridge(work, traced[last], traced[first]):
                    last = -1
                break
            last += 1
        else:
            last = -1
        mine = traced[first : last + 1]  # that go round one contour together
        starts = work.path.starts[[t.first for t in mine]].tolist()
        along: dict[int, float] = {}
        for t in mine:
            length = float(work.path.lengths[t.first : t.last].sum())
            along[t.contour] = along.get(t.contour, 0.0) + length
        contour = max(along, key=lambda one: along[one], default=-1)
        for t, (x, y) in zip(mine, [*starts[1:], *starts[:1]], strict=True):
            t.bridge_to, t.joined, t.contour = (x, y), True, contour
        if mine:
            end = work.path.ends[mine[-1].last - 1]
            if np.hypot(*(np.array(starts[0]) - end)) <= 2 * work.tolerance:
                mine[-1].bridge_to = None
            mine[0].members = list(mine)
        first = max(first, last) + 1


def _is_bridge(work: Work, t: Traced, following: Traced) -> bool:
    """Whether a stroke begins about a bridge's width behind another one, on the same contour.

    Of an edge that two contours share either may be the one that a stroke follows; and what is cut
    between both holds nothing. What begins in a kerf that was cut before is the rest of a contour,
    and a bridge that is beside it one of another contour.
    """
    end, start = work.path.ends[t.last - 1], work.path.starts[following.first]
    width = float(np.hypot(*(start - end)))
    if width > WIDEST * (work.torch.tab_width + 2 * t.half_kerf + 2 * work.tolerance):
        return False
    reach = MITRE * t.half_kerf + 2 * work.tolerance
    ends = shapely.points([end, start])
    for contour in {t.contour, following.contour} - {-1}:
        ring = shapely.get_exterior_ring(work.region.polygons[contour])
        if (shapely.distance(ring, ends) > reach).any():
            continue
        at, to = shapely.line_locate_point(ring, ends)
        way = (to - at + ring.length / 2) % ring.length - ring.length / 2
        if not 4 * work.tolerance < abs(way) <= MOST_ALONG * width + 2 * reach:
            continue
        between = shapely.line_interpolate_point(ring, (at + way * BETWEEN) % ring.length)
        cut = work.path.near(shapely.get_coordinates(between), t.half_kerf + work.tolerance)
        if len(np.unique(cut.point)) < len(BETWEEN):
            return not is_in_kerf(work, start, int(work.of_way[following.first]))
    return False


def is_in_kerf(work: Work, place: Floats, number: int) -> bool:
    """Whether a place lies on what was cut before a stroke, by its number."""
    near = work.path.near(place.reshape(1, 2), 2 * work.tolerance)
    return bool((work.of_way[work.path.owner[near.element]] < number).any())


def _close(work: Work, one: Traced, last: Traced) -> bool:
    """Whether the last stroke ends where the first begins; what is not part of the ring is lead."""
    starts, ends, begins = work.path.starts, work.path.ends, work.path.begins
    head, tail = one.begin, last.end
    total = begins[tail - 1] + work.path.lengths[tail - 1]
    for low in range(one.last - 1, head - 1, -1):
        most = max(work.most_in, work.most_from_middle) if low == head + 1 else work.most_in
        if begins[low] - begins[head] > most:
            continue
        for high in range(last.begin + 1, tail + 1):
            if high < tail and total - begins[high] > work.most_out:
                continue
            if np.hypot(*(starts[low] - ends[high - 1])) <= work.meeting:
                one.first, last.last = low, high
                return True
    return False


def in_bridges(work: Work, traced: Sequence[Traced], points: Floats) -> Flags:
    """Which points lie in a bridge: between the end of a stroke and the start of the next."""
    inside = np.zeros(len(points), dtype=bool)
    for t in traced:
        if t.bridge_to is None or not len(points):
            continue
        ends = work.path.ends[t.last - 1], np.array(t.bridge_to)
        width = float(np.hypot(*(ends[1] - ends[0])))
        # In a corner the contour lies farther off than half a kerf.
        most = MOST_ALONG * width + 2 * (MITRE * t.half_kerf + work.tolerance)
        inside |= sum(np.hypot(*(points - end).T) for end in ends) <= most
    return inside
