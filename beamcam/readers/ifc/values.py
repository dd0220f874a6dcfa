r"""The values in the text of a STEP record.

.AREA.,'bolt hole',#5,9.            ('AREA', 'bolt hole', <#5>, 9.0)
"""

import re
from collections.abc import Callable
from contextlib import suppress
from typing import Any

from beamcam.readers.ifc.step import Malformed, Typed

Values = tuple[Any, ...]

_GLOBAL_ID = 24  #: its length with its quotes; there are no two alike, so none need be kept
_MOST_DIGITS = 20  #: of a record's number; Python itself refuses 4,300
_SHORT = 7  #: characters of a number that a model likely has again

_TOKEN = re.compile(r"'[^']*+(?:''[^']*+)*+'|[^\s,()']++|[(),']")
_ESCAPE = re.compile(
    r"\\X2\\((?:[0-9A-F]{4})*)\\X0\\|\\X4\\((?:[0-9A-F]{8})*)\\X0\\|\\X\\([0-9A-F]{2})"
    r"|\\S\\(.)|\\P[A-I]\\|\\(\\)",
    re.DOTALL,
)


class Tokens(dict[str, Any]):
    """Values by how they are written: None by `$`, 1.5 by `1.5`, what `reference` gives by `#12`.

    A dict, so that a token that was met before costs one look, without a call. `reference` is
    given the name and its number.
    """

    def __init__(self, reference: Callable[[str, int], Any]) -> None:
        super().__init__({"$": None, "*": None, ".T.": True, ".F.": False, ".U.": "UNKNOWN"})
        self.reference = reference

    def __missing__(self, token: str) -> Any:
        """Raises Malformed for what is not a value, and for a part of a string."""
        first = token[:1]
        if first == "#":
            digits = token[1:]
            if digits.isdecimal() and len(digits) < _MOST_DIGITS:
                self[token] = found = self.reference(token, int(digits))
                return found
        elif first == "'":
            if len(token) < 2 or token.find("'", 1) != len(token) - 1:
                raise Malformed(f"{token[:40]!r} as a value")
            text = text_of(token[1:-1]) if "\\" in token else token[1:-1]
            if len(token) != _GLOBAL_ID:
                self[token] = text
            return text
        elif "_" not in token:  # Python's numbers may have some
            try:
                # A real number has a point, and 1.E-05 is one.
                number = float(token) if "." in token else int(token)
            except ValueError:
                pass  # a word then
            else:
                if len(token) < _SHORT:
                    self[token] = number
                return number
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

        An enumeration is its text, a list a tuple. Raises Malformed for what is not a value.
        """
        if "(" not in inner:
            # A string with a comma in it falls into pieces with an odd number of quotes, which are
            # no values.
            with suppress(Malformed):
                return tuple(map(self.__getitem__, inner.split(","))) if inner else ()
        return self._nested(inner)

    def _nested(self, inner: str) -> Values:
        """Values among which are lists, types, or strings with commas or brackets in them."""
        fault = Malformed(f"{inner[:40]!r} as values")
        stack: list[list[Any]] = [[]]
        kinds: list[str | None] = []
        kind: str | None = None  # written before the next value
        complete = False  # so that a comma or a closing bracket is next
        for token in _TOKEN.findall(inner):
            first = token[0]
            if first in ",)":
                nothing = first == ")" and not stack[-1] and kind is None  # as in an empty list
                if not complete and not nothing:
                    raise fault
                complete = False
                if first == ")":
                    if not kinds:
                        raise fault
                    done, of = tuple(stack.pop()), kinds.pop()
                    stack[-1].append(done if of is None else Typed(of, done[0] if done else None))
                    complete = True
            elif complete or (kind is not None and first != "("):
                raise fault
            elif first == "(":
                stack.append([])
                kinds.append(kind)
                kind = None
            elif first.isalpha():
                kind = token.upper()
            else:
                string = first == "'" and len(token) > 1  # and not a quote without another
                stack[-1].append(text_of(token[1:-1]) if string else self[token])
                complete = True
        if kinds or not complete:
            raise fault
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
