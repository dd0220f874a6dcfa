r"""STEP physical files (ISO 10303-21): from text to records, and from a record to values.

    #12=IFCCIRCLEPROFILEDEF(.AREA.,'bolt hole',#5,9.);

A record is kept as its text until somebody asks for its values, which most are never asked for.
"""

import re
from collections.abc import Callable
from sys import intern
from typing import Any

from msgspec import Struct

Values = tuple[Any, ...]

# A name, a class, and all behind its bracket up to the semicolon that is in no string. Possessive,
# so that a string that is never closed costs one look at the rest of the file and not many.
_RECORD = re.compile(r"(#\d++)\s*+=\s*+(\w++)\s*+\(((?:[^';]++|'[^']*+')*+);")
_COMMENT = re.compile(r"('[^']*+')|/\*.*?\*/", re.DOTALL)
_PADDED = re.compile(r"('[^']*+')|#0+(?=\d)")
_REAL = r"\s*([-+]?\d+\.?\d*(?:[Ee][-+]?\d+)?)\s*"
_NUMBER = re.compile(_REAL)
_TOKEN = re.compile(r"'[^']*+(?:''[^']*+)*+'|[^\s,()']++|[()]")
# The two records with strings that a model has most of, properties and relations of many to one:
#     'Phase',$,IFCLABEL('1'),$                            'guid',#5,$,$,(#100,#101),#200
_TEXT, _BARE = r"(\$|'[^']*+')", r"([^\s,()'A-Za-z][^\s,()']*+)"
_PROPERTY = re.compile(rf"{_TEXT},{_TEXT},([A-Za-z]\w*+)\((?:{_TEXT}|{_BARE})\),{_BARE}")
_RELATION = re.compile(rf"{_TEXT},{_BARE},{_TEXT},{_TEXT},\((#\d++(?:,#\d++)*+)\),(#\d++)")
_START = re.compile(r"\bDATA\s*;")
_END = re.compile(r"\bENDSEC\s*;")
_ESCAPE = re.compile(
    r"\\X2\\((?:[0-9A-F]{4})*)\\X0\\|\\X4\\((?:[0-9A-F]{8})*)\\X0\\|\\X\\([0-9A-F]{2})"
    r"|\\S\\(.)|\\P[A-I]\\|\\(\\)",
    re.DOTALL,
)


class Malformed(ValueError):
    """A file that is no STEP file; `line` is where, counted from 1."""

    def __init__(self, text: str, line: int | None = None) -> None:
        super().__init__(text)
        self.line = line


class Typed(Struct, frozen=True):
    """A value with its type written before it: IFCLENGTHMEASURE(25.4)."""

    kind: str  #: in capitals
    value: Any

    def is_a(self, name: str) -> bool:
        """As of an entity."""
        return name.upper() == self.kind


def tidy(text: str) -> str:
    """The text without comments, and with names of the shortest form; lines stay lines."""
    if "/*" in text:
        text = _COMMENT.sub(lambda m: m[1] or "\n" * m[0].count("\n"), text)
    if "#0" in text:
        text = _PADDED.sub(lambda m: m[1] or "#", text)
    return text


class Records(Struct, frozen=True):
    """The records of a file by their names, `#12`."""

    kinds: dict[str, str]  #: IFCDIRECTION
    inner: dict[str, str]  #: what is behind the opening bracket: `(0.,0.,1.))`


def records(text: str) -> Records:
    """The records of all DATA sections.

    Raises Malformed for text that is no record, and for a name that is there twice.
    """
    found = Records({}, {})
    at = 0
    while (start := _START.search(text, at)) is not None:
        at = start.end()
        end = text.rfind("ENDSEC") if text.count("ENDSEC") <= 2 else _end_of(text, at)
        if end < at:
            raise Malformed("a DATA section without an end", _line(text, at))
        # [gap, name, class, inner, gap, ...]: no tuple for each of a million records
        flat = _RECORD.split(text[at:end])
        gaps = "".join(flat[::4])
        if gaps and not gaps.isspace():
            raise _strange(text, at, flat)
        names = flat[1::4]
        before = len(found.kinds)
        found.kinds.update(zip(names, map(intern, flat[2::4]), strict=True))
        found.inner.update(zip(names, flat[3::4], strict=True))
        if len(found.kinds) != before + len(names):
            raise Malformed(f"record {_repeated(names)} twice")
        at = end
    return found


def _end_of(text: str, at: int) -> int:
    """Where the section that begins at `at` ends, if the text has several."""
    rest = _COMMENT.sub(lambda m: " " * len(m[0]), text[at:])  # strings say ENDSEC; too
    end = _END.search(rest)
    return at + end.start() if end is not None else -1


def _line(text: str, at: int) -> int:
    return text.count("\n", 0, at) + 1


def _strange(text: str, at: int, flat: list[str]) -> Malformed:
    """What stands between the records, and its line."""
    for i, gap in enumerate(flat[::4]):
        if gap and not gap.isspace():
            where = at + sum(map(len, flat[: 4 * i])) + len(gap) - len(gap.lstrip())
            if i:  # what the pattern took beside its groups
                last = re.compile(rf"{flat[4 * i - 3]}\s*=")
                found = list(last.finditer(text, at))[-1]
                where = text.index(gap.strip()[:40], found.end())
            return Malformed(f"{gap.strip()[:40]!r} where a record begins", _line(text, where))
    raise AssertionError("no gap holds anything")


def _repeated(names: list[str]) -> str:
    seen = set[str]()
    for name in names:
        if name in seen:
            return name
        seen.add(name)
    return "of another section"


class Tokens(dict[str, Any]):
    """Values by how they are written: None by `$`, 1.5 by `1.5`, what `reference` gives by `#12`.

    A dict, so that a token that was met before costs one look, without a call.
    """

    def __init__(self, known: dict[str, Any], reference: Callable[[str], Any]) -> None:
        super().__init__(known)
        self.reference = reference
        self.update({"$": None, "*": None, ".T.": True, ".F.": False, ".U.": "UNKNOWN"})

    def __missing__(self, token: str) -> Any:
        """Raises Malformed for what is no value."""
        if token[:1] == "#" and token[1:].isdigit():
            self[token] = found = self.reference(token)
            return found
        if "_" not in token:  # Python's numbers may have some
            try:
                # A real number has a point, and 1.E-05 is one.
                return float(token) if "." in token else int(token)
            except ValueError:
                pass  # a word then
        if len(token) > 2 and token[0] == token[-1] == ".":
            self[token] = token[1:-1]
            return token[1:-1]
        if len(token) > 1 and token[0] == token[-1] == '"':
            return token[1:-1]
        bare = token.strip()
        if bare == token or not bare:
            raise Malformed(f"{token[:40]!r} as a value")
        return self[bare]

    def values(self, inner: str) -> Values:  # type: ignore[override]
        """The values between a record's brackets: None, numbers, strings, truths, references.

        An enumeration is its text, a list a tuple. Raises Malformed for what are no values.
        """
        if "'" not in inner:
            if "(" not in inner:
                return tuple(map(self.__getitem__, inner.split(","))) if inner else ()
            # The whole record is one list of plain values, as of polylines and composite curves.
            if inner[0] == "(" and inner.find(")") == len(inner) - 1 and inner.rfind("(") == 0:
                listed = inner[1:-1]
                return (tuple(map(self.__getitem__, listed.split(","))) if listed else (),)
            return self._nested(inner)
        found = _PROPERTY.fullmatch(inner)
        if found is not None:
            name, about, kind, text, bare, unit = found.groups()
            value = self[bare] if text is None else self._text(text)
            return self._text(name), self._text(about), Typed(kind.upper(), value), self[unit]
        found = _RELATION.fullmatch(inner)
        if found is not None:
            guid, owner, name, about, many, one = found.groups()
            side = tuple(map(self.__getitem__, many.split(",")))
            texts = self._text(name), self._text(about)
            return self._text(guid), self[owner], *texts, side, self[one]
        return self._nested(inner)

    def _text(self, token: str) -> str | None:
        return None if token == "$" else text_of(token[1:-1])

    def _nested(self, inner: str) -> Values:
        """Values among which are strings, lists in lists or types."""
        if inner.count("'") % 2:
            raise Malformed(f"{inner[:40]!r} as values")
        stack: list[list[Any]] = [[]]
        kinds: list[str | None] = []
        kind: str | None = None
        for token in _TOKEN.findall(inner):
            first = token[0]
            if first == "(":
                stack.append([])
                kinds.append(kind)
                kind = None
            elif first == ")":
                if not kinds:
                    raise Malformed(f"{inner[:40]!r} as values")
                done, of = tuple(stack.pop()), kinds.pop()
                stack[-1].append(done if of is None else Typed(of, done[0] if done else None))
            elif first == "'":
                stack[-1].append(text_of(token[1:-1]))
            elif first.isalpha():
                kind = token.upper()
            else:
                stack[-1].append(self[token])
        if kinds:
            raise Malformed(f"{inner[:40]!r} as values")
        return tuple(stack[0])


def text_of(raw: str) -> str:
    """A string as it is meant: doubled quotes and the escapes of ISO 10303-21 undone."""
    if "''" in raw:
        raw = raw.replace("''", "'")
    return _ESCAPE.sub(_unescaped, raw) if "\\" in raw else raw


def _unescaped(found: re.Match[str]) -> str:
    two, four, one, upper, slash = found.groups()
    if two is not None:
        return bytes.fromhex(two).decode("utf-16-be", "replace")
    if four is not None:
        return bytes.fromhex(four).decode("utf-32-be", "replace")
    if one is not None:
        return chr(int(one, 16))
    if upper is not None:
        return chr(ord(upper) + 128)
    return "\\" if slash else ""
