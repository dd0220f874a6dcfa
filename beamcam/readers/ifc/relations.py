"""Objects related to elements: property sets, types, materials, assemblies.

    #9=IFCRELDEFINESBYPROPERTIES('guid',#5,$,$,(#49,#50),#58);     #58 to #49 and to #50
    #8=IFCRELAGGREGATES('guid',#5,$,$,#61,(#49,#50));              #61 to #49 and to #50

A relation's last two values are its sides, so that it can be read from its end, without a look at
what stands before.
"""

import re
from collections import defaultdict

from beamcam.readers.ifc.records import Entity, File

#: The relations by what they tie to elements, and which of their values that is.
_CLASSES = {
    "definitions": (("IfcRelDefinesByProperties",), 5),
    "types": (("IfcRelDefinesByType",), 5),
    "materials": (("IfcRelAssociatesMaterial",), 5),
    "wholes": (("IfcRelAggregates", "IfcRelNests"), 4),
}
_ELEMENTS, _ONE = r"\((?P<elements>#\d++(?:,#\d++)*+)\)", r"(?P<one>#\d++)"
_SIDES = {4: re.compile(f",{_ONE},{_ELEMENTS}"), 5: re.compile(f",{_ELEMENTS},{_ONE}")}


def tied(element: Entity, what: str) -> list[str]:
    """The names of what relations tie to an element: definitions, types, materials or wholes.

    Raises LookupError for an element that is not in the file, Malformed or LookupError if some
    relation of the kind is not well formed.
    """
    known = element.file.tied.get(what)
    if known is None:
        known = element.file.tied[what] = _tied(element.file, what)
    return known.get(element.index, [])


def features_of(element: Entity, relation: str) -> list[Entity]:
    """The features that relations of a class give an element: its own, and those of its wholes.

    An opening in an assembly goes through all that it is made of.
    """
    related = element.file.related(relation)
    if not related:
        return []
    hosts = [element]
    for host in hosts:
        wholes = map(element.file.entity, tied(host, "wholes"))
        hosts += [whole for whole in wholes if whole not in hosts]
    return [one.values[5] for host in hosts for one in related.get(host, ())]


def _tied(file: File, what: str) -> dict[int, list[str]]:
    """As `tied`, by the indices of all elements."""
    classes, place = _CLASSES[what]
    found: dict[int, list[str]] = defaultdict(list)
    for name in classes:
        for index in file.indices(name):
            elements, one = _sides(file, index, place)
            for element in elements:
                found[file.find(element)].append(one)
    return dict(found)


def _sides(file: File, index: int, place: int) -> tuple[list[str], str]:
    """The elements of a relation, and what it ties to them as its value `place`."""
    inner = file.records.inner(index)
    comma = inner.rfind(",(")
    if place == 4:
        comma = inner.rfind(",", 0, max(comma, 0))
    # No string ends in what is behind, so that none began before.
    usual = _SIDES[place].fullmatch(inner, max(comma, 0))
    if usual is not None:
        return usual["elements"].split(","), usual["one"]
    values = file.values(index)
    near, one = values[9 - place], values[place]
    elements = near if isinstance(near, tuple) else (near,)
    return [e.name for e in elements if isinstance(e, Entity)], getattr(one, "name", "$")
