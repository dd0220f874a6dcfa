"""Bytes to a drawing: the plain entities of model space as they stand, the rest by ezdxf."""

import io
import logging
import re
from collections.abc import Iterable
from contextlib import suppress

import numpy as np
from msgspec import Struct
from msgspec.structs import replace

from beamcam.errors import Diagnostic, ReadError, Source
from beamcam.readers.dxf import plain, rules
from beamcam.readers.dxf.layers import (
    HANDLE,
    SUBCLASS,
    Attributes,
    Document,
    Rows,
    Tables,
    rows_of,
    tables_by_rows,
    tables_of,
)
from beamcam.readers.dxf.repair import VERSION, is_sound, message_of, recovered, with_subclasses

UTF8 = 1021  #: and above: files in UTF-8, whatever code page they name
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


class Plain(Struct, frozen=True, gc=False):
    """A plain entity and its numbers, as the function of `curves` for its kind takes them."""

    kind: str
    handle: str | None
    attributes: Attributes
    values: plain.Values


Run = list[Plain]  #: plain entities that follow one another


class Taken(Struct, frozen=True):
    """Plain entities of a file and the text of the rest, with a marker for each run."""

    runs: tuple[Run, ...]
    rest: str
    owners: frozenset[str]  #: the layouts that the entities say they stand in
    tables: Tables | None = None  #: where nothing else is drawn, and ezdxf has nothing to say


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
        if is_binary(data):
            from ezdxf.document import Drawing
            from ezdxf.lldxf.tagger import binary_tags_loader

            loaded = _of_document(Drawing.load(binary_tags_loader(data)), handles)
        else:
            loaded = _load_text(data, handles)
    # ezdxf lets errors of every kind pass through for damaged files (ValueError, KeyError,
    # AttributeError of half-read entities): whatever it is, the file is not sound.
    except Exception as error:
        if is_binary(data):
            raise ReadError(rules.STRUCTURE.at(source, found=message_of(error))) from error
        loaded = _repaired(data, handles, source, error)
    return replace(loaded, remarks=(*remarks, *loaded.remarks))


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


def _of_document(document: Document, handles: bool, runs: tuple[Run, ...] = ()) -> Loaded:
    return Loaded(document, tables_of(document), runs, handles)


def _load_text(data: bytes, handles: bool) -> Loaded:
    """The document, without the plain entities of model space where they can be taken apart."""
    data = data.removeprefix(b"\xef\xbb\xbf")
    named = VERSION.search(data)
    if named is not None and (data.isascii() or int(named[1]) >= UTF8):
        version, encoding = f"AC{named[1].decode()}", "utf-8"
    else:  # that of its code page
        from ezdxf.filemanagement import dxf_stream_info

        info = dxf_stream_info(_text(data, "utf-8", "ignore"))
        version, encoding = info.version, info.encoding
    text = _text(data, encoding, "surrogateescape").read()
    taken = take_plain(text, version, handles)
    if taken is not None and taken.tables is not None:
        return Loaded(None, taken.tables, taken.runs, handles)
    from ezdxf.filemanagement import read

    if taken is not None:
        # Where the file is not sound, ezdxf shall say so of the whole of it.
        with suppress(Exception):
            document = read(io.StringIO(taken.rest))
            owners = {document.modelspace().layout_key}
            if document.loaded_dxfversion == version and taken.owners <= owners:
                return _of_document(document, handles, taken.runs)
    return _of_document(read(io.StringIO(text)), handles)


def _text(data: bytes, encoding: str, errors: str) -> io.TextIOWrapper:
    return io.TextIOWrapper(io.BytesIO(data), encoding=encoding, errors=errors)


def _repaired(data: bytes, handles: bool, source: Source, first: Exception) -> Loaded:
    """The document of a file that ezdxf does not read as it stands, and what was done to it.

    Raises ReadError if nothing helps.
    """
    marked, count = with_subclasses(data)
    remarks = (rules.SUBCLASSES.at(source, count=count),) if count else ()
    if count:
        try:
            return replace(_load_text(marked, handles), remarks=remarks)
        except Exception as error:  # as above: any kind of error means that it is damaged besides
            first = error
    document, repair = recovered(marked if count else data, source, first)
    return replace(_of_document(document, handles), remarks=(*remarks, repair))


# --- plain entities -------------------------------------------------------------------------------

# The plain entities of model space taken out of a file, and the rest of it for ezdxf.
#
# Where plain entities follow one another in the section ENTITIES, a marker takes their place, so
# that the rest is a sound file and everything keeps its order. What might connect a plain entity
# with the rest by its name, or by where it stands, leaves the whole file to ezdxf.


_R12 = "AC1009"

#: The kind of entity that marks plain entities in the remainder of a file.
MARKER = "BEAMCAM_PLAIN_ENTITIES"

#: Group codes of names: of entities, and of dimension styles.
_NAMES = (HANDLE, 105)


def take_plain(text: str, version: str, named: bool) -> Taken | None:
    """The plain entities of model space and the rest; None if the file is one for ezdxf.

    Lines of `text` end in "\\n". `named` tells whether entities have names of their own (handles).
    """
    rows = rows_of(text)
    entities = rows.sections.get("ENTITIES") if rows is not None else None
    if rows is None or entities is None or MARKER in text:
        return None
    blocks = rows.sections.get("BLOCKS", range(0))
    if named and not _all_named(rows, (*entities, *blocks)):
        return None
    taker = _Taker(rows, version <= _R12)
    taker.take(entities)
    if taker.odd or not taker.runs or taker.has_names_of_others():
        return None
    owners = frozenset(taker.owners - {plain.UNSAID})
    is_whole = sum(map(len, taker.runs)) == len(entities)
    tables = tables_by_rows(rows, version <= _R12) if is_whole and is_sound(rows, version) else None
    if tables is not None and not owners <= {tables.model_space}:
        tables = None
    return Taken(tuple(taker.runs), taker.rest() if tables is None else "", owners, tables)


def _codes(sequence: bytes) -> plain.Codes:
    return tuple(np.frombuffer(sequence, np.int32).tolist())


def _all_named(rows: Rows, entities: Iterable[int]) -> bool:
    """Whether every entity has a handle above its subclasses; ends of blocks need none."""
    seen: dict[bytes, bool] = {}
    for first, _, sequence in rows.sequences(entities):
        if sequence not in seen:
            codes = _codes(sequence)
            head = codes[: codes.index(SUBCLASS)] if SUBCLASS in codes else codes
            seen[sequence] = HANDLE in head
        if not seen[sequence] and rows.value(first) not in ("BLOCK", "ENDBLK"):
            return False
    return True


class _Taker:
    """The entities taken so far, and their places."""

    def __init__(self, rows: Rows, r12: bool) -> None:
        self.rows = rows
        self.r12 = r12
        self.runs: list[Run] = []
        self.odd = False  #: whether a plain entity is where none is allowed
        self.owners: set[str] = set()
        self._spans: list[tuple[int, int]] = []  #: first row of each run, and the row behind it
        self._attributes: dict[plain.Texts, Attributes] = {}

    def take(self, entities: Iterable[int]) -> None:
        """Take those of the entities that are plain."""
        lines = self.rows.lines
        plans: dict[tuple[str, bytes], plain.ValuePlaces | None] = {}
        goes_on = False  # whether the entity before goes on in the one that follows
        for first, last, sequence in self.rows.sequences(entities):
            row = lines[2 * first + 1 : 2 * last : 2]
            key = (row[0], sequence)
            try:
                plan = plans[key]
            except KeyError:
                plan = plans[key] = plain.plan_of(row[0], _codes(sequence), self.r12)
            entity = None if plan is None else self._read(plan, row)
            if entity is None:  # do its vertices or attributes follow, up to a SEQEND?
                goes_on = row[0] in ("POLYLINE", "VERTEX", "ATTRIB")
                if row[0] == "INSERT":
                    codes = _codes(sequence)
                    goes_on = 66 in codes and row[codes.index(66)].strip() != "0"
                continue
            self.odd |= goes_on
            begun, behind = self._spans[-1] if self._spans else (0, 0)
            if behind == first:
                self._spans[-1] = begun, last
            else:
                self._spans.append((first, last))
                self.runs.append([])
            self.runs[-1].append(entity)

    def _read(self, plan: plain.ValuePlaces, row: list[str]) -> Plain | None:
        row += plain.BEYOND
        texts = plan.attributes(row)
        try:
            attributes = self._attributes.get(texts)
            if attributes is None:
                attributes = self._attributes[texts] = plain.attributes_from(*texts)
            values = plan.read(row)
        except (ValueError, ArithmeticError):
            return None
        self.owners.add(row[plan.owner])
        handle = None if plan.handle == plain.NOT_SAID else row[plan.handle]
        return Plain(row[0], handle, attributes, values)

    def has_names_of_others(self) -> bool:
        """Whether anything in the rest of the file has the handle of a plain entity."""
        handles = {entity.handle for run in self.runs for entity in run}
        names = np.isin(self.rows.codes, _NAMES)
        for first, last in self._spans:
            names[first:last] = False
        return any(self.rows.value(row) in handles for row in np.flatnonzero(names).tolist())

    def rest(self) -> str:
        """The text of the rest, with a marker for each run."""
        lines = self.rows.lines
        pieces: list[str] = []
        kept = 0
        for first, last in self._spans:
            pieces += lines[2 * kept : 2 * first]
            pieces += ("0", MARKER)
            kept = last
        return "\n".join((*pieces, *lines[2 * kept :], ""))
