"""Readers: a file's bytes in, parts and diagnostics out. One module a format.

A reader is `read(data, name) -> Reading`; it opens no file, prints nothing and never raises for
bad input. `looks_like(data)` tells by the content whether the bytes are of its format.
"""

import os.path
from collections.abc import Callable, Mapping
from importlib import import_module

from msgspec import Struct

from beamcam.caches import cached
from beamcam.errors import Source
from beamcam.readers import rules
from beamcam.readers.reading import Reading

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
    go to a reader that takes them (units, width, layers and fit of a drawing).
    """
    if not data or data.isspace():
        return Reading("unknown", (), (rules.EMPTY.at(Source(name)),))
    suffix = os.path.splitext(name)[1].lower()
    if corel := _coreldraw(data, suffix):
        return Reading("unknown", (), (rules.CORELDRAW.at(Source(name), found=corel),))
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


def _read_as(known: Format, data: bytes, name: str, options: Mapping[str, object]) -> Reading:
    taken = {k: v for k, v in options.items() if k in known.options and v is not None}
    return known.read(data, name, **taken)
