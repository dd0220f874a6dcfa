"""Cuts that are not square at the root of a web, where a torch cuts web and flange at one x.

They cross it on a slant, or a corner of a cope is still round there. What stays of both walls
reaches as far as either of them does at the root: of the web as deep as the passes through that
root cut, of the flange as wide as web and fillets are.
"""

from collections.abc import Iterator, Mapping, Sequence
from itertools import pairwise, product
from math import radians, tan
from typing import Any

from msgspec import Struct

from beamcam.checks.coping.section import CoperSection, pieces_of
from beamcam.checks.coping.skew import AT_EDGE, ON_PLANE, EndOnWall, Shape
from beamcam.checks.coping.strokes import TorchStroke, through_root
from beamcam.checks.coping.wanted import RequiredWall
from beamcam.geometry.plane import Point

#: mm along the bar by mm across it of a cut through a root that is made square
STEEPEST = tan(radians(30.0))
APART = 1.0  #: mm along the bar that web and flange may be drawn apart and are one cut
SQUARE = 0.1  #: mm along the bar that a square cut may slant
FAR = 1e5


class Crossing(Struct, frozen=True):
    """An edge of a wall through the whole of a root, straight or round."""

    line: EndOnWall  #: it, or of a round edge its side alone: 1 where the scrap lies at greater x
    xs: tuple[float, float]  #: where it meets the other wall
    round: Any = None  #: the edge itself, of shapely

    @property
    def side(self) -> int:
        return self.line.side

    def over(self, band: tuple[float, float]) -> list[float]:
        """x at both sides of a band; of a round one the least and the greatest."""
        if self.round is not None:
            return [*self.round.bounds[::2]]
        return [self.line.x(y) for y in band]

    def corners(self, band: tuple[float, float]) -> list[Point]:
        """Where it is at both sides of a band."""
        if self.round is not None:
            return [(x, y) for x, y in self.round.coords]
        return [(self.line.x(y), y) for y in band]

    def step(self, drawn: Shape, band: tuple[float, float], x: float) -> Shape:
        """What is more of a wall that goes to x on a band of it."""
        if self.round is None:
            return self.line.step(*band, x)
        from shapely import box, union_all

        inside = min(self.over(band), key=lambda at: self.side * at) - self.side * AT_EDGE
        air = box(min(inside, x), band[0], max(inside, x), band[1]).difference(drawn)
        return union_all([one for one in pieces_of(air) if one.intersects(self.round)])


def crossings_of(
    shape: Shape, band: tuple[float, float], wider: Sequence[tuple[float, float]],
    surface: float | None, ends: Sequence[EndOnWall], radius: float,
) -> Iterator[Crossing]:  # fmt: skip
    """The edges from side to side of a band of a wall, but for its ends: straight ones, and on the
    first of some wider bands round ones, of `radius` mm along the bar or as steep at most.

    The inner surface of a flange lies at y `surface` of a web: it meets a round edge there, or in
    its own thickness where that goes back.
    """
    from shapely import LineString, box

    for edge in _across(shape, band):
        (xa, ya), (xb, yb) = edge.coords[0], edge.coords[-1]
        more = (xb - xa) / (yb - ya)
        if _is_straight(edge) and not _is_end(edge, ends) and abs(more) <= STEEPEST:
            line = EndOnWall(_side(shape, edge), xa - more * ya, more, 0.0)
            yield Crossing(line, (xa, xb))
    known: list[Any] = []
    for edge in (edge for one in wider for edge in _across(shape, one)):
        least, _, most, _ = edge.bounds
        is_known = any(edge.within(one.buffer(ON_PLANE)) for one in known)
        if is_known or _is_straight(edge) or _is_end(edge, ends):
            continue
        known.append(edge)
        if not SQUARE < most - least <= max(radius, (edge.bounds[3] - edge.bounds[1]) * STEEPEST):
            continue
        ys = [y for _, y in edge.coords]
        if any(a >= b for a, b in pairwise(ys)):  # a hole of the web beside its flange
            continue
        side = _side(shape, edge)
        if surface is not None:
            there = edge.intersection(LineString([(-FAR, surface), (FAR, surface)])).bounds[0]
            flange = sorted((surface, FAR if surface > (ys[0] + ys[-1]) / 2 else -FAR))
            least, _, most, _ = edge.intersection(box(-FAR, flange[0], FAR, flange[1])).bounds
            least, most = (least, there) if side > 0 else (there, most)
        yield Crossing(EndOnWall(side, 0.0, 0.0, 0.0), (least, most), edge)


def _across(shape: Shape, band: tuple[float, float]) -> Iterator[Any]:
    """The edges of a shape from the lower side of a band to the upper one."""
    from shapely import LineString, box, line_merge

    low, high = band
    edges = shape.boundary.intersection(box(-FAR, low, FAR, high))
    if edges.geom_type == "MultiLineString":
        edges = line_merge(edges)
    for edge in pieces_of(edges):
        if edge.geom_type == "LineString":
            places = [*edge.coords]
            places = places if places[0][1] < places[-1][1] else places[::-1]
            if places[-1][1] - places[0][1] >= high - low - ON_PLANE:
                yield LineString(places)


def _is_straight(edge: Any) -> bool:
    from shapely import LineString

    chord = LineString([edge.coords[0], edge.coords[-1]])
    return bool(edge.hausdorff_distance(chord) <= ON_PLANE / 2)


def _is_end(edge: Any, ends: Sequence[EndOnWall]) -> bool:
    """Whether an edge lies on an end, by its middle."""
    (xa, ya), (xb, yb) = edge.coords[0], edge.coords[-1]
    return any(abs((xa + xb) / 2 - end.x((ya + yb) / 2)) <= ON_PLANE for end in ends)


def _side(shape: Shape, edge: Any) -> int:
    """1 where the scrap lies at greater x of an edge."""
    from shapely import Point as Place

    middle = edge.interpolate(0.5, normalized=True)
    return -1 if shape.covers(Place(middle.x + 2 * ON_PLANE, middle.y)) else 1


def with_square_roots(
    required: dict[tuple[str, float], RequiredWall], ends: Mapping[str, Sequence[EndOnWall]],
    section: CoperSection, strokes: Sequence[TorchStroke], widest: float, radius: float,
) -> dict[str, float]:  # fmt: skip
    """Puts what stays where a cut is not square at a root into `required`, on all surfaces that it
    has; gives the mm that are too much, by face. `widest` is the widest kerf, `radius` that of a
    corner that is drawn sharp."""
    off: dict[str, float] = {}
    cut = {face: required[face, 0.0].cut for face in section.faces}
    for face in section.faces[1:]:
        passes = through_root(face, section, strokes)
        deep = max((one.row.up_to for one in passes if not one.b_deg), default=0.0)
        if not deep:
            continue
        back, front = section.root(face)
        zs = max(back - ON_PLANE, 0.0), min(front + ON_PLANE, section.wide)
        ys, inner = (0.0, deep + ON_PLANE), (section.flange + 2 * ON_PLANE, deep - 2 * ON_PLANE)
        wider = [(ON_PLANE, ys[1]), (inner[0], ys[1])]
        if face == "o":
            ys, inner, *wider = (
                (section.high - high, section.high - low) for low, high in (ys, inner, *wider)
            )
        across = zs[0] + 2 * ON_PLANE, zs[1] - 2 * ON_PLANE
        beside = max(zs[0], ON_PLANE), min(zs[1], section.wide - ON_PLANE)
        at = inner[1] if face == "o" else inner[0]
        on_web = [*crossings_of(cut["v"], inner, wider, at, ends["v"], radius)]
        on_flange = [*crossings_of(cut[face], across, [beside], None, ends[face], radius)]
        for web, flange in product(on_web, on_flange):
            # Both are one cut, of which either is not square at its root.
            apart = max(min(web.xs) - max(flange.xs), min(flange.xs) - max(web.xs))
            slanted = max(abs(xa - xb) for xa, xb in (web.xs, flange.xs)) > SQUARE
            is_square = not slanted and web.round is None and flange.round is None
            if is_square or web.side != flange.side or apart > APART:
                continue
            x = web.side * max(web.side * at for at in (*web.over(ys), *flange.over(zs)))
            for one, edge, band in (("v", web, ys), (face, flange, zs)):
                off[one] = max(off.get(one, 0.0), *(abs(x - at) for at in edge.over(band)))
                step = edge.step(required[one, 0.0].drawn, band, x)
                for key, wall in [*required.items()]:
                    if key[0] == one:
                        required[key] = wall.grown(step, edge.corners(band), widest)
    return off
