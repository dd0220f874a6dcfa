"""TOML of machines and configurations: text to a table, and the lines that its keys stand on."""

import tomllib
from pathlib import Path
from typing import Any

from msgspec import Struct

from beamcam.caches import cached

#: The longest machine file shipped has 12,000 bytes; reading takes a second for a million.
MAX_TOML_BYTES = 500_000


class TomlError(ValueError):
    """A file that is no TOML, or none that anybody wrote."""


class TomlFile(Struct, frozen=True):
    """A file as it was found."""

    path: Path
    shown: str  #: its name in messages
    text: str

    @property
    def table(self) -> dict[str, Any]:
        """What it says; not to be changed. Raises TomlError."""
        return _table(self.text)


def toml_text(data: bytes) -> str:
    """The text of a file. Raises TomlError for what is no text, or more than anybody writes."""
    if len(data) > MAX_TOML_BYTES:
        raise TomlError(f"{len(data)} bytes; expected at most {MAX_TOML_BYTES}")
    try:
        return data.decode("utf-8")
    except UnicodeDecodeError as error:
        raise TomlError(str(error)) from error


@cached("files.toml")
def _table(text: str) -> dict[str, Any]:
    try:
        return tomllib.loads(text)
    except RecursionError as error:
        raise TomlError("lists or tables too deep inside one another") from error
    except ValueError as error:  # of numbers with too many digits too
        raise TomlError(str(error)) from error


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
    """The first line of each dotted key and table."""
    table, counts = "", dict[str, int]()
    found: dict[str, int] = {}
    for number, raw in enumerate(text.split("\n"), 1):
        line = raw.strip()
        if line.startswith("[["):
            name = line[2:].partition("]]")[0].strip()
            counts[name] = counts.get(name, -1) + 1
            here = table = f"{name}.{counts[name]}"
        elif line.startswith("["):
            here = table = line[1:].partition("]")[0].strip()
        elif "=" in line and not line.startswith("#"):
            name = line.partition("=")[0].strip().strip('"')
            here = f"{table}.{name}" if table else name
        else:
            continue
        found.setdefault(here, number)
    return found
