"""Bridges: as many as are asked of each contour, as wide, and at places that hold the part.

Where on a contour they lie is the planner's choice, but for this:

    spread   two neighbours are at least half as far apart as if all were, and at most half as much
             again
    corners  none is nearer to a corner than `torch.min_tab_to_corner`, unless every place is that
             lies within a quarter of these distances
"""

from collections.abc import Iterator, Sequence
from itertools import pairwise
from typing import NamedTuple

import numpy as np
import shapely

from beamcam.errors import Diagnostic, Rule, Source
from beamcam.geometry.array_types import Floats
from beamcam.machine.torch import CORNER_DEG
from beamcam.verify.sheets import rules
from beamcam.verify.sheets.work import SHOWN, STAIRS, Traced, Work

MIN_WIDTH = 1e-3  #: mm, half of it on an average, of what a ring goes round
DOUBT_DEG = 5.0  #: what turns a little less or more than a corner is not asked
MITRE = 1.25  #: by the kerf, how far the corner of a path may lie from that of its contour
OFF = 0.1  #: of its width, how far off the contour the ends of a bridge may be to be measured
SHORT = 20.0  #: steps of the program's numbers, of a move whose direction is not told
MIN_TURN = 1e-3  #: sine of an angle below which two directions are one

Beside = tuple[float, float]
Limits = tuple[float, float]  #: least and most


class _Gap(NamedTuple):
    """A bridge: the end of a stroke, the start of the next, and the width of it."""

    before: Traced
    after: Traced
    end: Floats
    start: Floats
    least: float  #: mm along the contour
    most: float

    @property
    def middle(self) -> Floats:
        return (self.end + self.start) / 2


def tab_faults(work: Work, traced: Sequence[Traced]) -> list[Diagnostic]:
    """Contours with too few or too many bridges, with narrow and wide ones, and misplaced ones."""
    if not work.bridged or work.torch.kerf_by == "machine":
        return []
    rings = [t for t in traced if t.members]
    polygons = [t.inside() for t in rings]
    said: list[Diagnostic] = []
    depths = _depths(polygons)
    corners = _corners(work) if work.torch.min_tab_to_corner else np.zeros((0, 2))
    for t, polygon, depth in zip(rings, polygons, depths, strict=True):
        is_ring = polygon is not None and polygon.area > MIN_WIDTH * polygon.length
        said += _ring_faults(work, t, depth if is_ring else -1, corners)
    return said[:SHOWN]


def _depths(polygons: Sequence["shapely.Polygon | None"]) -> list[int | None]:
    """Number of larger rings around each; None where one crosses it."""
    shapes = np.array([shapely.Polygon() if p is None else p for p in polygons], dtype=object)
    tree = shapely.STRtree(shapes)
    areas = shapely.area(shapes)
    found: list[int | None] = [0] * len(shapes)
    for inner, outer in tree.query(shapes, predicate="intersects").T.tolist():
        if areas[outer] <= areas[inner] or inner == outer or found[inner] is None:
            continue
        if shapely.covers(shapely.buffer(shapes[outer], 0.01), shapes[inner]):
            found[inner] = (found[inner] or 0) + 1
        elif shapely.area(shapely.intersection(shapes[inner], shapes[outer])) > 0.0:
            found[inner] = None
    return found


def _ring_faults(work: Work, t: Traced, depth: int | None, corners: Floats) -> Iterator[Diagnostic]:
    """What is wrong with the bridges of one ring; -1 is the depth of one without an inside."""
    gaps = [_gap(work, a, b) for a, b in _bridged_pairs(t)]
    lengths = [_length(work, m) for m in t.members]
    width = work.torch.tab_width + 2 * t.half_kerf
    total = sum(lengths) + len(gaps) * width
    slack = 2 * work.tolerance
    allowed = _counts(work, depth, total, width)
    contour = work.contour_at(work.path.starts[t.first])
    if len(gaps) not in allowed:
        expected = " or ".join(map(str, sorted(allowed)))
        yield rules.TABS.at(
            Source(work.name, t.stroke.line), found=len(gaps), contour=contour, expected=expected
        )
        return
    for gap in gaps:
        if gap.most < width - slack or gap.least > width + slack:
            found = f"{gap.most if gap.most < width else gap.least:.3f}"
            yield _at(work, rules.TAB_WIDTH, gap, contour, found, f"{width:g}")
    even = total / max(len(gaps), 1)
    apart = [length + width for length in lengths[1:-1]]
    if len(gaps) > 1:
        closes = t.members[-1].bridge_to is not None
        apart += [lengths[0] + width, lengths[-1] + width] if closes else [
            lengths[0] + lengths[-1] + width
        ]  # fmt: skip
    for gap, way in zip(gaps, apart, strict=False):
        if not even / 2 - slack <= way <= 1.5 * even + slack:
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


def _counts(work: Work, depth: int | None, total: float, width: float) -> set[int]:
    """How many bridges a ring may have: those asked for, or as many as it is long enough for.

    What has not four times as much length as its bridges gets fewer; at the limit both count.
    """
    if depth == -1:
        return {0}
    found = set()
    if depth is None or depth % 2 == 0 or work.torch.inner_tabs:
        for slack in (-4 * work.tolerance, 4 * work.tolerance):
            count = work.torch.tabs
            while count and total + slack < 4 * count * width:
                count -= 1
            found.add(count)
    if depth is None or (depth % 2 == 1 and not work.torch.inner_tabs):
        found.add(0)
    return found


def _bridged_pairs(t: Traced) -> Iterator[tuple[Traced, Traced]]:
    yield from pairwise(t.members)
    if t.members[-1].bridge_to is not None:
        yield t.members[-1], t.members[0]


def _gap(work: Work, before: Traced, after: Traced) -> _Gap:
    """The bridge between two strokes; its width along the contour is known by two limits.

    It is no less than the distance of both ends, and no more than the way over the place where
    the tangents there meet: a bend, or a corner.
    """
    path = work.path
    end, start = path.ends[before.last - 1], path.starts[after.first]
    a, b = work.heading(before, at_end=True), work.heading(after, at_end=False)
    chord = start - end
    least = float(np.hypot(*chord))
    most = _over_corner(chord, a, b, work.tolerance)
    if min(path.lengths[[before.last - 1, after.first]]) < SHORT * work.step:
        most = np.inf  # rounding turns what is that short
    elif work.half_kerf:
        least, most = _beside(work, (end, start), (least, most), _turn_deg(a, b))
    if work.half_kerf == 0.0:
        way = _along_contour(work, end, start, 2 * work.torch.tab_width)
        least, most = (way, way) if way >= least - work.tolerance else (least, most)
    return _Gap(before, after, end, start, least, most)


def _over_corner(chord: Floats, a: Floats, b: Floats, slack: float) -> float:
    """The way over the place where the directions of both ends meet; infinite if they do not."""
    turn = float(a[0] * b[1] - a[1] * b[0])
    length = float(np.hypot(*chord))
    if abs(turn) <= MIN_TURN:
        return length if float(a @ b) > 0.0 else np.inf
    ahead = float(chord[0] * b[1] - chord[1] * b[0]) / turn
    behind = float(a[0] * chord[1] - a[1] * chord[0]) / turn
    return max(ahead + behind, length) if min(ahead, behind) > -slack else np.inf


def _beside(work: Work, ends: tuple[Floats, Floats], limits: Limits, turn_deg: float) -> Limits:
    """The limits of a bridge of a beam that keeps off; both ends are beside one curve, or two.

    Between two straight sides it goes over their corner, or round it on an arc of half the kerf.
    Where more than a corner lies between the ends nothing but their distance is known.
    """
    need, (least, most) = work.need, limits
    a, b = (need.nearest_to(place)[1] for place in ends)
    places = np.array([need.starts[a], need.ends[a], need.starts[b], need.ends[b]])
    apart = np.hypot(*(places[:2, None] - places[None, 2:]).T)
    if a != b and apart.min() > work.torch.gap:
        return least, np.inf
    if need.kinds[[a, b]].any() or np.isinf(most):
        return least, most
    turn = float(np.radians(turn_deg))
    return max(least, most - work.half_kerf * (2 * float(np.tan(turn / 2)) - turn)), most


def _along_contour(work: Work, end: Floats, start: Floats, most: float) -> float:
    """The shortest way along the curves of the part from one place to another; -1 if beyond `most`.

    From curve to curve it goes on where ends are no farther apart than the machine's gap.
    """
    need = work.need
    pairs = need.near(np.array([end, start]), 2 * work.tolerance + OFF * work.torch.tab_width)
    #: Of both places the curves beside them: how far along, and how far away.
    places: tuple[dict[int, Beside], dict[int, Beside]] = {}, {}
    columns = (pairs.point, pairs.element, pairs.along, pairs.away)
    for point, element, along, away in zip(*columns, strict=True):
        way = int(need.owner[element])
        at = float(need.at(np.array([element]), np.array([along]))[0] - need.begins[way])
        beside = places[int(point)]
        if way not in beside or away < beside[way][1]:
            beside[way] = at, float(away)
    waiting = [(away, way, at) for way, (at, away) in places[0].items()]
    reached: dict[tuple[int, bool], float] = {}
    found = [np.inf]
    while waiting:
        done, way, at = waiting.pop()
        if way in places[1]:
            to, away = places[1][way]
            found.append(done + abs(to - at) + away)
        for is_end, left in ((False, at), (True, float(need.lengths[way]) - at)):
            far = done + left
            if far > most or reached.get((way, is_end), np.inf) <= far:
                continue
            reached[way, is_end] = far
            place = (need.ends if is_end else need.starts)[way]
            for ends, other_at in ((need.starts, 0.0 * need.lengths), (need.ends, need.lengths)):
                near = np.flatnonzero(np.hypot(*(ends - place).T) <= work.torch.gap)
                waiting += [
                    (far, int(k), float(other_at[k]))
                    for k in near.tolist()
                    if k != way or need.lengths[k] > most
                ]
    least = min(found)
    return least if least <= most else -1.0


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
    found = [
        rows[0][:2] for rows in ways.values()
        if len(rows) == 2 and _turn_deg(rows[0][2:], -rows[1][2:]) > CORNER_DEG + DOUBT_DEG
    ]  # fmt: skip
    return np.array(found).reshape(-1, 2)


def _turn_deg(a: Floats, b: Floats) -> float:
    return float(np.degrees(np.arccos(np.clip(np.dot(a, b), -1.0, 1.0))))


def _is_at_corner(work: Work, gap: _Gap, corners: Floats) -> bool:
    """Whether a corner of the part lies beside the bridge, or in it."""
    reach = work.torch.min_tab_to_corner - 2 * work.tolerance
    back = _stretch(work, gap.before, reach, backwards=True)
    forth = _stretch(work, gap.after, reach, backwards=False)
    line = shapely.LineString([*back[::-1], *forth])
    near = gap.before.half_kerf + work.tolerance
    ends = shapely.LineString([back[0], forth[0]])
    a, b = _directions(work, gap)
    if _turn_deg(a, b) > CORNER_DEG + DOUBT_DEG:
        inside = shapely.distance(ends, shapely.points(corners)) <= near + gap.least / 2
        if inside.any():
            return True
    return bool((shapely.distance(line, shapely.points(corners)) <= near).any())


def _directions(work: Work, gap: _Gap) -> tuple[Floats, Floats]:
    return work.heading(gap.before, at_end=True), work.heading(gap.after, at_end=False)


def _stretch(work: Work, t: Traced, length: float, backwards: bool) -> Floats:
    """Points of a stroke from its end backwards, or from its start on, so far along it."""
    points = work.path.outline(t.first, t.last, work.fine)
    points = points[::-1] if backwards else points
    steps = np.hypot(*np.diff(points, axis=0).T)
    reached = np.concatenate(([0.0], np.cumsum(steps)))
    count = int(np.searchsorted(reached, length))
    if count >= len(points):
        return points
    kept = points[: max(count, 1)]
    share = (length - reached[len(kept) - 1]) / steps[len(kept) - 1]
    last = kept[-1] + share * (points[len(kept)] - kept[-1])
    return np.concatenate((kept, last.reshape(1, 2)))


def _may_be_clear(work: Work, gap: _Gap, width: float, most: float) -> bool:
    """Whether a place with no corner near it is at most so far along the contour from a bridge."""
    reach = width / 2 + work.torch.min_tab_to_corner + 2 * MITRE * gap.before.half_kerf
    reach += 2 * work.tolerance
    most -= 2 * work.tolerance
    # Where in the bridge a corner lies is not known.
    turned = _turn_deg(*_directions(work, gap)) > CORNER_DEG - DOUBT_DEG
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
                and _turn_deg(legs[k - 1] / sizes[k - 1], legs[k] / sizes[k])
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
