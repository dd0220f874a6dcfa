"""Whose configuration a run uses, and which machine file, with its checksum."""

import os
from collections.abc import Iterable
from hashlib import sha256

from beamcam.commands.rules import MACHINE_ELSEWHERE
from beamcam.config.places import CONFIG_NAME, is_in
from beamcam.config.values import Config
from beamcam.errors import Diagnostic, Source
from beamcam.machine.load import SHIPPED, files_of_machine
from beamcam.machine.machine import Machine
from beamcam.machine.toml import TomlFile
from beamcam.system import user_folder

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
    shown = [f"{path} ({_whose(path, path in config.own)})" for path in config.files]
    return ", ".join(shown) or "none"


def machine_line(name: str) -> str:
    """A machine's name, its file and those it is laid over. Raises MachineError."""
    files = files_of_machine(name)
    called = files[0].table.get("name", files[0].path.stem)
    return f"{called} ({' over '.join(map(_file, files))})"


def reference(machine: Machine, config: Config) -> str:
    """What `machine_line` takes for a machine of a job: its path, or its name if it is shipped."""
    named = [*config.machine_names("beam"), *config.machine_names("sheet")]
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


def _whose(path: str, own: bool) -> str:
    if is_in(path, [user_folder()]):
        return "the user's"
    if not own:
        return "beside the inputs, harmless keys only"
    return "here or above" if os.path.basename(path) == CONFIG_NAME else "named"


def _file(file: TomlFile) -> str:
    place = f"{file.shown} as shipped" if file.path.parent == SHIPPED else file.shown
    return f"{place}, sha256 {sha256(file.text.encode()).hexdigest()[:DIGITS]}"
