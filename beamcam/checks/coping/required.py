"""What has to stay of all walls, surface by surface, with the skew ends of the part.

What a web keeps along a flange at a hole that reaches it: the torch does not come there.

A hole right under a flange that stays, at its end, is cut up to a ledge; that is as high as the
torch over the web keeps off the flange, or as deep as the pass cuts that takes the root with it.
"""

from collections.abc import Collection, Iterator, Mapping, Sequence
from typing import Any

from msgspec import Struct

from beamcam.checks.coping.bevels import BevelPass, passes_of
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
from beamcam.checks.coping.strokes import TorchStroke
from beamcam.checks.coping.wanted import RequiredWall, wanted_on, with_round_corners
from beamcam.geometry.plane import Point
from beamcam.machine.coper import Coper
from beamcam.machine.torch import TorchRow
from beamcam.model.part import Contour, Feature, Part

Shape = Any  #: of shapely

ABOVE = 0.1  #: mm that a ledge is higher than what is cut with the flange
SHORT = 1.0  #: mm; a shorter gap between web and flange is none
FAR = 1e5


def ledges_of(
    web: Shape, flange: Shape, face: str, section: CoperSection, heights: Sequence[float | None],
    ends: Sequence[EndOnWall],
) -> Iterator[tuple[Shape, list[Point]]]:  # fmt: skip
    """The ledges of a web along a flange, and where they end in the web's contour.

    At the start and the end they are so high from the flange's outside, or None where there is
    none. `ends` are skew ones of the web.
    """
    for side, height in zip((-1, 1), heights, strict=True):
        if height is not None:
            end = next((one for one in ends if one.side == side), None)
            yield from _ledges_at(web, flange, face, section, height, side, end)


def _ledges_at(
    web: Shape, flange: Shape, face: str, section: CoperSection, height: float, side: int,
    end: EndOnWall | None,
) -> Iterator[tuple[Shape, list[Point]]]:  # fmt: skip
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
            at = end.at + end.more * inner
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


class WallsAsked(Struct, frozen=True):
    """What has to stay, by face and by mm below it."""

    wanted: Mapping[tuple[str, float], RequiredWall]
    ends: Mapping[str, Sequence[EndOnWall]]  #: skew ends by the faces that they end
    made: Sequence[SkewEnd]  #: those that a tilted torch makes as they are
    off: Mapping[str, float]  #: mm too much by the walls that are cut square
    passes: Sequence[BevelPass] = ()  #: bevels, with the strokes that make them

    def has_bevels_left(self, k: int, feature: Feature, coper: Coper) -> bool:
        """Whether the feature k of a part has bevels that neither an end nor a pass makes."""
        there = [bevel for one in self.passes if one.feature == k for bevel in one.drawn]
        return any(one not in there for one in own_bevels(feature, self.made, coper.min_bevel))


def walls_asked(
    part: Part,
    section: CoperSection,
    coper: Coper,
    rows: Sequence[TorchRow],
    left: Collection[int],
    stock: WallStock,
    strokes: Sequence[TorchStroke],
) -> WallsAsked:
    """What has to stay of a part; `left` are features that are not made."""
    ends = (None, None) if stock.is_piece else skew_ends(part, section)

    def surface(face: str, depth: float, tilted: Sequence[bool]) -> RequiredWall:
        there = ends_on(ends, tilted, face, section, depth)
        return wanted_on(part, face, section, coper, left, stock, there)

    faces = section.faces
    upper = {face: surface(face, 0.0, (True, True)) for face in faces}
    drawn = {face: one.drawn for face, one in upper.items()}
    height = min((row.cut_height for row in rows), default=0.0)
    near = section.near(coper, height)
    tilted = [end is not None and is_tilted(end, drawn, section, coper, near) for end in ends]
    wanted = {(face, 0.0): one for face, one in upper.items()}
    if any(tilted):
        wanted = {
            (face, depth): surface(face, depth, tilted) if depth else upper[face]
            for face in faces for depth in (0.0, section.thickness(face))
        }  # fmt: skip
    off: dict[str, float] = {}
    if not stock.is_piece:
        off |= _with_ledges(wanted, section, rows, near, strokes, ends, tilted)
    widest = max((row.kerf for row in rows), default=0.0)
    for end, is_tilted_to in zip(ends, tilted, strict=True):
        if end is not None and not is_tilted_to:
            by_face = _with_square_end(wanted, end, section, coper, strokes, widest)
            off |= {face: max(mm, off.get(face, 0.0)) for face, mm in by_face.items()}
    on_walls = {face: ends_on(ends, (True, True), face, section, 0.0) for face in faces}
    known = {
        face: [(at, then - at) for at, then, _ in stock.ends[face]] if stock.is_piece
        else [(one.at, one.more) for one in on_walls[face]]
        for face in faces
    }  # fmt: skip
    steps = with_square_roots(wanted, known, section, strokes, widest, coper.corner_radius)
    for face, mm in steps.items():
        off[face] = max(mm, off.get(face, 0.0))
    made = [end for end, yes in zip(ends, tilted, strict=True) if end is not None and yes]
    passes = passes_of(part, section, coper, strokes, made)
    _with_passes(wanted, passes, section)
    told = {face: mm for face, mm in off.items() if mm >= LEAST_OFF}
    return WallsAsked(wanted, on_walls, made, told, passes)


def _with_passes(
    wanted: dict[tuple[str, float], RequiredWall], passes: Sequence[BevelPass],
    section: CoperSection,
) -> None:  # fmt: skip
    """Walls at both surfaces and at the lands of their bevels, without what the bevels take."""
    from shapely import union_all

    for face in {one.stroke.face for one in passes}:
        own = [one for one in passes if one.stroke.face == face]
        outer, thick = wanted[face, 0.0], section.thickness(face)
        inner = wanted.get((face, thick), outer)
        for down in {0.0, thick, *(p.thickness - p.bevel.land for p in own)}:
            # Between both surfaces a skew end lies between where it is at them.
            over, under = outer if down < thick else inner, inner if down > 0.0 else outer
            gone = union_all([bevel.strip(down) for bevel in own])
            drawn, cut, most = (
                areas_of(shape.difference(gone))
                for shape in (
                    over.drawn.intersection(under.drawn),
                    over.cut.intersection(under.cut),
                    over.most.union(under.most),
                )
            )
            wanted[face, down] = RequiredWall(drawn, cut, outer.short, most)


def _with_square_end(
    wanted: dict[tuple[str, float], RequiredWall], end: SkewEnd, section: CoperSection,
    coper: Coper, strokes: Sequence[TorchStroke], widest: float,
) -> dict[str, float]:  # fmt: skip
    """Puts what stays at a skew end that is cut square into `wanted`, on all surfaces that it has;
    gives the mm that are too much, by face. `widest` is the widest kerf."""
    faces, off = section.faces, dict[str, float]()
    depths = {face: _depth(face, end, section, strokes) for face in faces[1:]}
    has_inner = any(depth for _, depth in wanted)
    for inner in (False, True) if has_inner else (False,):
        some = {face: (face, section.thickness(face) if inner else 0.0) for face in faces}
        shapes = {face: wanted[key].drawn for face, key in some.items()}
        more, by_face, steps = as_square(end, shapes, section, coper, depths)
        for face, key in some.items():
            one = wanted[key]
            cut = one.cut.union(more[face])
            most = with_round_corners(one.most.union(cut), steps[face], widest / 2)
            wanted[key] = RequiredWall(more[face], cut, one.short, most)
        off |= {face: max(mm, off.get(face, 0.0)) for face, mm in by_face.items()}
    return off


def _with_ledges(
    wanted: dict[tuple[str, float], RequiredWall],
    section: CoperSection,
    rows: Sequence[TorchRow],
    near: float,
    strokes: Sequence[TorchStroke],
    ends: Sequence[SkewEnd | None],
    tilted: Sequence[bool],
) -> dict[str, float]:
    """Adds the ledges of the web to what is wanted of it; how high they are, by wall.

    At a skew end there are some only where the torch is tilted to it.
    """
    off: dict[str, float] = {}
    widest = max((row.kerf for row in rows), default=0.0)
    for face in section.faces[1:]:
        flange = wanted[face, 0.0].drawn
        deep = _depths_of_roots(face, flange, section, section.flange + near, strokes)
        heights = [deep[k] if end is None or tilted[k] else None for k, end in enumerate(ends)]
        for (one, depth), asked in [*wanted.items()]:
            if one != "v":
                continue
            there = ends_on(ends, tilted, "v", section, depth)
            for ledge, places in ledges_of(asked.drawn, flange, face, section, heights, there):
                asked = wanted[one, depth]
                cut = asked.cut.union(ledge)
                most = with_round_corners(asked.most.union(ledge), places, widest / 2)
                wanted[one, depth] = RequiredWall(asked.drawn.union(ledge), cut, asked.short, most)
                off["v"] = max(*deep) - section.flange
    return off


def _depths_of_roots(
    face: str, flange: Shape, section: CoperSection, least: float, strokes: Sequence[TorchStroke]
) -> tuple[float, float]:
    """How deep passes through a root cut at the start and at the end, square to the flange."""
    back, front = section.root(face)
    bounds = flange.bounds or (0.0,) * 4
    deep = [least, least]
    for stroke in strokes:
        ys = [y for _, y in stroke.points]
        if stroke.face == face and min(ys) <= back and max(ys) >= front:
            k = stroke.points[-1][0] > (bounds[0] + bounds[2]) / 2
            deep[k] = max(deep[k], stroke.row.up_to * stroke.share)
    return deep[0], deep[1]


def _depth(face: str, end: SkewEnd, section: CoperSection, strokes: Sequence[TorchStroke]) -> float:
    """How deep the passes through a root cut near an end, square to the flange."""
    back, front = section.root(face)
    at, more = end.on(face, section, 0.0)
    depth = 0.0
    for stroke in strokes:
        ys = [y for _, y in stroke.points]
        beyond = any(end.side * (x - at - more * y) > 0.0 for x, y in stroke.points)
        if stroke.face == face and beyond and min(ys) <= back and max(ys) >= front:
            depth = max(depth, stroke.row.up_to)
    return depth


def is_outline_of(feature: Feature, off: Mapping[str, float]) -> bool:
    """Whether a feature is an outline of a wall whose skew end is cut square."""
    face = {"h": "v"}.get(getattr(feature, "face", ""), getattr(feature, "face", ""))
    return isinstance(feature, Contour) and feature.kind == "outer" and face in off
