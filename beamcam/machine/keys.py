"""Every key that a machine file may have, from the records that hold them.

The records' own annotations and `#:` comments say it, so this list cannot grow old.
"""

import typing
from collections.abc import Iterator, Mapping
from types import UnionType
from typing import Literal, NamedTuple, Union, get_args, get_origin

from msgspec import Meta

from beamcam.conversion.schema import documented
from beamcam.machine.formula import Formula
from beamcam.machine.machine import MachineFile


class Key(NamedTuple):
    """One key of a machine file."""

    name: str  #: dotted; [] stands for each table of a list
    kind: str  #: what its value is
    default: str  #: empty where the file has to give it
    meaning: str


def machine_keys() -> tuple[Key, ...]:
    """All keys, in the order of the records."""
    return tuple(_keys(MachineFile, ""))


def _keys(record: type, prefix: str) -> Iterator[Key]:
    hints = typing.get_type_hints(record, include_extras=True)
    for name, (default, meaning) in documented(record).items():
        inner, between = _record_in(hints[name])
        if inner is None:
            yield Key(prefix + name, _kind(hints[name]), default, meaning)
        else:
            yield from _keys(inner, f"{prefix}{name}{between}.")


_PLAIN = {str: "text", float: "number", int: "whole number", bool: "true or false"}


def _kind(hint: object) -> str:
    """The type of a value, in words."""
    origin, args = get_origin(hint), get_args(hint)
    if origin is typing.Annotated:
        return _kind(args[0]) + _limits(args[1])
    if origin in (Union, UnionType):
        return _kind(next(a for a in args if a is not type(None)))
    if origin is Literal:
        return "one of " + ", ".join(map(repr, args))
    if origin is tuple:
        many = args[-1] is Ellipsis
        return f"list of {'' if many else f'{len(args)}: '}{_kind(args[0])}"
    if isinstance(origin, type) and issubclass(origin, Mapping):
        return f"table of {_kind(args[1])}"
    return "arithmetic" if hint is Formula else _PLAIN[typing.cast(type, hint)]


def _limits(meta: Meta) -> str:
    """The limits of a number, in words."""
    if meta.le is not None and meta.gt is not None:
        return f", above {meta.gt:g}, {meta.le:g} at most"
    if meta.le is not None:
        return f", {meta.ge:g} to {meta.le:g}"
    if meta.gt is not None:
        return f" above {meta.gt:g}"
    return "" if meta.ge is None else f", {meta.ge:g} or more"


def _record_in(hint: object) -> tuple[type | None, str]:
    """The record that a field holds, and what stands behind its key where it holds several."""
    origin, args = get_origin(hint), get_args(hint)
    if origin is typing.Annotated:
        return None, ""
    if origin in (Union, UnionType):
        return _record_in(next(a for a in args if a is not type(None)))
    if origin is tuple:
        return _record_in(args[0])[0], "[]"
    if isinstance(origin, type) and issubclass(origin, Mapping):
        return _record_in(args[1])[0], ".NAME"
    if isinstance(hint, type) and hint is not Formula and hint.__module__.startswith("beamcam."):
        return hint, ""
    return None, ""
