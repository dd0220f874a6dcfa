"""A configuration read from its file, each value with the line that sets it."""

from collections.abc import Mapping
from pathlib import Path
from typing import Any, get_args

from msgspec.structs import replace

from beamcam.budget import Limits
from beamcam.config import rules
from beamcam.config.values import COMMAND_LINE, Config, ConfigFile, Dask, Meaning, Sheet
from beamcam.conversion import Fault, converted
from beamcam.errors import BeamcamError, Diagnostic, Source
from beamcam.machine.machine import Machine
from beamcam.machine.range_faults import slack_faults
from beamcam.machine.toml import MAX_TOML_BYTES, Place, TomlError, TomlFile, toml_text
from beamcam.model.colour import parse_colour
from beamcam.system import beginning_of, portable_path


class ConfigError(BeamcamError):
    """A configuration that cannot be used."""


def load(path: str | Path) -> Config:
    """The configuration in a file. Raises ConfigError."""
    file = Path(path)
    try:
        text = toml_text(beginning_of(file, MAX_TOML_BYTES + 1))
        table = TomlFile(file, str(path), text).table
    except OSError as error:
        said = rules.UNREADABLE.at(Source(str(path)), found=error.strerror or error)
        raise ConfigError(said) from error
    except TomlError as error:
        raise ConfigError(rules.NOT_TOML.at(Source(str(path), error.line), found=error)) from error
    place = Place({"": (str(path), text)})
    try:
        read = converted(table, ConfigFile)
        _check_colours(read.map)
    except Fault as fault:
        raise ConfigError(_said(fault, place)) from None
    folder = file.resolve().parent
    values: dict[str, Any] = {name: getattr(read, name) for name in table}
    if read.machine:
        values["machine"] = _from(folder, read.machine)
    if read.machines:
        values["machines"] = {
            stock: _from(folder, named)
            if isinstance(named, str)
            else tuple(_from(folder, name) for name in named)
            for stock, named in read.machines.items()
        }
    values["split"] = tuple(_from(folder, name) for name in read.split)
    values["trust"] = tuple(str(folder / portable_path(place)) for place in read.trust)
    values["stock_lengths"] = tuple(sorted(set(read.stock_lengths)))
    return Config(**values, files=(str(path),), own=(str(path),), sources=_sources(table, place))


def _from(folder: Path, machine: str) -> str:
    """A machine's name, or its path as it holds wherever the command is called from."""
    return str(folder / machine.replace("\\", "/")) if machine.endswith(".toml") else machine


def _sources(table: Mapping[str, Any], place: Place) -> dict[str, Source]:
    """Source of each key, and of each row of a table."""
    rows = [f"{key}.{row}" for key in table if isinstance(table[key], dict) for row in table[key]]
    return {key: place.child(key).source for key in (*table, *rows)}


def _check_colours(colours: Mapping[str, object]) -> None:
    """Raises Fault for a key of the map that starts like a colour and is not one."""
    for key in colours:
        if key.startswith(("#", "rgb(", "rgba(")):
            try:
                parse_colour(key)
            except ValueError as error:
                raise Fault("value", ("map", key), key, "a colour such as '#ff0000'") from error


def _said(fault: Fault, place: Place) -> Diagnostic:
    """The message for an invalid key of a configuration."""
    from beamcam.conversion.diagnosis import shown

    at = place.child(*fault.path)
    if fault.kind == "unknown":
        tables = {"sheet": Sheet, "dask": Dask, "limits": Limits}
        of = next((t for t, kind in tables.items() if at.key in kind.__struct_fields__), None)
        expected = fault.expected if of is None else f"it below [{of}], as {of}.{at.key}"
        return rules.UNKNOWN_KEY.at(at.source, found=at.key, expected=expected)
    if fault.kind == "missing":  # of a row of the map, the only table with a key that it needs
        expected = f"one of {', '.join(map(repr, get_args(Meaning)))}"
        return rules.WRONG_VALUE.at(at.source, key=at.key, found="nothing", expected=expected)
    found = shown(fault.found)
    return rules.WRONG_VALUE.at(at.source, key=at.key, found=found, expected=fault.expected)


# --- apply ----------------------------------------------------------------------------------------

# Changes of a drilling machine by a configuration: its tolerances.


#: Key below `[tolerances]` -> field of the machine's drill that it stands for.
TOLERANCES = {
    "merge": "merge_tolerance",
    "duplicate": "duplicate_tolerance",
    "sink": "sink_tolerance",
    "path": "path_tolerance",
    "twin": "twin",
}


def with_tolerances(machine: Machine, config: Config) -> Machine:
    """The machine with the configuration's tolerances in place of its own; itself if none.

    One configuration serves machines of all kinds, so that one that does not drill is left as it
    is. Raises ConfigError where that is the one that the configuration names for all its jobs, and
    for a tolerance that no machine file may have.
    """
    if not config.tolerances:
        return machine
    if machine.drill is None:
        if config.machine is None or config.sources.get("machine") == COMMAND_LINE:
            return machine
        key = f"tolerances.{next(iter(config.tolerances))}"
        source = config.place(key)
        raise ConfigError(rules.NO_DRILL.at(source, key=key, machine=machine.name))
    changed = {TOLERANCES[name]: value for name, value in config.tolerances.items()}
    # The names are those of TOLERANCES, so that they are fields of a drill.
    drill = replace(machine.drill, **changed)
    wrong = {name: rest for name, *rest in slack_faults(drill)}
    for name in config.tolerances:
        if TOLERANCES[name] in wrong:
            found, expected = wrong[TOLERANCES[name]]
            key = f"tolerances.{name}"
            source = config.place(key)
            said = rules.WRONG_VALUE.at(source, key=key, found=f"{found:g}", expected=expected)
            raise ConfigError(said)
    return replace(machine, drill=drill)
