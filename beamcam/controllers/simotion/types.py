"""Types of expressions, and checks of assignments."""

import re
from collections.abc import Sequence
from typing import Literal, cast

from beamcam.controllers.simotion import axes, rules, syntax
from beamcam.controllers.simotion.names import UNKNOWN, Names, near, spelled, text_of
from beamcam.controllers.simotion.parser import RESERVED, Parser, Stop, parsed_by
from beamcam.controllers.simotion.syntax import Section, Statement, Token, tokens
from beamcam.errors import Diagnostic, Source

_NUMERIC = (*axes.NUMBERS, "integer", "real")
_WITH_A_POINT = ("REAL", "LREAL", "real")


class Types:
    """Finds types by name, and reports mismatches."""

    def __init__(self, names: Names) -> None:
        self.names = names

    def of(self, value: syntax.Expression) -> str:
        """The type of an expression."""
        match value:
            case syntax.Constant():
                return value.type
            case syntax.Name():
                return self.names.of_value(value)
            case syntax.Member():
                return self._member(value)
            case syntax.ArrayElement():
                return self._element(value)
            case syntax.Call():
                return self.call(value, as_statement=False)
            case syntax.Unary():
                type_ = self.of(value.value)
                allowed = ("BOOL",) if value.operator == "NOT" else _NUMERIC
                if type_ in (*allowed, UNKNOWN):
                    return type_
                expected = " or ".join(allowed)
                return self.names.wrong_type(value.line, type_, value.operator, expected)
            case syntax.Binary():
                return self._binary(value)

    def check(self, value: syntax.Expression, expected: str, what: str) -> None:
        """Say so if a value does not fit where a type is wanted."""
        type_ = self.of(value)
        if UNKNOWN not in (type_, expected) and not axes.fits(type_, expected):
            self.names.wrong_type(value.line, type_, what, expected)
        if isinstance(value, syntax.Constant) and value.type == "integer":
            low, high = axes.INTEGERS.get(expected, (value.value, value.value))
            if not low <= value.value <= high:
                self.names.wrong_type(value.line, str(value.value), what, expected)

    def _member(self, value: syntax.Member) -> str:
        base = self.of(value.base)
        if base == UNKNOWN:
            return UNKNOWN
        known = self.names.components(base)
        if known is None:
            expected = "something with components"
            return self.names.wrong_type(value.line, base, f".{value.name}", expected)
        if (name := spelled(value.name, known)) is not None:
            return known[name]
        return self.names.unknown(value.line, f".{value.name}", value.name, known)

    def _element(self, value: syntax.ArrayElement) -> str:
        if not isinstance(value.base, syntax.Name):
            return self.names.wrong_type(value.line, text_of(value.base), "an element", "an array")
        variable = self.names.variable(value.base.name)
        if variable is None:
            return self.names.of_value(value.base)
        if not isinstance(variable.type, syntax.Array):
            return self.names.wrong_type(value.line, str(variable.type), "an element", "an array")
        index = self.of(value.index)
        if index not in (*axes.INTEGERS, "integer", UNKNOWN):
            self.names.wrong_type(value.line, index, "an index", "a whole number")
        match value.index:
            case syntax.Constant(value=at):
                pass
            case syntax.Unary(operator="-", value=syntax.Constant(value=of)):
                at = -of
            case _:
                at = variable.type.low
        low, high = variable.type.low, variable.type.high
        if index != UNKNOWN and not low <= at <= high:
            name = variable.name
            self.names.say(rules.BOUNDS, value.line, found=at, name=name, low=low, high=high)
        return self.names.canonical(variable.type.of)

    def _binary(self, value: syntax.Binary) -> str:
        left, right = self.of(value.left), self.of(value.right)
        if UNKNOWN in (left, right):
            return "BOOL" if value.operator in axes.GIVES_BOOL else UNKNOWN
        if value.operator in axes.LOGIC:
            for one in (left, right):
                if one != "BOOL":
                    self.names.wrong_type(value.line, one, value.operator, "BOOL")
            return "BOOL"
        common = right if axes.fits(left, right) else left
        together = axes.fits(left, right) or axes.fits(right, left)
        if left.startswith("enum:") and right.startswith("enum:"):
            shared = set(axes.choices(left)) & set(axes.choices(right))
            together = bool(shared) and value.operator in ("=", "<>")
        if not together:
            what = f"{value.operator} with {axes.shown(left)}"
            self.names.wrong_type(value.line, right, what, left)
        elif value.operator in ("=", "<>") and common in _WITH_A_POINT:
            expected = "a difference within a tolerance"
            equality = "an equality of numbers with a point"
            self.names.wrong_type(value.line, equality, "a test", expected)
        elif value.operator not in ("=", "<>") and common not in (*_NUMERIC, "TIME"):
            self.names.wrong_type(value.line, common, value.operator, "numbers")
        return "BOOL" if value.operator in axes.GIVES_BOOL else common

    # -- calls ------------------------------------------------------------------------------

    def call(self, call: syntax.Call, as_statement: bool) -> str:
        """The type of what a call gives; its parameters are looked at."""
        name = call.callee
        if name.upper() in axes.FUNCTIONS:
            return self._numeric(call)
        command = spelled(name, self.names.commands)
        if command is not None:
            if as_statement:
                expected = "a variable for it, as a dropped command says so only there"
                dropped = f"{command} without its answer"
                self.names.wrong_type(call.line, dropped, "a command", expected)
            declared = axes.COMMANDS[command]
            self._parameters(call, declared.parameters, declared.needed)
            return axes.ANSWER
        variable = self.names.variable(name)
        type_ = variable.type if variable is not None else ""
        inputs = isinstance(type_, str) and self.names.of_block(type_, "input", "inout")
        if not isinstance(type_, str) or not isinstance(inputs, dict):
            own = (v.name for v in self.names.locals.values())
            known = [*self.names.commands, *axes.FUNCTIONS, *own]
            return self.names.unknown(call.line, f"{name}()", name, known)
        passed = self.names.of_block(type_, "inout") or {}
        self._parameters(call, inputs, tuple(inputs if self.names.needs_all else passed))
        for word, value, line in call.named:
            if spelled(word, passed) and not isinstance(value, syntax.Name):
                self.names.wrong_type(line, text_of(value), word, "a variable")
        if not as_statement:
            self.names.wrong_type(call.line, f"the function block {name}", "a value", "a function")
        return UNKNOWN

    def _numeric(self, call: syntax.Call) -> str:
        if len(call.placed) != 1 or call.named:
            count = len(call.placed) + len(call.named)
            return self._wrong_call(call, call.line, f"{count} values", "one")
        type_ = self.of(call.placed[0])
        allowed = _NUMERIC if call.callee.upper() == "ABS" else _WITH_A_POINT
        if type_ not in (*allowed, UNKNOWN):
            return self.names.wrong_type(call.line, type_, call.callee, " or ".join(allowed))
        return type_

    def _wrong_call(self, call: syntax.Call, line: int, found: str, expected: str) -> str:
        return self.names.say(
            rules.PARAMETER, line, found=found, callee=call.callee, expected=expected
        )

    def _parameters(self, call: syntax.Call, known: dict[str, str], needed: Sequence[str]) -> None:
        named: set[str] = set()
        if call.placed:
            expected = "names, as in position := ..."
            self._wrong_call(call, call.line, "a value without its name", expected)
        for name, value, line in call.named:
            real = spelled(name, known)
            if real is None:
                self._wrong_call(call, line, name, near(name, known))
                self.of(value)
                continue
            if real in named:
                self._wrong_call(call, line, f"{name} twice", "it once")
            named.add(real)
            self.check(value, known[real], f"{real} of {call.callee}")
        for name in needed:
            if name not in named and not call.placed:
                self._wrong_call(call, call.line, f"no {name}", f"{name} := ...")


# --- plain Structured Text: IEC 61131-3, edition 2, as strictly as a compiler of it ---------------

# Types, function blocks, programs and a configuration in one text, each declared before it is used;
# no comments to the end of a line, no empty lists of statements, no initial values where edition 2
# has none, addresses for global variables alone.


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
    words, diagnostics = tokens(text, name)
    code = _COMMENT.sub(lambda comment: re.sub(r"[^\n]", " ", comment[0]), text)
    if (foreign := _FOREIGN.search(code)) is not None:
        line = code.count("\n", 0, foreign.start()) + 1
        source = Source(name, line)
        diagnostics.append(rules.SYNTAX.at(source, found=foreign[0], expected="(* ... *)"))
    return parsed_by(_PlainParser(words), diagnostics, name)


class _PlainParser(Parser):
    def __init__(self, tokens: list[Token]) -> None:
        super().__init__([token for token in tokens if token.kind != "unit"])
        self.types = {name.upper() for name in (*axes.PLAIN_TYPES, *axes.BLOCKS)}

    def units(self) -> list[syntax.Unit]:
        structures: list[syntax.Structure] = []
        blocks: list[syntax.ProgramBlock] = []
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
        return [syntax.Unit("program", (), tuple(run), tuple(variables), tuple(blocks),
                            tuple(structures), True)]  # fmt: skip

    def structure(self) -> syntax.Structure:
        # name : STRUCT a : INT; END_STRUCT;
        token = self.identifier("the name of a type")
        self.take_each(":", "STRUCT")
        fields = []
        while not self.accept("END_STRUCT"):
            field = self.identifier("a name or END_STRUCT")
            self.take(":")
            fields.append(syntax.Variable(field.line, field.text, "local", self.type()))
            self.take(";")
        self.take(";")
        self.types.add(token.text.upper())
        return syntax.Structure(token.line, token.text, tuple(fields))

    def block(self) -> syntax.ProgramBlock:
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
        return syntax.ProgramBlock(kind.line, word, name, tuple(variables), body)

    def section(self, section: Section) -> list[syntax.Variable]:
        """The variables of a section, one or more."""
        if self.is_word("END_VAR"):
            raise Stop(self.here, "a variable")
        variables = self.variables(section)
        for variable in variables:
            if variable.initial is not None and section in _WITHOUT_VALUE:
                raise Stop(self.tokens[self.at - 1], f"no value for {variable.name}")
            if variable.address and section != "global":
                raise Stop(self.tokens[self.at - 1], f"no address for {variable.name}")
        return variables

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
        self.take_each("END_RESOURCE", "END_CONFIGURATION")
        return variables, run

    def task(self) -> str:
        # TASK name(INTERVAL := T#25ms, PRIORITY := 1);
        name = self.identifier("a name").text.upper()
        self.take_each("(", "INTERVAL", ":=")
        interval = self.unary()
        if not isinstance(interval, syntax.Constant) or interval.type != "TIME":
            raise Stop(self.tokens[self.at - 1], "a time such as T#25ms")
        self.take_each(",", "PRIORITY", ":=")
        self.whole()
        self.take_each(")", ";")
        return name

    # -- statements -------------------------------------------------------------------------

    def statements(self, *ends: str) -> tuple[Statement, ...]:
        if self.is_word(";"):
            raise Stop(self.here, "a statement")
        statements = super().statements(*ends)
        if not statements:
            raise Stop(self.here, "a statement")
        return statements
