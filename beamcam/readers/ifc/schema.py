"""Attributes and supertypes, by schema, of the entities that the reader uses."""

from importlib.resources import files

from msgspec import Struct

from beamcam.caches import cached


class EntityType(Struct, frozen=True):
    """An entity type of a schema (EXPRESS)."""

    name: str  #: IfcBeam
    kinds: frozenset[str]  #: its name and those of its supertypes
    places: dict[str, int]  #: of its attributes among its values


@cached("ifc.schema")
def entity_types(schema: str) -> dict[str, EntityType]:
    """The entities of IFC2X3, IFC4 or IFC4X3 by their names in capitals."""
    drawn = dict(_sections()["IFC4"])
    drawn.update(_sections()[schema])
    found: dict[str, EntityType] = {}

    def entity(name: str) -> EntityType:
        known = found.get(name.upper())
        if known is None:
            parent, own = drawn[name]
            above = entity(parent) if parent != "-" else EntityType("", frozenset(), {})
            first = len(above.places)
            places = above.places | {own[i]: first + i for i in range(len(own))}
            known = found[name.upper()] = EntityType(name, above.kinds | {name}, places)
        return known

    for name in drawn:
        entity(name)
    return found


@cached("ifc.schema_text")
def _sections() -> dict[str, dict[str, tuple[str, tuple[str, ...]]]]:
    """Supertype and own attributes by name; of each schema what IFC4 has not alike."""
    sections: dict[str, dict[str, tuple[str, tuple[str, ...]]]] = {}
    for line in files(__package__).joinpath("schema.txt").read_text("ascii").splitlines():
        if line.startswith("["):
            section = sections.setdefault(line.strip("[]"), {})
        elif line and not line.startswith("#"):
            name, parent, *own = line.split()
            section[name] = (parent, tuple(own))
    return sections
