"""The representation items of an element, and those of them that no straight member has."""

from collections.abc import Iterator

from beamcam.errors import Rule
from beamcam.readers.ifc import rules
from beamcam.readers.ifc.entities import Entity

CURVED = ("IfcRevolvedAreaSolid", "IfcSurfaceCurveSweptAreaSolid", "IfcSweptDiskSolid",
          "IfcFixedReferenceSweptAreaSolid", "IfcDirectrixCurveSweptAreaSolid",
          "IfcSweptDiskSolidPolygonal")  # fmt: skip
TAPERED = ("IfcExtrudedAreaSolidTapered", "IfcRevolvedAreaSolidTapered", "IfcSectionedSpine",
           "IfcSectionedSolidHorizontal")  # fmt: skip


def curved_or_tapered(element: Entity) -> tuple[Rule, str] | None:
    """The rule against a curved or tapered solid of an element, and its class; None without."""
    kinds = {item.is_a() for item in items_below(element) if not _is_straight(item)}
    for rule, names in ((rules.CURVED, CURVED), (rules.TAPERED, TAPERED)):
        for kind in names:
            if kind in kinds:
                return rule, kind
    return None


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
