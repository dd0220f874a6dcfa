"""Contours with bridges: several strokes go round one, with a gap between each and the next."""

from collections.abc import Iterator, Sequence

import numpy as np

from beamcam.geometry.array_types import Flags, Floats
from beamcam.verify.sheets.work import MITRE, Traced, Work

Bounds = Sequence[tuple[int, int]]
Beside = tuple[float, float]  #: how far along a curve, and how far away
Stretch = tuple[int, float, float]  #: of a curve of the part: which, from where, to where along it

MOST_ALONG = 1.75  #: of the contour in a bridge, by the distance of its ends
WIDEST = 1.5  #: of a bridge that is told to be too wide, by the width of one
SAMPLED = (0.25, 0.5, 0.75)  #: shares of a stretch of contour where it is asked whether it is cut


def join_bridged(work: Work, bounds: Bounds, traced: Sequence[Traced]) -> None:
    """Puts the strokes together that go round a contour with bridges, one after the other.

    `bounds` are the ways of each stroke, those of leads included. The last stroke ends where the
    first begins, or a bridge lies there too.
    """
    if not work.bridged:
        return
    first = 0
    while first < len(traced):
        last = _last_of_ring(work, bounds, traced, first)
        if last is None:
            first += 1
            continue
        _join(work, traced[first : last + 1])
        first = last + 1


def _last_of_ring(work: Work, bounds: Bounds, traced: Sequence[Traced], first: int) -> int | None:
    """The last of the strokes that go round from `first` on; None if they do not."""
    last = first
    while not traced[last].closed:
        if last > first and _close(work, bounds, traced, first, last):
            return last
        if not _goes_on(work, traced, last):
            return last if _is_bridge(work, traced[last], traced[first]) else None
        last += 1
    return None


def _join(work: Work, mine: Sequence[Traced]) -> None:
    """Tells strokes that they go round a contour together."""
    starts = work.path.starts[[t.first for t in mine]].tolist()
    for t, (x, y) in zip(mine, [*starts[1:], starts[0]], strict=True):
        t.bridge_to = x, y
    end = work.path.ends[mine[-1].last - 1]
    if np.hypot(*(np.array(starts[0]) - end)) <= 2 * work.tolerance:
        mine[-1].bridge_to = None
    mine[0].members = list(mine)
    for t in mine:
        t.joined = True
    if mine[0].contour is not None:
        return
    mine[0].ring = [(t.first, t.last) for t in mine]
    boxes = np.array([t.box for t in mine])
    low, high = boxes[:, :2].min(axis=0).tolist(), boxes[:, 2:].max(axis=0).tolist()
    mine[0].box = (*low, *high)
    for t in mine:
        t.group, t.goes_round = mine[0].group, True


def _goes_on(work: Work, traced: Sequence[Traced], k: int) -> bool:
    """Whether the next stroke begins a bridge's width behind the end of stroke `k`."""
    if k + 1 == len(traced) or traced[k + 1].closed:
        return False
    return _is_bridge(work, traced[k], traced[k + 1])


def _is_bridge(work: Work, t: Traced, following: Traced) -> bool:
    """Whether a stroke begins about a bridge's width behind another one, on the same contour.

    That goes on from the one to the other, over corners as well, and no stroke runs along it there.
    """
    end, start = work.path.ends[t.last - 1], work.path.starts[following.first]
    width = float(np.hypot(*(start - end)))
    if width > WIDEST * work.tab_width(t.half_kerf):
        return False
    reach = MITRE * t.half_kerf + 2 * work.tolerance
    routes = _routes(work, end, start, reach, MOST_ALONG * width + 2 * reach)
    return any(not _is_cut(work, route, t.half_kerf) for route in routes)


def _routes(
    work: Work, end: Floats, start: Floats, reach: float, most: float
) -> Iterator[list[Stretch]]:
    """The ways along the curves of the part from one place to another, each at most `most` long.

    Both places are no farther from the curves than `reach`. From curve to curve it goes on where
    ends are no farther apart than the machine's gap.
    """
    need = work.need
    pairs = need.near(np.array([end, start]), reach)
    #: Of both places the curves beside them: how far along, and how far away.
    places: tuple[dict[int, Beside], dict[int, Beside]] = {}, {}
    columns = (pairs.point, pairs.element, pairs.along, pairs.away)
    for point, element, along, away in zip(*columns, strict=True):
        way = int(need.owner[element])
        at = float(need.at(np.array([element]), np.array([along]))[0] - need.begins[way])
        beside = places[int(point)]
        if way not in beside or away < beside[way][1]:
            beside[way] = at, float(away)
    waiting: list[tuple[float, int, float, list[Stretch]]] = [
        (away, way, at, []) for way, (at, away) in places[0].items()
    ]
    reached: dict[tuple[int, bool], float] = {}
    while waiting:
        done, way, at, route = waiting.pop()
        if way in places[1]:
            to, away = places[1][way]
            if done + abs(to - at) + away <= most:
                yield [*route, (way, at, to)]
        for is_end, left in ((False, at), (True, float(need.lengths[way]) - at)):
            far = done + left
            if far > most or reached.get((way, is_end), np.inf) <= far:
                continue
            reached[way, is_end] = far
            place = (need.ends if is_end else need.starts)[way]
            gone = [*route, (way, at, float(need.lengths[way]) if is_end else 0.0)]
            for ends, other_at in ((need.starts, 0.0 * need.lengths), (need.ends, need.lengths)):
                near = np.flatnonzero(np.hypot(*(ends - place).T) <= work.torch.gap)
                waiting += [
                    (far, int(k), float(other_at[k]), gone)
                    for k in near.tolist()
                    if k != way or need.lengths[k] > most
                ]


def _is_cut(work: Work, route: Sequence[Stretch], half_kerf: float) -> bool:
    """Whether nothing holds on a way along the contour: it is cut, or has no length."""
    if sum(abs(to - at) for _, at, to in route) <= 4 * work.tolerance:
        return True
    parts = [(way, at, to) for way, at, to in route if abs(to - at) > work.tolerance / 8]
    rows = [(way, at + share * (to - at)) for way, at, to in parts for share in SAMPLED]
    if not rows:
        return False
    way, along = np.array(rows).T
    points = work.need.point(way.astype(np.int64), along)
    cut = np.unique(work.path.near(points, half_kerf + work.tolerance).point)
    return len(cut) == len(rows)


def _close(work: Work, bounds: Bounds, traced: Sequence[Traced], first: int, last: int) -> bool:
    """Whether stroke `last` ends where `first` begins; what is not part of the ring is lead."""
    starts, ends, begins = work.path.starts, work.path.ends, work.path.begins
    head, tail = bounds[first][0], bounds[last][1]
    total = begins[tail - 1] + work.path.lengths[tail - 1]
    for low in range(traced[first].last - 1, head - 1, -1):
        most = max(work.most_in, work.most_from_middle) if low == head + 1 else work.most_in
        if begins[low] - begins[head] > most:
            continue
        for high in range(bounds[last][0] + 1, tail + 1):
            if high < tail and total - begins[high] > work.most_out:
                continue
            if np.hypot(*(starts[low] - ends[high - 1])) <= work.meeting:
                traced[first].first, traced[last].last = low, high
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
