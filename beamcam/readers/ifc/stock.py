"""Stock of a member: a section between two ends, or a plate, and its placement."""

from msgspec import Struct

from beamcam.readers.ifc.body import Swept
from beamcam.readers.ifc.curves2d import Chain
from beamcam.readers.ifc.entities import Entity, Model, Unreadable
from beamcam.readers.ifc.plates import Plate, plate_of
from beamcam.readers.ifc.profiles import section_of
from beamcam.readers.ifc.section import Section
from beamcam.readers.ifc.space import Frame, Vec, add, cross, dot, size, unit


class Stock(Struct, frozen=True, gc=False):
    """Stock of a member in its own frame: a section between two x."""

    section: Section
    frame: Frame  #: the member's coordinates in the element's
    x0: float
    x1: float
    outline: Chain = ()  #: of a plate, in (x, y); none of a full rectangle
    hollows: tuple[Chain, ...] = ()


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
        return plate_stock(plate, base.frame, base.along, depth, factor)
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


def plate_stock(
    plate: Plate, at: Frame, along: Vec, thickness: float, factor: float = 1.0
) -> Stock:
    """The stock of a plate that is pushed `along`, which is its thickness, off the plane of `at`.

    Its measures grow by a factor.
    """
    x = unit(at.vector((*plate.x, 0.0)))
    y = unit(at.vector((*plate.y, 0.0)))
    z = cross(x, y)
    o = at.point((*plate.origin, 0.0))
    if dot(z, along) < 0:
        o = add(o, along)
    width, length = plate.width * factor, plate.length * factor
    section = Section(
        "B", width, thickness, 0.0, thickness, 0.0, (0.0, 0.0), (0.0, 1.0), (1.0, 0.0),
        width * thickness,
    )  # fmt: skip
    matrix = ((factor, 0.0, 0.0), (0.0, factor, 0.0))
    outline, *hollows = (
        tuple(c.transformed(matrix) for c in chain) for chain in (plate.outline, *plate.hollows)
    )
    return Stock(section, Frame(o, x, y, z), 0.0, length, outline, tuple(hollows))
