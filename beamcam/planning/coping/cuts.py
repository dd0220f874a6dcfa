"""The cuts that make a region: half a kerf off it, within the torch's reach, led into from scrap.

free edge  _______o__            o  pierced on the edge of the scrap, along it to the path
           part  |  scrap        x  over the web: pierced in scrap, straight to the path
                 |
root       ------x--             The part lies on the left of a path as its ring runs, so that
                                 the scrap is on the right.
"""

from collections.abc import Iterator, Sequence
from itertools import pairwise
from math import hypot, inf
from typing import Any, Literal

from msgspec import Struct

from beamcam.geometry.curves import Point
from beamcam.machine.coper import Coper
from beamcam.machine.torch import TorchRow
from beamcam.planning.coping.regions import Shape
from beamcam.planning.coping.walls import EDGE, Wall

MITRE = 5.0  #: half kerfs from the end of a contour at which its path leaves a free edge, at most
ROUND = 8  #: sides of a quarter of a path round a corner
SHARE_OVER = 0.98  #: of half a kerf, by which a path is followed beyond a free edge
LEADS = (1.0, 0.75, 0.5, 0.25, 0.0)  #: shares of the lead that are tried
STARTS = 12  #: stretches of a closed path on which a start is looked for
SLACK = 0.005  #: mm that paths round corners may be nearer than half a kerf

End = Literal["low", "high", ""]  #: the border of the reach at which a path ends; "": it is closed


class Chain(Struct, frozen=True):
    """A stretch of a path; the scrap is on its right."""

    points: tuple[Point, ...]
    start: End = ""
    end: End = ""

    def reversed(self) -> "Chain":
        return Chain(self.points[::-1], self.end, self.start)


class RequiredPath(Struct, frozen=True):
    """A path with its lead."""

    path: tuple[Point, ...]
    lead: int  #: stretches of the lead


def paths_of(shape: Shape, half_kerf: float, wall: Wall) -> Shape:
    """The region whose border a torch follows: round the part's corners at half a kerf.

    Where a contour ends at a free edge the path goes straight on beyond that edge.
    """
    from shapely import box, union_all

    round_corners = next(
        (found for sides in (ROUND, ROUND + 1, ROUND + 3)
         if (found := shape.buffer(half_kerf, sides)).is_valid),
        shape.buffer(half_kerf, ROUND),
    )  # fmt: skip
    straight = shape.buffer(half_kerf, join_style="mitre", mitre_limit=MITRE)
    left, _, right, _ = straight.bounds
    edges = [
        box(left, edge - side * half_kerf, right, edge + side * MITRE * half_kerf)
        for border, edge, side in ((wall.low, 0.0, -1.0), (wall.high, wall.width, 1.0))
        if abs(border) == inf
    ]
    return union_all([round_corners, *(straight.intersection(edge) for edge in edges)])


def rings_of(shape: Shape) -> Iterator[list[Point]]:
    """The rings of a region with the region on their left, without repeating their start."""
    from shapely.geometry.polygon import orient

    for polygon in getattr(shape, "geoms", (shape,)):
        if polygon.geom_type == "Polygon" and not polygon.is_empty:
            turned = orient(polygon)
            for ring in (turned.exterior, *turned.interiors):
                yield [(x, y) for x, y in ring.coords[:-1]]


def chains_of(shape: Shape, low: float, high: float) -> Iterator[Chain]:
    """The stretches of a region's rings at y between two borders; whole rings where they lie so."""
    for ring in rings_of(shape):
        yield from _clipped(ring, low, high)


def _clipped(ring: Sequence[Point], low: float, high: float) -> Iterator[Chain]:
    inside = [low <= y <= high for _, y in ring]
    if all(inside):
        yield Chain((*ring, ring[0]))
        return
    if not any(inside) and not _crosses(ring, low, high):
        return
    first = next(k for k, within in enumerate(inside) if not within)
    points: list[Point] = []
    start: End = ""
    for a, b in pairwise((*ring[first:], *ring[: first + 1])):
        for p, q, entered, left in _pieces(a, b, low, high):
            if entered or not points:
                points, start = [p], entered or start
            points.append(q)
            if left:
                yield Chain(tuple(points), start, left)
                points, start = [], ""


def _crosses(ring: Sequence[Point], low: float, high: float) -> bool:
    return min(y for _, y in ring) < low and max(y for _, y in ring) > high


def _pieces(a: Point, b: Point, low: float, high: float) -> Iterator[tuple[Point, Point, End, End]]:
    """The stretch of a line between two borders, and at which of them it enters and leaves."""
    (xa, ya), (xb, yb) = a, b
    if max(ya, yb) < low or min(ya, yb) > high or (ya == yb and not low <= ya <= high):
        return
    entered: End = "low" if ya < low else "high" if ya > high else ""
    left: End = "low" if yb < low else "high" if yb > high else ""

    def at(y: float) -> Point:
        return xa + (xb - xa) * (y - ya) / (yb - ya), y

    p = at(low) if entered == "low" else at(high) if entered == "high" else a
    q = at(low) if left == "low" else at(high) if left == "high" else b
    yield p, q, entered, left


def led(chain: Chain, wall: Wall, shape: Shape, row: TorchRow, coper: Coper) -> RequiredPath | None:
    """A chain with its lead; None if there is no room for one in scrap.

    It begins at a free edge where it has one, that away from the root if both are free.
    """
    if not chain.start:
        return _closed(chain, shape, row, coper)
    free = {"low": wall.low == -inf, "high": wall.high == inf}
    if free[chain.end] and (
        not free[chain.start] or (chain.start == "low" and len(wall.roots) == 1)
    ):
        chain = chain.reversed()
    half = row.kerf / 2
    led = _from_edge(chain, wall, shape, half, coper) if free[chain.start] else None
    if led is None and not free[chain.start]:
        led = _from_root(chain, shape, row, coper)
    if led is not None and free[chain.end]:
        (xa, ya), (xb, yb) = led.path[-2:]
        longer = coper.over / (hypot(xb - xa, yb - ya) or 1.0)
        beyond = xb + (xb - xa) * longer, yb + (yb - ya) * longer
        led = RequiredPath((*led.path[:-1], beyond), led.lead)
    return led


def _closed(chain: Chain, shape: Shape, row: TorchRow, coper: Coper) -> RequiredPath | None:
    """A whole ring from the middle of a long stretch, pierced square to it."""
    ring = chain.points[:-1]
    stretches = sorted(range(len(ring)), key=lambda k: -_length(ring[k], ring[(k + 1) % len(ring)]))
    for k in stretches[:STARTS]:
        a, b = ring[k], ring[(k + 1) % len(ring)]
        middle = (a[0] + b[0]) / 2, (a[1] + b[1]) / 2
        pierce = _pierce(middle, _right_of(a, b), shape, row, coper)
        if pierce is not None:
            return RequiredPath((pierce, middle, *ring[k + 1 :], *ring[: k + 1], middle), 1)
    return None


def _from_root(chain: Chain, shape: Shape, row: TorchRow, coper: Coper) -> RequiredPath | None:
    """A path that begins over the web, pierced along it beside its start."""
    start = chain.points[0]
    for side in (1.0, -1.0):
        beside = start[0] + side * row.kerf / 4, start[1]
        if shape.distance(_place(beside)) > shape.distance(_place(start)):
            pierce = _pierce(start, (side, 0.0), shape, row, coper)
            return None if pierce is None else RequiredPath((pierce, *chain.points), 1)
    return None


def _pierce(start: Point, way: Point, shape: Shape, row: TorchRow, coper: Coper) -> Point | None:
    """Where a path is pierced: the farthest place on a way off it that is clear of the part."""
    least = row.pierce_radius - row.kerf / 2
    for share in LEADS:
        length = least + share * (coper.lead - least) + EDGE
        pierce = start[0] + way[0] * length, start[1] + way[1] * length
        if (
            shape.distance(_place(pierce)) >= row.pierce_radius
            and shape.distance(_line(pierce, start)) >= row.kerf / 2 - SLACK
        ):
            return pierce
    return None


def _from_edge(
    chain: Chain, wall: Wall, shape: Shape, half_kerf: float, coper: Coper
) -> RequiredPath | None:
    """A path that begins on the edge of the scrap and goes along that edge to the contour.

    It meets the contour's path just beyond the edge, so that no wedge is left in the corner.
    """
    edge = 0.0 if chain.start == "low" else wall.width
    first = chain.points[0]
    (xa, ya), (xb, yb) = next(
        (p, q) for p, q in pairwise(chain.points) if (p[1] - edge) * (q[1] - edge) <= 0.0
    )
    x = xa + (xb - xa) * (edge - ya) / (yb - ya) if ya != yb else xa
    for share in LEADS[:-1]:
        for side in (1.0, -1.0):
            start = x + side * share * coper.lead, edge
            if (
                shape.distance(_line(start, first)) >= half_kerf - SLACK
                and shape.distance(_place(start)) > half_kerf + EDGE
            ):
                return RequiredPath((start, *chain.points), 1)
    return None


def _length(a: Point, b: Point) -> float:
    return hypot(b[0] - a[0], b[1] - a[1])


def _right_of(a: Point, b: Point) -> Point:
    size = _length(a, b) or 1.0
    return (b[1] - a[1]) / size, (a[0] - b[0]) / size


def _place(point: Point) -> Any:
    from shapely import Point as Place

    return Place(point)


def _line(a: Point, b: Point) -> Any:
    from shapely import LineString

    return LineString((a, b))
