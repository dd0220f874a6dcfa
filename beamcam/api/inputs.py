"""What a caller may give: a file by its path, its bytes or open; options of files and sheets."""

import os
from collections.abc import Sequence
from typing import IO, Literal, TypedDict

from msgspec import Struct

from beamcam.conversion import PositiveCount
from beamcam.model.request import MarkFrom

#: The content of a file, or where it is.
FileInput = str | os.PathLike[str] | bytes | bytearray | memoryview | IO[bytes] | IO[str]


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
