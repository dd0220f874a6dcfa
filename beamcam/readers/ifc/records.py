"""A model's entities: their attributes by name or place, and the relations between them."""

from collections import defaultdict
from collections.abc import Iterable
from typing import Any

import numpy as np
from msgspec import Struct

from beamcam.readers.ifc.characters import Places
from beamcam.readers.ifc.columns import Alike
from beamcam.readers.ifc.schema import EntityType, entity_types
from beamcam.readers.ifc.step import MISSING, Malformed, records
from beamcam.readers.ifc.tuples import KINDS, objects, tuples
from beamcam.readers.ifc.values import Tokens, Values, text_of

#: Classes of which a model has many: all their values are read when those of one are asked for.
MANY = frozenset(
    (
        "IFCARBITRARYCLOSEDPROFILEDEF",
        "IFCARBITRARYPROFILEDEFWITHVOIDS",
        "IFCBEAM",
        "IFCBOOLEANCLIPPINGRESULT",
        "IFCBOOLEANRESULT",
        "IFCCIRCLE",
        "IFCCIRCLEPROFILEDEF",
        "IFCCOLUMN",
        "IFCCOMPOSITECURVE",
        "IFCCOMPOSITECURVESEGMENT",
        "IFCEXTRUDEDAREASOLID",
        "IFCFACE",
        "IFCFACEBOUND",
        "IFCFACEOUTERBOUND",
        "IFCHALFSPACESOLID",
        "IFCISHAPEPROFILEDEF",
        "IFCLOCALPLACEMENT",
        "IFCLSHAPEPROFILEDEF",
        "IFCMAPPEDITEM",
        "IFCMEMBER",
        "IFCOPENINGELEMENT",
        "IFCPLANE",
        "IFCPLATE",
        "IFCPOLYLINE",
        "IFCPOLYLOOP",
        "IFCPRODUCTDEFINITIONSHAPE",
        "IFCRECTANGLEHOLLOWPROFILEDEF",
        "IFCRECTANGLEPROFILEDEF",
        "IFCRELVOIDSELEMENT",
        "IFCROUNDEDRECTANGLEPROFILEDEF",
        "IFCSHAPEREPRESENTATION",
        "IFCTRIMMEDCURVE",
        "IFCTSHAPEPROFILEDEF",
        "IFCUSHAPEPROFILEDEF",
    )
)


_NO_TYPE = EntityType("", frozenset(), {})


class Entity(Struct, eq=False, gc=False):
    """A record of the file. Its values are read from the text when one is first asked for.

    `beam.Tag` is an attribute by its name, `beam.values[7]` the same by its place, which is
    faster.

    A model has a hundred thousand, over which the garbage collector would walk again and again. It
    does not know them: what leads back to itself is parted when the file is closed.
    """

    file: "File"
    index: int  #: of its record
    type: EntityType  #: what the schema says of it; of an entity that it does not know, its name
    values: Values = ()  #: none until they are asked for: deleted, so that `__getattr__` reads them

    @property
    def name(self) -> str:
        """#12"""
        return self.file.records.name(self.index)

    def id(self) -> int:
        """Its number, by which the geometry kernel knows it."""
        return int(self.name[1:])

    def is_a(self, name: str | None = None) -> Any:
        """The entity's class; or whether it is of a class, be it as a subtype."""
        return self.type.name if name is None else name in self.type.kinds

    def __getitem__(self, index: int) -> Any:
        return self.values[index]

    def __len__(self) -> int:
        return len(self.values)

    def __getattr__(self, name: str) -> Any:
        # Called for what has no value yet: the slot that is filled late, and attributes.
        if name == "values":
            self.file.fill(self)
            return self.values
        place = self.type.places.get(name)
        if place is not None:
            return self.values[place]
        raise AttributeError(f"{self.type.name} has no {name}")

    @property
    def guid(self) -> str:
        """The GlobalId of a rooted entity, its first value; its name where that is not text."""
        found = self.values[0] if self.values else None
        return found if isinstance(found, str) else self.name

    @property
    def label(self) -> str | None:
        """The Name of a rooted entity, its third value, without a look at the others."""
        # '', GlobalId, ',#1,', Name, ',$,...'
        parts = self.file.records.inner(self.index).split("'", 4)
        if len(parts) == 5 and parts[2].count(",") == 2 and parts[4][:1] == ",":
            return text_of(parts[3])
        found: str | None = self.values[2]
        return found

    @property
    def listed(self) -> list[str]:
        """The names in its last value, which is a list of references, without a look at them."""
        inner = self.file.records.inner(self.index)
        listed = inner[inner.rfind("(") + 1 : inner.rfind(")")]
        return "".join(listed.split()).split(",")  # without line breaks

    def __repr__(self) -> str:
        return f"{self.name}=({self.file.records.inner(self.index)})"


class Missing(Entity):
    """What a reference to no record of the file stands for: all it has is its name.

    Raises LookupError when it is looked at.
    """

    written: str = ""

    @property
    def name(self) -> str:
        return self.written

    def __getattr__(self, name: str) -> Any:
        raise LookupError(f"a reference to {self.name}, which is not in the file")


class File:
    """A model's records, with its schema; an entity is made when it is first referred to.

    Points, directions and placements are not entities but tuples; see tuples.py.
    """

    def __init__(self, text: str, schema: str) -> None:
        """Raises Malformed if the text is not a STEP file."""
        self.schema = schema  #: IFC2X3, IFC4 or IFC4X3
        self.records = records(text)
        self._types = entity_types(schema)
        self._type_of = {
            number: self._types.get(kind.upper()) or EntityType(kind, frozenset((kind,)), {})
            for number, kind in self.records.kinds.items()
        }
        #: What stands for each record, and whether it was met yet.
        self._things, self._met = tuples(self.records)
        self._numbers = self._met.copy()  #: which of them are points and directions
        #: Classes of points, directions and placements that are to be looked at one by one.
        self._unusual = {
            number
            for number, kind in self.records.kinds.items()
            if kind.upper() in KINDS and not self._met[self.records.of_kind(number)[0]]
        }
        self.tokens = Tokens(self._referred)
        self._unread = {n for n, kind in self.records.kinds.items() if kind.upper() in MANY}
        self.tied: dict[str, dict[int, list[str]]] = {}  #: names by indices; see relations.py
        self._related: dict[str, dict[Entity, list[Entity]]] = {}

    def close(self) -> None:
        """Let go of all entities, they of the file and of one another: the collector knows none."""
        self._related = {}
        for thing in self._things[self._met & ~self._numbers].tolist():
            if isinstance(thing, Entity):
                thing.values = ()  # which may lead back to it
        del self.tokens, self._things

    def _referred(self, name: str, number: int) -> Any:
        """What stands for a name among values; a missing entity fails when it is looked at."""
        index = self.records.find(number)
        if index == MISSING:
            missing = Missing(self, index, _NO_TYPE, (), name)
            del missing.index, missing.type, missing.values
            return missing
        if not self._met[index]:
            self._things[index] = self._made(index, self.records.kind(index))
            self._met[index] = True
        return self._things[index]

    def _all_referred(self, numbers: Places) -> list[Any] | None:
        """As `_referred`, by many numbers; None if one of the records is missing."""
        indices = self.records.find_all(numbers)
        return None if (indices == MISSING).any() else self._standing(indices)

    def _standing(self, indices: Places) -> list[Any]:
        """What stands for records; where one was not met before, all of its class are made."""
        for kind in set(self.records.kinds_of(indices[~self._met[indices]]).tolist()):
            of = self.records.of_kind(kind)
            of, kind_type = of[~self._met[of]], self._type_of[kind]
            if kind in self._unusual:
                made = [self._made(index, kind) for index in of.tolist()]
            else:
                made = [Entity(self, index, kind_type) for index in of.tolist()]
                for entity in made:
                    del entity.values
            self._things[of] = objects(made)
            self._met[of] = True
        things: list[Any] = self._things[indices].tolist()
        return things

    def _made(self, index: int, kind: int) -> Any:
        """What stands for a record that was not met before: an entity, or its numbers."""
        made = Entity(self, index, self._type_of[kind])
        del made.values
        if kind not in self._unusual:
            return made
        values = made.values
        if made.is_a("IfcPlacement"):
            return values
        try:
            return tuple(map(float, values[0]))
        except (IndexError, TypeError, ValueError):
            raise Malformed(f"{made.name} without numbers") from None

    def entity(self, name: str) -> Entity:
        """The entity of a name."""
        found: Entity = self.tokens[name]
        return found

    def find(self, name: str) -> int:
        """The index of the record of a name, or MISSING."""
        return self.records.find(int(name[1:]))

    def values(self, index: int) -> Values:
        """The values of a record. Raises Malformed."""
        return self.tokens.values(self.records.inner(index))

    def fill(self, entity: Entity) -> None:
        """Give an entity its values, and with it all others of one of MANY. Raises Malformed."""
        kind = self.records.kind(entity.index)
        if kind not in self._unread or not self._fill_class(kind):
            entity.values = self.values(entity.index)

    def _fill_class(self, kind: int) -> bool:
        """Give all entities of a class their values, if they are written alike."""
        self._unread.remove(kind)
        indices = self.records.of_kind(kind)
        inners = self.records.inners(indices)
        found = Alike(self.tokens, self._all_referred).values(inners)
        if found is None:
            return False
        for entity, values in zip(self._standing(indices), found, strict=True):
            entity.values = values
        return True

    def counts(self, names: Iterable[str]) -> dict[str, int]:
        """Number of records of classes, given in capitals."""
        written = {kind.upper() for kind in self.records.kinds.values()}
        return {name: len(self.records.of(name)) for name in names if name in written}

    def by_type(self, name: str) -> list[Entity]:
        """The entities of a class and of its subtypes, in the order of the file."""
        return self._standing(np.array(self.indices(name), np.int64))

    def indices(self, name: str) -> list[int]:
        """The records of a class and of its subtypes, in the order of the file."""
        kinds = [kind for kind, kind_type in self._types.items() if name in kind_type.kinds]
        return sorted(index for kind in kinds for index in self.records.of(kind).tolist())

    def related(self, name: str) -> dict[Entity, list[Entity]]:
        """The relations of a class to a feature each, by the elements that have the features."""
        known = self._related.get(name)
        if known is None:
            known = self._related[name] = defaultdict(list)
            for relation in self.by_type(name):
                known[relation.values[4]].append(relation)
        return known
