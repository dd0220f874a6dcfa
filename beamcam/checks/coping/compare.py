"""The walls as the strokes leave them, compared with what has to stay of each.

    bar less kerfs -> pieces of each wall -> those of the part lie within what is wanted, and the
    kerfs outside of it -> web and flange hold together where both stay, and nowhere else

A pass through a root cuts the web below its flange as deep as its row of the cut chart says. Where
a skew end has the torch tilted, both surfaces of each wall are looked at: a stroke goes on through
it along the torch.
"""

from collections.abc import Iterator, Mapping, Sequence
from math import radians, tan
from typing import Any

from beamcam.checks.coping import rules
from beamcam.checks.coping.bevels import BevelPass, ends_of_passes, pass_faults
from beamcam.checks.coping.chart import SAME_FEED, row_for
from beamcam.checks.coping.contour_bands import ContourBand, extra_at
from beamcam.checks.coping.fillets import FLUSH, beside_web
from beamcam.checks.coping.left import (
    WallPieces,
    holding_faults,
    kept_faults,
    outline_of,
    parted,
)
from beamcam.checks.coping.lips import lip_faults
from beamcam.checks.coping.section import CoperSection, jet_of, line_of, pieces_of
from beamcam.checks.coping.skew import EndOnWall, SkewEnd
from beamcam.checks.coping.stock import FINE, WallStock
from beamcam.checks.coping.strokes import TorchStroke
from beamcam.checks.coping.wanted import RequiredWall
from beamcam.errors import Diagnostic, Source
from beamcam.machine.coper import Coper
from beamcam.machine.torch import TorchRow

Shape = Any  #: of shapely
Surface = tuple[str, float]  #: a face, and how far below it
SLANTED = 2.0  #: mm along the bar by mm across it that a cut through a root goes, at most
TWICE = 0.1  #: share of a stroke that is new at least, or it is cut twice
SLIVER = 1e-3  #: mm2 that the offset of an outline with steps of microns may lie outside of it
SURE = 0.01  #: mm that figures of a thickness may be off


def compare(
    strokes: Sequence[TorchStroke],
    wanted: Mapping[Surface, RequiredWall],
    ends: Mapping[str, Sequence[EndOnWall]],
    made: Sequence[SkewEnd],
    passes: Sequence[BevelPass],
    stock: WallStock,
    section: CoperSection,
    coper: Coper,
    rows: Sequence[TorchRow],
    step: float,
    name: str,
) -> Iterator[Diagnostic]:
    """All that strokes make otherwise than wanted on each surface; `ends` are skew ones by wall,
    `made` those that a tilted torch makes, `passes` the strokes that make bevels."""
    from shapely import box

    slack = coper.tolerance + 2 * step + FINE
    left: dict[Surface, WallPieces] = {}
    for (face, depth), asked in wanted.items():
        if asked.short:
            yield rules.SHORT.at(Source(name), found=f"{asked.short:.2f}", face=face)
        own = [stroke for stroke in strokes if stroke.face == face]
        gone = taken_of(face, own, strokes, section, depth)
        low, high = section.extent(face)
        steel = stock.wall(face).intersection(box(-1e6, low, 1e6, high))
        yield from _hurt(face, gone, asked.cut, section, slack, name)
        left[face, depth] = parted(steel, [surely for surely, _ in gone], asked.drawn, slack)
        yield from kept_faults(face, left[face, depth], asked.most, slack, name)
        if depth:
            continue
        views = {(stroke.row.kerf, stroke.share) for stroke in own if not is_pass(stroke, passes)}
        beside = {
            (d, *view): ContourBand(one.cut, *view, slack)
            for (other, d), one in wanted.items() if other == face for view in views
        }  # fmt: skip
        # No arc starts over a hole that is there; on its way it burns on over one.
        solid = steel.difference(stock.open[face]) if stock.is_piece else steel
        for stroke in own:
            yield from _stroke_faults(
                stroke, strokes, beside, passes, steel, solid, section, coper, rows, slack, name
            )
        yield from _twice(face, own, name)
    for face in section.faces[1:]:
        inner = max(depth for one, depth in left if one == face)
        for one, depth in left:
            if one == "v":
                pair = left[one, depth], left[face, inner]
                z = min(section.front - depth, section.wide - 1e-3)
                yield from holding_faults(face, *pair, section, z, slack, name)
    far = {s.line: not stock.is_piece and _is_far(s, wanted, ends, section) for s in strokes}
    far |= ends_of_passes(passes, strokes, far, section)
    for stroke in strokes if section.lip else ():
        if stroke.face != "v":
            yield from lip_faults(stroke, made, section, slack, Source(name, stroke.line))
    yield from _order_faults(strokes, far, name)
    yield from pass_faults(passes, strokes, far, section, name)


def taken_of(
    face: str, own: Sequence[TorchStroke], strokes: Sequence[TorchStroke], section: CoperSection,
    depth: float = 0.0,
) -> list[tuple[Shape, Shape]]:  # fmt: skip
    """What each stroke takes of a wall, so far below its face: surely, and what it may take more.

    `own` are those on its face.
    """
    found = [(stroke.jet(depth), stroke.pierced(depth)) for stroke in own]
    if face == "v":
        found += [cut for stroke in strokes for cut in _below(stroke, section, depth)]
    return found


def _below(
    stroke: TorchStroke, section: CoperSection, depth: float
) -> Iterator[tuple[Shape, Shape]]:
    """What a stroke on a flange takes of the web below it, so far below the web's face.

    It goes on along the torch. What does not go through all of the web may take all that it meets.
    """
    from shapely import LineString, Polygon, box

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
    from shapely import LineString, MultiPoint, Polygon, box

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


def _hurt(
    face: str,
    gone: Sequence[tuple[Shape, Shape]],
    wanted: Shape,
    section: CoperSection,
    slack: float,
    name: str,
) -> Iterator[Diagnostic]:
    """Steel that has to stay and that a kerf or a pierce takes."""
    from shapely import box, intersects, prepare, union_all

    low, high = section.extent(face)
    kept = wanted.intersection(box(-1e6, low, 1e6, high))
    inner = kept.buffer(-slack, join_style="mitre")
    prepare(inner)
    for taken in gone:
        if not intersects(inner, taken).any():
            continue
        hurt = union_all(taken).intersection(inner)
        if hurt.area > SLIVER:
            x, y = hurt.representative_point().coords[0]
            deep = slack + max(inner.boundary.distance(line_of([p])) for p in outline_of(hurt))
            yield rules.HURT.at(
                Source(name), found=f"{deep:.2f}", face=face, x=f"{x:.1f}", y=f"{y:.1f}",
                expected=f"{slack:.2f}",
            )  # fmt: skip
            return


def _stroke_faults(
    stroke: TorchStroke,
    strokes: Sequence[TorchStroke],
    beside: Mapping[tuple[float, float, float], ContourBand],
    passes: Sequence[BevelPass],
    steel: Shape,
    solid: Shape,
    section: CoperSection,
    coper: Coper,
    rows: Sequence[TorchRow],
    slack: float,
    name: str,
) -> Iterator[Diagnostic]:
    """A stroke beside its wall, along no contour of any surface, or at the speed of another
    thickness.

    `beside` is where a stroke may run, by mm below the face, its kerf and its `share`, `solid` the
    steel without the holes that are there.
    """
    source = Source(name, stroke.line)
    low, high = section.extent(stroke.face)
    over = stroke.row.kerf / 2 + coper.over + slack
    free = (over, over)
    if stroke.face == "v":
        free = (-stroke.row.kerf / 2, -stroke.row.kerf / 2 if section.has_upper else over)
    ys = [y for _, y in stroke.points]
    has_edge = is_pass(stroke, passes)  # to stay along
    if not has_edge and (min(ys) < low - free[0] or max(ys) > high + free[1]):
        y = min(ys) if min(ys) < low - free[0] else max(ys)
        yield rules.PLACE.at(
            source, y=f"{y:g}", face=stroke.face, least=f"{low:g}", most=f"{high:g}"
        )
        return
    if stroke.leans and not has_edge:
        yield rules.ANGLE.at(source, found="off that of its face, along no bevel")
        return
    if not has_edge and (off := extra_at(stroke, beside, steel, slack)) is not None:
        x, y = off
        yield rules.EXTRA.at(source, x=f"{x:.1f}", y=f"{y:.1f}", face=stroke.face)
    x, y = stroke.points[0]
    lost = _in_air(stroke, steel, coper.over)
    if solid.distance(line_of([(x, y)])) > slack or lost is not None:
        x, y = lost or (x, y)
        yield rules.AIR.at(source, x=f"{x:.1f}", y=f"{y:.1f}", face=stroke.face)
    least, most = _thickness(stroke, strokes, section, coper)
    if has_edge:
        deep = section.thickness(stroke.face) / stroke.share
        least, most = deep - SURE, deep + SURE
    found = (row_for(rows, coper, thickness) for thickness in (least, most))
    fits = {row.feed_mm_min if row else 0.0 for row in found}
    between = min(fits) - SAME_FEED < stroke.row.feed_mm_min < max(fits) + SAME_FEED
    if stroke.row.feed_mm_min not in fits and not (between and coper.between_rows == "interpolate"):
        expected = " or ".join(f"{feed:g}" for feed in sorted(fits))
        yield rules.FEED.at(
            source, found=f"{stroke.row.feed_mm_min:g}", thickness=f"{least:.2f}",
            expected=expected,
        )  # fmt: skip


def _in_air(stroke: TorchStroke, steel: Shape, over: float) -> tuple[float, float] | None:
    """A place of a stroke in air, but just beyond the edges where it begins and ends; or None.

    Where its lead begins on an edge it goes on beside that edge to the contour.
    """
    from shapely import Point

    run = line_of(stroke.points[1:])
    ends = [Point(stroke.points[1]), Point(stroke.points[-1])]
    for air in pieces_of(run.difference(steel.buffer(stroke.row.kerf / 4))):
        at_end = any(air.distance(end) <= SURE for end in ends)
        if air.length > (over + 3 * stroke.row.kerf if at_end else stroke.row.kerf):
            x, y = air.representative_point().coords[0]
            return x, y
    return None


def _twice(face: str, own: Sequence[TorchStroke], name: str) -> Iterator[Diagnostic]:
    """A stroke along what is cut already."""
    for k, stroke in enumerate(own):
        run = line_of(stroke.points)
        for before in own[:k]:
            if not run.intersects(line_of(before.points)):
                continue
            again = run.difference(before.jet(0.0))
            if again.length < TWICE * run.length:
                x, y = stroke.points[0]
                yield rules.EXTRA.at(
                    Source(name, stroke.line), x=f"{x:.1f}", y=f"{y:.1f}", face=face
                )


def is_pass(stroke: TorchStroke, passes: Sequence[BevelPass]) -> bool:
    """Whether a stroke makes a bevel."""
    return any(one.stroke is stroke for one in passes)


def _thickness(
    stroke: TorchStroke, strokes: Sequence[TorchStroke], section: CoperSection, coper: Coper
) -> tuple[float, float]:
    """The steel that a stroke has to go through, with what it may be off.

    Through a root that is as deep as from outside of the flange to where cuts over the web end, and
    `root_over` more; through a lip as that is long, and as much more.
    """
    ys = [y for _, y in stroke.points]
    if stroke.face == "v":
        low, high = section.extent("v")
        ends = (min(max(y, low + SURE), high - SURE) for y in (min(ys), max(ys)))
        deep = max(section.web, *(section.steel_through("v", y) for y in ends)) / stroke.share
        return deep - SURE, deep + SURE
    back, front = section.root(stroke.face)
    lip = section.lip + coper.root_over if min(ys) < section.bend - SURE else 0.0
    beside = beside_web(stroke, section)
    if beside is not None and (max(ys) <= section.back or min(ys) >= section.front):
        return beside
    if max(ys) <= back or min(ys) >= front:
        deep = max(section.flange, lip) / stroke.share
        # Of a tilted torch B is read as it is written, to some decimals.
        return (deep - SURE, deep + SURE) if lip and stroke.is_tilted else (deep, deep)
    over = [y for one in strokes if one.face == "v" for _, y in one.points]
    end = (section.high - max(over) if stroke.face == "o" else min(over)) if over else 0.0
    along = beside[1] if beside is not None else 0.0
    deep = max(max(section.flange, end) + coper.root_over, lip, along) / stroke.share
    return deep - SURE, deep + SURE


def _is_far(
    stroke: TorchStroke,
    wanted: Mapping[Surface, RequiredWall],
    ends: Mapping[str, Sequence[EndOnWall]],
    section: CoperSection,
) -> bool:
    """Whether a stroke is of the far end; of a flange with a lip by where that part of it ends."""
    from shapely import box

    drawn = wanted[stroke.face, 0.0].drawn
    if section.lip and stroke.face != "v":
        at_lip = min(y for _, y in stroke.points) < 0.0
        band = (0.0, section.bend) if at_lip else (section.bend, section.wide)
        drawn = drawn.intersection(box(-1e6, band[0], 1e6, band[1]))
    bounds = drawn.bounds
    return (bool(bounds) and max(x for x, _ in stroke.points) > bounds[2]) or any(
        end.side > 0 and any(x > end.at + end.more * y for x, y in stroke.points)
        for end in ends[stroke.face]
    )


def _order_faults(
    strokes: Sequence[TorchStroke], far: Mapping[int, bool], name: str
) -> Iterator[Diagnostic]:
    """Cuts of anything else behind the first one of the far end."""
    parting = False
    for stroke in strokes:
        if parting and not far[stroke.line]:
            yield rules.ORDER.at(Source(name, stroke.line), face=stroke.face)
            return
        parting = parting or far[stroke.line]
