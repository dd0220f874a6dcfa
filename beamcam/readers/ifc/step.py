"""STEP physical files (ISO 10303-21): positions of the records in the text.

    #12=IFCCIRCLEPROFILEDEF(.AREA.,'bolt hole',#5,9.);
    |   |                  |                        |
    start                  opening                  closing
        kind

A record ends at a semicolon that is in no string. All of them are found at once, by arrays over
the characters; the text of a record is cut out when somebody asks for it, which for most nobody
does.

ifcopenshell reads the same text, but builds an object for every record and passes over faults
without a line. So the own way takes entities and their attributes from here and never judges
geometry that only a kernel can: members with other solids are built by ifcopenshell. It may not
repair: a record that cannot be read is a diagnostic. tests/unit/readers/ifc/test_step.py holds
both readings equal.
"""

import re
from typing import Any

import numpy as np
from msgspec import Struct

from beamcam.readers.ifc.characters import (
    Codes,
    Places,
    Truths,
    Words,
    back_over_blanks,
    codes_of,
    hashes,
    holds,
    numbers_at,
    past_blanks,
    places_of,
    words_before,
)

_COMMENT = re.compile(r"('[^']*+')|/\*.*?\*/", re.DOTALL)
_PADDED = re.compile(r"('[^']*+')|#0+(?=\d)")
_START = re.compile(r"\bDATA\s*;")
_SECTION = re.compile(r"DATA\s*(\(.*\))?", re.DOTALL)
_CLASS = re.compile(r"\w+", re.ASCII)
_HASH, _OPENING, _CLOSING, _SEMICOLON, _EQUALS, _COMMA, _DOLLAR = b"#();=,$"
_SPARSE = 8  #: names beyond so many times the count of records are looked up in a dict
_NONE: Places = np.empty(0, np.int64)

MISSING = -1  #: instead of the index of a record that is not in the file
NONE_GIVEN = -2  #: instead of an index where there is `$`


class Malformed(ValueError):
    """A file that is not a STEP file; `line` is where, counted from 1."""

    def __init__(self, text: str, line: int | None = None) -> None:
        super().__init__(text)
        self.line = line


class Typed(Struct, frozen=True, gc=False):
    """A value with its type written before it: IFCLENGTHMEASURE(25.4)."""

    kind: str  #: in capitals
    value: Any

    def is_a(self, name: str) -> bool:
        """As of an entity."""
        return name.upper() == self.kind


class Inners(Struct, frozen=True):
    """Text between the brackets of some records, in the order of the file."""

    text: str  #: of the file
    codes: Codes
    marks: Places  #: of all commas, brackets and semicolons in the text
    opened: Places  #: which of the marks the brackets before them are
    closed: Places  #: which of the marks the brackets behind them are

    @property
    def first(self) -> Places:
        """Start of each of them."""
        return self.marks[self.opened] + 1

    @property
    def last(self) -> Places:
        """The places behind them."""
        return self.marks[self.closed]

    def some(self, which: Places) -> "Inners":
        """Those of some of the records."""
        return Inners(self.text, self.codes, self.marks, self.opened[which], self.closed[which])

    def texts(self) -> list[str]:
        return pieces(self.text, self.first, self.last)


class Records:
    """The records of a file, known by their indices in the order of the file."""

    def __init__(self, every: Inners, numbers: Places, starts: Places, kinds: Places) -> None:
        """The records of some numbers; `starts` are the places of their names, then their kinds'.

        Raises Malformed for a number that is there twice, and for a class that is not a word.
        """
        self._every, self._starts, self._kinds = every, starts, kinds
        self._index = _index(numbers)
        first = every.first
        self._hashes = hashes(every.codes, kinds, back_over_blanks(every.codes, first - 1))
        # A memoryview gives single numbers faster than an array does, and as Python's own.
        self._number, self._kind = numbers.data, self._hashes.data
        self._first, self._last = first.data, every.last.data
        if (twice := _second(numbers)) is not None:
            line = _line(every.text, int(starts[twice]))
            raise Malformed(f"record {self.name(twice)} twice", line)
        self._of_kind = _places_of_each(self._hashes)
        self.kinds = self._classes()  #: as they are written, IFCDIRECTION, by their numbers

    def __len__(self) -> int:
        return len(self._hashes)

    def find(self, number: int) -> int:
        """The index of the record named `#12`, if 12 is the number, or MISSING."""
        try:
            return self._index[number]
        except LookupError:
            return MISSING

    def name(self, index: int) -> str:
        """#12"""
        return f"#{self._number[index]}"

    def kinds_of(self, indices: Places) -> Words:
        """As `kind`, of many records."""
        return self._hashes[indices]

    def kind(self, index: int) -> int:
        """The class of a record, as a number of `kinds`."""
        return self._kind[index]

    def inner(self, index: int) -> str:
        """Text between the brackets: `(0.,0.,1.)`."""
        return self._every.text[self._first[index] : self._last[index]]

    def of(self, kind: str) -> Places:
        """The indices of the records of a class, which is in capitals."""
        numbers = [number for number, written in self.kinds.items() if written.upper() == kind]
        if len(numbers) == 1:
            return self.of_kind(numbers[0])
        return np.sort(np.concatenate([_NONE, *map(self.of_kind, numbers)]))

    def of_kind(self, number: int) -> Places:
        """The indices of the records of a class, by its number in `kinds`."""
        return self._of_kind[number]

    def beginning(self, kind: str, texts: tuple[str, ...]) -> dict[str, str]:
        """As `inner`, by the names of those of a class that begin with one of the texts.

        Blanks before the text are left out.
        """
        size = min(8, *map(len, texts))
        heads = codes_of("".join(text[:size].rjust(8) for text in texts))
        indices = self.of(kind)
        codes = self._every.codes
        words = words_before(codes, past_blanks(codes, self.inners(indices).first) + size, size)
        wanted = words_before(heads, np.arange(1, len(texts) + 1) * 8, size)
        likely = indices[np.isin(words, wanted)]
        inners = [inner.lstrip() for inner in self.inners(likely).texts()]
        found = zip(likely.tolist(), inners, strict=True)
        return {self.name(index): inner for index, inner in found if inner.startswith(texts)}

    def inners(self, indices: Places) -> Inners:
        """As `inner`, of many records."""
        return self._every.some(indices)

    def references(self, indices: Places, count: int) -> list[Places] | None:
        """The indices that records refer to whose values are `count` references and no more.

        A column for each value; `$` is NONE_GIVEN, a record that is not there MISSING. None if
        one of the records is written in another way, as with blanks.
        """
        codes, at = self._every.codes, self.inners(indices).first - 1
        columns = []
        for behind_it in (*[_COMMA] * (count - 1), _CLOSING):
            first = codes[at + 1]
            numbers, behind = numbers_at(codes, at + 2)
            given = first == _HASH
            well = (given | (first == _DOLLAR)) & (given == (behind > at + 2))
            if not (well & (codes[behind] == behind_it)).all():
                return None
            columns.append(np.where(given, self.find_all(numbers), NONE_GIVEN))
            at = behind
        return columns

    def find_all(self, numbers: Places) -> Places:
        """As `find`, of many numbers."""
        if isinstance(self._index, dict):
            return np.array([self._index.get(n, MISSING) for n in numbers.tolist()], np.int64)
        table = np.asarray(self._index)
        there = numbers < len(table)
        return np.where(there, table[np.where(there, numbers, 0)], MISSING)

    def _classes(self) -> dict[int, str]:
        """The classes that there are, by their hashes."""
        found: dict[int, str] = {}
        for number, indices in self._of_kind.items():
            index = int(indices[0])
            kind = self._every.text[self._kinds[index] : self._first[index] - 1].rstrip()
            if _CLASS.fullmatch(kind) is None:
                _refuse(self._every.text, self._starts[index : index + 1])
            found[number] = kind
        return found


def records(text: str) -> Records:
    """The records of all DATA sections, without comments, with names of the shortest form.

    Raises Malformed for text that is not a record, and for a name that is there twice.
    """
    codes = codes_of(text)
    if holds(codes, b"/*") or holds(codes, b"#0"):
        text = _tidy(text)
        codes = codes_of(text)
    marks = np.append(places_of(codes, b",();"), len(text))
    starts, before, after = _in_sections(text, codes, marks)
    every, ends = Inners(text, codes, marks, before + 1, after - 1), marks[after]
    numbers, behind = numbers_at(codes, starts + 1)
    equals = past_blanks(codes, behind)
    kinds = past_blanks(codes, np.minimum(equals + 1, ends))
    openings, closings = marks[every.opened], back_over_blanks(codes, ends) - 1
    well: Truths = (behind > starts + 1) & (codes[equals] == _EQUALS) & (kinds < openings)
    well &= (codes[openings] == _OPENING) & (openings < closings) & (codes[closings] == _CLOSING)
    _refuse(text, starts[~well])
    return Records(every, numbers, starts, kinds)


def pieces(text: str, first: Places, last: Places) -> list[str]:
    """What stands from each of the first places up to its last."""
    return [text[i:j] for i, j in zip(first.tolist(), last.tolist(), strict=True)]


def _tidy(text: str) -> str:
    """The text without comments, and with names of the shortest form; lines stay lines."""
    text = _COMMENT.sub(lambda m: m[1] or "\n" * m[0].count("\n"), text)
    return _PADDED.sub(lambda m: m[1] or "#", text)


def _in_sections(text: str, codes: Codes, marks: Places) -> tuple[Places, Places, Places]:
    """Start of the records of the DATA sections; which marks are the semicolons beside them.

    That is the semicolon that ends what stands before a record, and the one that ends the record.
    """
    found = _START.search(text)
    if found is None:
        return _NONE, _NONE, _NONE
    first = found.end()
    begun = int(np.searchsorted(marks, first))
    after = np.flatnonzero(codes[marks[begun:]] == _SEMICOLON) + begun
    quotes = places_of(codes[first:], b"'") + first
    after = after[np.searchsorted(quotes, marks[after]) % 2 == 0]
    before, ends = np.append(begun - 1, after), marks[after]
    starts = past_blanks(codes, marks[before] + 1)
    inside = np.zeros(len(ends), bool)
    section: int | None = 0  # the first record of the one that is open
    for i in np.flatnonzero(codes[starts[:-1]] != _HASH).tolist():
        word = text[starts[i] : ends[i]].rstrip()
        if section is None:
            section = i + 1 if _SECTION.fullmatch(word) else None
        elif word == "ENDSEC":
            inside[section:i] = True
            section = None
        else:
            _refuse(text, starts[i:])
    if section is not None:
        if text[starts[-1] :]:
            _refuse(text, starts[-1:])
        raise Malformed("a DATA section without an end", _line(text, first))
    _refuse(text, starts[:-1][(codes[starts[:-1]] == _HASH) & ~inside])
    return starts[:-1][inside], before[:-1][inside], after[inside]


def _refuse(text: str, places: Places) -> None:
    """Raises Malformed for what stands at the first of the places, if there is one."""
    for at in places[:1].tolist():
        found = text[at : at + 40].strip()
        raise Malformed(f"{found!r} where a record begins", _line(text, at))


def _line(text: str, at: int) -> int:
    return text.count("\n", 0, at) + 1


def _index(numbers: Places) -> memoryview | dict[int, int]:
    """The indices of records by their numbers; MISSING, or nothing, where there is none."""
    last = int(numbers.max(initial=0))
    if last > _SPARSE * len(numbers) + 1000:
        return dict(zip(numbers.tolist(), range(len(numbers)), strict=True))
    table = np.full(last + 1, MISSING)
    table[numbers] = np.arange(len(numbers))
    return table.data


def _places_of_each(words: Words) -> dict[int, Places]:
    """The places of equal numbers, ascending, by these numbers in the order of their first."""
    order = np.argsort(words, kind="stable")
    changes = np.flatnonzero(words[order[1:]] != words[order[:-1]]) + 1
    groups = np.split(order, changes) if len(order) else []
    return {int(words[group[0]]): group for group in sorted(groups, key=lambda g: int(g[0]))}


def _second(numbers: Places) -> int | None:
    """The index of the first number that was there before; None if there is none."""
    order = np.argsort(numbers, kind="stable")
    again = order[1:][numbers[order[1:]] == numbers[order[:-1]]]
    return int(again.min()) if len(again) else None
