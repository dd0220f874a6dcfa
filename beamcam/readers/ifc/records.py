"""A model's entities as ifcopenshell reads them: attributes by name or place, relations.

An entity is made when it is first referred to, and has its values from ifcopenshell when one is
first asked for, all at once and once: every look at an instance of its costs a few microseconds. So
what the kernel is given in place of what it cannot build never shows here.
"""

import re
from collections import Counter
from collections.abc import Container, Iterator
from contextlib import suppress
from typing import Any, SupportsIndex

from msgspec import Struct

from beamcam.caches import cached
from beamcam.readers.ifc.text import (
    Malformed,
    StepRecord,
    look_over,
    parsable,
    places,
    prepared,
    records,
)
from beamcam.system import interrupts_waiting

_POINTS = frozenset(("IfcCartesianPoint", "IfcDirection"))
_PLACEMENTS = frozenset(("IfcAxis2Placement2D", "IfcAxis2Placement3D"))
_PLAIN = (str, float, int, type(None))  #: what ifcopenshell's values and ours have in common
_FIRST = re.compile(r"'([^'\\]*+)'\s*+(?:,|\Z)")
_REFERENCES = re.compile(r"#\d+|\(#\d+(,#\d+)*\)")

Values = tuple[Any, ...]


class Typed(Struct, frozen=True, gc=False):
    """A value with its type written before it: IFCLENGTHMEASURE(25.4)."""

    kind: str  #: in capitals
    value: Any

    def is_a(self, name: str) -> bool:
        """As of an entity."""
        return name.upper() == self.kind


class Doubtful(Values):
    """Values of which ifcopenshell has some otherwise than they are written.

    Those are the errors that are raised when they are looked at.
    """

    def __getitem__(self, place: SupportsIndex | slice) -> Any:
        value = super().__getitem__(place)
        if isinstance(value, Malformed):
            raise Malformed(str(value))
        return tuple(Doubtful(value)) if isinstance(place, slice) else value

    def __iter__(self) -> Iterator[Any]:
        return map(self.__getitem__, range(len(self)))


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
    number: int  #: by which the geometry kernel knows it too
    type: EntityType  #: what the schema says of it; of an entity that it does not know, its name
    held: Any  #: ifcopenshell's instance; None of a record that it does not have
    values: Values = ()  #: none until they are asked for: deleted, so that `__getattr__` reads them

    @property
    def name(self) -> str:
        """#12"""
        return f"#{self.number}"

    def is_a(self, name: str | None = None) -> Any:
        """The entity's class; or whether it is of a class, be it as a subtype."""
        return self.type.name if name is None else name in self.type.kinds

    def __getattr__(self, name: str) -> Any:
        # Called for what has no value yet: the slot that is filled late, and attributes.
        if name == "values":
            self.values = self.file.values(self.type, self.number, self.held)
            return self.values
        place = self.type.places.get(name)
        if place is not None:
            return self.values[place]
        raise AttributeError(f"{self.type.name} has no {name}")

    @property
    def guid(self) -> str:
        """The GlobalId of a rooted entity, its first value; its name where that is no text."""
        try:
            name = next(tuple.__iter__(self.values), None)  # which may be an error
        except (Malformed, RecursionError):
            name = None
        return name if isinstance(name, str) else self.name

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
        text = prepared(text, identifier_of(schema))
        numbers, sound = look_over(text)
        self._places = {number: place for place, number in enumerate(numbers)}  #: in the file
        self._things: dict[int, Any] = {}  #: what stands for each record that was met
        self.tied: dict[str, dict[int, list[Any]]] = {}  #: see entities.py
        #: Value of an instance by its place, without its wrapper's checks; so since 0.9.
        instances = parser().entity_instance
        self._read = getattr(instances, "get_argument", instances.__getitem__)
        parser().get_log()  # what others left there
        try:
            self.opened: Any = parser().file.from_string(parsable(text, sound))
        except Exception as fault:  # the parser's own errors have no class of their own
            raise Malformed(str(fault)) from fault
        remarks, own = str(parser().get_log()).strip(), self.opened.entity_names()
        #: The records as they are written, where ifcopenshell may have some otherwise.
        self._written: dict[int, StepRecord] = {}
        #: Those that it does not have, as of classes that the schema does not know.
        self._lost: list[StepRecord] = []
        if not sound or remarks or len(own) < len(numbers):
            self._written = {one.number: one for one in records(text)}
            self._lost = [self._written[number] for number in self._written.keys() - set(own)]

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
        try:
            held = self.opened.by_id(number)
        except (RuntimeError, OverflowError):
            held = None
        if held is None and number not in self._written:
            made = Missing(self, number, EntityType("", frozenset(), {}), None)
            del made.type, made.held, made.values
            return made
        return self._met(number, held)

    def _met(self, number: int, held: Any) -> Any:
        """What stands for a record that was not met before: an entity, or its numbers."""
        kind = held.is_a() if held is not None else self._written[number].kind
        known = entity_type(self.schema, kind)
        thing: Any
        if known.name in _POINTS:
            values = self.values(known, number, held)[:1]
            try:
                thing = tuple(map(float, values[0]))
            except (IndexError, TypeError, ValueError):
                raise Malformed(f"#{number} without numbers") from None
        elif known.name in _PLACEMENTS:
            thing = self.values(known, number, held)
        else:
            thing = Entity(self, number, known, held)
            del thing.values
        self._things[number] = thing
        return thing

    def values(self, known: EntityType, number: int, held: Any) -> Values:
        """The values of a record."""
        if self._written:
            return Doubtful(self._as_written(self._written[number], held))
        read, values = self._read, []
        for place in range(len(known.places)):
            value = read(held, place)
            values.append(value if isinstance(value, _PLAIN) else self._value(value))
        return tuple(values)

    def _as_written(self, record: StepRecord, held: Any) -> Iterator[Any]:
        """The values that ifcopenshell has as they are written, references, and errors for others.

        It leaves out what refers to no record, words that the schema does not list, and members of
        another kind than a list's first. Of a record that it does not have only a text that comes
        first is told, which may be its name.
        """
        name = f"#{record.number}={record.kind}"
        own = [] if held is None else places(held.to_string(True).partition("(")[2][:-1])
        for place, written in enumerate(places(record.inner)):
            if held is None:
                text = _FIRST.match(record.inner) if not place else None
                fault = f"{name}({record.inner[:40]}), not as the schema has it"
                yield text[1] if text is not None else Malformed(fault)
            elif place == len(own):
                return
            elif _REFERENCES.fullmatch(written):
                entities = tuple(self.entity(int(one)) for one in re.findall(r"\d+", written))
                yield entities if written.startswith("(") else entities[0]
            elif written == own[place]:
                yield self._value(self._read(held, place))
            else:
                yield Malformed(f"value {place + 1} of {name}, not as the schema has it")

    def _value(self, value: Any) -> Any:
        """A value of ifcopenshell's as one of ours."""
        if isinstance(value, _PLAIN):
            return value
        if isinstance(value, tuple):
            plain = not value or isinstance(value[0], _PLAIN)
            return value if plain else tuple(map(self._value, value))
        if not (number := value.id()):
            return Typed(value.is_a().upper(), self._value(self._read(value, 0)))
        thing = self._things.get(number)
        return self._met(number, value) if thing is None else thing

    def peek(self, entity: Entity, place: int) -> Any:
        """One of an entity's values, without a look at the others."""
        return entity.values[place] if self._written else self._read(entity.held, place)

    def listed(self, entity: Entity, place: int, names: Container[str]) -> Iterator[Entity]:
        """Those of the entities in a list among an entity's values whose first value is a name.

        The others, of which there are many, are not made.
        """
        if self._written:
            return (one for one in referred(entity.values[place] or ()) if one.guid in names)
        values = self._read(entity.held, place) or ()
        return (self._value(one) for one in values if self._read(one, 0) in names)

    def by_type(self, name: str) -> list[Any]:
        """The entities of a class and of its subtypes, in the order of the file."""
        entities = [*map(self._value, self.opened.by_type(name))]
        lost = [one for one in self._lost if name in entity_type(self.schema, one.kind).kinds]
        entities += [self.entity(one.number) for one in lost]
        return sorted(entities, key=lambda one: self._places[one.number])

    def unknown_classes(self) -> Counter[str]:
        """How many records have each class that the schema does not know."""
        kinds = Counter(one.kind for one in self._lost)
        return Counter({k: n for k, n in kinds.items() if not entity_type(self.schema, k).places})


@cached("ifc.parser")
def parser() -> Any:
    """The module of ifcopenshell. An interrupt waits until it is loaded: it would swallow it."""
    with interrupts_waiting():
        import ifcopenshell
    return ifcopenshell


@cached("ifc.class")
def entity_type(schema: str, kind: str) -> EntityType:
    """What a schema (IFC2X3, IFC4 or IFC4X3) says of a class, in any letters, or else what IFC4
    does; of a class that neither knows its name.
    """
    wrapper = parser().ifcopenshell_wrapper
    entity = None
    for known in (schema, "IFC4"):
        with suppress(RuntimeError):
            declared = wrapper.schema_by_name(identifier_of(known)).declaration_by_name(kind)
            entity = entity or declared.as_entity()
    if entity is None:
        return EntityType(kind, frozenset((kind,)), {})
    kinds, above = [entity.name()], entity.supertype()
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
