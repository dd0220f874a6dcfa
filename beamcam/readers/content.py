"""The bytes of an input, or why they cannot be had."""

import os
import sys

from beamcam.errors import Diagnostic, Source
from beamcam.readers import rules
from beamcam.system import BINARY

STANDARD_INPUT = "-"
TO_READ = os.O_RDONLY | BINARY  #: how a file is opened
_PIECE = 1 << 20
_ZEROS = bytes(_PIECE)


def shown_name(path: str) -> str:
    """Name of an input in messages."""
    return "stdin" if path == STANDARD_INPUT else path


def content(path: str) -> bytes | Diagnostic:
    """Content of a file, `-` for standard input; a diagnostic if it cannot be read or is zeros."""
    try:
        if path == STANDARD_INPUT:
            return _unless_zeros(sys.stdin.buffer.read(), "stdin")
        file = os.open(path, TO_READ)
        try:
            return content_of(file, os.fstat(file).st_size, path)
        finally:
            os.close(file)
    except OSError as error:
        if os.path.isdir(path):
            return rules.FOLDER.at(Source(path), found=path)
        return rules.UNREADABLE.at(Source(shown_name(path)), found=error.strerror or error)


def content_of(file: int, size: int, name: str) -> bytes | Diagnostic:
    """Content of an open file, as `content`; its `size` as the system has it. Raises OSError."""
    if size >= _PIECE:
        # A broken copy is often as large as the disk had room, and would fill the memory.
        zeros = 0
        while (piece := os.read(file, _PIECE)) and piece == _ZEROS[: len(piece)]:
            zeros += len(piece)
        if not piece:
            return _zeros(zeros, name)
        os.lseek(file, 0, os.SEEK_SET)
    data = os.read(file, size + 1)
    if len(data) != size:  # a pipe, or a file that someone writes to
        pieces = [data]
        while piece := os.read(file, _PIECE):
            pieces.append(piece)
        data = b"".join(pieces)
    return _unless_zeros(data, name)


def _unless_zeros(data: bytes, name: str) -> bytes | Diagnostic:
    if data[:1] == b"\0" and not data.strip(b"\0"):
        return _zeros(len(data), name)
    return data


def _zeros(count: int, name: str) -> Diagnostic:
    return rules.ZEROS.at(Source(name), found=f"{count:,}".replace(",", " "))
