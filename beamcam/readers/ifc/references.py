"""References that the geometry kernel cannot follow: it ends the process over one that is missing.

An attribute that the schema asks for stands for an entity of a class that the schema names there.
"""

from collections.abc import Iterator
from typing import Any

from msgspec import Struct


class Attribute(Struct, frozen=True):
    """An attribute that refers to entities."""

    place: int  #: among the values
    name: str
    optional: bool
    classes: tuple[str, ...]  #: that it may refer to, by the names of the schema
    pure: bool  #: nothing but entities may stand there


def broken_reference(file: Any, root: Any) -> str | None:
    """The first broken reference among all that an instance leads to; None if there is none.

    `file` and `root` are the kernel's own. What leads back to itself is not to be asked for.
    """
    from ifcopenshell import ifcopenshell_wrapper as wrapper

    schema = wrapper.schema_by_name(file.schema_identifier)
    known: dict[str, tuple[Attribute, ...]] = {}
    for one in file.traverse(root):
        name = one.is_a()
        if name not in known:
            known[name] = tuple(_attributes(schema.declaration_by_name(name)))
        for attribute in known[name]:
            if (fault := _fault(one[attribute.place], attribute)) is not None:
                return f"#{one.id()} {name} with {attribute.name} {fault}"
    return None


def _attributes(declaration: Any) -> Iterator[Attribute]:
    """The attributes of a class that refer to entities."""
    entity = declaration.as_entity()
    if entity is None:  # a number or text with its type
        return
    derived = entity.derived()
    for place, attribute in enumerate(entity.all_attributes()):
        classes, pure = _classes(attribute.type_of_attribute())
        if classes and not derived[place]:
            yield Attribute(place, attribute.name(), attribute.optional(), classes, pure)


def _classes(kind: Any) -> tuple[tuple[str, ...], bool]:
    """The classes of entities that a type takes, and whether it takes nothing else."""
    if (many := kind.as_aggregation_type()) is not None:
        return _classes(many.type_of_element())
    if (named := kind.as_named_type()) is not None:
        return _declared(named.declared_type())
    return (), False


def _declared(declaration: Any) -> tuple[tuple[str, ...], bool]:
    if declaration.as_entity() is not None:
        return (declaration.name(),), True
    if (select := declaration.as_select_type()) is not None:
        found = [_declared(one) for one in select.select_list()]
        return sum((classes for classes, _ in found), ()), all(pure for _, pure in found)
    if (typed := declaration.as_type_declaration()) is not None:
        return _classes(typed.declared_type())
    return (), False


def _fault(value: Any, attribute: Attribute) -> str | None:
    """The fault of an attribute's value, if any."""
    if value is None:
        return None if attribute.optional else "missing"
    if isinstance(value, tuple):
        faults = (_fault(one, attribute) for one in value)
        return next((fault for fault in faults if fault is not None), None)
    if hasattr(value, "is_a") and (not value.id() or any(map(value.is_a, attribute.classes))):
        return None
    return "of another class" if attribute.pure or hasattr(value, "is_a") else None
