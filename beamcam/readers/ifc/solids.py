"""Solids that are taken away: what each of them is as a cutter."""

from collections.abc import Sequence
from math import hypot

from beamcam.caches import cached
from beamcam.geometry.curves import Arc
from beamcam.readers.ifc.curves2d import chain_of
from beamcam.readers.ifc.cutters import Bounded, Cutter, HalfSpace, Less, Prism, hole_of
from beamcam.readers.ifc.entities import (
    Coordinates,
    Entity,
    Model,
    Placement,
    Unreadable,
    ratios,
    right_handed,
)
from beamcam.readers.ifc.outline import Round, Slotted
from beamcam.readers.ifc.profiles import Outline, definition, outline_of, rounded_box
from beamcam.readers.ifc.shell import shell_of
from beamcam.readers.ifc.space import ORIGIN, Frame, Vec, scale, unit

_FACETED = frozenset(
    (
        "IfcFacetedBrep",
        "IfcTessellatedFaceSet",
        "IfcFaceBasedSurfaceModel",
        "IfcShellBasedSurfaceModel",
    )
)
FAR = 1e6  #: mm; how far the prism of a bounded half-space reaches
UPRIGHT = (0.0, 0.0, 1.0)
ASKEW = 2e-3  #: tangent of the angle by which a hole may be pushed off square


def is_faceted(model: Model, item: Entity) -> bool:
    """Whether a solid is given by its faces."""
    faces = _FACETED if model.file.schema != "IFC2X3" else _FACETED - {"IfcTessellatedFaceSet"}
    return not faces.isdisjoint(item.type.kinds)


def mapping(model: Model, item: Entity, frame: Frame) -> tuple[Frame, tuple[Entity, ...]]:
    """The frame of a mapped item's source and the source's items."""
    source = item.values[0]
    target = model.operator(item.values[1])
    inner = frame.times(target).times(model.axes(source.values[0]))
    return inner, source.values[1].values[3]


def pushed(model: Model, position: Frame, way: Coordinates | None, depth: float) -> Vec:
    """The vector along which a profile is pushed that lies in the plane of `position`."""
    if way is None or way == UPRIGHT:
        return scale(position.z, depth * model.mm)
    return position.vector(scale(unit(ratios(way) or UPRIGHT), depth * model.mm))


def solid_cutters(model: Model, item: Entity, frame: Frame, where: str | None) -> Sequence[Cutter]:
    """Cutters of a solid in `frame`."""
    kind, kinds = item.type.name, item.type.kinds
    if kind == "IfcExtrudedAreaSolid":
        return (_extrusion(model, item, frame, where),)
    if kind == "IfcHalfSpaceSolid":
        return (_half_space(model, item, frame, where),)
    if kind == "IfcPolygonalBoundedHalfSpace":
        half = _half_space(model, item, frame, where)
        position = frame.times(model.axes(item.Position))
        bound = Outline(chain_of(model, item.PolygonalBoundary))
        start = position.point((0.0, 0.0, -FAR))
        column = Frame(start, position.x, position.y, scale(position.z, 2 * FAR))
        return (Bounded(half, Prism(column, bound, where, hole_of(bound)), where),)
    if kind == "IfcMappedItem":
        inner, source = mapping(model, item, frame)
        return [c for one in source for c in solid_cutters(model, one, inner, where)]
    if kind == "IfcCsgSolid":
        return solid_cutters(model, item.TreeRootExpression, frame, where)
    if "IfcBooleanResult" in kinds:
        return _compound(model, item, frame, where)
    if kind in ("IfcRightCircularCylinder", "IfcBlock"):
        return (_primitive(model, item, frame, where),)
    if is_faceted(model, item):
        return (shell_of(model, item, frame, where),)
    raise Unreadable(f"a cut by {kind}")


def _extrusion(model: Model, item: Entity, frame: Frame, where: str | None) -> Prism:
    profile, place, way, depth, *_ = item.values
    outline, hole = model.once("cut-out", definition(profile), _cut_out, model, profile)
    o, axes, even = _standing(model, frame, place)
    along = pushed(model, axes, way, depth)
    if hole is not None and not (even and (way is None or _upright(way))):
        hole = None  # a circle that is pushed askew or stretched is not a circle across its length
    return Prism(Frame(o, axes.x, axes.y, along), outline, where, hole)


def _standing(model: Model, frame: Frame, place: Placement | None) -> tuple[Vec, Frame, bool]:
    """The origin and the axes of a solid that is placed in `frame`, and whether they keep forms."""
    if place is None or len(place) != 3:
        at = frame.times(model.axes(place))
        return at.o, at, at.even
    location, axis, reference = place
    axes, even = _turned(frame.x, frame.y, frame.z, axis, reference)
    return frame.point(model.point(location)), axes, even


@cached("ifc.placement")
def _turned(
    x: Vec, y: Vec, z: Vec, axis: Coordinates | None, reference: Coordinates | None
) -> tuple[Frame, bool]:
    """The axes of a placement by its Axis and RefDirection, in a frame that has the axes x, y, z.

    Behind them whether they keep forms. A model's holes stand in many places, but lie few ways.
    """
    by = Frame(ORIGIN, x, y, z)
    axes = Frame(ORIGIN, *map(by.vector, right_handed(ratios(axis), ratios(reference))))
    return axes, axes.even


def _upright(way: Coordinates) -> bool:
    """Whether a direction is square to the plane of x and y, either way."""
    return way == UPRIGHT or hypot(way[0], way[1]) <= ASKEW * abs(way[2])


def _cut_out(model: Model, profile: Entity) -> tuple[Outline, Round | Slotted | None]:
    """The outline of what is cut out, and the hole or slot that it is."""
    outline = outline_of(model, profile)
    return outline, hole_of(outline)


def _compound(model: Model, item: Entity, frame: Frame, where: str | None) -> Sequence[Cutter]:
    first = tuple(solid_cutters(model, item.FirstOperand, frame, where))
    second = tuple(solid_cutters(model, item.SecondOperand, frame, where))
    if item.Operator == "UNION":
        return first + second
    if item.Operator == "DIFFERENCE":
        return [Less(one, second, where) for one in first]
    return [Bounded(one, other, where) for one in first for other in second]


def _half_space(model: Model, item: Entity, frame: Frame, where: str | None) -> HalfSpace:
    surface, agreement, *_ = item.values
    if not surface.is_a("IfcPlane"):
        raise Unreadable(f"a cut by a half-space over {surface.is_a()}")
    plane = model.axes(surface.values[0])
    # AgreementFlag true: the half-space lies against the normal of its plane.
    normal = scale(plane.z, -1.0) if agreement else plane.z
    return HalfSpace(plane.o, normal, where).moved(frame)


def _primitive(model: Model, item: Entity, frame: Frame, where: str | None) -> Prism:
    position = frame.times(model.axes(item.Position))
    mm = model.mm
    if item.is_a("IfcBlock"):
        x, y = item.XLength * mm, item.YLength * mm
        middle, up = position.point((x / 2, y / 2, 0.0)), scale(position.z, item.ZLength * mm)
        block = Frame(middle, position.x, position.y, up)
        return Prism(block, Outline(rounded_box(x, y, 0.0)), where)
    radius = item.Radius * mm
    outline = Outline((Arc((0.0, 0.0), radius, 0.0, 360.0),))
    along = scale(position.z, item.Height * mm)
    return Prism(
        Frame(position.o, position.x, position.y, along),
        outline,
        where,
        Round((0.0, 0.0), 2 * radius) if position.even else None,
    )
