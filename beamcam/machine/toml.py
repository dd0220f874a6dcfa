"""TOML of machines and configurations: text to a table, its keys as they are called today, rows
added to those of a base, and the line numbers of keys.
"""

import re
import tomllib
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

from msgspec import Struct

from beamcam.caches import cached
from beamcam.conversion import Fault, converted
from beamcam.errors import Source
from beamcam.machine.torch import TorchRow
from beamcam.plain_text import fault_text

#: The longest machine file shipped has 12,000 bytes; reading takes a second for a million.
MAX_TOML_BYTES = 500_000
MAX_LINE = 4096  #: characters; the parser's time grows with the square of a dotted key's length
MAX_DEPTH = 16  #: of tables and lists in each other
_AT_LINE = re.compile(r" \(at line (\d+), column \d+\)$")
UTF_16 = (b"\xff\xfe", b"\xfe\xff")


class TomlError(ValueError):
    """A file that is not TOML, or none that anybody wrote; `line` is where."""

    def __init__(self, message: str, line: int = 1) -> None:
        super().__init__(message)
        self.line = line


class TomlFile(Struct, frozen=True):
    """A file as it was found."""

    path: Path
    shown: str  #: its name in messages
    text: str

    @property
    def table(self) -> dict[str, Any]:
        """The parsed table; do not modify. Raises TomlError."""
        return _table(self.text)


def toml_text(data: bytes) -> str:
    """The text of a file. Raises TomlError for what is not text, or more than anybody writes."""
    if len(data) > MAX_TOML_BYTES:
        raise TomlError(f"more bytes than one has; expected at most {MAX_TOML_BYTES}")
    if data.startswith(UTF_16):
        raise TomlError("the file is UTF-16; save it as UTF-8")
    try:
        text = data.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        raise TomlError(str(error)) from error
    for number, line in enumerate(text.split("\n"), 1):
        if len(line) > MAX_LINE:
            raise TomlError(f"more than {MAX_LINE} characters", number)
    return text


@cached("files.toml")
def _table(text: str) -> dict[str, Any]:
    try:
        table = tomllib.loads(text)
    except RecursionError:
        raise TomlError(f"nested more than {MAX_DEPTH} deep") from None
    except ValueError as error:  # of numbers with too many digits too
        message = fault_text(error)
        if at := _AT_LINE.search(message):
            raise TomlError(message[: at.start()], int(at[1])) from error
        at_end = " (at end of document)"
        line = len(text.splitlines()) if at_end in message else 1
        raise TomlError(message.removesuffix(at_end), line) from error
    level: list[Any] = [table]
    for _ in range(MAX_DEPTH):
        inner = (holder.values() if isinstance(holder, dict) else holder for holder in level)
        level = [item for items in inner for item in items if isinstance(item, dict | list)]
    if level:
        raise TomlError(f"nested more than {MAX_DEPTH} deep")
    return table


class TomlPlace:
    """A key of a TOML document, for messages: it knows its file and its line."""

    def __init__(self, files: Mapping[str, tuple[str, str]], key: str = "") -> None:
        self._files = files  #: dotted key of a leaf -> (file, text of that file)
        self.key = key

    def child(self, *path: str | int) -> "TomlPlace":
        return TomlPlace(self._files, ".".join(map(str, (self.key, *path) if self.key else path)))

    @property
    def source(self) -> Source:
        """The place of the key, or of its nearest parent that the file has."""
        key = self.key
        while key not in self._files and "." in key:
            key = key.rpartition(".")[0]
        file, text = self._files.get(key, self._files[""])
        return Source(file, line_of(text, self.key) or 1)


def keys_of(table: Mapping[str, Any]) -> Iterator[tuple[str, ...]]:
    """The words of the key of each value in a table; a list of tables is one value."""
    for key, value in table.items():
        if isinstance(value, dict):
            yield from ((key, *words) for words in keys_of(value))
        else:
            yield (key,)


def without(table: Mapping[str, Any], words: Sequence[str]) -> dict[str, Any]:
    """A copy of a table without one of its keys, which is given by its words."""
    first, *rest = words
    if rest:
        return {**table, first: without(table[first], rest)}
    return {key: value for key, value in table.items() if key != first}


def line_of(text: str, key: str) -> int | None:
    """The line on which a dotted key of a TOML text, or what it is part of, is set; None if not.

    Array tables count: `spindles.1.number` is `number` under the second `[[spindles]]`.
    """
    lines = _lines(text)
    while key and key not in lines:
        key = key.rpartition(".")[0]
    return lines.get(key)


@cached("files.lines")
def _lines(text: str) -> dict[str, int]:
    """The first line of each dotted key, by its former and its present name, and of each table."""
    table, counts = "", dict[str, int]()
    lines: dict[str, int] = {}
    for number, raw in enumerate(text.split("\n"), 1):
        line = raw.strip()
        if line.startswith("[["):
            name = _bare(line[2:].partition("]]")[0])
            counts[name] = counts.get(name, -1) + 1
            here = table = f"{name}.{counts[name]}"
            lines.setdefault(name, number)
        elif line.startswith("["):
            # With the index of the array table that it is in: `spindles.1.stroke`.
            first, dot, rest = _bare(line[1:].partition("]")[0]).partition(".")
            here = (
                f"{first}.{counts[first]}.{rest}" if dot and first in counts else first + dot + rest
            )
            table = here
        elif "=" in line and not line.startswith("#"):
            name = _bare(line.partition("=")[0])
            here = f"{table}.{name}" if table else name
        else:
            continue
        lines.setdefault(here, number)
        above, _, key = here.rpartition(".")
        lines.setdefault(f"{above}.{_present_name(above, key)}".removeprefix("."), number)
        while "." in here:  # [a.b] begins a too, unless a line before did
            here = here.rpartition(".")[0]
            lines.setdefault(here, number)
    return lines


def _bare(key: str) -> str:
    """A key as it is written, without its quotes."""
    return key.strip().replace('"', "").replace("'", "")


# --- more rows ------------------------------------------------------------------------------------

# Rows of a cut chart that a machine file adds to those of its base: `[[torch.more_rows]]`.
#
# A list in a machine file takes the place of the whole list of its base, so that a row more would
# need all of them again. Rows under `more_rows` are set among the others by their thickness; one of
# the same process, material and thickness takes the place of the other. One that names no material
# is of that of the base's rows of its process, if these are all of one.


ANY = "*"


def with_more_rows(table: dict[str, Any]) -> dict[str, Any]:
    """The table of a machine with its added rows among the others.

    The table itself where nothing is added, or where a row cannot be read: what is wrong with it is
    reported with its own key.
    """
    torch = table.get("torch")
    if not isinstance(torch, dict) or "more_rows" not in torch:
        return table
    rows, more = torch.get("rows", []), torch["more_rows"]
    try:
        for both in (rows, more):
            converted(both, list[TorchRow])
    except Fault:
        return table
    others = {key: value for key, value in torch.items() if key != "more_rows"}
    return {**table, "torch": {**others, "rows": _merged(rows, more)}}


def _merged(rows: Sequence[dict[str, Any]], more: Sequence[dict[str, Any]]) -> list[dict[str, Any]]:
    """The rows in the order in which the first that fits counts."""
    both = list(rows)
    for row in more:
        # A chart of one material is not left by a row that names none.
        own = {_row_key(old)[1]: old for old in rows if old["process"] == row["process"]}
        if "material" not in row and len(own) == 1:
            row = row | {"material": next(iter(own.values())).get("material", ANY)}
        process, material, up_to = key = _row_key(row)
        keys = [_row_key(old) for old in both]
        if key in keys:
            both[keys.index(key)] = row
            continue
        # Before those that would match first otherwise.
        behind = [
            k for k, (of, its, to) in enumerate(keys)
            if of == process and (up_to < to if its == material else its == ANY)
        ]  # fmt: skip
        both.insert(behind[0] if behind else len(both), row)
    return both


def _row_key(row: dict[str, Any]) -> tuple[str, str, float]:
    return row["process"], row.get("material", ANY).upper(), float(row["up_to"])


# --- former keys ----------------------------------------------------------------------------------

# Renamed keys of machine files: still read for one minor version, with a warning.
#
# `least_x` became `min_x` and `greatest_x` became `max_x`, in every table; others by name.


_FORMER = re.compile(r"^(least|greatest)(_|$)")
_PRESENT = {"least": "min", "greatest": "max"}
#: Table and former key -> present key.
_RENAMED = {
    ("drill", "twin"): "same_tool_tolerance",
    ("times", "reload_s"): "manual_change_s",
    ("stroke", "start"): "retract",
    ("stroke", "near"): "approach",
    ("saw", "square"): "zero_angle",
}
#: Tables whose keys are names that the user chooses.
_FREE = frozenset({"sections", "colours", "names", "default_for"})


class KeyTwice(ValueError):
    """A table has a key under both its former and its present name."""

    def __init__(self, former: str, present: str) -> None:
        super().__init__(former)
        self.former, self.present = former, present


def _present_name(table: str, key: str) -> str:
    """A key of a table as this version names it."""
    name = _RENAMED.get((table.rpartition(".")[2], key))
    return name or _FORMER.sub(lambda match: _PRESENT[match[1]] + match[2], key, count=1)


def with_present_keys(table: dict[str, Any]) -> tuple[dict[str, Any], list[tuple[str, str]]]:
    """The table with its keys as this version names them, and (former, present) for each renamed.

    Former keys are dotted, as `axes.0.least`. Raises KeyTwice where both names stand in one table.
    """
    renamed: list[tuple[str, str]] = []
    return _renamed_in(table, "", renamed), renamed


def _renamed_in(value: Any, prefix: str, renamed: list[tuple[str, str]]) -> Any:
    if isinstance(value, list):
        return [_renamed_in(item, f"{prefix}{k}.", renamed) for k, item in enumerate(value)]
    if not isinstance(value, dict):
        return value
    present: dict[str, Any] = {}
    for key, item in value.items():
        name = _present_name(prefix.rstrip("."), key)
        if name != key:
            if name in value:
                raise KeyTwice(prefix + key, prefix + name)
            renamed.append((prefix + key, name))
        present[name] = item if key in _FREE else _renamed_in(item, f"{prefix}{key}.", renamed)
    return present
