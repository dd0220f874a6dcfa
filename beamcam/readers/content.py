"""The bytes of an input, or why they cannot be had."""

import os
import sys
from typing import BinaryIO

from beamcam.errors import Diagnostic, Source
from beamcam.readers import rules

STANDARD_INPUT = "-"
_PIECE = 1 << 20
_ZEROS = bytes(_PIECE)


def shown_name(path: str) -> str:
    """How an input is called in messages."""
    return "stdin" if path == STANDARD_INPUT else path


def content(path: str) -> bytes | Diagnostic:
    """What is in a file, `-` for standard input; a diagnostic if it cannot be read or is zeros."""
    try:
        if path == STANDARD_INPUT:
            return _of(sys.stdin.buffer, 0, "stdin")
        with open(path, "rb", buffering=0) as file:
            return _of(file, os.fstat(file.fileno()).st_size, path)
    except OSError as error:
        return rules.UNREADABLE.at(Source(shown_name(path)), found=error.strerror or error)


def _of(file: BinaryIO, size: int, name: str) -> bytes | Diagnostic:
    """`size` is 0 where it is not known."""
    if size >= _PIECE:
        # A broken copy is often as large as the disk had room, and would fill the memory.
        zeros = 0
        while (piece := file.read(_PIECE)) and piece == _ZEROS[: len(piece)]:
            zeros += len(piece)
        if not piece:
            return _zeros(zeros, name)
        file.seek(0)
    data = file.read()
    if data[:1] == b"\0" and not data.strip(b"\0"):
        return _zeros(len(data), name)
    return data


def _zeros(count: int, name: str) -> Diagnostic:
    return rules.ZEROS.at(Source(name), found=f"{count:,}".replace(",", " "))
