"""The roots of a web: where a cut over it meets one through a flange, at one x or in one plane.

   x: a cut of the flange, and below it one of the web; the root between them goes with the
___|___   flange. What is cut of the root otherwise (along it, or of one wall alone) cannot be
   |      made: the flange would be hurt, or the scrap would hold.

At a skew end both lie in its plane, in which a pass from outside of the flange goes on.

Holes of a web right under a flange that stays, at its square end: weld access holes.

________ o        The torch over the web comes no nearer to the flange than `near`, and a pass
####|    |        through the root cuts as deep as its row. What is left there is a ledge (####);
    '--. | hole   it goes on to the end of the flange, where the root is cut with it.
web    |
"""

from collections.abc import Iterator, Mapping, Sequence
from itertools import pairwise, product
from math import atan, degrees, radians, tan

from msgspec import Struct
from msgspec.structs import replace
from shapely import LineString, Polygon

from beamcam.errors import Diagnostic, Source
from beamcam.geometry.curves import Point
from beamcam.machine.coper import Coper
from beamcam.model.part import Face
from beamcam.planning.coping import rules
from beamcam.planning.coping.cuts import borders_of, chains_of
from beamcam.planning.coping.ends import STEEPEST_DEG, is_on
from beamcam.planning.coping.fillets import ways_beside
from beamcam.planning.coping.regions import OUTLINE_NOISE, Shape, WallRegion, polygons_of
from beamcam.planning.coping.walls import EDGE, EndLine, PlannedWall, Root

SHARE = 0.5  #: of the tolerance, that web and flange may differ by at a root
FAR = 1e5  #: mm beyond any bar
ALONG_LIP = 4.0  #: mm along the bar by mm across it that a cut through a lip goes, at most


class Crossing(Struct, frozen=True):
    """A cut through the whole of a root, square to the bar or in the plane of an end."""

    x: float
    right: bool  #: whether the scrap lies at greater x
    square: bool = True  #: to the bar
    end: int | None = None  #: in whose plane it lies, 0 at the start


def crossings(
    region: WallRegion, band: tuple[float, float], coper: Coper
) -> tuple[list[Crossing], list[tuple[Point, ...]]]:
    """The cuts through a band of a wall, along x, and the paths by which it is cut otherwise."""
    crossings: list[Crossing] = []
    wrong: list[tuple[Point, ...]] = []
    for chain in chains_of(region.shape, borders_of(region.wall, *band, -EDGE)):
        xs = [x for x, _ in chain.points]
        whole = {chain.start, chain.end} == {"low", "high"}
        near = SHARE * coper.tolerance
        end = next(
            (k for k, line in enumerate(region.wall.skew)
             if line and all(abs(x - line.x(y)) <= near for x, y in chain.points)),
            None,
        )  # fmt: skip
        square = max(xs) - min(xs) <= near
        if not whole or (end is None and not square):
            wrong.append(chain.points)
            continue
        # The region lies on the left of its ring: upwards, the scrap is at greater x.
        crossings.append(Crossing((max(xs) + min(xs)) / 2, chain.start == "low", square, end))
    return sorted(crossings, key=lambda one: one.x), wrong


def through_flange(
    flange: WallRegion, coper: Coper
) -> tuple[list[Crossing], list[tuple[Point, ...]], tuple[float, float]]:
    """The cuts through a flange where its web stands, as `crossings`, and in which band: over web
    and fillets, or where one runs along the web, over that alone."""
    wall = flange.wall
    (behind,) = wall.roots
    band = max(EDGE, behind.low), min(wall.width - EDGE, behind.high)
    on_flange, wrong = crossings(flange, band, coper)
    if wrong and behind.stands is not None:
        low, high = max(behind.stands[0], 0.0) + EDGE, min(behind.stands[1], wall.width) - EDGE
        if wall.skew == (None, None):
            return *crossings(flange, (low, high), coper), (low, high)
        ys = [[y for _, y in way] for way in wrong]
        wrong = [way for way, of in zip(wrong, ys, strict=True) if max(of) > low and min(of) < high]
    return on_flange, wrong, band


def root_faults(
    regions: Mapping[Face, WallRegion], depths: Mapping[int | None, float],
    deeper: Mapping[Face, float], coper: Coper, source: Source,
) -> Iterator[Diagnostic]:  # fmt: skip
    """What cannot be cut at the roots of a web.

    `depths` are those to which a pass through a root may cut, from outside of the flange: what it
    meets of the web has to be cut at that x anyway, or in the plane of the end that it is tilted
    to (0 at the start). `deeper` are those to which one cuts that runs along the web as well.
    """
    web = regions["v"]
    for root in web.wall.roots:
        flange = regions[root.face]
        depth = max(depths[None], deeper.get(root.face, 0.0))
        across = root.inside(depth)
        on_web, wrong = crossings(web, across, coper)
        for end in depths.keys() - {None}:  # which counts there, be it more or less
            own = [one for one in crossings(web, root.inside(depths[end]), coper)[0]
                   if one.end == end]  # fmt: skip
            before = [one for one in on_web if one.end == end]
            on_web = [one for one in on_web if one.end != end] + own
            line = web.wall.skew[end or 0]
            if own and line is not None:
                wrong = [way for way in wrong if not any(is_on(line, (at,)) for at in way)]
            elif before:
                wrong += [((one.x, 0.0),) for one in before]
        deep = max(root.high - root.low, depth)
        clear = f"{deep + 2 * EDGE:.1f} mm off the outside of face {root.face} at least"
        on_flange, others, band = through_flange(flange, coper)
        there = [one.x for one in on_flange] + [x for way in others for x, _ in way]
        alone = [way for way in wrong if all(abs(x - way[0][0]) > flange.wall.width for x in there)]
        yield from _otherwise(wrong, web.wall, across, clear, root.face, source, alone)
        over = f"clear of y {band[0]:.1f} to {band[1]:.1f}, where the web stands"
        yield from _otherwise(others, flange.wall, band, over, "v", source)
        if not (wrong or others):
            both = (on_web, web.wall), (on_flange, flange.wall)
            yield from _unpaired(both[0], both[1], coper, source)
            yield from _unpaired(both[1], both[0], coper, source)
        if coper.k_area == "refuse":
            beside = (chain.points[0][0] for chain, _ in ways_beside(flange))
            for x in [*(one.x for one in on_web), *beside][:1]:
                yield rules.K_AREA.at(source, x=f"{x:g}", face=root.face)


def lip_faults(regions: Mapping[Face, WallRegion], source: Source) -> Iterator[Diagnostic]:
    """What cannot be cut at the lips of a C: all that does not go through a lip as a whole."""
    for face, region in regions.items():
        wall = region.wall
        if not wall.lip:
            continue
        for high in (wall.lip, wall.low):
            for chain in chains_of(region.shape, borders_of(wall, EDGE, high, -EDGE)):
                xs = [x for x, _ in chain.points]
                along = high == wall.low and max(xs) - min(xs) > ALONG_LIP * high
                if along or {chain.start, chain.end} != {"low", "high"}:
                    what = "a cut into or along a lip" if chain.start else "a hole over a lip"
                    yield rules.INTO_LIP.at(source, what=what, x=f"{xs[0]:g}", face=face)


def _otherwise(
    wrong: Sequence[Sequence[Point]], wall: PlannedWall, band: tuple[float, float], clear: str,
    other: Face, source: Source, alone: Sequence[Sequence[Point]] = (),
) -> Iterator[Diagnostic]:  # fmt: skip
    """The errors of some paths; `alone` are those beside which the other wall has no cut."""
    for way in wrong[:3]:
        ys = [y for _, y in way]
        is_whole = abs(ys[0] - ys[-1]) >= band[1] - band[0] - EDGE and (
            all(a < b for a, b in pairwise(ys)) or all(a > b for a, b in pairwise(ys))
        )
        what = "a cut into or along a root"
        expected = f"one {clear}, or through all of it, square to the bar or along a skew end"
        if is_whole and way in alone:
            what = "a cut through the flange"
            expected = f"one of face {other} there too, or none in the thickness of that"
        elif is_whole:
            what = "a slanted or round cut through a root"
            expected = (
                "it square to the bar or along a skew end, or within 30 degrees or a corner's "
                f"radius of that and with one of face {other} that it meets"
            )
        yield rules.ROOT.at(
            source, x=f"{way[0][0]:g}", face=wall.face, what=what, expected=expected
        )


CutWall = tuple[Sequence[Crossing], PlannedWall]  #: cuts through a root, and whose they are


def _unpaired(mine: CutWall, others: CutWall, coper: Coper, source: Source) -> Iterator[Diagnostic]:
    """Cuts through a root of one wall without one of the other at the same x and side."""
    (cuts, wall), (there, other), near = mine, others, SHARE * coper.tolerance
    for one in cuts:
        if any(
            one.right == two.right
            and ((one.end is not None and one.end == two.end)
                 or (one.square and two.square and abs(one.x - two.x) <= near))
            for two in there
        ):  # fmt: skip
            continue
        expected = f"one of face {other.face} at that x, which the root goes with"
        if other.face == "v":
            expected += f", or a strip of the flange {other.thickness:g} mm wide on the web"
        yield rules.ROOT.at(
            source, what="a cut to the root", x=f"{one.x:g}", face=wall.face, expected=expected
        )


class _Approach(Struct, frozen=True):
    """A cut through the whole of a root that is straight at whatever angle, or round."""

    path: tuple[Point, ...]  #: along rising y; of a straight one over all of its wall
    #: where it meets the other wall: a round one of the web in that, others at both sides of it
    xs: tuple[float, float]
    right: bool  #: whether the scrap lies at greater x
    is_round: bool

    def meets(self, other: "_Approach") -> bool:
        """Whether it and one of the other wall are one cut, of which either is not square."""
        apart = max(min(self.xs) - max(other.xs), min(other.xs) - max(self.xs))
        square = not (self.is_round or other.is_round) and all(
            abs(one.xs[1] - one.xs[0]) <= EDGE for one in (self, other)
        )
        return not square and self.right == other.right and apart <= OUTLINE_NOISE

    def within(self, band: tuple[float, float]) -> list[Point]:
        """Its places on a band; beyond its ends it goes on square to the bar."""
        from numpy import interp

        xs, ys = zip(*self.path, strict=True)
        first, last = ((float(interp(y, ys, xs)), y) for y in band)
        return [first, *(place for place in self.path if band[0] < place[1] < band[1]), last]


def with_steps(
    regions: Mapping[Face, WallRegion], depths: Mapping[Face, float], coper: Coper, source: Source
) -> tuple[dict[Face, WallRegion], list[Diagnostic], dict[Face, float]]:
    """Regions whose walls meet square at roots that a cut crosses on a slant, or as the round of a
    corner begins there; a warning of each, and mm too much by wall.

    `depths` are those to which passes through a root cut. What is more than drawn reaches as far as
    either of the walls does there, so that no steel is missing.
    """
    walls, steps, off = dict(regions), list[Diagnostic](), dict[Face, float]()
    for root in regions["v"].wall.roots:
        flange, depth = regions[root.face].wall, depths[root.face]
        (behind,) = flange.roots
        ys, inner = root.band(0.0, depth + EDGE), root.inside(depth)
        zs = max(behind.low - EDGE, 0.0), min(behind.high + EDGE, flange.width)
        across = max(EDGE, behind.low), min(flange.width - EDGE, behind.high)
        wider = [root.band(near, depth + 2 * EDGE) for near in (EDGE, root.thick + EDGE)]
        beside = max(EDGE, zs[0] - EDGE), min(flange.width - EDGE, zs[1] + EDGE)
        pairs = product(
            _approaches(regions["v"], inner, wider, root.y(root.thick + EDGE), coper),
            _approaches(regions[root.face], across, (beside,), None, coper),
        )
        for one, other in pairs:
            if not one.meets(other):
                continue
            side = 1.0 if one.right else -1.0
            ways: dict[Face, list[Point]] = {"v": one.within(ys), root.face: other.within(zs)}
            x = side * max(side * at for way in ways.values() for at, _ in way)
            for face, way in ways.items():
                inside = [(at - side * OUTLINE_NOISE, y) for at, y in way]
                more = Polygon([*inside, (x, way[-1][1]), (x, way[0][1])])
                walls[face] = replace(walls[face], shape=walls[face].shape.union(more))
                off[face] = max(off.get(face, 0.0), *(abs(x - at) for at, _ in way))
            steps.append(rules.STEP.at(
                source, x=f"{x:g}", face=root.face, found=f"{max(off['v'], off[root.face]):.1f}",
            ))  # fmt: skip
    return walls, steps, off


def _approaches(
    region: WallRegion, band: tuple[float, float], wider: Sequence[tuple[float, float]],
    inner: float | None, coper: Coper,
) -> Iterator[_Approach]:  # fmt: skip
    """The cuts through a root that lie on none of a wall's skew ends: straight ones through a band,
    and round ones through the first of some wider bands that reach no farther along the bar than
    the steepest of those, or than a corner is round. A flange's inner surface lies at y `inner` of
    a web.
    """
    wide, begun = region.wall.width, set[Point]()
    for borders in (band, *wider):
        for chain in chains_of(region.shape, borders_of(region.wall, *borders, -EDGE)):
            right = chain.start == "low"
            way = chain.points if right else chain.points[::-1]
            (xa, ya), (xb, yb) = way[0], way[-1]
            if {chain.start, chain.end} != {"low", "high"} or any(
                end is not None and is_on(end, way) for end in region.wall.skew
            ):
                continue
            slope = (xb - xa) / (yb - ya)
            line, xs = EndLine(xa - slope * ya, slope), [x for x, _ in way]
            is_straight = is_on(line, way)
            if borders is band and is_straight and degrees(atan(abs(slope))) <= STEEPEST_DEG:
                yield _Approach(((line.x(0.0), 0.0), (line.x(wide), wide)), (xa, xb), right, False)
            begin = way[-1 if inner == band[0] else 0]
            if borders is band or is_straight or begin in begun:
                continue
            begun.add(begin)
            rises = all(a[1] < b[1] for a, b in pairwise(way))
            most = max(coper.corner_radius, tan(radians(STEEPEST_DEG)) * (yb - ya))
            if rises and SHARE * coper.tolerance < max(xs) - min(xs) <= most:
                one = _Approach(way, (min(xs), max(xs)), right, True)
                if inner is not None:  # rounder than the flange is thick it is off its drawn x
                    edge, side = (0.0 if inner == band[0] else wide), (1.0 if right else -1.0)
                    met = [x for x, _ in one.within((min(inner, edge), max(inner, edge)))]
                    there = met[-1 if inner == band[0] else 0]
                    one = replace(one, xs=(there, side * min(side * x for x in met)))
                yield one


def with_ledges(
    regions: Mapping[Face, WallRegion], depths: Mapping[int | None, float], kerf: float,
    coper: Coper, source: Source,
) -> tuple[dict[Face, WallRegion], list[Diagnostic]]:  # fmt: skip
    """Regions whose web keeps the ledges of such holes, and a warning of each.

    `depths` are those to which passes through a root cut, as of `root_faults`, `kerf` is that of a
    cut over the web. At a skew end the flange has to be cut with the torch tilted to it.
    """
    web = regions["v"]
    diagnostics: list[Diagnostic] = []
    for root in web.wall.roots:
        flange = regions[root.face]
        for one in through_flange(flange, coper)[0]:
            end, line = web.wall.skew[one.right], EndLine(one.x, 0.0)
            depth = depths[None]
            if end is not None:
                if one.end not in depths:
                    continue
                line, depth = end, depths[one.end]
            elif not one.square:
                continue
            for ledge, mm in _ledge(web, root, line, one.right, depth, kerf):
                web = replace(web, shape=web.shape.union(ledge))
                x = f"{line.x(root.inner):g}"
                diagnostics.append(rules.LEDGE.at(source, x=x, face=root.face, found=f"{mm:.1f}"))
    return {**regions, "v": web}, diagnostics


def _ledge(
    web: WallRegion, root: Root, end: EndLine, right: bool, depth: float, kerf: float
) -> Iterator[tuple[Shape, float]]:
    """What a web keeps at a root up to the end of its flange, and how high; nothing where the web
    ends there too, where it has no hole, or one that is all within reach of none."""

    def inside(low: float, high: float) -> Shape:
        """A band of the web up to its end."""
        far = -FAR if right else FAR
        return Polygon([(far, low), (end.x(low), low), (end.x(high), high), (far, high)])

    deep, beside = max(root.high - root.low, depth) + 2 * EDGE, root.y(root.thick + EDGE)
    x = end.x(beside)
    inwards = (-FAR, x) if right else (x, FAR)
    gap = LineString([(at, beside) for at in inwards]).difference(web.shape)
    gap = next(
        (one for one in getattr(gap, "geoms", (gap,))
         if not one.is_empty and abs(one.bounds[2 if right else 0] - x) <= EDGE),
        None,
    )  # fmt: skip
    if gap is None or gap.length <= OUTLINE_NOISE or gap.length >= FAR / 2:
        return
    # An outline of the web without the flange's own thickness means that the flange goes too.
    least, _, most, _ = gap.bounds
    middle = root.y(root.thick / 2)
    within = (least, end.x(middle)) if right else (end.x(middle), most)
    if LineString([(at, middle) for at in within]).difference(web.shape).length > OUTLINE_NOISE:
        return
    strip, over = inside(*root.band(0.0, deep)), inside(*root.band(deep, web.wall.width))
    voids = polygons_of(over.difference(web.shape).buffer(-kerf), 0.0)
    open_above = [one for one in voids if one.length < FAR]
    ledges = [p for p in polygons_of(strip.difference(web.shape), 0.0) if p.intersects(gap)]
    near = [one for one in open_above if any(one.distance(ledge) <= 2 * kerf for ledge in ledges)]
    if near and all(one.length < FAR for one in ledges):
        for one in ledges:
            yield one.buffer(EDGE / 10, join_style="mitre"), deep - root.thick
