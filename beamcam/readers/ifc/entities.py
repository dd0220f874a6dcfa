"""Common queries of an IFC file: units, placements, curves' axes.

All lengths that leave this module are millimetres.
"""

from collections import defaultdict
from collections.abc import Callable
from itertools import chain
from typing import Any, TypeVar

from msgspec import UNSET, Struct, UnsetType, field

from beamcam.caches import cached
from beamcam.errors import Rule
from beamcam.readers.ifc import rules
from beamcam.readers.ifc.records import Entity as Entity
from beamcam.readers.ifc.records import File, Missing
from beamcam.readers.ifc.space import IDENTITY, Frame, Vec, across, cross, dot, scale, sub, unit

# --- units ----------------------------------------------------------------------------------------
# The units of a model: what its numbers are in metres, radians and kilograms.

_DEEPEST = 8  #: of units that are defined by others


def scale_of(file: File, kind: str) -> float:
    """The model's unit of a kind in SI: LENGTHUNIT in m, PLANEANGLEUNIT in rad, MASSUNIT in kg.

    1 where the file has none of the kind; inches and degrees are so many of another unit. Raises
    ValueError, LookupError, TypeError or AttributeError for a unit that is not well formed.
    """
    projects = file.by_type("IfcProject")
    assignment = projects[0].UnitsInContext if projects else None
    units = assignment.Units if assignment is not None else ()
    named = (one for one in units if one.is_a("IfcNamedUnit") and one.UnitType == kind)
    unit, by = next(named, None), 1.0
    if unit is None:
        return by
    for _ in range(_DEEPEST):
        if unit.is_a("IfcSIUnit"):
            from ifcopenshell.util.unit import prefixes

            # The base of mass is the gram, so that a kilogram has a prefix.
            base = 1e-3 if unit.Name == "GRAM" else 1.0
            return by * base * (1.0 if unit.Prefix is None else prefixes[unit.Prefix])
        by *= float(unit.ConversionFactor.ValueComponent.value)
        unit = unit.ConversionFactor.UnitComponent
    raise ValueError("a unit that is defined by itself")


Coordinates = tuple[float, ...]  #: an IfcCartesianPoint or an IfcDirection
Placement = tuple[Any, ...]  #: an IfcAxis2Placement: location, and one direction or two
Known = TypeVar("Known")


#: What a reference that is missing, or to the wrong kind of entity, ends in.
NOT_WELL_FORMED = (
    ArithmeticError, AttributeError, LookupError, RuntimeError, TypeError, ValueError,
)  # fmt: skip


class Unreadable(Exception):
    """Something in a member's geometry that the reader does not take; the text says what.

    `final` says that the solid of the kernel would be no other, so that it is not asked for.
    """

    def __init__(self, found: str, rule: Rule = rules.GEOMETRY, *, final: bool = False) -> None:
        super().__init__(found)
        self.rule = rule
        self.final = final


class Model(Struct):
    """An open file with its units and what was already worked out of it."""

    file: File
    data: bytes  #: for other processes, which open the file by themselves
    mm: float  #: mm in the file's length unit
    radians: float  #: radians in the file's plane angle unit
    kilograms: float  #: kg in the file's mass unit
    known: dict[Any, Any] = field(default_factory=dict)  #: by what it is and its key; see `once`

    def once(self, what: str, key: Any, made: Callable[..., Known], *of: Any) -> Known:
        """What a key stands for: `made(*of)`, worked out when it is first asked for."""
        at = what, key
        found: Known | UnsetType = self.known.get(at, UNSET)
        if found is UNSET:
            found = self.known[at] = made(*of)
        return found

    def point(self, c: Coordinates) -> Vec:
        """An IfcCartesianPoint of two or three coordinates, in mm."""
        mm = self.mm
        return (c[0] * mm, c[1] * mm, c[2] * mm if len(c) > 2 else 0.0)

    def axes(self, placement: Placement | None) -> Frame:
        """An IfcAxis2Placement2D or 3D, or the frame itself where there is none."""
        if placement is None:
            return IDENTITY
        return self.once("axes", placement, self._axes, placement)

    def _axes(self, placement: Placement) -> Frame:
        origin, ways = self.point(placement[0]), placement[1:]
        if len(ways) == 1:
            x, y, _ = ratios(ways[0]) or (1.0, 0.0, 0.0)
            along = unit((x, y, 0.0))
            axes: tuple[Vec, ...] = along, (-along[1], along[0], 0.0)
        else:
            axes = right_handed(*map(ratios, ways))
        frame = Frame(origin, *axes)
        return IDENTITY if frame == IDENTITY else frame  # which costs nothing to multiply with

    def placement(self, entity: Entity | None) -> Frame:
        """An IfcObjectPlacement in the world, chained placements included."""
        if entity is None:
            return IDENTITY
        # A damaged file refers to numbers in its place.
        if not isinstance(entity, Entity) or not entity.is_a("IfcLocalPlacement"):
            raise Unreadable("a placement by something else")
        try:
            return self.once("placement", entity, self._placed, entity)
        except RecursionError:
            raise Unreadable("a placement that is relative to itself") from None

    def _placed(self, entity: Entity) -> Frame:
        above = self.placement(entity.PlacementRelTo)
        return above.times(self.axes(entity.RelativePlacement))

    def operator(self, entity: Entity) -> Frame:
        """An IfcCartesianTransformationOperator, its scales and mirrors included."""
        by = entity.Scale if entity.Scale is not None else 1.0
        # Of two dimensions it has no third axis, and if it is uniform no other scales.
        by_y, by_z = (
            by if (stated := getattr(entity, name, None)) is None else stated
            for name in ("Scale2", "Scale3")
        )
        z = unit(ratios(getattr(entity, "Axis3", None)) or (0.0, 0.0, 1.0))
        x = square_to(ratios(entity.Axis1) or (1.0, 0.0, 0.0), z)
        y = cross(z, x)
        drawn = ratios(entity.Axis2)
        if drawn is not None and dot(drawn, y) < 0:
            y = scale(y, -1.0)
        return Frame(self.point(entity.LocalOrigin), scale(x, by), scale(y, by_y), scale(z, by_z))


def ratios(c: Coordinates | None) -> Vec | None:
    """The components of an IfcDirection; None where there is none."""
    if c is None:
        return None
    return (c[0], c[1], c[2] if len(c) > 2 else 0.0)


def square_to(v: Vec, axis: Vec) -> Vec:
    """The unit vector nearest to `v` that is square to the unit vector `axis`."""
    x, y, z = rest = sub(v, scale(axis, dot(v, axis)))
    if abs(x) < 1e-9 and abs(y) < 1e-9 and abs(z) < 1e-9:
        return across(axis)
    return unit(rest)


@cached("ifc.axes")
def right_handed(axis: Vec | None, reference: Vec | None) -> tuple[Vec, Vec, Vec]:
    """The axes of an IfcAxis2Placement3D by its Axis (z) and RefDirection (x)."""
    z = (0.0, 0.0, 1.0) if axis is None else unit(axis)
    x = square_to((1.0, 0.0, 0.0) if reference is None else reference, z)
    return x, cross(z, x), z


# --- relations ------------------------------------------------------------------------------------
# Objects related to elements: property sets, types, materials, assemblies.
#
# #9=IFCRELDEFINESBYPROPERTIES('guid',#5,$,$,(#49,#50),#58);     #58 to #49 and to #50
# #8=IFCRELAGGREGATES('guid',#5,$,$,#61,(#49,#50));              #61 to #49 and to #50

#: The relations by what they tie to elements, and which of their values that is; features are
#: openings and what is added.
_CLASSES = {
    "openings": (("IfcRelVoidsElement",), 5),
    "projections": (("IfcRelProjectsElement",), 5),
    "definitions": (("IfcRelDefinesByProperties",), 5),
    "types": (("IfcRelDefinesByType",), 5),
    "materials": (("IfcRelAssociatesMaterial",), 5),
    "wholes": (("IfcRelAggregates", "IfcRelNests"), 4),
}


def tied(element: Entity, what: str) -> list[Any]:
    """What relations tie to an element: its definitions, types, materials, wholes or features.

    Raises LookupError for an element that is not in the file, Malformed or LookupError if some
    relation of the kind is not well formed.
    """
    if isinstance(element, Missing):
        raise LookupError(f"a reference to {element.name}, which is not in the file")
    known = element.file.tied.get(what)
    if known is None:
        known = defaultdict(list)
        classes, place = _CLASSES[what]
        for relation in chain.from_iterable(map(element.file.by_type, classes)):
            values = relation.values
            near = values[9 - place]
            # None where a relation is cut short, so that only what is near it suffers.
            one = values[place] if place < len(values) else None
            for end in near if isinstance(near, tuple) else (near,):
                if isinstance(end, Entity):
                    known[end.number].append(one)
        element.file.tied[what] = known
    return known.get(element.number, [])


def features_of(element: Entity, what: str) -> list[Entity]:
    """The openings or projections of an element: its own, and those of its wholes.

    An opening in an assembly goes through all that it is made of.
    """
    if not tied(element, what) and not element.file.tied[what]:  # as of most models
        return []
    hosts = [element]
    for host in hosts:
        hosts += [whole for whole in tied(host, "wholes") if whole not in hosts]
    return [feature for host in hosts for feature in tied(host, what)]
