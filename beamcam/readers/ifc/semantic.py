"""The semantic route: a swept profile and its cutters, without a geometry kernel.

1. The section gives the member's own axes: X = Y x Z along it, whatever mirrors lie between.
2. Half-spaces, and prisms that take all of an end, become end planes.
3. Round and slotted prisms that pierce a wall squarely become holes.
4. What is left is cut out of the walls it touches, exactly, and shows as contours.
"""

from collections.abc import Sequence

from msgspec.structs import replace

from beamcam.errors import Source
from beamcam.geometry.curves import Line, Point
from beamcam.model.part import Hole, Slot
from beamcam.readers.ifc.body import Body, Swept
from beamcam.readers.ifc.curves2d import Chain, box_around
from beamcam.readers.ifc.cutters import Bounded, Box3, Cutter, HalfSpace, Prism
from beamcam.readers.ifc.ends import MIN_LEAN, End, of_plane, trim
from beamcam.readers.ifc.entities import Entity, Model, OddCut, Unreadable
from beamcam.readers.ifc.finish import Levels, Regions, Shaped, from_regions, sawn
from beamcam.readers.ifc.holes import Drilled, pierce
from beamcam.readers.ifc.region import Circles, Shape, polygon_of, rectangle
from beamcam.readers.ifc.section import Wall, corner_points, walls_of
from beamcam.readers.ifc.space import Frame, add, cross, dot, scale, size, sub, unit
from beamcam.readers.ifc.stock import Stock, stock_of

# --- trimming -------------------------------------------------------------------------------------

# Which cutters are saw cuts: those that take all of an end.


def end_plane(cutter: Cutter, stock: Stock, corners: Sequence[Point]) -> HalfSpace | None:
    """The half-space that a cutter is for this member; None if it does not take all of an end."""
    if isinstance(cutter, Prism) and cutter.shape is not None:
        return None
    if isinstance(cutter, HalfSpace):
        return cutter if abs(cutter.normal[0]) > MIN_LEAN else None
    if isinstance(cutter, Bounded) and isinstance(cutter.first, HalfSpace):
        half = cutter.first
        if abs(half.normal[0]) > MIN_LEAN and isinstance(cutter.second, Prism):
            return half if _takes_all(cutter.second, half, stock, corners) else None
        return None
    if isinstance(cutter, Prism):
        for plane in _sides(cutter):
            if abs(plane.normal[0]) > MIN_LEAN and _takes_all(cutter, plane, stock, corners):
                return plane
    return None


def _sides(cutter: Prism) -> list[HalfSpace]:
    """The planes of a prism's flat sides and ends; normals point into the prism."""
    f = cutter.frame
    found = []
    for o, way in ((f.o, 1.0), (add(f.o, f.z), -1.0)):
        normal = unit(cross(f.x, f.y))
        if dot(normal, f.z) * way < 0:
            normal = scale(normal, -1.0)
        found.append(HalfSpace(o, normal, cutter.where))
    x0, y0, x1, y1 = box_around(cutter.outline.outer)
    middle = f.point(((x0 + x1) / 2, (y0 + y1) / 2, 0.5))
    for curve in cutter.outline.outer:
        if isinstance(curve, Line):
            a, b = f.point((*curve.start, 0.0)), f.point((*curve.end, 0.0))
            normal = cross(sub(b, a), f.z)
            if size(normal) < 1e-9:
                continue
            normal = unit(normal)
            if dot(normal, sub(middle, a)) < 0:
                normal = scale(normal, -1.0)
            found.append(HalfSpace(a, normal, cutter.where))
    return found


def _takes_all(cutter: Prism, plane: HalfSpace, stock: Stock, corners: Sequence[Point]) -> bool:
    """Whether a prism holds everything of the stock beyond a plane, up to the stock's end."""
    inverse = cutter.frame.inverse()
    far = stock.x1 if plane.normal[0] > 0 else stock.x0
    way = 1.0 if plane.normal[0] > 0 else -1.0
    some = False
    h, b = stock.section.height, stock.section.width
    for y, z in (*corners[:: max(1, len(corners) // 24)], (h / 2, b / 2)):
        x = plane.x_at(y, z)
        if way * (far - x) <= 1e-4:
            continue
        some = True
        for at in (x + way * 1e-3, (x + far) / 2, far - way * 1e-3):
            inner_y = min(max(y, 1e-3), h - 1e-3)
            inner_z = min(max(z, 1e-3), b - 1e-3)
            shift = plane.x_at(inner_y, inner_z) - x
            s, t, k = inverse.point(
                (at + (shift if at != far - way * 1e-3 else 0.0), inner_y, inner_z)
            )
            if not -1e-9 <= k <= 1 + 1e-9 or not _inside(cutter.outline.outer, (s, t)):
                return False
    return some


def _inside(chain: Chain, p: Point) -> bool:
    """Whether a point is inside a chain, its arcs taken as eight chords each."""
    points: list[Point] = []
    for curve in chain:
        count = 1 if isinstance(curve, Line) else 16
        points += [curve.point(i / count) for i in range(count)]
    inside = False
    for i, (bx, by) in enumerate(points):
        ax, ay = points[i - 1]
        if (ay > p[1]) != (by > p[1]) and p[0] < ax + (p[1] - ay) * (bx - ax) / (by - ay):
            inside = not inside
    return inside


MIN_LENGTH = 0.1  #: mm that the ends have to leave
MOST_IN = 0.1  #: share of its thickness that they lie inside a thin wall
BETWEEN = (0.12, 0.25, 0.4, 0.5, 0.6, 0.75, 0.88)  #: shares at which leaning edges are looked at
LEVEL_IN = 0.06  #: mm that the outer levels lie inside a wall; a cut may fall short of it by less


Boxed = tuple[Cutter, Box3]


def read_swept(model: Model, element: Entity, body: Body, source: Source) -> Shaped:
    """The member of a swept body. Raises Unreadable, which says what the route cannot take."""
    assert isinstance(body.base, Swept)
    stock = stock_of(model, element, body.base)
    cutters = body.cutters(model, stock.frame.inverse())
    return in_place(cut(stock, cutters, source), stock.frame)


def in_place(shaped: Shaped, frame: Frame) -> Shaped:
    """The member with its place: its own coordinates in the element's."""
    moved = Frame(add(frame.o, scale(frame.x, shaped.x0)), frame.x, frame.y, frame.z)
    return replace(shaped, frame=moved)


def cut(stock: Stock, cutters: Sequence[Cutter], source: Source) -> Shaped:
    """The member that is left of a stock when the cutters have done their work."""
    section = stock.section
    corners = corner_points(section)
    walls = walls_of(section)
    starts, ends, rest = _sorted_out(cutters, stock)
    start = trim(End(-1, 0.0, 0.0, stock.x0), starts, corners)
    end = trim(End(1, 0.0, 0.0, stock.x1), ends, corners)
    if start.most + end.most < MIN_LENGTH:
        raise Unreadable("end cuts that leave nothing")
    holes: list[Hole | Slot] = []
    general: list[Boxed] = []
    into = Drilled(section, walls, start, end)
    for cutter, box in rest:
        pierced = pierce(cutter, box, into, source)
        if pierced is None:
            general.append((cutter, box))
        else:
            holes += pierced
    gross = stock.x1 - stock.x0
    plain = not stock.outline and not stock.hollows and not general
    if plain and start.sole is not None and end.sole is not None:
        span = -start.reach, end.reach
        return sawn(section, (start.sole, end.sole), span, holes, source, gross)
    if not walls:
        raise OddCut(f"cuts other than saw cuts and holes in a section of code {section.code}")
    circles = Circles()
    regions = _left_of_walls(stock, (*starts, *ends), general, circles)
    return from_regions(section, regions, holes, circles, source, gross, (start.sole, end.sole))


def _sorted_out(
    cutters: Sequence[Cutter], stock: Stock
) -> tuple[list[End], list[End], list[Boxed]]:
    """The cutters that are planes at the start and at the end of a stock, and the other ones."""
    corners, walls = corner_points(stock.section), walls_of(stock.section)
    starts: list[End] = []
    ends: list[End] = []
    rest: list[Boxed] = []
    for cutter in cutters:
        if walls and isinstance(cutter, Prism) and cutter.shape is not None:
            rest.append((cutter, cutter.box))  # which makes no hole where it touches no wall
            continue
        plane = end_plane(cutter, stock, corners)
        if plane is None:
            box = cutter.box
            if _touches(cutter, box, stock):
                rest.append((cutter, box))
        elif plane.normal[0] > 0:
            ends.append(of_plane(plane))
        else:
            starts.append(of_plane(plane))
    return starts, ends, rest


def _left_of_walls(
    stock: Stock, ends: Sequence[End], general: Sequence[Boxed], circles: Circles
) -> Regions:
    """What ends and cutters leave of each wall of a stock, at its outer levels or at more."""
    walls = walls_of(stock.section)
    uncut = {wall: _stock_shape(stock, wall, circles) for wall in walls}
    leaning = bool(general) or any(e.a or e.b for e in ends)
    regions: Regions = {}

    def at(wall: Wall, share: float) -> tuple[float, Shape]:
        c = wall.low + share * wall.thickness
        shape = uncut[wall]
        for one in ends:
            shape = shape.difference(one.removed(wall, c))
        for cutter, box in general:
            if _box_meets(box, wall, c):
                shape = shape.difference(cutter.slice(wall, c, circles))
        return c, shape

    for wall in walls:
        edge = outer_level(wall)
        row: Levels = (at(wall, edge), at(wall, 1 - edge))
        # Edges may lean, of a flat bar also from both sides to its middle.
        if leaning and (stock.section.code == "B" or not row[0][1].equals(row[1][1])):
            row = (row[0], *(at(wall, share) for share in BETWEEN), row[1])
        regions[wall] = row
    return regions


def outer_level(wall: Wall) -> float:
    """The share of its thickness that the outer levels of a wall lie inside it."""
    return min(LEVEL_IN / wall.thickness, MOST_IN)


def _stock_shape(stock: Stock, wall: Wall, circles: Circles) -> Shape:
    if stock.outline:
        return polygon_of(stock.outline, stock.hollows, circles)
    shape = rectangle(stock.x0, 0.0, stock.x1, wall.width)
    for hollow in stock.hollows:
        shape = shape.difference(polygon_of(hollow, (), circles))
    return shape


def _touches(cutter: Cutter, box: Box3, stock: Stock) -> bool:
    """Whether a cutter reaches the stock at all."""
    if isinstance(cutter, HalfSpace):
        section = stock.section
        return any(
            dot(cutter.normal, sub((x, y, z), cutter.point)) > 0.01
            for y, z in corner_points(section)
            for x in (stock.x0, stock.x1)
        )
    (ax, ay, az), (bx, by, bz) = box
    tiny = 1e-3
    return (
        bx > stock.x0 + tiny
        and ax < stock.x1 - tiny
        and by > tiny
        and ay < stock.section.height - tiny
        and bz > tiny
        and az < stock.section.width - tiny
    )


def _box_meets(box: Box3, wall: Wall, c: float) -> bool:
    low, high = box
    q0, c0 = wall.split(low)
    q1, c1 = wall.split(high)
    return c0 < c < c1 and q1 > 0 and q0 < wall.width
