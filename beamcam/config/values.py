"""The values of a configuration, and where its file is looked for.

Every command comes by here, so that this module needs next to nothing; `config.load` reads the
file if there is one.
"""

import os.path
from collections.abc import Iterable, Mapping
from typing import Annotated, Any, Literal

from msgspec import Meta, Struct, field
from msgspec.structs import asdict, replace

from beamcam.conversion import Count, Keys, NotNegative, Positive, PositiveCount, Text
from beamcam.errors import Source
from beamcam.machine.torch import Degrees, LookSettings
from beamcam.system import is_open_to_all, user_folder

CONFIG_NAME = "beamcam.toml"
COMMAND_LINE = Source("command line")
_MAGIC = frozenset("*?[")

Stock = Literal["beam", "sheet"]
Meaning = Literal["cut", "mark", "engrave", "ignore"]
Origin = Literal["table", "lower-left", "lower-right", "upper-left", "upper-right", "centre"]
Machines = Annotated[tuple[Text, ...], Meta(min_length=1)]
Quantity = Literal["file"] | PositiveCount
Tolerance = Literal["merge", "duplicate", "sink", "path", "twin"]


class Setting(Struct, frozen=True):
    """One value and the place that it comes from."""

    key: str  #: dotted
    value: object
    source: Source | None  #: None for a default


class Sheet(Keys, frozen=True):
    """Settings for cutting a sheet, named like the command line options."""

    thickness: Positive | None = None
    material: Text | None = None
    kerf: NotNegative | None = None
    kerf_by: Literal["none", "offset", "machine"] | None = None
    lead: Literal["none", "line", "arc"] | None = None
    lead_in: NotNegative | None = None
    lead_out: NotNegative | None = None
    tabs: Count | None = None
    tab_width: Positive | None = None
    inner_tabs: bool | None = None
    overcut: NotNegative | None = None
    place: Literal["corner", "drawn"] | None = None
    origin: Origin | None = None
    mirror: Literal["none", "x", "y"] | None = None
    rotate: Degrees | None = None
    copies: tuple[PositiveCount, PositiveCount] | None = None
    spacing: NotNegative | None = None
    sheet_size: tuple[Positive, Positive] | None = None  #: length and width of a sheet, mm
    unrolled: bool | None = None  #: whether pipes that are written as plates are cut flat

    def given(self) -> dict[str, Any]:
        """The values that are set, by their names."""
        return {name: value for name, value in asdict(self).items() if value is not None}


class Dask(Keys, frozen=True):
    """The cluster that batches are worked on."""

    scheduler: Text | None = None  #: its address, as tcp://host:8786; without one no cluster
    answer_s: Annotated[float, Meta(gt=0, le=600)] | None = None  #: for it and its workers
    chunks: PositiveCount | None = None  #: of files that each thread has at a time, one in work

    def given(self) -> dict[str, Any]:
        """The values that are set, by their names."""
        return {name: value for name, value in asdict(self).items() if value is not None}


class MapRow(LookSettings, frozen=True, kw_only=True):
    """Process and settings of a layer or a colour."""

    process: Meaning

    def settings(self) -> LookSettings:
        """How it is done."""
        return LookSettings(**{k: getattr(self, k) for k in LookSettings.__struct_fields__})

    def said(self) -> dict[str, Any]:
        """The keys that say something, with their values."""
        return {"process": self.process} | {k: getattr(self, k) for k in self.settings().given()}


class ConfigFile(Keys, frozen=True):
    """A configuration; the fields are the keys of the file."""

    machine: Text | None = None  #: machine of --machine: a name or a TOML file
    #: by stock, before `machine`: one, or several that are tried in order
    machines: Mapping[Stock, Text | Machines] = field(default_factory=dict)
    stock_lengths: tuple[Positive, ...] = ()  #: bars in store, mm; the shortest that will do
    allow_skips: tuple[str, ...] = ()  #: kinds of features that may be left out
    strict: bool = False  #: whether warnings refuse a part
    job: Text = "JOB"  #: name in a program's first line
    jobs: PositiveCount | None = None  #: worker processes of a batch; all cores if not given
    name: Text | None = None  #: template of a batch's output names
    quantity: Quantity | None = None  #: pieces of each part: "file", or a number
    flat: bool = False  #: whether a batch writes all outputs to one folder
    #: of drills, over the machine's own, mm
    tolerances: Mapping[Tolerance, NotNegative] = field(default_factory=dict)
    sheet: Sheet = Sheet()  #: how sheets are cut, over the machine's own
    dask: Dask = Dask()  #: cluster of a batch
    #: what is done with a layer or a colour of a drawing
    map: Mapping[str, Meaning | MapRow] = field(default_factory=dict)


class Config(ConfigFile, frozen=True):
    """A configuration as it was read."""

    file: str | None = None  #: None where there is no file
    sources: Mapping[str, Source] = field(default_factory=dict)  #: by dotted key

    def machine_names(self, stock: Stock) -> tuple[str, ...]:
        """The machines that are named for a kind of stock, in the order in which they are tried."""
        named = self.machines.get(stock) or self.machine
        return () if named is None else (named,) if isinstance(named, str) else tuple(named)

    @property
    def meanings(self) -> dict[str, Meaning]:
        """The process of each layer or colour of the map."""
        return {k: v.process if isinstance(v, MapRow) else v for k, v in self.map.items()}

    @property
    def look_settings(self) -> dict[str, LookSettings]:
        """How layers and colours of the map are worked, where it says more than the process."""
        return {k: v.settings() for k, v in self.map.items() if isinstance(v, MapRow)}

    def rows(self, table: str) -> Mapping[str, Any]:
        """The rows of a key that is a table, by their names."""
        value: Mapping[str, Any] | Sheet | Dask = getattr(self, table)
        return value.given() if isinstance(value, Sheet | Dask) else value

    def settings(self) -> tuple[Setting, ...]:
        """Every value, the defaults included, each with where it was set."""
        rows: list[Setting] = []
        for key in self.__struct_fields__[:-2]:
            value = getattr(self, key)
            tabular = isinstance(value, Mapping | Sheet | Dask)
            for name, row in self.rows(key).items() if tabular else (("", value),):
                dotted = f"{key}.{name}" if name else key
                value = row.said() if isinstance(row, MapRow) else row
                rows.append(Setting(dotted, value, self.sources.get(dotted)))
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
            own = config.rows(key)
            changed[key] = {**value, **{name: own[name] for name in own if name not in value}}
            sources |= {f"{key}.{name}": COMMAND_LINE for name in value}
        elif value is not None:
            changed[key] = value
            sources[key] = COMMAND_LINE
    if "sheet" in changed:
        changed["sheet"] = Sheet(**changed["sheet"])
    if "dask" in changed:
        changed["dask"] = Dask(**changed["dask"])
    if "machine" in changed:
        changed["machines"] = {}
    return replace(config, **changed, sources=sources) if changed else config


def beside(inputs: Iterable[str]) -> tuple[str, ...]:
    """Every configuration that holds for one of `inputs`, each once: two are one too many.

    It is the nearest in the folder of an input, or in the input if that is a folder, and those
    above; where none is, the nearest in the folder that the command is called in and those above,
    or else the user's own. Standard input lies in that folder too. It costs a look at each folder.
    """
    found: dict[str, str] = {}
    for folder in dict.fromkeys(map(_folder, inputs)):
        if path := _nearest(folder):
            found.setdefault(os.path.realpath(path), path)
    if found:
        return tuple(found.values())
    own = os.path.join(user_folder(), CONFIG_NAME)
    path = _nearest("") or (own if os.path.isfile(own) else None)
    return () if path is None else (path,)


def _nearest(folder: str) -> str | None:
    """The configuration in a folder, or in the nearest above it that has one.

    A folder above in which anybody may put a file is passed over.
    """
    path = os.path.join(folder, CONFIG_NAME)
    if os.path.isfile(path):
        return path
    below, here = os.path.abspath(folder), os.path.abspath("")
    while (above := os.path.dirname(below)) != below:
        path = os.path.join(above, CONFIG_NAME)
        if os.path.isfile(path) and not is_open_to_all(above):
            return CONFIG_NAME if above == here else path
        below = above
    return None


def _folder(name: str) -> str:
    """The folder of an input: itself if it is one; of a pattern as far as it has no magic."""
    if os.path.isdir(name):
        return name
    folder = os.path.dirname(name)
    while not _MAGIC.isdisjoint(folder) and not os.path.isdir(folder):
        folder = os.path.dirname(folder)
    return folder
