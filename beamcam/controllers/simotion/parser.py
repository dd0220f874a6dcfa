"""Structured Text to a syntax tree: the language as far as trigger programs need it.

Recursive descent over tokens, one function a construct, its form above it. The first thing that
is not understood ends a text with a message, as nothing behind it can be trusted.
"""

from __future__ import annotations

from typing import Literal, cast

from beamcam.controllers.simotion import rules, syntax
from beamcam.controllers.simotion.expressions import KEYWORDS, Expressions, Stop
from beamcam.controllers.simotion.syntax import Expression, Section, Statement, Token, tokens
from beamcam.errors import Diagnostic, Source

_SECTIONS: dict[str, Section] = {
    "VAR_INPUT": "input", "VAR_OUTPUT": "output", "VAR_IN_OUT": "inout", "VAR": "local",
}  # fmt: skip


def parse(text: str, name: str) -> tuple[list[syntax.Unit], list[Diagnostic]]:
    """The units of a text, and what is wrong with it."""
    found, diagnostics = tokens(text, name)
    if diagnostics:
        return [], diagnostics
    parser = Parser(found)
    try:
        return parser.units(), []
    except Stop as stop:
        source = Source(name, stop.token.line)
        shown = stop.token.text or "the end of the text"
        return [], [rules.SYNTAX.at(source, found=shown, expected=stop.expected)]


class Parser(Expressions):
    """Takes units of SIMOTION; what stands in a block is the same in every dialect."""

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
                initial = self.array_values() if self.is_word("[") else self.expression()
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
            self.take("]")
            self.take("OF")
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

    def array_values(self) -> tuple[Expression, ...]:
        self.take("[")
        values = self.separated(self.expression)
        self.take("]")
        return tuple(values)

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
