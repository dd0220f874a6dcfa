"""The values of a configuration, and how one is laid over another.

Every command comes by here, so that this module needs next to nothing; `config.load` reads the
file if there is one.
"""

from collections.abc import Mapping
from pathlib import Path
from typing import Annotated, Any, Literal, get_args

from msgspec import Meta, Struct, field
from msgspec.structs import asdict, replace

from beamcam.budget import Limits
from beamcam.config import NO_DRILL, NOT_TOML, UNKNOWN_KEY, UNREADABLE, WRONG_VALUE
from beamcam.conversion import (
    Count,
    Fault,
    Keys,
    NotNegative,
    Positive,
    PositiveCount,
    Text,
    converted,
)
from beamcam.errors import BeamcamError, Diagnostic, Source
from beamcam.machine.faults import slack_faults
from beamcam.machine.machine import Machine
from beamcam.machine.toml import MAX_TOML_BYTES, TomlError, TomlFile, TomlPlace, toml_text
from beamcam.machine.torch import Degrees, LayerSettings
from beamcam.system import beginning_of, portable_path

COMMAND_LINE = Source("command line")

Stock = Literal["beam", "sheet"]
Meaning = Literal["cut", "mark", "engrave", "ignore"]
Origin = Literal["table", "lower-left", "lower-right", "upper-left", "upper-right", "centre"]
Machines = Annotated[tuple[Text, ...], Meta(min_length=1)]
Quantity = Literal["file"] | PositiveCount
ChosenBy = Literal["order", "time"]
Tolerance = Literal["merge", "duplicate", "sink", "path", "same_tool"]


class Setting(Struct, frozen=True):
    """One value and the place that it comes from."""

    key: str  #: dotted
    value: object
    source: Source | None  #: None for a default


class Sheet(Keys, frozen=True):
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


class MapRow(LayerSettings, frozen=True, kw_only=True):
    """Process and settings of a layer or a colour."""

    process: Meaning

    def settings(self) -> LayerSettings:
        """How it is done."""
        return LayerSettings(**{k: getattr(self, k) for k in LayerSettings.__struct_fields__})

    def said(self) -> dict[str, Any]:
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
    #: of drills, over the machine's own, mm
    tolerances: Mapping[Tolerance, NotNegative] = field(default_factory=dict)
    corner: Positive | None = None  #: outer radius of a tube's corners, if nothing else says it, mm
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
        value: Mapping[str, Any] | Sheet | Dask | Limits = getattr(self, table)
        return value.given() if isinstance(value, Sheet | Dask | Limits) else value

    def settings(self) -> tuple[Setting, ...]:
        """Every value, the defaults included, each with where it was set."""
        rows: list[Setting] = []
        for key in ConfigFile.__struct_fields__:
            value = getattr(self, key)
            for name, row in self.rows(key).items() if is_table(value) else (("", value),):
                dotted = f"{key}.{name}" if name else key
                value = row.said() if isinstance(row, MapRow) else row
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
    return _laid_over(config, given, sources)


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
    both = _laid_over(far, given, near.sources)
    return replace(
        both, files=(*near.files, *far.files), own=(*near.own, *far.own),
        trust=(*near.trust, *far.trust), remarks=(*near.remarks, *far.remarks),
    )  # fmt: skip


def is_table(value: object) -> bool:
    """Whether a value has rows of its own, which are laid over those of another one by one."""
    return isinstance(value, Mapping | Sheet | Dask | Limits)


def _laid_over(config: Config, given: Mapping[str, Any], sources: Mapping[str, Source]) -> Config:
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
    for key, record in (("sheet", Sheet), ("dask", Dask), ("limits", Limits)):
        if key in changed:
            changed[key] = record(**changed[key])
    return replace(config, **changed, sources={**kept, **sources})


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


def _sources(table: Mapping[str, Any], place: TomlPlace) -> dict[str, Source]:
    """Source of each key, and of each row of a table."""
    rows = [f"{key}.{row}" for key in table if isinstance(table[key], dict) for row in table[key]]
    return {key: place.child(key).source for key in (*table, *rows)}


def _check_colours(colours: Mapping[str, object]) -> None:
    """Raises Fault for a key of the map that starts like a colour and is not one."""
    if not colours:
        return
    from beamcam.model.colour import parse_colour

    for key in colours:
        if key.startswith(("#", "rgb(", "rgba(")):
            try:
                parse_colour(key)
            except ValueError as error:
                raise Fault("value", ("map", key), key, "a colour such as '#ff0000'") from error


def _said(fault: Fault, place: TomlPlace) -> Diagnostic:
    """The message for an invalid key of a configuration."""
    from beamcam.conversion import shown

    at = place.child(*fault.path)
    if fault.kind == "unknown":
        tables = {"sheet": Sheet, "dask": Dask, "limits": Limits}
        of = next((t for t, kind in tables.items() if at.key in kind.__struct_fields__), None)
        expected = fault.expected if of is None else f"it below [{of}], as {of}.{at.key}"
        return UNKNOWN_KEY.at(at.source, found=at.key, expected=expected)
    if fault.kind == "missing":  # of a row of the map, the only table with a key that it needs
        expected = f"one of {', '.join(map(repr, get_args(Meaning)))}"
        return WRONG_VALUE.at(at.source, key=at.key, found="nothing", expected=expected)
    found = shown(fault.found)
    return WRONG_VALUE.at(at.source, key=at.key, found=found, expected=fault.expected)


# --- apply ----------------------------------------------------------------------------------------

# Changes of a drilling machine by a configuration: its tolerances.


#: Key below `[tolerances]` -> field of the machine's drill that it stands for.
TOLERANCES = {
    "merge": "merge_tolerance", "duplicate": "duplicate_tolerance", "sink": "sink_tolerance",
    "path": "path_tolerance", "same_tool": "same_tool_tolerance",
}  # fmt: skip


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
        raise ConfigError(NO_DRILL.at(source, key=key, machine=machine.name))
    changed = {TOLERANCES[name]: value for name, value in config.tolerances.items()}
    # The names are those of TOLERANCES, so that they are fields of a drill.
    drill = replace(machine.drill, **changed)
    wrong = {name: rest for name, *rest in slack_faults(drill)}
    for name in config.tolerances:
        if TOLERANCES[name] in wrong:
            found, expected = wrong[TOLERANCES[name]]
            key = f"tolerances.{name}"
            source = config.place(key)
            diagnostic = WRONG_VALUE.at(source, key=key, found=f"{found:g}", expected=expected)
            raise ConfigError(diagnostic)
    return replace(machine, drill=drill)
