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
      | (?P<address>%[IQ]\d+\.\d+)
      | (?P<number>\d+\.(?!\.)\d+(?:[eE][+-]?\d+)?|\d+)
      | (?P<name>[A-Za-z_]\w*)
      | (?P<sign>:=|<=|>=|<>|=>|\.\.|\*\*|[-+*/<>=();:,.\[\]&])
    """,
    re.VERBOSE | re.DOTALL | re.IGNORECASE,
)


def tokens(text: str, name: str) -> tuple[list[Token], list[Diagnostic]]:
    """The tokens of a text, an `end` behind them, and what is no token or not ASCII."""
    said: list[Diagnostic] = []
    return list(_tokens(text, name, said)), said


def _tokens(text: str, name: str, said: list[Diagnostic]) -> Iterator[Token]:
    line, at = 1, 0
    while at < len(text):
        match = _TOKEN.match(text, at)
        if match is None or not match[0].isascii():
            shown = text[at : at + 12].split("\n")[0]
            expected = "ASCII letters, numbers and characters of Structured Text"
            said.append(rules.SYNTAX.at(Source(name, line), found=shown, expected=expected))
            at += len(match[0]) if match else 1
            continue
        kind = match.lastgroup or ""
        if kind not in ("space", "comment", "newline"):
            yield Token(kind, match[0], line)
        line += match[0].count("\n")
        at = match.end()
    yield Token("end", "", line)
