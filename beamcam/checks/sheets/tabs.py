"""Bridges: as many as are asked of each contour, as wide, and at places that hold the part.

Where on a contour they lie is the planner's choice, but for this:

    spread   two neighbours are at least half as far apart as if all were, and at most half as much
             again
    corners  none is nearer to a corner than `torch.min_tab_to_corner`, unless every place is that
             lies within a quarter of these distances

What holds is the steel between both ends of the cut, so their distance is the width of a bridge.
Over a corner or round a bend more of the contour is left, 1.75 times as much at most.
"""

from collections.abc import Iterator, Sequence
from itertools import pairwise
from typing import NamedTuple

import numpy as np
import shapely
from shapely.ops import substring

from beamcam.checks.sheets import rules
from beamcam.checks.sheets.controller_state import turn_deg
from beamcam.checks.sheets.region import ring_depths
from beamcam.checks.sheets.work import MITRE, SHOWN, STAIRS, Traced, Work
from beamcam.errors import Diagnostic, Rule, Source
from beamcam.geometry.array_types import Flags, Floats
from beamcam.machine.torch import CORNER_DEG

MOST_ALONG = 1.75  #: of the contour in a bridge, by the distance of its ends

# --- bridges --------------------------------------------------------------------------------------

# Contours with bridges: several strokes go round one, with a gap between each and the next.


Bounds = Sequence[tuple[int, int]]
Beside = tuple[float, float]  #: how far along a curve, and how far away
Stretch = tuple[int, float, float]  #: of a curve of the part: which, from where, to where along it

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
        goes_on = last + 1 < len(traced) and not traced[last + 1].closed
        if not goes_on or not _is_bridge(work, traced[last], traced[last + 1]):
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


# --- what is asked of them ------------------------------------------------------------------------

MIN_WIDTH = 1e-3  #: mm, half of it on an average, of what a ring goes round
DOUBT_DEG = 5.0  #: what turns a little less or more than a corner is not asked

Limits = tuple[float, float]  #: least and most


class _Gap(NamedTuple):
    """A bridge between the end of a stroke and the start of the next."""

    before: Traced
    after: Traced
    middle: Floats
    width: float
    turn_deg: float  #: from the one stroke to the other


def tab_faults(work: Work, traced: Sequence[Traced]) -> list[Diagnostic]:
    """Contours with too few or too many bridges, with narrow and wide ones, and misplaced ones."""
    if not work.bridged or work.torch.kerf_by == "machine":
        return []
    rings = [t for t in traced if t.members]
    polygons = [t.inside() for t in rings]
    diagnostics: list[Diagnostic] = []
    depths = ring_depths(polygons)
    corners = _corners(work) if work.torch.min_tab_to_corner else np.zeros((0, 2))
    for t, polygon, depth in zip(rings, polygons, depths, strict=True):
        is_ring = polygon is not None and polygon.area > MIN_WIDTH * polygon.length
        diagnostics += _ring_faults(work, t, depth if is_ring else -1, corners)
    return diagnostics[:SHOWN]


def _ring_faults(work: Work, t: Traced, depth: int | None, corners: Floats) -> Iterator[Diagnostic]:
    """What is wrong with the bridges of one ring; -1 is the depth of one without an inside."""
    closes = t.members[-1].bridge_to is not None
    rounds = [(t.members[-1], t.members[0])] if closes else []
    gaps = [_gap(work, a, b) for a, b in (*pairwise(t.members), *rounds)]
    lengths = [_length(work, m) for m in t.members]
    width = work.torch.tab_width + 2 * t.half_kerf
    total = sum(lengths) + len(gaps) * width
    slack, bent = 2 * work.tolerance, (MOST_ALONG - 1) * width
    allowed = _counts(work, depth, (total, total + len(gaps) * bent), width)
    contour = work.contour_at(work.path.starts[t.first])
    if len(gaps) not in allowed:
        expected = " or ".join(map(str, sorted(allowed)))
        yield rules.TABS.at(
            Source(work.name, t.stroke.line), found=len(gaps), contour=contour, expected=expected
        )
        return
    for gap in gaps:
        if abs(gap.width - width) > slack:
            yield _at(work, rules.TAB_WIDTH, gap, contour, f"{gap.width:.3f}", f"{width:g}")
    even = total / max(len(gaps), 1)
    apart = [length + width for length in lengths[1:-1]]
    if len(gaps) > 1:
        apart += [lengths[0] + width, lengths[-1] + width] if closes else [
            lengths[0] + lengths[-1] + width
        ]  # fmt: skip
    for gap, way in zip(gaps, apart, strict=False):
        if not even / 2 - slack - bent <= way <= 1.5 * (even + bent) + slack:
            found, expected = f"{way:.3f} mm from another", f"{even / 2:.3f} to {1.5 * even:.3f} mm"
            yield _at(work, rules.TAB_PLACE, gap, contour, found, expected)
            return
    for gap in gaps if len(corners) else ():
        if _is_at_corner(work, gap, corners) and _may_be_clear(work, gap, width, even / 4):
            least = f"at least {work.torch.min_tab_to_corner:g} mm from a corner"
            yield _at(work, rules.TAB_PLACE, gap, contour, "at a corner", least)


def _length(work: Work, t: Traced) -> float:
    """How long a stroke is; of stairs what they climb."""
    if not work.stepped:
        return float(work.path.lengths[t.first : t.last].sum())
    line = shapely.LineString(work.path.outline(t.first, t.last, work.fine))
    return float(shapely.length(line.simplify(2 * work.tolerance)))


def _at(work: Work, rule: Rule, gap: _Gap, contour: str, found: str, expected: str) -> Diagnostic:
    x, y = gap.middle.tolist()
    return rule.at(
        Source(work.name, gap.after.stroke.line), contour=contour, x=f"{x:.3f}", y=f"{y:.3f}",
        found=found, expected=expected,
    )  # fmt: skip


def _counts(work: Work, depth: int | None, totals: Limits, width: float) -> set[int]:
    """How many bridges a ring may have: those asked for, or as many as it is long enough for.

    What has not four times as much length as its bridges gets fewer; at the limit both count.
    `totals` are the least and the greatest length that it may have.
    """
    if depth == -1:
        return {0}
    counts: set[int] = set()
    if depth is None or depth % 2 == 0 or work.torch.inner_tabs:
        low, high = (
            min(work.torch.tabs, int((total + slack) / (4 * width)))
            for total, slack in zip(totals, (-4 * work.tolerance, 4 * work.tolerance), strict=True)
        )
        counts.update(range(max(low, 0), high + 1))
    if depth is None or (depth % 2 == 1 and not work.torch.inner_tabs):
        counts.add(0)
    return counts


def _gap(work: Work, before: Traced, after: Traced) -> _Gap:
    """The bridge between two strokes."""
    end, start = work.path.ends[before.last - 1], work.path.starts[after.first]
    turn = turn_deg(work.heading(before, at_end=True), work.heading(after, at_end=False))
    return _Gap(before, after, (end + start) / 2, float(np.hypot(*(start - end))), turn)


def _corners(work: Work) -> Floats:
    """Places where two curves of the part meet and turn, (n, 2)."""
    need = work.need
    every = np.arange(need.count)
    out = need.elements.directions(need.first(every), np.zeros(need.count))
    back = -need.elements.directions(need.last(every), np.ones(need.count))
    places = np.concatenate((need.starts, need.ends))
    ways: dict[tuple[float, float], list[Floats]] = {}
    step = max(work.torch.gap, work.tolerance)
    for place, way in zip(places, np.concatenate((out, back)), strict=True):
        x, y = np.round(place / step).tolist()
        ways.setdefault((x, y), []).append(np.concatenate((place, way)))
    corners = [
        rows[0][:2] for rows in ways.values()
        if len(rows) == 2 and turn_deg(rows[0][2:], -rows[1][2:]) > CORNER_DEG + DOUBT_DEG
    ]  # fmt: skip
    return np.array(corners).reshape(-1, 2)


def _is_at_corner(work: Work, gap: _Gap, corners: Floats) -> bool:
    """Whether a corner of the part lies beside the bridge, or in it."""
    reach = work.torch.min_tab_to_corner - 3 * work.tolerance
    if reach <= 0.0:
        return False  # no distance that is told from none
    back = _stretch(work, gap.before, reach, backwards=True)
    forth = _stretch(work, gap.after, reach, backwards=False)
    line = shapely.LineString([*back[::-1], *forth])
    near = gap.before.half_kerf + work.tolerance
    ends = shapely.LineString([back[0], forth[0]])
    if gap.turn_deg > CORNER_DEG + DOUBT_DEG and bool(
        (shapely.distance(ends, shapely.points(corners)) <= near + gap.width / 2).any()
    ):
        return True
    return bool((shapely.distance(line, shapely.points(corners)) <= near).any())


def _stretch(work: Work, t: Traced, length: float, backwards: bool) -> Floats:
    """Points of a stroke from its end backwards, or from its start on, so far along it."""
    points = work.path.outline(t.first, t.last, work.fine)
    line = shapely.LineString(points[::-1] if backwards else points)
    stretch: Floats = shapely.get_coordinates(substring(line, 0.0, length))
    return stretch


def _may_be_clear(work: Work, gap: _Gap, width: float, most: float) -> bool:
    """Whether a place with no corner near it is at most so far along the contour from a bridge."""
    reach = width / 2 + work.torch.min_tab_to_corner + MITRE * gap.before.half_kerf
    # Where in the bridge a corner lies is not known, nor how much of the contour.
    turned = gap.turn_deg > CORNER_DEG - DOUBT_DEG
    doubt = 2 * work.tolerance + ((MOST_ALONG - 1) * width / 2 if turned else 0.0)
    reach, most = reach + doubt, most - doubt
    turns = [-width / 2, width / 2] if turned else []
    for t, backwards in ((gap.before, True), (gap.after, False)):
        points = _stretch(work, t, most + reach, backwards)
        if work.stepped:
            line = shapely.LineString(points).simplify(STAIRS * work.tolerance / 4)
            points = shapely.get_coordinates(line)
        legs = np.diff(points, axis=0)
        sizes = np.hypot(*legs.T)
        legs, sizes = legs[sizes > 0.0], sizes[sizes > 0.0]
        side = -1.0 if backwards else 1.0
        place = width / 2
        for k in range(len(legs)):
            if (
                k
                and turn_deg(legs[k - 1] / sizes[k - 1], legs[k] / sizes[k])
                > CORNER_DEG - DOUBT_DEG
            ):
                turns.append(side * place)
            place += float(sizes[k])
        if place < most + reach:
            turns.append(side * place)  # another bridge
    places = [0.0, *(turn + s * reach for turn in turns for s in (-1.0, 1.0))]
    return any(
        abs(place) <= most and all(abs(place - turn) >= reach - 1e-9 for turn in turns)
        for place in places
    )
