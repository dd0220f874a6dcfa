"""The values in the text of a record, of a file that ifcopenshell does not read as it is written.

    .AREA.,'bolt hole',#5,9.            ('AREA', 'bolt hole', <#5>, 9.0)

It leaves out records of classes that the schema has not, members of a list that are of another kind
than the first or refer to no record, and words that the schema does not list. Of such a file each
record says itself what it holds, so that a fault refuses the members that have it and no other.
"""

import re
from collections.abc import Callable, Iterator
from typing import Any

from msgspec import Struct

from beamcam.readers.ifc.text import ESCAPE, Malformed, letters_of

Values = tuple[Any, ...]

_TOKEN = re.compile(r"'[^']*+(?:''[^']*+)*+'|[^\s,()']++|[(),']")
#: A real number has a point, and 1.E-05 is one.
_NUMBER = re.compile(r"[-+]?(?:\d++|(?:\d++\.\d*+|\.\d++)(?:[Ee][-+]?\d++)?)", re.ASCII)
_WORD = re.compile(r"\.(\w++)\.|\"(\w*+)\"", re.ASCII)
_KIND = re.compile(r"[A-Za-z]\w*+", re.ASCII)
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
    if not inner.strip():
        return ()
    tokens = iter(_TOKEN.findall(inner + ")"))
    try:
        found = _list(tokens, inner, referred)
    except RecursionError:
        raise Malformed("values too deep inside one another") from None
    if next(tokens, None) is not None:
        raise Malformed(f"{inner[:40]!r} as values")
    return found


def _list(tokens: Iterator[str], inner: str, referred: Callable[[int], Any]) -> Values:
    """The values up to the bracket that closes a list."""
    fault = Malformed(f"{inner[:40]!r} as values")
    found: list[Any] = []
    for token in tokens:
        if token == ")" and not found:
            return ()
        if token == "(":
            value: Any = _list(tokens, inner, referred)
        elif _KIND.fullmatch(token):
            if next(tokens, None) != "(":
                raise fault
            held = _list(tokens, inner, referred)
            value = Typed(token.upper(), held[0] if held else None)
        elif token in ",)":
            raise fault
        else:
            value = _value(token, referred)
        found.append(value)
        if (behind := next(tokens, None)) == ")":
            return tuple(found)
        if behind != ",":
            raise fault
    raise fault


def _value(token: str, referred: Callable[[int], Any]) -> Any:
    if token in _CONSTANTS:
        return _CONSTANTS[token]
    if token[0] == "#" and token[1:].isdecimal() and len(token) < 20:
        return referred(int(token[1:]))
    if token[0] == "'" and len(token) > 1:
        return ESCAPE.sub(letters_of, token[1:-1].replace("''", "'"))
    if (word := _WORD.fullmatch(token)) is not None:
        return word[1] if word[1] is not None else word[2]
    if _NUMBER.fullmatch(token) is None or len(token) > _MOST_DIGITS:
        raise Malformed(f"{token[:40]!r} as a value")
    return float(token) if "." in token else int(token)
