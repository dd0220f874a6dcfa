"""Contours with bridges: several strokes go round one, with a gap between each and the next."""

from collections.abc import Sequence

import numpy as np

from beamcam.geometry.array_types import Flags, Floats
from beamcam.verify.sheets.work import MITRE, Traced, Work

Bounds = Sequence[tuple[int, int]]

#: Where a contour is looked for in a bridge, and how far it may bend until there, by its width.
AHEAD, BENT = 0.3, 0.1
WIDEST = 1.5  #: of a bridge that is told to be too wide, by the width of one


def join_bridged(work: Work, bounds: Bounds, traced: Sequence[Traced]) -> None:
    """Puts the strokes together that go round a contour with bridges, one behind the other.

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

    That goes on in the bridge, from one of the two ends at least: there may be a corner between.
    """
    end, start = work.path.ends[t.last - 1], work.path.starts[following.first]
    width = float(np.hypot(*(start - end)))
    if width > WIDEST * work.tab_width(t.half_kerf):
        return False
    ahead, behind = work.heading(t, at_end=True), work.heading(following, at_end=False)
    near = t.half_kerf + BENT * width + work.tolerance
    places = end + AHEAD * width * ahead, start - AHEAD * width * behind
    return any(work.need.nearest_to(place)[0] <= near for place in places)


def _close(work: Work, bounds: Bounds, traced: Sequence[Traced], first: int, last: int) -> bool:
    """Whether stroke `last` ends where `first` begins; what is no part of the ring is lead."""
    starts, ends, begins = work.path.starts, work.path.ends, work.path.begins
    head, tail = bounds[first][0], bounds[last][1]
    total = begins[tail - 1] + work.path.lengths[tail - 1]
    for low in range(traced[first].last - 1, head - 1, -1):
        if begins[low] - begins[head] > work.most_in:
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
        middle = (np.array(t.bridge_to) + work.path.ends[t.last - 1]) / 2
        # In a corner the contour lies farther off than half a kerf.
        reach = work.tab_width(t.half_kerf) / 2 + MITRE * t.half_kerf + work.tolerance
        inside |= np.hypot(*(points - middle).T) <= reach
    return inside
