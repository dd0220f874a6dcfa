"""Weld preparations of a wall by passes of a torch that is tilted off its normal.

  \\\\ angle      On the side that the torch looks at: the wall is cut square first, its root
___\\\\ wedge     with it. Then the torch takes the wedge off, from its surface to the square
   \\|           face, which stays as the land. A pass needs a wedge that is wider than what
    |  land      piercing burns, and room to run out at both ends of the edge.

       // angle  On the far side: the torch leans the other way, over the scrap, and cuts the
_____ //         whole wall along the bevel first. What that leaves beyond the edge above the
     |/          land goes with the square cut, whose arc stands on it.
     / wedge

The torch leans square to the edge: over an edge across the bar by B, along the bar by A, else by
both. Round an arc both turn as it cuts.
"""

from collections.abc import Iterator, Mapping, Sequence
from math import cos, hypot, inf, radians, sin
from typing import Any

from msgspec.structs import replace

from beamcam.geometry.curves import Point
from beamcam.machine.coper import A_OF_FACE, Coper, torch_angles, torch_way
from beamcam.machine.machine import Machine
from beamcam.model.part import Contour, Face, Part, Profile
from beamcam.model.plan import CopeCut, CopeKind, FeatureRef
from beamcam.model.surface import patch_of, surface_of
from beamcam.planning.coping.chart import Chart
from beamcam.planning.coping.edges import BevelEdge, bevel_edges, is_rolled, ways_of
from beamcam.planning.coping.ends import own_bevels
from beamcam.planning.coping.regions import Shape, WallRegion
from beamcam.planning.coping.walls import OPEN, WEB_AMID, from_behind

SLIVER = 0.05  #: mm by which a kerf may reach over the part, for rounding
BESIDE = 0.1  #: mm that a square cut may lie off half a kerf beside the edge that it makes
ALONG = 0.5  #: share of its way that a pass over a root goes across it, at least
HOLDER = 400.0  #: mm that the holder reaches outwards
ROUND = 16  #: sides of a quarter of a root fillet

Turns = tuple[tuple[float, float], ...]  #: A off its face and B, in degrees


def bevel_cuts(
    part: Part, regions: Mapping[Face, WallRegion], features: Mapping[Face, Sequence[int]],
    cuts: Sequence[CopeCut], tilts: Sequence[bool], chart: Chart, machine: Machine,
) -> tuple[list[CopeCut], set[int]]:  # fmt: skip
    """The passes along the edges that `cuts` make or the bar has, and the contours all of whose
    bevels are made by them or by the ends that `tilts` says the torch is tilted to.

    The last wall of a far end parts the piece from its bar; no second pass follows it.
    """
    coper = machine.needed(machine.coper, "coper")
    passes: list[CopeCut] = []
    made: set[int] = set()
    beveled: set[Face] = set()
    for face in ("o", "u", "v"):
        for f in features.get(face, ()) if face in regions else ():
            contour = part.features[f]
            if not isinstance(contour, Contour):
                continue
            bevels = own_bevels(contour, part, tilts, coper.min_bevel)
            if not bevels:
                made.add(f)
            # A pass would go on into the lip of a C behind its flange.
            is_out = contour.kind == "outer" and part.profile.code != "C"
            if not bevels or not coper.tilt or not is_out:
                continue
            region, contour = regions[face], replace(contour, bevels=tuple(bevels))
            if contour.face != face:
                contour = from_behind(contour, face, region.wall.thickness)
            plan = _Passes(region, part, cuts, chart, machine)
            found = [(edge, plan.along(edge, (0, f), contour))
                     for edge in bevel_edges(contour, region.wall, coper.min_bevel)]  # fmt: skip
            own = [(edge, cut) for edge, cut in found if cut is not None]
            if any(cut.kind == "far" and not cut.lower for _, cut in own):
                if part.made is None and len(beveled | {face}) == len(regions):
                    own = [(e, cut) for e, cut in own if cut.kind != "far" or cut.lower]
                beveled.add(face)
            passes += [cut for _, cut in own]
            if sum(edge.count for edge, _ in own) == len(bevels):
                made.add(f)
    return passes, made


class _Passes:
    """Passes along the edges of one wall."""

    def __init__(
        self, region: WallRegion, part: Part, cuts: Sequence[CopeCut], chart: Chart,
        machine: Machine,
    ) -> None:  # fmt: skip
        self._region, self._wall, self._part = region, region.wall, part
        self._cuts = [cut for cut in cuts if cut.face == region.wall.face and not cut.b_deg]
        self._chart, self._machine = chart, machine
        self._coper = machine.needed(machine.coper, "coper")

    def along(self, edge: BevelEdge, feature: FeatureRef, contour: Contour) -> CopeCut | None:
        """The pass along a bevelled edge; None where there is none."""
        wall, coper, thick = self._wall, self._coper, edge.thickness
        kind = self._kind(edge)
        deep = edge.land if edge.is_lower else thick - edge.land
        if kind is None or not 0.0 < deep <= thick or abs(edge.angle) > coper.tilt:
            return None
        share = cos(radians(edge.angle))
        row, square = self._chart.row(thick / share), self._chart.row(thick)
        if row is None or square is None:
            return None
        half = row.kerf / 2
        surface = edge.beside(0.0) - half / share
        over = coper.standoff(row.cut_height, edge.angle) + coper.pivot
        offs = surface, surface - thick * edge.slope, surface + over * sin(radians(edge.angle))
        if not edge.fits((*offs, edge.beside(0.0)), half):
            return None
        rulings = edge.rulings(offs)
        places = [one.at(surface) for one in rulings]
        leans = [(one.inside[0] * edge.slope, one.inside[1] * edge.slope) for one in rulings]
        widest = max(edge.beside(0.0), edge.beside(thick))
        run = edge.gone_on(places, widest, half + coper.over)
        first, last = run[0], run[-1]
        pierce = rulings[0].place
        if edge.is_lower:
            # The arc of the square cut has to stand on what is left of the wall there.
            if wall.face != "v" or -edge.beside(0.0) < square.kerf / 2:
                return None
            at = first[0], min(max(first[1], 0.0), wall.width)
            (nx, ny) = rulings[0].inside
            pierce = at[0] - coper.lead * nx, at[1] - coper.lead * ny
            ends = -coper.trim + row.pierce_radius, (
                self._part.length + coper.trim - row.pierce_radius)  # fmt: skip
            if not (wall.holds(pierce) and ends[0] <= pierce[0] <= ends[1]):
                return None
        turns: Turns = tuple(torch_angles(wall.face, lean) for lean in leans)
        path = (pierce, first, *places, last)
        if len(edge.curves) == 1 and len(places) == 2:
            path, turns = (pierce, first, last), turns[:1] * 3
        else:
            turns = (turns[0], *turns[:1], *turns, turns[-1])
        steady = len(set(turns)) == 1
        if not steady and not self._machine.words.feed_turning:
            return None
        cut = CopeCut(
            kind, wall.face, path, 1, thick / share, row, (feature,), contour.source, False,
            turns[0][1], True, edge.is_lower, turns[0][0], () if steady else turns,
        )  # fmt: skip
        fits = self._has_room(cut, turns, over - coper.pivot) and self._is_clear(cut, edge, offs)
        return cut if fits else None

    def _kind(self, edge: BevelEdge) -> CopeKind | None:
        """What the square cut makes that goes along an edge; a notch is the bar's own edge."""
        from shapely import LineString
        from shapely import Point as Place

        own = [curve for curve in edge.curves if not is_rolled(curve, self._wall)]
        middles = [Place(curve.point(share)) for curve in own for share in (0.3, 0.5, 0.7)]
        for cut in self._cuts:
            way, half = LineString(cut.path[cut.lead :]), cut.row.kerf / 2
            if middles and all(abs(way.distance(place) - half) <= BESIDE for place in middles):
                return cut.kind
        return "notch" if not middles and not edge.is_lower else None

    def _has_room(self, cut: CopeCut, turns: Turns, over: float) -> bool:
        """Whether the tilted torch comes to an edge: within the axes, clear of other walls."""
        from shapely import box

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
                    return False
            if wall.face == "v":
                low = wall.roots[0].inner + profile.radius + cut.row.kerf
                high = inf if profile.code in OPEN else profile.height - low
                tip = (at[1] + over * way[1], at[2] + over * way[2])
                down, up = (_torch((tip[0], z), a_deg, b_deg, coper)
                            for z in (tip[1], max(tip[1], top)))  # fmt: skip
                swept = [a.union(b).convex_hull for a, b in zip(down, up, strict=True)]
                if not low <= y <= high or any(one.distance(steel) < coper.play for one in swept):
                    return False
        for root in wall.roots if wall.face != "v" else ():
            band = box(-1e6, root.low, 1e6, root.high)
            for (xa, ya), (xb, yb) in ways_of(cut.path[1:]):
                over_it = _line((xa, ya), (xb, yb)).intersects(band)
                if over_it and abs(yb - ya) < ALONG * hypot(xb - xa, yb - ya):
                    return False
        return True

    def _is_clear(self, cut: CopeCut, edge: BevelEdge, offs: Sequence[float]) -> bool:
        """Whether a pass hurts nothing of its wall at any depth, and pierces clear of the part."""
        from shapely import LineString
        from shapely import Point as Place
        from shapely.affinity import translate

        share, shape = cos(radians(edge.angle)), self._region.shape
        (nx, ny) = edge.rulings(())[0].inside
        leans = [_lean(cut, k) for k in range(len(cut.path))]
        # What piercing burns is longer where the torch leans, square to the edge.
        burnt = _stretched(Place(cut.path[0]).buffer(cut.row.pierce_radius), (nx, ny), 1 / share)
        for depth in (0.0, edge.thickness - edge.land, edge.thickness):
            stays = shape.difference(edge.strip(depth)).buffer(-SLIVER)
            run = LineString([
                (x - depth * lx, y - depth * ly)
                for (x, y), (lx, ly) in zip(cut.path[1:], leans[1:], strict=True)
            ])  # fmt: skip
            hole = translate(burnt, -depth * leans[0][0], -depth * leans[0][1])
            if run.buffer(cut.row.kerf / 2 / share).union(hole).intersects(stays):
                return False
        return True


def _lean(cut: CopeCut, k: int) -> Point:
    """How far the head of the torch is over a place of a cut, by mm of height, along x and y."""
    off, b_deg = cut.turns[k] if cut.turns else (cut.a_off_deg, cut.b_deg)
    x, y, z = torch_way(A_OF_FACE[cut.face] + off, b_deg)
    out, along = {"v": (z, y), "o": (y, z), "u": (-y, z)}[cut.face]
    return x / out, along / out


def _stretched(shape: Shape, way: Point, by: float) -> Shape:
    """A shape that is so many times as long along a way, about its middle."""
    from shapely.affinity import affine_transform

    (c, s), more = way, by - 1.0
    x, y = shape.centroid.x, shape.centroid.y
    a, b, d = 1 + more * c * c, more * c * s, 1 + more * s * s
    return affine_transform(shape, [a, b, b, d, x - a * x - b * y, y - b * x - d * y])


def _line(a: Point, b: Point) -> Any:
    from shapely import LineString

    return LineString((a, b))


def _section(profile: Profile) -> Shape:
    """The section in Y and Z, with its root fillets."""
    from shapely import Point as Place
    from shapely import box, union_all

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
    from shapely import Polygon

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


def edges_of(cuts: Sequence[CopeCut]) -> Iterator[Face]:
    """The walls of the far end that a second pass follows."""
    yield from dict.fromkeys(cut.face for cut in cuts if cut.bevel and cut.kind == "far")
