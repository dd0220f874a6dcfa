"""Stock of a member: a section between two ends, or a plate, and its placement."""

from math import atan2, hypot

from msgspec import Struct
from msgspec.structs import replace

from beamcam.geometry.curves import Line, Point
from beamcam.geometry.plane import Box
from beamcam.readers.ifc.body import Swept
from beamcam.readers.ifc.classify import classify
from beamcam.readers.ifc.curves2d import Chain, box_around
from beamcam.readers.ifc.entities import Entity, Model, Unreadable
from beamcam.readers.ifc.outline import with_arcs
from beamcam.readers.ifc.profiles import Outline, moved, outline_of, section_of
from beamcam.readers.ifc.section import BareStock, Section
from beamcam.readers.ifc.space import Frame, Vec, add, cross, dot, size, unit

# --- plates ---------------------------------------------------------------------------------------
# Plates: an outline that is pushed through its thickness.

_FLAT = frozenset(("IfcRectangleProfileDef", "IfcCircleProfileDef", "IfcTrapeziumProfileDef"))
THIN = 0.3  #: of the lesser side, below which an outline of a rolled form is a plate all the same
TIGHTER = 0.98  #: of the area of the box as drawn, for another box to be taken


class Plate(Struct, frozen=True, gc=False):
    """Placement of a plate in its profile's plane, and its outline in its own (x, y)."""

    frame: Frame
    length: float
    width: float
    outline: Chain = ()  #: none where it is the full rectangle
    hollows: tuple[Chain, ...] = ()


def plate_of(model: Model, element: Entity, profile: Entity, depth: float) -> Plate | None:
    """The plate that a profile pushed by `depth` is; None if it is a bar of that section."""
    kinds = profile.type.kinds
    if "IfcParameterizedProfileDef" in kinds and kinds.isdisjoint(_FLAT):
        return None  # a rolled form
    key = profile, depth, element.is_a()
    return model.once("plate", key, _plate_of, model, element, profile, depth)


def _plate_of(model: Model, element: Entity, profile: Entity, depth: float) -> Plate | None:
    try:
        outline = outline_of(model, profile)
    except Unreadable:
        return None
    if 2 * depth > sum(c.length for c in outline.outer):
        return None  # a closed curve is at least twice as long as what it spans: a bar
    x0, y0, x1, y1 = box_around(outline.outer)
    if depth > hypot(x1 - x0, y1 - y0):
        return None  # longer than any side: a bar
    plate = box_of(outline)
    section = classify(outline.outer, outline.inner)
    if section is None:
        return plate
    least = min(plate.length, plate.width)
    if profile.is_a("IfcCircleHollowProfileDef"):
        is_bar = depth >= profile.WallThickness * model.mm
    elif section.code in ("M", "RO"):
        is_bar = True
    elif section.code == "B" or (section.code == "SO" and element.is_a("IfcPlate")):
        is_bar = depth >= least * (1 - 1e-9)
    else:
        is_bar = depth > THIN * least
    if is_bar:
        return None
    sides = section.code == "B" and len(plate.outline) == 4
    full = sides and abs(section.area - plate.length * plate.width) < 0.01
    return replace(plate, outline=()) if full else plate


def box_of(outline: Outline) -> Plate:
    """The minimum bounding box of an outline, x along its longer side; as drawn if as small."""
    curves = with_arcs(outline.outer)

    def spread(way: Point) -> Box:
        """The box along a direction and square to it."""
        c, s = way
        return box_around(tuple(k.transformed(((c, s, 0.0), (-s, c, 0.0))) for k in curves))

    def size_of(way: Point) -> float:
        x0, y0, x1, y1 = spread(way)
        return (x1 - x0) * (y1 - y0)

    ways = {0.0: (1.0, 0.0)}
    for curve in curves:
        if isinstance(curve, Line) and curve.length > 1.0:
            x, y = curve.tangent(0.0)
            while x <= 0.0 or y < 0.0:  # sides that are square to one another have one box
                x, y = y, -x
            ways.setdefault(round(atan2(y, x), 6), (x, y))
    best = min(ways.values(), key=size_of)
    if size_of(best) >= TIGHTER * size_of(ways[0.0]):
        best = ways[0.0]
    x0, y0, x1, y1 = spread(best)
    if y1 - y0 > x1 - x0:
        best = -best[1], best[0]
        x0, y0, x1, y1 = spread(best)
    (c, s), at = best, (x0 * best[0] - y0 * best[1], x0 * best[1] + y0 * best[0])
    frame = Frame((*at, 0.0), (c, s, 0.0), (-s, c, 0.0))
    outer, *inner = (moved(chain, frame.inverse()) for chain in (curves, *outline.inner))
    return Plate(frame, x1 - x0, y1 - y0, outer, tuple(inner))


class Stock(Struct, frozen=True, gc=False):
    """Stock of a member in its own frame: a section between two x."""

    section: Section
    frame: Frame  #: the member's coordinates in the element's
    x0: float
    x1: float
    outline: Chain = ()  #: of a plate, in (x, y); none of a full rectangle
    hollows: tuple[Chain, ...] = ()
    bare: BareStock | None = None  #: the section, where the faces of a shell show it


def stock_of(model: Model, element: Entity, base: Swept) -> Stock:
    """The stock and the frame of the member that a swept profile is."""
    depth = size(base.along)
    plane = unit(cross(base.frame.x, base.frame.y))
    if depth <= 0 or abs(abs(dot(plane, base.along)) - depth) > 1e-6 * depth:
        raise Unreadable("a profile that is extruded at a slant")
    factor = size(base.frame.x)
    if abs(size(base.frame.y) - factor) > 1e-6 * factor:
        raise Unreadable("a profile that is stretched unevenly")
    plate = plate_of(model, element, base.profile, depth / factor)
    if plate is not None:
        return plate_stock(plate, base.frame, base.along)
    section = section_of(model, base.profile)
    frame = _frame(section, base.frame)
    if dot(frame.x, base.along) < 0:
        section = section.turned()
        frame = _frame(section, base.frame)
    if abs(factor - 1.0) >= 1e-12:
        section = section.scaled(factor)
    reach_x = dot(frame.x, base.along)
    return Stock(section, frame, min(0.0, reach_x), max(0.0, reach_x))


def _frame(section: Section, at: Frame) -> Frame:
    """The member's axes: Y and Z as the section lies, X square to both."""
    o = at.point((*section.origin, 0.0))
    y = unit(at.vector((*section.y, 0.0)))
    z = unit(at.vector((*section.z, 0.0)))
    return Frame(o, cross(y, z), y, z)


def plate_stock(plate: Plate, at: Frame, along: Vec) -> Stock:
    """The stock of a plate that is pushed through its thickness off the plane of `at`."""
    factor, thickness = size(at.x), size(along)
    lies = at.times(plate.frame)
    o, x, y = lies.o, unit(lies.x), unit(lies.y)
    z = cross(x, y)
    if dot(z, along) < 0:
        o = add(o, along)
    width = plate.width * factor
    sizes, area = (width, thickness, 0.0, thickness, 0.0), width * thickness
    section = Section("B", *sizes, (0.0, 0.0), (0.0, 1.0), (1.0, 0.0), area)
    matrix = ((factor, 0.0, 0.0), (0.0, factor, 0.0))
    outline, *hollows = (
        tuple(c.transformed(matrix) for c in chain) for chain in (plate.outline, *plate.hollows)
    )
    frame = Frame(o, x, y, z)
    return Stock(section, frame, 0.0, plate.length * factor, outline, tuple(hollows))
