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


class Node(Struct, frozen=True):
    """What begins on a line of the text."""

    line: int


class Constant(Node, frozen=True):
    """A literal: its value, and its type; "integer" and "real" where none is written."""

    type: str
    value: float | int | bool


class Name(Node, frozen=True):
    """A variable, constant, axis or enumerator."""

    name: str


class Member(Node, frozen=True):
    """A component of a function block's instance or of an axis."""

    base: Expression
    name: str


class ArrayElement(Node, frozen=True):
    """An element of an array."""

    base: Expression
    index: Expression


class Unary(Node, frozen=True):
    """`-` or NOT."""

    operator: str
    value: Expression


class Binary(Node, frozen=True):
    """Two values and an operator."""

    operator: str
    left: Expression
    right: Expression


class Call(Node, frozen=True):
    """A function, or an instance of a function block; parameters by name or by place."""

    callee: str
    named: tuple[tuple[str, Expression, int], ...]
    placed: tuple[Expression, ...]


Expression = Constant | Name | Member | ArrayElement | Unary | Binary | Call


class Assign(Node, frozen=True):
    target: Expression
    value: Expression


class Invoke(Node, frozen=True):
    call: Call


class If(Node, frozen=True):
    branches: tuple[tuple[Expression, tuple[Statement, ...]], ...]
    otherwise: tuple[Statement, ...]


class Case(Node, frozen=True):
    selector: Expression
    branches: tuple[tuple[tuple[int, ...], tuple[Statement, ...]], ...]
    otherwise: tuple[Statement, ...]


class For(Node, frozen=True):
    variable: str
    first: Expression
    last: Expression
    body: tuple[Statement, ...]


class Leave(Node, frozen=True):
    """RETURN."""


Statement = Assign | Invoke | If | Case | For | Leave


class Array(Struct, frozen=True):
    low: int
    high: int
    of: str


class Variable(Node, frozen=True):
    name: str
    section: Section
    type: str | Array
    initial: Expression | tuple[Expression, ...] | None = None
    address: str = ""


class ProgramBlock(Node, frozen=True):
    """A PROGRAM or FUNCTION_BLOCK."""

    kind: Literal["PROGRAM", "FUNCTION_BLOCK"]
    name: str
    variables: tuple[Variable, ...]
    body: tuple[Statement, ...]


class Structure(Node, frozen=True):
    """A type with components."""

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
