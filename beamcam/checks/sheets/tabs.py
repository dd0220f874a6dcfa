"""Bridges: as many as are asked of each contour, as wide, and at places that hold the part.

Where on a contour they lie is the planner's choice, but for this:

    spread   two neighbours are at least half as far apart as if all were, and at most half as much
             again
    corners  none is nearer to a corner than `torch.min_tab_to_corner`, unless every place is that
             lies within a quarter of these distances

What holds is the steel between both ends of the cut, so their distance is the width of a bridge.
Over a corner or round a bend more of the contour is left, 1.75 times as much at most.

         0  width                      a contour's path from one of its bridges on, each bridge a
    -----|==|---------x-------|==|-    straight line; x is the place of a corner on it
         bridge     corner   another
"""

from collections.abc import Iterator, Sequence
from typing import NamedTuple

import numpy as np
import shapely
from shapely.ops import substring

from beamcam.checks.sheets import rules
from beamcam.checks.sheets.tracing import MOST_ALONG, Traced
from beamcam.checks.sheets.work import MITRE, SHOWN, Work
from beamcam.errors import Diagnostic, Rule
from beamcam.geometry.array_types import Floats
from beamcam.machine.torch import CORNER_DEG

DOUBT_DEG = 5.0  #: what turns a little less or more than a corner is not asked

Limits = tuple[float, float]  #: least and most


class _Gap(NamedTuple):
    """A bridge between the end of a stroke and the start of the next."""

    after: Traced
    middle: Floats
    width: float
    line: shapely.LineString  #: from the end of the one on round the contour, to there again


def tab_faults(work: Work, traced: Sequence[Traced]) -> list[Diagnostic]:
    """Contours with too few or too many bridges, with narrow and wide ones, and misplaced ones."""
    if not work.bridged or work.torch.kerf_by == "machine":
        return []
    heads = [t for t in traced if t.members]
    return [fault for t in heads for fault in _ring_faults(work, t)][:SHOWN]


def _ring_faults(work: Work, t: Traced) -> Iterator[Diagnostic]:
    """What is wrong with the bridges of one contour."""
    closes = t.members[-1].bridge_to is not None
    after = [*t.members[1:], *t.members[:1]] if closes else t.members[1:]
    lines = [work.path.outline(m.first, m.last, work.fine) for m in t.members]
    if work.stepped:  # of stairs what they climb
        drawn = (shapely.LineString(line).simplify(2 * work.tolerance) for line in lines)
        lines = [shapely.get_coordinates(line) for line in drawn]
    gaps = []
    for k, m in enumerate(after):
        line = np.concatenate([lines[k][-1:], *lines[k + 1 :], *lines[: k + 1]])
        middle, width = (line[0] + line[1]) / 2, float(np.hypot(*(line[1] - line[0])))
        gaps.append(_Gap(m, middle, width, shapely.LineString(line)))
    lengths = [float(shapely.LineString(line).length) for line in lines]
    width = work.torch.tab_width + 2 * t.half_kerf
    total = sum(lengths) + len(gaps) * width
    slack, bent = 2 * work.tolerance, (MOST_ALONG - 1) * width
    allowed = _counts(work, t.contour, (total, total + len(gaps) * bent), width)
    contour = work.contour_at(work.path.starts[t.first])

    def fault(rule: Rule, gap: _Gap, found: str, expected: str) -> Diagnostic:
        values = {"contour": contour, "found": found, "expected": expected}
        return work.fault(rule, gap.after.stroke.line, gap.middle, **values)

    if len(gaps) not in allowed:
        values = {"found": len(gaps), "expected": " or ".join(map(str, sorted(allowed)))}
        yield work.fault(rules.TABS, t.stroke.line, contour=contour, **values)
        return
    for gap in gaps:
        if abs(gap.width - width) > slack:
            yield fault(rules.TAB_WIDTH, gap, f"{gap.width:.3f}", f"{width:g}")
    even = total / max(len(gaps), 1)
    apart = [length + width for length in lengths[1:-1]]
    if len(gaps) > 1:
        apart += [lengths[0] + width, lengths[-1] + width] if closes else [
            lengths[0] + lengths[-1] + width
        ]  # fmt: skip
    for gap, way in zip(gaps, apart, strict=False):
        if not even / 2 - slack - bent <= way <= 1.5 * (even + bent) + slack:
            found, expected = f"{way:.3f} mm from another", f"{even / 2:.3f} to {1.5 * even:.3f} mm"
            yield fault(rules.TAB_PLACE, gap, found, expected)
            return
    least = work.torch.min_tab_to_corner
    if not gaps or least <= 3 * work.tolerance:
        return  # no distance that is told from none
    sharp, doubtful = (_corners(work, t.contour, CORNER_DEG + by) for by in (DOUBT_DEG, -DOUBT_DEG))
    for gap in gaps:
        is_at_corner = _is_at_corner(work, gap, t.half_kerf, sharp)
        if is_at_corner and _may_be_clear(work, gap, t.half_kerf, doubtful, even / 4):
            yield fault(rules.TAB_PLACE, gap, "at a corner", f"at least {least:g} mm from a corner")


def _counts(work: Work, contour: int, totals: Limits, width: float) -> set[int]:
    """How many bridges a contour may have: those asked for, or as many as it is long enough for.

    What has not four times as much length as its bridges gets fewer; at the limit both count.
    `totals` are the least and the greatest length that it may have.
    """
    if contour < 0:
        return {0}
    is_hole = work.holes[contour]
    counts: set[int] = set()
    if work.torch.inner_tabs or not is_hole:
        slack = 4 * work.tolerance
        low, high = (int(by / (4 * width)) for by in (totals[0] - slack, totals[1] + slack))
        counts.update(range(max(min(work.torch.tabs, low), 0), min(work.torch.tabs, high) + 1))
    if is_hole is None or (is_hole and not work.torch.inner_tabs):
        counts.add(0)
    return counts


def _corners(work: Work, contour: int, least_deg: float) -> Floats:
    """Places where two curves of a contour meet and turn by more than so much, (n, 2)."""
    need = work.need
    ways, turned = np.array(work.region.rings[contour], dtype=np.int64).T
    first, last, zero = need.first[ways], need.last[ways], np.zeros(len(ways))
    ahead = need.elements.directions(first, zero)
    back = need.elements.directions(last, zero + 1.0)
    is_turned = turned[:, None] == 1
    enters, leaves = np.where(is_turned, -back, ahead), np.where(is_turned, -ahead, back)
    cosines = np.sum(np.roll(leaves, 1, axis=0) * enters, axis=1)
    corners = np.where(is_turned, need.ends[ways], need.starts[ways])
    turning: Floats = corners[cosines < np.cos(np.radians(least_deg))]
    return turning


def _is_at_corner(work: Work, gap: _Gap, half_kerf: float, corners: Floats) -> bool:
    """Whether a corner of the contour lies beside the bridge, or in it."""
    places, total = shapely.points(corners), gap.line.length
    at = shapely.line_locate_point(gap.line, places)
    if ((at > work.tolerance) & (at < gap.width - work.tolerance)).any():
        return True
    reach = work.torch.min_tab_to_corner - 3 * work.tolerance
    beside = shapely.multilinestrings(
        [substring(gap.line, 0.0, gap.width + reach), substring(gap.line, total - reach, total)]
    )
    return bool((shapely.distance(beside, places) <= half_kerf + work.tolerance).any())


def _may_be_clear(work: Work, gap: _Gap, half_kerf: float, corners: Floats, most: float) -> bool:
    """Whether a place with no corner near it is at most so far along the contour from a bridge."""
    total = gap.line.length
    at = shapely.line_locate_point(gap.line, shapely.points(corners)) - gap.width / 2
    # Where in the bridge a corner lies is not known, nor how much of the contour; and round a
    # corner the path may have an arc.
    inside = bool((np.abs(at) < gap.width / 2).any())
    doubt = 2 * work.tolerance + ((MOST_ALONG - 1) * gap.width / 2 if inside else 0.0)
    reach = gap.width / 2 + work.torch.min_tab_to_corner + 2 * MITRE * half_kerf + doubt
    turned = [*at.tolist(), *([-gap.width / 2, gap.width / 2] if inside else [])]
    places = [0.0, *(turn + side * reach for turn in turned for side in (-1.0, 1.0))]
    return any(
        abs((place + total / 2) % total - total / 2) <= most - doubt
        and all(
            abs((place - turn + total / 2) % total - total / 2) >= reach - 1e-9 for turn in turned
        )
        for place in places
    )
