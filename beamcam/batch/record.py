"""The record of a batch, beside its outputs: what was made of what, so that it is made once.

`.beamcam-batch.jsonl` has a line for each input that was posted whole. A line is added as soon as
the outputs stand, so that a run that is killed has to be finished, not done again; a line that was
torn is none. An output that is missing or changed makes its line void.
"""

import errno
import hashlib
import os
from collections.abc import Iterator
from contextlib import suppress
from typing import BinaryIO

from beamcam.files import write_whole
from beamcam.report.run import Row, dumped, loaded
from beamcam.system import BINARY

RECORD_NAME = ".beamcam-batch.jsonl"
_TO_ADD = os.O_WRONLY | os.O_APPEND | os.O_CREAT | BINARY
_HEAD = b'{"key":"'
_KEY = slice(len(_HEAD), len(_HEAD) + 64)


class Record:
    """The record in an output folder. Raises OSError where the system does not let it be read."""

    def __init__(self, folder: str) -> None:
        self._folder = folder
        self._path = os.path.join(folder, RECORD_NAME)
        self._file: int | None = None  #: that lines are added to
        self._lines: BinaryIO | None = None  #: the same, to be read
        self._torn = False  #: whether a line was begun and could not be ended
        self._size = 0
        self._places: dict[bytes, int] = {}  #: key -> where its line begins
        lines = self._index()
        if lines > 2 * len(self._places) + 16:
            # Most lines stand for what was made anew since.
            write_whole(self._path, self._standing(), durable=False)
            self._index()

    def _index(self) -> int:
        """Note where the lines begin that hold, and give how many there are in all."""
        by_outputs: dict[bytes, tuple[bytes, int]] = {}
        self._size = lines = 0
        with suppress(FileNotFoundError), open(self._path, "rb") as file:
            for line in file:
                place, self._size = self._size, self._size + len(line)
                lines += 1
                self._torn = not line.endswith(b"\n")
                if self._torn or not line.startswith(_HEAD):
                    continue
                outputs = line.partition(b',"row":')[0][_KEY.stop :]
                with suppress(ValueError):  # a key that is none: the line is torn
                    key = bytes.fromhex(line[_KEY].decode("ascii"))
                    by_outputs[hashlib.sha256(outputs).digest()] = key, place
        self._places = dict(by_outputs.values())
        return lines

    def _standing(self) -> Iterator[bytes]:
        """The lines that hold."""
        with open(self._path, "rb") as file:
            for place in sorted(self._places.values()):
                file.seek(place)
                yield file.readline()

    def _line(self, place: int) -> bytes:
        if self._lines is None:
            self._lines = open(self._path, "rb")  # noqa: SIM115  closed by `close`
        self._lines.seek(place)
        return self._lines.readline()

    def find(self, key: bytes) -> Row | None:
        """What was made of the input with that key, if all of it still stands as it was made."""
        place = self._places.get(key)
        if place is None:
            return None
        try:
            row: Row = loaded(self._line(place))["row"]
            for part in row["parts"]:
                path = os.path.join(self._folder, part["output"])
                with open(path, "rb", buffering=0) as file:
                    if hashlib.sha256(file.read()).hexdigest() != part["sha256"]:
                        return None
        except (OSError, ValueError, KeyError, TypeError):
            return None  # a line that cannot be used is none: the file is done again
        return row

    def add(self, key: bytes, row: Row) -> None:
        """Note what was made of the input with that key. Raises OSError."""
        outputs = [part["output"] for part in row["parts"]]
        line = dumped({"key": key.hex(), "outputs": outputs, "row": row}) + b"\n"
        if self._file is None:
            self._file = os.open(self._path, _TO_ADD, 0o666)
        if self._torn:  # end the torn line, so that this one is read
            line = b"\n" + line
        self._torn = True
        written = os.write(self._file, line)
        if written != len(line):
            raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))
        self._torn = False

    def close(self) -> None:
        if self._file is not None:
            os.close(self._file)
            self._file = None
        if self._lines is not None:
            self._lines.close()
            self._lines = None
