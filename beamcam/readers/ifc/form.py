"""What a file says of a member's geometry, as a key: members of one form are one solid.

What is worked out of a solid is kept under this key, never under what was read of it: two solids
may be read alike, and only one of them be right.
"""

from collections.abc import Hashable, Iterator
from typing import Any

from beamcam.readers.ifc.body import body_representation, relative_placement
from beamcam.readers.ifc.entities import Entity, Model, Unreadable
from beamcam.readers.ifc.records import Missing
from beamcam.readers.ifc.relations import features_of

Form = tuple[Hashable, ...]


def form_of(model: Model, element: Entity) -> Form:
    """Key of an element's class, its solid and its openings, in its own coordinates.

    Equal to the last digit or not equal. Raises Unreadable for geometry that contains itself.
    """
    openings = tuple(
        (relative_placement(model, element, one), *_solids(model, one))
        for one in features_of(element, "IfcRelVoidsElement")
    )
    return element.type.name, *_solids(model, element), openings


def _solids(model: Model, element: Entity) -> tuple[int, ...]:
    return tuple(_number(model, item) for item in body_representation(element).values[3])


def _number(model: Model, item: Entity) -> int:
    """The number of all that an item says, down to its coordinates; equal ones share it."""
    numbers: dict[Entity, int] = model.once("numbers of items", None, dict)
    told: dict[Hashable, int] = model.once("told of items", None, dict)
    open_ = set[Entity]()
    stack = [item]
    while stack:
        one = stack[-1]
        if one in numbers:
            stack.pop()
            continue
        below = [each for each in _referred(_values(one)) if each not in numbers]
        if not below:
            stack.pop()
            open_.discard(one)
            said = one.type.name, _replaced(_values(one), numbers)
            numbers[one] = told.setdefault(said, len(told))
            continue
        if one in open_:
            raise Unreadable("geometry that contains itself")
        open_.add(one)
        stack += below
    return numbers[item]


def _values(item: Entity) -> tuple[Any, ...]:
    """What an item says of its form: of a profile not its name."""
    return item.values[2:] if "IfcProfileDef" in item.type.kinds else item.values


def _referred(values: tuple[Any, ...]) -> Iterator[Entity]:
    """The entities among attribute values, lists in lists included."""
    for value in values:
        if isinstance(value, tuple):
            yield from _referred(value)
        elif isinstance(value, Entity) and not isinstance(value, Missing):
            yield value


def _replaced(values: tuple[Any, ...], numbers: dict[Entity, int]) -> tuple[Hashable, ...]:
    """Attribute values with the numbers of entities in their places."""
    out: list[Hashable] = []
    for value in values:
        if isinstance(value, tuple):
            out.append(_replaced(value, numbers))
        elif isinstance(value, Entity) and not isinstance(value, Missing):
            out.append(("item", numbers[value]))
        else:
            out.append(value)
    return tuple(out)
