"""The values of a configuration, and where its file is looked for.

Every command comes by here, so that this module needs next to nothing; `config.load` reads the
file if there is one.
"""

import os.path
from collections.abc import Iterable, Mapping
from typing import Any, Literal

from msgspec import Struct, field
from msgspec.structs import replace

from beamcam.errors import Source

CONFIG_NAME = "beamcam.toml"
COMMAND_LINE = Source("command line")
_MAGIC = frozenset("*?[")

Stock = Literal["beam", "sheet"]
Meaning = Literal["cut", "mark", "engrave", "ignore"]


class Setting(Struct, frozen=True):
    """One value and the place that it comes from."""

    key: str  #: dotted
    value: object
    source: Source | None  #: None for a default


class Config(Struct, frozen=True):
    """What a configuration says; the fields are the keys of the file."""

    machine: str | None = None
    machines: Mapping[Stock, str] = field(default_factory=dict)
    stock_lengths: tuple[float, ...] = ()  #: rising
    allow_skips: tuple[str, ...] = ()
    strict: bool = False
    job: str = "JOB"
    jobs: int | None = None
    name: str | None = None
    flat: bool = False
    tolerances: Mapping[str, float] = field(default_factory=dict)
    sheet: Mapping[str, Any] = field(default_factory=dict)
    map: Mapping[str, Meaning] = field(default_factory=dict)
    file: str | None = None  #: None where there is no file
    sources: Mapping[str, Source] = field(default_factory=dict)  #: by dotted key

    def settings(self) -> tuple[Setting, ...]:
        """Every value, the defaults included, each with where it was set."""
        rows: list[Setting] = []
        for key in self.__struct_fields__[:-2]:
            value = getattr(self, key)
            for name, row in value.items() if isinstance(value, Mapping) else (("", value),):
                dotted = f"{key}.{name}" if name else key
                rows.append(Setting(dotted, row, self.sources.get(dotted)))
        return tuple(rows)


def over(config: Config, asked: Mapping[str, Any]) -> Config:
    """The configuration with what the command line asks for in place of its own.

    `asked` goes by the names of `Config`; what is None is not asked for. Tables are laid over each
    other row by row, those of the command line before the others. A machine that is asked for is
    that of every kind of stock.
    """
    changed: dict[str, Any] = {}
    sources = dict(config.sources)
    for key, value in asked.items():
        if isinstance(value, Mapping):
            own = getattr(config, key)
            changed[key] = {**value, **{name: own[name] for name in own if name not in value}}
            sources |= {f"{key}.{name}": COMMAND_LINE for name in value}
        elif value is not None:
            changed[key] = value
            sources[key] = COMMAND_LINE
    if "machine" in changed:
        changed["machines"] = {}
    return replace(config, **changed, sources=sources) if changed else config


def beside(inputs: Iterable[str]) -> tuple[str, ...]:
    """Every configuration beside one of `inputs`, or in it if that is a folder; each once.

    Where there is none, the one in the folder that the command is called in, if there is that.
    Standard input lies in that folder too. It costs a look at each folder of the inputs, no more.
    """
    found: dict[str, str] = {}
    for folder in dict.fromkeys(map(_folder, inputs)):
        path = os.path.join(folder, CONFIG_NAME)
        if os.path.isfile(path):
            found.setdefault(os.path.realpath(path), path)
    return tuple(found.values()) or ((CONFIG_NAME,) if os.path.isfile(CONFIG_NAME) else ())


def _folder(name: str) -> str:
    """The folder of an input: itself if it is one; of a pattern as far as it has no magic."""
    if os.path.isdir(name):
        return name
    folder = os.path.dirname(name)
    while not _MAGIC.isdisjoint(folder) and not os.path.isdir(folder):
        folder = os.path.dirname(folder)
    return folder
