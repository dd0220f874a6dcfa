"""The text of a model (ISO 10303-21), looked over before ifcopenshell reads it.

    #12=IFCCIRCLEPROFILEDEF(.AREA.,'bolt hole',#5,9.);

Its parser passes over rubbish between records, over references that lead nowhere and over values
of another kind, and after a string with a stray backslash over all that follows, without an error
to its caller. So a few regular expressions look at the text as a whole. Its records are told apart
only where there is a doubt.
"""

import json
import re
from collections.abc import Callable, Iterator
from typing import Any

from msgspec import Struct

_SECTION = re.compile(r"\bDATA\s*(?:\([^;]*\)\s*)?;")
_END = r"\s*+(?P<end>ENDSEC\s*;)?"
_RECORDS = re.compile(
    rf"(?:\s*+#\d{{1,18}}+\s*+=\s*+\w++\s*+\((?:[^;)]++|\)(?!\s*+;))*+\)\s*+;)*+{_END}", re.ASCII
)
_AFTER = re.compile(r"[^#;]*+#")  # a record that is in no section
_NAME = re.compile(r"(?<![(,])#(\d++)\s*+=")
_REFERENCE = re.compile(r"#(\d++)")
_STRING = re.compile(r"'[^']*+(?:'|\Z)")
_COMMENT = re.compile(r"('[^']*+')|/\*.*?\*/", re.DOTALL)
_RECORD = re.compile(
    r"#(\d++)\s*+=\s*+(\w++)\s*+\(((?:[^;')]++|'[^']*+'|\)(?!\s*+;))*+)\)\s*+;", re.ASCII
)
ESCAPE = re.compile(
    r"\\X2\\((?:[0-9A-F]{4})*+)\\X0\\|\\X4\\((?:[0-9A-F]{8})*+)\\X0\\|\\X\\([0-9A-F]{2})"
    r"|\\S\\([^'])|\\P[A-I]\\|\\(\\?)"
)
_LETTERS = re.compile(r"[^\x00-\x7f]++")

_VALUE = r"(?![-+]?+\d++[Ee])[^\s,();=$*]++"  # a real number has a point


def _listed(deep: int) -> str:
    """Pattern of a list, without `$`, in which lists and typed values are so deep at most."""
    value = rf"(?:{_VALUE}\s*+(?:{_listed(deep - 1)})?+|{_listed(deep - 1)})" if deep else _VALUE
    return rf"\(\s*+{value}\s*+(?:,\s*+{value}\s*+)*+\)"


_EACH = rf"(?:[$*]|{_VALUE}\s*+(?:{_listed(2)})?+|{_listed(2)})\s*+"
#: Records whose values ifcopenshell does not pass over: it does not ask for commas between them.
_SOUND = re.compile(
    rf"(?:\s*+#\d{{1,9}}+\s*+=\s*+\w++\s*+\(\s*+(?:{_EACH}(?:,\s*+{_EACH})*+)?+\)\s*+;)*+{_END}",
    re.ASCII,
)


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


def plain(text: str) -> str:
    """The text without comments, and with the letters that its escapes stand for.

    A backslash is written twice, also where it is no escape. Lines stay lines.
    """
    if "/*" in text:
        text = _COMMENT.sub(lambda m: m[1] or " " + "\n" * m[0].count("\n"), text)
    return ESCAPE.sub(_unescaped, text) if "\\" in text else text


def _unescaped(match: re.Match[str]) -> str:
    letters = letters_of(match)
    if re.search(r"[\x00-\x1f]", letters):
        return match[0]
    return letters.replace("'", "''").replace("\\", r"\\")


def letters_of(match: re.Match[str]) -> str:
    """What an escape stands for."""
    two, four, one, upper, slash = match.groups()
    if two is not None:
        return bytes.fromhex(two).decode("utf-16-be", "replace")
    if four is not None:
        return bytes.fromhex(four).decode("utf-32-be", "replace")
    if one is not None:
        return chr(int(one, 16))
    return chr(ord(upper) % 128 + 128) if upper is not None else "\\" * (slash is not None)


def escaped(text: str) -> str:
    """A plain text with escapes for the letters that are not ASCII; ifcopenshell drops them."""
    if text.isascii():
        return text
    return _LETTERS.sub(
        lambda found: f"\\X4\\{found[0].encode('utf-32-be').hex().upper()}\\X0\\", text
    )


def look_over(text: str) -> tuple[list[str], bool]:
    """The numbers of a plain text's records, and whether they are to be doubted.

    They are where some refer to no record or have values of another form. Raises Malformed for what
    is no record, and for a number again.
    """
    try:
        return _looked("''".join(text.split("'")[::2]), text)
    except Malformed:
        # Once more with all in its place, for the line and the words that stand there.
        _looked(_STRING.sub(lambda m: "'" * len(m[0]), text), text)
        raise


def _looked(bare: str, text: str) -> tuple[list[str], bool]:
    """As `look_over`, of a text without what is in its strings."""
    section = _SECTION.search(bare)
    first = at = section.end() if section is not None else len(bare)
    sound = True
    while section is not None:
        match = _SOUND.match(bare, section.end())
        if match is None or match["end"] is None:
            sound, match = False, _RECORDS.match(bare, section.end())
        at = section.end() if match is None else match.end()
        if match is None or match["end"] is None:
            if at == len(bare):
                raise Malformed("a DATA section without an end", _line(text, first))
            raise _no_record(text, at)
        section = _SECTION.search(bare, at)
        if outside := _AFTER.match(bare, at, section.start() if section else len(bare)):
            raise _no_record(text, outside.end() - 1)
    names, asked = _NAME.findall(bare, first), set(_REFERENCE.findall(bare, first))
    if "#0" in bare:
        names = [name.lstrip("0") for name in names]
        asked = {one.lstrip("0") for one in asked}
    there = set(names)
    if len(there) < len(names):
        met: set[int] = set()
        for name in _NAME.finditer(bare, first):
            if int(name[1]) in met:
                raise Malformed(f"record #{int(name[1])} twice", _line(text, name.start()))
            met.add(int(name[1]))
    return names, not sound or len(asked) > len(there)


def _no_record(text: str, at: int) -> Malformed:
    return Malformed(f"{text[at : at + 40].strip()!r} where a record begins", _line(text, at))


def records(text: str) -> Iterator[StepRecord]:
    """The records of a plain text that was looked over."""
    for match in _RECORD.finditer(text):
        yield StepRecord(int(match[1]), match[2], match[3])


def _line(text: str, at: int) -> int:
    return text.count("\n", 0, at) + 1


# --- doubts ---------------------------------------------------------------------------------------
# The values in the text of a record, of a file that ifcopenshell does not read as it is written.
#
#     .AREA.,'bolt hole',#5,9.            ('AREA', 'bolt hole', <#5>, 9.0)
#
# It leaves out records of classes that the schema has not, members of a list that are of another
# kind than the first or refer to no record, and words that the schema does not list. Of such a file
# each record says itself what it holds, so that a fault refuses the members that have it and no
# other.

Values = tuple[Any, ...]

_TOKEN = re.compile(r"([A-Za-z]\w*+)\s*+\(|'[^']*+(?:''[^']*+)*+'|[^\s,()']++|[(),']", re.ASCII)
_BRACKETS = {"(": "[", ")": "]", ",": ","}
#: A real number has a point, and 1.E-05 is one.
_NUMBER = re.compile(r"[-+]?(?:\d++|(?:\d++\.\d*+|\.\d++)(?:[Ee][-+]?\d++)?)", re.ASCII)
_WORD = re.compile(r"\.(\w++)\.|\"(\w*+)\"", re.ASCII)
_CONSTANTS = {"$": None, "*": None, ".T.": True, ".F.": False, ".U.": "UNKNOWN"}
_MOST_DIGITS = 400  #: of a number; Python itself refuses 4,300


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

    def tied(found: dict[str, Any]) -> Any:
        return referred(found["#"]) if "#" in found else _Kind(found["kind"])

    try:
        found = json.loads(f"[{_TOKEN.sub(_as_json, inner)}]", object_hook=tied)
    except RecursionError:
        raise Malformed("values too deep inside one another") from None
    except json.JSONDecodeError:
        raise Malformed(f"{inner[:40]!r} as values") from None
    return tuple(map(_held, found))


class _Kind(str):
    """The type that is written before a value."""


def _held(value: Any) -> Any:
    if not isinstance(value, list):
        return value
    if value and isinstance(value[0], _Kind):
        return Typed(value[0].upper(), _held(value[1]))
    return tuple(map(_held, value))


def _as_json(match: re.Match[str]) -> str:
    """A token in JSON; of a value with its type a list that begins with it."""
    token = match[0]
    if token in _BRACKETS:
        return _BRACKETS[token]
    if token[-1] == "(":
        return f'[{{"kind": "{match[1]}"}},'
    if token in _CONSTANTS:
        return json.dumps(_CONSTANTS[token])
    if token[0] == "#" and token[1:].isdecimal() and len(token) < 20:
        return f'{{"#": {int(token[1:])}}}'
    if token[0] == "'" and len(token) > 1:
        return json.dumps(ESCAPE.sub(letters_of, token[1:-1].replace("''", "'")))
    if (word := _WORD.fullmatch(token)) is not None:
        return json.dumps(word[1] if word[1] is not None else word[2])
    if _NUMBER.fullmatch(token) is None or len(token) > _MOST_DIGITS:
        raise Malformed(f"{token[:40]!r} as a value")
    return json.dumps(float(token) if "." in token else int(token))
