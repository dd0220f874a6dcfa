"""A model's entities as ifcopenshell reads them: attributes by name or place, relations.

An entity is made when it is first referred to, and has its values from ifcopenshell when one is
first asked for, all at once and once: every look at an instance of its costs a few microseconds. So
what the kernel is given in place of what it cannot build never shows here.
"""

import re
from collections import Counter
from collections.abc import Callable, Container, Iterator, Set
from functools import cached_property
from typing import Any

from msgspec import Struct

from beamcam.caches import cached
from beamcam.readers.ifc.text import (
    Malformed,
    Typed,
    Values,
    escaped,
    look_over,
    plain,
    records,
    values_of,
)
from beamcam.system import interrupts_waiting

_SCHEMA = re.compile(r"(FILE_SCHEMA\s*\(\s*\(\s*')[^']*", re.IGNORECASE)
_POINTS = frozenset(("IfcCartesianPoint", "IfcDirection"))
_PLACEMENTS = frozenset(("IfcAxis2Placement2D", "IfcAxis2Placement3D"))
_PLAIN = (str, float, int, type(None))  #: what ifcopenshell's values and ours have in common


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
    held: Any  #: ifcopenshell's instance, or the record where the file is doubtful
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
            self.values = self.file.values(self.type, self.held)
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
        text = _SCHEMA.sub(rf"\g<1>{identifier_of(schema)}", plain(text), count=1)
        self._names, doubtful = look_over(text)
        self._types: dict[str, EntityType] = {}
        self._things: dict[int, Any] = {}  #: what stands for each record that was met
        self.tied: dict[str, dict[int, list[Any]]] = {}  #: see entities.py
        #: Value of an instance by its place, without its wrapper's checks; so since 0.9.
        instances = parser().entity_instance
        self._read = getattr(instances, "get_argument", instances.__getitem__)
        self._instance: Any = instances
        parser().get_log()  # what others left there
        try:
            self.opened: Any = parser().file.from_string(escaped(text))
        except Exception as fault:  # the parser's own errors have no class of their own
            raise Malformed(str(fault)) from fault
        remarks, count = str(parser().get_log()).strip(), len(self.opened.entity_names())
        doubtful |= bool(remarks) or count != len(self._names)
        #: The records as they are written, where ifcopenshell does not read all of them so.
        self._written = {one.number: one for one in records(text)} if doubtful else None

    def close(self) -> None:
        """Let go of all entities, they of the file and of one another: the collector knows none."""
        self.tied = {}
        for thing in self._things.values():
            if isinstance(thing, Entity):
                thing.values = ()  # which may lead back to it
        self._things = {}
        self.opened = None

    def entity(self, number: int) -> Any:
        """What stands for a number among values; a missing entity fails when it is looked at."""
        if number in self._things:
            return self._things[number]
        if self._written is None:
            return self._met(number, self.opened.by_id(number))
        record = self._written.get(number)
        if record is None:
            made = Missing(self, number, EntityType("", frozenset(), {}), None)
            del made.type, made.held, made.values
            return made
        return self._met(number, record)

    def _met(self, number: int, held: Any) -> Any:
        """What stands for a record that was not met before: an entity, or its numbers."""
        kind = held.kind if self._written is not None else held.is_a()
        known = self._types.get(kind) or self._type(kind)
        thing: Any
        if known.name in _POINTS:
            values = self.values(known, held)
            try:
                thing = tuple(map(float, values[0]))
            except (IndexError, TypeError, ValueError):
                raise Malformed(f"#{number} without numbers") from None
        elif known.name in _PLACEMENTS:
            thing = self.values(known, held)
        else:
            thing = Entity(self, number, known, held)
            del thing.values
        self._things[number] = thing
        return thing

    def _type(self, kind: str) -> EntityType:
        """What the schema says of a class, or else what IFC4 does."""
        known = entity_type(self.schema, kind) or entity_type("IFC4", kind)
        known = self._types[kind] = known or EntityType(kind, frozenset((kind,)), {})
        return known

    def values(self, known: EntityType, held: Any) -> Values:
        """The values of an instance or a record. Raises Malformed."""
        if self._written is not None:
            return values_of(held.inner, self.entity)
        read, instances, things = self._read, self._instance, self._things
        values = []
        for place in range(len(known.places)):
            value = read(held, place)
            if type(value) is instances and (number := value.id()):
                thing = things.get(number)
                value = self._met(number, value) if thing is None else thing
            elif not isinstance(value, _PLAIN):
                value = self._value(value)
            values.append(value)
        return tuple(values)

    def _value(self, value: Any) -> Any:
        """A list of ifcopenshell's, or an instance, as one of ours."""
        if isinstance(value, tuple):
            plain = not value or isinstance(value[0], _PLAIN)
            return value if plain else tuple(map(self._value, value))
        if not isinstance(value, self._instance):
            return value
        if not (number := value.id()):
            return Typed(value.is_a().upper(), self._value(self._read(value, 0)))
        thing = self._things.get(number)
        return self._met(number, value) if thing is None else thing

    def peek(self, entity: Entity, place: int) -> Any:
        """One of an entity's values, without a look at the others."""
        if self._written is not None:
            return entity.values[place]
        return self._value(self._read(entity.held, place))

    def listed(self, entity: Entity, place: int, names: Set[str]) -> Iterator[Entity]:
        """Those of the entities in a list among an entity's values whose first value is a name.

        The others, of which there are many, are not made.
        """
        if self._written is not None:
            quoted = tuple(f"'{name}'" for name in names)
            for one in entity.values[place]:
                if type(one) is Entity and one.held.inner.lstrip().startswith(quoted):
                    yield one
            return
        for one in self._read(entity.held, place) or ():
            if self._read(one, 0) in names:
                yield self._value(one)

    def counts(self, name: str) -> Counter[str]:
        """Number of records of each class below another."""
        written = self._written is not None
        return Counter(self._type(r.kind).name if written else r.is_a() for r in self._of(name))

    def by_type(self, name: str) -> list[Any]:
        """The entities of a class and of its subtypes, in the order of the file."""
        if self._written is not None:
            return [self.entity(record.number) for record in self._of(name)]
        return list(map(self._value, self._of(name)))

    def _of(self, name: str) -> list[Any]:
        """The instances, or else the records, of a class and of its subtypes."""
        if self._written is not None:
            kinds = {r.kind: self._type(r.kind).kinds for r in self._written.values()}
            return [record for record in self._written.values() if name in kinds[record.kind]]
        if entity_type(self.schema, name) is None:
            return []
        return sorted(self.opened.by_type(name), key=lambda instance: self._order(instance.id()))

    @cached_property
    def _order(self) -> Callable[[int], int]:
        """The place of a record in the file, by its number."""
        return {int(number): place for place, number in enumerate(self._names)}.__getitem__


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
