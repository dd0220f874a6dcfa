"""The Body of an element: the profile that is swept, and what is subtracted from it.

    IfcBooleanResult            -> the first operand's body, with the second as a cutter
    IfcMappedItem               -> the body of its source, mapped
    IfcRelVoidsElement          -> cutters, openings and voiding features alike

Everything is in the element's own coordinates, in mm; the element's placement only says where in
the building it is, and its large numbers are kept out.
"""

from collections.abc import Iterator

from msgspec import Struct

from beamcam.readers.ifc import rules
from beamcam.readers.ifc.cutters import Cutter
from beamcam.readers.ifc.entities import Bent, Entity, Model, Unreadable, features_of
from beamcam.readers.ifc.shell import Shell, shell_of
from beamcam.readers.ifc.solids import is_faceted, mapping, pushed, solid_cutters
from beamcam.readers.ifc.space import IDENTITY, Frame, Vec

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


class Swept(Struct, frozen=True, gc=False):
    """A profile pushed along a vector; the profile lies in the plane of `frame`."""

    profile: Entity
    frame: Frame
    along: Vec


class Removed(Struct, frozen=True, gc=False):
    """A solid that is taken away; it stands in `frame`, in the element's coordinates."""

    item: Entity
    frame: Frame
    where: str | None = None  #: the GlobalId of its opening


class Body(Struct, frozen=True, gc=False):
    """Body of a member: one swept profile or one shell, and the solids subtracted from it."""

    base: Swept | Shell
    removed: tuple[Removed, ...]

    def cutters(self, model: Model, to: Frame) -> list[Cutter]:
        """What is taken away, in coordinates in which the element stands in `to`."""
        found: list[Cutter] = []
        stands, frame = IDENTITY, to
        for one in self.removed:
            if one.frame is not stands:  # as few are: a chain of booleans has one frame
                stands, frame = one.frame, to.times(one.frame)
            found += solid_cutters(model, one.item, frame, one.where)
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
    """Solids removed by the openings and voiding features of an element and of its assemblies."""
    for opening in features_of(element, "IfcRelVoidsElement"):
        frame = relative_placement(model, element, opening)
        if opening.values[6] is None:
            raise Unreadable(f"an opening {opening.guid} without geometry")
        guid = opening.guid
        for item in body_representation(opening).values[3]:
            yield Removed(item, frame, guid)


def relative_placement(model: Model, element: Entity, other: Entity) -> Frame:
    """Placement of `other` in the coordinates of `element`."""
    mine, its = element.values[5], other.values[5]
    if its is not None and mine is not None and its.is_a("IfcLocalPlacement"):
        relative = its.values[0]
        # Directly below the element the world's large numbers never come in.
        if relative is mine:
            return model.axes(its.values[1])
    return model.placement(mine).inverse().times(model.placement(its))


def _item(model: Model, item: Entity, frame: Frame) -> tuple[Swept | Shell, list[Removed]]:
    """What a representation item that stands in `frame` is made of, and what is taken from it."""
    kinds = item.type.kinds
    if item.type.name == "IfcExtrudedAreaSolid":
        return _swept(model, item, frame), []
    if "IfcBooleanResult" in kinds:
        taken = []
        seen = set[Entity]()
        while "IfcBooleanResult" in item.type.kinds:
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
    if is_faceted(model, item):
        return shell_of(model, item, frame), []
    raise Unreadable(f"a solid by {item.type.name}")


def _swept(model: Model, item: Entity, frame: Frame) -> Swept:
    profile, place, way, depth, *_ = item.values
    position = frame.times(model.axes(place))
    return Swept(profile, position, pushed(model, position, way, depth))


# --- items ----------------------------------------------------------------------------------------

# The representation items of an element, and those of them that no straight member has.


CURVED = ("IfcRevolvedAreaSolid", "IfcSurfaceCurveSweptAreaSolid", "IfcSweptDiskSolid",
          "IfcFixedReferenceSweptAreaSolid", "IfcDirectrixCurveSweptAreaSolid",
          "IfcSweptDiskSolidPolygonal")  # fmt: skip
TAPERED = ("IfcExtrudedAreaSolidTapered", "IfcRevolvedAreaSolidTapered", "IfcSectionedSpine",
           "IfcSectionedSolidHorizontal")  # fmt: skip


def refuse_bent(element: Entity) -> None:
    """Raise Bent for an element one of whose solids is curved or tapered."""
    kinds = {item.is_a() for item in items_below(element) if not _is_straight(item)}
    for rule, names in ((rules.CURVED, CURVED), (rules.TAPERED, TAPERED)):
        for kind in names:
            if kind in kinds:
                raise Bent(rule, kind)


def items_below(element: Entity) -> Iterator[Entity]:
    """All representation items of an element, through maps and booleans."""
    todo = []
    if element.Representation is not None:
        for representation in element.Representation.Representations:
            if representation.RepresentationIdentifier not in ("Axis", "Box", "FootPrint"):
                todo += list(representation.Items)
    seen = set[Entity]()
    while todo:
        item = todo.pop()
        if item in seen:  # shared, or geometry that contains itself
            continue
        seen.add(item)
        yield item
        if item.is_a("IfcMappedItem"):
            todo += list(item.MappingSource.MappedRepresentation.Items)
        elif item.is_a("IfcBooleanResult"):
            todo.append(item.FirstOperand)
        elif item.is_a("IfcCsgSolid"):
            todo.append(item.TreeRootExpression)


def _is_straight(item: Entity) -> bool:
    """Whether a solid is a disc or a ring that is swept along one line: a rod or a pipe."""
    if not item.is_a("IfcSweptDiskSolid"):
        return False
    line = item.Directrix
    return (line.is_a("IfcPolyline") and len(line.Points) == 2) or (
        line.is_a("IfcTrimmedCurve") and bool(line.BasisCurve.is_a("IfcLine"))
    )
