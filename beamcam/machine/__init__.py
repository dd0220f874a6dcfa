"""Machines: TOML in, `Machine` out. All that differs from machine to machine is data here.

Machines of one's own are known by name: the files in folders that are called `machines`.

machines/ beside the configuration   before   machines/ in this folder   before   the user's own
"""

import os
from collections.abc import Iterator, Mapping, Sequence
from pathlib import PurePath
from typing import Literal

from beamcam.errors import MachineError, Source
from beamcam.machine.load import SHIPPED, load, settings, shipped
from beamcam.machine.machine import Machine
from beamcam.machine.words import NAME_TWICE
from beamcam.system import user_folder

__all__ = ["Machine", "load", "settings", "shipped"]

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
        for path in _files(folder):
            files.setdefault(os.path.splitext(os.path.basename(path))[0], path)
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
                raise MachineError(NAME_TWICE.at(Source(path), found=name))
            return path
    return name


def _files(folder: str) -> Iterator[str]:
    if os.path.isdir(folder):
        for entry in sorted(os.listdir(folder)):
            if entry.endswith(".toml"):
                yield os.path.join(folder, entry)


# --- defaults -------------------------------------------------------------------------------------

# Which shipped machine is meant where none is named.


Stock = Literal["beam", "sheet", "profile"]

ANY_SUFFIX = "*"

#: Stock and suffix of the output -> machines in the order in which they are tried, from the keys
#: `default_for` and `choice` of the shipped files. It stands here since reading all of them takes
#: longer than posting a small part; a test compares.
DEFAULTS: Mapping[tuple[Stock, str], tuple[str, ...]] = {
    ("beam", "*"): ("beamline", "beamline-pusher"),
    ("beam", ".gcode"): ("beamline", "beamline-pusher"),
    ("sheet", "*"): ("plate-linuxcnc", "plate-codesys", "plate-oxyfuel"),
    ("sheet", ".bin"): ("laser-stepper",), ("sheet", ".csv"): ("laser-stepper",),
    ("sheet", ".gcode"): ("plate-codesys",), ("sheet", ".h"): ("laser-stepper",),
    ("sheet", ".nc"): ("laser-grbl",), ("sheet", ".ngc"): ("plate-linuxcnc", "plate-oxyfuel"),
    ("sheet", ".st"): ("table-simotion",), ("sheet", ".steps"): ("laser-stepper",),
    ("sheet", ".tap"): ("plate-mach3",),
    ("profile", "*"): ("coper-linuxcnc", "coper-tilt-linuxcnc", "tube-linuxcnc"),
}  # fmt: skip

DEFAULT_MACHINE = DEFAULTS["beam", ANY_SUFFIX][0]


def default_machines(stock: Stock, output: str = "", flats: bool = False) -> tuple[str, ...]:
    """The machines for that stock where none is named, by the name of the output, in order.

    A torch that goes round profiles may make of bars what no line that saws and drills does, and
    such a line `flats` that no table makes.
    """
    found = DEFAULTS.get((stock, PurePath(output).suffix.lower()), DEFAULTS[stock, ANY_SUFFIX])
    if stock == "beam":
        return (*found, *DEFAULTS["profile", ANY_SUFFIX])
    return (*found, *DEFAULTS["beam", ANY_SUFFIX]) if flats else found


def is_of_sheets(program: str) -> bool:
    """Whether programs with that suffix are always of sheets."""
    suffix = PurePath(program).suffix.lower()
    return ("sheet", suffix) in DEFAULTS and ("beam", suffix) not in DEFAULTS
