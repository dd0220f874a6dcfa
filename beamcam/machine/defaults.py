"""Which shipped machine is meant where none is named."""

from collections.abc import Mapping
from pathlib import PurePath
from typing import Literal

Stock = Literal["beam", "sheet", "profile"]

ANY_SUFFIX = "*"

#: Stock and suffix of the output -> machines in the order in which they are tried, from the keys
#: `default_for` and `choice` of the shipped files. It stands here since reading all of them takes
#: longer than posting a small part; a test compares.
DEFAULTS: Mapping[tuple[Stock, str], tuple[str, ...]] = {
    ("beam", "*"): ("beamline", "beamline-pusher"),
    ("beam", ".gcode"): ("beamline", "beamline-pusher"),
    ("sheet", "*"): ("plate-linuxcnc", "plate-codesys", "plate-oxyfuel"),
    ("sheet", ".bin"): ("laser-stepper",),
    ("sheet", ".csv"): ("laser-stepper",),
    ("sheet", ".gcode"): ("plate-codesys",),
    ("sheet", ".h"): ("laser-stepper",),
    ("sheet", ".nc"): ("laser-grbl",),
    ("sheet", ".ngc"): ("plate-linuxcnc", "plate-oxyfuel"),
    ("sheet", ".st"): ("table-simotion",),
    ("sheet", ".steps"): ("laser-stepper",),
}

DEFAULT_MACHINE = DEFAULTS["beam", ANY_SUFFIX][0]


def default_machines(stock: Stock, output: str = "") -> tuple[str, ...]:
    """The machines for that stock where none is named, by the name of the output, in order."""
    return DEFAULTS.get((stock, PurePath(output).suffix.lower()), DEFAULTS[stock, ANY_SUFFIX])


def is_of_sheets(program: str) -> bool:
    """Whether programs with that suffix are always of sheets."""
    suffix = PurePath(program).suffix.lower()
    return ("sheet", suffix) in DEFAULTS and ("beam", suffix) not in DEFAULTS


def is_of_programs(name: str) -> bool:
    """Whether a machine writes its programs under that suffix."""
    suffix = PurePath(name).suffix.lower()
    return any(suffix == known for _, known in DEFAULTS)
