"""The cuts that make a region: half a kerf off it, within the torch's reach, led into from scrap.

free edge  _______o__            o  pierced on the edge of the scrap, along it to the path
           part  |  scrap        x  over the web: pierced in scrap, straight to the path
                 |
root       ------x--             The part lies on the left of a path as its ring runs, so that
                                 the scrap is on the right.
"""

from collections.abc import Iterator, Sequence
from itertools import pairwise
from math import cos, dist, hypot, inf, pi
from typing import Any, Literal

from msgspec import Struct
from shapely import (
    LineString,
    Polygon,
    box,
    get_coordinates,
    get_parts,
    get_rings,
    is_ccw,
    remove_repeated_points,
    reverse,
    union_all,
)
from shapely import Point as Place

from beamcam.errors import Diagnostic, Source
from beamcam.geometry.curves import Point
from beamcam.machine.coper import Coper
from beamcam.machine.torch import TorchRow
from beamcam.model.part import Face
from beamcam.planning.coping import rules
from beamcam.planning.coping.regions import Shape, WallRegion
from beamcam.planning.coping.walls import EDGE, PlannedWall

MITRE = 5.0  #: half kerfs from the end of a contour at which its path leaves a free edge, at most
ROUND = 8  #: sides of a quarter of a path round a corner
SHARE_OVER = 0.98  #: of half a kerf, by which a path is followed beyond a free edge
LEADS = (1.0, 0.75, 0.5, 0.25, 0.0)  #: shares of the lead that are tried
STARTS = 12  #: segments of a closed path on which a start is looked for
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


def paths_of(shape: Shape, half_kerf: float, wall: PlannedWall) -> Shape:
    """The region whose border a torch follows: round the part's corners at half a kerf.

    Where a contour ends at a free edge, or at the end of a piece, the path goes straight on beyond
    that edge.
    """
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
    """The rings of a region, of shapely, each once round with the region on its left."""
    import numpy as np

    polygons = get_parts(remove_repeated_points(shape, SAME_PLACE))
    rings, polygon = get_rings(polygons, return_index=True)
    is_hole = np.diff(polygon, prepend=-1) == 0  # the border of a polygon comes before its holes
    return np.where(is_ccw(rings) == is_hole, reverse(rings), rings)


def chains_of(shape: Shape, borders: Sequence[CutBorder]) -> Iterator[CutChain]:
    """The segments of a region's rings within borders; whole rings where they lie so."""
    import numpy as np

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


Path = tuple[Point, ...]  #: its first segment is the lead


class Leads:
    """Leads of the paths round a region, from scrap that the torch comes to."""

    def __init__(self, region: WallRegion, row: TorchRow, coper: Coper) -> None:
        self._wall, self._shape, self._row, self._coper = region.wall, region.shape, row, coper

    def path(self, chain: CutChain) -> Path | None:
        """A chain with its lead; None if there is no room for one in scrap.

        It begins at a free edge where it has one, that away from the root if both are free; at the
        other where it runs along the first. Edges of a flange with a lip are round: it ends there.
        """
        wall = self._wall
        if not chain.start:
            return self._closed(chain)
        free = {
            "low": wall.low == -inf, "high": wall.high == inf, "near": True, "far": True,
            "bevel": False,
        }  # fmt: skip
        nearer = chain.start == "low" and len(wall.roots) == 1
        turns = free[chain.end] and (not free[chain.start] or nearer)
        if wall.lip and free[chain.start] != free[chain.end]:
            turns = free[chain.start]
        both = (chain.reversed(), chain) if turns else (chain, chain.reversed())
        begins, ends = (free[one.start] for one in both)
        tried = [self._from_edge] if begins else [self._from_root]
        if begins == ends:
            tried = [tried[0], tried[0]]
        for chain, way in zip(both, tried, strict=False):
            if (path := way(chain)) is not None:
                return gone_on(path, self._coper.over) if free[chain.end] else path
        return None

    def in_two(self, chain: CutChain) -> list[Path]:
        """Two ways from the middle of a chain to both its ends at roots, where a lead has no room;
        none where there is no scrap beside a long segment either. They lap."""
        wall, beside, own = self._wall, 2 * self._row.pierce_radius, chain.points
        if {chain.start, chain.end} - {"low", "high"} or inf in (-wall.low, wall.high):
            return []
        for k in _longest_first(own):
            a, b = own[k], own[k + 1]
            if (long := dist(a, b)) <= 2 * beside:
                break
            ways: list[Path] = []
            for side, rest in ((-1.0, own[k + 1 :]), (1.0, own[k::-1])):
                share = 0.5 + side * beside / long / 2
                begin = a[0] + (b[0] - a[0]) * share, a[1] + (b[1] - a[1]) * share
                pierce = self._pierce(begin, _right_of(a, b))
                if pierce is not None and wall.holds(pierce):
                    ways.append((pierce, begin, *rest))
            if len(ways) == 2:
                return ways
        return []

    def _closed(self, chain: CutChain) -> Path | None:
        """A whole ring from the middle of a long segment, pierced square to it."""
        ring = chain.points[:-1]
        for k in _longest_first(chain.points):
            a, b = chain.points[k], chain.points[k + 1]
            middle = (a[0] + b[0]) / 2, (a[1] + b[1]) / 2
            pierce = self._pierce(middle, _right_of(a, b))
            if pierce is not None:
                return (pierce, middle, *ring[k + 1 :], *ring[: k + 1], middle)
        return None

    def _from_root(self, chain: CutChain) -> Path | None:
        """A path that begins over the web, pierced along it beside its start."""
        (x, y), shape = chain.points[0], self._shape
        for side in (1.0, -1.0):
            beside = Place(x + side * self._row.kerf / 4, y)
            if shape.distance(beside) > shape.distance(Place(x, y)):
                pierce = self._pierce((x, y), (side, 0.0))
                return None if pierce is None else (pierce, *chain.points)
        return None

    def _pierce(self, start: Point, way: Point) -> Point | None:
        """Where a path is pierced: the farthest place on a way off it that is clear of the part."""
        least = self._row.pierce_radius - self._row.kerf / 2
        for share in LEADS:
            length = least + share * (self._coper.lead - least) + EDGE
            pierce = start[0] + way[0] * length, start[1] + way[1] * length
            if is_clear(pierce, start, self._shape, self._row, self._wall.open):
                return pierce
        return None

    def _from_edge(self, chain: CutChain) -> Path | None:
        """A path that begins on the edge of the scrap and goes along that edge to the contour.

        It meets the contour's path just beyond the edge, so that no wedge is left in the corner.
        """
        wall, borders = self._wall, borders_of(self._wall, 0.0, self._wall.width, 0.0)
        edge = next(b for b in borders if b.name == chain.start)
        first = chain.points[0]
        crossing = next(
            (k for k in pairwise(chain.points) if edge.beyond(k[0]) * edge.beyond(k[1]) <= 0.0),
            None,
        )
        if crossing is None:  # a path that leaves the wall at once
            return None
        a, b = crossing
        begin, end = edge.beyond(a), edge.beyond(b)
        share = begin / (begin - end) if begin != end else 0.0
        x, y = a[0] + (b[0] - a[0]) * share, a[1] + (b[1] - a[1]) * share
        for part_of in LEADS[:-1]:
            for side in (1.0, -1.0):
                way = side * part_of * self._coper.lead
                start = x + way * edge.ny, y - way * edge.nx
                if edge.nx == 0.0:
                    start = x + way, edge.limit * edge.ny
                holds = wall.ends is None or wall.holds(start)
                if holds and is_clear(start, first, self._shape, self._row, wall.open):
                    return (start, *chain.points)
        return None


def is_clear(start: Point, first: Point, shape: Shape, row: TorchRow, holes: Shape | None) -> bool:
    """Whether a lead from a start to the first place of a path, and what piercing burns, are clear
    of the part, and not over a hole that is there, where no arc starts."""
    lead, half = LineString((start, first)), row.kerf / 2
    return bool(
        shape.distance(Place(start)) >= row.pierce_radius
        and shape.distance(lead) >= CHORDS * half - SLACK
        and (holes is None or not holes.dwithin(lead, half))
    )


def gone_on(path: Sequence[Point], over: float) -> Path:
    """A path that goes straight on beyond its end."""
    (xa, ya), (xb, yb) = path[-2:]
    longer = over / (dist((xa, ya), (xb, yb)) or 1.0)
    return (*path[:-1], (xb + (xb - xa) * longer, yb + (yb - ya) * longer))


def no_room(source: Source, face: Face, at: Point, row: TorchRow) -> Diagnostic:
    """The error that a path from a place on has no room for its lead."""
    return rules.NARROW.at(
        source, what="no room to pierce", x=f"{at[0]:g}", y=f"{at[1]:g}", face=face,
        expected=f"scrap {2 * row.pierce_radius:g} mm wide beside the contour",
    )  # fmt: skip


def over_hole(
    wall: PlannedWall, path: Sequence[Point], row: TorchRow, face: Face, source: Source,
    turn: float = inf,
) -> Iterator[Diagnostic]:  # fmt: skip
    """A warning where a path goes over a hole for more than a kerf; a tube has a `turn`."""
    over = None if wall.open is None else wall.open.intersection(LineString(path))
    if over is not None and over.length > row.kerf:
        x, y = over.centroid.x, over.centroid.y % turn
        yield rules.OPEN.at(source, x=f"{x:.1f}", y=f"{y:.1f}", face=face)


def _longest_first(points: Sequence[Point]) -> list[int]:
    """Some segments of a path, the longest first."""
    return sorted(range(len(points) - 1), key=lambda k: -dist(points[k], points[k + 1]))[:STARTS]


def _right_of(a: Point, b: Point) -> Point:
    size = dist(a, b) or 1.0
    return (b[1] - a[1]) / size, (a[0] - b[0]) / size
