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
from beamcam.readers.ifc.cutters import Bounded, Cutter, HalfSpace, Less, Prism, prism
from beamcam.readers.ifc.entities import Entity, Model, Unreadable, argument, ratios
from beamcam.readers.ifc.facets import shell_of
from beamcam.readers.ifc.outline import Round
from beamcam.readers.ifc.profiles import Outline, outline_of, rounded_box
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
    bodies = [_item(model, item, IDENTITY, None) for item in argument(representation, 3)]
    if len(bodies) != 1:
        raise Unreadable(f"a body of {len(bodies)} solids")
    (body,) = bodies
    return replace(body, cutters=(*body.cutters, *openings_of(model, element)))


def body_representation(element: Entity) -> Entity:
    """The representation that holds the solid; its identifier is Body, or missing in old files."""
    shape = argument(element, 6)
    if shape is None:
        raise Unreadable("no geometry")
    candidates = [
        r
        for r in argument(shape, 2)
        if argument(r, 1) not in _SKIPPED_REPRESENTATIONS
        and argument(r, 2) not in _FLAT_TYPES
        and argument(r, 3)
    ]
    for wanted in ("Body", None, "", "Facetation", "Body-FallBack"):
        for one in candidates:
            if argument(one, 1) == wanted:
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
        opening = argument(relation, 5)
        frame = relative_placement(model, element, opening)
        if argument(opening, 6) is None:
            raise Unreadable(f"an opening {opening.GlobalId} without geometry")
        guid = argument(opening, 0)
        for item in argument(body_representation(opening), 3):
            yield from _solid_cutters(model, item, frame, guid)


def relative_placement(model: Model, element: Entity, other: Entity) -> Frame:
    """Where `other` stands in the coordinates of `element`."""
    mine, its = argument(element, 5), argument(other, 5)
    if its is not None and mine is not None and its.is_a("IfcLocalPlacement"):
        relative = argument(its, 0)
        # Directly below the element the world's large numbers never come in.
        if relative is not None and relative.id() == mine.id():
            return model.axes(argument(its, 1))
    return model.placement(mine).inverse().times(model.placement(its))


def _item(model: Model, item: Entity, frame: Frame, where: str | None) -> Body:
    """The body of a representation item that stands in `frame`."""
    kind = item.is_a()
    if kind == "IfcExtrudedAreaSolid":
        return Body(_swept(model, item, frame), ())
    if item.is_a("IfcBooleanResult"):
        chain = []
        seen = set[int]()
        while item.is_a("IfcBooleanResult"):
            if item.id() in seen:
                raise Unreadable("geometry that contains itself")
            seen.add(item.id())
            if item.Operator != "DIFFERENCE":
                raise Unreadable(f"a boolean {item.Operator}")
            chain.append(item.SecondOperand)
            item = item.FirstOperand
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
    source = argument(item, 0)
    target = model.operator(argument(item, 1))
    inner = frame.times(target).times(model.axes(argument(source, 0)))
    return inner, argument(argument(source, 1), 3)


def _swept(model: Model, item: Entity, frame: Frame) -> Swept:
    position = frame.times(model.axes(argument(item, 1)))
    direction = unit(ratios(argument(item, 2)) or (0.0, 0.0, 1.0))
    along = position.vector(scale(direction, argument(item, 3) * model.mm))
    return Swept(argument(item, 0), position, along)


def _solid_cutters(model: Model, item: Entity, frame: Frame, where: str | None) -> Iterator[Cutter]:
    """What a solid in `frame` removes."""
    kind = item.is_a()
    if kind == "IfcExtrudedAreaSolid":
        swept = _swept(model, item, frame)
        yield _drill(model, swept, where) or prism(
            swept.frame, swept.along, outline_of(model, swept.profile), where
        )
    elif kind == "IfcHalfSpaceSolid":
        yield _half_space(model, item, frame, where)
    elif kind == "IfcPolygonalBoundedHalfSpace":
        half = _half_space(model, item, frame, where)
        position = frame.times(model.axes(item.Position))
        bound = outline_of_curve(model, item.PolygonalBoundary)
        start = Frame(position.point((0.0, 0.0, -FAR)), position.x, position.y)
        yield Bounded(half, prism(start, scale(position.z, 2 * FAR), bound, where), where)
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


def _drill(model: Model, swept: Swept, where: str | None) -> Prism | None:
    """The cutter of a round hole, which most cuts are, without a look at its outline."""
    profile, at = swept.profile, swept.frame
    if profile.is_a() != "IfcCircleProfileDef":
        return None
    position = model.axes(argument(profile, 2))
    radius = argument(profile, 3) * model.mm
    centre = (position.o[0], position.o[1])
    outline = Outline((Arc(centre, radius, 0.0, 360.0),))
    frame = Frame(at.o, at.x, at.y, swept.along)
    return Prism(frame, outline, where, Round(centre, 2 * radius))


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
        return prism(
            corner, scale(position.z, item.ZLength * mm), Outline(rounded_box(x, y, 0.0)), where
        )
    radius = item.Radius * mm
    outline = Outline((Arc((0.0, 0.0), radius, 0.0, 360.0),))
    along = scale(position.z, item.Height * mm)
    return Prism(
        Frame(position.o, position.x, position.y, along),
        outline,
        where,
        Round((0.0, 0.0), 2 * radius),
    )
