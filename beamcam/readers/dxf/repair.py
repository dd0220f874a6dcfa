"""A DXF file that ezdxf does not read as it stands, repaired; and one that needs no ezdxf.

Subclass markers (group 100) put into polylines and splines that were written without them.

    0 LWPOLYLINE | 5 1F | 8 0 | 90 4 | 10 ...
    0 LWPOLYLINE | 5 1F | 100 AcDbEntity | 8 0 | 100 AcDbPolyline | 90 4 | 10 ...

Programs that read DXF by group codes alone take the one for the other; ezdxf looks for the markers.
In a file of R12, which has none, it takes what all entities have from what stands before the first.
"""

import io
import re
from binascii import unhexlify
from collections.abc import Callable
from functools import partial
from itertools import takewhile

import numpy as np

from beamcam.errors import Diagnostic, ReadError, Source
from beamcam.readers.dxf import rules
from beamcam.readers.dxf.layers import BRACKET, COMMENT, HANDLE, NAME, VARIABLE, Document, Rows

#: The class that a marker names, of the entities that ezdxf refuses without it.
MARKERS = {b"LWPOLYLINE": b"AcDbPolyline", b"SPLINE": b"AcDbSpline"}
#: Groups of every entity. Source: Autodesk DXF reference, "Common group codes for entities".
IDENTITY = frozenset((b"5", b"330", b"360"))
COMMON = frozenset(
    (b"8", b"6", b"48", b"60", b"62", b"67", b"347", b"370", b"380", b"390", b"410", b"420",
     b"430", b"440", b"284")
)  # fmt: skip
R12 = 1009  #: and below: files without subclasses
VERSION = re.compile(rb"\$ACADVER\s+1\s+AC(\d{4})")
Group = tuple[bytes, bytes]  #: code and value


def with_subclasses(data: bytes) -> tuple[bytes, int]:
    """The text of a DXF file with the markers that were missing, and of how many entities."""
    lines = [line.strip(b"\r") for line in data.replace(b"\r\n", b"\n").split(b"\n")]
    groups = [(lines[k].strip(), lines[k + 1]) for k in range(0, len(lines) - 1, 2)]
    version = VERSION.search(data)
    is_old = version is None or int(version[1]) <= R12
    marked: list[Group] = []
    count = k = 0
    while k < len(groups):
        marked.append(groups[k])
        code, value = groups[k]
        k += 1
        marker = MARKERS.get(value.strip()) if code == b"0" else None
        if marker is None:
            continue
        own = list(takewhile(lambda group: group[0] != b"0", groups[k:]))
        k += len(own)
        if any(c == b"100" and v.strip() == marker for c, v in own):
            marked += own
        else:
            marked += _marked(own, marker, is_old)
            count += 1
    return b"".join(b"%b\n%b\n" % group for group in marked), count


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


def recovered(data: bytes, source: Source, first: Exception) -> tuple[Document, Diagnostic]:
    """The document as far as it can be repaired. Raises ReadError if it cannot."""
    from ezdxf import recover

    try:
        document, auditor = recover.read(io.BytesIO(data))
    except Exception as error:  # as above: any kind of error means that repair failed
        raise ReadError(rules.STRUCTURE.at(source, found=message_of(error))) from error
    count = len(auditor.errors) + len(auditor.fixes)
    return document, rules.RECOVERED.at(source, count=count, found=message_of(first))


def message_of(error: Exception) -> str:
    """One line that says what ezdxf stumbled over; ids of unread entities are left out, since
    they are addresses in memory and differ from run to run."""
    text = re.sub(r"\(#\d{9,}\)", "", " ".join(str(error).split()))
    return text[:160] or type(error).__name__


# --- whether ezdxf has something to say -----------------------------------------------------------

# To import ezdxf takes longer than to read a small drawing. Where it has no entity to read, a file
# may do without it (`is_sound`) that has every section and table begun, ended and there once,
# numbers where numbers belong, and blocks without content. Of any other ezdxf says what is wrong,
# or repairs it; tests/property/test_dxf_plain_laws.py holds both ways equal.


#: The kinds of entities in sections; of the rest any. Source: Autodesk DXF reference.
_KINDS = {"HEADER": set[str](), "CLASSES": {"CLASS"}, "BLOCKS": {"BLOCK", "ENDBLK"}}
_SECTIONS = {*_KINDS, "TABLES", "ENTITIES", "OBJECTS", "THUMBNAILIMAGE"}
_TABLES = {
    "APPID", "BLOCK_RECORD", "DIMSTYLE", "LAYER", "LTYPE", "STYLE", "UCS", "VIEW", "VPORT",
}  # fmt: skip

# The types of values. Source: Autodesk DXF reference, "Group code value types".
_TYPES: tuple[tuple[Callable[[str], object], tuple[int, ...]], ...] = (
    (float, (*range(10, 60), *range(110, 150), *range(210, 240), *range(460, 470),
             *range(1010, 1060))),
    (int, (*range(60, 80), *range(90, 100), *range(160, 180), *range(270, 300), *range(370, 390),
           *range(400, 410), *range(420, 430), *range(440, 460), *range(1060, 1072))),
    (partial(int, base=16), (HANDLE, 105, *range(320, 370), *range(390, 400), 480, 481, 1005)),
    (unhexlify, (*range(310, 320), 1004)),
)  # fmt: skip
LAST_CODE = 1071
_X = (*range(10, 19), *range(110, 113), *range(210, 214), *range(1010, 1014))  #: Y is 10 more
_AFTER_X = tuple(range(1020, 1034))  #: Y and Z that may not stand alone


def is_sound(rows: Rows, version: str) -> bool:
    """Whether a file of a version is framed and filled as it should be, beside its entities."""
    sections, count = rows.sections, len(rows.starts)
    named = {k: name for name, inside in sections.items() for k in inside}
    marks = {inside.start - 1: "SECTION" for inside in sections.values()}
    marks |= {inside.stop: "ENDSEC" for inside in sections.values()}
    kinds = map(rows.kind, range(count - 1))
    blocks = [rows.kind(k) for k in sections.get("BLOCKS", ())]
    return (
        next(iter(sections), "") == "HEADER"
        and _SECTIONS.issuperset(sections)
        and "ENTITIES" in sections
        and all(
            kind == marks[k] if k in marks else k in named and kind in _KINDS.get(named[k], {kind})
            for k, kind in enumerate(kinds)
        )
        and blocks == ["BLOCK", "ENDBLK"] * (len(blocks) // 2)
        and [rows.kind(k) for k in sections.get("OBJECTS", ())][:1] in ([], ["DICTIONARY"])
        and _has_sound_tables(rows)
        and _version(rows) == version
        and _has_sound_values(rows)
    )


def _has_sound_tables(rows: Rows) -> bool:
    """Whether tables are begun and ended, each once, with entries of their kind."""
    left = set(_TABLES)
    table = ""
    for k in rows.sections.get("TABLES", ()):
        kind = rows.kind(k)
        if kind == "TABLE" and not table:
            begin = rows.starts[k] + 1
            table = rows.value(begin)
            if rows.codes[begin] != NAME or table not in left:
                return False
            left.remove(table)
        elif kind == "ENDTAB" and table:
            table = ""
        elif kind != table:
            return False
    return not table


def _version(rows: Rows) -> str:
    """The value of $ACADVER; empty if the header is not variables and their values."""
    begin, end = rows.starts[0] + 2, rows.starts[1]
    variables = [row for row in range(begin, end) if rows.codes[row] == VARIABLE]
    if variables[:1] != [begin]:
        return ""
    version = ""
    for row, behind in zip(variables, [*variables[1:], end], strict=True):
        is_point = rows.codes[row + 1] == 10 and behind - row in (3, 4)
        if not rows.value(row).startswith("$") or not (behind - row == 2 or is_point):
            return ""
        if rows.value(row) == "$ACADVER":
            version = rows.value(row + 1)
    return version


def _has_sound_values(rows: Rows) -> bool:
    """Whether values beside entities are of the type of their group, points and brackets whole."""
    entities = rows.sections["ENTITIES"]
    first, last = rows.starts[entities.start - 1], rows.starts[entities.stop]
    places = np.append(np.arange(first), np.arange(last, len(rows.codes)))
    codes = rows.codes[places]
    after, before = np.append(codes[1:], 0), np.append(0, codes[:-1])
    if (
        np.any((codes == COMMENT) | (codes < 0) | (codes > LAST_CODE))
        or np.any(np.isin(codes, _X) & (after != codes + 10))
        or np.any(np.isin(codes, _AFTER_X) & (before != codes - 10))
    ):
        return False
    brackets = places[codes == BRACKET]
    within = np.searchsorted(rows.starts, brackets)
    opens = [rows.value(row).startswith("{") for row in brackets.tolist()]
    if opens != [True, False] * (len(opens) // 2) or np.any(within[::2] != within[1::2]):
        return False
    try:
        for convert, kinds in _TYPES:
            for row in places[np.isin(codes, kinds)].tolist():
                convert(rows.value(row))
    except ValueError:
        return False
    return True
