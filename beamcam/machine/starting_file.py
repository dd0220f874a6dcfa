"""A machine file to start from: all that a shipped machine says, as comments to be made one's own.

    ## How the stations stand along the bar, ...     what a table or a key is for
    # kerf = 4.04                                    a value of the base; without #, of this file

Lines with one # are TOML: with the # taken off all of them, the file says what the base says.
"""

import json
from collections.abc import Iterator, Mapping, Sequence
from typing import Any

from beamcam.machine.keys import machine_keys
from beamcam.machine.load import files_of_machine, merged

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
    plain = {key: value for key, value in table.items() if not _is_table(value)}
    for key, value in plain.items():
        yield from _value(key, value, meanings.get(prefix + key, ""))
    for key, value in table.items():
        if key not in plain:
            yield from ("", f"[{prefix}{_key(key)}]")
            yield from _lines(value, f"{prefix}{key}.", meanings)


def _is_table(value: object) -> bool:
    return isinstance(value, dict) and bool(value)


def _value(key: str, value: object, meaning: str) -> Iterator[str]:
    mark = "" if isinstance(value, Own) else "# "
    short = f"# {_key(key)} = {_toml(value)}"
    if len(short) <= WIDTH and not _is_list_of_tables(value):
        yield f"{short}  # {meaning}" if meaning else short
        return
    if meaning:
        yield f"## {meaning}"
    yield f"{mark}{_key(key)} = ["
    if isinstance(value, list):
        yield from (f"{mark}    {_toml(row)}," for row in value)
    yield f"{mark}]"


def _is_list_of_tables(value: object) -> bool:
    return isinstance(value, list) and bool(value) and isinstance(value[0], dict)


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
