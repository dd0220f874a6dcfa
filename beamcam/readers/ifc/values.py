r"""The values in the text of a STEP record.

.AREA.,'bolt hole',#5,9.            ('AREA', 'bolt hole', <#5>, 9.0)
"""

import re
from collections.abc import Callable, Iterator
from typing import Any

from beamcam.readers.ifc.step import Malformed, Typed

Values = tuple[Any, ...]

_TOKEN = re.compile(r"'[^']*+(?:''[^']*+)*+'|[^\s,()']++|[()]")
_ESCAPE = re.compile(
    r"\\X2\\((?:[0-9A-F]{4})*)\\X0\\|\\X4\\((?:[0-9A-F]{8})*)\\X0\\|\\X\\([0-9A-F]{2})"
    r"|\\S\\(.)|\\P[A-I]\\|\\(\\)",
    re.DOTALL,
)


class Tokens(dict[str, Any]):
    """Values by how they are written: None by `$`, 1.5 by `1.5`, what `reference` gives by `#12`.

    A dict, so that a token that was met before costs one look, without a call.
    """

    def __init__(self, reference: Callable[[str], Any]) -> None:
        super().__init__({"$": None, "*": None, ".T.": True, ".F.": False, ".U.": "UNKNOWN"})
        self.reference = reference

    def __missing__(self, token: str) -> Any:
        """Raises Malformed for what is no value."""
        if token[:1] == "#" and token[1:].isdecimal():
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
        if "'" not in inner and "(" not in inner:
            return tuple(map(self.__getitem__, inner.split(","))) if inner else ()
        try:
            found = self._once_bracketed(inner)
        except Malformed:
            found = None  # there are blanks between values, or there is what is none
        return self._nested(inner) if found is None else found

    def _once_bracketed(self, inner: str) -> Values | None:
        """As `values` where there is one list or type at most, as in nearly all records.

        None if there are more, or quotes in a string. May raise Malformed for what is well formed.
        """
        parts = inner.split("'")
        texts, bare = parts[1::2], "'".join(parts[::2])  # each string is a single quote now
        if "''" in bare or len(parts) % 2 == 0:
            return None
        strings = map(text_of, texts)
        before, bracket, rest = bare.partition("(")
        if not bracket:
            return tuple(self._plain(bare, strings))
        listed, closing, behind = rest.partition(")")
        comma = before.rfind(",")
        kind = before[comma + 1 :]
        if "(" in rest or not closing or ")" in behind or behind[:1] not in ("", ","):
            return None
        if kind and not kind[0].isalpha():
            return None
        first = self._plain(before[:comma], strings) if comma >= 0 else ()
        many: Any = tuple(self._plain(listed, strings)) if listed else ()
        if kind:
            many = Typed(kind.upper(), many[0] if many else None)
        return *first, many, *(self._plain(behind[1:], strings) if behind else ())

    def _plain(self, bare: str, strings: Iterator[str]) -> list[Any]:
        """The values of a text without brackets, in which a quote stands for the next string."""
        tokens = bare.split(",")
        if "'" in tokens:
            return [next(strings) if token == "'" else self[token] for token in tokens]
        return list(map(self.__getitem__, tokens))

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
