"""Outlines that are cut in one go: the torch stays on from one to the next.

        .--------.                 .--------.
        |  part  P=====link========Q  part  |     pierced once, before P
        '--------'                 '--------'

A link is a straight line in waste, no longer than the machine's file says. It keeps half a kerf
off every part, and a whole kerf off all that is cut but the two outlines that it joins, so that
the arc always has metal before it. Both outlines close where the link touches them.
"""

from collections.abc import Sequence
from itertools import accumulate
from typing import Any

import shapely
from msgspec.structs import replace

from beamcam.geometry.curves import Line
from beamcam.geometry.plane import Point
from beamcam.machine.torch import Torch, TorchRow
from beamcam.planning.contours.outline import Shape, stretch, ways
from beamcam.planning.contours.tabs import needs_tabs

Way = tuple[Shape, float]  #: with the kerf that is kept off

#: mm along a contour within which a link goes to the end of a curve instead.
AT_CORNER = 0.2
STRAIGHT = 1e-9  #: sine between two lines that were one
NEAR = 0.01  #: mm that a link may be nearer to a part, by the chords that stand for curves
CLEAR_SHARE = 0.25  #: of a link behind each of its ends, that may lie in the cut there


def chained(
    way: Sequence[Way], rows: Sequence[TorchRow | None], torch: Torch, fence: Sequence[Shape]
) -> tuple[list[Way], dict[int, Line]]:
    """The toolpaths, begun where links touch them, and the link that leads to each of some.

    `rows` are those that the paths are cut by, `fence` the contours as they are drawn.
    """
    shapes, links = list(way), dict[int, Line]()
    field = _Field(shapes, torch, fence)
    for k in range(1, len(shapes)):
        before, after = shapes[k - 1], shapes[k]
        both = (before, after)
        if rows[k - 1] != rows[k] or not all(_may_chain(*one, rows[k], torch) for one in both):
            continue
        linked = field.link(k, k - 1 in links)
        if linked is not None:
            links[k], shapes[k - 1], shapes[k] = linked
    return shapes, links


def _may_chain(shape: Shape, kerf: float, row: TorchRow | None, torch: Torch) -> bool:
    """Whether a contour is an outline that is cut at one feed in one pass, all round."""
    if row is None or row.passes > 1 or not kerf or needs_tabs(shape, torch) or shape.level:
        return False
    if shape.process != "cut" or not shape.is_ring or shape.is_hole:
        return False
    ends = [tuple(round(v, 3) for v in curve.end) for curve in shape.curves]
    return len(ends) > 1 and len({*ends}) == len(ends)  # it touches itself nowhere


class _Field:
    """What links have to keep clear of."""

    def __init__(self, way: list[Way], torch: Torch, fence: Sequence[Shape]) -> None:
        self._way = way
        self._most = torch.chain_cuts
        self._kerf = max((kerf for _, kerf in way), default=0.0)
        fine = torch.tolerance / 4
        self._paths = ways([shape.curves for shape, _ in way], fine)
        drawn = [shape.curves for shape in fence if shape.process == "cut"]
        self._parts = shapely.STRtree(ways(drawn, fine))
        self._tree = shapely.STRtree(self._paths)

    def link(self, k: int, is_fixed: bool) -> tuple[Line, Way, Way] | None:
        """The link from the path before to path `k`, and both as they begin where it touches them.

        The path before begins where it does already if that `is_fixed`.
        """
        target = self._paths[k]
        shape = self._way[k - 1][0]
        starts: list[Any] = [shapely.Point(shape.curves[0].start)]
        if not is_fixed:
            starts = [shapely.Point(curve.point(0.5)) for curve in shape.curves]
            starts.sort(key=lambda place: round(place.distance(target), 3))
            line = shapely.shortest_line(self._paths[k - 1], target)
            starts.append(shapely.get_point(line, 0))
        for start in starts:
            if start.distance(target) > self._most:
                continue
            ends = shapely.get_coordinates(shapely.shortest_line(start, target))
            (x0, y0), (x1, y1) = ends.tolist()
            before, after = self._way[k - 1], _begun_at(self._way[k], (x1, y1))
            if not is_fixed:
                before = _begun_at(before, (x0, y0))
            link = Line(before[0].curves[0].start, after[0].curves[0].start)
            if self._is_clear(link, k):
                return link, before, after
        return None

    def _is_clear(self, link: Line, k: int) -> bool:
        if not 4 * NEAR < link.length <= self._most:
            return False
        line = shapely.LineString([link.start, link.end])
        if len(self._parts.query(line, "dwithin", distance=self._kerf / 2 - NEAR)):
            return False
        inner = shapely.LineString([link.point(CLEAR_SHARE), link.point(1 - CLEAR_SHARE)])
        near = self._tree.query(line, "dwithin", distance=self._kerf)
        if {*near.tolist()} - {k - 1, k}:
            return False
        ends = (shapely.Point(link.start), shapely.Point(link.end))
        return all(
            not inner.intersects(path)
            and shapely.intersection(line, path).difference(end.buffer(4 * NEAR)).is_empty
            for path, end in zip(self._paths[[k - 1, k]], ends, strict=True)
        )


def _begun_at(way: Way, place: Point) -> Way:
    """A closed path from the place on it that is nearest to another one."""
    (shape, kerf), whole = way, way[0].curves
    first, last = whole[0], whole[-1]
    if len(whole) > 2 and isinstance(last, Line) and isinstance(first, Line):
        # A line that was divided where the path began is one again.
        (ax, ay), (bx, by) = last.tangent(1.0), first.tangent(0.0)
        if ax * bx + ay * by > 0.0 and abs(ax * by - ay * bx) < STRAIGHT:
            whole = (*whole[1:-1], Line(last.start, first.end))
    (line,) = ways([whole], NEAR / 4)
    lengths = [curve.length for curve in whole]
    total = sum(lengths)
    at = shapely.line_locate_point(line, shapely.Point(place)) / line.length * total
    corners = [0.0, *accumulate(lengths)]
    corner = min(corners, key=lambda c: abs(c - at))
    if abs(corner - at) <= AT_CORNER:
        k = corners.index(corner) % len(lengths)
        return replace(shape, curves=(*whole[k:], *whole[:k])), kerf
    begun = (*stretch(whole, lengths, at, total), *stretch(whole, lengths, 0.0, at))
    return replace(shape, curves=begun), kerf
