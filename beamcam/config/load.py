"""A configuration read from its file, each value with the line that sets it."""

import tomllib
from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Any, cast

from msgspec import Struct, field

from beamcam.config import rules
from beamcam.config.keys import KEYS, Check, Table, Unfit, layer_or_colour
from beamcam.errors import BeamcamError, Source
from beamcam.machine.schema import line_of, nearest
from beamcam.model.part import Process

CONFIG_NAME = "beamcam.toml"


class ConfigError(BeamcamError):
    """A configuration that cannot be used."""


class Setting(Struct, frozen=True):
    """One value and the place that it comes from."""

    key: str  #: dotted
    value: object
    source: Source | None  #: None for a default


class Config(Struct, frozen=True):
    """What a configuration says; the fields are the keys of the file."""

    machine: str | None = None
    stock_lengths: tuple[float, ...] = ()
    allow_skips: tuple[str, ...] = ()
    strict: bool = False
    job: str = "JOB"
    jobs: int | None = None
    name: str | None = None
    flat: bool = False
    tolerances: Mapping[str, float] = field(default_factory=dict)
    map: Mapping[str, Process] = field(default_factory=dict)
    file: str | None = None  #: None where there is no file
    sources: Mapping[str, Source] = field(default_factory=dict)  #: by dotted key

    def settings(self) -> tuple[Setting, ...]:
        """Every value, the defaults included, each with where it was set."""
        rows: list[Setting] = []
        for key, known in KEYS.items():
            value = getattr(self, key)
            if isinstance(known, Table):
                rows += [
                    Setting(f"{key}.{name}", row, self.sources[f"{key}.{name}"])
                    for name, row in value.items()
                ]
            else:
                rows.append(Setting(key, value, self.sources.get(key)))
        return tuple(rows)


def find(inputs: Iterable[str] = ()) -> Path | None:
    """The configuration beside the first of `inputs` (in it, if a folder), else the one here.

    None if there is neither.
    """
    for name in inputs:
        path = Path(name)
        folder = path if path.is_dir() else path.parent
        if (folder / CONFIG_NAME).is_file():
            return folder / CONFIG_NAME
        break
    here = Path(CONFIG_NAME)
    return here if here.is_file() else None


def load(path: str | Path | None) -> Config:
    """The configuration in a file; the defaults for None. Raises ConfigError."""
    if path is None:
        return Config()
    file = Path(path)
    shown = str(path)
    try:
        content = file.read_bytes().decode("utf-8")
        table = tomllib.loads(content)
    except OSError as error:
        said = rules.UNREADABLE.at(Source(shown), found=error.strerror or error)
        raise ConfigError(said) from error
    except (tomllib.TOMLDecodeError, UnicodeDecodeError) as error:
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
            if known.names is not None and name not in known.names:
                raise ConfigError(
                    rules.UNKNOWN_KEY.at(
                        source(dotted), found=dotted, expected=nearest(name, known.names)
                    )
                )
            if known.names is None:
                checked(dotted, lambda word, _: layer_or_colour(cast(str, word)), name)
            rows[name] = checked(dotted, known.check, row)
        values[key] = rows
    return Config(**cast("dict[str, Any]", values), file=shown, sources=sources)


def _table(value: object, folder: Path) -> object:
    if not isinstance(value, dict):
        raise Unfit("a table")
    return value
