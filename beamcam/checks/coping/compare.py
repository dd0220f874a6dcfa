"""The walls as the strokes leave them, compared with what has to stay of each.

    bar less kerfs -> pieces of each wall -> those of the part lie within what has to stay, and the
    kerfs outside of it -> web and flange hold together where both stay, and nowhere else

A pass through a root cuts the web below its flange as deep as its row of the cut chart says. Where
a skew end has the torch tilted, both surfaces of each wall are looked at: a stroke goes on through
it along the torch.
"""

from collections.abc import Iterator, Sequence
from itertools import dropwhile
from math import atan, cos, radians, tan
from typing import Any

from shapely import LineString, MultiPoint, Polygon, box, intersects, prepare, union_all

from beamcam.checks.coping import rules
from beamcam.checks.coping.bevels import ends_of_passes, pass_faults
from beamcam.checks.coping.chart import SAME_FEED, CoperJob
from beamcam.checks.coping.fillets import FLUSH, beside_web
from beamcam.checks.coping.left import WallPieces, holding_faults, hurt_fault, kept_faults, parted
from beamcam.checks.coping.required import RequiredWalls
from beamcam.checks.coping.section import CoperSection, jet_of, line_of, narrowed, pieces_of
from beamcam.checks.coping.stock import FINE, WallStock
from beamcam.checks.coping.strokes import TorchStroke, in_air
from beamcam.errors import Diagnostic
from beamcam.geometry.plane import Point

Shape = Any  #: of shapely
SLANTED = 2.0  #: mm along the bar by mm across it that a cut through a root goes, at most
ALONG_LIP = 4.0  #: likewise of one through a lip
TWICE = 0.1  #: share of a stroke that is new at least, or it is cut twice
SLIVER = 1e-3  #: mm2 that the offset of an outline with steps of microns may lie outside of it
SURE = 0.01  #: mm that figures of a thickness may be off


class ContourBand:
    """Where strokes run half a kerf off the contour of a surface, as the torch sees it."""

    def __init__(self, kept: Shape, depth: float, kerf: float, share: float, slack: float) -> None:
        self.view, self._depth, self._slack = (kerf, share), depth, slack
        self._seen, self._off = narrowed(kept, share).simplify(FINE / 2), kerf / 2 + slack
        self._along = self._seen.boundary.buffer(self._off)
        prepare(self._along)

    def off(self, stroke: TorchStroke, steel: Shape) -> Point | None:
        """A place of a stroke that runs elsewhere; None without one.

        Its first segment is the lead, and beyond the edges of the wall there is air.
        """
        run = narrowed(line_of(stroke.at(self._depth)[1:]).intersection(steel), stroke.share)
        if self._along.covers(run):
            return None
        # At an edge of its wall a path goes straight on beyond the end of a slanting contour.
        around = self._seen.buffer(self._off, join_style="mitre").difference(self._seen)
        off = run.difference(self._along).difference(around)
        if off.length <= self._slack:
            return None
        x, y = off.representative_point().coords[0]
        return x / stroke.share, y


class WallComparison:
    """The strokes of a program beside what has to stay on each surface of each wall."""

    def __init__(
        self, strokes: Sequence[TorchStroke], required: RequiredWalls, stock: WallStock,
        section: CoperSection, job: CoperJob,
    ) -> None:  # fmt: skip
        self._strokes, self._required, self._stock = strokes, required, stock
        self._section, self._job = section, job
        self._slack = job.coper.tolerance + 2 * job.machine.format.resolution + FINE

    def faults(self) -> Iterator[Diagnostic]:
        """All that strokes make otherwise than required."""
        section, stock, slack, name = self._section, self._stock, self._slack, self._job.name
        left: dict[tuple[str, float], WallPieces] = {}
        for (face, depth), wall in self._required.walls.items():
            if wall.short:
                yield rules.SHORT.at(self._job.at(), found=f"{wall.short:.2f}", face=face)
            own = [stroke for stroke in self._strokes if stroke.face == face]
            gone = taken_of(face, own, self._strokes, section, depth)
            low, high = section.extent(face)
            steel = stock.wall(face).intersection(box(-1e6, low, 1e6, high))
            yield from self._hurt(face, gone, wall.cut)
            left[face, depth] = parted(steel, [surely for surely, _ in gone], wall.drawn, slack)
            yield from kept_faults(face, left[face, depth], wall.most, slack, name)
            if not depth:
                yield from self._on_wall(face, own, steel)
        for face in section.faces[1:]:
            inner = max(depth for one, depth in left if one == face)
            for one, depth in left:
                if one == "v":
                    pair = left[one, depth], left[face, inner]
                    z = min(section.front - depth, section.wide - 1e-3)
                    yield from holding_faults(face, *pair, section, z, slack, name)
        passes = self._required.passes
        far = {s.line: not stock.is_piece and self._is_far(s) for s in self._strokes}
        far |= ends_of_passes(passes, self._strokes, far, section)
        for stroke in self._strokes if section.lip else ():
            if stroke.face != "v":
                yield from self._through_lip(stroke)
        begun = dropwhile(lambda stroke: not far[stroke.line], self._strokes)
        for stroke in (one for one in begun if not far[one.line]):  # behind one of the far end
            yield rules.ORDER.at(self._job.at(stroke.line), face=stroke.face)
            break
        yield from pass_faults(passes, self._strokes, far, section, name)

    def _is_pass(self, stroke: TorchStroke) -> bool:
        """Whether a stroke makes a bevel."""
        return any(one.stroke is stroke for one in self._required.passes)

    def _on_wall(self, face: str, own: Sequence[TorchStroke], steel: Shape) -> Iterator[Diagnostic]:
        """What is wrong with the strokes of a wall, whatever they leave of it."""
        views = {(one.row.kerf, one.share) for one in own if not self._is_pass(one)}
        bands = [
            ContourBand(wall.cut, depth, *view, self._slack)
            for (other, depth), wall in self._required.walls.items() if other == face
            for view in views
        ]  # fmt: skip
        # No arc starts over a hole that is there; on its way it burns on over one.
        solid = steel.difference(self._stock.open[face]) if self._stock.is_piece else steel
        for stroke in own:
            yield from self._stroke_faults(stroke, bands, steel, solid)
        for k, stroke in enumerate(own):  # along what is cut already
            run = line_of(stroke.points)
            for before in own[:k]:
                again = run.intersects(line_of(before.points))
                if again and run.difference(before.jet(0.0)).length < TWICE * run.length:
                    x, y = stroke.points[0]
                    yield rules.EXTRA.at(
                        self._job.at(stroke.line), x=f"{x:.1f}", y=f"{y:.1f}", face=face
                    )

    def _hurt(
        self, face: str, gone: Sequence[tuple[Shape, Shape]], cut: Shape
    ) -> Iterator[Diagnostic]:
        """Steel that has to stay and that a kerf or a pierce takes."""
        low, high = self._section.extent(face)
        kept = cut.intersection(box(-1e6, low, 1e6, high))
        inner = kept.buffer(-self._slack, join_style="mitre")
        prepare(inner)
        for taken in gone:
            if not intersects(inner, taken).any():
                continue
            hurt = union_all(taken).intersection(inner)
            if hurt.area > SLIVER:
                yield hurt_fault(hurt, inner, self._slack, self._job.at(), face)
                return

    def _stroke_faults(
        self, stroke: TorchStroke, bands: Sequence[ContourBand], steel: Shape, solid: Shape
    ) -> Iterator[Diagnostic]:
        """A stroke beside its wall, along no contour of any surface, or at the speed of another
        thickness. `solid` is the steel without the holes that are there."""
        section, coper, source = self._section, self._job.coper, self._job.at(stroke.line)
        low, high = section.extent(stroke.face)
        over = stroke.row.kerf / 2 + coper.over + self._slack
        free = (over, over)
        if stroke.face == "v":
            free = (-stroke.row.kerf / 2, -stroke.row.kerf / 2 if section.has_upper else over)
        (least, most), has_edge = stroke.across, self._is_pass(stroke)  # to stay along
        if not has_edge and (least < low - free[0] or most > high + free[1]):
            y = least if least < low - free[0] else most
            yield rules.PLACE.at(
                source, y=f"{y:g}", face=stroke.face, least=f"{low:g}", most=f"{high:g}"
            )
            return
        if stroke.leans and not has_edge:
            yield rules.ANGLE.at(source, found="off that of its face, along no bevel")
            return
        if not has_edge and (off := self._extra(stroke, bands, steel)) is not None:
            x, y = off
            yield rules.EXTRA.at(source, x=f"{x:.1f}", y=f"{y:.1f}", face=stroke.face)
        lost = in_air(stroke.points[1:], steel, stroke.row, coper)
        if solid.distance(line_of(stroke.points[:1])) > self._slack or lost is not None:
            x, y = lost or stroke.points[0]
            yield rules.AIR.at(source, x=f"{x:.1f}", y=f"{y:.1f}", face=stroke.face)
        least, most = self._thickness(stroke)
        if has_edge:
            deep = section.thickness(stroke.face) / stroke.share
            least, most = deep - SURE, deep + SURE
        feed, rows = stroke.row.feed_mm_min, map(self._job.row_for, (least, most))
        fits = {row.feed_mm_min if row else 0.0 for row in rows}
        between = min(fits) - SAME_FEED < feed < max(fits) + SAME_FEED
        if feed not in fits and not (between and coper.between_rows == "interpolate"):
            expected = " or ".join(f"{feed:g}" for feed in sorted(fits))
            yield rules.FEED.at(
                source, found=f"{feed:g}", thickness=f"{least:.2f}", expected=expected
            )

    def _extra(
        self, stroke: TorchStroke, bands: Sequence[ContourBand], steel: Shape
    ) -> Point | None:
        """A place of a stroke that runs along the contour of no surface; None of any other."""
        first: Point | None = None
        for band in bands:
            if band.view == (stroke.row.kerf, stroke.share):
                if (off := band.off(stroke, steel)) is None:
                    return None
                first = first or off
        return first

    def _thickness(self, stroke: TorchStroke) -> tuple[float, float]:
        """The steel that a stroke has to go through, with what it may be off.

        Through a root that is as deep as from outside of the flange to where cuts over the web end,
        and `root_over` more; through a lip as that is long, and as much more.
        """
        section, (least, most) = self._section, stroke.across
        if stroke.face == "v":
            low, high = section.extent("v")
            ends = (min(max(y, low + SURE), high - SURE) for y in (least, most))
            deep = max(section.web, *(section.steel_through("v", y) for y in ends)) / stroke.share
            return deep - SURE, deep + SURE
        more = self._job.coper.root_over
        back, front = section.root(stroke.face)
        lip = section.lip + more if least < section.bend - SURE else 0.0
        beside = beside_web(stroke, section)
        if beside is not None and (most <= section.back or least >= section.front):
            return beside
        if most <= back or least >= front:
            deep = max(section.flange, lip) / stroke.share
            # Of a tilted torch B is read as it is written, to some decimals.
            return (deep - SURE, deep + SURE) if lip and stroke.is_tilted else (deep, deep)
        over = [y for one in self._strokes if one.face == "v" for y in one.across]
        end = (section.high - max(over) if stroke.face == "o" else min(over)) if over else 0.0
        along = beside[1] if beside is not None else 0.0
        deep = max(max(section.flange, end) + more, lip, along) / stroke.share
        return deep - SURE, deep + SURE

    def _is_far(self, stroke: TorchStroke) -> bool:
        """Whether a stroke is of the far end; of a flange with a lip by that part of it."""
        section, drawn = self._section, self._required.walls[stroke.face, 0.0].drawn
        if section.lip and stroke.face != "v":
            at_lip = stroke.across[0] < 0.0
            band = (0.0, section.bend) if at_lip else (section.bend, section.wide)
            drawn = drawn.intersection(box(-1e6, band[0], 1e6, band[1]))
        bounds = drawn.bounds
        return (bool(bounds) and max(x for x, _ in stroke.points) > bounds[2]) or any(
            end.side > 0 and any(x > end.x(y) for x, y in stroke.points)
            for end in self._required.ends[stroke.face]
        )

    def _through_lip(self, stroke: TorchStroke) -> Iterator[Diagnostic]:
        """A stroke on a flange that, behind its lead, does not go through a lip from side to side,
        or whose torch does not lie in the plane of its end all along the lip."""
        section, source, bend = self._section, self._job.at(stroke.line), self._section.bend
        run = line_of(stroke.points[1:]).intersection(box(-1e6, 0.0, 1e6, bend - SURE))
        crossing = [one.bounds for one in pieces_of(run)]
        if not crossing:
            return
        for x0, y0, x1, y1 in crossing:
            along = x1 - x0 > ALONG_LIP * bend + stroke.row.kerf
            if along or y0 > SURE or y1 < bend - 2 * SURE:
                yield rules.PLACE.at(
                    source, y=f"{y0:g}", face=stroke.face, least=f"{bend:g}",
                    most=f"{section.wide:g}",
                )  # fmt: skip
                return
        x0, y0, x1, y1 = run.bounds
        slope, side = 0.0, 1
        for end in self._required.made:
            line = end.on_wall(stroke.face, section, 0.0)
            long, near = cos(atan(line.more)), stroke.row.kerf / 2 / stroke.share + self._slack
            if all(abs(x - line.x(y)) * long <= near for x, y in stroke.points[1:-1]):
                slope, side = end.on_wall(stroke.face, section, 1.0).at - line.at, end.side
        off = side * section.lip * (-tan(radians(stroke.b_deg)) - slope)
        if abs(off) <= self._slack:
            return
        at = {"face": stroke.face, "x": f"{(x0 + x1) / 2:.1f}", "y": f"{(y0 + y1) / 2:.1f}"}
        if off > 0.0:
            yield rules.LEFT.at(source, found=f"{off:.2f}", **at)
        else:
            yield rules.HURT.at(source, found=f"{-off:.2f}", expected=f"{self._slack:.2f}", **at)


def taken_of(
    face: str, own: Sequence[TorchStroke], strokes: Sequence[TorchStroke], section: CoperSection,
    depth: float = 0.0,
) -> list[tuple[Shape, Shape]]:  # fmt: skip
    """What each stroke takes of a wall, so far below its face: surely, and what it may take more.

    `own` are those on its face.
    """
    taken = [(stroke.jet(depth), stroke.pierced(depth)) for stroke in own]
    if face == "v":
        taken += [cut for stroke in strokes for cut in _below(stroke, section, depth)]
    return taken


def _below(
    stroke: TorchStroke, section: CoperSection, depth: float
) -> Iterator[tuple[Shape, Shape]]:
    """What a stroke on a flange takes of the web below it, so far below the web's face.

    It goes on along the torch. What does not go through all of the web may take all that it meets.
    """
    half, low, high = stroke.row.kerf / 2, section.back, section.front
    deep = stroke.row.up_to * stroke.share
    if stroke.face == "v" or deep <= section.flange:
        return
    downs = section.flange, deep
    ys = [section.high - down if stroke.face == "o" else down for down in downs]
    if stroke.leans:
        yield Polygon(), _met_off(stroke, section, downs, ys, high - depth)
        return
    back = [down * tan(radians(stroke.b_deg)) for down in downs]
    run = line_of(stroke.points[1:])
    z = high - depth
    over_web = box(-1e6, low - half + FLUSH, 1e6, high + half - FLUSH)
    for one in pieces_of(run.intersection(over_web)):
        kerf = jet_of([*one.coords], half, stroke.share)
        through = one.bounds[1] <= low + 1e-6 and one.bounds[3] >= high - 1e-6
        across = kerf.intersection(LineString([(-1e6, z), (1e6, z)])) if through else kerf
        x0, _, x1, _ = across.bounds
        met = Polygon([
            (x0 - back[0], ys[0]), (x1 - back[0], ys[0]), (x1 - back[1], ys[1]),
            (x0 - back[1], ys[1]),
        ])  # fmt: skip
        least = one.intersection(box(-1e6, low, 1e6, high)).bounds
        along = bool(least) and least[2] - least[0] > SLANTED * (high - low) + 2 * half
        yield met if through and not along else Polygon(), met


def _met_off(
    stroke: TorchStroke, section: CoperSection, downs: tuple[float, float],
    ys: Sequence[float], z: float,
) -> Shape:  # fmt: skip
    """What a stroke whose A is off its face may take of the web below it at most, at z of it; all
    that it meets of the web where it does not go across it."""
    places = []
    for down, y in zip(downs, ys, strict=True):
        jet = stroke.jet(down)
        is_across = jet.bounds[1] <= section.back and jet.bounds[3] >= section.front
        met = jet.intersection(
            LineString([(-1e6, z), (1e6, z)]) if is_across
            else box(-1e6, section.back, 1e6, section.front)
        )  # fmt: skip
        if not met.is_empty:
            places += [(met.bounds[0], y), (met.bounds[2], y)]
    return MultiPoint(places).convex_hull if len(places) > 2 else Polygon()
