"""Structured Text as tokens."""

import re
from collections.abc import Iterator
from typing import NamedTuple

from beamcam.controllers.simotion import rules
from beamcam.errors import Diagnostic, Source


class Token(NamedTuple):
    """A word of the text: `kind` is name, number, typed, address, sign, unit or end."""

    kind: str
    text: str
    line: int


_TOKEN = re.compile(
    r"""(?P<unit>\(\*\ =====\ UNIT\ \w+\ =====\ \*\))
      | (?P<comment>\(\*.*?\*\)|//[^\n]*)
      | (?P<space>[ \t\r]+)
      | (?P<newline>\n)
      | (?P<typed>(?:LREAL|REAL|USINT|UINT|UDINT|SINT|INT|DINT|BOOL|TIME|T)
            \#-?[\w.]+(?:[eE][+-]?\d+)?)
      | (?P<address>%[IQ]X?\d+(?:\.\d+)*)
      | (?P<number>\d+\.(?!\.)\d+(?:[eE][+-]?\d+)?|\d+)
      | (?P<name>[A-Za-z_]\w*)
      | (?P<sign>:=|<=|>=|<>|=>|\.\.|\*\*|[-+*/<>=();:,.\[\]&])
      | (?P<odd>.)
    """,
    re.VERBOSE | re.DOTALL | re.IGNORECASE,
)


def tokens(text: str, name: str) -> tuple[list[Token], list[Diagnostic]]:
    """The tokens of a text, an `end` behind them, and what is not a token or not ASCII."""
    said: list[Diagnostic] = []
    return list(_tokens(text, name, said)), said


def _tokens(text: str, name: str, said: list[Diagnostic]) -> Iterator[Token]:
    line = 1
    for match in _TOKEN.finditer(text):
        kind = match.lastgroup or ""
        if kind == "odd" or not match[0].isascii():
            shown = text[match.start() : match.start() + 12].split("\n")[0]
            expected = "ASCII letters, numbers and characters of Structured Text"
            said.append(rules.SYNTAX.at(Source(name, line), found=shown, expected=expected))
        elif kind not in ("space", "comment", "newline"):
            yield Token(kind, match[0], line)
        line += match[0].count("\n")
    yield Token("end", "", line)
