"""Bytes to an ezdxf document: text or binary, sound or in need of repair.

Subclass markers (group 100) put into polylines and splines that were written without them.

    0 LWPOLYLINE | 5 1F | 8 0 | 90 4 | 10 ...
    0 LWPOLYLINE | 5 1F | 100 AcDbEntity | 8 0 | 100 AcDbPolyline | 90 4 | 10 ...

Programs that read DXF by group codes alone take the one for the other; ezdxf looks for the markers.
In a file of R12, which has none, it takes what all entities have from what stands before the first.
"""

import io
import logging
import re
from itertools import takewhile
from typing import Any

from msgspec import Struct

from beamcam.errors import Diagnostic, ReadError, Source
from beamcam.readers.drawing import MM_PER_UNIT, UNITS_OPTION
from beamcam.readers.dxf import rules
from beamcam.readers.dxf.bulk import Run, Taken, take_plain
from beamcam.readers.dxf.layers import Document, Tables, tables_of

#: The class that a marker names, of the entities that ezdxf refuses without it.
MARKERS = {b"LWPOLYLINE": b"AcDbPolyline", b"SPLINE": b"AcDbSpline"}
#: Groups of every entity. Source: Autodesk DXF reference, "Common group codes for entities".
IDENTITY = frozenset((b"5", b"330", b"360"))
COMMON = frozenset(
    (b"8", b"6", b"48", b"60", b"62", b"67", b"347", b"370", b"380", b"390", b"410", b"420",
     b"430", b"440", b"284")
)  # fmt: skip
R12 = 1009  #: and below: files without subclasses
UTF8 = 1021  #: and above: files in UTF-8, whatever code page they name
_VERSION = re.compile(rb"\$ACADVER\s+1\s+AC(\d{4})")
Group = tuple[bytes, bytes]  #: code and value


def with_subclasses(data: bytes) -> tuple[bytes, int]:
    """The text of a DXF file with the markers that were missing, and of how many entities."""
    lines = [line.strip(b"\r") for line in data.replace(b"\r\n", b"\n").split(b"\n")]
    groups = [(lines[k].strip(), lines[k + 1]) for k in range(0, len(lines) - 1, 2)]
    version = _VERSION.search(data)
    is_old = version is None or int(version[1]) <= R12
    found: list[Group] = []
    count = k = 0
    while k < len(groups):
        found.append(groups[k])
        code, value = groups[k]
        k += 1
        marker = MARKERS.get(value.strip()) if code == b"0" else None
        if marker is None:
            continue
        own = list(takewhile(lambda group: group[0] != b"0", groups[k:]))
        k += len(own)
        if any(c == b"100" and v.strip() == marker for c, v in own):
            found += own
        else:
            found += _marked(own, marker, is_old)
            count += 1
    return b"".join(b"%b\n%b\n" % group for group in found), count


def _marked(own: list[Group], marker: bytes, is_old: bool) -> list[Group]:
    """The groups of an entity with both of its markers, each behind it what belongs to it."""
    identity: list[Group] = []
    common: list[Group] = []
    rest: list[Group] = []
    in_brackets = False
    for code, value in own:
        if code == b"102":  # names of objects that want to hear of changes
            in_brackets = value.strip().startswith(b"{")
            identity.append((code, value))
        elif in_brackets or code in IDENTITY:
            identity.append((code, value))
        elif code != b"100":
            (common if code in COMMON else rest).append((code, value))
    first = (b"100", b"AcDbEntity")
    head = [*identity, *common, first] if is_old else [*identity, first, *common]
    return [*head, (b"100", marker), *rest]


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
    """A drawing and remarks on how it was read."""

    document: Document | None  #: None where all of model space is one run
    tables: Tables
    runs: tuple[Run, ...]  #: what stood at the markers in the document
    handles: bool  #: whether the file names its entities; ezdxf invents names where it does not
    remarks: tuple[Diagnostic, ...] = ()


def looks_like(data: bytes) -> bool:
    """Whether the bytes begin as a DXF file, text or binary, or as a DWG file (to refuse it)."""
    head = data[:4096].removeprefix(b"\xef\xbb\xbf")
    return head.startswith(BINARY_MARK) or bool(_START.match(head) or _DWG.match(head))


def is_binary(data: bytes) -> bool:
    return data.startswith(BINARY_MARK)


def load_document(data: bytes, source: Source) -> Loaded:
    """The document in `data`. Raises ReadError where there is none, or only the start of one."""
    if _DWG.match(data):
        raise ReadError(rules.DWG.at(source, found=data[:6].decode("ascii")))
    remarks = _check_end(data, source)
    handles = is_binary(data) or bool(_HANDLE.search(data))
    logging.getLogger("ezdxf").addHandler(_SILENT)
    try:
        drawing = _load_binary(data) if is_binary(data) else _load_text(data, handles)
    # ezdxf lets errors of every kind pass through for damaged files (ValueError, KeyError,
    # AttributeError of half-read entities): whatever it is, the file is not sound.
    except Exception as error:
        if is_binary(data):
            raise ReadError(rules.STRUCTURE.at(source, found=_said(error))) from error
        drawing, repairs = _repaired(data, handles, source, error)
        remarks = (*remarks, *repairs)
    return Loaded(*drawing, handles, remarks)


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


#: A document, its tables, and what stood at the markers in it.
_Drawing = tuple[Document | None, Tables, tuple[Run, ...]]


def _load_text(data: bytes, handles: bool) -> _Drawing:
    """The document, without the plain entities of model space where they can be taken apart."""
    data = data.removeprefix(b"\xef\xbb\xbf")
    version, encoding = _version_and_encoding(data)
    text = _text(data, encoding, "surrogateescape").read()
    taken = take_plain(text, version, handles)
    if taken is not None and taken.tables is not None:
        return None, taken.tables, taken.runs
    document = _rest(taken, version) if taken is not None else None
    if taken is not None and document is not None:
        return document, tables_of(document), taken.runs
    from ezdxf.filemanagement import read

    document = read(io.StringIO(text))
    return document, tables_of(document), ()


def _version_and_encoding(data: bytes) -> tuple[str, str]:
    """The version of a text, "AC1015", and the encoding that belongs to it or to its code page."""
    said = _VERSION.search(data)
    if said is not None and (data.isascii() or int(said[1]) >= UTF8):
        return f"AC{said[1].decode()}", "utf-8"
    from ezdxf.filemanagement import dxf_stream_info

    info = dxf_stream_info(_text(data, "utf-8", "ignore"))
    return info.version, info.encoding


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


def _load_binary(data: bytes) -> _Drawing:
    from ezdxf.document import Drawing
    from ezdxf.lldxf.tagger import binary_tags_loader

    document = Drawing.load(binary_tags_loader(data))
    return document, tables_of(document), ()


def _repaired(
    data: bytes, handles: bool, source: Source, first: Exception
) -> tuple[_Drawing, tuple[Diagnostic, ...]]:
    """The document of a file that ezdxf does not read as it stands, and what was done to it.

    Raises ReadError if nothing helps.
    """
    marked, count = with_subclasses(data)
    remarks = (rules.SUBCLASSES.at(source, count=count),) if count else ()
    if count:
        try:
            return _load_text(marked, handles), remarks
        except Exception as error:  # as above: any kind of error means that it is damaged besides
            first = error
    document, repair = _recover(marked if count else data, source, first)
    return (document, tables_of(document), ()), (*remarks, repair)


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


# --- units ----------------------------------------------------------------------------------------

# Unit of length of a DXF file, from its own data.
#
# ezdxf invents `$INSUNITS` 6 (metres) for files without a header, so that the raw text is asked.


#: Name and mm of the values of $INSUNITS. Source: Autodesk DXF reference, HEADER section. Those
#: of astronomy (17 to 20) are left out.
INSUNITS: dict[int, tuple[str, float]] = {
    1: ("inches", 25.4),
    2: ("feet", 304.8),
    3: ("miles", 1_609_344.0),
    4: ("mm", 1.0),
    5: ("cm", 10.0),
    6: ("metres", 1000.0),
    7: ("km", 1_000_000.0),
    8: ("microinches", 25.4e-6),
    9: ("mils", 0.0254),
    10: ("yards", 914.4),
    11: ("angstroms", 1e-7),
    12: ("nm", 1e-6),
    13: ("microns", 0.001),
    14: ("dm", 100.0),
    15: ("dam", 10_000.0),
    16: ("hm", 100_000.0),
    21: ("US survey feet", 1200_000.0 / 3937),
    22: ("US survey inches", 100_000.0 / 3937),
    23: ("US survey yards", 3600_000.0 / 3937),
    24: ("US survey miles", 1200_000.0 / 3937 * 5280),
}

_NL = rb"[ \t]*(?:\r\n|\r|\n)[ \t]*"


class LengthUnit(Struct, frozen=True):
    """The unit of a drawing's numbers."""

    name: str
    mm: float
    given: bool = False  #: by the user: what the file says about it does not count


def header_number(data: bytes, variable: str) -> int | None:
    """The whole number that the header gives to `variable` (group 70); None if it does not.

    Of a number of more digits than any variable has the first nine.
    """
    name = re.escape(variable.encode("ascii"))
    if is_binary(data):
        # Group codes are two bytes since R13, and the values of group 70 too.
        match = re.search(rb"\x09\x00" + name + rb"\x00\x46\x00(..)", data, re.DOTALL)
        return None if match is None else int.from_bytes(match[1], "little", signed=True)
    end = data.find(b"ENDSEC")
    text = data[: end if end >= 0 else len(data)]
    match = re.search(
        rb"(?:^|[\r\n])[ \t]*9" + _NL + name + _NL + rb"70" + _NL + rb"(-?\d{1,9})", text
    )
    return None if match is None else int(match[1])


def find_unit(
    data: bytes, units: str | None, source: Source
) -> tuple[LengthUnit | None, tuple[Diagnostic, ...]]:
    """The unit of a file, or the one that the user gave; None with an error if there is none."""
    if units is not None:
        mm = MM_PER_UNIT.get(units.lower())
        if mm is None:
            expected = ", ".join(MM_PER_UNIT)
            return None, (UNITS_OPTION.at(source, found=units, expected=expected),)
        return LengthUnit(units.lower(), mm, given=True), ()
    code = header_number(data, "$INSUNITS")
    if code is None or code == 0:
        return LengthUnit("mm", 1.0), (rules.UNITS_MISSING.at(source, found=_missing(data, code)),)
    if code not in INSUNITS:
        expected = ", ".join(f"{c} {name}" for c, (name, _) in INSUNITS.items() if c <= 6)
        return None, (rules.UNITS_UNKNOWN.at(source, found=code, expected=expected),)
    unit = LengthUnit(*INSUNITS[code])
    shown = header_number(data, "$LUNITS")
    if shown in (3, 4) and unit.mm not in (25.4, 304.8):
        return unit, (rules.UNITS_IMPERIAL.at(source, found=shown, unit=unit.name),)
    return unit, ()


def _missing(data: bytes, code: int | None) -> str:
    text = "no $INSUNITS" if code is None else "$INSUNITS 0 (no unit)"
    if header_number(data, "$MEASUREMENT") == 0:
        return text + " but $MEASUREMENT 0 (inches)"
    return text


# --- what dimensions say --------------------------------------------------------------------------

_STATED = re.compile(r"(\d+(?:[.,]\d+)?)\s*(mm|cm|m|inch(?:es)?|in|ft|\"|″|')\.?\Z", re.IGNORECASE)
_WORDS = {"inch": 25.4, "inches": 25.4, '"': 25.4, "″": 25.4, "'": 304.8}
_FORMATTING = re.compile(r"\\[A-Za-z][^;\\]*;|[{}]")


def contradictions(
    document: Document | None, unit: LengthUnit, name: str
) -> tuple[Diagnostic, ...]:
    """An error for the first dimension that names a length in a unit which denies `unit`.

    A dimension measures in drawing units and may show its length with a unit, written by hand
    ("100 mm") or appended by its style. If both differ by the factor between two units, the
    drawing was scaled or its header is wrong. Other differences are no matter of units.
    """
    if unit.given or document is None:
        return ()
    for dimension in document.modelspace().query("DIMENSION"):
        stated = _stated_length(dimension)
        if stated is None:
            continue
        text, length, measured = stated
        size = measured * unit.mm
        if size > 0.0 and _is_unit_factor(length / size):
            return (
                rules.UNITS_CONTRADICT.at(
                    Source(name, None, dimension.dxf.handle),
                    stated=text,
                    measured=measured,
                    unit=unit.name,
                    size=size,
                ),
            )
    return ()


def _stated_length(dimension: Any) -> tuple[str, float, float] | None:
    """Text, mm that it states, and measure in drawing units; None if it names no unit."""
    measured = dimension.dxf.get("actual_measurement")
    if not measured or not 0.0 < measured < 1e9:
        return None
    text = _FORMATTING.sub("", dimension.dxf.get("text", "") or "<>").strip()
    if "<>" in text:
        style = dimension.override()
        shown = measured * float(style.get("dimlfac", 1.0) or 1.0)
        post = str(style.get("dimpost", "") or "")
        text = text.replace("<>", (post if "<>" in post else "<>" + post))
        text = text.replace("<>", f"{shown:.9f}")
    match = _STATED.match(text)
    if match is None:
        return None
    word = match[2].lower()
    mm = _WORDS.get(word) or MM_PER_UNIT[word]
    return text, float(match[1].replace(",", ".")) * mm, measured


def _is_unit_factor(factor: float) -> bool:
    sizes = (1.0, 10.0, 25.4, 304.8, 1000.0)
    known = {a / b for a in sizes for b in sizes if a != b}
    return any(abs(factor / k - 1.0) < 0.01 for k in known)
