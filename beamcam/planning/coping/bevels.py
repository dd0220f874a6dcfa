"""Weld preparations of a wall by passes of a torch that is tilted along the bar.

  \\\\ B          On the side that the torch looks at: the wall is cut square first, its root
___\\\\ wedge     with it. Then the torch takes the wedge off, from its surface to the square
   \\|           face, which stays as the land. A pass needs a wedge that is wider than what
    |  land      piercing burns, and room to run out at both ends of the edge.

       // B      On the far side: the torch leans the other way, over the scrap, and cuts the
_____ //         whole wall along the bevel first. What that leaves beyond the edge above the
     |/          land goes with the square cut, whose arc stands on it.
     / wedge
"""

from collections.abc import Iterator, Mapping, Sequence
from math import atan, cos, degrees, hypot, radians, tan

from msgspec import Struct

from beamcam.geometry.curves import Line, Point, signed_area
from beamcam.machine.coper import Coper
from beamcam.model.part import Bevel, Contour, Face, Part
from beamcam.model.plan import CopeCut
from beamcam.planning.coping.chart import Chart
from beamcam.planning.coping.ends import room_at
from beamcam.planning.coping.regions import OUTLINE_NOISE, Shape, WallRegion
from beamcam.planning.coping.walls import WEB_AMID, from_behind

LEAST_SIDE = 0.3  #: share of an edge's normal along the bar, in which B tilts
SLIVER = 0.05  #: mm by which a kerf may reach over the part, for rounding


class Edge(Struct, frozen=True):
    """A bevelled edge of a wall, the steel on its left."""

    start: Point
    end: Point
    bevel: Bevel
    thickness: float  #: of the wall

    @property
    def way(self) -> Point:
        dx, dy = self.end[0] - self.start[0], self.end[1] - self.start[1]
        return dx / hypot(dx, dy), dy / hypot(dx, dy)

    @property
    def b_deg(self) -> float:
        """The tilt along the bar whose plane is the bevel's: of a lower one over the scrap."""
        return -degrees(atan(tan(radians(self.bevel.angle)) / self.way[1]))

    def inside(self, place: Point, mm: float) -> Point:
        """A place moved into the steel, square to the edge."""
        dx, dy = self.way
        return place[0] - mm * dy, place[1] + mm * dx

    @property
    def is_lower(self) -> bool:
        return self.bevel.angle < 0.0

    def beside(self, depth: float) -> float:
        """How far in the steel the bevel's plane lies, so far below the surface."""
        return (self.thickness - self.bevel.land - depth) * tan(radians(self.bevel.angle))

    def wide(self, depth: float) -> float:
        """How far the bevel reaches into the steel there."""
        return max(0.0, self.beside(depth))

    def strip(self, depth: float) -> Shape:
        """What it takes of the wall there."""
        from shapely import Polygon

        wide = self.wide(depth)
        a, b = self.start, self.end
        return Polygon([a, b, self.inside(b, wide), self.inside(a, wide)]) if wide else Polygon()


def bevel_cuts(
    part: Part, regions: Mapping[Face, WallRegion], features: Mapping[Face, Sequence[int]],
    chart: Chart, coper: Coper,
) -> tuple[list[CopeCut], set[int]]:  # fmt: skip
    """The second passes, and the contours all of whose bevels are made by them.

    The last wall of a far end parts the piece from its bar; no second pass follows it.
    """
    cuts: list[CopeCut] = []
    made: set[int] = set()
    # A pass would go on into the lip of a C behind its flange.
    if part.profile.code == "C":
        return cuts, made
    skew = any(line is not None for one in regions.values() for line in one.wall.skew)
    if not coper.tilt or skew:
        return cuts, made
    beveled: set[Face] = set()
    for face in ("o", "u", "v"):
        for f in features.get(face, ()) if face in regions else ():
            contour = part.features[f]
            if not isinstance(contour, Contour) or contour.kind != "outer":
                continue
            if contour.face != face:
                contour = from_behind(contour, face, regions[face].wall.thickness)
            bevels = [one for one in contour.bevels if abs(one.angle) >= coper.min_bevel]
            cope_cuts = [
                _pass(one, f, contour, regions[face], part, chart, coper) for one in bevels
            ]
            own = [cut for cut in cope_cuts if cut is not None]
            if any(cut.kind == "far" and not cut.lower for cut in own):
                if part.made is None and len(beveled | {face}) == len(regions):
                    own = [cut for cut in own if cut.kind != "far" or cut.lower]
                beveled.add(face)
            cuts += own
            if bevels and len(own) == len(bevels):
                made.add(f)
    return cuts, made


def _pass(
    bevel: Bevel,
    f: int,
    contour: Contour,
    region: WallRegion,
    part: Part,
    chart: Chart,
    coper: Coper,
) -> CopeCut | None:
    """The second pass along a bevelled edge; None where there is none."""
    wall, line = region.wall, contour.curves[bevel.curve]
    thick = wall.thickness
    deep = bevel.land if bevel.angle < 0.0 else thick - bevel.land
    if not isinstance(line, Line) or not 0.0 < deep <= thick:
        return None
    ends = _on_wall(line.start, region), _on_wall(line.end, region)
    if signed_area(contour.curves) < 0.0:  # that of o runs clockwise in its numbers
        ends = ends[::-1]
    edge = Edge(*ends, bevel, thick)
    if abs(edge.way[1]) < LEAST_SIDE or abs(edge.b_deg) > coper.tilt:
        return None
    share = cos(radians(edge.b_deg))
    row, square = chart.row(thick / share), chart.row(thick)
    middle = (edge.start[0] + edge.end[0]) / 2
    is_far = edge.way[1] > 0.0
    if row is None or square is None or is_far != (middle > part.length / 2):
        return None
    if not _has_room(region, edge, part, coper):
        return None
    half = row.kerf / 2
    dx, dy = edge.way
    beside = edge.beside(0.0) - hypot(half / share * dy, half * dx)
    more = half + coper.over
    a, b = edge.inside(edge.start, beside), edge.inside(edge.end, beside)
    first = a[0] - more * dx, a[1] - more * dy
    last = b[0] + more * dx, b[1] + more * dy
    pierce = edge.start
    if edge.is_lower:
        # The arc of the square cut has to stand on what is left of the wall there.
        if wall.face != "v" or -edge.beside(0.0) < square.kerf / 2:
            return None
        at = first[0], min(max(first[1], 0.0), wall.width)
        pierce = edge.inside(at, -coper.lead)
        within = -coper.trim + row.pierce_radius, part.length + coper.trim - row.pierce_radius
        if not (wall.holds(pierce) and within[0] <= pierce[0] <= within[1]):
            return None
    cut = CopeCut(
        "far" if is_far else "near", wall.face, (pierce, first, last), 1, thick / share, row,
        ((0, f),), contour.source, False, edge.b_deg, True, edge.is_lower,
    )  # fmt: skip
    return cut if _is_clear(cut, edge, region) else None


def _on_wall(place: Point, region: WallRegion) -> Point:
    """A corner of an outline; near an edge of its wall on that edge."""
    x, y = place
    for side in (0.0, region.wall.width):
        if abs(y - side) <= OUTLINE_NOISE:
            y = side
    return x, y


def _has_room(region: WallRegion, edge: Edge, part: Part, coper: Coper) -> bool:
    """Whether the tilted torch comes to an edge: over the web between its flanges."""
    wall, web = region.wall, part.profile.web_thickness or 0.0
    if wall.face != "v":
        return True
    ys = sorted((edge.start[1], edge.end[1]))
    more = coper.over + coper.lead
    deep = part.profile.width - web
    deep = deep / 2 if part.profile.code in WEB_AMID else deep
    reached = ys[0] - more >= wall.low and ys[1] + more <= wall.high
    return reached and deep <= room_at(edge.b_deg, coper)


def _is_clear(cut: CopeCut, edge: Edge, region: WallRegion) -> bool:
    """Whether a pass hurts nothing of its wall at any depth, and pierces clear of the part."""
    from shapely import LineString
    from shapely import Point as Place
    from shapely.affinity import scale

    share, lean = cos(radians(cut.b_deg)), tan(radians(cut.b_deg))

    def seen(shape: Shape) -> Shape:
        return scale(shape, share, 1.0, origin=(0.0, 0.0))

    for depth in (0.0, edge.thickness - edge.bevel.land, edge.thickness):
        stays = region.shape.difference(edge.strip(depth)).buffer(-SLIVER)
        run = LineString([(x - depth * lean, y) for x, y in cut.path[1:]])
        if seen(run).buffer(cut.row.kerf / 2).intersects(seen(stays)):
            return False
    stays = region.shape.difference(edge.strip(0.0))
    return bool(seen(stays).distance(seen(Place(cut.path[0]))) >= cut.row.pierce_radius)


def edges_of(cuts: Sequence[CopeCut]) -> Iterator[Face]:
    """The walls of the far end that a second pass follows."""
    yield from dict.fromkeys(cut.face for cut in cuts if cut.bevel and cut.kind == "far")
