"""What a caller may give as a file: a path, its bytes, or the file itself while it is open."""

import os
from typing import IO, Any

from beamcam.asked import AskError, ask_type
from beamcam.errors import Diagnostic, ReadError
from beamcam.readers.content import content

#: The content of a file, or where it is.
FileInput = str | os.PathLike[str] | bytes | bytearray | memoryview | IO[bytes] | IO[str]


def bytes_of(source: object, what: str) -> bytes | None:
    """The bytes of a file that is given by its content or open; None of a path.

    Raises AskError for anything else.
    """
    if isinstance(source, bytes | bytearray | memoryview):
        return bytes(source)
    if isinstance(source, str | os.PathLike):
        return None
    read: Any = getattr(source, "read", None)
    if not callable(read):
        raise AskError(ask_type(what, source, "a path, bytes, or a file that is open to be read"))
    data = read()
    return data.encode() if isinstance(data, str) else bytes(data)


def program_bytes(program: object) -> bytes:
    """The bytes of a program: of its text, its bytes, or its file as a `Path` or open.

    Raises AskError, and ReadError for a file that cannot be read.
    """
    if isinstance(program, str):
        return program.encode()
    data = bytes_of(program, "program")
    if data is not None:
        return data
    found = content(os.fspath(program))  # type: ignore[call-overload]
    if isinstance(found, Diagnostic):
        raise ReadError(found)
    return bytes(found)
