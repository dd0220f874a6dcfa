"""A configuration file as the commands take it: read, and its words checked against what they know.

Apart from `settings`, so that a job without such a file pays nothing for it.
"""

import os
import os.path
from collections.abc import Callable, Iterable, Sequence
from hashlib import sha256
from typing import Any

from msgspec.structs import replace

from beamcam.arguments import expected_job
from beamcam.commands import MACHINE_ELSEWHERE
from beamcam.config import NOT_REPEATED, TWO, WRONG_VALUE
from beamcam.config.load import (
    ConfigError,
    harmless,
    is_in,
    is_ones_own_place,
    load,
    merged,
    not_followed,
)
from beamcam.config.values import CONFIG_NAME, Config, ConfigFiles
from beamcam.errors import Diagnostic, Source
from beamcam.machine.load import SHIPPED, files_of_machine
from beamcam.machine.machine import Machine
from beamcam.model.plan import ALL_SKIPS, SKIP_NAMES, named_skips
from beamcam.system import user_folder


def checked(files: ConfigFiles, trust: Sequence[str] = ()) -> Config:
    """The configuration that the files are together; `trust` are folders that are one's own too.

    Raises ConfigError.
    """
    if files.two:
        raise ConfigError(TWO.at(Source(files.two[1]), found=files.two[0]))
    config = Config()
    for path in reversed(files.own):
        config = merged(config, _loaded(path))
    trusted = (*trust, *config.trust)
    for path in reversed(files.beside):
        near = _loaded(path)
        config = merged(config, near if is_in(path, trusted) else harmless(near))
    return config


def checked_again(files: ConfigFiles, trust: Sequence[str]) -> Config:
    """The configuration of a batch by the files that its record names.

    Raises ConfigError if a file that it followed in full is not trusted.
    """
    for path in files.own:
        if not_followed(_loaded(path)):
            refuse_strange(path, trust)
    return checked(files)


def refuse_strange(path: str, trust: Sequence[str]) -> None:
    """Raises ConfigError for a file that a record names and that is not trusted."""
    if not (is_ones_own_place(path) or is_in(path, trust)):
        folder = os.path.dirname(path) or os.curdir
        raise ConfigError(NOT_REPEATED.at(Source(path), found=path, folder=folder))


def _loaded(path: str) -> Config:
    """The configuration in a file, its words checked. Raises ConfigError."""
    config = load(path)
    for key, check in _CHECKS.items():
        value = getattr(config, key)
        if value and (expected := check(value)):
            found = repr(value) if isinstance(value, str) else ", ".join(map(repr, value))
            diagnostic = WRONG_VALUE.at(
                config.sources[key], key=key, found=found, expected=expected
            )
            raise ConfigError(diagnostic)
    return replace(config, allow_skips=named_skips(config.allow_skips))


def _expected_name(template: str) -> str:
    """The expected form of an invalid name template; "" if it is valid."""
    from beamcam.batch.names import template_fault

    fault = template_fault(template)
    return "" if fault is None else fault[1]


def _expected_skips(skips: Sequence[str]) -> str:
    known = (*SKIP_NAMES, ALL_SKIPS)
    return "" if set(skips) <= set(known) else f"names of {', '.join(known)}"


_CHECKS: dict[str, Callable[[Any], str]] = {
    "name": _expected_name,
    "job": expected_job,
    "allow_skips": _expected_skips,
}


# --- provenance: whose configuration a run uses, and which machine file, with its checksum --------

DIGITS = 12  #: of a checksum, as its first ones are compared by eye


def settings_line(config: Config, machines: Iterable[str]) -> str:
    """The configuration and the machines of a run in one line.

    `machines` are names of shipped machines, and paths of files. Raises MachineError.
    """
    made_on = "; ".join(f"machine {machine_line(name)}" for name in dict.fromkeys(machines))
    return f"configuration {configuration_line(config)}; {made_on}"


def used(config: Config, machine: Machine) -> str:
    """The same of a job that is settled. Raises MachineError."""
    return settings_line(config, [reference(machine, config)])


def configuration_line(config: Config) -> str:
    """The files of a configuration, the nearest first, and whose they are."""
    shown = []
    for path in config.files:
        whose = "here or above" if os.path.basename(path) == CONFIG_NAME else "named"
        if is_in(path, [user_folder()]):
            whose = "the user's"
        elif path not in config.own:
            whose = "beside the inputs, harmless keys only"
        shown.append(f"{path} ({whose})")
    return ", ".join(shown) or "none"


def machine_line(name: str) -> str:
    """A machine's name, its file and those it is laid over. Raises MachineError."""
    files = files_of_machine(name)
    called = files[0].table.get("name", files[0].path.stem)
    shown = (
        f"{file.shown}{' as shipped' if file.path.parent == SHIPPED else ''}, sha256 "
        f"{sha256(file.text.encode()).hexdigest()[:DIGITS]}"
        for file in files
    )
    return f"{called} ({' over '.join(shown)})"


def reference(machine: Machine, config: Config) -> str:
    """What `machine_line` takes for a machine of a job: its path, or its name if it is shipped."""
    named = config.all_machines
    paths = {name: files_of_machine(name)[0] for name in named if name.endswith(".toml")}
    for name, file in paths.items():
        if file.table.get("name", file.path.stem) == machine.name:
            return name
    return machine.name


def strange(name: str) -> tuple[Diagnostic, ...]:
    """The note on a machine whose file is neither shipped nor the user's own."""
    if not name.endswith(".toml") or is_in(name, [user_folder()]):
        return ()
    return (MACHINE_ELSEWHERE.at(Source(name), found=machine_line(name)),)
