"""Machine files: found by name or path, laid over their bases, checked, and explained."""

import os
from collections.abc import Sequence
from os.path import isfile
from pathlib import Path, PurePath
from typing import Any
from unicodedata import normalize
from zlib import crc32

from msgspec import json, structs

from beamcam.caches import cached
from beamcam.conversion import Fault, converted, nearest, shown
from beamcam.errors import Diagnostic, MachineError, Source
from beamcam.machine import toml
from beamcam.machine import words as rules
from beamcam.machine.machine import Machine, MachineFile
from beamcam.machine.proved import PROVED
from beamcam.machine.stations import as_formula
from beamcam.machine.toml import TomlFile, TomlPlace, line_of
from beamcam.system import beginning_of, portable_path, user_folder

MAX_BASES = 8  #: machine files laid over each other
#: Keys that say how a file is found, and nothing of the machine.
_NOT_INHERITED = ("name", "default_for", "choice")
_BY_AXES = ("bodies", "modbus")  #: keys of a base that follow from its axes
_NOT_OF_PROGRAMS = (*_NOT_INHERITED, *_BY_AXES)  #: keys that no program depends on
SHIPPED = Path(__file__).resolve().parent.parent / "machines"


def shipped() -> tuple[str, ...]:
    """Names of the machines that come with beamcam."""
    return tuple(sorted(p.stem for p in SHIPPED.iterdir() if p.suffix == ".toml"))


def load(name: str) -> Machine:
    """The machine called `name`, or the one in the file at that path. Raises MachineError."""
    return _checked(files_of_machine(name))


def is_proved(files: tuple[TomlFile, ...]) -> bool:
    """Whether a machine's files are those shipped, letter by letter: the tests prove those."""
    texts = "".join(file.text for file in files)
    return PROVED.get(files[0].path.stem) == f"{crc32(texts.encode()):08x}"


def files_of(name: str) -> tuple[str, ...]:
    """The paths of the file of a machine and of all that it is based on. Raises MachineError."""
    return tuple(str(file.path) for file in files_of_machine(name))


def source_in(name: str, key: str, text: str) -> Source:
    """Where a machine's file or one of its bases sets a key; the line of a text in its value.

    Of a key that a shipped base sets it is the file over it, without which there is no fault.
    """
    files = files_of_machine(name)
    _, places = merged(files)
    source = TomlPlace(places).child(key).source
    if _is_of_shipped_base(source, files):
        return Source(files[0].shown, line_of(files[0].text, key))
    whole = places.get(key, places[""])[1]
    first = source.line or 1
    for number, line in enumerate(whole.split("\n")[first - 1 :], first):
        if text and text in line:
            return Source(source.file, number)
    return source


@cached("files.machine")
def _checked(files: tuple[TomlFile, ...]) -> Machine:
    """The machine described by a file and its bases. Raises MachineError."""
    try:
        return _described(files)
    except MachineError as error:
        faults = [
            structs.replace(fault, source=_cause(files))
            if _is_of_shipped_base(fault.source, files) else fault
            for fault in error.diagnostics
        ]  # fmt: skip
        raise MachineError(tuple(faults)) from None


def _cause(files: tuple[TomlFile, ...]) -> Source:
    """Where a machine's own file brings a fault about that stands in a shipped one.

    That is the first of its keys without which there is no fault; else the whole file.
    """
    own = files[0]
    for words in toml.keys_of(_present(own)[0]):
        try:
            _described(files, words)
        except MachineError:
            continue
        return Source(own.shown, line_of(own.text, ".".join(words)))
    return Source(own.shown)


def _is_of_shipped_base(source: Source, files: tuple[TomlFile, ...]) -> bool:
    """Whether a place is in a shipped file that the machine's own is laid over."""
    shipped_bases = {file.shown for file in files[1:] if file.path.parent == SHIPPED}
    return files[0].path.parent != SHIPPED and source.file in shipped_bases


def _described(files: tuple[TomlFile, ...], but: Sequence[str] = ()) -> Machine:
    """The machine of `_checked`, its faults where the values stand; without a key of its file."""
    renamed = [(file, key, present) for file in files for key, present in _present(file)[1]]
    remarks = tuple(
        rules.FORMER_KEY.at(Source(f.shown, line_of(f.text, key)), found=key, expected=present)
        for f, key, present in renamed
    )
    table, places = merged(files, but)
    place = TomlPlace(places)
    name = table["name"]
    # The head of a program and every message would name a machine that did not make it.
    plain = normalize("NFKC", name).strip().casefold() if isinstance(name, str) else ""
    if files[0].path.parent != SHIPPED and plain in shipped():
        raise MachineError(rules.NAME_TWICE.at(place.child("name").source, found=name))
    try:
        read = converted(table, MachineFile, as_formula)
    except Fault as fault:
        raise MachineError(_diagnostic(fault, place)) from None
    # That changes with any value that programs depend on, even under the same name; no protection
    # against forgery.
    values = {key: value for key, value in table.items() if key not in _NOT_OF_PROGRAMS}
    checksum = f"{crc32(json.encode(values, order='deterministic')):08x}"
    machine = Machine(**structs.asdict(read), checksum=checksum, remarks=remarks)
    if not is_proved(files):
        from beamcam.machine.references import check_keys

        first = {
            key: next((k for k, file in enumerate(files) if key in file.table), len(files))
            for key in ("spindles", "saw", "axes")
        }
        check_keys(machine, place, frozenset(key for key in first if first[key] < first["axes"]))
    return machine


def _present(file: TomlFile) -> tuple[dict[str, Any], list[tuple[str, str]]]:
    """A file's table as this version names its keys, and its renamed keys. Raises MachineError."""
    try:
        return toml.with_present_keys(file.table)
    except toml.KeyTwice as twice:
        source = Source(file.shown, line_of(file.text, twice.former))
        diagnostic = rules.KEY_TWICE.at(source, found=twice.former, expected=twice.present)
        raise MachineError(diagnostic) from None


def _diagnostic(fault: Fault, place: TomlPlace) -> Diagnostic:
    """The message for an invalid key of a machine file."""
    at = place.child(*fault.path)
    if fault.kind == "unknown":
        return rules.UNKNOWN_KEY.at(at.source, found=at.key, expected=fault.expected)
    if fault.kind == "missing":
        return rules.MISSING_KEY.at(at.source, expected=at.key)
    found = shown(fault.found)
    return rules.WRONG_VALUE.at(at.source, key=at.key, found=found, expected=fault.expected)


def files_of_machine(name: str) -> tuple[TomlFile, ...]:
    """The file of a machine and those that it is based on, the last one first said."""
    files: list[TomlFile] = []
    while True:
        path = _find(name, files[-1] if files else None)
        if any(path == file.path for file in files):
            raise MachineError(rules.BASE_LOOP.at(Source(str(files[0].path)), found=path.stem))
        shown = path.name if path.parent == SHIPPED else str(path)
        try:
            file = TomlFile(
                path, shown, toml.toml_text(beginning_of(path, toml.MAX_TOML_BYTES + 1))
            )
            base = file.table.get("base")
        except toml.TomlError as error:
            raise MachineError(rules.NOT_TOML.at(Source(shown, error.line), found=error)) from error
        except OSError as error:
            expected = error.strerror or "a file that can be read"
            diagnostic = rules.UNKNOWN_MACHINE.at(Source(shown), found=name, expected=expected)
            raise MachineError(diagnostic) from error
        files.append(file)
        if base is None:
            return tuple(files)
        if not isinstance(base, str):
            raise MachineError(_wrong_base(file, "a machine's name"))
        if len(files) > MAX_BASES:
            raise MachineError(_wrong_base(file, f"{MAX_BASES} files below each other at most"))
        name = base


def _wrong_base(file: TomlFile, expected: str) -> Diagnostic:
    source, found = Source(file.shown, line_of(file.text, "base")), repr(file.table["base"])
    return rules.WRONG_VALUE.at(source, key="base", found=found, expected=expected)


def merged(
    files: tuple[TomlFile, ...], but: Sequence[str] = ()
) -> tuple[dict[str, Any], dict[str, tuple[str, str]]]:
    """The merged table of a machine, and for each of its keys the file that sets it.

    `but` has the words of a key of the first file that is left out.
    """
    table: dict[str, Any] = {}
    places: dict[str, tuple[str, str]] = {}
    for file in reversed(files):
        own = {"name": file.path.stem, **_present(file)[0]}
        own.pop("base", None)
        if but and file is files[0] and but[0] in own:
            own = toml.without(own, but)
        if file is not files[0]:
            own = {k: v for k, v in own.items() if k not in ("default_for", "choice")}
        if "axes" in own:
            for key in _BY_AXES:
                table.pop(key, None)
        origin = file.shown, file.text
        _overlay(table, own, places, origin, "")
        places[""] = origin
    return toml.with_more_rows(table), places


def _overlay(
    table: dict[str, Any], over: dict[str, Any], files: dict[str, tuple[str, str]],
    origin: tuple[str, str], prefix: str,
) -> None:  # fmt: skip
    """Lay `over` over `table` in place: tables key by key, everything else as a whole.

    False in the place of a table takes it away: `saw = false`.
    """
    for key, value in over.items():
        dotted = f"{prefix}{key}"
        if value is False and isinstance(table.get(key), dict):
            del table[key]
        elif dotted == "torch.more_rows" and isinstance(value, list):
            # Those of a base are added too, unless the file has rows of its own.
            kept = [] if "rows" in over else table.get(key, [])
            table[key] = [*kept, *value] if isinstance(kept, list) else value
        elif isinstance(value, dict) and isinstance(table.get(key, {}), dict):
            _overlay(table.setdefault(key, {}), value, files, origin, dotted + ".")
        else:
            table[key] = value
        files[dotted] = origin
    if prefix == "torch." and "rows" in over and "more_rows" not in over:
        table.pop("more_rows", None)


def _find(name: str, over: TomlFile | None) -> Path:
    """The file of a machine: a shipped name, or a path (of a base: beside the file it is in)."""
    below = None if over is None else over.path
    if name.endswith(".toml"):
        name = portable_path(name) if below is None else name.replace("\\", "/")
        path = Path(name) if below is None else below.parent / name
        if isfile(path):
            return path.resolve()
    elif PurePath(name).name == name and isfile(SHIPPED / f"{name}.toml"):
        return SHIPPED / f"{name}.toml"
    elif below is not None and isfile(beside := below.parent / f"{name}.toml"):
        return beside.resolve()  # one's own, laid over another one's own
    expected = f"{nearest(name, shipped())} or the path of a .toml file"
    source = Source(name) if over is None else Source(over.shown, line_of(over.text, "base"))
    raise MachineError(rules.UNKNOWN_MACHINE.at(source, found=name, expected=expected))


# --- machines of one's own ------------------------------------------------------------------------

# They are known by name: the files in folders that are called `machines`.
#
# machines/ beside the configuration   before   machines/ in this folder   before   the user's own


FOLDER = "machines"


def machine_folders(configurations: Sequence[str]) -> tuple[str, ...]:
    """Folders searched for the user's machines, the nearest first; they need not exist.

    `configurations` are those that are one's own, the nearest first. A link to one of them does not
    bring the machines that lie beside the link.
    """
    files = (os.path.realpath(path) if os.path.islink(path) else path for path in configurations)
    beside = (os.path.join(os.path.dirname(path), FOLDER) for path in files)
    last = os.path.join(user_folder(), FOLDER)
    return (*dict.fromkeys(f for f in (*beside, FOLDER) if f != last), last)


def own_machines(configurations: Sequence[str]) -> dict[str, str]:
    """Name -> path of each machine of one's own; of two with one name the nearest."""
    files: dict[str, str] = {}
    for folder in machine_folders(configurations):
        for entry in sorted(os.listdir(folder)) if os.path.isdir(folder) else ():
            name, suffix = os.path.splitext(entry)
            if suffix == ".toml":
                files.setdefault(name, os.path.join(folder, entry))
    return dict(sorted(files.items()))


def is_file_name(name: str) -> bool:
    """Whether a machine that is called so is meant as a file, not as one that is known."""
    return name.endswith(".toml") or os.path.basename(name) != name


def resolved(name: str, configurations: Sequence[str]) -> str:
    """The path of a machine of one's own that is called so; the name as it is of any other.

    Raises MachineError where a shipped machine has the name too.
    """
    if is_file_name(name):
        return name
    for folder in machine_folders(configurations):
        path = os.path.join(folder, f"{name}.toml")
        if os.path.isfile(path):
            if (SHIPPED / f"{name}.toml").is_file():
                raise MachineError(rules.NAME_TWICE.at(Source(path), found=name))
            return path
    return name
