"""Plain Structured Text to a syntax tree: IEC 61131-3, edition 2, as strictly as a compiler of it.

Types, function blocks, programs and a configuration in one text, each declared before it is used;
no comments to the end of a line, no empty lists of statements, no initial values where edition 2
has none, addresses for global variables alone.
"""

import re
from typing import Literal, cast

from beamcam.controllers.simotion import library, rules, syntax
from beamcam.controllers.simotion.expressions import RESERVED, Stop
from beamcam.controllers.simotion.lexer import Token, tokens
from beamcam.controllers.simotion.parser import Parser
from beamcam.controllers.simotion.syntax import Section, Statement
from beamcam.errors import Diagnostic, Source

#: Sections of a block in their order: what is passed, then what is its own.
_PASSED: dict[str, Section] = {
    "VAR_INPUT": "input", "VAR_OUTPUT": "output", "VAR_IN_OUT": "inout",
}  # fmt: skip
_OWN: dict[str, Section] = {"VAR_EXTERNAL": "external", "VAR": "local"}
_WITHOUT_VALUE = ("inout", "external")

_COMMENT = re.compile(r"\(\*.*?\*\)", re.DOTALL)
_FOREIGN = re.compile(r"//[^\n]*")


def parse_plain(text: str, name: str) -> tuple[list[syntax.Unit], list[Diagnostic]]:
    """The one unit of a text, and what is wrong with it."""
    found, said = tokens(text, name)
    code = _COMMENT.sub(lambda comment: re.sub(r"[^\n]", " ", comment[0]), text)
    if (foreign := _FOREIGN.search(code)) is not None:
        line = code.count("\n", 0, foreign.start()) + 1
        said.append(rules.SYNTAX.at(Source(name, line), found=foreign[0], expected="(* ... *)"))
    if said:
        return [], said
    try:
        return [_PlainParser(found).program()], []
    except Stop as stop:
        source = Source(name, stop.token.line)
        shown = stop.token.text or "the end of the text"
        return [], [rules.SYNTAX.at(source, found=shown, expected=stop.expected)]


class _PlainParser(Parser):
    def __init__(self, found: list[Token]) -> None:
        super().__init__([token for token in found if token.kind != "unit"])
        self.types = {name.upper() for name in (*library.PLAIN_TYPES, *library.BLOCKS)}

    def program(self) -> syntax.Unit:
        structures: list[syntax.Structure] = []
        blocks: list[syntax.Block] = []
        variables: list[syntax.Variable] = []
        run: list[tuple[str, str, int]] = []
        while self.here.kind != "end":
            if self.accept("TYPE"):
                while not self.accept("END_TYPE"):
                    structures.append(self.structure())
            elif self.is_word("CONFIGURATION"):
                variables, run = self.configuration()
            else:
                blocks.append(self.block())
        if not run:
            raise Stop(self.here, "CONFIGURATION, with a task that runs a program")
        return syntax.Unit(
            "program", (), tuple(run), tuple(variables), tuple(blocks), tuple(structures), True
        )

    def structure(self) -> syntax.Structure:
        # name : STRUCT a : INT; END_STRUCT;
        token = self.identifier("the name of a type")
        for word in (":", "STRUCT"):
            self.take(word)
        fields = []
        while not self.accept("END_STRUCT"):
            field = self.identifier("a name or END_STRUCT")
            self.take(":")
            fields.append(syntax.Variable(field.line, field.text, "local", self.type()))
            self.take(";")
        self.take(";")
        self.types.add(token.text.upper())
        return syntax.Structure(token.line, token.text, tuple(fields))

    def block(self) -> syntax.Block:
        # FUNCTION_BLOCK name VAR_INPUT ... END_VAR statements END_FUNCTION_BLOCK
        kind = self.take("FUNCTION_BLOCK", "PROGRAM", "TYPE", "CONFIGURATION")
        name = self.identifier("a name").text
        variables: list[syntax.Variable] = []
        for sections in (_PASSED, _OWN):
            while self.is_word(*sections):
                word = self.take(*sections).text.upper()
                constant = word == "VAR" and self.accept("CONSTANT")
                variables += self.section("const" if constant else sections[word])
        if not variables:
            raise Stop(self.here, "a section of variables")
        word = cast('Literal["PROGRAM", "FUNCTION_BLOCK"]', kind.text.upper())
        body = self.statements("END_" + word)
        if word == "FUNCTION_BLOCK":
            self.types.add(name.upper())
        return syntax.Block(kind.line, word, name, tuple(variables), body)

    def section(self, section: Section) -> list[syntax.Variable]:
        """The variables of a section, one or more."""
        if self.is_word("END_VAR"):
            raise Stop(self.here, "a variable")
        found = self.variables(section)
        for variable in found:
            if variable.initial is not None and section in _WITHOUT_VALUE:
                raise Stop(self.tokens[self.at - 1], f"no value for {variable.name}")
            if variable.address and section != "global":
                raise Stop(self.tokens[self.at - 1], f"no address for {variable.name}")
        return found

    def type_name(self) -> str:
        token = self.here
        if token.text.upper() not in self.types:
            raise Stop(token, "a type that is declared before")
        return super().type_name()

    def identifier(self, what: str) -> Token:
        if self.here.text.upper() in RESERVED and self.tokens[self.at + 1].text != "(":
            raise Stop(self.here, what)
        return super().identifier(what)

    # -- configuration ----------------------------------------------------------------------

    def configuration(self) -> tuple[list[syntax.Variable], list[tuple[str, str, int]]]:
        """Global variables, and the programs that a task runs."""
        self.take("CONFIGURATION")
        self.identifier("a name")
        variables: list[syntax.Variable] = []
        while self.accept("VAR_GLOBAL"):
            variables += self.section("const" if self.accept("CONSTANT") else "global")
        self.take("RESOURCE")
        self.identifier("a name")
        self.take("ON")
        self.identifier("the type of a resource")
        tasks = []
        while self.accept("TASK"):
            tasks.append(self.task())
        run = []
        while self.accept("PROGRAM"):
            # PROGRAM instance WITH task : type;
            self.identifier("a name")
            self.take("WITH")
            self.take(*tasks)
            self.take(":")
            token = self.identifier("a program")
            run.append(("PROGRAM", token.text, token.line))
            self.take(";")
        self.take("END_RESOURCE")
        self.take("END_CONFIGURATION")
        return variables, run

    def task(self) -> str:
        # TASK name(INTERVAL := T#25ms, PRIORITY := 1);
        name = self.identifier("a name").text.upper()
        self.take("(")
        self.take("INTERVAL")
        self.take(":=")
        interval = self.unary()
        if not isinstance(interval, syntax.Constant) or interval.type != "TIME":
            raise Stop(self.tokens[self.at - 1], "a time such as T#25ms")
        self.take(",")
        self.take("PRIORITY")
        self.take(":=")
        self.whole()
        self.take(")")
        self.take(";")
        return name

    # -- statements -------------------------------------------------------------------------

    def statements(self, *ends: str) -> tuple[Statement, ...]:
        if self.is_word(";"):
            raise Stop(self.here, "a statement")
        found = super().statements(*ends)
        if not found:
            raise Stop(self.here, "a statement")
        return found
