"""The bytes of an input, or why they cannot be had; rules for inputs of no known format."""

import os
import sys

from msgspec import Struct

from beamcam.budget import BYTES, limits
from beamcam.errors import Diagnostic, Source, error, errors_in, warning
from beamcam.model.part import Part
from beamcam.system import NotAFile, open_file

# fmt: off

EMPTY = error("read-empty",
    "found an empty file; expected a part or a drawing",
    "An export that failed often leaves a file without content.")
UNKNOWN_FORMAT = error("read-format",
    "found content of no known format; expected a file of one of {expected}",
    "The suffix is not known and the content looks like none of the formats.")
CORELDRAW = error("read-coreldraw",
    "found a CorelDRAW file ({found}); expected a drawing as SVG or DXF: export it as SVG",
    "CDR is a closed format; CorelDRAW writes SVG and DXF.")
OTHER_FORMAT = error("read-other-format",
    "found {found}; expected {expected}",
    "What other programs keep their work in says nothing of holes and cuts that could be trusted.")
PROGRAM = error("read-program",
    "found a program; expected parts (`beamcam verify`, `plot`, `report`, `simulate` and `recover` "
    "take programs)",
    "A program says what a machine does, and not what the part is.")
UNREADABLE = error("read-file",
    "found no file that can be read ({found}); expected one",
    "The file does not exist, or the system does not let it be read.")
FOLDER = error("read-folder",
    "found a folder; expected a file (`beamcam batch {found} -o OUT` posts the files of a folder, "
    "`check` its golden programs, `diff` compares two folders)",
    "This command takes files one by one.")
NOT_A_FILE = error("read-not-a-file",
    "found {found}; expected a plain file, or `-` for standard input",
    "A pipe or a device may have no end, or none that comes.")
ZEROS = error("read-zeros",
    "found {found} bytes that are all zero; expected a part, a drawing or a program",
    "A copy that was broken off leaves such a file; copy it again.")
ENCODING = error("read-encoding",
    "found bytes that are no {encoding} text; expected the alphabet that the file was written in, "
    "by --encoding",
    "Marks and names would show other characters than meant.")
OSCILLATION = warning("polynomial-oscillates",
    "found that {found}",
    "Between many nodes a polynomial swings; take fewer nodes, or several curves of up to five.")
NODES_LOST = error("polynomial-lost",
    "found a polynomial through {nodes} nodes that misses them by {found:.3g} mm, expected at most "
    "{expected:g} mm; take fewer nodes",
    "Its values cancel each other until no digit of them is left.")


# fmt: on


STANDARD_INPUT = "-"
_PIECE = 1 << 20
_ZEROS = bytes(_PIECE)


def shown_name(path: str) -> str:
    """Name of an input in messages."""
    return "stdin" if path == STANDARD_INPUT else path


def content(path: str) -> bytes | Diagnostic:
    """Content of a file, `-` for standard input.

    A diagnostic if it cannot be read, is no plain file, is zeros or larger than `limits.bytes`.
    """
    try:
        if path == STANDARD_INPUT:
            most, pieces, total = limits().bytes, [], 0
            while total <= most and (piece := sys.stdin.buffer.read(_PIECE)):
                pieces.append(piece)
                total += len(piece)
            return _unless_zeros(b"".join(pieces), "stdin")
        file = open_file(path)
        try:
            return content_of(file, os.fstat(file).st_size, path)
        finally:
            os.close(file)
    except NotAFile as error:
        return NOT_A_FILE.at(Source(path), found=error.strerror)
    except OSError as error:
        if os.path.isdir(path):
            return FOLDER.at(Source(path), found=path)
        return UNREADABLE.at(Source(shown_name(path)), found=error.strerror or error)


def content_of(file: int, size: int, name: str) -> bytes | Diagnostic:
    """Content of an open file, as `content`; its `size` as the system has it. Raises OSError."""
    if size > limits().bytes:
        return _too_long(size, name)
    if size >= _PIECE:
        # A broken copy is often as large as the disk had room, and would fill the memory.
        zeros = 0
        while (piece := os.read(file, _PIECE)) and piece == _ZEROS[: len(piece)]:
            zeros += len(piece)
        if not piece:
            return _zeros(zeros, name)
        os.lseek(file, 0, os.SEEK_SET)
    data = os.read(file, size + 1)
    if len(data) != size:  # a file that someone writes to
        pieces = [data]
        total = len(data)
        while total <= limits().bytes and (piece := os.read(file, _PIECE)):
            pieces.append(piece)
            total += len(piece)
        data = b"".join(pieces)
    return _unless_zeros(data, name)


def _unless_zeros(data: bytes, name: str) -> bytes | Diagnostic:
    if data[:1] == b"\0" and not data.strip(b"\0"):
        return _zeros(len(data), name)
    return _too_long(len(data), name) if len(data) > limits().bytes else data


def _too_long(size: int, name: str) -> Diagnostic:
    return BYTES.at(Source(name), found=size, expected=limits().bytes)


def _zeros(count: int, name: str) -> Diagnostic:
    return ZEROS.at(Source(name), found=f"{count:,}".replace(",", " "))


# --- reading --------------------------------------------------------------------------------------

# The result of every reader.


class Reading(Struct, frozen=True):
    """The parts of one file, as far as they could be read, and remarks on it.

    Where a diagnostic is an error no part may be posted; `parts` then still holds what was read.
    """

    format: str
    parts: tuple[Part, ...]
    diagnostics: tuple[Diagnostic, ...] = ()

    @property
    def refused(self) -> bool:
        return bool(errors_in(self.diagnostics))
