"""Readers: a file's bytes in, parts and diagnostics out. One module a format.

A reader is `read(data, name) -> Reading`; it opens no file, prints nothing and never raises for
bad input. `looks_like(data)` tells by the content whether the bytes are of its format. Here are
also what a file holds, or why it cannot be had, and the table of formats.

Whether a file has come to its end, by what the last of it has to be in its format.

    M58.nc1  EN            a line of its own
    hall.ifc END-ISO-10303-21;
    P7.json  } or ]        the one that closes the whole text
    cut.dxf  EOF           the value of its last group, 0
    cut.svg  </svg>        the one that closes the drawing

A writer may pause in mid file for any time, so that a file which stays the same is not complete
for that alone.
"""

import os
import re
import sys
from collections.abc import Callable
from functools import partial
from importlib import import_module

import msgspec
from msgspec import Struct
from msgspec.structs import replace

from beamcam.budget import BYTES, InForce
from beamcam.caches import cached
from beamcam.errors import Diagnostic, Source, error, errors_in
from beamcam.machine.machine import DEFAULTS
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
            return _unless_zeros(_pieces(sys.stdin.buffer.read), "stdin")
        file = open_file(path)
        try:
            size = os.fstat(file).st_size
            if size > InForce.limits.bytes:
                return BYTES.at(Source(path), found=size, expected=InForce.limits.bytes)
            if size >= _PIECE:
                # A broken copy is often as large as the disk had room, and would fill the memory.
                zeros = 0
                while (piece := os.read(file, _PIECE)) and piece == _ZEROS[: len(piece)]:
                    zeros += len(piece)
                if not piece:
                    return _zeros(zeros, path)
                os.lseek(file, 0, os.SEEK_SET)
            data = os.read(file, size + 1)
            if len(data) != size:  # a file that someone writes to
                data = _pieces(partial(os.read, file), data)
            return _unless_zeros(data, path)
        finally:
            os.close(file)
    except NotAFile as error:
        return NOT_A_FILE.at(Source(path), found=error.strerror)
    except OSError as error:
        if os.path.isdir(path):
            return FOLDER.at(Source(path), found=path)
        return UNREADABLE.at(Source(shown_name(path)), found=error.strerror or error)


def _pieces(read: Callable[[int], bytes], first: bytes = b"") -> bytes:
    """All that is read piece by piece, or a little more than `limits.bytes` of it."""
    pieces, total = [first], len(first)
    while total <= InForce.limits.bytes and (piece := read(_PIECE)):
        pieces.append(piece)
        total += len(piece)
    return b"".join(pieces)


def _unless_zeros(data: bytes, name: str) -> bytes | Diagnostic:
    if data[:1] == b"\0" and not data.strip(b"\0"):
        return _zeros(len(data), name)
    if len(data) > InForce.limits.bytes:
        return BYTES.at(Source(name), found=len(data), expected=InForce.limits.bytes)
    return data


def _zeros(count: int, name: str) -> Diagnostic:
    return ZEROS.at(Source(name), found=f"{count:,}".replace(",", " "))


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


def sound(reading: Reading) -> Reading:
    """A reading with those of its parts only that no error is said of.

    Errors of a model name their members, which are parts of their own; in any other file they
    refuse all of it.
    """
    refused = {diagnostic.source.where for diagnostic in errors_in(reading.diagnostics)}
    if not refused:
        return reading
    is_model = reading.format == "ifc"
    parts = tuple([part for part in reading.parts if is_model and part.guid not in refused])
    return replace(reading, parts=parts)


_module = cached("readers.module")(import_module)


class Format(Struct, frozen=True):
    """One format: its name, the suffixes of its files and the module that reads it."""

    name: str
    suffixes: tuple[str, ...]
    module: str  #: imported when a file of the format is met, since some readers are heavy
    options: tuple[str, ...] = ()  #: keywords that its reader takes beside the name

    @property
    def looks_like(self) -> Callable[[bytes], bool]:
        function: Callable[[bytes], bool] = _module(self.module).looks_like
        return function

    @property
    def read(self) -> Callable[..., Reading]:
        function: Callable[..., Reading] = _module(self.module).read
        return function


FORMATS = (
    Format("dstv", (".nc", ".nc1"), "beamcam.readers.dstv", ("encoding", "ends")),
    Format("dxf", (".dxf",), "beamcam.readers.dxf", ("units", "layers", "fit", "letters", "wrap")),
    Format("svg", (".svg",), "beamcam.readers.svg", ("units", "width", "layers", "fit", "wrap")),
    Format("ifc", (".ifc", ".ifczip"), "beamcam.readers.ifc", ("selection", "options", "progress")),
    Format("part-json", (".json",), "beamcam.readers.part_json"),
)
_BY_SUFFIX = {suffix: known for known in FORMATS for suffix in known.suffixes}
_OF_PROGRAMS = frozenset(suffix for _, suffix in DEFAULTS)


def is_interruptible(name: str) -> bool:
    """Whether Ctrl-C is heard while a file called `name` is read.

    The geometry kernel of building models lets nothing through; without a known suffix the content
    may be one.
    """
    suffix = os.path.splitext(name)[1].lower()
    return any(suffix in known.suffixes for known in FORMATS if known.name != "ifc")


def read(data: bytes, name: str, **options: object) -> Reading:
    """The parts of a file called `name`; a file that no reader knows is refused.

    The suffix says which reader is asked first, the content decides. `options` that are not None
    go to a reader that takes them (units, width, layers and fit of a drawing); `wrap` names the
    tube whose surface a drawing is.
    """
    if not data or data.isspace():
        return Reading("unknown", (), (EMPTY.at(Source(name)),))
    suffix = os.path.splitext(name)[1].lower()
    if corel := _coreldraw(data, suffix):
        return Reading("unknown", (), (CORELDRAW.at(Source(name), found=corel),))
    if (other := other_format(data, name)) is not None:
        return Reading("unknown", (), (other,))
    if suffix in _OF_PROGRAMS and _is_program(data):
        return Reading("unknown", (), (PROGRAM.at(Source(name)),))
    by_content = (known for known in FORMATS if known.looks_like(data))
    if (known := _BY_SUFFIX.get(suffix) or next(by_content, None)) is None:
        expected = ", ".join(_BY_SUFFIX)
        return Reading("unknown", (), (UNKNOWN_FORMAT.at(Source(name), expected=expected),))
    taken = {k: v for k, v in options.items() if k in known.options and v is not None}
    return known.read(data, name, **taken)


def _coreldraw(data: bytes, suffix: str) -> str:
    """What tells that bytes are a CorelDRAW file, to refuse it by name; empty if they are none.

    Versions 3 to X3 are RIFF files of the form `CDR`, later ones zip archives that hold
    `content/riffData.cdr`. Of older ones and of damage only the suffix tells.
    """
    if data[:4] == b"RIFF" and data[8:11].upper() == b"CDR":
        return "RIFF " + data[8:12].decode("ascii", "replace")
    if data[:4] == b"PK\3\4" and b"content/riffData.cdr" in data:
        return "an archive with content/riffData.cdr"
    if suffix == ".cdr" and not any(known.looks_like(data) for known in FORMATS):
        return suffix
    return ""


#: How files of other programs begin, what they are, and what to export in their place.
_PARTS = "a part as DSTV or IFC"
_BEGINNINGS = (
    (b"%PDF-", "a PDF", "the drawing as DXF or SVG, as its program exports it"),
    (b"PK\3\4", "a zip archive", "its files, unpacked"),
    (b"\xd0\xcf\x11\xe0", "a document of Office", _PARTS),
    (b"\x89PNG", "a picture", "the drawing as DXF or SVG"),
    (b"\xff\xd8\xff", "a picture", "the drawing as DXF or SVG"),
    (b"solid ", "a mesh (STL)", _PARTS),
)
_SCHEMA = re.compile(rb"FILE_SCHEMA\s*\(\s*\(\s*['\"]([^'\"]{1,80})")
_HEAD_BYTES = 65_536  #: of a STEP file its schema lies within them
_G_CODE = re.compile(rb"^(?:N\d+[ \t]*)?[GM]\d{1,3}\b", re.MULTILINE)


def other_format(data: bytes, name: str) -> Diagnostic | None:
    """What a file of a common other format is, and what is expected instead of it."""
    if os.path.splitext(name)[1].lower() in _BY_SUFFIX:
        return None  # the reader of that suffix says what is wrong with it
    schema = _SCHEMA.search(data, 0, _HEAD_BYTES) if data[:13] == b"ISO-10303-21;" else None
    if schema is not None and not schema[1].upper().startswith(b"IFC"):
        found = f"a STEP model ({schema[1].split()[0].decode('ascii', 'replace')})"
        expected = "the model exported as IFC, or its parts as DSTV"
    elif data.startswith(b"PK\3\4") and (b"word/" in data or b"xl/" in data):
        found, expected = "a document of Office", _PARTS
    else:
        begun = (row for row in _BEGINNINGS if data.startswith(row[0]))
        _, found, expected = next(begun, (b"", "", ""))
    return OTHER_FORMAT.at(Source(name), found=found, expected=expected) if found else None


def is_of_programs(name: str) -> bool:
    """Whether a machine writes its programs under that suffix."""
    return os.path.splitext(name)[1].lower() in _OF_PROGRAMS


def _is_program(data: bytes) -> bool:
    """Whether bytes are a machine's program, by their content, and no reader knows them."""
    is_one = b"BEAMCAM" in data[:1024] or _G_CODE.search(data, 0, _HEAD_BYTES) is not None
    return is_one and not any(known.looks_like(data) for known in FORMATS)


TAIL_BYTES = 1 << 17  #: that are looked at; some writers leave remarks behind the end
_LAST_OF_NAME = {
    ".nc": re.compile(rb"^[ \t]*EN[ \t\x1a]*$", re.MULTILINE | re.IGNORECASE),
    ".ifc": re.compile(rb"END-ISO-10303-21\s*;"),
    ".ifczip": re.compile(rb"PK\x05\x06"),  # end of the directory, PKWARE APPNOTE 4.3.16
    ".json": re.compile(rb"[}\]]\s*$"),
    ".dxf": re.compile(rb"(?:^|\n)[ \t]*0\s*\n\s*EOF[\s\x1a]*$"),
    ".svg": re.compile(rb"(?:/|</(?:[\w.-]+:)?svg\s*)>(?:\s|<!--.*?-->|<\?.*?\?>)*$", re.DOTALL),
}
#: A DXF of bytes: its beginning, and the value EOF of its last group.
_BINARY_DXF = b"AutoCAD Binary DXF\r\n\x1a\0"
_BINARY_EOF = re.compile(rb"\0\0EOF\0+$")
_COMMENT = re.compile(rb"<!--.*?-->", re.DOTALL)
_SVG_TAG = re.compile(rb"<(/?)(?:[\w.-]+:)?svg\b[^>]*?(/?)>")
_LAST = {
    suffix: _LAST_OF_NAME.get(suffix, _LAST_OF_NAME.get(known.suffixes[0]))
    for known in FORMATS
    for suffix in known.suffixes
}


def has_end(path: str) -> bool:
    """Whether the end of a file's format stands in it; True of a format that has no certain end.

    A file that cannot be read counts as complete: its reader says what is wrong with it.
    """
    suffix = os.path.splitext(path)[1].lower()
    last = _LAST.get(suffix)
    if last is None:
        return True
    try:
        with open(path, "rb") as file:
            file.seek(max(0, file.seek(0, os.SEEK_END) - TAIL_BYTES))
            tail = file.read()
            file.seek(0)
            if suffix == ".dxf" and file.read(len(_BINARY_DXF)) == _BINARY_DXF:
                return _BINARY_EOF.search(tail) is not None
            if suffix != ".ifczip":
                tail = tail.replace(b"\0", b"").replace(b"\r", b"\n")  # of UTF-16, of old Macs
            if last.search(tail) is None:
                return False
            file.seek(0)
            torn = _TORN.get(suffix)
            return torn is None or not torn(file.read())
    except OSError:
        return True


def _is_torn(text: bytes) -> bool:
    """Whether a JSON text ends before its outermost bracket is closed."""
    try:
        msgspec.json.decode(text, type=msgspec.Raw)
    except msgspec.DecodeError as error:
        return "truncated" in str(error)
    return False


def _is_unclosed(drawing: bytes) -> bool:
    """Whether an SVG ends within its outermost element; drawings may stand in each other."""
    plain = _COMMENT.sub(b"", drawing.replace(b"\0", b""))
    tags = [(tag[1], tag[2]) for tag in _SVG_TAG.finditer(plain)]
    closed = sum(1 for closing, _ in tags if closing)
    opened = sum(1 for closing, alone in tags if not (closing or alone))
    return not tags or closed < opened or b"<!--" in plain


_TORN = {".json": _is_torn, ".svg": _is_unclosed}
