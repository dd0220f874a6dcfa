"""The Body of an element: the profile that is swept, and what is subtracted from it.

    IfcBooleanResult            -> the first operand's body, with the second as a cutter
    IfcMappedItem               -> the body of its source, mapped
    IfcRelVoidsElement          -> cutters, openings and voiding features alike

Everything is in the element's own coordinates, in mm; the element's placement only says where in
the building it is, and its large numbers are kept out.
"""

from collections.abc import Iterator, Sequence
from functools import lru_cache
from math import hypot
from typing import Any

from msgspec import Struct

from beamcam.geometry.curves import Arc
from beamcam.readers.ifc.cutters import Bounded, Cutter, HalfSpace, Less, Prism, hole_of, prism
from beamcam.readers.ifc.entities import (
    Coordinates,
    Entity,
    Model,
    Placement,
    Unreadable,
    ratios,
    right_handed,
)
from beamcam.readers.ifc.facets import shell_of
from beamcam.readers.ifc.outline import Round, Slotted
from beamcam.readers.ifc.profiles import Outline, definition, outline_of, rounded_box
from beamcam.readers.ifc.shell import Shell
from beamcam.readers.ifc.space import IDENTITY, ORIGIN, Frame, Vec, scale, unit

_FACETED = frozenset(
    (
        "IfcFacetedBrep",
        "IfcTessellatedFaceSet",
        "IfcFaceBasedSurfaceModel",
        "IfcShellBasedSurfaceModel",
    )
)
#: Identifiers of a representation that holds the solid, the best first.
_BODIES = {"Body": 0, None: 1, "": 2, "Facetation": 3, "Body-FallBack": 4}
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
UPRIGHT = (0.0, 0.0, 1.0)
ASKEW = 2e-3  #: tangent of the angle by which a hole may be pushed off square


class Swept(Struct, frozen=True):
    """A profile pushed along a vector; the profile lies in the plane of `frame`."""

    profile: Entity
    frame: Frame
    along: Vec


class Removed(Struct, frozen=True):
    """A solid that is taken away; it stands in `frame`, in the element's coordinates."""

    item: Entity
    frame: Frame
    where: str | None = None  #: the GlobalId of its opening


class Body(Struct, frozen=True):
    """What a member is made of: one swept profile or one shell, and what is taken from it."""

    base: Swept | Shell
    removed: tuple[Removed, ...]

    @property
    def has_openings(self) -> bool:
        return any(one.where is not None for one in self.removed)

    @property
    def form(self) -> tuple[Any, ...]:
        """What two bodies of one stock have in common if they are alike."""
        removed = [(_definition(one.item), one.frame) for one in self.removed]
        return self.base.frame if isinstance(self.base, Swept) else self.base, *removed

    def cutters(self, model: Model, to: Frame) -> list[Cutter]:
        """What is taken away, in coordinates in which the element stands in `to`."""
        found: list[Cutter] = []
        stands, frame = IDENTITY, to
        for one in self.removed:
            if one.frame is not stands:  # as few are: a chain of booleans has one frame
                stands, frame = one.frame, to.times(one.frame)
            found += _solid_cutters(model, one.item, frame, one.where)
        return found


def body_of(model: Model, element: Entity) -> Body:
    """The body of an element with its openings. Raises Unreadable, which says what was found."""
    items = body_representation(element).values[3]
    if len(items) != 1:
        raise Unreadable(f"a body of {len(items)} solids")
    base, removed = _item(model, items[0], IDENTITY)
    return Body(base, (*removed, *openings_of(model, element)))


def body_representation(element: Entity) -> Entity:
    """The representation that holds the solid; its identifier is Body, or missing in old files."""
    shape = element.values[6]
    if shape is None:
        raise Unreadable("no geometry")
    best: Entity | None = None
    first = len(_BODIES) + 1
    for one in shape.values[2]:
        _, identifier, kind, items, *_ = one.values
        if identifier in _SKIPPED_REPRESENTATIONS or kind in _FLAT_TYPES or not items:
            continue
        place = _BODIES.get(identifier, len(_BODIES))
        if place < first:
            best, first = one, place
    if best is None:
        raise Unreadable("no solid geometry")
    return best


def openings_of(model: Model, element: Entity) -> Iterator[Removed]:
    """What the openings and voiding features of an element remove."""
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
            yield Removed(item, frame, guid)


def relative_placement(model: Model, element: Entity, other: Entity) -> Frame:
    """Where `other` stands in the coordinates of `element`."""
    mine, its = element.values[5], other.values[5]
    if its is not None and mine is not None and its.is_a("IfcLocalPlacement"):
        relative = its.values[0]
        # Directly below the element the world's large numbers never come in.
        if relative is mine:
            return model.axes(its.values[1])
    return model.placement(mine).inverse().times(model.placement(its))


def _item(model: Model, item: Entity, frame: Frame) -> tuple[Swept | Shell, list[Removed]]:
    """What a representation item that stands in `frame` is made of, and what is taken from it."""
    kinds = item.row.kinds
    if item.row.name == "IfcExtrudedAreaSolid":
        return _swept(model, item, frame), []
    if "IfcBooleanResult" in kinds:
        taken = []
        seen = set[Entity]()
        while "IfcBooleanResult" in item.row.kinds:
            if item in seen:
                raise Unreadable("geometry that contains itself")
            seen.add(item)
            operator, first, second, *_ = item.values
            if operator != "DIFFERENCE":
                raise Unreadable(f"a boolean {operator}")
            taken.append(Removed(second, frame))
            item = first
        base, removed = _item(model, item, frame)
        return base, removed + taken[::-1]
    if "IfcMappedItem" in kinds:
        inner, source = mapping(model, item, frame)
        if len(source) != 1:
            raise Unreadable(f"a mapped body of {len(source)} solids")
        return _item(model, source[0], inner)
    if "IfcCsgSolid" in kinds:
        return _item(model, item.TreeRootExpression, frame)
    if _faceted(model, item):
        return shell_of(model, item, frame), []
    raise Unreadable(f"a solid by {item.row.name}")


def _faceted(model: Model, item: Entity) -> bool:
    """Whether a solid is given by its faces."""
    faces = _FACETED if model.file.schema != "IFC2X3" else _FACETED - {"IfcTessellatedFaceSet"}
    return not faces.isdisjoint(item.row.kinds)


def mapping(model: Model, item: Entity, frame: Frame) -> tuple[Frame, tuple[Entity, ...]]:
    """The frame of a mapped item's source and the source's items."""
    source = item.values[0]
    target = model.operator(item.values[1])
    inner = frame.times(target).times(model.axes(source.values[0]))
    return inner, source.values[1].values[3]


def _swept(model: Model, item: Entity, frame: Frame) -> Swept:
    profile, place, way, depth, *_ = item.values
    position = frame.times(model.axes(place))
    return Swept(profile, position, _pushed(model, position, way, depth))


def _pushed(model: Model, position: Frame, way: Coordinates | None, depth: float) -> Vec:
    """The vector along which a profile is pushed that lies in the plane of `position`."""
    if way is None or way == UPRIGHT:
        return scale(position.z, depth * model.mm)
    return position.vector(scale(unit(ratios(way) or UPRIGHT), depth * model.mm))


def _solid_cutters(model: Model, item: Entity, frame: Frame, where: str | None) -> Sequence[Cutter]:
    """What a solid in `frame` removes."""
    kind, kinds = item.row.name, item.row.kinds
    if kind == "IfcExtrudedAreaSolid":
        return (_extrusion(model, item, frame, where),)
    if kind == "IfcHalfSpaceSolid":
        return (_half_space(model, item, frame, where),)
    if kind == "IfcPolygonalBoundedHalfSpace":
        half = _half_space(model, item, frame, where)
        position = frame.times(model.axes(item.Position))
        bound = outline_of_curve(model, item.PolygonalBoundary)
        start = Frame(position.point((0.0, 0.0, -FAR)), position.x, position.y)
        column = prism(start, scale(position.z, 2 * FAR), bound, where, hole_of(bound))
        return (Bounded(half, column, where),)
    if kind == "IfcMappedItem":
        inner, source = mapping(model, item, frame)
        return [c for one in source for c in _solid_cutters(model, one, inner, where)]
    if kind == "IfcCsgSolid":
        return _solid_cutters(model, item.TreeRootExpression, frame, where)
    if "IfcBooleanResult" in kinds:
        return _compound(model, item, frame, where)
    if kind in ("IfcRightCircularCylinder", "IfcBlock"):
        return (_primitive(model, item, frame, where),)
    if _faceted(model, item):
        return (shell_of(model, item, frame, where),)
    raise Unreadable(f"a cut by {kind}")


def _extrusion(model: Model, item: Entity, frame: Frame, where: str | None) -> Prism:
    profile, place, way, depth, *_ = item.values
    outline, hole = _cut_out(model, profile)
    at, even = _standing(model, frame, place)
    along = _pushed(model, at, way, depth)
    if hole is not None and not (even and (way is None or _upright(way))):
        hole = None  # a circle that is pushed askew or stretched is none across its length
    return Prism(Frame(at.o, at.x, at.y, along), outline, where, hole)


def _standing(model: Model, frame: Frame, place: Placement | None) -> tuple[Frame, bool]:
    """The frame of a solid that is placed in `frame`, and whether forms are kept in it."""
    if place is None or len(place) != 3:
        at = frame.times(model.axes(place))
        return at, at.even
    location, axis, reference = place
    *axes, even = _turned(frame.x, frame.y, frame.z, axis, reference)
    return Frame(frame.point(model.point(location)), *axes), even


@lru_cache(4096)
def _turned(
    x: Vec, y: Vec, z: Vec, axis: Coordinates | None, reference: Coordinates | None
) -> tuple[Vec, Vec, Vec, bool]:
    """The axes of a placement by its Axis and RefDirection, in a frame that has the axes x, y, z.

    Behind them whether forms are kept. A model's holes stand in many places, but lie few ways.
    """
    by = Frame(ORIGIN, x, y, z)
    a, b, c = (by.vector(v) for v in right_handed(ratios(axis), ratios(reference)))
    return a, b, c, Frame(ORIGIN, a, b, c).even


def _upright(way: Coordinates) -> bool:
    """Whether a direction is square to the plane of x and y, either way."""
    return way == UPRIGHT or hypot(way[0], way[1]) <= ASKEW * abs(way[2])


def _definition(item: Entity) -> Any:
    """What two solids of one form have in common; of most kinds a solid is its own form only."""
    kind = item.row.name
    if kind == "IfcExtrudedAreaSolid":
        profile, *rest = item.values
        return definition(profile), *rest
    if kind == "IfcHalfSpaceSolid":
        surface, agreement, *_ = item.values
        return surface.row.name, surface.values, agreement
    return item


def _cut_out(model: Model, profile: Entity) -> tuple[Outline, Round | Slotted | None]:
    """The outline of what is cut out, and the hole or slot that it is; worked out once."""
    key = definition(profile)
    known: tuple[Outline, Round | Slotted | None] | None = model.cut_outs.get(key)
    if known is None:
        outline = outline_of(model, profile)
        known = model.cut_outs[key] = outline, hole_of(outline)
    return known


def _compound(model: Model, item: Entity, frame: Frame, where: str | None) -> Sequence[Cutter]:
    first = tuple(_solid_cutters(model, item.FirstOperand, frame, where))
    second = tuple(_solid_cutters(model, item.SecondOperand, frame, where))
    if item.Operator == "UNION":
        return first + second
    if item.Operator == "DIFFERENCE":
        return [Less(one, second, where) for one in first]
    return [Bounded(one, other, where) for one in first for other in second]


def outline_of_curve(model: Model, curve: Entity) -> Outline:
    """The outline of a bounding curve."""
    from beamcam.readers.ifc.curves2d import chain_of

    return Outline(chain_of(model, curve))


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
        Round((0.0, 0.0), 2 * radius) if position.even else None,
    )
