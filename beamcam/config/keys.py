"""The keys of a configuration: their defaults, and what their values may be.

A check gives the value in the form that the program uses, or raises `Unfit` with what was
expected. A new key is a row of `KEYS`.
"""

from collections.abc import Callable, Mapping
from pathlib import Path
from types import MappingProxyType
from typing import get_args

from msgspec import Struct, field

from beamcam.config.values import Meaning, Stock
from beamcam.model.colour import parse_colour

Check = Callable[[object, Path], object]  #: value and the folder of the file that sets it

#: Key below `[tolerances]` -> field of the machine's drill that it stands for.
TOLERANCES = {
    "merge": "merge_tolerance",
    "duplicate": "duplicate_tolerance",
    "sink": "sink_tolerance",
    "path": "path_tolerance",
    "twin": "twin",
}


class Unfit(ValueError):
    """A value that a key cannot have; the text is what was expected."""


def text(value: object, folder: Path) -> str:
    if not isinstance(value, str) or not value:
        raise Unfit("a text")
    return value


def machine(value: object, folder: Path) -> str:
    """A name, or a path that holds wherever the command is called from."""
    name = text(value, folder)
    return str(folder / name) if name.endswith(".toml") else name


def truth(value: object, folder: Path) -> bool:
    if not isinstance(value, bool):
        raise Unfit("true or false")
    return value


def count(value: object, folder: Path) -> int:
    if not isinstance(value, int) or isinstance(value, bool) or value < 1:
        raise Unfit("a whole number from 1 on")
    return value


def lengths(value: object, folder: Path) -> tuple[float, ...]:
    """Lengths in rising order, each once."""
    if not isinstance(value, list):
        raise Unfit("a list of lengths in mm")
    for length in value:
        if not isinstance(length, int | float) or isinstance(length, bool) or not 0 < length < 1e9:
            raise Unfit("a list of lengths in mm above 0")
    return tuple(sorted({float(length) for length in value}))


def texts(value: object, folder: Path) -> tuple[str, ...]:
    if not isinstance(value, list) or not all(isinstance(word, str) for word in value):
        raise Unfit("a list of texts")
    return tuple(value)


def length(value: object, folder: Path) -> float:
    if not isinstance(value, int | float) or isinstance(value, bool) or not 0 <= value < 1e9:
        raise Unfit("a length in mm, 0 or more")
    return float(value)


def some_length(value: object, folder: Path) -> float:
    if not isinstance(value, int | float) or isinstance(value, bool) or not 0 < value < 1e9:
        raise Unfit("a length in mm above 0")
    return float(value)


def number(value: object, folder: Path) -> int:
    if not isinstance(value, int) or isinstance(value, bool) or value < 0:
        raise Unfit("a whole number from 0 on")
    return value


def one_of(*words: str) -> Check:
    """The check of a value that is one of `words`."""

    def check(value: object, folder: Path) -> str:
        if value not in words:
            raise Unfit("one of " + ", ".join(words))
        return str(value)

    return check


def layer_or_colour(key: str) -> str:
    """A key of the map; one that starts like a colour has to be one. Raises Unfit."""
    if key.startswith(("#", "rgb(", "rgba(")):
        try:
            return parse_colour(key)
        except ValueError as error:
            raise Unfit("a colour such as '#ff0000'") from error
    return key


class Key(Struct, frozen=True):
    """One key: what its value has to be, its default and what it is for."""

    check: Check
    default: object
    help: str


_NO_ROWS: Mapping[str, object] = MappingProxyType({})


class Table(Struct, frozen=True):
    """A key that holds a table: each of its rows is set, and named, by itself."""

    rows: Mapping[str, Check]  #: what each row's value has to be
    help: str
    others: Check | None = None  #: of rows that are called after layers and colours
    default: Mapping[str, object] = field(default_factory=lambda: _NO_ROWS)


#: How a sheet is cut: the names are those of the options of the command line.
SHEET: Mapping[str, Check] = {
    "thickness": some_length,
    "material": text,
    "kerf": length,
    "kerf_by": one_of("none", "offset", "machine"),
    "lead": one_of("none", "line", "arc"),
    "tabs": number,
    "place": one_of("corner", "drawn"),
}

KEYS: Mapping[str, Key | Table] = {
    "machine": Key(machine, None, "machine of --machine: a name or a TOML file"),
    "machines": Table(
        dict.fromkeys(get_args(Stock), machine), "of one kind of stock, before `machine`"
    ),
    "stock_lengths": Key(lengths, (), "bars in store, mm; a bar is the shortest that will do"),
    "allow_skips": Key(texts, (), "kinds of features that may be left out"),
    "strict": Key(truth, False, "whether warnings refuse a part"),
    "job": Key(text, "JOB", "name in a program's first line"),
    "jobs": Key(count, None, "worker processes of a batch; all cores if not given"),
    "name": Key(text, None, "template of a batch's output names"),
    "flat": Key(truth, False, "whether a batch writes all outputs to one folder"),
    "tolerances": Table(dict.fromkeys(TOLERANCES, length), "of drills, over the machine's own, mm"),
    "sheet": Table(SHEET, "how sheets are cut, over the machine's own"),
    "map": Table({}, "what is done with a layer or a colour of a drawing",
                 one_of(*get_args(Meaning))),
}  # fmt: skip
