"""The text of a model (ISO 10303-21), looked over before ifcopenshell reads it.

    #12=IFCCIRCLEPROFILEDEF(.AREA.,'bolt hole',#5,9.);

Its parser stops at some values that are none, drops others, passes over rubbish between records and
over references that lead nowhere, all without an error to its caller. So a few regular expressions
look at the text as a whole. Its records are told apart only where there is a doubt.
"""

import re
from collections.abc import Iterator

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
_HEAD = re.compile(r"\A.*?(?=^\s*DATA\b)", re.DOTALL | re.MULTILINE)
_RECORD = re.compile(
    r"#(\d++)\s*+=\s*+(\w++)\s*+\(((?:[^;')]++|'[^']*+'|\)(?!\s*+;))*+)\)\s*+;", re.ASCII
)
_ESCAPE = re.compile(
    r"\\X2\\(?P<two>(?:[0-9A-F]{4})*+)\\X0\\|(?P<letters>[^\x00-\x7f]++)"
    r"|\\(?:X4\\(?:[0-9A-F]{8})++\\X0\\|X\\[0-9A-F]{2}|S\\[^']|P[A-I]\\|\\|(?P<stray>))"
)

# --- grammar --------------------------------------------------------------------------------------
# Records as ifcopenshell's parser takes them: numbers of records have nine digits, real numbers a
# point and an exponent that is not too large, and members of lists are never `$`.

_NUMBER = r"[-+]?\d{1,60}+(?![\dEe])(?:\.\d*+(?:[Ee][-+]?[012]?\d\d?(?!\d))?+)?+"
_TEXT = r"'[^']*+'(?:'[^']*+')*+"
_VALUE = rf"#\d{{1,9}}+(?!\d)|{_NUMBER}|{_TEXT}|\.[A-Za-z]\w*+\.|\"[0-9A-Fa-f]*+\""
_TYPE = r"[A-Za-z]\w*+\s*+"


def _value(deep: int) -> str:
    """Pattern of a value, in which lists and values with their types are so deep at most."""
    if not deep:
        return _VALUE
    each = rf"(?:{_value(deep - 1)})\s*+"
    return rf"{_VALUE}|(?:{_TYPE})?+\(\s*+{each}(?:,\s*+{each})*+\)|{_TYPE}\(\s*+\$\s*+\)"


_EACH = rf"(?:[$*]|{_value(3)}|\(\s*+\))\s*+"
_SOUND = rf"#\d{{1,9}}+\s*+=\s*+\w++\s*+\(\s*+(?:{_EACH}(?:,\s*+{_EACH})*+)?+\)\s*+;"
_ALL_SOUND = re.compile(rf"(?:\s*+{_SOUND})*+{_END}", re.ASCII)
_ONE_SOUND = re.compile(_SOUND, re.ASCII)


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


def prepared(text: str, schema: str) -> str:
    """The text with a head that names its schema and no more, and blanks for comments.

    Lines stay lines.
    """
    head = (
        "ISO-10303-21;HEADER;FILE_DESCRIPTION((''),'2;1');FILE_NAME('','',(''),(''),'','','');"
        f"FILE_SCHEMA(('{schema}'));ENDSEC;"
    )
    text = _HEAD.sub(lambda m: head + "\n" * m[0].count("\n"), text, count=1)
    if "/*" not in text:
        return text
    return _COMMENT.sub(lambda m: m[1] or " " + "\n" * m[0].count("\n"), text)


def look_over(text: str) -> tuple[list[str], bool]:
    """The numbers of the records of a prepared text, and whether all are sound.

    They are not where some refer to no record or have values of another form. Raises Malformed for
    what is no record, and for a number again.
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
        match = _ALL_SOUND.match(bare, section.end())
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
    return names, sound and len(asked) <= len(there)


def _no_record(text: str, at: int) -> Malformed:
    return Malformed(f"{text[at : at + 40].strip()!r} where a record begins", _line(text, at))


def _line(text: str, at: int) -> int:
    return text.count("\n", 0, at) + 1


def records(text: str) -> Iterator[StepRecord]:
    """The records of a text that was looked over."""
    for match in _RECORD.finditer(text):
        yield StepRecord(int(match[1]), match[2], match[3].strip())


# --- for the parser -------------------------------------------------------------------------------


def parsable(text: str, sound: bool) -> str:
    """A text that was looked over, as ifcopenshell's parser does not stop at it.

    Without the records that are not sound; with a backslash written twice where it is no escape,
    and escapes for letters that are not ASCII.
    """
    if not sound:
        text = _RECORD.sub(lambda m: m[0] if _ONE_SOUND.match(m[0]) else "", text)
    return text if text.isascii() and "\\" not in text else _ESCAPE.sub(_escape, text)


def _escape(match: re.Match[str]) -> str:
    """An escape or letters in a form that ifcopenshell reads: of UTF-16 it drops half."""
    letters = match["letters"]
    if match["two"] is not None:
        letters = bytes.fromhex(match["two"]).decode("utf-16-be", "replace")
    if letters is None:
        return "\\\\" if match["stray"] is not None else match[0]
    return f"\\X4\\{letters.encode('utf-32-be').hex().upper()}\\X0\\" if letters else ""


# --- doubts ---------------------------------------------------------------------------------------

_TOKEN = re.compile(
    r"(?P<string>'[^']*+(?:''[^']*+)*+')|(?P<number>[-+]?\d++(?:\.\d*+(?:[Ee][-+]?\d++)?+)?+(?!\w))"
    r"|#0*+(?P<reference>\d++)|\*|\w++|\S",
    re.ASCII,
)


def places(inner: str) -> list[str]:
    """What stands at each place among a record's values, in a form that equal ones share.

    It does not say which number or which string.

        .AREA.,'bolt hole',(#05,$),9.            .AREA.  '  (#5,$)  n
    """
    found, deep = [""], 0
    for match in _TOKEN.finditer(inner):
        token = match[0].upper()
        deep += (token == "(") - (token == ")")
        if token == "," and not deep:
            found.append("")
        elif match.lastgroup is not None:
            found[-1] += {"string": "'", "number": "n"}.get(match.lastgroup, f"#{match[3]}")
        else:
            found[-1] += "$" if token == "*" else token
    return found if inner.strip() else []
