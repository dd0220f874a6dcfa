"""What a caller may give: a file by its path, its bytes or open; options of files and sheets."""

import os
from collections.abc import Sequence
from typing import IO, Any, Literal, TypedDict

from msgspec import Struct

from beamcam.arguments import AskError, ask_type
from beamcam.conversion import PositiveCount
from beamcam.errors import Diagnostic, ReadError
from beamcam.model.description import MarkFrom
from beamcam.readers import content

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


class CheckedReadOptions(Struct, forbid_unknown_fields=True):
    """What a caller asks of a reader, checked."""

    units: str | None = None
    width: str | None = None
    layers: tuple[str, ...] = ()
    letters: tuple[str, ...] = ()
    fit: tuple[str, ...] = ()
    encoding: str | None = None
    wrap: str | None = None
    marks: tuple[str, ...] = ()
    guids: tuple[str, ...] = ()
    classes: tuple[str, ...] = ()
    assemblies: tuple[str, ...] = ()
    force: bool = False
    letter: Literal["mark"] | None = None
    mark_from: MarkFrom = "mark"
    check: bool = True
    workers: PositiveCount = 1


class SheetOptions(TypedDict, total=False):
    """How a sheet is cut, as the options of the command line and the keys of `[sheet]`; mm."""

    thickness: float
    material: str
    amps: float
    nozzle: str
    kerf: float
    kerf_by: Literal["none", "offset", "machine"]
    lead: Literal["none", "line", "arc"]
    lead_in: float
    lead_out: float
    tabs: int
    tab_width: float
    inner_tabs: bool
    overcut: float
    gap: float
    allow_open: bool
    place: Literal["corner", "drawn"]
    origin: Literal["table", "lower-left", "lower-right", "upper-left", "upper-right", "centre"]
    mirror: Literal["none", "x", "y"]
    rotate: float
    copies: tuple[int, int]
    spacing: float
    common_cuts: bool
    chain_cuts: float
    skeleton_cuts: bool
    sheet_size: tuple[float, float]
    unrolled: bool


class ReadOptions(TypedDict, total=False):
    """How a file is read, as the options of the command line."""

    units: str | None  #: of a drawing's numbers: "mm", "in"
    width: str | None  #: of an SVG's page: "600mm"
    layers: Sequence[str]  #: of a drawing, those to read
    letters: Sequence[str]  #: layers whose texts become strokes
    fit: Sequence[str]  #: layers whose polylines become polynomials through their vertices
    encoding: str | None  #: of a DSTV file
    wrap: str | None  #: the round tube whose unrolled surface a drawing is: "RO168.3x8"
    marks: Sequence[str]  #: members of a model by mark,
    guids: Sequence[str]  #: by GlobalId,
    classes: Sequence[str]  #: by IFC class
    assemblies: Sequence[str]  #: or by assembly
    force: bool  #: whether members with contradictory data are accepted
    letter: Literal["mark"] | None  #: whether they are lettered with their marks
    mark_from: MarkFrom  #: where marks stand: "mark", "drawing", "file" or "position"
    check: bool  #: whether their cuts are checked by the geometry kernel; True
    workers: int  #: processes that read a large model; 1
