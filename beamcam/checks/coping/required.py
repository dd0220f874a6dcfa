"""What has to stay of all walls, surface by surface, with the skew ends of the part.

What a web keeps along a flange at a hole that reaches it: the torch does not come there.

A hole right under a flange that stays, at its end, is cut up to a ledge; that is as high as the
torch over the web keeps off the flange, or as deep as the pass cuts that takes the root with it.
"""

from collections.abc import Collection, Iterator, Mapping, Sequence
from itertools import pairwise, product
from math import radians, tan
from typing import Any

from msgspec import Struct
from shapely import LineString, box, get_coordinates, line_merge, union_all
from shapely import Point as Place

from beamcam.checks.coping.bevels import passes_of
from beamcam.checks.coping.chart import CoperJob
from beamcam.checks.coping.required_wall import RequiredWall, required_on
from beamcam.checks.coping.section import CoperSection, areas_of, pieces_of
from beamcam.checks.coping.skew import (
    AT_EDGE,
    ON_PLANE,
    EndOnWall,
    SkewEnd,
    as_square,
    ends_on,
    is_tilted,
    own_bevels,
    skew_ends,
)
from beamcam.checks.coping.stock import WallStock
from beamcam.checks.coping.strokes import TorchStroke, through_root
from beamcam.geometry.plane import Point
from beamcam.model.part import Contour, Feature

Shape = Any  #: of shapely

ABOVE = 0.1  #: mm that a ledge is higher than what is cut with the flange
SHORT = 1.0  #: mm; a shorter gap between web and flange is none
#: mm along the bar by mm across it of a cut through a root that is made square
STEEPEST = tan(radians(30.0))
APART = 1.0  #: mm along the bar that web and flange may be drawn apart and are one cut
SQUARE = 0.1  #: mm along the bar that a square cut may slant
FAR = 1e5


def ledges_of(
    web: Shape, flange: Shape, face: str, section: CoperSection, height: float, side: int,
    end: EndOnWall | None,
) -> Iterator[tuple[Shape, list[Point]]]:  # fmt: skip
    """The ledges of a web along a flange at one of its ends, -1 the start, so high from the
    flange's outside, and where they end in the web's contour. `end` is a skew one of the web."""
    low, high = section.web_ends
    top = section.high - height - ABOVE if face == "o" else height + ABOVE
    inner = high - 0.05 if face == "o" else low + 0.05
    middle = (section.back + section.front) / 2
    line = LineString([(-FAR, inner), (FAR, inner)])
    stays = flange.intersection(LineString([(-FAR, middle), (FAR, middle)]))
    band = (top, section.high) if face == "o" else (0.0, top)
    for one in pieces_of(stays):
        first, _, last, _ = one.bounds
        if end is not None:  # the web ends elsewhere than the outside of the flange
            at = end.x(inner)
            first, last = (first, at) if side > 0 else (at, last)
        over = line.intersection(box(first, inner - 1.0, last, inner + 1.0))
        for gap in pieces_of(over.difference(web)):
            x0, _, x1, _ = gap.bounds
            is_first, is_last = abs(x0 - first) < 0.1, abs(x1 - last) < 0.1
            at_end = is_first != is_last and is_last == (side > 0)
            middle = section.high - section.flange / 2 if face == "o" else section.flange / 2
            own = LineString([(x0, middle), (x1, middle)]).difference(web)
            own = own if end is None else own.difference(end.beyond)
            # A web that is not drawn in the flange's own thickness has no flange there.
            if x1 - x0 <= SHORT or not at_end or own.length > SHORT:
                continue
            missing = box(first, band[0], last, band[1]).difference(web)
            if end is not None:  # which the band goes on to, above and below
                far = (first, FAR / 2) if side > 0 else (-FAR / 2, last)
                missing = box(far[0], band[0], far[1], band[1]).difference(web)
                missing = missing.difference(end.beyond)
            for piece in pieces_of(missing):
                if piece.geom_type == "Polygon" and piece.intersects(gap):
                    edge = piece.boundary.intersection(LineString([(-FAR, top), (FAR, top)]))
                    places: Sequence[Any] = get_coordinates(edge).tolist()
                    yield piece.buffer(1e-3, join_style="mitre"), [(x, y) for x, y in places]


# --- cuts that are not square at a root -----------------------------------------------------------

# A torch cuts web and flange at one x there. Such cuts cross the root on a slant, or a corner of a
# cope is still round there. What stays of both walls reaches as far as either of them does at the
# root: of the web as deep as the passes through that root cut, of the flange as wide as web and
# fillets are.


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
    chord = LineString([edge.coords[0], edge.coords[-1]])
    return bool(edge.hausdorff_distance(chord) <= ON_PLANE / 2)


def _is_end(edge: Any, ends: Sequence[EndOnWall]) -> bool:
    """Whether an edge lies on an end, by its middle."""
    (xa, ya), (xb, yb) = edge.coords[0], edge.coords[-1]
    return any(abs((xa + xb) / 2 - end.x((ya + yb) / 2)) <= ON_PLANE for end in ends)


def _side(shape: Shape, edge: Any) -> int:
    """1 where the scrap lies at greater x of an edge."""
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


# --- all walls ------------------------------------------------------------------------------------

LEAST_OFF = 0.5  #: mm that a square cut is off at a skew end and that are manual work


class RequiredWalls:
    """What has to stay of a part: of each wall, so far below its face."""

    def __init__(
        self, job: CoperJob, section: CoperSection, stock: WallStock, left: Collection[int],
        strokes: Sequence[TorchStroke],
    ) -> None:  # fmt: skip
        """`left` are features that are not made."""
        self._job, self._section, self._strokes = job, section, strokes
        self._off: dict[str, float] = {}
        rows, faces = job.rows, section.faces
        self._widest = max((row.kerf for row in rows), default=0.0)
        self._ends = (None, None) if stock.is_piece else skew_ends(job.part, section)

        def surface(face: str, depth: float, tilted: Sequence[bool]) -> RequiredWall:
            there = ends_on(self._ends, tilted, face, section, depth)
            return required_on(job, face, section, left, stock, there)

        upper = {face: surface(face, 0.0, (True, True)) for face in faces}
        drawn = {face: one.drawn for face, one in upper.items()}
        self._near = section.near(job.coper, min((row.cut_height for row in rows), default=0.0))
        self._tilted = [
            end is not None and is_tilted(end, drawn, section, job.coper, self._near)
            for end in self._ends
        ]
        #: by face and mm below it
        self.walls = {(face, 0.0): one for face, one in upper.items()}
        if any(self._tilted):
            self.walls = {
                (face, depth): surface(face, depth, self._tilted) if depth else upper[face]
                for face in faces for depth in (0.0, section.thickness(face))
            }  # fmt: skip
        if not stock.is_piece:
            self._add_ledges()
        for end, is_tilted_to in zip(self._ends, self._tilted, strict=True):
            if end is not None and not is_tilted_to:
                self._square(end)
        #: skew ends by the faces that they end
        self.ends = {face: ends_on(self._ends, (True, True), face, section, 0.0) for face in faces}
        known = stock.ends if stock.is_piece else self.ends
        radius = job.coper.corner_radius
        self._grow(with_square_roots(self.walls, known, section, strokes, self._widest, radius))
        #: those that a tilted torch makes as they are
        self.made = [e for e, yes in zip(self._ends, self._tilted, strict=True) if e and yes]
        #: bevels, with the strokes that make them
        self.passes = passes_of(job.part, section, job.coper, strokes, self.made)
        self._take_bevels()
        #: mm too much by the walls that are cut square
        self.off = {face: mm for face, mm in self._off.items() if mm >= LEAST_OFF}

    def is_left(self, k: int, feature: Feature) -> bool:
        """Whether the feature k of a part is the outline of a wall whose skew end is cut square, or
        has bevels that neither an end nor a pass makes."""
        face = getattr(feature, "face", "").replace("h", "v")
        if isinstance(feature, Contour) and feature.kind == "outer" and face in self.off:
            return True
        there = [bevel for one in self.passes if one.edge.feature == k for bevel in one.edge.drawn]
        own = own_bevels(feature, self.made, self._job.coper.min_bevel)
        return any(one not in there for one in own)

    def _grow(self, off: Mapping[str, float]) -> None:
        for face, mm in off.items():
            self._off[face] = max(mm, self._off.get(face, 0.0))

    def _take_bevels(self) -> None:
        """Walls at both surfaces and at the lands of their bevels, without what the bevels take."""
        for face in dict.fromkeys(one.stroke.face for one in self.passes):
            own = [one for one in self.passes if one.stroke.face == face]
            outer, thick = self.walls[face, 0.0], self._section.thickness(face)
            inner = self.walls.get((face, thick), outer)
            for down in {0.0, thick, *(p.edge.thickness - p.edge.bevel.land for p in own)}:
                # Between both surfaces a skew end lies between where it is at them.
                over, under = outer if down < thick else inner, inner if down > 0.0 else outer
                gone = union_all([one.edge.strip(down) for one in own])
                drawn, cut, most = (
                    areas_of(shape.difference(gone))
                    for shape in (
                        over.drawn.intersection(under.drawn),
                        over.cut.intersection(under.cut),
                        over.most.union(under.most),
                    )
                )
                self.walls[face, down] = RequiredWall(drawn, cut, outer.short, most)

    def _square(self, end: SkewEnd) -> None:
        """Adds what stays at a skew end that is cut square, on all surfaces."""
        section, depths = self._section, dict[str, float]()
        for face in section.faces[1:]:
            line = end.on_wall(face, section, 0.0)
            depths[face] = max(
                (one.row.up_to for one in through_root(face, section, self._strokes)
                 if any(end.side * (x - line.x(y)) > 0.0 for x, y in one.points)),
                default=0.0,
            )  # fmt: skip
        for inner in sorted({depth > 0.0 for _, depth in self.walls}):
            some = {face: (face, section.thickness(face) * inner) for face in section.faces}
            shapes = {face: self.walls[key].drawn for face, key in some.items()}
            more, off, steps = as_square(end, shapes, section, self._job.coper, depths)
            for face, key in some.items():
                self.walls[key] = self.walls[key].grown(more[face], steps[face], self._widest)
            self._grow(off)

    def _add_ledges(self) -> None:
        """Adds the ledges of the web; at a skew end only where the torch is tilted to it."""
        section = self._section
        for face in section.faces[1:]:
            flange = self.walls[face, 0.0].drawn
            bounds = flange.bounds or (0.0,) * 4
            deep = [section.flange + self._near] * 2  # square to the flange, at start and end
            for one in through_root(face, section, self._strokes):
                at_end = one.points[-1][0] > (bounds[0] + bounds[2]) / 2
                deep[at_end] = max(deep[at_end], one.row.up_to * one.share)
            for depth in [depth for one, depth in self.walls if one == "v"]:
                drawn, wall = self.walls["v", depth].drawn, self.walls["v", depth]
                for k, end in enumerate(self._ends):
                    if end is not None and not self._tilted[k]:
                        continue
                    line = None if end is None else end.on_wall("v", section, depth)
                    for ledge, places in ledges_of(
                        drawn, flange, face, section, deep[k], 2 * k - 1, line
                    ):
                        wall = wall.grown(ledge, places, self._widest)
                        self._off["v"] = max(*deep) - section.flange
                self.walls["v", depth] = wall
