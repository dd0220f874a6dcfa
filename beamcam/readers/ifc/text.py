"""The text of a model (ISO 10303-21), looked over before ifcopenshell reads it.

    #12=IFCCIRCLEPROFILEDEF(.AREA.,'bolt hole',#5,9.);

Its parser stops at some values that are none, drops others, passes over rubbish between records and
over references that lead nowhere, all without an error to its caller. So a few regular expressions
look at the text as a whole. Its records are told apart only where there is a doubt.
"""

import re
from collections.abc import Iterator

from msgspec import Struct

_HEAD = re.compile(r"\A.*?(?=^\s*DATA\b)", re.DOTALL | re.MULTILINE)
_COMMENT = re.compile(r"('[^']*+')|/\*.*?\*/", re.DOTALL)
_DATA = r"\bDATA\s*+(?:\([^;]*\)\s*+)?;"
_END = r"\s*+ENDSEC\s*+;"
_SECTION, _SECTION_END, _OUTSIDE = map(re.compile, (_DATA, _END, r"[^#;]*+(?=#)"))
_RECORD = re.compile(
    r"\s*+#(\d{1,18}+)\s*+=\s*+(\w++)\s*+\(((?:[^;')]++|'[^']*+'|\)(?!\s*+;))*+)\)\s*+;", re.ASCII
)
_NAME = re.compile(r"(?<![(,])#(\d++)\s*+=")
_REFERENCE = re.compile(r"#(\d++)")
_ESCAPE = re.compile(
    r"\\X2\\(?P<two>(?:[0-9A-F]{4})*+)\\X0\\|(?P<letters>[^\x00-\x7f]++)"
    r"|\\(?:X4\\(?:[0-9A-F]{8})++\\X0\\|X\\[0-9A-F]{2}|S\\[^']|P[A-I]\\|\\|(?P<stray>))"
)

# --- grammar --------------------------------------------------------------------------------------
# Records as ifcopenshell's parser takes them: numbers of records have nine digits, real numbers a
# point and an exponent that is not too large, and members of lists are never `$`.

_NUMBER = r"[-+]?\d{1,300}+(?![\dEe])(?:\.\d*+(?:[Ee][-+]?[012]?\d\d?(?!\d))?+)?+"
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
_ALL_SOUND = re.compile(rf"(?:\s*+{_DATA}(?:\s*+{_SOUND})*+{_END})+\s*+END-ISO", re.ASCII)
_ONE_SOUND = re.compile(rf"\s*+{_SOUND}", re.ASCII)


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


def look_over(text: str) -> tuple[list[int], bool]:
    """The numbers of the records of a prepared text, and whether all are sound.

    They are not where some refer to no record or have values of another form. Raises Malformed for
    what is no record, and for a number again.
    """
    bare = "''".join(text.split("'")[::2])  # without what is in its strings
    section = _SECTION.search(bare)
    if section is not None and _ALL_SOUND.match(bare, section.start()):
        names = [*map(int, _NAME.findall(bare, section.end()))]
        if len(set(names)) == len(names):
            return names, len(set(_REFERENCE.findall(bare, section.end()))) == len(names)
    return [record.number for record in records(text)], False


def records(text: str) -> Iterator[StepRecord]:
    """The records of a prepared text, one by one. Raises Malformed as `look_over`."""
    met: set[int] = set()
    section = _SECTION.search(text)
    while section is not None:
        at = section.end()
        while (match := _RECORD.match(text, at)) is not None:
            number, at = int(match[1]), match.end()
            if number in met:
                raise Malformed(f"record #{number} twice", _line(text, match.start(1)))
            met.add(number)
            yield StepRecord(number, match[2], match[3].strip())
        end, following = _SECTION_END.match(text, at), _SECTION.search(text, at)
        until = len(text) if following is None else following.start()
        outside = _OUTSIDE.match(text, end.end(), until) if end is not None else None
        if end is None or outside is not None:
            rest = text[at if outside is None else outside.end() :].lstrip()
            if not rest:
                raise Malformed("a DATA section without an end", _line(text, section.end()))
            line = _line(text, len(text) - len(rest))
            raise Malformed(f"{rest[:40].strip()!r} where a record begins", line)
        section = following


def _line(text: str, at: int) -> int:
    return text.count("\n", 0, at) + 1


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
    fields, deep = [""], 0
    for match in _TOKEN.finditer(inner):
        token = match[0].upper()
        deep += (token == "(") - (token == ")")
        if token == "," and not deep:
            fields.append("")
        elif match.lastgroup is not None:
            fields[-1] += {"string": "'", "number": "n"}.get(match.lastgroup, f"#{match[3]}")
        else:
            fields[-1] += "$" if token == "*" else token
    return fields if inner.strip() else []
