"""The semantic route: a swept profile and its cutters, without a geometry kernel.

1. The section gives the member's own axes: X = Y x Z along it, whatever mirrors lie between.
2. Half-spaces, and prisms that take all of an end, become end planes.
3. Round and slotted prisms that pierce a wall squarely become holes.
4. What is left is cut out of the walls it touches, exactly, and shows as contours.
"""

from collections.abc import Iterator, Sequence

import shapely

from beamcam.errors import Source
from beamcam.geometry.curves import Line, Point
from beamcam.model.part import Hole, Slot
from beamcam.readers.ifc import rules
from beamcam.readers.ifc.body import Body, Swept
from beamcam.readers.ifc.curves2d import Chain
from beamcam.readers.ifc.cutters import (
    MIN_LEAN,
    Box3,
    Combined,
    Cutter,
    HalfSpace,
    Prism,
    planes_of,
)
from beamcam.readers.ifc.ends import trim
from beamcam.readers.ifc.entities import Entity, Model, Unreadable
from beamcam.readers.ifc.finish import Levels, Regions, Shaped, from_regions, sawn
from beamcam.readers.ifc.holes import Drilled, pierce
from beamcam.readers.ifc.region import Circles, Shape, polygon_of
from beamcam.readers.ifc.section import Wall, corner_points, walls_of
from beamcam.readers.ifc.space import dot, size, sub
from beamcam.readers.ifc.stock import Stock, stock_of
from beamcam.readers.ifc.unrolled import NearSeam, cut_tube, turned

# --- trimming -------------------------------------------------------------------------------------
# Which cutters are saw cuts: those that take all of an end.


def end_plane(cutter: Cutter, stock: Stock, corners: Sequence[Point]) -> HalfSpace | None:
    """The half-space that a cutter is for this member; None if it does not take all of an end."""
    planes: Sequence[HalfSpace] = ()
    prism: Prism | None = None  #: that has to hold all beyond the plane
    match cutter:
        case HalfSpace():
            planes = (cutter,)
        case Combined(first=HalfSpace() as half, others=(Prism() as prism,), less=False):
            planes = (half,)
        case Prism(shape=None):
            planes, prism = cutter.sides, cutter
    for plane in planes:
        if abs(plane.normal[0]) > MIN_LEAN and (
            prism is None or _takes_all(prism, plane, stock, corners)
        ):
            return plane
    return None


def _takes_all(cutter: Prism, plane: HalfSpace, stock: Stock, corners: Sequence[Point]) -> bool:
    """Whether a prism holds everything of the stock beyond a plane, up to the stock's end."""
    far = stock.x1 if plane.side > 0 else stock.x0
    beyond = [
        (at, y, z)
        for y, z in corners
        for x in (plane.x(y, z),)
        if plane.side * (far - x) > NO_LENGTH
        for at in (x, far)
    ]
    found = [*map(cutter.frame.inverse().point, beyond)]
    off = [o / size(cutter.frame.z) for o in (-FLUSH, FLUSH)]
    if not found or not all(off[0] <= p[2] <= 1 + off[1] for p in found):
        return False
    region = polygon_of(cutter.outline.outer, (), Circles()).buffer(FLUSH / size(cutter.frame.x))
    return bool(region.covers(shapely.MultiPoint([p[:2] for p in found]).convex_hull))


NO_LENGTH = 1e-4  #: mm beyond a plane that are nothing
FLUSH = 2e-3  #: mm by which a prism may fall short of what it takes
MIN_LENGTH = 0.1  #: mm that the ends have to leave
MOST_IN = 0.1  #: share of its thickness that they lie inside a thin wall
BETWEEN = (0.12, 0.25, 0.4, 0.5, 0.6, 0.75, 0.88)  #: shares at which leaning edges are looked at
TINY = 1e-3  #: mm that a cutter has to reach into the stock
LEVEL_IN = 0.06  #: mm that the outer levels lie inside a wall; a cut may fall short of it by less


Boxed = tuple[Cutter, Box3]


def read_swept(model: Model, element: Entity, body: Body, source: Source) -> Shaped:
    """The member of a swept body. Raises Unreadable, which says what the route cannot take."""
    assert isinstance(body.base, Swept)
    stock = stock_of(model, element, body.base)
    cutters = body.cutters(model, stock.frame.inverse())
    try:
        return cut(stock, cutters, source)
    except NearSeam as other:
        stock = turned(stock, other.at_rad)
        return cut(stock, body.cutters(model, stock.frame.inverse()), source)


def cut(stock: Stock, cutters: Sequence[Cutter], source: Source) -> Shaped:
    """The member that is left of a stock when the cutters have done their work."""
    section = stock.section
    corners = corner_points(section)
    walls = walls_of(section)
    starts: list[HalfSpace] = []
    ends: list[HalfSpace] = []
    rest: list[Boxed] = []
    for cutter in cutters:
        is_hole = walls and isinstance(cutter, Prism) and cutter.shape is not None
        plane = None if is_hole else end_plane(cutter, stock, corners)
        if plane is not None:
            (ends if plane.normal[0] > 0 else starts).append(plane)
        elif is_hole or _touches(cutter, stock):  # a hole that touches no wall makes none
            rest.append((cutter, cutter.box))
    start = trim(HalfSpace.at(-1, stock.x0), starts, corners)
    end = trim(HalfSpace.at(1, stock.x1), ends, corners)
    if start.most + end.most < MIN_LENGTH:
        raise Unreadable("end cuts that leave nothing")
    holes: list[Hole | Slot] = []
    general: list[Boxed] = []
    into = Drilled(section, start, end)
    for cutter, box in rest:
        pierced = pierce(cutter, box, into, source)
        if pierced is None:
            general.append((cutter, box))
        else:
            holes += pierced
    plain = not stock.outline and not stock.hollows and not general
    if plain and start.sole is not None and end.sole is not None:
        span = -start.reach, end.reach
        return sawn(stock, (start.sole, end.sole), span, holes, source)
    if section.code == "RO":
        cutters = [cutter for cutter, _ in general]
        return cut_tube(stock, (start, end), cutters, holes, source)
    if not walls:
        if section.code == "RU":
            raise Unreadable("a flat, a notch or a slot", rules.SOLID_CUT)
        raise Unreadable("other cuts than saw cuts", rules.SPECIAL_CUT)
    circles = Circles()
    regions = _left_of_walls(stock, (*starts, *ends), general, circles)
    planes = [*start.planes, *end.planes, *_sides(stock.outline)]
    planes += [plane for cutter, _ in general for plane in planes_of(cutter)]
    return from_regions(stock, regions, holes, circles, source, planes)


def _sides(outline: Chain) -> Iterator[HalfSpace]:
    """The planes of a plate's straight sides that its ends may be."""
    for side in outline:
        dx, dy = side.end[0] - side.start[0], side.end[1] - side.start[1]
        if isinstance(side, Line) and abs(dy) > MIN_LEAN * side.length:
            yield HalfSpace.at(1, side.start[0] - side.start[1] * dx / dy, dx / dy)


def _left_of_walls(
    stock: Stock, ends: Sequence[HalfSpace], general: Sequence[Boxed], circles: Circles
) -> Regions:
    """What ends and cutters leave of each wall of a stock, at its outer levels or at more."""
    walls = walls_of(stock.section)
    leaning = bool(general) or any(map(any, (e.slopes for e in ends)))
    regions: Regions = {}

    def at(wall: Wall, uncut: Shape, share: float) -> tuple[float, Shape]:
        c = wall.low + share * wall.thickness
        shape = uncut
        for one in ends:
            shape = shape.difference(one.slice(wall, c))
        for cutter, box in general:
            (q0, c0), (q1, c1) = map(wall.split, box)
            if c0 < c < c1 and q1 > 0 and q0 < wall.width:
                shape = shape.difference(cutter.slice(wall, c, circles))
        return c, shape

    for wall in walls:
        if stock.outline:
            uncut = polygon_of(stock.outline, stock.hollows, circles)
        else:
            uncut = shapely.box(stock.x0, 0.0, stock.x1, wall.width)
            for hollow in stock.hollows:
                uncut = uncut.difference(polygon_of(hollow, (), circles))
        edge = outer_level(wall)
        row: Levels = (at(wall, uncut, edge), at(wall, uncut, 1 - edge))
        # Edges may lean, of a flat bar also from both sides to its middle.
        if leaning and (stock.section.code == "B" or not row[0][1].equals(row[1][1])):
            row = (row[0], *(at(wall, uncut, share) for share in BETWEEN), row[1])
        regions[wall] = row
    return regions


def outer_level(wall: Wall) -> float:
    """The share of its thickness that the outer levels of a wall lie inside it."""
    return min(LEVEL_IN / wall.thickness, MOST_IN)


def _touches(cutter: Cutter, stock: Stock) -> bool:
    """Whether a cutter reaches the stock at all."""
    if isinstance(cutter, HalfSpace):
        return any(
            dot(cutter.normal, sub((x, y, z), cutter.point)) > 0.01
            for y, z in corner_points(stock.section)
            for x in (stock.x0, stock.x1)
        )
    low, high = cutter.box
    section = stock.section
    box = (stock.x0, 0.0, 0.0), (stock.x1, section.height, section.width)
    return all(b > c + TINY and a < d - TINY for a, b, c, d in zip(low, high, *box, strict=True))
