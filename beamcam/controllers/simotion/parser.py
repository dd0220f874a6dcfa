"""Structured Text to a syntax tree: the language as far as trigger programs need it.

Recursive descent over tokens, one function a construct, its form above it. The first thing that
is not understood ends a text with a message, as nothing behind it can be trusted.
"""

from __future__ import annotations

import re
from collections.abc import Callable
from typing import Literal, TypeVar, cast

from beamcam.controllers.simotion import axes, rules, syntax
from beamcam.controllers.simotion.syntax import Expression, Section, Statement, Token, tokens
from beamcam.errors import Diagnostic, Source

_WORDS = """
    ACTION AND ARRAY AT BEGIN BY CASE CONFIGURATION CONSTANT DATE DO DT ELSE ELSIF END_ACTION
    END_CASE END_FOR END_FUNCTION END_FUNCTION_BLOCK END_IF END_IMPLEMENTATION END_INTERFACE
    END_PROGRAM END_REPEAT END_STRUCT END_TYPE END_VAR END_WHILE EXIT FALSE FOR FROM FUNCTION
    FUNCTION_BLOCK IF IMPLEMENTATION INTERFACE MOD NOT OF ON OR PROGRAM READ_ONLY REPEAT RETAIN
    RETURN STEP STRUCT TASK THEN TIME TO TOD TRANSITION TRUE TYPE UNTIL USELIB USEPACKAGE USES VAR
    VAR_GLOBAL VAR_INPUT VAR_IN_OUT VAR_OUTPUT VAR_TEMP WAITFORCONDITION WHILE WITH XOR
    R S LD ST N LDN STN JMP CAL RET ADD SUB MUL DIV GT GE EQ NE LE LT"""
KEYWORDS = frozenset(_WORDS.split())
_PLAIN_WORDS = """
    CONFIGURATION END_CONFIGURATION END_RESOURCE EN ENO F_EDGE INITIAL_STEP NON_RETAIN RESOURCE
    R_EDGE READ_WRITE TASK VAR_ACCESS VAR_CONFIG VAR_EXTERNAL CONCAT DELETE EXPT FIND INSERT LEFT
    LEN LIMIT LN LOG MAX MID MIN MOVE MUX REPLACE RIGHT ROL ROR SEL SHL SHR SIN COS TAN ASIN ACOS
    ATAN EXP TRUNC ABS SQRT BOOL BYTE WORD DWORD LWORD SINT INT DINT LINT USINT UINT UDINT ULINT
    REAL LREAL STRING WSTRING TON TOF TP CTU CTD CTUD SR RS R_TRIG F_TRIG SEMA RTC ANY"""
#: Words that are no names in plain IEC 61131-3 either: of configurations, types and functions.
RESERVED = frozenset(_PLAIN_WORDS.split())

_TIME = re.compile(r"(?<![\d.])(\d++(?:\.\d++)?)(ms|s|m|h|d)", re.IGNORECASE)
_TIME_S = {"ms": 0.001, "s": 1.0, "m": 60.0, "h": 3600.0, "d": 86400.0}
#: How tightly each operator between two values binds.
_LEVELS = {
    "OR": 0, "XOR": 1, "AND": 2, "&": 2, "=": 3, "<>": 3, "<": 4, ">": 4, "<=": 4, ">=": 4,
    "+": 5, "-": 5, "*": 6, "/": 6, "MOD": 6,
}  # fmt: skip
Item = TypeVar("Item")


class Stop(Exception):
    """A parse error."""

    def __init__(self, token: Token, expected: str) -> None:
        self.token, self.expected = token, expected


def _literal(token: Token) -> syntax.Constant:
    word, _, text = token.text.upper().partition("#")
    if word in ("TRUE", "FALSE"):
        return syntax.Constant(token.line, "BOOL", word == "TRUE")
    if token.kind == "number":
        plain = float(word) if "." in word else int(word)
        return syntax.Constant(token.line, "real" if "." in word else "integer", plain)
    if word in ("T", "TIME"):
        pieces = _TIME.findall(text)
        if "".join(a + b for a, b in pieces) != text or not pieces:
            raise Stop(token, "a time such as T#300ms")
        value = sum(float(a) * _TIME_S[b.lower()] for a, b in pieces)
        return syntax.Constant(token.line, "TIME", value)
    try:
        if word in ("LREAL", "REAL"):
            if "." not in text:
                raise ValueError(text)
            return syntax.Constant(token.line, word, float(text))
        if word == "BOOL":
            return syntax.Constant(token.line, word, bool(int(text)))
        low, high = axes.INTEGERS[word]
        if not low <= int(text) <= high:
            raise ValueError(text)
        return syntax.Constant(token.line, word, int(text))
    except ValueError:
        raise Stop(token, f"a value of {word}") from None


_SECTIONS: dict[str, Section] = {
    "VAR_INPUT": "input", "VAR_OUTPUT": "output", "VAR_IN_OUT": "inout", "VAR": "local",
}  # fmt: skip


def parse(text: str, name: str) -> tuple[list[syntax.Unit], list[Diagnostic]]:
    """The units of a text, and what is wrong with it."""
    words, diagnostics = tokens(text, name)
    return parsed_by(Parser(words), diagnostics, name)


def parsed_by(
    parser: Parser, diagnostics: list[Diagnostic], name: str
) -> tuple[list[syntax.Unit], list[Diagnostic]]:
    """The units that a parser takes, unless its words are wrong; and what is wrong."""
    if diagnostics:
        return [], diagnostics
    try:
        return parser.units(), []
    except Stop as stop:
        source = Source(name, stop.token.line)
        shown = stop.token.text or "the end of the text"
        return [], [rules.SYNTAX.at(source, found=shown, expected=stop.expected)]


class Parser:
    """Takes units of SIMOTION, a function a construct; what stands in a block is the same in every
    dialect."""

    def __init__(self, tokens: list[Token]) -> None:
        self.tokens, self.at = tokens, 0

    # -- words ------------------------------------------------------------------------------

    @property
    def here(self) -> Token:
        return self.tokens[self.at]

    def is_word(self, *words: str) -> bool:
        return self.here.kind in ("name", "sign") and self.here.text.upper() in words

    def take(self, *words: str) -> Token:
        if not self.is_word(*words):
            raise Stop(self.here, " or ".join(words))
        self.at += 1
        return self.tokens[self.at - 1]

    def take_each(self, *words: str) -> None:
        for word in words:
            self.take(word)

    def accept(self, *words: str) -> bool:
        if self.is_word(*words):
            self.at += 1
            return True
        return False

    def of_kind(self, kind: str, expected: str) -> Token:
        token = self.here
        if token.kind != kind:
            raise Stop(token, expected)
        self.at += 1
        return token

    def identifier(self, what: str) -> Token:
        if self.here.text.upper() in KEYWORDS:
            raise Stop(self.here, what)
        return self.of_kind("name", what)

    def separated(self, item: Callable[[], Item]) -> list[Item]:
        """Items with commas between them, one or more."""
        items = [item()]
        while self.accept(","):
            items.append(item())
        return items

    # -- expressions ------------------------------------------------------------------------

    def expression(self, level: int = 0) -> Expression:
        """Values with operators of a level or tighter ones between them."""
        left = self.unary()
        while (own := _LEVELS.get(self.here.text.upper(), -1)) >= level:
            token = self.take(*_LEVELS)
            operator = "AND" if token.text == "&" else token.text.upper()
            left = syntax.Binary(token.line, operator, left, self.expression(own + 1))
        return left

    def unary(self) -> Expression:
        token = self.here
        if self.accept("NOT", "-"):
            return syntax.Unary(token.line, token.text.upper(), self.unary())
        if self.accept("("):
            inner = self.expression()
            self.take(")")
            return inner
        if token.kind in ("number", "typed") or self.is_word("TRUE", "FALSE"):
            self.at += 1
            return _literal(token)
        return self.postfix()

    def postfix(self) -> Expression:
        token = self.identifier("a name or a value")
        expression: Expression = syntax.Name(token.line, token.text)
        if self.is_word("("):
            return self.call(token)
        while True:
            if self.accept("["):
                index = self.expression()
                self.take("]")
                expression = syntax.ArrayElement(token.line, expression, index)
            elif self.accept("."):
                member = self.of_kind("name", "a component")
                expression = syntax.Member(member.line, expression, member.text)
            else:
                return expression

    def call(self, callee: Token) -> Expression:
        # name(a := 1, b := 2) or name(1, 2)
        self.take("(")
        named, placed = [], []
        while not self.is_word(")"):
            token, after = self.here, self.tokens[self.at + 1]
            if token.kind == "name" and after.text == ":=":
                self.at += 2
                named.append((token.text, self.expression(), token.line))
            else:
                placed.append(self.expression())
            if not self.accept(","):
                break
        self.take(")")
        return syntax.Call(callee.line, callee.text, tuple(named), tuple(placed))

    # -- units ------------------------------------------------------------------------------

    def units(self) -> list[syntax.Unit]:
        units = []
        while self.here.kind != "end":
            name = "unit"
            if self.here.kind == "unit":
                name = self.here.text.split()[3]
                self.at += 1
            units.append(self.unit(name))
        if not units:
            raise Stop(self.here, "INTERFACE")
        return units

    def unit(self, name: str) -> syntax.Unit:
        # INTERFACE USEPACKAGE p; USES u, v; VAR_GLOBAL ... END_VAR FUNCTION_BLOCK f; END_INTERFACE
        self.take("INTERFACE")
        uses: list[Token] = []
        exports: list[tuple[str, str, int]] = []
        variables: list[syntax.Variable] = []
        while not self.accept("END_INTERFACE"):
            if self.accept("USEPACKAGE"):
                self.identifier("a technology package")
                self.take(";")
            elif self.accept("USES"):
                uses += self.separated(lambda: self.identifier("the name of a unit"))
                self.take(";")
            elif self.accept("VAR_GLOBAL"):
                section: Section = "const" if self.accept("CONSTANT") else "global"
                variables += self.variables(section)
            else:
                kind = self.take("FUNCTION_BLOCK", "PROGRAM", "VAR_GLOBAL", "END_INTERFACE")
                token = self.identifier("a name")
                exports.append((kind.text.upper(), token.text, token.line))
                self.take(";")
        self.take("IMPLEMENTATION")
        blocks = []
        while not self.accept("END_IMPLEMENTATION"):
            blocks.append(self.block())
        return syntax.Unit(name, tuple(uses), tuple(exports), tuple(variables), tuple(blocks))

    def block(self) -> syntax.ProgramBlock:
        # FUNCTION_BLOCK name VAR_INPUT ... END_VAR statements END_FUNCTION_BLOCK
        kind = self.take("FUNCTION_BLOCK", "PROGRAM", "END_IMPLEMENTATION")
        word = cast('Literal["PROGRAM", "FUNCTION_BLOCK"]', kind.text.upper())
        name = self.identifier("a name").text
        variables: list[syntax.Variable] = []
        while self.is_word(*_SECTIONS):
            section = _SECTIONS[self.take(*_SECTIONS).text.upper()]
            variables += self.variables(section)
        return syntax.ProgramBlock(
            kind.line, word, name, tuple(variables), self.statements("END_" + word)
        )

    def variables(self, section: Section) -> list[syntax.Variable]:
        # name AT %Q0.0 : TYPE := value;
        variables = []
        while not self.accept("END_VAR"):
            token = self.of_kind("name", "a name or END_VAR")
            address = ""
            if self.accept("AT"):
                address = self.of_kind("address", "an address such as %Q0.0").text
            self.take(":")
            type_ = self.type()
            initial: Expression | tuple[Expression, ...] | None = None
            if self.accept(":="):
                if self.accept("["):
                    initial = tuple(self.separated(self.expression))
                    self.take("]")
                else:
                    initial = self.expression()
            self.take(";")
            variables.append(
                syntax.Variable(token.line, token.text, section, type_, initial, address)
            )
        return variables

    def type(self) -> str | syntax.Array:
        if self.accept("ARRAY"):
            self.take("[")
            low = self.whole()
            self.take("..")
            high = self.whole()
            self.take_each("]", "OF")
            return syntax.Array(low, high, self.type_name())
        return self.type_name()

    def type_name(self) -> str:
        return self.of_kind("name", "a type").text

    def whole(self) -> int:
        sign = -1 if self.accept("-") else 1
        token = self.here
        if token.kind != "number" or not token.text.isdigit():
            raise Stop(token, "a whole number")
        self.at += 1
        return sign * int(token.text)

    # -- statements -------------------------------------------------------------------------

    def statements(self, *ends: str) -> tuple[Statement, ...]:
        statements: list[Statement] = []
        while not self.is_word(*ends):
            if self.accept(";"):
                continue
            if self.here.kind == "number":  # a label of CASE
                return tuple(statements)
            statements.append(self.statement(ends))
            self.take(";")
        if ends[0] not in ("END_IF", "END_CASE"):
            self.take(*ends)
        return tuple(statements)

    def statement(self, ends: tuple[str, ...]) -> Statement:
        token = self.here
        if self.accept("IF"):
            return self.if_(token.line)
        if self.accept("CASE"):
            return self.case(token.line)
        if self.accept("FOR"):
            return self.for_(token.line)
        if self.accept("RETURN"):
            return syntax.Leave(token.line)
        if token.kind != "name" or token.text.upper() in KEYWORDS:
            raise Stop(token, f"a statement or {ends[-1]}")
        target = self.postfix()
        if isinstance(target, syntax.Call):
            return syntax.Invoke(token.line, target)
        self.take(":=")
        return syntax.Assign(token.line, target, self.expression())

    def if_(self, line: int) -> Statement:
        # IF a THEN ... ELSIF b THEN ... ELSE ... END_IF;
        branches = [self._branch()]
        while self.accept("ELSIF"):
            branches.append(self._branch())
        otherwise = self.statements("END_IF") if self.accept("ELSE") else ()
        self.take("END_IF")
        return syntax.If(line, tuple(branches), otherwise)

    def _branch(self) -> tuple[Expression, tuple[Statement, ...]]:
        condition = self.expression()
        self.take("THEN")
        return condition, self.statements("END_IF", "ELSIF", "ELSE")

    def case(self, line: int) -> Statement:
        # CASE a OF 1, 2: ... ELSE ... END_CASE;
        selector = self.expression()
        self.take("OF")
        branches = []
        while not self.is_word("END_CASE", "ELSE"):
            labels = self.separated(self.whole)
            self.take(":")
            branches.append((tuple(labels), self.statements("END_CASE", "ELSE")))
        otherwise = self.statements("END_CASE") if self.accept("ELSE") else ()
        self.take("END_CASE")
        return syntax.Case(line, selector, tuple(branches), otherwise)

    def for_(self, line: int) -> Statement:
        # FOR k := 1 TO 9 DO ... END_FOR;
        variable = self.identifier("a variable").text
        self.take(":=")
        first = self.expression()
        self.take("TO")
        last = self.expression()
        self.take("DO")
        return syntax.For(line, variable, first, last, self.statements("END_FOR"))
