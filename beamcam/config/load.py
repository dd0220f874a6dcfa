"""A configuration read from its file, each value with the line that sets it."""

from pathlib import Path
from typing import Any, cast

from beamcam.config import rules
from beamcam.config.keys import KEYS, Check, Table, Unfit, layer_or_colour
from beamcam.config.values import Config
from beamcam.errors import BeamcamError, Source
from beamcam.machine.schema import nearest
from beamcam.machine.toml import TomlError, TomlFile, line_of, toml_text


class ConfigError(BeamcamError):
    """A configuration that cannot be used."""


def load(path: str | Path) -> Config:
    """The configuration in a file. Raises ConfigError."""
    file = Path(path)
    shown = str(path)
    try:
        content = toml_text(file.read_bytes())
        table = TomlFile(file, shown, content).table
    except OSError as error:
        said = rules.UNREADABLE.at(Source(shown), found=error.strerror or error)
        raise ConfigError(said) from error
    except TomlError as error:
        raise ConfigError(rules.NOT_TOML.at(Source(shown), found=error)) from error
    sources: dict[str, Source] = {}
    values: dict[str, object] = {}
    folder = file.resolve().parent

    def source(key: str) -> Source:
        return Source(shown, line_of(content, key))

    def checked(key: str, check: Check, value: object) -> object:
        sources[key] = source(key)
        try:
            return check(value, folder)
        except Unfit as unfit:
            raise ConfigError(
                rules.WRONG_VALUE.at(source(key), key=key, found=repr(value), expected=unfit)
            ) from unfit

    for key, value in table.items():
        known = KEYS.get(key)
        if known is None:
            said = rules.UNKNOWN_KEY.at(source(key), found=key, expected=nearest(key, KEYS))
            raise ConfigError(said)
        if not isinstance(known, Table):
            values[key] = checked(key, known.check, value)
            continue
        checked(key, _table, value)
        rows = {}
        for name, row in cast("dict[str, object]", value).items():
            dotted = f"{key}.{name}"
            check = known.rows.get(name, known.others)
            if check is None:
                raise ConfigError(
                    rules.UNKNOWN_KEY.at(
                        source(dotted), found=dotted, expected=nearest(name, known.rows)
                    )
                )
            if name not in known.rows:
                checked(dotted, lambda word, _: layer_or_colour(cast(str, word)), name)
            rows[name] = checked(dotted, check, row)
        values[key] = rows
    return Config(**cast("dict[str, Any]", values), file=shown, sources=sources)


def _table(value: object, folder: Path) -> object:
    if not isinstance(value, dict):
        raise Unfit("a table")
    return value
