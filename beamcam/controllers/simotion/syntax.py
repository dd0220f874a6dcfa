"""The syntax tree of Structured Text: what the parser gives, and checker and interpreter take."""

from __future__ import annotations

import re
from typing import Literal, NamedTuple

from msgspec import Struct

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
    diagnostics: list[Diagnostic] = []
    words: list[Token] = []
    line = 1
    for match in _TOKEN.finditer(text):
        kind = match.lastgroup or ""
        if kind == "odd" or not match[0].isascii():
            shown = text[match.start() : match.start() + 12].split("\n")[0]
            expected = "ASCII letters, numbers and characters of Structured Text"
            diagnostics.append(rules.SYNTAX.at(Source(name, line), found=shown, expected=expected))
        elif kind not in ("space", "comment", "newline"):
            words.append(Token(kind, match[0], line))
        line += match[0].count("\n")
    return [*words, Token("end", "", line)], diagnostics


Section = Literal["const", "global", "external", "input", "output", "inout", "local"]


class Constant(Struct, frozen=True):
    """A literal: its value, and its type; "integer" and "real" where none is written."""

    line: int
    type: str
    value: float | int | bool


class Name(Struct, frozen=True):
    """A variable, constant, axis or enumerator."""

    line: int
    name: str


class Member(Struct, frozen=True):
    """A component of a function block's instance or of an axis."""

    line: int
    base: Expression
    name: str


class ArrayElement(Struct, frozen=True):
    """An element of an array."""

    line: int
    base: Expression
    index: Expression


class Unary(Struct, frozen=True):
    """`-` or NOT."""

    line: int
    operator: str
    value: Expression


class Binary(Struct, frozen=True):
    """Two values and an operator."""

    line: int
    operator: str
    left: Expression
    right: Expression


class Call(Struct, frozen=True):
    """A function, or an instance of a function block; parameters by name or by place."""

    line: int
    callee: str
    named: tuple[tuple[str, Expression, int], ...]
    placed: tuple[Expression, ...]


Expression = Constant | Name | Member | ArrayElement | Unary | Binary | Call


class Assign(Struct, frozen=True):
    line: int
    target: Expression
    value: Expression


class Invoke(Struct, frozen=True):
    line: int
    call: Call


class If(Struct, frozen=True):
    line: int
    branches: tuple[tuple[Expression, tuple[Statement, ...]], ...]
    otherwise: tuple[Statement, ...]


class Case(Struct, frozen=True):
    line: int
    selector: Expression
    branches: tuple[tuple[tuple[int, ...], tuple[Statement, ...]], ...]
    otherwise: tuple[Statement, ...]


class For(Struct, frozen=True):
    line: int
    variable: str
    first: Expression
    last: Expression
    body: tuple[Statement, ...]


class Leave(Struct, frozen=True):
    """RETURN."""

    line: int


Statement = Assign | Invoke | If | Case | For | Leave


class Array(Struct, frozen=True):
    low: int
    high: int
    of: str


class Variable(Struct, frozen=True):
    line: int
    name: str
    section: Section
    type: str | Array
    initial: Expression | tuple[Expression, ...] | None = None
    address: str = ""


class ProgramBlock(Struct, frozen=True):
    """A PROGRAM or FUNCTION_BLOCK."""

    line: int
    kind: Literal["PROGRAM", "FUNCTION_BLOCK"]
    name: str
    variables: tuple[Variable, ...]
    body: tuple[Statement, ...]


class Structure(Struct, frozen=True):
    """A type with components."""

    line: int
    name: str
    fields: tuple[Variable, ...]


class Unit(Struct, frozen=True):
    """One source of the project; a plain one is the whole of it, without words of SIMOTION."""

    name: str
    uses: tuple[Token, ...]  #: names of other units
    exports: tuple[tuple[str, str, int], ...]  #: kind, name and line
    variables: tuple[Variable, ...]
    blocks: tuple[ProgramBlock, ...]
    structures: tuple[Structure, ...] = ()
    plain: bool = False
