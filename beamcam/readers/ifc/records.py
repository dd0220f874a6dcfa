"""A model's entities: attributes by name or place, relations.

An entity is made when it is first referred to, and has its values from the text of its record when
one is first asked for, all at once and once. What the kernel is given in place of what it cannot
build never shows here.
"""

import re
from collections import Counter
from collections.abc import Container, Iterator
from functools import cached_property
from typing import Any

from msgspec import Struct

from beamcam.caches import cached
from beamcam.readers.ifc.text import Malformed, StepRecord, Values, records, values_of
from beamcam.system import interrupts_waiting

_SCHEMA = re.compile(r"(FILE_SCHEMA\s*\(\s*\(\s*')[^']*", re.IGNORECASE)
_POINTS = frozenset(("IfcCartesianPoint", "IfcDirection"))
_PLACEMENTS = frozenset(("IfcAxis2Placement2D", "IfcAxis2Placement3D"))


class EntityType(Struct, frozen=True):
    """An entity type of a schema (EXPRESS)."""

    name: str  #: IfcBeam
    kinds: frozenset[str]  #: its name and those of its supertypes
    places: dict[str, int]  #: of its attributes among its values


class Entity(Struct, eq=False, gc=False):
    """A record of the file. Its values are read when one is first asked for.

    `beam.Tag` is an attribute by its name, `beam.values[7]` the same by its place, which is
    faster.

    A model has a hundred thousand, over which the garbage collector would walk again and again. It
    does not know them: what leads back to itself is parted when the file is closed.
    """

    file: "File"
    number: int
    type: EntityType  #: what the schema says of it; of an entity that it does not know, its name
    inner: str  #: its values as they are written
    values: Values = ()  #: none until they are asked for: deleted, so that `__getattr__` reads them

    @property
    def name(self) -> str:
        """#12"""
        return f"#{self.number}"

    def id(self) -> int:
        """Its number, by which the geometry kernel knows it."""
        return self.number

    def is_a(self, name: str | None = None) -> Any:
        """The entity's class; or whether it is of a class, be it as a subtype."""
        return self.type.name if name is None else name in self.type.kinds

    def __getattr__(self, name: str) -> Any:
        # Called for what has no value yet: the slot that is filled late, and attributes.
        if name == "values":
            self.values = values_of(self.inner, self.file.entity)
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

    def __repr__(self) -> str:
        return f"{self.name}={self.type.name}"

    def below(self, known: Container["Entity"] = ()) -> list["Entity"]:
        """It and all that it refers to but for what is known, each behind what it refers to.

        Raises RecursionError for what leads back to itself.
        """
        open_, done = set[Entity](), dict[Entity, None]()
        stack = [self]
        while stack:
            one = stack[-1]
            if one in done or one in known:
                stack.pop()
            elif one in open_:
                stack.pop()
                open_.discard(one)
                done[one] = None
            else:
                open_.add(one)
                below = list(referred(one.values))
                if not open_.isdisjoint(below):
                    raise RecursionError(f"{one.name} contains itself")
                stack += below
        return list(done)


class Missing(Entity):
    """What a reference to no record of the file stands for: all it has is its name.

    Raises LookupError when it is looked at.
    """

    def __getattr__(self, name: str) -> Any:
        raise LookupError(f"a reference to {self.name}, which is not in the file")


def referred(values: Values) -> Iterator[Entity]:
    """The entities of the file among attribute values, lists in lists included."""
    for value in values:
        if isinstance(value, tuple):
            yield from referred(value)
        elif isinstance(value, Entity) and not isinstance(value, Missing):
            yield value


class File:
    """A model's records, with its schema; an entity is made when it is first referred to.

    Points, directions and placements are not entities but tuples.
    """

    def __init__(self, text: str, schema: str) -> None:
        """Raises Malformed if the text is not a STEP file."""
        self.schema = schema  #: IFC2X3, IFC4 or IFC4X3
        self._text = text
        self._records = records(text)
        self._by_kind: dict[str, list[StepRecord]] = {}
        for record in self._records.values():
            self._by_kind.setdefault(record.kind, []).append(record)
        #: What the schema says of each class, or else what IFC4 does.
        self._types = {
            kind: entity_type(schema, kind)
            or entity_type("IFC4", kind)
            or EntityType(kind, frozenset((kind,)), {})
            for kind in self._by_kind
        }
        self._things: dict[int, Any] = {}  #: what stands for each record that was met
        self.tied: dict[str, dict[int, list[Any]]] = {}  #: see entities.py

    @cached_property
    def opened(self) -> Any:
        """The file as ifcopenshell reads it, for its geometry kernel. Raises Malformed."""
        text = _SCHEMA.sub(rf"\g<1>{identifier_of(self.schema)}", self._text, count=1)
        # It loses the way behind a stray backslash, and the kernel asks for no text with letters.
        text = text.replace("\\", "/").encode("ascii", "replace").decode()
        try:
            return parser().file.from_string(text)
        except Exception as fault:  # the parser's own errors have no class of their own
            raise Malformed(str(fault)) from fault

    def close(self) -> None:
        """Let go of all entities, they of the file and of one another: the collector knows none."""
        self.tied = {}
        for thing in self._things.values():
            if isinstance(thing, Entity):
                thing.values = ()  # which may lead back to it
        self._things = {}
        self.__dict__.pop("opened", None)

    def entity(self, number: int) -> Any:
        """What stands for a number among values; a missing entity fails when it is looked at."""
        thing: Any = self._things.get(number)
        if thing is not None:
            return thing
        record = self._records.get(number)
        if record is None:
            made = Missing(self, number, EntityType("", frozenset(), {}), "")
            del made.type, made.inner, made.values
            return made
        known = self._types[record.kind]
        if known.name in _POINTS:
            values = values_of(record.inner, self.entity)
            try:
                thing = tuple(map(float, values[0]))
            except (IndexError, TypeError, ValueError):
                raise Malformed(f"#{number} without numbers") from None
        elif known.name in _PLACEMENTS:
            thing = values_of(record.inner, self.entity)
        else:
            thing = Entity(self, number, known, record.inner)
            del thing.values
        self._things[number] = thing
        return thing

    def counts(self, name: str) -> Counter[str]:
        """Number of records of each class below another."""
        found = Counter[str]()
        for kind in self._below(name):
            found[self._types[kind].name] += len(self._by_kind[kind])
        return found

    def by_type(self, name: str) -> list[Any]:
        """The entities of a class and of its subtypes, in the order of the file."""
        found = [record for kind in self._below(name) for record in self._by_kind[kind]]
        return [self.entity(r.number) for r in sorted(found, key=lambda record: record.at)]

    def _below(self, name: str) -> list[str]:
        """The classes of records that are of a class, as they are written."""
        return [kind for kind, known in self._types.items() if name in known.kinds]


@cached("ifc.parser")
def parser() -> Any:
    """The module of ifcopenshell. An interrupt waits until it is loaded: it would swallow it."""
    with interrupts_waiting():
        import ifcopenshell
    return ifcopenshell


@cached("ifc.class")
def entity_type(schema: str, name: str) -> EntityType | None:
    """What a schema (IFC2X3, IFC4 or IFC4X3) says of a class, by its name in any letters."""
    wrapper = parser().ifcopenshell_wrapper
    try:
        declared = wrapper.schema_by_name(identifier_of(schema)).declaration_by_name(name)
    except RuntimeError:
        return None
    entity = above = declared.as_entity()
    if entity is None:
        return None
    kinds = []
    while above is not None:
        kinds.append(above.name())
        above = above.supertype()
    places = {a.name(): place for place, a in enumerate(entity.all_attributes())}
    return EntityType(entity.name(), frozenset(kinds), places)


@cached("ifc.identifier")
def identifier_of(schema: str) -> str:
    """The name by which ifcopenshell knows a schema: IFC4X3_ADD2 for IFC4X3."""
    names: tuple[str, ...] = parser().ifcopenshell_wrapper.schema_names()
    return next(name for name in names if name == schema or name.startswith(f"{schema}_"))
