"""Readers: a file's bytes in, parts and diagnostics out. One module a format.

A reader is `read(data, name) -> Reading`; it opens no file, prints nothing and never raises for
bad input. `looks_like(data)` tells by the content whether the bytes are of its format.

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
import os.path
import re
from collections.abc import Callable, Mapping
from importlib import import_module

import msgspec
from msgspec import Struct

from beamcam.caches import cached
from beamcam.errors import Diagnostic, Source
from beamcam.machine import is_of_programs
from beamcam.readers.content import CORELDRAW, EMPTY, OTHER_FORMAT, PROGRAM, UNKNOWN_FORMAT, Reading

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
    Format("dstv", (".nc", ".nc1"), "beamcam.readers.dstv", ("encoding",)),
    Format("dxf", (".dxf",), "beamcam.readers.dxf", ("units", "layers", "fit", "letters")),
    Format("svg", (".svg",), "beamcam.readers.svg", ("units", "width", "layers", "fit")),
    Format("ifc", (".ifc", ".ifczip"), "beamcam.readers.ifc", ("selection", "options", "progress")),
    Format("part-json", (".json",), "beamcam.readers.part_json"),
)


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
    if _is_program(data, name):
        return Reading("unknown", (), (PROGRAM.at(Source(name)),))
    for known in FORMATS:
        if suffix in known.suffixes:
            return _read_as(known, data, name, options)
    for known in FORMATS:
        if known.looks_like(data):
            return _read_as(known, data, name, options)
    known_suffixes = ", ".join(s for f in FORMATS for s in f.suffixes)
    return Reading("unknown", (), (UNKNOWN_FORMAT.at(Source(name), expected=known_suffixes),))


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
    other = _other_format(data, os.path.splitext(name)[1].lower())
    if other is None:
        return None
    return OTHER_FORMAT.at(Source(name), found=other[0], expected=other[1])


def _other_format(data: bytes, suffix: str) -> tuple[str, str] | None:
    if any(suffix in known.suffixes for known in FORMATS):
        return None  # the reader of that suffix says what is wrong with it
    schema = _SCHEMA.search(data, 0, _HEAD_BYTES) if data[:13] == b"ISO-10303-21;" else None
    if schema is not None and not schema[1].upper().startswith(b"IFC"):
        name = schema[1].split()[0].decode("ascii", "replace")
        return f"a STEP model ({name})", "the model exported as IFC, or its parts as DSTV"
    if data.startswith(b"PK\3\4") and (b"word/" in data or b"xl/" in data):
        return "a document of Office", _PARTS
    return next(
        ((what, expected) for begin, what, expected in _BEGINNINGS if data.startswith(begin)), None
    )


def _is_program(data: bytes, name: str) -> bool:
    """Whether bytes are a machine's program: by its suffix and content, and no reader knows it."""
    suffix = os.path.splitext(name)[1].lower()
    if not is_of_programs(name) and suffix != ".nc":
        return False
    is_one = b"BEAMCAM" in data[:1024] or _G_CODE.search(data, 0, _HEAD_BYTES) is not None
    return is_one and not any(known.looks_like(data) for known in FORMATS)


def _read_as(known: Format, data: bytes, name: str, options: Mapping[str, object]) -> Reading:
    taken = {k: v for k, v in options.items() if k in known.options and v is not None}
    reading = known.read(data, name, **taken)
    tube = options.get("wrap")
    if tube is None or known.name not in ("dxf", "svg") or reading.refused:
        return reading
    from beamcam.readers.drawing import wrapped

    return wrapped(reading, str(tube))


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
