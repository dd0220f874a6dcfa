"""The record of a batch, beside its outputs: what was made of what, so that it is made once.

`.beamcam-batch.jsonl` has a line for each input that was posted whole. A line is added as soon as
the outputs stand, so that a run that is killed has to be finished, not done again; a
torn line is not used. An output that is missing or changed makes its line void.

    {"recipe":"3f...","of":{"configs":[],"asked":{"machine":"../mine.toml"}}}
    {"key":"a1...","outputs":["M58.gcode"],"row":{...},"recipe":"3f...","input":"../in/M58.nc1",...}

Lines of the first kind say what the run was asked for, which those of its inputs name. A file that
was posted in part has a line too, under a key that no input has, so that its programs are known.
"""

import errno
import hashlib
import os
import stat
from collections.abc import Iterator
from contextlib import suppress
from hashlib import sha256
from typing import Any, BinaryIO

from msgspec import Struct, convert

from beamcam.batch import LINK, NOT_OURS
from beamcam.batch.find import Input
from beamcam.batch.names import folded
from beamcam.batch.recipe import Recipe, path_below, path_from
from beamcam.checks.job import MOST_BEFORE, head_of
from beamcam.errors import Diagnostic, Source
from beamcam.files import write_whole
from beamcam.planning.manual_list import LIST_BEGIN, LIST_SUFFIX, as_csv
from beamcam.readers.dstv import MADE
from beamcam.reports.run import FileRow, dumped, loaded, names_in
from beamcam.system import BINARY

RECORD_NAME = ".beamcam-batch.jsonl"
_TO_ADD = os.O_WRONLY | os.O_APPEND | os.O_CREAT | getattr(os, "O_NOFOLLOW", 0) | BINARY
_HEAD = b'{"key":"'
_KEY = slice(len(_HEAD), len(_HEAD) + 64)
#: In the form that a part has which another machine has begun: of DSTV, and of JSON.
REST_MARKS = (MADE.encode(), b'"made": {')
_RECIPE_HEAD = b'{"recipe":"'


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
        shared = _shared(self._path)
        lines = self._index()
        if kept and (shared or lines > 2 * len(self._places) + 16):
            # Most lines stand for what was made anew since; or another folder has the file too.
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
                    by_outputs[hashlib.sha256(outputs).digest()] = key, place
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

    def _line(self, place: int) -> bytes:
        if self._lines is None:
            self._lines = open(self._path, "rb")  # noqa: SIM115  closed by `close`
        self._lines.seek(place)
        return self._lines.readline()

    def find(self, key: bytes, found: Input) -> FileRow | None:
        """What was made of the input with that key, if all of it still stands as it was made.

        It is noted again where the run that made it was asked otherwise for the same.
        """
        place = self._places.get(key)
        if place is None:
            return None
        try:
            line = loaded(self._line(place))
            row: FileRow = line["row"]
            for part in row["parts"]:
                path = os.path.join(self._folder, part["output"])
                with open(path, "rb", buffering=0) as file:
                    if hashlib.sha256(file.read()).hexdigest() != part["sha256"]:
                        return None
                if part["by_hand"]:
                    with open(path + LIST_SUFFIX, "rb", buffering=0) as file:
                        if file.read() != as_csv(part["by_hand"]).encode("utf-8"):
                            return None
                if part["rest"] is not None:
                    path = os.path.join(self._folder, part["rest"]["output"])
                    with open(path, "rb", buffering=0) as file:
                        if hashlib.sha256(file.read()).hexdigest() != part["rest"]["sha256"]:
                            return None
            if (line["recipe"], line["input"]) != (self._recipe_name, self.input_of(found)):
                self.add(key, row, found)
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

    def add(self, key: bytes, row: FileRow, found: Input) -> None:
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
            "recipe": self._recipe_name, "input": self.input_of(found), "tree": found.tree,
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

    def input_of(self, found: Input) -> str:
        """The path of an input from the folder of the outputs."""
        folder, name = os.path.split(found.path)
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


def _shared(path: str) -> bool:
    """Whether a record is a file that another folder has too, as copies by links have.

    Raises OSError for a link, by which lines would be added to a file elsewhere, and for what is no
    plain file.
    """
    try:
        status = os.lstat(path)
    except FileNotFoundError:
        return False
    if not stat.S_ISREG(status.st_mode):
        raise OSError(errno.EINVAL, f"{RECORD_NAME} is a link, or no plain file")
    return status.st_nlink > 1


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
    return hashlib.sha256(key + b"in part").digest()


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


# --- standing -------------------------------------------------------------------------------------

# Files that stand where outputs of a batch go: which of them may be written over.
#
# nothing there                         written
# as the record says that it was made   written over
# beamcam's, of which no record knows   written over: by `post`, or by a run that was killed
# anybody else's, edited, or read-only  refused, unless the run is forced
# by a link out of the folder           refused


class OutputState:
    """What stands in the folder of a batch."""

    def __init__(self, folder: str, record: Record, force: bool) -> None:
        self._folder, self._record, self._force = folder, record, force
        self._within: dict[str, bool] = {}  #: whether folders below are in it, links followed

    def refusal(self, output: str, content: bytes, path: str) -> Diagnostic | None:
        """Why `output` of the input at `path` cannot be written; None if it can."""
        place = os.path.join(self._folder, output)
        if not self.is_within(output):
            found = os.path.realpath(place)
            return LINK.at(Source(path), found=output, to=found)
        if self._force:
            return None
        try:
            found_there = os.stat(place)
        except OSError:
            return None  # nothing is there, or writing says what is wrong
        why = _locked(found_there) or self._strange(output, place, content)
        return NOT_OURS.at(Source(path), found=output, why=why) if why else None

    def is_within(self, output: str) -> bool:
        """Whether an output lies in the folder, with every link followed."""
        below = output.rpartition("/")[0]
        if below not in self._within:
            self._within[below] = is_within(self._folder, below)
        is_link = os.path.islink(os.path.join(self._folder, output))
        return self._within[below] and (not is_link or is_within(self._folder, output))

    def _strange(self, output: str, place: str, content: bytes) -> str:
        """Why a file is not what a batch made there; "" if it is."""
        if not os.path.isfile(place):
            return "which is no plain file"
        there = b""
        with suppress(OSError), open(place, "rb") as file:
            there = file.read()
        if there == content:
            return ""
        made = self._record.made.get(output)
        if made is not None:
            is_it = sha256(there).hexdigest() == made
            return "" if is_it else "which was changed since it was made"
        if is_list_or_rest(there) or head_of(there[:MOST_BEFORE].decode("latin-1")):
            return ""
        return "which beamcam did not make"


def is_list_or_rest(data: bytes) -> bool:
    """Whether a file was written beside programs: manual work, or what is left of a part."""
    return data.startswith(LIST_BEGIN) or any(mark in data for mark in REST_MARKS)


def is_within(folder: str, output: str) -> bool:
    """Whether an output lies in a folder, with every link followed."""
    real, own = os.path.realpath(os.path.join(folder, output)), os.path.realpath(folder)
    return real == own or real.startswith(os.path.join(own, ""))


def _locked(status: os.stat_result) -> str:
    """Why a file is not to be written, by its rights; the owner of the system has none."""
    is_locked = stat.S_ISREG(status.st_mode) and not status.st_mode & 0o222
    return "which is read-only" if is_locked else ""
