"""The record of a batch, beside its outputs: what was made of what, so that it is made once.

`.beamcam-batch.jsonl` has a line for each input that was posted whole. A line is added as soon as
the outputs stand, so that a run that is killed has to be finished, not done again; a
torn line is not used. An output that is missing or changed makes its line void.

    {"recipe":"3f...","of":{"configs":[],"asked":{"machine":"../mine.toml"}}}
    {"key":"a1...","outputs":["M58.gcode"],"row":{...},"recipe":"3f...","input":"../in/M58.nc1",...}

Lines of the first kind say what the run was asked for, so that `check` asks for the same; those of
its inputs name them. Paths are kept from the folder of the outputs, so that they hold where it, its
inputs and its machines lie together on another system. A file that was posted in part has a line
too, under a key that no input has, so that its programs are known.
"""

import errno
import os
import stat
from collections.abc import Iterator, Mapping
from contextlib import suppress
from hashlib import sha256
from typing import Any, BinaryIO

from msgspec import Struct, convert, field

from beamcam.batch.find import Input
from beamcam.batch.names import folded
from beamcam.config.values import Config, ConfigFiles
from beamcam.files import write_whole
from beamcam.planning.manual_list import LIST_SUFFIX, as_csv
from beamcam.reports.run import FileRow, dumped, loaded, names_in
from beamcam.system import BINARY, portable_path

RECORD_NAME = ".beamcam-batch.jsonl"
_TO_ADD = os.O_WRONLY | os.O_APPEND | os.O_CREAT | getattr(os, "O_NOFOLLOW", 0) | BINARY
_HEAD = b'{"key":"'
_KEY = slice(len(_HEAD), len(_HEAD) + 64)
_RECIPE_HEAD = b'{"recipe":"'


MACHINE, MACHINES = "machine", "machines"  #: the options that may be paths
#: Options that say nothing of the programs, or are kept in another way.
_APART = ("config_file", "trust", "jobs", "as_json")
#: Values of options that are as if they were not given.
_DEFAULTS = {"order": "given", "mark_from": "mark", "rest_as": "nc1"}
#: Options whose value means something though it is empty: `--allow-skips none`, `--tree`.
_MAY_BE_NOTHING = ("skips", "strict", "flat")


class Recipe(Struct, frozen=True, forbid_unknown_fields=True):
    """The configuration of a run and the options that it was given."""

    configs: tuple[str, ...] = ()  #: its files, the nearest first
    own: tuple[str, ...] = ()  #: those of them that were followed in full
    asked: Mapping[str, Any] = field(default_factory=dict)  #: by the names of the options' values

    @property
    def name(self) -> str:
        """What lines of a record call it by."""
        return sha256(dumped(self)).hexdigest()[:16]


def recipe_of(config: Config, options: Mapping[str, Any], folder: str) -> Recipe:
    """The recipe of a run into `folder`; `options` holds the values of its options."""
    given = {
        name: value
        for name, value in options.items()
        if name not in _APART and value is not None and value != _DEFAULTS.get(name)
        and (value not in ((), False) or name in _MAY_BE_NOTHING)
    }  # fmt: skip
    machine = config.machine if MACHINE in given else None
    if machine is not None and machine.endswith(".toml"):
        given[MACHINE] = path_from(folder, portable_path(machine))
    if MACHINES in given:
        given[MACHINES] = [
            path_from(folder, portable_path(name)) if name.endswith(".toml") else name
            for name in config.split
        ]
    files, own = ([path_from(folder, p) for p in paths] for paths in (config.files, config.own))
    return Recipe(tuple(files), tuple(own), given)


def asked_again(recipe: Recipe, folder: str) -> tuple[ConfigFiles, dict[str, Any]]:
    """The configuration's files and the options of a recipe, as they hold from here.

    What is never kept in a record is not taken from one either.
    """
    options = {
        name: tuple(value) if isinstance(value, list) else value
        for name, value in recipe.asked.items()
        if name not in _APART
    }
    machine = options.get(MACHINE)
    if isinstance(machine, str) and machine.endswith(".toml"):
        options[MACHINE] = path_below(folder, machine)
    if MACHINES in options:
        options[MACHINES] = tuple(
            path_below(folder, name) if name.endswith(".toml") else name
            for name in map(str, options[MACHINES])
        )
    beside = tuple(path_below(folder, p) for p in recipe.configs if p not in recipe.own)
    return ConfigFiles(beside, tuple(path_below(folder, p) for p in recipe.own)), options


def path_from(folder: str, path: str) -> str:
    """A path as it is reached from a folder, with "/"; in full where it lies on another drive."""
    whole = os.path.abspath(path)
    try:
        return os.path.relpath(whole, os.path.abspath(folder)).replace(os.sep, "/")
    except ValueError:
        return whole


def path_below(folder: str, path: str) -> str:
    """The path that `path_from` made of it, from here."""
    return os.path.normpath(os.path.join(folder, path))


class Noted(Struct, frozen=True):
    """One input of a record: what was made of it, and what the run was asked for."""

    row: FileRow
    recipe: Recipe
    input: str  #: its path from the folder of the outputs
    tree: str  #: its path below the folder that all inputs of its run shared
    outputs: tuple[str, ...]  #: those that no later line has; paths below the folder


class Record:
    """The record in an output folder. Raises OSError where the system does not let it be read."""

    def __init__(self, folder: str, recipe: Recipe | None = None, kept: bool = True) -> None:
        """`recipe` is what this run is asked for. Unless `kept`, it is read and never written."""
        self._folder = folder
        recipe, self._kept = recipe or Recipe(), kept
        self._recipe_name = recipe.name
        self._recipe_line = dumped({"recipe": recipe.name, "of": recipe}) + b"\n"
        self._recipes: set[bytes] = set()  #: lines
        self._from_here: dict[str, str] = {}  #: folder of inputs -> as it is reached from `folder`
        self._path = os.path.join(folder, RECORD_NAME)
        self._file: int | None = None  #: that lines are added to
        self._lines: BinaryIO | None = None  #: the same, to be read
        self._torn = False  #: whether a line was begun and could not be ended
        self._size = 0
        self._places: dict[bytes, int] = {}  #: key -> where its line begins
        self._made: dict[str, str] | None = None
        links = 1
        with suppress(FileNotFoundError):
            status = os.lstat(self._path)
            if not stat.S_ISREG(status.st_mode):  # lines would be added to a file elsewhere
                raise OSError(errno.EINVAL, f"{RECORD_NAME} is a link, or no plain file")
            links = status.st_nlink
        lines = self._index()
        if kept and (links > 1 or lines > 2 * len(self._places) + 16):
            # Most lines stand for what was made anew since; or another folder has the file too,
            # as copies by links have.
            write_whole(self._path, self._standing(), durable=False)
            self._index()

    def _index(self) -> int:
        """Note where the lines begin that hold, and give how many there are in all."""
        by_outputs: dict[bytes, tuple[bytes, int]] = {}
        self._recipes.clear()
        self._size = lines = 0
        with suppress(FileNotFoundError), open(self._path, "rb") as file:
            for line in file:
                place, self._size = self._size, self._size + len(line)
                lines += 1
                self._torn = not line.endswith(b"\n")
                if line.startswith(_RECIPE_HEAD) and not self._torn:
                    self._recipes.add(line)
                if self._torn or not line.startswith(_HEAD):
                    continue
                outputs = line.partition(b',"row":')[0][_KEY.stop :]
                with suppress(ValueError):  # not a key: the line is torn
                    key = bytes.fromhex(line[_KEY].decode("ascii"))
                    by_outputs[sha256(outputs).digest()] = key, place
        self._places = dict(by_outputs.values())
        return lines

    def _standing(self) -> Iterator[bytes]:
        """The lines that hold, each behind that of its recipe."""
        recipes = {_recipe_named_by(line): line for line in self._recipes}
        with open(self._path, "rb") as file:
            for place in sorted(self._places.values()):
                file.seek(place)
                line = file.readline()
                yield recipes.pop(_recipe_named_by(line), b"")
                yield line

    def find(self, key: bytes, item: Input) -> FileRow | None:
        """What was made of the input with that key, if all of it still stands as it was made.

        It is noted again where the run that made it was asked otherwise for the same.
        """
        place = self._places.get(key)
        if place is None:
            return None
        try:
            if self._lines is None:
                self._lines = open(self._path, "rb")  # noqa: SIM115  closed by `close`
            self._lines.seek(place)
            line = loaded(self._lines.readline())
            row: FileRow = line["row"]
            made = names_in(row)
            for part in row["parts"]:
                if part["by_hand"]:
                    listed = as_csv(part["by_hand"]).encode("utf-8")
                    made[part["output"] + LIST_SUFFIX] = sha256(listed).hexdigest()
            for name, digest in made.items():
                with open(os.path.join(self._folder, name), "rb", buffering=0) as file:
                    if sha256(file.read()).hexdigest() != digest:
                        return None
            if (line["recipe"], line["input"]) != (self._recipe_name, self.input_of(item)):
                self.add(key, row, item)
        except (OSError, ValueError, KeyError, TypeError):
            return None  # the line cannot be used: the file is done again
        return row

    @property
    def made(self) -> dict[str, str]:
        """Program or rest -> SHA-256 of it as it was made last. It reads the record, once."""
        if self._made is None:
            self._made = {}
            with suppress(FileNotFoundError), open(self._path, "rb") as file:
                for line in file:
                    with suppress(ValueError, KeyError, TypeError, AttributeError):
                        self._made |= names_in(loaded(line)["row"])
        return self._made

    def add(self, key: bytes, row: FileRow, item: Input) -> None:
        """Note what was made of the input with that key. Raises OSError."""
        if not self._kept:
            return
        if self._made is not None:
            self._made |= names_in(row)
        lines = b""
        if self._recipe_line not in self._recipes:
            self._recipes.add(self._recipe_line)
            lines = self._recipe_line
        noted = {
            "key": key.hex(), "outputs": [part["output"] for part in row["parts"]], "row": row,
            "recipe": self._recipe_name, "input": self.input_of(item), "tree": item.tree,
        }  # fmt: skip
        lines += dumped(noted) + b"\n"
        if self._file is None:
            self._file = os.open(self._path, _TO_ADD, 0o666)
        if self._torn:  # end the torn line, so that this one is read
            lines = b"\n" + lines
        self._torn = True
        if os.write(self._file, lines) != len(lines):
            raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))
        self._torn = False

    def input_of(self, item: Input) -> str:
        """The path of an input from the folder of the outputs."""
        folder, name = os.path.split(item.path)
        if folder not in self._from_here:
            self._from_here[folder] = path_from(self._folder, folder or os.curdir)
        return f"{self._from_here[folder]}/{name}"

    def close(self) -> None:
        if self._file is not None:
            os.close(self._file)
            self._file = None
        if self._lines is not None:
            self._lines.close()
            self._lines = None


def claims_of(folder: str, inputs: str) -> dict[str, str]:
    """Which input below the folder `inputs` has which name of an output, as the record says.

    The input may be gone, as one that a hot folder has filed away; its program still stands.
    """
    claims: dict[str, str] = {}
    whole = os.path.abspath(inputs)
    with suppress(OSError):
        for noted in noted_in(folder):
            path = os.path.abspath(path_below(folder, noted.input))
            if path.startswith(os.path.join(whole, "")):
                named = os.path.join(inputs, os.path.relpath(path, whole))
                names = (*noted.outputs, *rests_of(noted))
                claims |= dict.fromkeys(map(folded, names), named)
    return claims


def rests_of(noted: Noted) -> list[str]:
    """The files between the programs of an input."""
    rests = (part.get("rest") for part in noted.row["parts"])  # of older versions they have none
    return [rest["output"] for rest in rests if rest is not None]


def _is_below(output: str) -> bool:
    """Whether a name of a record stays below the folder, as all that batches write do."""
    words = output.replace(os.sep, "/").split("/")
    return bool(output) and ".." not in words and not os.path.isabs(output)


def _recipe_named_by(line: bytes) -> bytes:
    """The name of the recipe of a line of either kind; b"" of an older version's."""
    _, mark, rest = line.rpartition(b'"recipe":"')
    return rest[:16] if mark else b""


def partly(key: bytes) -> bytes:
    """The key that the line of an input has which was posted in part: it is never found by it."""
    return sha256(key + b"in part").digest()


def noted_in(folder: str) -> tuple[Noted, ...]:
    """What the record in a folder says of the programs there, the last line of each program.

    Lines of older versions, which name no recipe, are left out. Raises OSError.
    """
    recipes: dict[str, Recipe] = {}
    lines: list[dict[str, Any]] = []
    last: dict[str, int] = {}  #: output -> the last of the lines that has it
    with open(os.path.join(folder, RECORD_NAME), "rb") as file:
        for text in file:
            with suppress(ValueError, KeyError, TypeError):  # a torn line is not used
                line = loaded(text)
                if "of" in line:
                    recipes[line["recipe"]] = convert(line["of"], Recipe)
                elif line["recipe"] in recipes:
                    if not all(map(_is_below, line["outputs"])):
                        continue  # no batch wrote such a line
                    last |= dict.fromkeys(line["outputs"], len(lines))
                    lines.append(line)
    notes = []
    for number, line in enumerate(lines):
        if outputs := tuple(name for name in line["outputs"] if last[name] == number):
            recipe = recipes[line["recipe"]]
            notes.append(Noted(line["row"], recipe, line["input"], line["tree"], outputs))
    return tuple(notes)


def is_within(folder: str, output: str) -> bool:
    """Whether an output lies in a folder, with every link followed."""
    real, own = os.path.realpath(os.path.join(folder, output)), os.path.realpath(folder)
    return real == own or real.startswith(os.path.join(own, ""))
