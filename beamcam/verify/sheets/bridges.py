"""Contours with bridges: several strokes go round one, with a gap between each and the next."""

from collections.abc import Sequence

import numpy as np

from beamcam.errors import Diagnostic, Source
from beamcam.geometry.array_types import Flags, Floats
from beamcam.verify.sheets import rules
from beamcam.verify.sheets.work import Traced, Work

Bounds = Sequence[tuple[int, int]]


def join_bridged(work: Work, bounds: Bounds, traced: Sequence[Traced]) -> list[Diagnostic]:
    """Gives the first stroke around a contour with bridges its ring; contours with too many.

    `bounds` are the ways of each stroke, those of leads included.
    """
    said: list[Diagnostic] = []
    if not work.bridged:
        return said
    first = 0
    while first < len(traced):
        last = first
        while last < len(traced) and not traced[last].closed:
            if last > first and _close(work, bounds, traced, first, last):
                break
            last = last + 1 if _goes_on(work, traced, last) else len(traced)
        if first < last < len(traced) and not traced[last].closed:
            mine = traced[first : last + 1]
            if mine[0].contour is None:
                mine[0].ring = [(t.first, t.last) for t in mine]
                boxes = np.array([t.box for t in mine])
                low, high = boxes[:, :2].min(axis=0).tolist(), boxes[:, 2:].max(axis=0).tolist()
                mine[0].box = (*low, *high)
                for t in mine:
                    t.group, t.goes_round = mine[0].group, True
            if last - first > work.torch.tabs:
                source = Source(work.name, mine[0].stroke.line)
                found, most = last - first, work.torch.tabs
                contour = work.contour_at(work.path.starts[mine[0].first])
                said.append(rules.TABS.at(source, found=found, contour=contour, expected=most))
            first = last
        first += 1
    return said


def _goes_on(work: Work, traced: Sequence[Traced], k: int) -> bool:
    """Whether the next stroke begins a bridge's width behind the end of stroke `k`."""
    if k + 1 == len(traced):
        return False
    end = work.path.ends[traced[k].last - 1]
    following = work.path.starts[traced[k + 1].first]
    return bool(np.hypot(*(following - end)) <= work.tab_width(traced[k].half_kerf))


def _close(work: Work, bounds: Bounds, traced: Sequence[Traced], first: int, last: int) -> bool:
    """Whether stroke `last` ends where `first` begins; what is no part of the ring is lead."""
    starts, ends, lengths = work.path.starts, work.path.ends, work.path.lengths
    head, tail = bounds[first][0], bounds[last][1]
    for low in range(traced[first].last - 1, head - 1, -1):
        if lengths[head:low].sum() > work.most(work.torch.lead_in):
            continue
        for high in range(bounds[last][0] + 1, tail + 1):
            if lengths[high:tail].sum() > work.most(work.torch.lead_out):
                continue
            if np.hypot(*(starts[low] - ends[high - 1])) <= 2 * work.step:
                traced[first].first, traced[last].last = low, high
                return True
    return False


def is_bridge(work: Work, place: Floats, others: Floats, half_kerf: float) -> bool:
    """Whether a bridge begins at a place: another stroke goes on behind it."""
    if not work.bridged:
        return False
    away = np.hypot(*(others - place).T)
    return bool(np.min(away) <= work.tab_width(half_kerf))


def in_bridges(work: Work, traced: Sequence[Traced], points: Floats) -> Flags:
    """Which points lie in a bridge: between the end of a stroke and the start of another."""
    inside = np.zeros(len(points), dtype=bool)
    opened = [t for t in traced if not t.closed]
    if not work.bridged or not opened or not len(points):
        return inside
    starts = work.path.starts[[t.first for t in opened]]
    for t in opened:
        end = work.path.ends[t.last - 1]
        away = np.hypot(*(starts - end).T)
        k = int(np.argmin(away))
        width = work.tab_width(t.half_kerf)
        if away[k] <= width:
            middle = (starts[k] + end) / 2
            reach = width / 2 + t.half_kerf + work.tolerance
            inside |= np.hypot(*(points - middle).T) <= reach
    return inside
