"""What the commands that read programs share."""

import sys

from beamcam.commands.common import STANDARD, shown_name
from beamcam.errors import ReadError, Source
from beamcam.readers.rules import UNREADABLE


def input_bytes(path: str) -> bytes:
    """What is in a file, `-` for standard input. Raises ReadError."""
    try:
        if path == STANDARD:
            return sys.stdin.buffer.read()
        with open(path, "rb") as file:
            return file.read()
    except OSError as error:
        said = UNREADABLE.at(Source(shown_name(path)), found=error.strerror or error)
        raise ReadError(said) from error


def program_text(path: str) -> str:
    """The text of a program; bytes that are no text become `\\ufffd`. Raises ReadError."""
    return input_bytes(path).decode("utf-8", "replace")
