"""Types of expressions, and checks of assignments."""

from collections.abc import Sequence

from beamcam.controllers.simotion import library, rules, syntax
from beamcam.controllers.simotion.names import UNKNOWN, Names, near, spelled, text_of

_NUMERIC = (*library.NUMBERS, "integer", "real")
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
            case syntax.Element():
                return self._element(value)
            case syntax.Call():
                return self.call(value, as_statement=False)
            case syntax.Unary():
                return self._unary(value)
            case syntax.Binary():
                return self._binary(value)

    def check(self, value: syntax.Expression, wanted: str, what: str) -> None:
        """Say so if a value does not fit where a type is wanted."""
        found = self.of(value)
        if UNKNOWN not in (found, wanted) and not library.fits(found, wanted):
            self.names.wrong_type(value.line, found, what, wanted)
        if isinstance(value, syntax.Constant) and value.type == "integer":
            low, high = library.INTEGERS.get(wanted, (value.value, value.value))
            if not low <= value.value <= high:
                self.names.wrong_type(value.line, str(value.value), what, wanted)

    def _member(self, value: syntax.Member) -> str:
        base = self.of(value.base)
        if base == UNKNOWN:
            return UNKNOWN
        known = self.names.components(base)
        if known is None:
            return self.names.wrong_type(
                value.line, base, f".{value.name}", "something with components"
            )
        if (name := spelled(value.name, known)) is not None:
            return known[name]
        return self.names.say(
            rules.NAME, value.line, found=f".{value.name}", expected=near(value.name, known)
        )

    def _element(self, value: syntax.Element) -> str:
        if not isinstance(value.base, syntax.Name):
            return self.names.wrong_type(value.line, text_of(value.base), "an element", "an array")
        variable = self.names.variable(value.base.name)
        if variable is None:
            return self.names.of_value(value.base)
        if not isinstance(variable.type, syntax.Array):
            return self.names.wrong_type(value.line, str(variable.type), "an element", "an array")
        index = self.of(value.index)
        if index not in (*library.INTEGERS, "integer", UNKNOWN):
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
            self.names.say(
                rules.BOUNDS, value.line, found=at, name=variable.name, low=low, high=high
            )
        return self.names.canonical(variable.type.of)

    def _unary(self, value: syntax.Unary) -> str:
        found = self.of(value.value)
        allowed = ("BOOL",) if value.operator == "NOT" else _NUMERIC
        if found not in (*allowed, UNKNOWN):
            return self.names.wrong_type(value.line, found, value.operator, " or ".join(allowed))
        return found

    def _binary(self, value: syntax.Binary) -> str:
        left, right = self.of(value.left), self.of(value.right)
        if UNKNOWN in (left, right):
            return "BOOL" if value.operator in library.GIVES_BOOL else UNKNOWN
        if value.operator in library.LOGIC:
            for one in (left, right):
                if one != "BOOL":
                    self.names.wrong_type(value.line, one, value.operator, "BOOL")
            return "BOOL"
        common = right if library.fits(left, right) else left
        together = library.fits(left, right) or library.fits(right, left)
        if left.startswith("enum:") and right.startswith("enum:"):
            shared = set(library.choices(left)) & set(library.choices(right))
            together = bool(shared) and value.operator in ("=", "<>")
        if not together:
            self.names.wrong_type(
                value.line, right, f"{value.operator} with {library.shown(left)}", left
            )
        elif value.operator in ("=", "<>") and common in _WITH_A_POINT:
            self.names.wrong_type(
                value.line, "an equality of numbers with a point", "a test",
                "a difference within a tolerance",
            )  # fmt: skip
        elif value.operator not in ("=", "<>") and common not in (*_NUMERIC, "TIME"):
            self.names.wrong_type(value.line, common, value.operator, "numbers")
        return "BOOL" if value.operator in library.GIVES_BOOL else common

    # -- calls ------------------------------------------------------------------------------

    def call(self, call: syntax.Call, as_statement: bool) -> str:
        """The type of what a call gives; its parameters are looked at."""
        name = call.callee
        if name.upper() in library.FUNCTIONS:
            return self._numeric(call)
        command = spelled(name, self.names.commands)
        if command is not None:
            if as_statement:
                self.names.wrong_type(
                    call.line, f"{command} without its answer", "a command",
                    "a variable for it, as a dropped command says so only there",
                )  # fmt: skip
            declared = library.COMMANDS[command]
            self._parameters(call, declared.parameters, declared.needed)
            return library.ANSWER
        inputs = self.names.inputs(name)
        if inputs is None:
            own = (v.name for v in self.names.locals.values())
            expected = near(name, [*self.names.commands, *library.FUNCTIONS, *own])
            return self.names.say(rules.NAME, call.line, found=f"{name}()", expected=expected)
        passed = self.names.inputs(name, "inout") or {}
        self._parameters(call, inputs, tuple(inputs if self.names.needs_all else passed))
        for word, value, line in call.named:
            if spelled(word, passed) and not isinstance(value, syntax.Name):
                self.names.wrong_type(line, text_of(value), word, "a variable")
        if not as_statement:
            self.names.wrong_type(call.line, f"the function block {name}", "a value", "a function")
        return UNKNOWN

    def _numeric(self, call: syntax.Call) -> str:
        if len(call.placed) != 1 or call.named:
            found = f"{len(call.placed) + len(call.named)} values"
            self.names.say(
                rules.PARAMETER, call.line, found=found, callee=call.callee, expected="one"
            )
            return UNKNOWN
        found = self.of(call.placed[0])
        allowed = _NUMERIC if call.callee.upper() == "ABS" else _WITH_A_POINT
        if found not in (*allowed, UNKNOWN):
            return self.names.wrong_type(call.line, found, call.callee, " or ".join(allowed))
        return found

    def _parameters(self, call: syntax.Call, known: dict[str, str], needed: Sequence[str]) -> None:
        given: set[str] = set()
        if call.placed:
            self.names.say(
                rules.PARAMETER, call.line, found="a value without its name", callee=call.callee,
                expected="names, as in position := ...",
            )  # fmt: skip
        for name, value, line in call.named:
            real = spelled(name, known)
            if real is None:
                self.names.say(
                    rules.PARAMETER, line, found=name, callee=call.callee,
                    expected=near(name, known),
                )  # fmt: skip
                self.of(value)
                continue
            if real in given:
                self.names.say(
                    rules.PARAMETER, line, found=f"{name} twice", callee=call.callee,
                    expected="it once",
                )  # fmt: skip
            given.add(real)
            self.check(value, known[real], f"{real} of {call.callee}")
        for name in needed:
            if name not in given and not call.placed:
                self.names.say(
                    rules.PARAMETER, call.line, found=f"no {name}", callee=call.callee,
                    expected=f"{name} := ...",
                )  # fmt: skip
