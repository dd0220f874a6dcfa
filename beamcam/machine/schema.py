"""From a TOML table to a record: every key known, every value of its field's type.

The record's own annotations are the schema, so a field added to `Machine` is a key of the file
at once. Errors name the file, the line of the key, what was found and what was expected.
"""

import types
import typing
from collections.abc import Mapping
from math import inf, isfinite
from typing import Any, Literal, Union, cast, get_args, get_origin

from msgspec import Struct

from beamcam.caches import cached
from beamcam.errors import MachineError, Source
from beamcam.machine import rules
from beamcam.machine.machine import DERIVED, Formula
from beamcam.machine.toml import line_of

GREATEST = 10**300  #: whole number that is one of the machine's, by far


@cached("machine.fields")
def _fields(cls: type[Struct]) -> dict[str, tuple[Any, bool]]:
    """Type of every field of a record, and whether the file has to give it."""
    hints = typing.get_type_hints(cls)
    names = cls.__struct_fields__
    required = len(names) - len(cls.__struct_defaults__)
    return {n: (hints[n], i < required) for i, n in enumerate(names) if n not in DERIVED}


class Place:
    """A key of a TOML document, for messages: it knows its file and its line."""

    def __init__(self, files: Mapping[str, tuple[str, str]], key: str = "") -> None:
        self._files = files  #: dotted key of a leaf -> (file, text of that file)
        self.key = key

    def child(self, name: str | int) -> "Place":
        return Place(self._files, f"{self.key}.{name}" if self.key else str(name))

    @property
    def source(self) -> Source:
        """Where the key stands; its nearest parent that stands anywhere if it does not."""
        key = self.key
        while key not in self._files and "." in key:
            key = key.rpartition(".")[0]
        file, text = self._files.get(key, self._files[""])
        return Source(file, line_of(text, self.key))


def build(cls: type[Struct], table: object, place: Place) -> Any:
    """The record `cls` that `table` describes. Raises MachineError."""
    if not isinstance(table, dict):
        raise _wrong(place, table, "a table")
    known = _fields(cls)
    for key in table:
        if key not in known:
            raise MachineError(
                rules.UNKNOWN_KEY.at(
                    place.child(key).source,
                    found=place.child(key).key,
                    expected=nearest(key, known),
                )
            )
    values = {}
    for name, (hint, required) in known.items():
        if name in table:
            values[name] = _value(hint, table[name], place.child(name))
        elif required:
            raise MachineError(rules.MISSING_KEY.at(place.source, expected=place.child(name).key))
    return cls(**values)


def nearest(word: str, known: typing.Iterable[str]) -> str:
    """The known word most like `word`, as a suggestion; all of them where none is like it."""
    from difflib import get_close_matches

    names = sorted(known)
    close = get_close_matches(word, names, 1, 0.6)
    return repr(close[0]) if close else "one of " + ", ".join(names)


def _value(hint: Any, value: object, place: Place) -> Any:
    origin, args = get_origin(hint), get_args(hint)
    if origin in (Union, types.UnionType):
        inner = next(a for a in args if a is not type(None))
        return _value(inner, value, place)
    if origin is Literal:
        if value not in args:
            raise _wrong(place, value, "one of " + ", ".join(map(repr, args)))
        return value
    if origin is tuple:
        return _tuple(args, value, place)
    if origin is not None and issubclass(origin, Mapping):
        if not isinstance(value, dict):
            raise _wrong(place, value, "a table")
        return {k: _value(args[1], v, place.child(k)) for k, v in value.items()}
    if hint is Formula:
        return _formula(value, place)
    if isinstance(hint, type) and issubclass(hint, Struct):
        return build(hint, value, place)
    if hint is float and isinstance(value, int) and not isinstance(value, bool):
        value = float(value) if abs(value) < GREATEST else inf
    if type(value) is not hint:
        raise _wrong(place, value, {float: "a number", int: "a whole number", str: "a text",
                                    bool: "true or false"}[hint])  # fmt: skip
    if isinstance(value, float) and not isfinite(value):
        raise _wrong(place, value, "a finite number")
    return value


def _tuple(args: tuple[Any, ...], value: object, place: Place) -> tuple[Any, ...]:
    if not isinstance(value, list):
        raise _wrong(place, value, "a list")
    if args[-1] is Ellipsis:
        return tuple(_value(args[0], v, place.child(i)) for i, v in enumerate(value))
    if len(value) != len(args):
        raise _wrong(place, value, f"a list of {len(args)}")
    return tuple(
        _value(a, v, place.child(i)) for i, (a, v) in enumerate(zip(args, value, strict=True))
    )


def _formula(value: object, place: Place) -> Formula:
    formula = Formula(f"{value}" if isinstance(value, int | float) else cast(str, value))
    if not isinstance(formula.text, str):
        raise _wrong(place, value, "arithmetic as a text")
    try:
        formula.check()
    except ValueError as error:
        raise _wrong(place, value, f"arithmetic: {error}") from error
    return formula


def _wrong(place: Place, found: object, expected: str) -> MachineError:
    return MachineError(
        rules.WRONG_VALUE.at(place.source, key=place.key, found=repr(found), expected=expected)
    )
