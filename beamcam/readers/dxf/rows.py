"""The rows of a DXF file, a group code and a value each, and whether they are as they should be.

To import ezdxf takes longer than to read a small drawing. Where it has no entity to read, a file
may do without it (`is_sound`) that has every section and table begun, ended and there once, numbers
where numbers belong, and blocks without content. Of any other ezdxf says what is wrong, or repairs
it; tests/property/test_dxf_plain_laws.py holds both ways equal.
"""

from binascii import unhexlify
from collections.abc import Callable, Iterable, Iterator
from functools import partial

import numpy as np
from msgspec import Struct
from numpy.typing import NDArray

#: Group codes: names of tables and entries, of entities (handles), subclasses, brackets.
NAME, HANDLE, SUBCLASS, BRACKET, VARIABLE, COMMENT = 2, 5, 100, 102, 9, 999


class Rows(Struct, frozen=True):
    """All lines, the group code of each row, and where entities begin."""

    lines: list[str]
    codes: NDArray[np.int32]
    starts: list[int]  #: the rows of group 0
    sections: dict[str, range]  #: which of `starts` stand in each that is there just once

    def value(self, row: int) -> str:
        return self.lines[2 * row + 1]

    def kind(self, entity: int) -> str:
        """The kind of an entity by its place among `starts`."""
        return self.value(self.starts[entity])

    def sequences(self, entities: Iterable[int]) -> Iterator[tuple[int, int, bytes]]:
        """First row, the row behind the last, and the group codes of entities as bytes."""
        codes, starts, size = self.codes.tobytes(), self.starts, self.codes.itemsize
        for k in entities:
            first, last = starts[k], starts[k + 1]
            yield first, last, codes[size * first : size * last]


def rows_of(text: str) -> Rows | None:
    """The rows of a text up to EOF; None if they are not two lines each, or if EOF is missing."""
    lines = text.rstrip().split("\n")
    if len(lines) % 2 or lines[-1] != "EOF":
        return None
    texts = lines[::2]
    try:
        numbers = {text: int(text) for text in set(texts)}
        codes = np.fromiter(map(numbers.__getitem__, texts), np.int32, len(texts))
    except (ValueError, OverflowError):
        return None
    starts: list[int] = np.flatnonzero(codes == 0).tolist()
    ends = [k for k in starts if lines[2 * k + 1] == "EOF"]
    if ends != [len(texts) - 1]:
        return None
    found: dict[str, list[range]] = {}
    name = ""
    for k, row in enumerate(starts):
        kind = lines[2 * row + 1].strip()
        if kind == "SECTION":
            name, begin = lines[2 * row + 3] if codes[row + 1] == NAME else "", k + 1
        elif kind == "ENDSEC" and name:
            found.setdefault(name, []).append(range(begin, k))
            name = ""
    once = {name: places[0] for name, places in found.items() if len(places) == 1}
    return Rows(lines, codes, starts, once)


# --- whether ezdxf has something to say -----------------------------------------------------------

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
    found = ""
    for row, behind in zip(variables, [*variables[1:], end], strict=True):
        is_point = rows.codes[row + 1] == 10 and behind - row in (3, 4)
        if not rows.value(row).startswith("$") or not (behind - row == 2 or is_point):
            return ""
        if rows.value(row) == "$ACADVER":
            found = rows.value(row + 1)
    return found


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
