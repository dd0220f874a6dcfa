"""TOML of machines and configurations: text to a table, and the line numbers of its keys."""

import re
import tomllib
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

from msgspec import Struct

from beamcam.caches import cached
from beamcam.errors import Source
from beamcam.machine.overlay import former_name
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
        raise _error_of(fault_text(error), text) from error
    if _depth(table) > MAX_DEPTH:
        raise TomlError(f"nested more than {MAX_DEPTH} deep")
    return table


def _error_of(message: str, text: str) -> TomlError:
    """What the parser says, with its line."""
    at = _AT_LINE.search(message)
    if at is not None:
        return TomlError(message[: at.start()], int(at[1]))
    at_end = " (at end of document)"
    return TomlError(
        message.removesuffix(at_end), len(text.splitlines()) if at_end in message else 1
    )


def _depth(table: dict[str, Any]) -> int:
    """Nesting depth of tables and lists."""
    depth = 0
    level: list[Any] = [table]
    while level:
        depth += 1
        level = [
            item
            for holder in level
            for item in (holder.values() if isinstance(holder, dict) else holder)
            if isinstance(item, dict | list)
        ]
    return depth


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
    while key:
        for name in (key, former_name(key)):
            if name in lines:
                return lines[name]
        key = key.rpartition(".")[0]
    return None


@cached("files.lines")
def _lines(text: str) -> dict[str, int]:
    """The first line of each dotted key and table."""
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
            here = table = _numbered(_bare(line[1:].partition("]")[0]), counts)
        elif "=" in line and not line.startswith("#"):
            name = _bare(line.partition("=")[0])
            here = f"{table}.{name}" if table else name
        else:
            continue
        lines.setdefault(here, number)
        while "." in here:  # [a.b] begins a too, unless a line before did
            here = here.rpartition(".")[0]
            lines.setdefault(here, number)
    return lines


def _numbered(table: str, counts: Mapping[str, int]) -> str:
    """A table's name with the index of the array table that it is in: `spindles.1.stroke`."""
    first, dot, rest = table.partition(".")
    return f"{first}.{counts[first]}.{rest}" if dot and first in counts else table


def _bare(key: str) -> str:
    """A key as it is written, without its quotes."""
    return key.strip().replace('"', "").replace("'", "")
