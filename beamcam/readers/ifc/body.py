"""The Body of an element: the profile that is swept, and what is subtracted from it.

    IfcBooleanResult            -> the first operand's body, with the second as a cutter
    IfcMappedItem               -> the body of its source, mapped
    IfcRelVoidsElement          -> cutters, openings and voiding features alike

Everything is in the element's own coordinates, in mm; the element's placement only says where in
the building it is, and its large numbers are kept out.
"""

from collections.abc import Iterator

from msgspec import Struct
from msgspec.structs import replace

from beamcam.geometry.curves import Arc
from beamcam.readers.ifc.cutters import Bounded, Cutter, HalfSpace, Less, Prism, hole_of, prism
from beamcam.readers.ifc.entities import Entity, Model, Unreadable, ratios
from beamcam.readers.ifc.facets import shell_of
from beamcam.readers.ifc.outline import Round, Slotted
from beamcam.readers.ifc.profiles import Outline, definition, outline_of, rounded_box
from beamcam.readers.ifc.shell import Shell
from beamcam.readers.ifc.space import IDENTITY, Frame, Vec, scale, unit

_FACETED = (
    "IfcFacetedBrep",
    "IfcTessellatedFaceSet",
    "IfcFaceBasedSurfaceModel",
    "IfcShellBasedSurfaceModel",
)
_SKIPPED_REPRESENTATIONS = (
    "Axis",
    "BoundingBox",
    "Box",
    "FootPrint",
    "Profile",
    "CoG",
    "Clearance",
)
_FLAT_TYPES = ("Curve2D", "Curve3D", "Curve", "BoundingBox", "GeometricCurveSet", "Point")
FAR = 1e6  #: mm; how far the prism of a bounded half-space reaches


class Swept(Struct, frozen=True):
    """A profile pushed along a vector; the profile lies in the plane of `frame`."""

    profile: Entity
    frame: Frame
    along: Vec


class Body(Struct, frozen=True):
    """What a member is made of: one swept profile or one shell, and what is taken from it."""

    base: Swept | Shell
    cutters: tuple[Cutter, ...]


def body_of(model: Model, element: Entity) -> Body:
    """The body of an element with its openings. Raises Unreadable, which says what was found."""
    representation = body_representation(element)
    bodies = [_item(model, item, IDENTITY, None) for item in representation.values[3]]
    if len(bodies) != 1:
        raise Unreadable(f"a body of {len(bodies)} solids")
    (body,) = bodies
    return replace(body, cutters=(*body.cutters, *openings_of(model, element)))


def body_representation(element: Entity) -> Entity:
    """The representation that holds the solid; its identifier is Body, or missing in old files."""
    shape = element.values[6]
    if shape is None:
        raise Unreadable("no geometry")
    candidates: list[Entity] = [
        r
        for r in shape.values[2]
        if r.values[1] not in _SKIPPED_REPRESENTATIONS
        and r.values[2] not in _FLAT_TYPES
        and r.values[3]
    ]
    for wanted in ("Body", None, "", "Facetation", "Body-FallBack"):
        for one in candidates:
            if one.values[1] == wanted:
                return one
    if candidates:
        return candidates[0]
    raise Unreadable("no solid geometry")


def openings_of(model: Model, element: Entity) -> Iterator[Cutter]:
    """What the openings and voiding features of an element remove, in its coordinates."""
    voids = getattr(element, "HasOpenings", ())
    if not voids:
        return
    for relation in voids:
        opening = relation.values[5]
        frame = relative_placement(model, element, opening)
        if opening.values[6] is None:
            raise Unreadable(f"an opening {opening.GlobalId} without geometry")
        guid = opening.values[0]
        for item in body_representation(opening).values[3]:
            yield from _solid_cutters(model, item, frame, guid)


def relative_placement(model: Model, element: Entity, other: Entity) -> Frame:
    """Where `other` stands in the coordinates of `element`."""
    mine, its = element.values[5], other.values[5]
    if its is not None and mine is not None and its.is_a("IfcLocalPlacement"):
        relative = its.values[0]
        # Directly below the element the world's large numbers never come in.
        if relative is mine:
            return model.axes(its.values[1])
    return model.placement(mine).inverse().times(model.placement(its))


def _item(model: Model, item: Entity, frame: Frame, where: str | None) -> Body:
    """The body of a representation item that stands in `frame`."""
    kind = item.row.name
    if kind == "IfcExtrudedAreaSolid":
        return Body(_swept(model, item, frame), ())
    if item.is_a("IfcBooleanResult"):
        chain = []
        seen = set[Entity]()
        while item.is_a("IfcBooleanResult"):
            if item in seen:
                raise Unreadable("geometry that contains itself")
            seen.add(item)
            operator, first, second = item.values
            if operator != "DIFFERENCE":
                raise Unreadable(f"a boolean {operator}")
            chain.append(second)
            item = first
        body = _item(model, item, frame, where)
        taken = [
            c for second in reversed(chain) for c in _solid_cutters(model, second, frame, where)
        ]
        return Body(body.base, (*body.cutters, *taken))
    if kind == "IfcMappedItem":
        inner, source = mapping(model, item, frame)
        if len(source) != 1:
            raise Unreadable(f"a mapped body of {len(source)} solids")
        return _item(model, source[0], inner, where)
    if kind == "IfcCsgSolid":
        return _item(model, item.TreeRootExpression, frame, where)
    if any(
        item.is_a(name)
        for name in _FACETED
        if name != "IfcTessellatedFaceSet" or model.file.schema != "IFC2X3"
    ):
        return Body(shell_of(model, item, frame), ())
    raise Unreadable(f"a solid by {kind}")


def mapping(model: Model, item: Entity, frame: Frame) -> tuple[Frame, tuple[Entity, ...]]:
    """The frame of a mapped item's source and the source's items."""
    source = item.values[0]
    target = model.operator(item.values[1])
    inner = frame.times(target).times(model.axes(source.values[0]))
    return inner, source.values[1].values[3]


def _swept(model: Model, item: Entity, frame: Frame) -> Swept:
    profile, place, way, depth, *_ = item.values
    position = frame.times(model.axes(place))
    direction = unit(ratios(way) or (0.0, 0.0, 1.0))
    return Swept(profile, position, position.vector(scale(direction, depth * model.mm)))


def _solid_cutters(model: Model, item: Entity, frame: Frame, where: str | None) -> Iterator[Cutter]:
    """What a solid in `frame` removes."""
    kind = item.row.name
    if kind == "IfcExtrudedAreaSolid":
        swept = _swept(model, item, frame)
        outline, hole = _cut_out(model, swept.profile)
        yield prism(swept.frame, swept.along, outline, where, hole)
    elif kind == "IfcHalfSpaceSolid":
        yield _half_space(model, item, frame, where)
    elif kind == "IfcPolygonalBoundedHalfSpace":
        half = _half_space(model, item, frame, where)
        position = frame.times(model.axes(item.Position))
        bound = outline_of_curve(model, item.PolygonalBoundary)
        start = Frame(position.point((0.0, 0.0, -FAR)), position.x, position.y)
        column = prism(start, scale(position.z, 2 * FAR), bound, where, hole_of(bound))
        yield Bounded(half, column, where)
    elif kind == "IfcMappedItem":
        inner, source = mapping(model, item, frame)
        for one in source:
            yield from _solid_cutters(model, one, inner, where)
    elif kind == "IfcCsgSolid":
        yield from _solid_cutters(model, item.TreeRootExpression, frame, where)
    elif item.is_a("IfcBooleanResult"):
        yield from _compound(model, item, frame, where)
    elif kind in ("IfcRightCircularCylinder", "IfcBlock"):
        yield _primitive(model, item, frame, where)
    elif any(
        item.is_a(name)
        for name in _FACETED
        if name != "IfcTessellatedFaceSet" or model.file.schema != "IFC2X3"
    ):
        yield shell_of(model, item, frame, where)
    else:
        raise Unreadable(f"a cut by {kind}")


def _cut_out(model: Model, profile: Entity) -> tuple[Outline, Round | Slotted | None]:
    """The outline of what is cut out, and the hole or slot that it is; worked out once."""
    key = definition(profile)
    known: tuple[Outline, Round | Slotted | None] | None = model.cut_outs.get(key)
    if known is None:
        outline = outline_of(model, profile)
        known = model.cut_outs[key] = outline, hole_of(outline)
    return known


def _compound(model: Model, item: Entity, frame: Frame, where: str | None) -> Iterator[Cutter]:
    first = tuple(_solid_cutters(model, item.FirstOperand, frame, where))
    second = tuple(_solid_cutters(model, item.SecondOperand, frame, where))
    if item.Operator == "UNION":
        yield from first
        yield from second
    elif item.Operator == "DIFFERENCE":
        for one in first:
            yield Less(one, second, where)
    else:
        for one in first:
            for other in second:
                yield Bounded(one, other, where)


def outline_of_curve(model: Model, curve: Entity) -> Outline:
    """The outline of a bounding curve."""
    from beamcam.readers.ifc.curves2d import chain_of

    return Outline(chain_of(model, curve))


def _half_space(model: Model, item: Entity, frame: Frame, where: str | None) -> HalfSpace:
    surface = item.BaseSurface
    if not surface.is_a("IfcPlane"):
        raise Unreadable(f"a cut by a half-space over {surface.is_a()}")
    plane = model.axes(surface.Position)
    # AgreementFlag true: the half-space lies against the normal of its plane.
    normal = scale(plane.z, -1.0) if item.AgreementFlag else plane.z
    return HalfSpace(plane.o, normal, where).moved(frame)


def _primitive(model: Model, item: Entity, frame: Frame, where: str | None) -> Prism:
    position = frame.times(model.axes(item.Position))
    mm = model.mm
    if item.is_a("IfcBlock"):
        x, y = item.XLength * mm, item.YLength * mm
        corner = Frame(position.point((x / 2, y / 2, 0.0)), position.x, position.y)
        up = scale(position.z, item.ZLength * mm)
        return prism(corner, up, Outline(rounded_box(x, y, 0.0)), where, None)
    radius = item.Radius * mm
    outline = Outline((Arc((0.0, 0.0), radius, 0.0, 360.0),))
    along = scale(position.z, item.Height * mm)
    return Prism(
        Frame(position.o, position.x, position.y, along),
        outline,
        where,
        Round((0.0, 0.0), 2 * radius),
    )
