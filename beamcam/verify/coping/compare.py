"""The walls as the strokes leave them, compared with what has to stay of each.

    bar less kerfs -> pieces of each wall -> those of the part lie within what is wanted, and the
    kerfs outside of it -> web and flange hold together where both stay, and nowhere else

A pass through a root cuts the web below its flange as deep as its row of the cut chart says.
"""

from collections.abc import Iterator, Mapping, Sequence
from typing import Any

from msgspec import Struct

from beamcam.errors import Diagnostic, Source
from beamcam.machine.coper import Coper
from beamcam.machine.torch import TorchRow
from beamcam.verify.coping import rules
from beamcam.verify.coping.rings import FINE
from beamcam.verify.coping.section import ARC, Section, kerf_of, line_of, pieces_of
from beamcam.verify.coping.stock import Stock
from beamcam.verify.coping.strokes import Stroke
from beamcam.verify.coping.wanted import Wanted

Shape = Any  #: of shapely
SPECK = 0.05  #: mm2 that is nothing
TWICE = 0.1  #: share of a stroke that is new at least, or it is cut twice
SURE = 0.01  #: mm that figures of a thickness may be off


class Left(Struct, frozen=True):
    """What is left of a wall: the pieces of the part, and the others."""

    part: Shape
    scrap: Shape


def compare(
    strokes: Sequence[Stroke],
    wanted: Mapping[str, Wanted],
    stock: Stock,
    section: Section,
    coper: Coper,
    rows: Sequence[TorchRow],
    step: float,
    name: str,
) -> Iterator[Diagnostic]:
    """All that strokes make otherwise than wanted."""
    slack = coper.tolerance + 2 * step + FINE
    left: dict[str, Left] = {}
    for face in section.faces:
        if wanted[face].short:
            yield rules.SHORT.at(Source(name), found=f"{wanted[face].short:.2f}", face=face)
        own = [stroke for stroke in strokes if stroke.face == face]
        gone = taken_of(face, own, strokes, section)
        yield from _hurt(face, gone, wanted[face].cut, section, slack, name)
        left[face] = _left(face, gone, wanted[face].drawn, stock, section, slack)
        yield from _standing(face, left[face], wanted[face].cut, slack, name)
        for stroke in own:
            yield from _stroke_faults(
                stroke, strokes, wanted[face].cut, stock, section, coper, rows, slack, name
            )
        yield from _twice(face, own, name)
    for face in section.faces[1:]:
        yield from _holding(face, left, section, slack, name)
    if not stock.is_piece:
        yield from _order_faults(strokes, wanted, name)


def taken_of(
    face: str, own: Sequence[Stroke], strokes: Sequence[Stroke], section: Section
) -> list[tuple[Shape, Shape]]:
    """What each stroke takes of a wall: surely, and at most; `own` are those on its face."""
    from shapely import Point, union_all

    found: list[tuple[Shape, Shape]] = []
    for stroke in own:
        kerf = kerf_of(stroke.points, stroke.row.kerf / 2)
        pierced = Point(stroke.points[0]).buffer(stroke.row.pierce_radius, ARC)
        found.append((kerf, union_all([kerf, pierced])))
    if face == "v":
        found += [cut for stroke in strokes for cut in _below(stroke, section)]
    return found


def _below(stroke: Stroke, section: Section) -> Iterator[tuple[Shape, Shape]]:
    """What a stroke on a flange takes of the web below it."""
    from shapely import box

    if stroke.face == "v":
        return
    half, deep = stroke.row.kerf / 2, stroke.row.up_to - section.flange
    low, high = section.web_ends
    ends = (high - deep, high) if stroke.face == "o" else (low, low + deep)
    web = box(-1e6, section.back, 1e6, section.front)
    over = box(-1e6, section.back - half, 1e6, section.front + half)
    run = line_of(stroke.points)
    crossed = run.intersection(web)
    for one in pieces_of(run.intersection(over)):
        if deep <= 0.0:
            continue
        least, _, most, _ = one.bounds
        at_most = box(least - half, ends[0], most + half, ends[1])
        surely = box(0.0, 0.0, 0.0, 0.0)
        for piece in pieces_of(crossed):
            if not piece.intersects(one):
                continue
            x0, y0, x1, y1 = piece.bounds
            if y0 <= section.back + 1e-6 and y1 >= section.front - 1e-6 and x1 - x0 < 2 * half:
                surely = box(x1 - half, ends[0], x0 + half, ends[1])
        yield surely, at_most


def _hurt(
    face: str,
    gone: Sequence[tuple[Shape, Shape]],
    wanted: Shape,
    section: Section,
    slack: float,
    name: str,
) -> Iterator[Diagnostic]:
    """Steel that has to stay and that a kerf or a pierce takes."""
    from shapely import box

    low, high = section.extent(face)
    kept = wanted.intersection(box(-1e6, low, 1e6, high))
    inner = kept.buffer(-slack, join_style="mitre")
    for _, at_most in gone:
        hurt = at_most.intersection(inner)
        if hurt.area > 0.0:
            x, y = hurt.representative_point().coords[0]
            deep = slack + max(inner.boundary.distance(line_of([p])) for p in _outline(hurt))
            yield rules.HURT.at(
                Source(name), found=f"{deep:.2f}", face=face, x=f"{x:.1f}", y=f"{y:.1f}",
                expected=f"{slack:.2f}",
            )  # fmt: skip
            return


def _outline(shape: Shape) -> list[tuple[float, float]]:
    from shapely import get_coordinates

    return [tuple(p) for p in get_coordinates(shape).tolist()]


def _left(
    face: str,
    gone: Sequence[tuple[Shape, Shape]],
    drawn: Shape,
    stock: Stock,
    section: Section,
    slack: float,
) -> Left:
    """The pieces of a wall of the bar, or of the piece, after all strokes."""
    from shapely import MultiPolygon, box, union_all

    low, high = section.extent(face)
    bar = stock.wall(face).intersection(box(-1e6, low, 1e6, high))
    rest = bar.difference(union_all([surely for surely, _ in gone])) if gone else bar
    pieces = [p for p in pieces_of(rest) if p.area > SPECK]
    core = drawn.intersection(bar).buffer(-2 * slack, join_style="mitre")
    mine = [p for p in pieces if p.intersection(core).area > SPECK]
    others = [p for p in pieces if not any(p is one for one in mine)]
    return Left(MultiPolygon(mine), MultiPolygon(others))


def _standing(
    face: str, left: Left, wanted: Shape, slack: float, name: str
) -> Iterator[Diagnostic]:
    """Scrap that holds to the part."""
    if left.part.is_empty:
        yield rules.GONE.at(Source(name), face=face)
        return
    over = left.part.difference(wanted.buffer(slack, join_style="mitre"))
    for piece in pieces_of(over):
        if piece.area > SPECK:
            far = max(wanted.distance(line_of([p])) for p in _outline(piece))
            x, y = piece.representative_point().coords[0]
            yield rules.LEFT.at(
                Source(name), found=f"{far:.2f}", face=face, x=f"{x:.1f}", y=f"{y:.1f}"
            )
            return


def _holding(
    face: str, left: Mapping[str, Left], section: Section, slack: float, name: str
) -> Iterator[Diagnostic]:
    """Scrap of the web that a flange of the part holds, or the other way round."""
    from shapely import LineString, force_2d, transform

    y = section.web_ends[1] - 1e-3 if face == "o" else section.web_ends[0] + 1e-3
    along = LineString([(-1e6, y), (1e6, y)])
    middle = LineString([(-1e6, (section.back + section.front) / 2),
                         (1e6, (section.back + section.front) / 2)])  # fmt: skip

    def flat(shape: Shape) -> Shape:
        """Stretches along x, whatever their y."""

        def to_axis(points: Any) -> Any:
            points = points.copy()
            points[:, 1] = 0.0
            return points

        return transform(force_2d(shape), to_axis)

    web, flange = left["v"], left[face]
    for scrap, other, names in (
        (web.scrap, flange.part, ("v", face)), (flange.scrap, web.part, (face, "v"))
    ):  # fmt: skip
        lines = (along, middle) if names[0] == "v" else (middle, along)
        held = flat(scrap.intersection(lines[0])).intersection(flat(other.intersection(lines[1])))
        if held.length > 2 * slack:
            yield rules.HOLDS.at(
                Source(name), scrap=names[0], face=names[1], found=f"{held.length:.2f}",
                x=f"{held.bounds[0]:.1f}",
            )  # fmt: skip


def _stroke_faults(
    stroke: Stroke,
    strokes: Sequence[Stroke],
    wanted: Shape,
    stock: Stock,
    section: Section,
    coper: Coper,
    rows: Sequence[TorchRow],
    slack: float,
    name: str,
) -> Iterator[Diagnostic]:
    """A stroke beside its wall, along no contour, or at the speed of another thickness."""
    from shapely import box

    source = Source(name, stroke.line)
    low, high = section.extent(stroke.face)
    over = stroke.row.kerf / 2 + coper.over + slack
    free = (over, over)
    if stroke.face == "v":
        free = (-stroke.row.kerf / 2, -stroke.row.kerf / 2 if section.has_upper else over)
    ys = [y for _, y in stroke.points]
    if min(ys) < low - free[0] or max(ys) > high + free[1]:
        y = min(ys) if min(ys) < low - free[0] else max(ys)
        yield rules.PLACE.at(
            source, y=f"{y:g}", face=stroke.face, least=f"{low:g}", most=f"{high:g}"
        )
        return
    steel = stock.wall(stroke.face).intersection(box(-1e6, low, 1e6, high))
    off = _off_contour(stroke, wanted, steel, slack)
    if off is not None:
        x, y = off
        yield rules.EXTRA.at(source, x=f"{x:.1f}", y=f"{y:.1f}", face=stroke.face)
    x, y = stroke.points[0]
    lost = _in_air(stroke, steel, coper.over)
    # No arc starts over a hole that is there; on its way it burns on over one, as the plan said.
    solid = steel.difference(stock.open[stroke.face]) if stock.is_piece else steel
    if solid.distance(line_of([(x, y)])) > slack or lost is not None:
        x, y = lost or (x, y)
        yield rules.AIR.at(source, x=f"{x:.1f}", y=f"{y:.1f}", face=stroke.face)
    least, most = _thickness(stroke, strokes, section, coper)
    rising = sorted(rows, key=lambda row: row.up_to)
    fits = {next((r.feed_mm_min for r in rising if r.up_to >= t), 0.0) for t in (least, most)}
    if stroke.row.feed_mm_min not in fits:
        expected = " or ".join(f"{feed:g}" for feed in sorted(fits))
        yield rules.FEED.at(
            source, found=f"{stroke.row.feed_mm_min:g}", thickness=f"{least:.2f}",
            expected=expected,
        )  # fmt: skip


def _in_air(stroke: Stroke, steel: Shape, over: float) -> tuple[float, float] | None:
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


def _twice(face: str, own: Sequence[Stroke], name: str) -> Iterator[Diagnostic]:
    """A stroke along what is cut already."""
    for k, stroke in enumerate(own):
        run = line_of(stroke.points)
        for before in own[:k]:
            if not run.intersects(line_of(before.points)):
                continue
            again = run.difference(kerf_of(before.points, before.row.kerf / 2))
            if again.length < TWICE * run.length:
                x, y = stroke.points[0]
                yield rules.EXTRA.at(
                    Source(name, stroke.line), x=f"{x:.1f}", y=f"{y:.1f}", face=face
                )


def _off_contour(
    stroke: Stroke, wanted: Shape, steel: Shape, slack: float
) -> tuple[float, float] | None:
    """A place of a stroke that keeps no half a kerf off a contour; None if there is none.

    Its first stretch is the lead, and beyond the edges of the wall there is air.
    """
    near = wanted.boundary.buffer(stroke.row.kerf / 2 + slack)
    off = line_of(stroke.points[1:]).intersection(steel).difference(near)
    if off.length <= slack:
        return None
    x, y = off.representative_point().coords[0]
    return x, y


def _thickness(
    stroke: Stroke, strokes: Sequence[Stroke], section: Section, coper: Coper
) -> tuple[float, float]:
    """The steel that a stroke has to go through, with what it may be off.

    Through a root that is as deep as from outside of the flange to where cuts over the web end, and
    `root_over` more.
    """
    ys = [y for _, y in stroke.points]
    if stroke.face == "v":
        low, high = section.extent("v")
        ends = (min(max(y, low + SURE), high - SURE) for y in (min(ys), max(ys)))
        deep = max(section.web, *(section.steel_through("v", y) for y in ends))
        return deep - SURE, deep + SURE
    back, front = section.root(stroke.face)
    if max(ys) <= back or min(ys) >= front:
        return section.flange, section.flange
    over = [y for one in strokes if one.face == "v" for _, y in one.points]
    end = (section.high - max(over) if stroke.face == "o" else min(over)) if over else 0.0
    deep = max(section.flange, end) + coper.root_over
    return deep - SURE, deep + SURE


def _order_faults(
    strokes: Sequence[Stroke], wanted: Mapping[str, Wanted], name: str
) -> Iterator[Diagnostic]:
    """Cuts of anything else behind the first one of the far end."""
    parting = False
    for stroke in strokes:
        ends = wanted[stroke.face].drawn.bounds
        is_far = bool(ends) and max(x for x, _ in stroke.points) > ends[2]
        if parting and not is_far:
            yield rules.ORDER.at(Source(name, stroke.line), face=stroke.face)
            return
        parting = parting or is_far
