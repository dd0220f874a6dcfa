r"""Tubes that come cut: their ends are there, and what is taken of one is open to it.

     x 0                  The piece as it comes less the outline that is drawn. A side of the
u  |  ______              outline on the end of the piece is that end, and no cut: there the
   | |______  slot        outline goes on beyond it, so that what is drawn is open to the air.
   |                      A path begins and ends in the air; its arc starts on the end of the
   |____                  scrap, where all of the wall is.
        |   notch
"""

from collections.abc import Iterator, Sequence
from itertools import pairwise
from math import dist, inf

import numpy as np
from msgspec import Struct
from msgspec.structs import replace
from shapely import (
    LineString,
    Polygon,
    get_coordinates,
    intersection_all,
    line_merge,
    make_valid,
    union_all,
)
from shapely import Point as Place
from shapely.affinity import translate

from beamcam.errors import Diagnostic, Source
from beamcam.geometry.array_types import Floats
from beamcam.geometry.curves import Point
from beamcam.machine.coper import Coper
from beamcam.machine.torch import TorchRow
from beamcam.model.part import Contour, EndCuts, EndPlane, Feature, Part
from beamcam.planning.coping import rules
from beamcam.planning.coping.cuts import (
    LEADS,
    MITRE,
    OF_PIECE,
    ROUND,
    SHARE_OVER,
    CutChain,
    Path,
    gone_on,
    is_clear,
    rings_of,
)
from beamcam.planning.coping.regions import ALONG, OUTLINE_NOISE, Shape, is_through

BEYOND = 100.0  #: mm that an outline goes on beyond an end that is there
LEAST_RUN = 3.0  #: mm of an end that a border lies on, at least; what is shorter is a curve
ON = 1e-6  #: mm
IN_AIR = 2.5  #: kerfs that a path may go on in the air before it is clear of the end, at most


class EndLine(Struct, frozen=True):
    """How an end that is there may be drawn: where the outside of the wall ends, or its inside."""

    side: int  #: -1 at the start, 1 at the end
    across: Floats  #: y of a face, or the way round, rising
    xs: tuple[Floats, ...]  #: along it, one row for each surface
    far: float  #: x far beyond it

    def off(self, places: Floats) -> list[Floats]:
        """How far places lie beyond it, by each surface; negative on the piece."""
        x, y = places.T
        return [self.side * (x - np.interp(y, self.across, row)) for row in self.xs]

    def beyond(self, y: float) -> float:
        """The x at which nothing of the wall is left."""
        every = (self.side * float(np.interp(y, self.across, row)) for row in self.xs)
        return self.side * max(every)


class FaceEnds(Struct, frozen=True):
    """The ends of a face that are there."""

    lines: tuple[EndLine, EndLine]
    is_drawn: bool  #: by an outline of its own


def opened(shape: Shape, ends: Sequence[EndLine]) -> Shape:
    """A shape that goes on straight beyond the ends where its border lies on one of them."""
    if shape.is_empty or not ends:
        return shape
    longer = []
    for one in getattr(shape, "geoms", (shape,)):
        if one.geom_type == "Polygon":
            rings = (np.array(ring.coords)[:-1] for ring in (one.exterior, *one.interiors))
            outer, *holes = (_opened(ring, ends) for ring in rings)
            longer.append(make_valid(Polygon(outer, holes)))
    return union_all(longer)


def _opened(ring: Floats, ends: Sequence[EndLine]) -> list[Point]:
    """A ring with each stretch of it that lies on an end replaced by one far beyond that."""
    after = np.roll(ring, -1, axis=0)
    on = np.zeros(len(ring), int)
    for end in ends:
        for here, there in zip(end.off(ring), end.off(after), strict=True):
            near = np.maximum(np.abs(here), np.abs(there)) <= OUTLINE_NOISE
            along = np.abs(there - here) <= ALONG * np.abs(after[:, 1] - ring[:, 1])
            on[near & along] = end.side
    points: list[Point] = []
    count = len(ring)
    first = next((k for k in range(count) if on[k] != on[k - 1]), None)
    if first is None:
        return [(x, y) for x, y in ring.tolist()]
    k = first
    while k < first + count:
        side, stop = on[k % count], k
        while stop < first + count and on[stop % count] == side:
            stop += 1
        a, b = ring[k % count], ring[stop % count]
        own = [one for one in ends if one.side == side]
        if not own or abs(b[1] - a[1]) < LEAST_RUN:
            points += [(x, y) for x, y in (ring[j % count].tolist() for j in range(k, stop))]
        else:
            far, before, behind = own[0].far, ring[(k - 1) % count], ring[(stop + 1) % count]
            out = [_gone_on(before, a, own[0]), _gone_on(behind, b, own[0])]
            points += [(a[0], a[1]), out[0], (far, out[0][1]), (far, out[1][1]), out[1]]
        k = stop
    return points


def _gone_on(before: Floats, last: Floats, end: EndLine) -> Point:
    """Where a side that goes on straight meets the farthest of an end."""
    (xa, ya), (x, y) = before.tolist(), last.tolist()
    run, rise = x - xa, y - ya
    if end.side * (end.beyond(y) - x) <= ON or end.side * run <= abs(rise) * ALONG:
        return x, y
    for _ in range(4):
        x, y = end.beyond(y), y + (end.beyond(y) - x) * rise / run
    return x, y


def beyond_ends(shape: Shape, ends: Sequence[EndLine]) -> tuple[float, float]:
    """mm that all of a shape lies beyond one of the ends that it is drawn on, and that any of it
    does; below 0 on the piece."""
    places = get_coordinates(shape)
    offs = [np.min(end.off(places), axis=0) for end in ends]
    least = max((float(off.min()) for off in offs), default=-inf)
    return least, max((float(off.max()) for off in offs), default=0.0)


# --- the piece ------------------------------------------------------------------------------------


class TubePiece(Struct, frozen=True):
    """A tube that comes cut, on three turns of its surface."""

    steel: Shape  #: with that where its holes are; it ends where the wall reaches farthest
    open: Shape  #: the holes that are there
    slant: float  #: mm that its ends are skew through the wall


def ends_there(part: Part) -> tuple[Feature, ...]:
    """What a file has as made of the ends of a tube that comes cut: outlines and planes."""
    return tuple(f for f in part.made or () if _is_end(f))


def _is_end(feature: Feature) -> bool:
    is_outline = isinstance(feature, Contour) and feature.kind == "outer"
    return is_outline or isinstance(feature, EndPlane)


def holes_there(part: Part) -> tuple[Part, Sequence[int]]:
    """A tube with what is made of it as its features, and which of them go through its wall."""
    made = part.made or ()
    return replace(part, features=made), [
        k for k, f in enumerate(made) if _is_end(f) or is_through(f)
    ]


def without_ends(part: Part) -> Part:
    """What is asked of a piece; how its ends are the header says, and what is made of it."""
    return replace(part, cuts=EndCuts())


def planes_refused(part: Part) -> Iterator[Diagnostic]:
    """Errors for planes that are to end a tube that comes cut."""
    for feature in part.features:
        if isinstance(feature, EndPlane):
            yield rules.TUBE_END.at(feature.source, what="a plane that ends it")


def paths_round(shape: Shape, half_kerf: float, piece: TubePiece) -> Shape:
    """The region whose border a torch follows: round the part's corners at half a kerf; where an
    outline ends at the end of the piece it goes straight on beyond that."""
    straight = shape.buffer(half_kerf, join_style="mitre", mitre_limit=MITRE)
    ways = half_kerf, -half_kerf
    inner = intersection_all([piece.steel, *(translate(piece.steel, way, 0.0) for way in ways)])
    return union_all([shape.buffer(half_kerf, ROUND), straight.difference(inner)])


def open_paths(
    paths: Shape, region: Shape, piece: TubePiece, row: TorchRow, turn: float, source: Source
) -> tuple[list[CutChain], list[Diagnostic]]:
    """The paths that begin and end beyond the ends of a piece, each once, and what is wrong with
    those that stay beside an end."""
    half = row.kerf / 2
    window = piece.steel.buffer(SHARE_OVER * half)
    low, _, high, _ = piece.steel.bounds
    chains: list[CutChain] = []
    wrong: list[Diagnostic] = []
    for line in rings_of(paths):
        if window.covers(line):
            continue
        within = line.intersection(window)
        within = line_merge(within) if within.geom_type == "MultiLineString" else within
        for one in getattr(within, "geoms", (within,)):
            if one.geom_type != "LineString" or one.is_empty:
                continue
            places = [(x, u) for x, u in one.coords]
            us = [u for _, u in places]
            if max(us) - min(us) > 1.5 * turn:
                wrong.append(rules.TUBE_END.at(source, what="an outline that takes all of an end"))
            elif turn <= min(us) < 2 * turn:
                off, ends = one.difference(piece.steel), one.boundary
                air = next(  # where it goes on in the air for longer than an arc does
                    (p.centroid.x for p in getattr(off, "geoms", (off,)) if p.length > (
                        IN_AIR * row.kerf if p.distance(ends) <= ON else row.kerf / 2)),
                    None,
                )  # fmt: skip
                if air is not None:
                    what = f"an outline that leaves too little to cut along the end at x {air:.1f}"
                    wrong.append(rules.TUBE_END.at(source, what=what))
                    continue
                start, end = (OF_PIECE[2 * x > low + high] for x, _ in (places[0], places[-1]))
                chain = CutChain(tuple(places), start, end)
                # The region lies on the left of a path round it.
                (xa, ya), (xb, yb) = max(pairwise(places), key=lambda pair: dist(*pair))
                long, x, y = dist((xa, ya), (xb, yb)), (xa + xb) / 2, (ya + yb) / 2
                nx, ny = (ya - yb) / long / 2, (xb - xa) / long / 2
                left, right = (
                    region.distance(Place(x + side * nx, y + side * ny)) for side in (1.0, -1.0)
                )
                chains.append(chain if left < right else chain.reversed())
    return chains, [*dict.fromkeys(wrong)]


def path_from_air(
    chain: CutChain, region: Shape, piece: TubePiece, row: TorchRow, coper: Coper
) -> Path | None:
    """A path with its lead, from the end of the scrap beside it; None without room."""
    low, _, high, _ = piece.steel.bounds
    for one in (chain, chain.reversed()):
        first, side = one.points[0], -1 if one.start == "near" else 1
        for share in LEADS[:-1]:
            for way in (1.0, -1.0):
                u = first[1] + way * share * coper.lead
                across = piece.steel.intersection(LineString([(low - 1.0, u), (high + 1.0, u)]))
                if across.is_empty:
                    continue
                x = across.bounds[0 if side < 0 else 2] - side * piece.slant
                if dist((x, u), first) <= coper.lead + piece.slant and is_clear(
                    (x, u), first, region, row, piece.open
                ):
                    return gone_on(((x, u), *one.points), coper.over)
    return None
