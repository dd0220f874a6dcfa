"""What has to stay of all walls, surface by surface, with the skew ends of the part.

What a web keeps along a flange at a hole that reaches it: the torch does not come there.

A hole right under a flange that stays, at its end, is cut up to a ledge; that is as high as the
torch over the web keeps off the flange, or as deep as the pass cuts that takes the root with it.
"""

from collections.abc import Collection, Iterator, Mapping, Sequence
from typing import Any

from beamcam.checks.coping.bevels import passes_of
from beamcam.checks.coping.chart import CoperJob
from beamcam.checks.coping.section import CoperSection, areas_of, pieces_of
from beamcam.checks.coping.skew import (
    EndOnWall,
    SkewEnd,
    as_square,
    ends_on,
    is_tilted,
    own_bevels,
    skew_ends,
)
from beamcam.checks.coping.slants import with_square_roots
from beamcam.checks.coping.stock import WallStock
from beamcam.checks.coping.strokes import TorchStroke, through_root
from beamcam.checks.coping.wanted import RequiredWall, required_on
from beamcam.geometry.plane import Point
from beamcam.model.part import Contour, Feature

Shape = Any  #: of shapely

ABOVE = 0.1  #: mm that a ledge is higher than what is cut with the flange
SHORT = 1.0  #: mm; a shorter gap between web and flange is none
FAR = 1e5


def ledges_of(
    web: Shape, flange: Shape, face: str, section: CoperSection, height: float, side: int,
    end: EndOnWall | None,
) -> Iterator[tuple[Shape, list[Point]]]:  # fmt: skip
    """The ledges of a web along a flange at one of its ends, -1 the start, so high from the
    flange's outside, and where they end in the web's contour. `end` is a skew one of the web."""
    from shapely import LineString, box, get_coordinates

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
        from shapely import union_all

        for face in {one.stroke.face for one in self.passes}:
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
        """Adds the ledges of the web. At a skew end there are some only where the torch is tilted
        to it."""
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
