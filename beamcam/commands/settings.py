"""Settings of a job: the command line over the configuration, and the resulting machine.

--machine and other options   over   --config FILE, or else each beamcam.toml beside the job, here,
above and of the user, the nearest first   over   the defaults; the same for every command
"""

from collections.abc import Iterable, Iterator, Mapping, Sequence
from typing import Any, Literal

import click
from msgspec.structs import replace

from beamcam.arguments import InTurn, load_tested
from beamcam.budget import InForce
from beamcam.commands.common import remark, running_console
from beamcam.config.values import (
    COMMAND_LINE,
    Config,
    ConfigFiles,
    Stock,
    config_files,
    over,
    own_files,
)
from beamcam.errors import BeamcamError, Diagnostic, MachineError, PlanError, Source
from beamcam.files import FilesRead
from beamcam.machine import Machine
from beamcam.machine.machine import default_machines, is_of_sheets
from beamcam.machine.words import UNKNOWN_MACHINE
from beamcam.model.part import Part
from beamcam.model.request import are_flats, stock_of
from beamcam.readers import Reading

#: Keys of a configuration that are options of their own, by the name of the option's value.
_OPTIONS = {
    "machine": "machine", "by": "by", "machines": "split", "skips": "allow_skips",
    "strict": "strict", "job": "job", "jobs": "jobs", "name": "name", "quantity": "quantity",
    "flat": "flat", "colours": "map", "corner": "corner", "lip": "lip", "ends": "ends",
}  # fmt: skip
#: Options that are rows of the table `[sheet]`.
SAME_THICKNESS = 0.01  #: mm that two statements may differ by
SHEET_OPTIONS = (
    "thickness", "material", "amps", "nozzle", "kerf", "kerf_by", "lead", "lead_in",
    "lead_out", "tabs", "tab_width", "inner_tabs", "overcut", "gap", "allow_open", "place",
    "origin", "mirror",
    "rotate", "copies", "spacing", "common_cuts", "chain_cuts", "skeleton_cuts", "sheet_size",
    "unrolled",
)  # fmt: skip


def settled(options: Mapping[str, Any], inputs: Iterable[str]) -> Config:
    """The configuration of a job on `inputs`, what the command line asks for laid over it.

    `options` holds the values of the options, `config_file` among them. Raises ConfigError.
    """
    file = options.get("config_file")
    files = config_files(inputs) if file is None else ConfigFiles(own=(file,))
    config = Config()
    if files != ConfigFiles():
        from beamcam.commands.configuration import checked

        config = checked(files, options.get("trust", ()))
        remark(config.remarks)
    return _in_force(over(config, _wanted(options)))


def settled_again(
    options: Mapping[str, Any], files: ConfigFiles, machines: Iterable[str]
) -> Config:
    """The same by the files that the record of a batch names, and those of its `machines`.

    --config goes before these files. Raises ConfigError if one of them is not trusted.
    """
    from beamcam.commands.configuration import checked, checked_again, refuse_strange

    trust = (*options.get("trust", ()), *checked(ConfigFiles(own=own_files())).trust)
    for machine in machines:
        if machine.endswith(".toml"):
            refuse_strange(machine, trust)
    if options.get("config_file") is not None:
        return settled(options, ())
    return _in_force(over(checked_again(files, trust), _wanted(options)))


def _in_force(config: Config) -> Config:
    """The configuration as it holds: its limits for all that follows, its machines by their paths.

    Raises MachineError as `_with_own_machines`.
    """
    InForce.limits = config.limits
    return _with_own_machines(config)


def _with_own_machines(config: Config) -> Config:
    """The configuration with the paths of one's own machines in place of their names.

    Raises MachineError where a name is that of a shipped machine too.
    """
    if config.machine is None and not config.machines and not config.split:
        return config
    from beamcam.machine.load import resolved

    machine = config.machine and resolved(config.machine, config.own)
    machines = {
        stock: resolved(named, config.own)
        if isinstance(named, str)
        else tuple(resolved(name, config.own) for name in named)
        for stock, named in config.machines.items()
    }
    split = tuple(resolved(name, config.own) for name in config.split)
    return replace(config, machine=machine, machines=machines, split=split)


def files_read(config: Config, inputs: Iterable[str]) -> FilesRead:
    """Every file that a job reads: its inputs, its configuration, the files of its machines."""
    return FilesRead(_files_read(config, inputs))


def _files_read(config: Config, inputs: Iterable[str]) -> Iterator[str]:
    from beamcam.machine.load import files_of

    yield from inputs
    yield from config.files
    for name in config.all_machines:
        yield from files_of(name)


def _wanted(options: Mapping[str, Any]) -> dict[str, Any]:
    """The options that were given, by the names of a configuration's values."""
    given = {key: options[name] for name, key in _OPTIONS.items() if options.get(name) is not None}
    if options.get("bar") is not None:
        given["stock_lengths"] = (options["bar"],)
    sheet = {name: options[name] for name in SHEET_OPTIONS if options.get(name) is not None}
    if sheet:
        given["sheet"] = sheet
    if options.get("scheduler") is not None:
        given["dask"] = {"scheduler": options["scheduler"]}
    return given


def machines_for(config: Config, parts: Sequence[Part], output: str) -> Sequence[Machine]:
    """The machines that may make `parts`, as the job wants them, in the order they are tried in.

    `output` is the program's name. Where none is asked for they are those for the kind of stock,
    and of sheets by the suffix of `output`. Raises MachineError, ConfigError and PlanError.
    """
    _agree_on_sheet(config, parts)
    stock = stock_of(parts, bool(config.sheet.unrolled))
    return machines_of_stock(config, stock, output, flats=stock == "sheet" and are_flats(parts))


def _agree_on_sheet(config: Config, parts: Sequence[Part]) -> None:
    """Raises PlanError where the command line says another thickness or material than a part."""
    diagnostics: list[Diagnostic] = []
    thickness, material = config.sheet.thickness, config.sheet.material
    if thickness is not None and config.sources.get("sheet.thickness") == COMMAND_LINE:
        diagnostics += _other_thicknesses(thickness, parts)
    if material is not None and config.sources.get("sheet.material") == COMMAND_LINE:
        diagnostics += _other_materials(material, parts)
    if diagnostics:
        raise PlanError(tuple(diagnostics))


def with_thickness(reading: Reading, config: Config) -> Reading:
    """A reading whose sheets have the job's thickness where their file says none.

    Where the command line says another than the file that is an error, as it is to `post`.
    """
    thickness = config.sheet.thickness
    if thickness is None:
        return reading
    sheets = [part for part in reading.parts if part.profile.code == "B"]
    diagnostics: tuple[Diagnostic, ...] = ()
    if config.sources.get("sheet.thickness") == COMMAND_LINE:
        diagnostics = tuple(_other_thicknesses(thickness, sheets))
    parts = tuple(
        replace(part, profile=replace(part.profile, web_thickness=thickness))
        if part in sheets and part.profile.web_thickness is None
        else part
        for part in reading.parts
    )
    return replace(reading, parts=parts, diagnostics=(*reading.diagnostics, *diagnostics))


def _other_thicknesses(thickness: float, parts: Sequence[Part]) -> Iterator[Diagnostic]:
    from beamcam.planning.contours.rules import OTHER_THICKNESS

    for part in parts:
        own = part.profile.web_thickness
        if own is not None and abs(own - thickness) > SAME_THICKNESS:
            yield OTHER_THICKNESS.at(part.source, found=f"{thickness:g}", expected=f"{own:g}")


def _other_materials(material: str, parts: Sequence[Part]) -> Iterator[Diagnostic]:
    from beamcam.planning.contours.plate import is_same
    from beamcam.planning.contours.rules import OTHER_MATERIAL

    for part in parts:
        if part.grade and not is_same(material, part.grade):
            yield OTHER_MATERIAL.at(part.source, found=material, expected=part.grade)


def map_remarks(config: Config, parts: Sequence[Part], machine: Machine) -> tuple[Diagnostic, ...]:
    """A note for each key of a configured map that no curve of the parts has.

    Raises PlanError for a key of the command line that matches nothing: it was meant for these
    very parts.
    """
    if not config.map or machine.torch is None:
        return ()
    from beamcam.planning.left_out import curves_by_key, idle, unmatched

    asked = {key for key, source in config.sources.items() if source == COMMAND_LINE}
    here = {k: v for k, v in config.meanings.items() if f"map.{k}" in asked}
    table = machine.torch.colours
    if refused := tuple(unmatched(here, parts, table)):
        raise PlanError(refused)
    configured = [key for key in config.map if key not in here]
    used = curves_by_key(parts, table) if configured else ()
    return tuple(idle(configured, used, config.place("map")))


def machine_for_program(
    config: Config, program: str, data: bytes | str = b"", parts: Sequence[Part] = ()
) -> Machine:
    """The machine that a program is for: the one that its head names, as the job wants it.

    Where machines are named by the command line or the configuration it is one of them. A program
    whose head names none of them is for the first that its `parts`, or else its name, allow.
    `data` is what stands in it, where that is known.
    """
    if parts:
        allowed = machines_for(config, parts, program)
    else:
        allowed = machines_of_stock(config, "sheet" if is_of_sheets(program) else "beam", program)
    from beamcam.machine.load import is_file_name

    named = _machine_in_head(data)
    if named is None:
        return allowed[0]
    chosen = config.all_machines
    # A head names machines that are known here, never a file.
    more = chosen or ([] if is_file_name(named) else [named])
    if (known := next((one for one in allowed if one.name == named), None)) is not None:
        return known
    for name in more:
        other = machine_asked(name, config)
        if other is not None and other.name == named:
            return _told(name, other, config)
    return allowed[0]


def _machine_in_head(data: bytes | str) -> str | None:
    """The machine that the head of a program names."""
    from beamcam.checks.job import head_of

    head = head_of(data.decode("utf-8", "replace") if isinstance(data, bytes) else data)
    return None if head is None else head.machine


def machines_of_stock(
    config: Config, stock: Stock, output: str, is_one_of_two: bool = False, flats: bool = False
) -> Sequence[Machine]:
    """The machines for a kind of stock, as `machines_for`.

    `is_one_of_two` says that there are some for the other kind, which may be who can do what the
    command line asks for, and `flats` that the sheets are flats.
    """
    names = config.machine_names(stock)
    if not names:
        is_one_of_two = is_one_of_two or flats
        return InTurn(
            default_machines(stock, output, flats),
            lambda name: _told(name, _as_asked(load_tested(name), config, is_one_of_two), config),
        )
    machines = [_named_machine(config, stock, name) for name in names]
    return tuple(
        _told(name, _as_asked(machine, config, is_one_of_two), config)
        for name, machine in zip(names, machines, strict=True)
    )


def machines_of_split(config: Config) -> tuple[Machine, ...]:
    """The machines that make parts one after the other, as the job wants them; none if not named.

    What the command line asks of sheets is asked of those that cut sheets, if there is one. Raises
    MachineError, ConfigError and PlanError.
    """
    machines = [_named_machine(config, "split", name) for name in config.split]
    cuts_sheets = any(machine.torch is not None for machine in machines)
    return tuple(
        _told(name, _as_asked(machine, config, cuts_sheets), config)
        for name, machine in zip(config.split, machines, strict=True)
    )


def check_split(config: Config, options: Mapping[str, Any]) -> None:
    """Raises UsageError for what excludes that several machines make a part."""
    excluded = (
        ("--machine", options.get("machine"), "one of the two"),
        ("a quantity", config.quantity, "programs of one piece, each run as often as needed"),
        ("--turn", options.get("turn"), "parts as they were read"),
        ("--no-verify", options.get("no_verify"), "programs that are read back"),
    )
    for option, value, expected in excluded:
        if value:
            raise click.UsageError(f"found {option} with --machines; expected {expected}.")


def _told(name: str, machine: Machine, config: Config) -> Machine:
    """The machine; --verbose says whose file it is, and an untrusted one is always reported."""
    console = running_console()
    if console is not None and (console.verbose or name.endswith(".toml")):
        from beamcam.commands.configuration import settings_line, strange

        console.remark(strange(name))
        if console.verbose:
            console.did_once(settings_line(config, [name]))
    return machine


def machine_asked(name: str, config: Config) -> Machine | None:
    """A machine as the job wants it; None where there is none, or it cannot do what is asked."""

    try:
        return _as_asked(load_tested(name), config, is_one_of_two=False)
    except BeamcamError:
        return None


def _as_asked(machine: Machine, config: Config, is_one_of_two: bool) -> Machine:
    """A machine with the tolerances, the map and the sheet of the job."""
    remark(machine.remarks)
    if config.tolerances.given():
        from beamcam.config.load import with_tolerances

        machine = with_tolerances(machine, config)
    if config.corner or config.lip:
        from beamcam.machine.overlay import with_section

        machine = with_section(machine, config.corner, config.lip)
    if not (config.sheet.given() or config.map) or (machine.torch is None and is_one_of_two):
        return machine
    return _with_sheet(machine, config)


def _named_machine(config: Config, of: Stock | Literal["split"], named: str) -> Machine:
    """A machine that is named for a kind of stock, by the configuration or the command line.

    Or `of` split, for one behind another. Raises MachineError; ConfigError where a configuration
    names one that is not there.
    """
    key = "split" if of == "split" else f"machines.{of}" if of in config.machines else "machine"
    try:
        return load_tested(named)
    except MachineError as error:
        source = config.sources.get(key)
        if source in (None, COMMAND_LINE) or error.diagnostics[0].code != UNKNOWN_MACHINE.code:
            raise
        from beamcam.config import WRONG_VALUE
        from beamcam.config.load import ConfigError

        expected = error.diagnostics[0]["expected"]
        raise ConfigError(
            WRONG_VALUE.at(source, key=key, found=repr(named), expected=expected)
        ) from error


def _with_sheet(machine: Machine, config: Config) -> Machine:
    """The machine as the map and the table `[sheet]` want it.

    One configuration serves all kinds of machines, so that only what the command line asks for is
    asked of one without a torch.
    """
    is_given = COMMAND_LINE in (
        config.sources.get(f"{table}.{name}")
        for table in ("sheet", "map")
        for name in config.rows(table)
    )
    if machine.torch is None and not is_given:
        return machine
    from beamcam.machine.overlay import with_torch
    from beamcam.planning.contours import rules

    try:
        return with_torch(
            machine, config.meanings, settings=config.layer_settings, **config.sheet.given()
        )
    except ValueError as error:
        sources = (config.sources.get(f"sheet.{name}") for name in config.sheet.given())
        lines = (source for source in sources if source not in (None, COMMAND_LINE))
        place = next(lines, None) or Source(machine.name)
        raise PlanError(rules.OPTION.at(place, found=error)) from error
