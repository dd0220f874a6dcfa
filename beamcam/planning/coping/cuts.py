"""The cuts that make a region: half a kerf off it, within the torch's reach, led into from scrap.

free edge  _______o__            o  pierced on the edge of the scrap, along it to the path
           part  |  scrap        x  over the web: pierced in scrap, straight to the path
                 |
root       ------x--             The part lies on the left of a path as its ring runs, so that
                                 the scrap is on the right.
"""

from collections.abc import Iterator, Sequence
from itertools import pairwise
from math import cos, hypot, inf, pi
from typing import Any, Literal

from msgspec import Struct

from beamcam.geometry.curves import Point
from beamcam.machine.coper import Coper
from beamcam.machine.torch import TorchRow
from beamcam.planning.coping.regions import Shape
from beamcam.planning.coping.walls import EDGE, PlannedWall

MITRE = 5.0  #: half kerfs from the end of a contour at which its path leaves a free edge, at most
ROUND = 8  #: sides of a quarter of a path round a corner
SHARE_OVER = 0.98  #: of half a kerf, by which a path is followed beyond a free edge
LEADS = (1.0, 0.75, 0.5, 0.25, 0.0)  #: shares of the lead that are tried
STARTS = 12  #: stretches of a closed path on which a start is looked for
#: Of half a kerf, how near a path comes that goes round a corner along chords: as at a peak of the
#: end of a tube, which lies on the seam.
CHORDS = cos(pi / (4 * ROUND))
SLACK = 0.005  #: mm that a lead may be nearer than the path that it leads to
SAME_PLACE = 0.0005  #: mm; places of a path that are nearer are one

#: The border at which a path ends: of the torch's reach, an end of a piece, or the kerf of a bevel;
#: "": it is closed.
End = Literal["low", "high", "near", "far", "bevel", ""]
OF_PIECE: tuple[End, End] = ("near", "far")


class CutBorder(Struct, frozen=True):
    """A line that a path is followed to: inside is where nx x + ny y is at most its limit."""

    name: End
    nx: float
    ny: float
    limit: float

    def beyond(self, place: Point) -> float:
        """How far a place lies outside; negative inside."""
        return self.nx * place[0] + self.ny * place[1] - self.limit


def borders_of(wall: PlannedWall, low: float, high: float, over: float) -> list[CutBorder]:
    """The borders at two y of a wall; of a piece that comes cut its ends too, `over` outwards."""
    borders = [CutBorder("low", 0.0, -1.0, -low), CutBorder("high", 0.0, 1.0, high)]
    if wall.ends is not None:
        for name, side, end in zip(OF_PIECE, (-1.0, 1.0), wall.ends, strict=True):
            long = hypot(1.0, end.slope)
            borders.append(
                CutBorder(name, side / long, -side * end.slope / long, side * end.at / long + over)
            )
    return borders


class CutChain(Struct, frozen=True):
    """A stretch of a path; the scrap is on its right."""

    points: tuple[Point, ...]
    start: End = ""
    end: End = ""

    def reversed(self) -> "CutChain":
        return CutChain(self.points[::-1], self.end, self.start)


class LeadPath(Struct, frozen=True):
    """A path with its lead."""

    path: tuple[Point, ...]
    lead: int  #: stretches of the lead


def paths_of(shape: Shape, half_kerf: float, wall: PlannedWall) -> Shape:
    """The region whose border a torch follows: round the part's corners at half a kerf.

    Where a contour ends at a free edge, or at the end of a piece, the path goes straight on beyond
    that edge.
    """
    from shapely import Polygon, box, union_all

    round_corners = next(
        (found for sides in (ROUND, ROUND + 1, ROUND + 3)
         if (found := shape.buffer(half_kerf, sides)).is_valid),
        shape.buffer(half_kerf, ROUND),
    )  # fmt: skip
    straight = shape.buffer(half_kerf, join_style="mitre", mitre_limit=MITRE)
    left, bottom, right, top = straight.bounds
    edges = [
        box(left, edge - side * half_kerf, right, edge + side * MITRE * half_kerf)
        for border, edge, side in ((wall.low, 0.0, -1.0), (wall.high, wall.width, 1.0))
        if abs(border) == inf
    ]
    for side, end in zip((-1.0, 1.0), wall.ends or (), strict=False):
        ways = (-side * half_kerf, side * MITRE * half_kerf)
        edges.append(
            Polygon(
                [(end.x(y) + way, y) for way, ys in zip(ways, ((bottom, top), (top, bottom)),
                 strict=True) for y in ys]
            )
        )  # fmt: skip
    return union_all([round_corners, *(straight.intersection(edge) for edge in edges)])


def rings_of(shape: Shape) -> Any:
    """The rings of a region, of shapely, with the region on their left, each without repeating a
    place."""
    import numpy as np
    from shapely import get_parts, get_rings, is_ccw, remove_repeated_points, reverse

    polygons = get_parts(remove_repeated_points(shape, SAME_PLACE))
    rings, polygon = get_rings(polygons, return_index=True)
    is_hole = np.diff(polygon, prepend=-1) == 0  # the border of a polygon comes before its holes
    return np.where(is_ccw(rings) == is_hole, reverse(rings), rings)


def chains_of(shape: Shape, borders: Sequence[CutBorder]) -> Iterator[CutChain]:
    """The stretches of a region's rings within borders; whole rings where they lie so."""
    import numpy as np
    from shapely import get_coordinates

    places, ring = get_coordinates(rings_of(shape), return_index=True)
    nx, ny, limits = np.array([(one.nx, one.ny, one.limit) for one in borders]).T
    over = places[:, :1] * nx + places[:, 1:] * ny - limits  # each place beyond each border
    outside = over > 0.0
    is_side = (ring[1:] == ring[:-1]) & ~(outside[:-1] & outside[1:]).any(axis=1)
    met, is_beyond = np.flatnonzero(is_side), outside.any(axis=1)
    begins = np.searchsorted(ring, np.arange(ring.max(initial=-1) + 2))
    for (begin, end), (low, high) in zip(
        pairwise(begins.tolist()), pairwise(np.searchsorted(met, begins).tolist()), strict=True
    ):
        if low == high:
            continue
        xy: list[Point] = [(x, y) for x, y in places[begin:end].tolist()]
        beyond = is_beyond[begin:end].tolist()
        if True not in beyond:
            yield CutChain(tuple(xy))
            continue
        offs, which, first = over[begin:end].tolist(), met[low:high] - begin, beyond.index(True)
        points: list[Point] = []
        start: End = ""
        for k in (*which[which >= first].tolist(), *which[which < first].tolist()):
            a, b = xy[k], xy[k + 1]
            entered: End = ""
            left: End = ""
            if beyond[k] or beyond[k + 1]:
                piece = _within(a, b, offs[k], offs[k + 1], borders)
                if piece is None:
                    continue
                a, b, entered, left = piece
            if entered or not points:
                points, start = [a], entered or start
            points.append(b)
            if left:
                yield CutChain(tuple(points), start, left)
                points, start = [], ""


def _within(
    a: Point, b: Point, over_a: Sequence[float], over_b: Sequence[float],
    borders: Sequence[CutBorder],
) -> tuple[Point, Point, End, End] | None:  # fmt: skip
    """The stretch of a line within borders, and at which of them it enters and leaves; its ends lie
    so far beyond each.

    Source: Cyrus and Beck, Generalized two- and three-dimensional clipping, 1978.
    """
    first, last = 0.0, 1.0
    entered: CutBorder | None = None
    left: CutBorder | None = None
    for border, begin, end in zip(borders, over_a, over_b, strict=True):
        if begin > 0.0 and begin / (begin - end) >= first:
            first, entered = begin / (begin - end), border
        elif end > 0.0 and begin / (begin - end) <= last:
            last, left = begin / (begin - end), border
    if first > last or (first == last and entered and left):
        return None
    (xa, ya), (xb, yb) = a, b

    def at(share: float, border: CutBorder | None, otherwise: Point) -> Point:
        if border is None:
            return otherwise
        x, y = xa + (xb - xa) * share, ya + (yb - ya) * share
        return (x, y) if border.nx else (x, border.ny * border.limit)

    p, q = at(first, entered, a), at(last, left, b)
    return p, q, entered.name if entered else "", left.name if left else ""


def led(
    chain: CutChain, wall: PlannedWall, shape: Shape, row: TorchRow, coper: Coper
) -> LeadPath | None:
    """A chain with its lead; None if there is no room for one in scrap.

    It begins at a free edge where it has one, that away from the root if both are free; at the
    other where it runs along the first. Edges of a flange with a lip are round: it ends there.
    """
    if not chain.start:
        return _closed(chain, wall, shape, row, coper)
    free = {
        "low": wall.low == -inf, "high": wall.high == inf, "near": True, "far": True,
        "bevel": False,
    }  # fmt: skip
    nearer = chain.start == "low" and len(wall.roots) == 1
    turns = free[chain.end] and (not free[chain.start] or nearer)
    if wall.lip and free[chain.start] != free[chain.end]:
        turns = free[chain.start]
    if turns:
        chain = chain.reversed()
    led = _from_edge(chain, wall, shape, row, coper) if free[chain.start] else None
    if led is None and free[chain.start] and free[chain.end]:
        chain = chain.reversed()
        led = _from_edge(chain, wall, shape, row, coper)
    if led is None and not (free[chain.start] or free[chain.end]):
        ways = (_from_root(one, wall, shape, row, coper) for one in (chain, chain.reversed()))
        led = next(filter(None, ways), None)
    elif led is None and not free[chain.start]:
        led = _from_root(chain, wall, shape, row, coper)
    if led is not None and free[chain.end]:
        (xa, ya), (xb, yb) = led.path[-2:]
        longer = coper.over / (hypot(xb - xa, yb - ya) or 1.0)
        beyond = xb + (xb - xa) * longer, yb + (yb - ya) * longer
        led = LeadPath((*led.path[:-1], beyond), led.lead)
    return led


def in_two(
    chain: CutChain, wall: PlannedWall, shape: Shape, row: TorchRow, coper: Coper
) -> list[LeadPath]:
    """Two ways from the middle of a chain to both its ends at roots, where a lead has no room; none
    where there is no scrap beside a long stretch either. They lap."""
    if {chain.start, chain.end} - {"low", "high"} or inf in (-wall.low, wall.high):
        return []
    beside, own = 2 * row.pierce_radius, chain.points
    stretches = sorted(range(len(own) - 1), key=lambda k: -_length(own[k], own[k + 1]))
    for k in stretches[:STARTS]:
        a, b = own[k], own[k + 1]
        if (long := _length(a, b)) <= 2 * beside:
            break
        ways, out = [], _right_of(a, b)
        for side, rest in ((-1.0, own[k + 1 :]), (1.0, own[k::-1])):
            share = 0.5 + side * beside / long / 2
            begin = a[0] + (b[0] - a[0]) * share, a[1] + (b[1] - a[1]) * share
            pierce = _pierce(begin, out, wall, shape, row, coper)
            if pierce is not None and wall.holds(pierce):
                ways.append(LeadPath((pierce, begin, *rest), 1))
        if len(ways) == 2:
            return ways
    return []


def _closed(
    chain: CutChain, wall: PlannedWall, shape: Shape, row: TorchRow, coper: Coper
) -> LeadPath | None:
    """A whole ring from the middle of a long stretch, pierced square to it."""
    ring = chain.points[:-1]
    stretches = sorted(range(len(ring)), key=lambda k: -_length(ring[k], ring[(k + 1) % len(ring)]))
    for k in stretches[:STARTS]:
        a, b = ring[k], ring[(k + 1) % len(ring)]
        middle = (a[0] + b[0]) / 2, (a[1] + b[1]) / 2
        pierce = _pierce(middle, _right_of(a, b), wall, shape, row, coper)
        if pierce is not None:
            return LeadPath((pierce, middle, *ring[k + 1 :], *ring[: k + 1], middle), 1)
    return None


def _from_root(
    chain: CutChain, wall: PlannedWall, shape: Shape, row: TorchRow, coper: Coper
) -> LeadPath | None:
    """A path that begins over the web, pierced along it beside its start."""
    start = chain.points[0]
    for side in (1.0, -1.0):
        beside = start[0] + side * row.kerf / 4, start[1]
        if shape.distance(_place(beside)) > shape.distance(_place(start)):
            pierce = _pierce(start, (side, 0.0), wall, shape, row, coper)
            return None if pierce is None else LeadPath((pierce, *chain.points), 1)
    return None


def _pierce(
    start: Point, way: Point, wall: PlannedWall, shape: Shape, row: TorchRow, coper: Coper
) -> Point | None:
    """Where a path is pierced: the farthest place on a way off it that is clear of the part.

    Nor is it over a hole, where no arc starts.
    """
    least = row.pierce_radius - row.kerf / 2
    nearest = CHORDS * row.kerf / 2 - SLACK
    for share in LEADS:
        length = least + share * (coper.lead - least) + EDGE
        pierce = start[0] + way[0] * length, start[1] + way[1] * length
        if (
            shape.distance(_place(pierce)) >= row.pierce_radius
            and shape.distance(_line(pierce, start)) >= nearest
            and (wall.open is None or not wall.open.dwithin(_line(pierce, start), row.kerf / 2))
        ):
            return pierce
    return None


def _from_edge(
    chain: CutChain, wall: PlannedWall, shape: Shape, row: TorchRow, coper: Coper
) -> LeadPath | None:
    """A path that begins on the edge of the scrap and goes along that edge to the contour.

    It meets the contour's path just beyond the edge, so that no wedge is left in the corner.
    """
    half_kerf = row.kerf / 2
    edge = _edge_of(chain.start, wall)
    first = chain.points[0]
    crossing = next(
        (k for k in pairwise(chain.points) if edge.beyond(k[0]) * edge.beyond(k[1]) <= 0.0), None
    )
    if crossing is None:  # a path that leaves the wall at once
        return None
    a, b = crossing
    begin, end = edge.beyond(a), edge.beyond(b)
    share = begin / (begin - end) if begin != end else 0.0
    x, y = a[0] + (b[0] - a[0]) * share, a[1] + (b[1] - a[1]) * share
    for part_of in LEADS[:-1]:
        for side in (1.0, -1.0):
            way = side * part_of * coper.lead
            start = x + way * edge.ny, y - way * edge.nx
            if edge.nx == 0.0:
                start = x + way, edge.limit * edge.ny
            if (
                (wall.ends is None or wall.holds(start))
                and shape.distance(_line(start, first)) >= CHORDS * half_kerf - SLACK
                and shape.distance(_place(start)) >= row.pierce_radius
                and (wall.open is None or not wall.open.dwithin(_line(start, first), half_kerf))
            ):
                return LeadPath((start, *chain.points), 1)
    return None


def _edge_of(name: End, wall: PlannedWall) -> CutBorder:
    """The edge of a wall, or the end of a piece, at which a path begins."""
    return next(b for b in borders_of(wall, 0.0, wall.width, 0.0) if b.name == name)


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
