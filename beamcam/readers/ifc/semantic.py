"""The semantic route: a swept profile and its cutters, without a geometry kernel.

1. The section gives the member's own axes: X = Y x Z along it, whatever mirrors lie between.
2. Half-spaces, and prisms that take all of an end, become end planes.
3. Round and slotted prisms that pierce a wall squarely become holes.
4. What is left is cut out of the walls it touches, exactly, and shows as contours.
"""

from collections.abc import Sequence
from math import atan2, copysign, cos, degrees, pi, radians, sin, sqrt

import shapely
from msgspec.structs import replace

from beamcam.errors import Source
from beamcam.geometry.curves import Point
from beamcam.model.part import Hole, HoleKind, Slot
from beamcam.readers.ifc import rules
from beamcam.readers.ifc.body import Body, Swept
from beamcam.readers.ifc.cutters import Combined, Cutter, HalfSpace, Prism, Trim, planes_of, trim
from beamcam.readers.ifc.entities import Entity, Model, Unreadable
from beamcam.readers.ifc.finish import Levels, Regions, Shaped, from_regions, sawn
from beamcam.readers.ifc.outline import Round, Slotted
from beamcam.readers.ifc.profiles import Outline
from beamcam.readers.ifc.region import Circles, Shape, polygon_of
from beamcam.readers.ifc.section import Section, Wall, corner_points, walls_of
from beamcam.readers.ifc.space import IDENTITY, dot, scale, size, sub, unit
from beamcam.readers.ifc.stock import Stock, stock_of
from beamcam.readers.ifc.unrolled import NearSeam, cut_tube, turned

# --- trimming -------------------------------------------------------------------------------------
# Which cutters are saw cuts: those that take all of an end.


def end_plane(cutter: Cutter, stock: Stock, corners: Sequence[Point]) -> HalfSpace | None:
    """The half-space that a cutter is for this member; None if it does not take all of an end."""
    prism: Prism | None = None  #: that has to hold all beyond the plane
    match cutter:
        case HalfSpace() as plane:
            pass
        case Combined(first=HalfSpace() as plane, others=(Prism() as prism,), less=False):
            pass
        case Prism(shape=None) as plane:
            prism = plane
        case _:
            return None
    planes = (p for p in planes_of(plane) if prism is None or _takes_all(prism, p, stock, corners))
    return next(planes, None)


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
    points, off = [*map(cutter.frame.inverse().point, beyond)], FLUSH / size(cutter.frame.z)
    if not points or not all(-off <= p[2] <= 1 + off for p in points):
        return False
    region = polygon_of(cutter.outline.outer, (), Circles()).buffer(FLUSH / size(cutter.frame.x))
    return bool(region.covers(shapely.MultiPoint([p[:2] for p in points]).convex_hull))


NO_LENGTH = 1e-4  #: mm beyond a plane that are nothing
FLUSH = 2e-3  #: mm by which a prism may fall short of what it takes
MIN_LENGTH = 0.1  #: mm that the ends have to leave
MOST_IN = 0.1  #: share of its thickness that they lie inside a thin wall
BETWEEN = (0.12, 0.25, 0.4, 0.5, 0.6, 0.75, 0.88)  #: shares at which leaning edges are looked at
TINY = 1e-3  #: mm that a cutter has to reach into the stock
LEVEL_IN = 0.06  #: mm that the outer levels lie inside a wall; a cut may fall short of it by less


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
    starts, ends, rest = list[HalfSpace](), list[HalfSpace](), list[Cutter]()
    for cutter in cutters:
        is_hole = walls and isinstance(cutter, Prism) and cutter.shape is not None
        plane = None if is_hole else end_plane(cutter, stock, corners)
        if plane is not None:
            (ends if plane.normal[0] > 0 else starts).append(plane)
        elif is_hole or _touches(cutter, stock):  # a hole that touches no wall makes none
            rest.append(cutter)
    start = trim(HalfSpace.at(-1, stock.x0), starts, corners)
    end = trim(HalfSpace.at(1, stock.x1), ends, corners)
    if start.most + end.most < MIN_LENGTH:
        raise Unreadable("end cuts that leave nothing")
    holes, general = list[Hole | Slot](), list[Cutter]()
    for cutter in rest:
        pierced = pierce(cutter, section, start, end, source)
        if pierced is None:
            general.append(cutter)
        else:
            holes += pierced
    plain = not stock.outline and not stock.hollows and not general
    if plain and start.sole is not None and end.sole is not None:
        span = -start.reach, end.reach
        return sawn(stock, (start.sole, end.sole), span, holes, source)
    if section.code == "RO":
        return cut_tube(stock, (start, end), general, holes, source)
    if not walls:
        if section.code == "RU":
            raise Unreadable("a flat, a notch or a slot", rules.SOLID_CUT)
        raise Unreadable("other cuts than saw cuts", rules.SPECIAL_CUT)
    circles = Circles()
    regions = _left_of_walls(stock, (*starts, *ends), general, circles)
    planes = [*start.planes, *end.planes]
    if stock.outline:  # of a plate, whose ends may be sides of it
        general.append(Prism(IDENTITY, Outline(stock.outline)))
    planes += [plane for cutter in general for plane in planes_of(cutter)]
    return from_regions(stock, regions, holes, circles, source, planes)


def _left_of_walls(
    stock: Stock, ends: Sequence[HalfSpace], general: Sequence[Cutter], circles: Circles
) -> Regions:
    """What ends and cutters leave of each wall of a stock, at its outer levels or at more."""
    walls = walls_of(stock.section)
    leaning = bool(general) or any(map(any, (e.slopes for e in ends)))
    boxed = [(cutter, cutter.box) for cutter in general]
    regions: Regions = {}

    def at(wall: Wall, uncut: Shape, share: float) -> tuple[float, Shape]:
        c = wall.low + share * wall.thickness
        shape = uncut
        for one in ends:
            shape = shape.difference(one.slice(wall, c))
        for cutter, box in boxed:
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


# --- holes ----------------------------------------------------------------------------------------
# Round and slotted cutters that pierce walls squarely: holes, one for each wall.

SQUARE = 2e-3  #: sine of the angle by which a hole may be off square, a tenth of a degree
THROUGH = 0.05  #: mm that a hole may fall short of the far surface
TOUCH = 0.02  #: mm into a wall that still counts as beside it
BITE = 0.1  #: share of a wall's thickness that a hole in the wall beside it may touch
WIDEST = 0.9  #: of a round section, that a hole across it may be
NEAR = 1e-3  #: mm between a hole and an edge that it does not cut open

Span = tuple[float, float]


def pierce(
    cutter: Cutter, section: Section, start: Trim, end: Trim, source: Source
) -> list[Hole | Slot] | None:
    """The holes that a cutter makes in a section; None if it is none, or cuts an edge open.

    Raises Unreadable for a hole that is not square to its wall, or ends inside where no drill
    comes.
    """
    if not isinstance(cutter, Prism) or cutter.shape is None:
        return None
    place = source if cutter.where is None else replace(source, where=cutter.where)
    low, high = cutter.box
    clear = low[0] > NEAR - start.least and high[0] < end.least - NEAR  # of all planes
    if section.code in ("RO", "RU"):
        return _radial(cutter, cutter.shape, section, place) if clear else None
    walls = walls_of(section)
    if not walls:
        return None  # a special section has no face that a hole could be on
    # The first planes are the stock's own, square ends.
    if high[0] <= start.planes[0].point[0] or low[0] >= end.planes[0].point[0]:
        return []
    features: list[Hole | Slot] = []
    for wall in walls:
        (q0, c0), (q1, c1) = wall.split(low), wall.split(high)
        if (
            c1 - wall.low < TOUCH  # most walls are not touched at all
            or wall.high - c0 < TOUCH
            or c1 - c0 < TOUCH
            or q1 <= TOUCH
            or q0 >= wall.width - TOUCH
        ):
            continue
        lean = abs(wall.split(cutter.frame.z)[1]) / size(cutter.frame.z)
        if SQUARE <= lean < 1 - SQUARE * SQUARE / 2:
            angle = degrees(atan2(sqrt(1 - lean * lean), lean))
            raise Unreadable(f"a hole at {angle:.2f} degrees to face {wall.face}")
        if lean < SQUARE:
            # What it takes of the wall may belong to another one too, square to this.
            bite = min(c1, wall.high) - max(c0, wall.low)
            whole = section.height if wall.normal == "z" else section.width
            within = (
                other.low - THROUGH <= max(q0, 0.0) and min(q1, whole) <= other.high + THROUGH
                for other in walls if other.normal != wall.normal
            )  # fmt: skip
            if bite <= BITE * wall.thickness or any(within):
                continue
            return None  # it runs along inside the wall
        beyond = False if clear else _beyond((low[0], high[0]), (q0, q1), start, end, wall)
        if beyond:
            continue
        if beyond is None or q0 < NEAR or q1 > wall.width - NEAR:
            return None
        features.append(_drilled(cutter, cutter.shape, wall, (c0, c1), place))
    return features


def _beyond(xs: Span, qs: Span, start: Trim, end: Trim, wall: Wall) -> bool | None:
    """Whether a hole lies all beyond an end, where nothing is to drill; None if the end cuts it."""

    def x(end: HalfSpace, q: float) -> float:
        return end.x(wall.surface, q) if wall.normal == "y" else end.x(q, wall.surface)

    for side, edge, planes in (-1, xs[0], start.planes), (1, xs[1], end.planes):
        for plane in planes:
            slope = plane.slopes[wall.normal == "y"]
            nearest = qs[1] if (slope < 0) == (side > 0) else qs[0]
            if side * edge > side * x(plane, nearest) - NEAR:
                inner = xs[1] if side < 0 else xs[0]
                gone = (all(side * inner > side * x(e, q) - NEAR for q in qs) for e in planes)
                return any(gone) or None
    return False


def _drilled(
    cutter: Prism, shape: Round | Slotted, wall: Wall, reach: Span, source: Source
) -> Hole | Slot:
    face, depth = wall.face, None
    from_low, from_high = reach[0] <= wall.low + THROUGH, reach[1] >= wall.high - THROUGH
    if not (from_low and from_high):
        if not from_low and not from_high:
            raise Unreadable("a hollow inside the material")
        outside = from_high if wall.outer else from_low
        depth = reach[1] - wall.low if from_low else wall.high - reach[0]
        if not outside:
            if wall.face != "v":
                raise Unreadable(f"a blind hole from inside of face {wall.face}")
            face = "h"
    factor = size(cutter.frame.x)
    p = cutter.frame.point((*shape.centre, 0.0))
    q = wall.split(p)[0]
    kind: HoleKind = "blind" if depth else "through"
    if isinstance(shape, Round):
        return Hole(face, p[0], q, shape.diameter * factor, source, depth, kind)
    turn = radians(shape.angle)
    way = cutter.frame.vector((cos(turn), sin(turn), 0.0))
    angle = round(degrees(atan2(wall.split(way)[0], way[0])), 7) % 180.0
    sizes = (shape.diameter * factor, shape.length * factor, 0.0, angle)
    return Slot(face, p[0], q, *sizes, source, depth, kind)


def _radial(
    cutter: Prism, shape: Round | Slotted, section: Section, source: Source
) -> list[Hole | Slot] | None:
    """Holes across a round section, unrolled: y runs round it from u over v, in mm of its skin."""
    if not isinstance(shape, Round):
        return None
    r = section.height / 2
    diameter = shape.diameter * size(cutter.frame.x)
    if diameter > WIDEST * 2 * r:
        return None  # a saddle
    along = unit(cutter.frame.z)
    if abs(along[0]) > SQUARE:
        return None
    start = cutter.frame.point((*shape.centre, 0.0))
    y, z = start[1] - r, start[2] - r
    if abs(y * along[2] - z * along[1]) > 0.05:
        if section.code == "RO":
            return None
        raise Unreadable("a hole beside the axis", rules.SOLID_CUT)
    first = y * along[1] + z * along[2]
    last = first + dot(cutter.frame.z, along)
    wall = section.web_thickness if section.code == "RO" else r
    holes: list[Hole | Slot] = []
    for at in (-r, r):
        low, high = sorted((at, at - copysign(wall, at)))
        if first <= low + THROUGH and last >= high - THROUGH:
            way = scale(along, copysign(1.0, at))
            # 0 at the lowest line, a quarter of the round at v, half of it on top.
            angle = atan2(way[2], -way[1]) % (2 * pi)
            holes.append(Hole("v", start[0], angle * r, diameter, source))
        elif min(last, high) - max(first, low) > TOUCH:
            rule = rules.ODD_CUT if section.code == "RO" else rules.SOLID_CUT
            raise Unreadable("a blind hole", rule)
    if section.code == "RU" and len(holes) == 1:
        raise Unreadable("a blind hole", rules.SOLID_CUT)
    return holes[:1] if section.code == "RU" else holes  # a solid bar is drilled from one side
