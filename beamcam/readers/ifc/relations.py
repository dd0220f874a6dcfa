"""Objects related to elements: property sets, types, materials, assemblies.

#9=IFCRELDEFINESBYPROPERTIES('guid',#5,$,$,(#49,#50),#58);     #58 to #49 and to #50
#8=IFCRELAGGREGATES('guid',#5,$,$,#61,(#49,#50));              #61 to #49 and to #50
"""

from collections import defaultdict
from typing import Any

from beamcam.readers.ifc.records import Entity, File, Missing

#: The relations by what they tie to elements, and which of their values that is.
_CLASSES = {
    "definitions": (("IfcRelDefinesByProperties",), 5),
    "types": (("IfcRelDefinesByType",), 5),
    "materials": (("IfcRelAssociatesMaterial",), 5),
    "wholes": (("IfcRelAggregates", "IfcRelNests"), 4),
}


def tied(element: Entity, what: str) -> list[Any]:
    """What relations tie to an element: its definitions, types, materials or wholes.

    Raises LookupError for an element that is not in the file, Malformed or LookupError if some
    relation of the kind is not well formed.
    """
    if isinstance(element, Missing):
        raise LookupError(f"a reference to {element.name}, which is not in the file")
    known = element.file.tied.get(what)
    if known is None:
        known = element.file.tied[what] = _tied(element.file, what)
    return known.get(element.number, [])


def features_of(element: Entity, relation: str) -> list[Entity]:
    """The features that relations of a class give an element: its own, and those of its wholes.

    An opening in an assembly goes through all that it is made of.
    """
    related = element.file.related(relation)
    if not related:
        return []
    hosts = [element]
    for host in hosts:
        hosts += [whole for whole in tied(host, "wholes") if whole not in hosts]
    return [one.values[5] for host in hosts for one in related.get(host, ())]


def _tied(file: File, what: str) -> dict[int, list[Any]]:
    """As `tied`, by the numbers of all elements."""
    classes, place = _CLASSES[what]
    found: dict[int, list[Any]] = defaultdict(list)
    for name in classes:
        for near, one in file.sides(name, 9 - place, place):
            for element in near if isinstance(near, tuple) else (near,):
                if isinstance(element, Entity):
                    found[element.number].append(one)
    return dict(found)
