"""Every key that a machine file may have, from the records that hold them.

The records' own annotations and `#:` comments say it, so this list cannot grow old.
"""

import json
import typing
from collections.abc import Iterator, Mapping, Sequence
from types import UnionType
from typing import Any, Literal, NamedTuple, Union, get_args, get_origin

from msgspec import Struct

from beamcam.conversion.schema import Schema, documented, schema_of
from beamcam.errors import Source
from beamcam.machine.faults import leaves
from beamcam.machine.load import files_of_machine, load, merged
from beamcam.machine.machine import MachineFile
from beamcam.machine.stations import Formula
from beamcam.machine.toml import TomlPlace


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
    """The type of a value with its limits, in words."""
    origin, args = get_origin(hint), get_args(hint)
    if origin is typing.Annotated:
        kind, meta = _kind(args[0]), args[1]
        if meta.le is not None:
            least = f"above {meta.gt:g}, " if meta.ge is None else f"{meta.ge:g} to "
            return f"{kind}, {least}{meta.le:g}{' at most' if meta.ge is None else ''}"
        if meta.gt is not None:
            return f"{kind} above {meta.gt:g}"
        return kind if meta.ge is None else f"{kind}, {meta.ge:g} or more"
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


# --- schema ---------------------------------------------------------------------------------------

# The JSON schema of a machine file, for editors that complete and check TOML.


#: Keys of a file that are not the machine's own.
BASE: Schema = {"type": "string", "description": "machine that this file is laid over"}
ARITHMETIC: Schema = {"type": ["string", "number"], "description": "arithmetic"}


def machine_schema() -> Schema:
    """JSON schema of a machine file. One that has a base need not repeat what is required."""
    schema = schema_of(MachineFile, {Formula: ARITHMETIC})
    records, whole = schema["$defs"], schema["$defs"]["MachineFile"]
    for record in records.values():
        for name, value in record["properties"].items():  # that may be left out; TOML has no null
            choices = value.get("anyOf", [])
            if {"type": "null"} in choices:
                (choice,) = (choice for choice in choices if choice != {"type": "null"})
                others = {k: v for k, v in value.items() if k not in ("anyOf", "default")}
                record["properties"][name] = {**choice, **others}
    whole["properties"] = {"base": BASE, **whole["properties"]}
    required = [name for name in whole.pop("required") if name != "name"]  # or the file's own
    tables = {}
    for name, value in whole["properties"].items():
        record = records.get(value.get("$ref", "").rpartition("/")[2], {})
        if "required" in record:  # of a table, which is laid over that of the base
            tables[name] = {"required": record.pop("required")}
    whole["if"] = {"not": {"required": ["base"]}}
    whole["then"] = {"required": required, "properties": tables}
    return schema


# --- starting file --------------------------------------------------------------------------------

# A machine file to start from: all that a shipped machine says, as comments to be made one's own.
#
#     ## How the stations stand along the bar, ...     what a table or a key is for
#     # kerf = 4.04                                    a value of the base; without #, of this file
#
# Lines with one # are TOML: with the # taken off all of them, the file says what the base says.


WIDTH = 100
_HEAD = """\
## {name}: a machine of your own, laid over {base}.
##
## A line that begins with one # is a value of {base}. Take the # off and change the value to make
## it this machine's; what stays as it is holds as {base} has it. A list in brackets is replaced as
## a whole; a table that this machine has not is taken away by a line such as saw = false.
## docs/my-machine.md goes through it, docs/machine-keys.md lists every key.
##
##     beamcam machines show {name}
##     beamcam post PART.nc1 --machine {name} -o PART{suffix}

base = "{base}"
title = {title}
"""


def starting_file(name: str, base: str, rows: Sequence[Mapping[str, Any]] = ()) -> str:
    """The text of a file for the machine `name`, over the machine `base`.

    `rows` are those of a cut chart, in the place of the base's rows to cut. Raises MachineError.
    """
    table, _ = merged(files_of_machine(base))
    for key in ("name", "default_for", "choice"):
        table.pop(key, None)
    title = json.dumps(f"{table.pop('title')} ({name})", ensure_ascii=False)
    head = _HEAD.format(name=name, base=base, title=title, suffix=table.get("suffix", ""))
    meanings = {key.name: key.meaning for key in machine_keys()}
    if rows and "torch" in table:
        others = [row for row in table["torch"]["rows"] if row["process"] != "cut"]
        table["torch"]["rows"] = Own([*map(dict, rows), *others])
    return head + "".join(f"{line}\n" for line in _lines(table, "", meanings))


class Own(list[Any]):
    """A value of the file's own, which is written without the # of a comment."""


def _lines(table: Mapping[str, Any], prefix: str, meanings: Mapping[str, str]) -> Iterator[str]:
    """The lines of a table, its plain values before the tables in it."""
    plain = {k: v for k, v in table.items() if not (v and isinstance(v, dict))}
    for key, value in plain.items():
        yield from _value(key, value, meanings.get(prefix + key, ""))
    for key, value in table.items():
        if key not in plain:
            yield from ("", f"[{prefix}{_key(key)}]")
            yield from _lines(value, f"{prefix}{key}.", meanings)


def _value(key: str, value: object, meaning: str) -> Iterator[str]:
    mark = "" if isinstance(value, Own) else "# "
    short = f"# {_key(key)} = {_toml(value)}"
    if len(short) <= WIDTH and not (
        isinstance(value, list) and value and isinstance(value[0], dict)
    ):
        yield f"{short}  # {meaning}" if meaning else short
        return
    if meaning:
        yield f"## {meaning}"
    yield f"{mark}{_key(key)} = ["
    if isinstance(value, list):
        yield from (f"{mark}    {_toml(row)}," for row in value)
    yield f"{mark}]"


def _key(key: str) -> str:
    bare = key.replace("-", "").replace("_", "")
    return key if bare.isascii() and bare.isalnum() else json.dumps(key, ensure_ascii=False)


def _toml(value: object) -> str:
    """A value as TOML on one line."""
    if isinstance(value, dict):
        rows = ", ".join(f"{_key(key)} = {_toml(row)}" for key, row in value.items())
        return "{ " + rows + " }" if rows else "{}"
    if isinstance(value, list):
        return "[" + ", ".join(map(_toml, value)) + "]"
    # Texts, numbers and truth values of JSON are those of TOML.
    return json.dumps(value, ensure_ascii=False)


class MachineSetting(Struct, frozen=True):
    """One value of a machine and the place that it comes from."""

    key: str  #: dotted
    value: object
    source: Source | None  #: None for a default


def settings(name: str) -> tuple[MachineSetting, ...]:
    """Every value of a machine, the defaults included, each with where it was set.

    The last one is its checksum, as in the heads of its programs.
    """
    files = files_of_machine(name)
    table, places = merged(files)
    place = TomlPlace(places)
    return tuple(
        MachineSetting(key, value, place.child(key).source if _is_set(table, key) else None)
        for key, value in leaves(load(name))
        if not key.startswith("remarks")
    )


def _is_set(table: Any, key: str) -> bool:
    """Whether a dotted key stands in the table, and not only in the defaults."""
    for word in key.split("."):
        if isinstance(table, list):
            table = table[int(word)]
        elif isinstance(table, dict) and word in table:
            table = table[word]
        else:
            return False
    return True
