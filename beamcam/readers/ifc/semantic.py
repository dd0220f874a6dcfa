"""The semantic route: a swept profile and its cutters, without a geometry kernel.

1. The section gives the member's own axes: X = Y x Z along it, whatever mirrors lie between.
2. Half-spaces, and prisms that take all of an end, become end planes.
3. Round and slotted prisms that pierce a wall squarely become holes.
4. What is left is cut out of the walls it touches, exactly, and shows as contours.
"""

from collections.abc import Sequence
from typing import Any

from msgspec import Struct, field
from msgspec.structs import replace

from beamcam.errors import Source
from beamcam.geometry.curves import Line, Point
from beamcam.model.part import Hole, Slot
from beamcam.readers.ifc.body import Body, Swept
from beamcam.readers.ifc.curves2d import Chain
from beamcam.readers.ifc.cutters import Bounded, Box3, Cutter, HalfSpace, Prism
from beamcam.readers.ifc.ends import LEAST_LEAN, End, of_plane, trim
from beamcam.readers.ifc.entities import Entity, Model, Unreadable
from beamcam.readers.ifc.finish import (
    Regions,
    Shaped,
    cuts_of,
    end_planes,
    from_regions,
    hole_volume,
    reach,
    shifted,
    sorted_features,
)
from beamcam.readers.ifc.holes import Drilled, pierce
from beamcam.readers.ifc.plates import Plate, plate_of
from beamcam.readers.ifc.profiles import definition, section_of
from beamcam.readers.ifc.region import Circles, Shape, polygon_of, rectangle
from beamcam.readers.ifc.section import Section
from beamcam.readers.ifc.space import Frame, add, cross, dot, scale, size, sub, unit
from beamcam.readers.ifc.walls import Wall, corner_points, walls_of

LEAST_LENGTH = 0.1  #: mm that the ends have to leave
LEVEL_IN = 0.1  #: share of a wall's thickness that its two levels lie inside it


class Stock(Struct, frozen=True):
    """What a member is cut from, in its own frame: a section between two x."""

    section: Section
    frame: Frame  #: the member's coordinates in the element's
    x0: float
    x1: float
    outline: Chain | None = None  #: of a plate, in (x, y); None is a full rectangle
    hollows: tuple[Chain, ...] = ()


def read_swept(model: Model, element: Entity, body: Body, source: Source) -> Shaped:
    """The member of a swept body. Raises Unreadable, which says what the route cannot take.

    Equal members are read once: a building has each of its pieces several times.
    """
    base = body.base
    assert isinstance(base, Swept)
    if body.has_openings:  # whose features name them and are nobody else's
        return _read(model, element, body, source)
    stock = element.row.name, definition(base.profile), base.along
    of_one_stock: Alike = model.members.setdefault(stock, Alike())
    if of_one_stock.first is None:
        shaped = _read(model, element, body, source)
        of_one_stock.first = body, shaped
        return shaped
    if not of_one_stock.known:
        before, shaped = of_one_stock.first
        of_one_stock.known[before.form] = shaped
    form = body.form
    known = of_one_stock.known.get(form)
    if known is None:
        known = of_one_stock.known[form] = _read(model, element, body, source)
        return known
    return replace(known, features=tuple(replace(f, source=source) for f in known.features))


class Alike(Struct):
    """The members of one stock that were read, and what they came to.

    What a form is told by is long, so that none is looked at before a second one comes.
    """

    first: tuple[Body, Shaped] | None = None
    known: dict[Any, Shaped] = field(default_factory=dict)  #: by their forms


def _read(model: Model, element: Entity, body: Body, source: Source) -> Shaped:
    assert isinstance(body.base, Swept)
    stock = stock_of(model, element, body.base)
    cutters = body.cutters(model, stock.frame.inverse())
    return in_place(cut(stock, cutters, source), stock.frame)


def in_place(shaped: Shaped, frame: Frame) -> Shaped:
    """The member with its place: its own coordinates in the element's."""
    moved = Frame(add(frame.o, scale(frame.x, shaped.x0)), frame.x, frame.y, frame.z)
    return replace(shaped, frame=moved)


def stock_of(model: Model, element: Entity, base: Swept) -> Stock:
    """The stock and the frame of the member that a swept profile is."""
    depth = size(base.along)
    plane = unit(cross(base.frame.x, base.frame.y))
    if depth <= 0 or abs(abs(dot(plane, base.along)) - depth) > 1e-6 * depth:
        raise Unreadable("a profile that is pushed askew")
    factor = size(base.frame.x)
    if abs(size(base.frame.y) - factor) > 1e-6 * factor:
        raise Unreadable("a profile that is stretched unevenly")
    plate = plate_of(model, element, base.profile, depth / factor)
    if plate is not None:
        return _plate_stock(plate, base, factor)
    section = section_of(model, base.profile)
    frame = _frame(section, base.frame)
    if dot(frame.x, base.along) < 0 and (section.flip_z or section.flip_y):
        section = section.flipped_z() if section.flip_z else section.flipped_y()
        frame = _frame(section, base.frame)
    section = _scaled(section, factor)
    reach_x = dot(frame.x, base.along)
    return Stock(section, frame, min(0.0, reach_x), max(0.0, reach_x))


def _frame(section: Section, at: Frame) -> Frame:
    """The member's axes: Y and Z as the section lies, X square to both."""
    o = at.point((*section.origin, 0.0))
    y = unit(at.vector((*section.y, 0.0)))
    z = unit(at.vector((*section.z, 0.0)))
    return Frame(o, cross(y, z), y, z)


def _scaled(section: Section, by: float) -> Section:
    if abs(by - 1.0) < 1e-12:
        return section
    return replace(
        section,
        height=section.height * by,
        width=section.width * by,
        flange_thickness=section.flange_thickness * by,
        web_thickness=section.web_thickness * by,
        radius=section.radius * by,
        area=section.area * by * by,
    )


def _plate_stock(plate: Plate, base: Swept, factor: float) -> Stock:
    at = base.frame
    x = unit(at.vector((*plate.x, 0.0)))
    y = unit(at.vector((*plate.y, 0.0)))
    z = cross(x, y)
    o = at.point((*plate.origin, 0.0))
    if dot(z, base.along) < 0:
        o = add(o, base.along)
    thickness = size(base.along)
    width, length = plate.width * factor, plate.length * factor
    section = Section(
        "B", width, thickness, 0.0, thickness, 0.0, (0.0, 0.0), (0.0, 1.0), (1.0, 0.0),
        True, True, width * thickness,
    )  # fmt: skip
    matrix = ((factor, 0.0, 0.0), (0.0, factor, 0.0))
    outline = None
    if plate.outline is not None:
        outline = tuple(c.transformed(matrix) for c in plate.outline)
    hollows = tuple(tuple(c.transformed(matrix) for c in h) for h in plate.hollows)
    return Stock(section, Frame(o, x, y, z), 0.0, length, outline, hollows)


def cut(stock: Stock, cutters: Sequence[Cutter], source: Source) -> Shaped:
    """The member that is left of a stock when the cutters have done their work."""
    section = stock.section
    corners = corner_points(section)
    walls = walls_of(section)
    starts: list[End] = []
    ends: list[End] = []
    rest: list[tuple[Cutter, Box3]] = []
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
    start = trim(End(-1, 0.0, 0.0, stock.x0), starts, corners)
    end = trim(End(1, 0.0, 0.0, stock.x1), ends, corners)
    if start.most + end.most < LEAST_LENGTH:
        raise Unreadable("end cuts that leave nothing")
    holes: list[Hole | Slot] = []
    general: list[tuple[Cutter, Box3]] = []
    into = Drilled(section, walls, start, end)
    for cutter, box in rest:
        pierced = pierce(cutter, box, into, source)
        if pierced is None:
            general.append((cutter, box))
        else:
            holes += pierced
    gross = stock.x1 - stock.x0
    plain = stock.outline is None and not stock.hollows and not general
    if plain and start.sole is not None and end.sole is not None:
        return _sawn(section, start.sole, end.sole, holes, source, gross)
    if not walls:
        raise Unreadable(f"cuts other than saw cuts and holes in a section of code {section.code}")
    circles = Circles()
    regions: Regions = {}
    for wall in walls:
        levels = []
        for share in (LEVEL_IN, 1 - LEVEL_IN):
            c = wall.low + share * wall.thickness
            shape = _stock_shape(stock, wall, circles)
            for one in (*starts, *ends):
                shape = shape.difference(one.removed(wall, c))
            for cutter, box in general:
                if _box_meets(box, wall, c):
                    shape = shape.difference(cutter.slice(wall, c, circles))
            levels.append((c, shape))
        regions[wall] = (levels[0], levels[1])
    sole = start.sole, end.sole
    return from_regions(section, regions, holes, circles, source, gross, sole)


def _stock_shape(stock: Stock, wall: Wall, circles: Circles) -> Shape:
    if stock.outline is not None or stock.hollows:
        outline = stock.outline or ()
        if not outline:
            shape = rectangle(stock.x0, 0.0, stock.x1, wall.width)
            for hollow in stock.hollows:
                shape = shape.difference(polygon_of(hollow, (), circles))
            return shape
        return polygon_of(outline, stock.hollows, circles)
    return rectangle(stock.x0, 0.0, stock.x1, wall.width)


def _sawn(
    section: Section,
    start: End,
    end: End,
    holes: Sequence[Hole | Slot],
    source: Source,
    gross: float,
) -> Shaped:
    """A member with two plane ends and holes: all that most members have."""
    x0, x1 = reach(section, start, end)
    features = (
        *sorted_features([shifted(h, -x0) for h in holes]),
        *end_planes(start, end, x0, source),
    )
    middle = section.height / 2, section.width / 2
    volume = section.area * (end.x(*middle) - start.x(*middle)) - hole_volume(section, holes)
    return Shaped(section, x1 - x0, cuts_of(start, end), features, volume, gross, (), x0)


def end_plane(cutter: Cutter, stock: Stock, corners: Sequence[Point]) -> HalfSpace | None:
    """The half-space that a cutter is for this member; None if it does not take all of an end."""
    if isinstance(cutter, Prism) and cutter.shape is not None:
        return None
    if isinstance(cutter, HalfSpace):
        return cutter if abs(cutter.normal[0]) > LEAST_LEAN else None
    if isinstance(cutter, Bounded) and isinstance(cutter.first, HalfSpace):
        half = cutter.first
        if abs(half.normal[0]) > LEAST_LEAN and isinstance(cutter.second, Prism):
            return half if _takes_all(cutter.second, half, stock, corners) else None
        return None
    if isinstance(cutter, Prism):
        for plane in _sides(cutter):
            if abs(plane.normal[0]) > LEAST_LEAN and _takes_all(cutter, plane, stock, corners):
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
    boxes = [c.bbox for c in cutter.outline.outer]
    middle = f.point(
        (
            (min(b[0] for b in boxes) + max(b[2] for b in boxes)) / 2,
            (min(b[1] for b in boxes) + max(b[3] for b in boxes)) / 2,
            0.5,
        )
    )
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
