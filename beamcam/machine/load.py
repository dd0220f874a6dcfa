"""Machine files: found by name or path, laid over their bases, checked, and explained."""

import re
from collections.abc import Iterator
from pathlib import Path
from string import Formatter
from typing import Any, cast
from zlib import crc32

from msgspec import Struct, json
from msgspec.structs import replace

from beamcam.caches import cached
from beamcam.errors import MachineError, Source
from beamcam.machine import rules
from beamcam.machine.faults import axis_faults, pair_faults, tool_faults, torch_faults
from beamcam.machine.machine import Machine
from beamcam.machine.schema import Place, build, nearest
from beamcam.machine.toml import TomlError, TomlFile, toml_text
from beamcam.machine.words import WORD_NAMES

SHIPPED = Path(__file__).resolve().parent.parent / "machines"


class Setting(Struct, frozen=True):
    """One value of a machine and the place that it comes from."""

    key: str  #: dotted
    value: object
    source: Source | None  #: None for a default


def shipped() -> tuple[str, ...]:
    """Names of the machines that come with beamcam."""
    return tuple(sorted(p.stem for p in SHIPPED.glob("*.toml")))


def load(name: str) -> Machine:
    """The machine called `name`, or the one in the file at that path. Raises MachineError."""
    return _machine(_files(name))


def files_of(name: str) -> tuple[str, ...]:
    """The paths of the file of a machine and of all that it is based on. Raises MachineError."""
    return tuple(str(file.path) for file in _files(name))


@cached("files.machine")
def _machine(files: tuple[TomlFile, ...]) -> Machine:
    """The machine that is told by a file and its bases."""
    table, places = _merged(files)
    place = Place(places)
    machine: Machine = build(Machine, table, place)
    _check(machine, place)
    return replace(machine, checksum=_checksum(table))


def _checksum(table: dict[str, Any]) -> str:
    """Eight hex digits that change with any value of a machine's file, or of those it is based on.

    They tell that a machine has changed since, whatever it is called; against a forger they would
    be of no use.
    """
    values = {key: value for key, value in table.items() if key != "name"}
    return f"{crc32(json.encode(values, order='deterministic')):08x}"


def settings(name: str) -> tuple[Setting, ...]:
    """Every value of a machine, the defaults included, each with where it was set."""
    files = _files(name)
    table, places = _merged(files)
    place = Place(places)
    return tuple(
        Setting(key, value, place.child(key).source if _is_set(table, key) else None)
        for key, value in _leaves(_machine(files))
    )


def _is_set(table: Any, key: str) -> bool:
    """Whether a dotted key stands in the table, and not only in the defaults."""
    for word in key.split("."):
        if isinstance(table, list):
            table = table[int(word)]
        elif isinstance(table, dict) and word in table:
            table = table[word]
        else:
            return False
    return True


def _leaves(record: Any, key: str = "") -> Iterator[tuple[str, object]]:
    """Dotted key and value of every plain value in a record."""
    if hasattr(record, "text"):  # a Formula is one value
        yield key, record.text
    elif isinstance(record, Struct):
        for name in record.__struct_fields__:
            yield from _leaves(getattr(record, name), f"{key}.{name}" if key else name)
    elif isinstance(record, dict):
        for name, value in record.items():
            yield from _leaves(value, f"{key}.{name}")
    elif isinstance(record, tuple) and record and not isinstance(record[0], str | float | int):
        for index, value in enumerate(record):
            yield from _leaves(value, f"{key}.{index}")
    elif record is not None:
        yield key, list(record) if isinstance(record, tuple) else record


def _files(name: str) -> tuple[TomlFile, ...]:
    """The file of a machine and those that it is based on, the last one first said."""
    found: list[TomlFile] = []
    while True:
        path = _find(name, found[-1].path if found else None)
        if any(path == file.path for file in found):
            raise MachineError(rules.BASE_LOOP.at(Source(str(found[0].path)), found=path.stem))
        shown = path.name if path.parent == SHIPPED else str(path)
        try:
            file = TomlFile(path, shown, toml_text(path.read_bytes()))
            base = file.table.get("base")
        except TomlError as error:
            raise MachineError(rules.NOT_TOML.at(Source(shown), found=error)) from error
        except OSError as error:
            expected = error.strerror or "a file that can be read"
            said = rules.UNKNOWN_MACHINE.at(Source(shown), found=name, expected=expected)
            raise MachineError(said) from error
        found.append(file)
        if base is None:
            return tuple(found)
        if not isinstance(base, str):
            said = rules.WRONG_VALUE.at(
                Source(shown), key="base", found=repr(base), expected="a machine's name"
            )
            raise MachineError(said)
        name = base


def _merged(
    files: tuple[TomlFile, ...],
) -> tuple[dict[str, Any], dict[str, tuple[str, str]]]:
    """The merged table of a machine, and for each of its keys the file that sets it."""
    table: dict[str, Any] = {}
    places: dict[str, tuple[str, str]] = {}
    for file in reversed(files):
        own = {"name": file.path.stem, **file.table}
        own.pop("base", None)
        origin = file.shown, file.text
        _overlay(table, own, places, origin, "")
        places[""] = origin
    return table, places


def _overlay(
    table: dict[str, Any],
    over: dict[str, Any],
    files: dict[str, tuple[str, str]],
    origin: tuple[str, str],
    prefix: str,
) -> None:
    """Lay `over` over `table` in place: tables key by key, everything else as a whole."""
    for key, value in over.items():
        dotted = f"{prefix}{key}"
        if isinstance(value, dict) and isinstance(table.get(key, {}), dict):
            _overlay(table.setdefault(key, {}), value, files, origin, dotted + ".")
        else:
            table[key] = value
        files[dotted] = origin


def _find(name: str, below: Path | None) -> Path:
    """The file of a machine: a shipped name, or a path (of a base: beside the file it is in)."""
    if name.endswith(".toml"):
        path = Path(name) if below is None else below.parent / name
        if path.is_file():
            return path.resolve()
    elif (SHIPPED / f"{name}.toml").is_file() and "/" not in name:
        return SHIPPED / f"{name}.toml"
    expected = f"{nearest(name, shipped())} or the path of a .toml file"
    raise MachineError(
        rules.UNKNOWN_MACHINE.at(Source(str(below or name)), found=name, expected=expected)
    )


def _check(machine: Machine, place: Place) -> None:
    """Raise MachineError for what no field can tell by itself."""

    def wrong(key: str, found: object, expected: str) -> MachineError:
        return MachineError(
            rules.WRONG_VALUE.at(
                place.child(key).source, key=key, found=repr(found), expected=expected
            )
        )

    for key, names in WORD_NAMES.items():
        template = getattr(machine.words, key)
        for line in (template,) if isinstance(template, str) else template:
            try:
                parsed = tuple(Formatter().parse(line))
            except ValueError as error:
                raise wrong(f"words.{key}", line, f"a template: {error}") from error
            for _, name, how, _ in parsed:
                if name is None:
                    continue
                if name not in names:
                    raise wrong(f"words.{key}", "{" + name + "}", nearest(name, names))
                if not _FIELD_FORM.fullmatch(how or ""):
                    raise wrong(f"words.{key}", how, "a width of two digits, such as :>8")
    faces = {s.face for s in machine.spindles}
    for index, pair in enumerate(machine.pairs):
        if not faces.issuperset(pair.faces):
            raise wrong(f"pairs.{index}.faces", list(pair.faces), "faces that have a spindle")
    for index, spindle in enumerate(machine.spindles):
        if spindle.across.axis == spindle.stroke.axis:
            raise wrong(f"spindles.{index}.stroke.axis", spindle.stroke.axis, "another axis")
        if machine.drill is None:
            raise wrong(f"spindles.{index}", spindle.name, "a [drill] table for it")
    for key, value in _leaves(machine):
        if key.endswith(_POSITIVE) and isinstance(value, float) and value <= 0:
            raise wrong(key, value, "more than 0")
        if key.endswith(_NOT_NEGATIVE) and isinstance(value, float) and value < 0:
            raise wrong(key, value, "0 or more")
        if key.endswith("_decimals") and not 0 <= cast(int, value) <= MAX_DECIMALS:
            raise wrong(key, value, f"0 to {MAX_DECIMALS}")
    for key, found, expected in (
        *tool_faults(machine),
        *pair_faults(machine),
        *axis_faults(machine),
        *torch_faults(machine),
    ):
        raise wrong(key, found, expected)
    if machine.stock == "beam" and machine.layout is None:
        raise MachineError(rules.MISSING_KEY.at(place.source, expected="layout"))
    if machine.stock == "sheet" and machine.torch is None:
        raise MachineError(rules.MISSING_KEY.at(place.source, expected="torch"))


#: No machine resolves a nanometre; the texts of all decimals are kept, of more they would not fit.
MAX_DECIMALS = 6
#: How a value may be set in a template; a greater width would fill the memory with blanks.
_FIELD_FORM = re.compile(r"[^{}]?[<>^]?[0-9]{0,2}")
_POSITIVE = ("up_to", "speed_m_min", "feed_per_turn", "_mm_min", "_rpm", "point_deg",
             "greatest_height", "greatest_width", "torch.length", "torch.width", "torch.tolerance",
             "torch.thickness", "torch.gap", "torch.tab_width", "_radius", "arc_limit")  # fmt: skip
_NOT_NEGATIVE = ("kerf", "tolerance", "clearance", "breakthrough", "_trim", "least_bar",
                 "plus", "minus", "dead_zone", "least_part", "least_remnant", "twin",
                 "runout_pitches", "_depth", "_s", "torch.margin",
                 "torch.lead_in", "torch.lead_out", "least_hole", "torch.cross",
                 "power")  # fmt: skip
