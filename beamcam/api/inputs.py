"""What a caller may give, and checks of it: a file by its path, its bytes or open; options of files
and sheets; parts.
"""

import os
from collections.abc import Collection, Iterable, Sequence
from math import isfinite
from typing import IO, Any, Literal, TypedDict, TypeVar

import msgspec
from msgspec import Struct

from beamcam.arguments import HERE, AskError, ask_type
from beamcam.conversion import PositiveCount
from beamcam.errors import Diagnostic, error
from beamcam.model.part import Part
from beamcam.model.request import MarkFrom

#: The content of a file, or where it is.
FileInput = str | os.PathLike[str] | bytes | bytearray | memoryview | IO[bytes] | IO[str]


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
    ends: Literal["contour", "header"] | None  #: what counts where its ends contradict each other
    wrap: str | None  #: the round tube whose unrolled surface a drawing is: "RO168.3x8"
    marks: Sequence[str]  #: members of a model by mark,
    guids: Sequence[str]  #: by GlobalId,
    classes: Sequence[str]  #: by IFC class
    assemblies: Sequence[str]  #: or by assembly
    force: bool  #: whether members with contradictory data are accepted
    letter: Literal["mark"] | None  #: whether they are lettered with their marks
    mark_from: MarkFrom  #: where marks stand: "mark", "drawing", "file" or "position"
    check: bool  #: whether their cuts are checked by the geometry kernel; True
    workers: PositiveCount  #: processes that read a large model; 1


ASK_NUMBER = error("ask-number",
    "found {found} as {name} of the part; expected a finite number",
    "A part that was put together by a program may hold nan or inf, which no axis can move "
    "to.")  # fmt: skip

ASK_VALUE = error("ask-value",
    "found a wrong value of {name} ({fault}); expected one that the option of that name takes",
    "The options of the library are those of the command line and of beamcam.toml, by their "
    "names.")  # fmt: skip


Asked = TypeVar("Asked")


def ask_value(name: str, fault: str) -> Diagnostic:
    """What is said of a wrong value of an option."""
    return ASK_VALUE.at(HERE, name=name, fault=fault)


def check_flags(**flags: object) -> None:
    """Raise AskError for what is neither True nor False."""
    for name, flag in flags.items():
        if not isinstance(flag, bool):
            raise AskError(ask_type(name, flag, "True or False"))


def check_choice(name: str, value: object, choices: Collection[str]) -> None:
    """Raise AskError for what is not one of the choices."""
    if value not in choices:
        raise AskError(ask_type(name, value, " or ".join(map(repr, choices))))


def check_text(name: str, value: object, *others: type) -> None:
    """Raise AskError for what is neither text nor one of `others`."""
    if not isinstance(value, (str, *others)):
        raise AskError(
            ask_type(name, value, " or ".join(("a text", *(t.__name__ for t in others))))
        )


def checked_parts(parts: Part | Iterable[Part]) -> tuple[Part, ...]:
    """The parts that are meant. Raises AskError for anything else, and for nan and inf."""
    if isinstance(parts, Part):
        parts = (parts,)
    if isinstance(parts, str | bytes) or not isinstance(parts, Iterable):
        raise AskError(ask_type("parts", parts, "a Part, or several"))
    all_parts = tuple(parts)
    for part in all_parts:
        if not isinstance(part, Part):
            raise AskError(ask_type("parts", part, "a Part, or several"))
        waiting: list[tuple[str, Any]] = [("", part)]
        while waiting:
            name, value = waiting.pop()
            if isinstance(value, float):
                if not isfinite(value):
                    raise AskError(ASK_NUMBER.at(part.source, found=value, name=name))
            elif isinstance(value, Struct):
                fields = ((field, getattr(value, field)) for field in value.__struct_fields__)
                waiting += ((f"{name}.{f}".lstrip("."), inner) for f, inner in fields)
            elif isinstance(value, tuple):
                waiting += ((name, inner) for inner in value)
    return all_parts


def converted(value: object, kind: type[Asked], name: str = "") -> Asked:
    """A value as one of a `kind`. Raises AskError that names the part of it which is not."""
    try:
        return msgspec.convert(value, kind)
    except msgspec.ValidationError as error:
        fault, _, where = str(error).partition(" - at `$")
        place = where.rstrip("`").lstrip(".") or name
        raise AskError(ask_value(place or "the options", fault)) from error
