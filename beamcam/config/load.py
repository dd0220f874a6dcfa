"""Configurations that are there: read from a file, laid over each other, and followed as far as
they are one's own.

What came with the parts is a stranger's as the parts are; what is taken of it stands under trust.
"""

import json
import os
import os.path
import tomllib
from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import Any, get_args

from msgspec.structs import replace

from beamcam.config import NO_DRILL, NOT_FOLLOWED, NOT_TOML, UNKNOWN_KEY, UNREADABLE, WRONG_VALUE
from beamcam.config.values import (
    COMMAND_LINE,
    CONFIG_NAME,
    TABLES,
    Config,
    ConfigFile,
    MapRow,
    Meaning,
    Sheet,
    is_table,
    laid_over,
)
from beamcam.conversion import Fault, converted, shown
from beamcam.errors import BeamcamError, Diagnostic, Source
from beamcam.files import write_whole
from beamcam.machine.machine import Machine
from beamcam.machine.toml import (
    MAX_TOML_BYTES,
    TomlError,
    TomlFile,
    TomlPlace,
    line_of,
    toml_text,
)
from beamcam.system import beginning_of, portable_path, user_folder


class ConfigError(BeamcamError):
    """A configuration that cannot be used."""


def load(path: str | Path) -> Config:
    """The configuration in a file. Raises ConfigError."""
    file = Path(path)
    try:
        text = toml_text(beginning_of(file, MAX_TOML_BYTES + 1))
        table = TomlFile(file, str(path), text).table
    except OSError as error:
        diagnostic = UNREADABLE.at(Source(str(path)), found=error.strerror or error)
        raise ConfigError(diagnostic) from error
    except TomlError as error:
        raise ConfigError(NOT_TOML.at(Source(str(path), error.line), found=error)) from error
    place = TomlPlace({"": (str(path), text)})
    try:
        read = converted(table, ConfigFile)
        for key in read.map:
            if key.startswith(("#", "rgb(", "rgba(")):
                from beamcam.model.colour import parse_colour

                try:
                    parse_colour(key)
                except ValueError as error:
                    raise Fault("value", ("map", key), key, "a colour such as '#ff0000'") from error
    except Fault as fault:
        raise ConfigError(_diagnostic(fault, place)) from None
    folder = file.resolve().parent

    def held(machine: str) -> str:
        """A machine's name, or its path as it holds wherever the command is called from."""
        return str(folder / machine.replace("\\", "/")) if machine.endswith(".toml") else machine

    values: dict[str, Any] = {name: getattr(read, name) for name in table}
    if read.machine:
        values["machine"] = held(read.machine)
    values["machines"] = {
        stock: held(named) if isinstance(named, str) else tuple(map(held, named))
        for stock, named in read.machines.items()
    }
    values["split"] = tuple(map(held, read.split))
    values["trust"] = tuple(str(folder / portable_path(place)) for place in read.trust)
    values["stock_lengths"] = tuple(sorted(set(read.stock_lengths)))
    rows = [f"{key}.{row}" for key in table if isinstance(table[key], dict) for row in table[key]]
    sources = {key: place.child(key).source for key in (*table, *rows)}
    return Config(**values, files=(str(path),), own=(str(path),), sources=sources)


def _diagnostic(fault: Fault, place: TomlPlace) -> Diagnostic:
    """The message for an invalid key of a configuration."""
    at = place.child(*fault.path)
    if fault.kind == "unknown":
        of = next((t for t, kind in TABLES.items() if at.key in kind.__struct_fields__), None)
        expected = fault.expected if of is None else f"it below [{of}], as {of}.{at.key}"
        return UNKNOWN_KEY.at(at.source, found=at.key, expected=expected)
    if fault.kind == "missing":  # of a row of the map, the only table with a key that it needs
        expected = f"one of {', '.join(map(repr, get_args(Meaning)))}"
        return WRONG_VALUE.at(at.source, key=at.key, found="nothing", expected=expected)
    found = shown(fault.found)
    return WRONG_VALUE.at(at.source, key=at.key, found=found, expected=fault.expected)


def merged(far: Config, near: Config) -> Config:
    """Two configurations as one: what the nearer sets goes over the same of the farther.

    A machine of the nearer one is that of every kind of stock for which it names no other.
    """
    keys = [key for key in ConfigFile.__struct_fields__ if key in near.sources]
    given = {
        key: {row: v for row, v in near.rows(key).items() if f"{key}.{row}" in near.sources}
        if is_table(getattr(near, key))
        else getattr(near, key)
        for key in keys
    }
    both = laid_over(far, given, near.sources)
    return replace(
        both, files=(*near.files, *far.files), own=(*near.own, *far.own),
        trust=(*near.trust, *far.trust), remarks=(*near.remarks, *far.remarks),
    )  # fmt: skip


MACHINES = "machines"  #: folder of machine files that are known by name


def is_ones_own_place(path: str) -> bool:
    """Whether a file lies where one's own configurations do, or their machines.

    That is in the folder of the command, in one above it, in the user's, or in `machines` of one.
    """
    folder = os.path.dirname(os.path.realpath(path))
    above, name = os.path.split(folder)
    places = (folder, above) if name == MACHINES else (folder,)
    here = os.path.join(os.path.abspath(""), CONFIG_NAME)
    users = _key(user_folder())
    return any(_key(place) == users or is_in(here, [place]) for place in places)


def is_in(path: str, folders: Iterable[str]) -> bool:
    """Whether a file lies in one of the folders, or anywhere below it; links are followed."""
    real = _key(path)
    return any(real.startswith(os.path.join(_key(folder), "")) for folder in folders)


def _key(path: str) -> str:
    return os.path.normcase(os.path.realpath(path))


# --- trust ----------------------------------------------------------------------------------------

# What is taken of a configuration that came with the parts.
#
# The sender of parts says what they are: how many, how thick, what a colour means, what they are
# called. The shop decides which machine makes them, what may be left out, where programs are
# written and how strict the run is.


#: Keys that are followed wherever a configuration lies; of rows of the map the process only.
HARMLESS = ("name", "job", "quantity", "map", "sheet.thickness", "sheet.material")


def harmless(config: Config) -> Config:
    """The harmless part of a configuration, with a remark that names the rest of it."""
    if not (diagnostics := not_followed(config)):
        return config
    sources = {key: at for key, at in config.sources.items() if _is_harmless(key)}
    given = {key: getattr(config, key) for key in sources if key in HARMLESS and "." not in key}
    if "map" in given:
        given["map"] = config.meanings
    sheet = {row: config.rows("sheet")[row] for row in config.rows("sheet")
             if f"sheet.{row}" in HARMLESS}  # fmt: skip
    if sheet:
        sources["sheet"] = config.sources["sheet"]
    return Config(
        **given, sheet=Sheet(**sheet), files=config.files, sources=sources, remarks=diagnostics
    )


def not_followed(config: Config) -> tuple[Diagnostic, ...]:
    """The message about the keys of a configuration that are more than harmless, if it has any."""
    keys: list[str] = []  # that are not harmless, with their rows
    for key in config.sources:
        if key == "map":
            for name, row in config.map.items():
                if isinstance(row, MapRow):
                    keys += [f"map.{name}.{key}" for key in row.values() if key != "process"]
        elif not _is_harmless(key) and not any(k.startswith(f"{key}.") for k in config.sources):
            keys.append(key)
    if not keys:
        return ()
    places = (config.place(key, key.rpartition(".")[0]) for key in keys)
    source = min(places, key=lambda at: at.line or 0)
    folder = os.path.dirname(config.files[0]) or os.curdir
    found = ", ".join(map(repr, keys))
    return (NOT_FOLLOWED.at(source, found=found, known=", ".join(HARMLESS), folder=folder),)


def _is_harmless(key: str) -> bool:
    return key in HARMLESS or key.startswith("map.")


# --- remember -------------------------------------------------------------------------------------

KEY = "trust"  #: in the user's own configuration: folders that the user trusts for good


def remember(folders: Sequence[str]) -> str:
    """Add folders to those that the user's own configuration trusts, and give its path.

    The rest of the file is kept. Raises ConfigError for a file that is no configuration, and
    OSError.
    """
    path = os.path.join(user_folder(), CONFIG_NAME)
    text = ""
    known: Sequence[str] = ()
    if os.path.exists(path):
        known = load(path).trust
        with open(path, "rb") as file:
            text = toml_text(file.read())
    every = tuple(dict.fromkeys((*known, *map(os.path.abspath, folders))))
    os.makedirs(os.path.dirname(path), exist_ok=True)
    write_whole(path, with_trust(text, every))
    return path


def with_trust(text: str, folders: Sequence[str]) -> str:
    """The text of a configuration with these folders as its `trust`, and nothing else changed."""
    line = f"{KEY} = {json.dumps(list(folders), ensure_ascii=False)}\n"
    table = tomllib.loads(text)
    if KEY not in table:
        return line + text
    rest = {key: value for key, value in table.items() if key != KEY}
    lines = text.splitlines(keepends=True)
    begin = (line_of(text, KEY) or 1) - 1
    for end in range(begin + 1, len(lines) + 1):  # the value may go on over several lines
        try:
            if tomllib.loads("".join(lines[:begin] + lines[end:])) == rest:
                return "".join([*lines[:begin], line, *lines[end:]])
        except tomllib.TOMLDecodeError:
            continue
    raise AssertionError("a key that stands in a text stands in one of its lines")


# --- apply ----------------------------------------------------------------------------------------

#: Key below `[tolerances]` -> field of the machine's drill that it stands for.
TOLERANCES = {
    "merge": "merge_tolerance", "duplicate": "duplicate_tolerance", "sink": "sink_tolerance",
    "path": "path_tolerance", "same_tool": "same_tool_tolerance",
}  # fmt: skip


def with_tolerances(machine: Machine, config: Config) -> Machine:
    """The machine with the configuration's tolerances in place of its own; itself if none.

    One configuration serves machines of all kinds, so that one that does not drill is left as it
    is. Raises ConfigError where that is the one that the configuration names for all its jobs.
    """
    tolerances = config.tolerances.given()
    if not tolerances:
        return machine
    if machine.drill is None:
        if config.machine is None or config.sources.get("machine") == COMMAND_LINE:
            return machine
        key = f"tolerances.{next(iter(tolerances))}"
        raise ConfigError(NO_DRILL.at(config.place(key), key=key, machine=machine.name))
    # By TOLERANCES the names are fields of a drill.
    drill = replace(machine.drill, **{TOLERANCES[name]: v for name, v in tolerances.items()})
    return replace(machine, drill=drill)
