"""Shared by the commands that read programs."""

from beamcam.errors import Diagnostic, ReadError
from beamcam.readers.content import content


def input_bytes(path: str) -> bytes:
    """Content of a file, `-` for standard input. Raises ReadError."""
    data = content(path)
    if isinstance(data, Diagnostic):
        raise ReadError(data)
    return data


def program_text(path: str) -> str:
    """The text of a program; bytes that are no text become `\\ufffd`. Raises ReadError."""
    return input_bytes(path).decode("utf-8", "replace")
