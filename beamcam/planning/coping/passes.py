"""One pass of a torch along a bevelled edge: where it runs, and whether it has room there.

The torch leans square to the edge, over the part or over the scrap. What it sweeps is looked at on
both surfaces of the wall, its box across the bar.
"""

from collections.abc import Iterator, Sequence
from math import cos, dist, hypot, inf, radians, sin
from typing import Literal

from msgspec.structs import replace
from shapely import LineString, Polygon, box, union_all
from shapely import Point as Place
from shapely.affinity import affine_transform, translate

from beamcam.geometry.curves import Point
from beamcam.machine.coper import A_OF_FACE, Coper, torch_angles, torch_way
from beamcam.machine.machine import Machine
from beamcam.machine.torch import TorchRow
from beamcam.model.part import Contour, Part, Profile
from beamcam.model.plan import CopeCut, FeatureRef
from beamcam.model.surface import patch_of, surface_of
from beamcam.planning.coping.chart import Chart
from beamcam.planning.coping.cuts import LEADS
from beamcam.planning.coping.edges import BevelEdge, is_rolled, ways_of
from beamcam.planning.coping.regions import Shape, WallRegion
from beamcam.planning.coping.walls import OPEN, WEB_AMID

SLIVER = 0.05  #: mm by which a kerf may reach over the part, for rounding
BESIDE = 0.1  #: mm that a square cut may lie off half a kerf beside the edge that it makes
ALONG = 0.5  #: share of its way that a pass over a root goes across it, at least
HOLDER = 400.0  #: mm that the holder reaches outwards
ROUND = 16  #: sides of a quarter of a root fillet
FAR = 1e6  #: mm

Turns = tuple[tuple[float, float], ...]  #: A off its face and B, in degrees
_Begin = tuple[Point, Sequence[Point], Turns]  #: where a pass is pierced, its way, its turns


class NoPass(Exception):
    """Why an edge has no pass."""


class Passes:
    """Passes along the edges of one wall."""

    def __init__(
        self, region: WallRegion, part: Part, cuts: Sequence[CopeCut], chart: Chart,
        machine: Machine,
    ) -> None:  # fmt: skip
        self._region, self._wall, self._part = region, region.wall, part
        self._cuts = cuts
        self._chart, self._machine = chart, machine
        self._coper = machine.needed(machine.coper, "coper")

    def along(self, edge: BevelEdge, feature: FeatureRef, contour: Contour) -> CopeCut:
        """The pass along a bevelled edge. Raises NoPass where there is none."""
        wall, coper, thick = self._wall, self._coper, edge.thickness
        deep = edge.land if edge.is_lower else thick - edge.land
        if self._part.profile.code == "C":
            raise NoPass("behind a flange of a C a pass would go on into the lip")
        if not 0.0 < deep <= thick:
            raise NoPass(f"nothing of {thick:g} mm is left beside its land")
        if abs(edge.angle) > coper.tilt:
            raise NoPass(f"the torch leans by {coper.tilt:g} degrees at most")
        share = cos(radians(edge.angle))
        row, square = self._chart.row(thick / share), self._chart.row(thick)
        if row is None or square is None:
            raise NoPass(f"no row of the cut chart is {thick / share:.1f} mm deep")
        half = row.kerf / 2
        surface = edge.beside(0.0) - half / share
        tip = coper.standoff(row.cut_height, edge.angle) * sin(radians(edge.angle))
        over = coper.standoff(row.cut_height, edge.angle) + coper.pivot
        offs = surface, surface - thick * edge.slope, surface + over * sin(radians(edge.angle))
        if not edge.fits((*offs[:2], surface + tip, edge.beside(0.0), edge.beside(thick)), half):
            raise NoPass("its curve has no room for the kerf of a torch that leans")
        rulings = edge.rulings(offs, thick + over)
        places = [one.at(surface) for one in rulings]
        leans = [(one.inside[0] * edge.slope, one.inside[1] * edge.slope) for one in rulings]
        turns: Turns = tuple(torch_angles(wall.face, lean) for lean in leans)
        widest = max(edge.beside(0.0), edge.beside(thick))
        run = edge.gone_on(places, widest, half + coper.over)
        if not edge.is_ring:
            turns = turns if len(run) == 2 else (turns[0], *turns, turns[-1])
        steady = len(set(turns)) == 1
        if not steady and not self._machine.words.feed_turning:
            raise NoPass("the machine file has no words.feed_turning, A and B stand still")
        cut = CopeCut(
            self._kind(edge, square), wall.face, (), 1, thick / share, row, (feature,),
            contour.source, bevel=True, lower=edge.is_lower,
        )  # fmt: skip
        begins: list[_Begin] = [(rulings[0].place, run, turns)]
        if edge.is_lower:
            begins = [*self._begins(run, turns, (rulings[0].inside, rulings[-1].inside), cut)]
        why = NoPass("there is no scrap to pierce beside it")
        for pierce, way, (first, *others) in begins:
            both = (first, first, *others)
            cut = replace(
                cut, path=(pierce, *way), a_off_deg=first[0], b_deg=first[1],
                turns=() if steady else both,
            )  # fmt: skip
            try:
                self._look_at_room(cut, both, over - coper.pivot)
                self._look_at_part(cut, edge)
            except NoPass as found:
                why = found
            else:
                return cut
        raise why

    def _begins(
        self, run: Sequence[Point], turns: Turns, insides: tuple[Point, Point], cut: CopeCut
    ) -> Iterator[_Begin]:
        """Where a pass of the far side may be pierced, in scrap beside either of its ends, the
        farthest place first, and how it goes on from there. Raises NoPass for one that is in the
        air longer than its arc lives."""
        wall, row, coper = self._wall, cut.row, self._coper
        for way in (run, run[::-1]):
            (xa, ya), (xb, yb) = way[:2]
            air = max(-ya, ya - wall.width)
            if air > 0.0 and air * dist(*way[:2]) > abs(yb - ya) * (coper.over + 2 * row.kerf):
                raise NoPass("at an edge of the bar it would go on in the air")
        ways = ((run, turns, insides[0]), (run[::-1], turns[::-1], insides[1]))
        for way, turned, (nx, ny) in ways:
            (xa, ya), (xb, yb) = way[:2]
            y = min(max(ya, 0.0), wall.width)
            x = xa + (xb - xa) * (y - ya) / (yb - ya) if y != ya else xa
            for share in LEADS[:-1]:
                pierce = x - share * coper.lead * nx, y - share * coper.lead * ny
                beside = min(pierce[0], self._part.length - pierce[0])
                if wall.holds(pierce) and beside >= row.pierce_radius - coper.trim:
                    yield pierce, way, turned

    def square_beside(self, edge: BevelEdge) -> CopeCut | None:
        """The square cut that goes along an edge; None where there is none."""
        own = [curve for curve in edge.curves if not is_rolled(curve, self._wall)]
        middles = [Place(curve.point(share)) for curve in own for share in (0.3, 0.5, 0.7)]
        for cut in self._cuts if middles else ():
            way, half = LineString(cut.path[cut.lead :]), cut.row.kerf / 2
            if all(abs(way.distance(place) - half) <= BESIDE for place in middles):
                return cut
        return None

    def _kind(self, edge: BevelEdge, square: TorchRow) -> Literal["inner", "notch", "near", "far"]:
        """What the square cut makes that goes along an edge; a notch is the bar's own edge. Raises
        NoPass where that cut, or the arc of what has to be cut behind or before it, has no
        steel."""
        beside = self.square_beside(edge)
        if edge.is_lower:
            if all(is_rolled(curve, self._wall) for curve in edge.curves):
                raise NoPass("on the far side of an edge of the bar its arc has no steel")
            nose = -edge.beside(0.0)
            if edge.is_ring and not edge.is_whole:
                raise NoPass("the slug falls with the first of its passes")
            if not edge.is_whole and nose < square.kerf / 2:
                raise NoPass(f"above its land {nose:.1f} mm are left, on which no arc stands")
        elif beside is None and all(is_rolled(curve, self._wall) for curve in edge.curves):
            return "notch"
        if beside is None:
            raise NoPass("no square cut goes along all of it")
        return beside.kind

    def _look_at_room(self, cut: CopeCut, turns: Turns, over: float) -> None:
        """Raises NoPass where the tilted torch would leave its axes or meet other walls."""
        wall, coper, profile = self._wall, self._coper, self._part.profile
        patch = patch_of(surface_of(profile), wall.face)
        assert patch is not None
        steel = _section(profile)
        top = profile.width + coper.clearance
        limits: dict[str, Point] = {axis.moves: axis.limits for axis in self._machine.axes}
        for (x, y), (off, b_deg) in dict.fromkeys(zip(cut.path, turns, strict=True)):
            a_deg = A_OF_FACE[wall.face] + off
            at, way = patch.point(x + coper.trim, y), torch_way(a_deg, b_deg)
            places = [at[k] + (over + coper.pivot) * way[k] for k in range(3)]
            for letter, value in zip("XYZAB", (*places, a_deg, b_deg), strict=True):
                least, most = limits.get(letter, (value, value))
                if not least <= value <= most:
                    raise NoPass(f"{letter} would have to reach {value:.0f}, beyond its limits")
            if wall.face == "v":
                low = wall.roots[0].inner + profile.radius + cut.row.kerf
                high = inf if profile.code in OPEN else profile.height - low
                tip = (at[1] + over * way[1], at[2] + over * way[2])
                down, up = (_torch((tip[0], z), a_deg, b_deg, coper)
                            for z in (tip[1], max(tip[1], top)))  # fmt: skip
                swept = [a.union(b).convex_hull for a, b in zip(down, up, strict=True)]
                if not low <= y <= high or any(one.distance(steel) < coper.play for one in swept):
                    raise NoPass("the torch or its holder would meet a flange")
        if wall.face != "v":
            self._look_at_roots(cut)

    def _look_at_roots(self, cut: CopeCut) -> None:
        """Raises NoPass where a pass along a flange goes along a root, or on the far side to it."""
        half = cut.row.kerf / 2
        for root in self._wall.roots:
            band = box(-FAR, root.low, FAR, root.high)
            for a, b in ways_of(cut.path[1:]):
                over_it = LineString((a, b)).intersects(band)
                if over_it and abs(b[1] - a[1]) < ALONG * hypot(b[0] - a[0], b[1] - a[1]):
                    raise NoPass("it goes along the root")
            ways = [cut.path, _below(cut, self._wall.thickness)] if cut.lower else []
            if any(LineString(way).buffer(half).intersects(band) for way in ways):
                raise NoPass("behind its flange the web stands")

    def _look_at_part(self, cut: CopeCut, edge: BevelEdge) -> None:
        """Raises NoPass where a pass hurts the part at any depth of its wall, or pierces it."""
        share, shape = cos(radians(edge.angle)), self._region.shape
        (nx, ny) = edge.rulings(())[0].inside
        long = hypot(nx, ny)
        leans = [_lean(cut, k) for k in range(len(cut.path))]
        # What piercing burns is longer where the torch leans, square to the edge.
        (x, y), (c, s), more = cut.path[0], (nx / long, ny / long), 1 / share - 1.0
        a, b, d = 1 + more * c * c, more * c * s, 1 + more * s * s
        matrix = [a, b, b, d, x - a * x - b * y, y - b * x - d * y]
        burnt = affine_transform(Place(x, y).buffer(cut.row.pierce_radius), matrix)
        for depth in dict.fromkeys((0.0, edge.thickness - edge.land, edge.thickness)):
            stays = shape.difference(edge.strip(depth)).buffer(-SLIVER)
            run = LineString(_below(cut, depth)[1:])
            hole = translate(burnt, -depth * leans[0][0], -depth * leans[0][1])
            if run.buffer(cut.row.kerf / 2 / share).intersects(stays):
                raise NoPass("it would cut the part, where it runs out at an end or beside it")
            if hole.intersects(stays):
                raise NoPass("what piercing burns is wider than its wedge, or than the scrap")


def _below(cut: CopeCut, depth: float) -> list[Point]:
    """Where a pass goes through its wall so far below the surface."""
    leans = (_lean(cut, k) for k in range(len(cut.path)))
    return [(x - depth * lx, y - depth * ly) for (x, y), (lx, ly)
            in zip(cut.path, leans, strict=True)]  # fmt: skip


def _lean(cut: CopeCut, k: int) -> Point:
    """How far the head of the torch is over a place of a cut, by mm of height, along x and y."""
    off, b_deg = cut.turns[k] if cut.turns else (cut.a_off_deg, cut.b_deg)
    x, y, z = torch_way(A_OF_FACE[cut.face] + off, b_deg)
    out, along = {"v": (z, y), "o": (y, z), "u": (-y, z)}[cut.face]
    return x / out, along / out


def _section(profile: Profile) -> Shape:
    """The section in Y and Z, with its root fillets."""
    high, wide, r = profile.height, profile.width, profile.radius
    flange, web = profile.flange_thickness, profile.web_thickness or 0.0
    back = (wide - web) / 2 if profile.code in WEB_AMID else 0.0
    front = back + web
    shapes = [box(0.0, back, high, front), box(0.0, 0.0, flange, wide)]
    sides = [(flange, 1.0)]
    if profile.code not in OPEN:
        shapes.append(box(high - flange, 0.0, high, wide))
        sides.append((high - flange, -1.0))
    for y, way in sides:
        square = box(min(y, y + way * r), front, max(y, y + way * r), front + r)
        shapes.append(square.difference(Place(y + way * r, front + r).buffer(r, ROUND)))
    return union_all(shapes)


def _torch(tip: Point, a_deg: float, b_deg: float, coper: Coper) -> tuple[Shape, Shape]:
    """The torch and its holder as they are seen along the bar, from its tip on."""
    a, lean = radians(a_deg), abs(radians(b_deg))
    long, half, head = coper.torch_length * cos(lean), coper.torch_width / 2, coper.head_width / 2

    def box_at(low: float, high: float, wide: float) -> Shape:
        return Polygon([
            (tip[0] - sin(a) * up + cos(a) * side, tip[1] + cos(a) * up + sin(a) * side)
            for up, side in ((low, -wide), (high, -wide), (high, wide), (low, wide))
        ])  # fmt: skip

    return (
        box_at(-half * sin(lean), long, half),
        box_at(long - head * sin(lean), long + HOLDER, head),
    )
