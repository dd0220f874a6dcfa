"""The text of a model (ISO 10303-21): its records, and the values in one of them.

    #12=IFCCIRCLEPROFILEDEF(.AREA.,'bolt hole',#5,9.);       ('AREA', 'bolt hole', <#5>, 9.0)

The parser of ifcopenshell passes over rubbish between records, over references that lead nowhere,
over words that the schema does not list and over values of another kind, and after a string with a
stray backslash over all that follows, without an error to its caller. Here each record says itself
what it holds, so that a fault refuses the members that have it and no other.
"""

import re
from collections.abc import Callable
from typing import Any

from msgspec import Struct

_SECTION = re.compile(r"(?:^|(?<=;))\s*+DATA\s*(?:\([^;]*\)\s*)?;", re.MULTILINE)
_END = re.compile(r"\s*+ENDSEC\s*;")
_AFTER = re.compile(r"[^#;]*+#")  # a record that is in no section
_COMMENT = re.compile(r"('[^']*')|/\*.*?\*/", re.DOTALL)
_RECORD = re.compile(
    r"\s*+#(\d{1,18}+)\s*+=\s*+(\w++)\s*+\(((?:[^;')]++|'[^']*+'|\)(?!\s*+;))*+)\)\s*+;", re.ASCII
)
#: What a bracket or a comma ends, and that: a text, a word, or nothing.
_TOKEN = re.compile(r"\s*+('[^']*+(?:''[^']*+)*+'|[^\s,()']++)?\s*+([(,)]?)", re.ASCII)
#: A real number has a point, and 1.E-05 is one.
_NUMBER = re.compile(r"[-+]?(?:\d++|(?:\d++\.\d*+|\.\d++)(?:[Ee][-+]?\d++)?)", re.ASCII)
_WORD = re.compile(r"([.\"])(\w*+)\1", re.ASCII)
_TYPE = re.compile(r"[A-Za-z]\w*+", re.ASCII)
_ESCAPE = re.compile(
    r"\\X2\\((?:[0-9A-F]{4})*+)\\X0\\|\\X4\\((?:[0-9A-F]{8})*+)\\X0\\|\\X\\([0-9A-F]{2})"
    r"|\\S\\([^'])|\\P[A-I]\\|\\(\\?)"
)
_CONSTANTS = {"$": None, "*": None, ".T.": True, ".F.": False, ".U.": "UNKNOWN"}
_MOST_DIGITS = 400  #: of a number; Python itself refuses 4,300
_DEEPEST = 100  #: lists inside one another


class Malformed(ValueError):
    """A file that is not a STEP file; `line` is where, counted from 1."""

    def __init__(self, text: str, line: int | None = None) -> None:
        super().__init__(text)
        self.line = line


class StepRecord(Struct, frozen=True, gc=False):
    """A record as it is written."""

    number: int
    kind: str  #: its class
    inner: str  #: what is between its brackets
    at: int  #: where it begins in the text


def records(text: str) -> dict[int, StepRecord]:
    """The records of a STEP file by their numbers, in its order.

    Raises Malformed for what is no record, and for a number again.
    """
    if "/*" in text:  # lines stay lines
        text = _COMMENT.sub(lambda m: m[1] or " " + "\n" * m[0].count("\n"), text)
    found: dict[int, StepRecord] = {}
    section = _SECTION.search(text)
    if section is None:
        raise Malformed("no DATA section")
    while section is not None:
        first = at = section.end()
        for match in _RECORD.finditer(text, at):
            if match.start() != at:
                break
            number = int(match[1])
            if number in found:
                raise Malformed(f"record #{number} twice", _line(text, match.start(1)))
            found[number] = StepRecord(number, match[2], match[3], at)
            at = match.end()
        end = _END.match(text, at)
        if end is None:
            if not text[at:].strip():
                raise Malformed("a DATA section without an end", _line(text, first))
            raise _no_record(text, at)
        at = end.end()
        section = _SECTION.search(text, at)
        if outside := _AFTER.match(text, at, section.end() if section else len(text)):
            raise _no_record(text, outside.end() - 1)
    return found


def _no_record(text: str, at: int) -> Malformed:
    at += len(text[at:]) - len(text[at:].lstrip())
    return Malformed(f"{text[at : at + 40].strip()!r} where a record begins", _line(text, at))


def _line(text: str, at: int) -> int:
    return text.count("\n", 0, at) + 1


Values = tuple[Any, ...]
_NOTHING = object()  #: where a value is still to come


class Typed(Struct, frozen=True, gc=False):
    """A value with its type written before it: IFCLENGTHMEASURE(25.4)."""

    kind: str  #: in capitals
    value: Any

    def is_a(self, name: str) -> bool:
        """As of an entity."""
        return name.upper() == self.kind


def values_of(inner: str, referred: Callable[[int], Any]) -> Values:
    """The values between a record's brackets; `referred` gives what a number stands for.

    An enumeration is its text, a list a tuple. Raises Malformed for what is not a value.
    """
    open_: list[tuple[str, list[Any]]] = [("", [])]  # lists and values with their types
    value: Any = _NOTHING
    for word, mark in _TOKEN.findall(f"{inner})"):
        if word and value is not _NOTHING:
            raise Malformed(f"{word[:40]!r} behind a value")
        if mark == "(":
            if value is not _NOTHING or (word and _TYPE.fullmatch(word) is None):
                raise Malformed(f"{word[:40]!r} before a bracket")
            if len(open_) > _DEEPEST:
                raise Malformed("values too deep inside one another")
            open_.append((word.upper(), []))
            continue
        if word:
            value = _value(word, referred)
        if not mark:
            continue
        if not open_:
            raise Malformed(f"{inner[:40]!r} as values")
        kind, row = open_[-1]
        if value is not _NOTHING:
            row.append(value)
        elif mark == "," or row or kind:
            raise Malformed(f"{inner[:40]!r} as values")
        value = _NOTHING
        if mark == ")":
            open_.pop()
            value = Typed(kind, row[0]) if kind else tuple(row)
    if open_:
        raise Malformed(f"{inner[:40]!r} as values")
    return tuple(row)


def _value(word: str, referred: Callable[[int], Any]) -> Any:
    """What a word or a text stands for."""
    if word[0] == "#" and word[1:].isdecimal() and len(word) < 20:
        return referred(int(word[1:]))
    if word[0] == "'":
        text = word[1:-1].replace("''", "'")
        return _ESCAPE.sub(_letters, text) if "\\" in text else text
    if word in _CONSTANTS:
        return _CONSTANTS[word]
    if len(word) <= _MOST_DIGITS and _NUMBER.fullmatch(word):
        return float(word) if "." in word else int(word)
    if (found := _WORD.fullmatch(word)) is not None:
        return found[2]
    raise Malformed(f"{word[:40]!r} as a value")


def _letters(match: re.Match[str]) -> str:
    """What an escape stands for."""
    two, four, one, upper, slash = match.groups()
    if two is not None:
        return bytes.fromhex(two).decode("utf-16-be", "replace")
    if four is not None:
        return bytes.fromhex(four).decode("utf-32-be", "replace")
    if one is not None:
        return chr(int(one, 16))
    return chr(ord(upper) % 128 + 128) if upper is not None else "\\" * (slash is not None)
