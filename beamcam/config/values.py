"""The values of a configuration, what the command line lays over them, and where they lie.

Every command comes by here, so that this module needs next to nothing; `config.load` reads the
files, if there are any.
"""

import os
from collections.abc import Iterable, Iterator, Mapping
from typing import Annotated, Any, Literal

from msgspec import Meta, Struct, field
from msgspec.structs import asdict, replace

from beamcam.budget import Limits
from beamcam.conversion import Count, Keys, NotNegative, Positive, PositiveCount, Text
from beamcam.errors import Diagnostic, Source
from beamcam.machine.torch import ChordSlack, Degrees, LayerSettings, Slack
from beamcam.system import is_ones_own, is_open_to_all, user_folder

COMMAND_LINE = Source("command line")

Stock = Literal["beam", "sheet"]
Meaning = Literal["cut", "mark", "engrave", "ignore"]
Origin = Literal["table", "lower-left", "lower-right", "upper-left", "upper-right", "centre"]
Machines = Annotated[tuple[Text, ...], Meta(min_length=1)]
Quantity = Literal["file"] | PositiveCount
ChosenBy = Literal["order", "time"]


class Setting(Struct, frozen=True):
    """One value and the place that it comes from."""

    key: str  #: dotted
    value: object
    source: Source | None  #: None for a default


class Table(Keys, frozen=True):
    """A table whose keys need not be set."""

    def given(self) -> dict[str, Any]:
        """The values that are set, by their names."""
        return {name: value for name, value in asdict(self).items() if value is not None}


class Sheet(Table, frozen=True):
    """Settings for cutting a sheet, named like the command line options."""

    thickness: Positive | None = None
    material: Text | None = None
    amps: Positive | None = None
    nozzle: Text | None = None
    kerf: NotNegative | None = None
    kerf_by: Literal["none", "offset", "machine"] | None = None
    lead: Literal["none", "line", "arc"] | None = None
    lead_in: NotNegative | None = None
    lead_out: NotNegative | None = None
    tabs: Count | None = None
    tab_width: Positive | None = None
    inner_tabs: bool | None = None
    overcut: NotNegative | None = None
    gap: Positive | None = None
    allow_open: bool | None = None
    place: Literal["corner", "drawn"] | None = None
    origin: Origin | None = None
    mirror: Literal["none", "x", "y"] | None = None
    rotate: Degrees | None = None
    copies: tuple[PositiveCount, PositiveCount] | None = None
    spacing: NotNegative | None = None
    common_cuts: bool | None = None
    chain_cuts: NotNegative | None = None  #: mm, the longest way between two parts, the torch on
    skeleton_cuts: bool | None = None
    sheet_size: tuple[Positive, Positive] | None = None  #: length and width of a sheet, mm
    unrolled: bool | None = None  #: whether pipes that are written as plates are cut flat


class Tolerances(Table, frozen=True):
    """Tolerances of drills, over the machine's own, mm."""

    merge: Slack | None = None
    duplicate: Slack | None = None
    sink: Slack | None = None
    path: ChordSlack | None = None
    same_tool: Slack | None = None


class Dask(Table, frozen=True):
    """The cluster that batches are worked on."""

    scheduler: Text | None = None  #: its address, as tcp://host:8786; without one no cluster
    answer_s: Annotated[float, Meta(gt=0, le=600)] | None = None  #: for it and its workers
    chunks: PositiveCount | None = None  #: of files that each thread has at a time, one in work


class MapRow(LayerSettings, frozen=True, kw_only=True):
    """Process and settings of a layer or a colour."""

    process: Meaning

    def settings(self) -> LayerSettings:
        """How it is done."""
        return LayerSettings(**{k: getattr(self, k) for k in LayerSettings.__struct_fields__})

    def values(self) -> dict[str, Any]:
        """The keys that say something, with their values."""
        return {"process": self.process} | {k: getattr(self, k) for k in self.settings().given()}


class ConfigFile(Keys, frozen=True):
    """A configuration; the fields are the keys of the file."""

    machine: Text | None = None  #: machine of --machine: a name or a TOML file
    #: by stock, before `machine`: one, or several that are tried in order
    machines: Mapping[Stock, Text | Machines] = field(default_factory=dict)
    by: ChosenBy = "order"  #: which of several machines makes a part: the first, or the quickest
    #: machines that make parts one after the other, as --machines: of `split`, `batch`, `watch`
    split: tuple[Text, ...] = ()
    stock_lengths: tuple[Positive, ...] = ()  #: bars in store, mm; the shortest that will do
    allow_skips: tuple[str, ...] = ()  #: kinds of features that may be left out
    strict: bool = False  #: whether warnings refuse a part
    job: Text = "JOB"  #: name in a program's first line
    jobs: PositiveCount | None = None  #: worker processes of a batch; all cores if not given
    name: Text | None = None  #: template of a batch's output names
    quantity: Quantity | None = None  #: pieces of each part: "file", or a number
    flat: bool = False  #: whether a batch writes all outputs to one folder
    tolerances: Tolerances = Tolerances()  #: of drills, over the machine's own, mm
    corner: Positive | None = None  #: outer radius of tubes whose file does not say it, mm
    #: what counts where header and contour of a DSTV file have different ends
    ends: Literal["contour", "header"] | None = None
    lip: Positive | None = None  #: length of a C's lips, if nothing else says it, mm
    sheet: Sheet = Sheet()  #: how sheets are cut, over the machine's own
    dask: Dask = Dask()  #: cluster of a batch
    limits: Limits = Limits()  #: how much a run may take
    #: what is done with a layer or a colour of a drawing
    map: Mapping[str, Meaning | MapRow] = field(default_factory=dict)
    #: folders whose configurations are followed in full, and all below them
    trust: tuple[Text, ...] = ()


class Config(ConfigFile, frozen=True):
    """A configuration as it was read, or several of which the nearer went over the farther."""

    files: tuple[str, ...] = ()  #: the nearest first
    own: tuple[str, ...] = ()  #: those of them that are followed in full
    sources: Mapping[str, Source] = field(default_factory=dict)  #: by dotted key
    remarks: tuple[Diagnostic, ...] = ()  #: on what is not followed

    def place(self, *keys: str) -> Source:
        """Where the first of the keys that is set stands; else the nearest file."""
        places = (self.sources[key] for key in keys if key in self.sources)
        return next(places, Source(next(iter(self.files), "configuration")))

    def machine_names(self, stock: Stock) -> tuple[str, ...]:
        """The machines that are named for a kind of stock, in the order in which they are tried."""
        named = self.machines.get(stock) or self.machine
        return () if named is None else (named,) if isinstance(named, str) else tuple(named)

    @property
    def all_machines(self) -> tuple[str, ...]:
        """Every machine that is named, each once."""
        named = (*self.machine_names("beam"), *self.machine_names("sheet"), *self.split)
        return tuple(dict.fromkeys(named))

    @property
    def meanings(self) -> dict[str, Meaning]:
        """The process of each layer or colour of the map."""
        return {k: v.process if isinstance(v, MapRow) else v for k, v in self.map.items()}

    @property
    def layer_settings(self) -> dict[str, LayerSettings]:
        """How layers and colours of the map are worked, where it says more than the process."""
        return {k: v.settings() for k, v in self.map.items() if isinstance(v, MapRow)}

    def rows(self, table: str) -> Mapping[str, Any]:
        """The rows of a key that is a table, by their names."""
        value: Mapping[str, Any] | Table | Limits = getattr(self, table)
        if isinstance(value, Limits):
            return asdict(value)
        return value.given() if isinstance(value, Table) else value

    def settings(self) -> tuple[Setting, ...]:
        """Every value, the defaults included, each with where it was set."""
        rows: list[Setting] = []
        for key in ConfigFile.__struct_fields__:
            value = getattr(self, key)
            for name, row in self.rows(key).items() if is_table(value) else (("", value),):
                dotted = f"{key}.{name}" if name else key
                value = row.values() if isinstance(row, MapRow) else row
                rows.append(Setting(dotted, value, self.sources.get(dotted)))
        return tuple(rows)


def over(config: Config, options: Mapping[str, Any]) -> Config:
    """The configuration with what the command line asks for in place of its own.

    `options` goes by the names of `Config`; what is None is not asked for. A machine that is asked
    for is that of every kind of stock.
    """
    given = {key: value for key, value in options.items() if value is not None}
    sources = dict.fromkeys(given, COMMAND_LINE)
    for key, value in given.items():
        if isinstance(value, Mapping):
            sources |= {f"{key}.{name}": COMMAND_LINE for name in value}
            del sources[key]
    return laid_over(config, given, sources)


#: Keys that are tables of their own.
TABLES: dict[str, type[Table | Limits]] = {
    "tolerances": Tolerances, "sheet": Sheet, "dask": Dask, "limits": Limits,
}  # fmt: skip


def is_table(value: object) -> bool:
    """Whether a value has rows of its own, which are laid over those of another one by one."""
    return isinstance(value, Mapping | Table | Limits)


def laid_over(config: Config, given: Mapping[str, Any], sources: Mapping[str, Source]) -> Config:
    """The configuration with what is given in place of its own; tables row by row."""
    if not given:
        return config
    changed: dict[str, Any] = {}
    kept = dict(config.sources)
    if "machine" in given:
        changed["machines"], changed["split"] = {}, ()
        kept = {k: v for k, v in kept.items() if k.partition(".")[0] not in ("machines", "split")}
    for key, value in given.items():
        if isinstance(value, Mapping):
            own = changed.get(key, config.rows(key))
            changed[key] = {**value, **{name: own[name] for name in own if name not in value}}
        else:
            changed[key] = value
    for key, record in TABLES.items():
        if key in changed:
            changed[key] = record(**changed[key])
    return replace(config, **changed, sources={**kept, **sources})


# --- places ---------------------------------------------------------------------------------------

# Where the configurations of a job are looked for, and whose they are.
#
#     shop/beamcam.toml         here, where the command is called, or above: one's own
#     shop/jobs/beamcam.toml    beside the inputs, further down or elsewhere: came with the parts
#     ~/.config/beamcam/        the user's own, the farthest of all


CONFIG_NAME = "beamcam.toml"


class ConfigFiles(Struct, frozen=True):
    """The configurations of a job, each list with the nearest first."""

    beside: tuple[str, ...] = ()  #: of the folders of the inputs and those above
    own: tuple[str, ...] = ()  #: of the folder of the command, those above, and the user
    #: the nearest of two inputs of the job, where these are different ones
    two: tuple[str, str] | None = None


def config_files(inputs: Iterable[str]) -> ConfigFiles:
    """The configurations that hold for a job on `inputs`. It costs a look at each folder.

    Each stands once, and what is one's own is not beside. Standard input lies in the folder that
    the command is called in.
    """
    own = own_files()
    known = {os.path.realpath(path): path for path in own}
    near: dict[str, tuple[str, ...]] = {}
    for folder in dict.fromkeys(map(_folder, inputs)):
        if chain := tuple(_upwards(folder)):
            near.setdefault(os.path.realpath(chain[0]), chain)
    first, *others = near.values() or [()]
    beside = {real: path for path in first if (real := os.path.realpath(path)) not in known}
    return ConfigFiles(tuple(beside.values()), own, (first[0], others[0][0]) if others else None)


def own_files() -> tuple[str, ...]:
    """The configurations here, in the folders above, and the user's own, the nearest first.

    In a folder that anybody may write to one has to belong to the user, or to the system's owner.
    """
    paths = [
        path for path in _upwards("")
        if path != CONFIG_NAME or not is_open_to_all(os.curdir) or is_ones_own(path)
    ]  # fmt: skip
    users = os.path.join(user_folder(), CONFIG_NAME)
    if os.path.isfile(users):
        paths.append(users)
    return tuple({os.path.realpath(path): path for path in reversed(paths)}.values())[::-1]


def _upwards(folder: str) -> Iterator[str]:
    """The configurations in a folder and in those above it.

    A folder above in which anybody may put a file is passed over.
    """
    path = os.path.join(folder, CONFIG_NAME)
    if os.path.isfile(path):
        yield path
    below, here = os.path.abspath(folder), os.path.abspath("")
    while (above := os.path.dirname(below)) != below:
        path = os.path.join(above, CONFIG_NAME)
        if os.path.isfile(path) and not is_open_to_all(above):
            yield CONFIG_NAME if above == here else path
        below = above


def _folder(name: str) -> str:
    """The folder of an input: itself if it is one; of a pattern as far as it has no magic."""
    if os.path.isdir(name):
        return name
    folder = os.path.dirname(name)
    while not {*"*?["}.isdisjoint(folder) and not os.path.isdir(folder):
        folder = os.path.dirname(folder)
    return folder
