"""Readers: a file's bytes in, parts and diagnostics out. One module a format.

A reader is `read(data, name) -> Reading`; it opens no file, prints nothing and never raises for
bad input. `looks_like(data)` tells by the content whether the bytes are of its format.
"""

import os.path
import re
from collections.abc import Callable, Mapping
from importlib import import_module

from msgspec import Struct

from beamcam.caches import cached
from beamcam.errors import Diagnostic, Source
from beamcam.machine.names import is_of_programs
from beamcam.readers import rules
from beamcam.readers.content import Reading

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
        return Reading("unknown", (), (rules.EMPTY.at(Source(name)),))
    suffix = os.path.splitext(name)[1].lower()
    if corel := _coreldraw(data, suffix):
        return Reading("unknown", (), (rules.CORELDRAW.at(Source(name), found=corel),))
    if (other := other_format(data, name)) is not None:
        return Reading("unknown", (), (other,))
    if _is_program(data, name):
        return Reading("unknown", (), (rules.PROGRAM.at(Source(name)),))
    for known in FORMATS:
        if suffix in known.suffixes:
            return _read_as(known, data, name, options)
    for known in FORMATS:
        if known.looks_like(data):
            return _read_as(known, data, name, options)
    known_suffixes = ", ".join(s for f in FORMATS for s in f.suffixes)
    return Reading("unknown", (), (rules.UNKNOWN_FORMAT.at(Source(name), expected=known_suffixes),))


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
    return rules.OTHER_FORMAT.at(Source(name), found=other[0], expected=other[1])


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
    found = known.read(data, name, **taken)
    tube = options.get("wrap")
    if tube is None or known.name not in ("dxf", "svg") or found.refused:
        return found
    from beamcam.readers.drawing.wrap import wrapped

    return wrapped(found, str(tube))
