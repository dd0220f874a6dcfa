"""Bytes to an ezdxf document: text or binary, sound or in need of repair."""

import io
import logging
import re

from msgspec import Struct

from beamcam.errors import Diagnostic, ReadError, Source
from beamcam.readers.dxf import rules
from beamcam.readers.dxf.bulk import Run, Taken, take_plain
from beamcam.readers.dxf.layers import Document
from beamcam.readers.dxf.subclasses import with_subclasses

#: Without a handler, Python would print what ezdxf logs.
_SILENT = logging.NullHandler()

BINARY_MARK = b"AutoCAD Binary DXF\r\n\x1a\x00"
_DWG = re.compile(rb"AC1\.\d|AC10\d\d")
# Comments (group 999) and the first group. Nothing here gives back what it took: a file of line
# ends would otherwise be tried in each way in which they can be parted.
_LINE_END = rb"(?:\r*+\n|\r)"
_START = re.compile(
    rb"(?:\s*+999[^\r\n]*+" + _LINE_END + rb"[^\r\n]*+" + _LINE_END + rb")*+"
    rb"\s*+0[ \t]*+[\r\n]\s*+SECTION\b"
)
# Group 5 holds the handle of an entity, a hexadecimal number; R12 may go without.
_HANDLE = re.compile(rb"[\r\n][ \t]*5[ \t]*(?:\r\n|\r|\n)[ \t]*[0-9A-Fa-f]+[ \t]*[\r\n]")

_EOF = re.compile(rb"[\r\n][ \t]*0[ \t]*(?:\r\n|\r|\n)[ \t]*EOF[ \t]*(?:[\r\n\x1a\x00]|\Z)")
NEAR_THE_END = 1000  #: bytes in which EOF is looked for first; nearly all files have it there


class Loaded(Struct, frozen=True):
    """A document and remarks on how it was read."""

    document: Document
    handles: bool  #: whether the file names its entities; ezdxf invents names where it does not
    runs: tuple[Run, ...] = ()  #: what stood at the markers in the document
    remarks: tuple[Diagnostic, ...] = ()


def looks_like(data: bytes) -> bool:
    """Whether the bytes begin as a DXF file, text or binary, or as a DWG file (to refuse it)."""
    head = data[:4096].removeprefix(b"\xef\xbb\xbf")
    return head.startswith(BINARY_MARK) or bool(_START.match(head) or _DWG.match(head))


def is_binary(data: bytes) -> bool:
    return data.startswith(BINARY_MARK)


def load(data: bytes, source: Source) -> Loaded:
    """The document in `data`. Raises ReadError where there is none, or only the start of one."""
    if _DWG.match(data):
        raise ReadError(rules.DWG.at(source, found=data[:6].decode("ascii")))
    remarks = _check_end(data, source)
    handles = is_binary(data) or bool(_HANDLE.search(data))
    logging.getLogger("ezdxf").addHandler(_SILENT)
    try:
        document, runs = _load_binary(data) if is_binary(data) else _load_text(data, handles)
    # ezdxf lets errors of every kind pass through for damaged files (ValueError, KeyError,
    # AttributeError of half-read entities): whatever it is, the file is not sound.
    except Exception as error:
        if is_binary(data):
            raise ReadError(rules.STRUCTURE.at(source, found=_said(error))) from error
        document, runs, repairs = _repaired(data, handles, source, error)
        remarks = (*remarks, *repairs)
    return Loaded(document, handles, runs, remarks)


def _check_end(data: bytes, source: Source) -> tuple[Diagnostic, ...]:
    """A warning where EOF is missing behind a whole section.

    Raises ReadError where more is missing, and for what begins as no DXF file does.
    """
    if not looks_like(data):
        raise ReadError(rules.NOT_DXF.at(source, found=data[:20].decode("latin-1").split("\n")[0]))
    if is_binary(data):
        if data.rstrip(b"\x00\x1a\r\n").endswith(b"EOF"):
            return ()
        raise ReadError(rules.TRUNCATED.at(source, found="binary data"))
    if _EOF.search(data, max(0, len(data) - NEAR_THE_END)) or _EOF.search(data):
        return ()
    last = data.rstrip().splitlines()[-1:] or [b""]
    if last[0].strip() == b"ENDSEC":
        return (rules.NO_EOF.at(source),)
    raise ReadError(rules.TRUNCATED.at(source, found=last[0].decode("latin-1").strip()))


def _load_text(data: bytes, handles: bool) -> tuple[Document, tuple[Run, ...]]:
    """The document, without the plain entities of model space where they can be taken apart."""
    from ezdxf.filemanagement import dxf_stream_info, read

    data = data.removeprefix(b"\xef\xbb\xbf")
    info = dxf_stream_info(_text(data, "utf-8", "ignore"))
    text = _text(data, info.encoding, "surrogateescape").read()
    taken = take_plain(text, info.version, handles)
    document = _rest(taken, info.version) if taken is not None else None
    if taken is None or document is None:
        return read(io.StringIO(text)), ()
    return document, taken.runs


def _rest(taken: Taken, version: str) -> Document | None:
    """The document of what plain entities leave; None if these are not all of model space's."""
    from ezdxf.filemanagement import read

    try:
        document = read(io.StringIO(taken.rest))
    except Exception:  # the file is not sound: ezdxf shall say so of the whole of it
        return None
    owners = {document.modelspace().layout_key}
    return document if document.loaded_dxfversion == version and taken.owners <= owners else None


def _text(data: bytes, encoding: str, errors: str) -> io.TextIOWrapper:
    return io.TextIOWrapper(io.BytesIO(data), encoding=encoding, errors=errors)


def _load_binary(data: bytes) -> tuple[Document, tuple[Run, ...]]:
    from ezdxf.document import Drawing
    from ezdxf.lldxf.tagger import binary_tags_loader

    return Drawing.load(binary_tags_loader(data)), ()


def _repaired(
    data: bytes, handles: bool, source: Source, first: Exception
) -> tuple[Document, tuple[Run, ...], tuple[Diagnostic, ...]]:
    """The document of a file that ezdxf does not read as it stands, and what was done to it.

    Raises ReadError if nothing helps.
    """
    marked, count = with_subclasses(data)
    told = (rules.SUBCLASSES.at(source, count=count),) if count else ()
    if count:
        try:
            return *_load_text(marked, handles), told
        except Exception as error:  # as above: any kind of error means that it is damaged besides
            first = error
    document, repair = _recover(marked if count else data, source, first)
    return document, (), (*told, repair)


def _recover(data: bytes, source: Source, first: Exception) -> tuple[Document, Diagnostic]:
    """The document as far as it can be repaired. Raises ReadError if it cannot."""
    from ezdxf import recover

    try:
        document, auditor = recover.read(io.BytesIO(data))
    except Exception as error:  # as above: any kind of error means that repair failed
        raise ReadError(rules.STRUCTURE.at(source, found=_said(error))) from error
    count = len(auditor.errors) + len(auditor.fixes)
    return document, rules.RECOVERED.at(source, count=count, found=_said(first))


def _said(error: Exception) -> str:
    """One line that says what ezdxf stumbled over; ids of unread entities are left out, since
    they are addresses in memory and differ from run to run."""
    text = re.sub(r"\(#\d{9,}\)", "", " ".join(str(error).split()))
    return text[:160] or type(error).__name__
