"""Names, types, parameters and bounds of Structured Text, each fault with its line."""

from collections.abc import Mapping, Sequence

from beamcam.controllers.simotion import axes, rules, syntax
from beamcam.controllers.simotion.names import UNKNOWN, Names, near, text_of
from beamcam.controllers.simotion.parser import KEYWORDS
from beamcam.controllers.simotion.types import Types
from beamcam.errors import Diagnostic

MAX_NAME = 32


def check(units: Sequence[syntax.Unit], objects: Mapping[str, str], name: str) -> list[Diagnostic]:
    """All faults of units by themselves.

    `objects` are the project's own with their types: axes, path objects, inputs and outputs.
    """
    return _Checker(units, Names(units, objects, name)).check()


class _Checker:
    def __init__(self, units: Sequence[syntax.Unit], names: Names) -> None:
        self.units, self.names, self.types = units, names, Types(names)
        self.shared: dict[str, syntax.Variable] = {}  #: global ones that blocks declare external

    # -- units ------------------------------------------------------------------------------

    def check(self) -> list[Diagnostic]:
        by_name = {u.name.upper(): u for u in self.units}
        for unit in self.units:
            used: dict[str, syntax.Variable] = {}
            for word in unit.uses:
                other = by_name.get(word.text.upper())
                if other is None:
                    expected = near(word.text, by_name)
                    self.names.say(
                        rules.NAME, word.line, found=f"unit {word.text}", expected=expected
                    )
                else:
                    used |= {v.name.upper(): v for v in other.variables}
            self._exports(unit)
            self.names.globals, self.names.locals = used, {}
            self._declare(unit.variables, used)
            if unit.plain:  # a block sees of the global variables those that it declares itself
                self.shared, self.names.globals = used, {}
            for block in unit.blocks:
                self._block(block)
        return sorted(self.names.diagnostics, key=lambda d: d.source.line or 0)

    def _exports(self, unit: syntax.Unit) -> None:
        own = {b.name.upper(): b for b in unit.blocks}
        for kind, name, line in unit.exports:
            block = own.get(name.upper())
            if block is None or block.kind != kind:
                self.names.say(rules.NAME, line, found=f"{kind} {name}", expected=near(name, own))
        exported = {name.upper() for _, name, _ in unit.exports}
        for block in unit.blocks:
            if block.kind == "PROGRAM" and block.name.upper() not in exported:
                self.names.say(
                    rules.NAME, block.line, found=f"PROGRAM {block.name}",
                    expected="its name in the INTERFACE, so that a task can call it",
                )  # fmt: skip
            if [b.name.upper() for b in unit.blocks].count(block.name.upper()) > 1:
                self.names.twice(block.name, block.line)

    def _declare(
        self, variables: Sequence[syntax.Variable], seen: dict[str, syntax.Variable]
    ) -> None:
        """Put variables to those that can be seen already."""
        for variable in variables:
            key, line = variable.name.upper(), variable.line
            if key in KEYWORDS or key in self.names.reserved:
                self.names.say(
                    rules.DECLARED, line, found=variable.name, how="as a variable",
                    expected="another, as it means something already",
                )  # fmt: skip
            if "__" in key or len(key) > MAX_NAME:
                self.names.say(
                    rules.DECLARED, line, found=variable.name, how="so",
                    expected=f"at most {MAX_NAME} letters without __",
                )  # fmt: skip
            if key in seen or key in self.names.objects:
                self.names.twice(variable.name, line)
            seen[key] = variable
            self._variable(variable)

    def _variable(self, variable: syntax.Variable) -> None:
        type_ = variable.type
        if variable.section == "external":
            self._external(variable)
        plain = type_.of if isinstance(type_, syntax.Array) else type_
        known = self.names.types()
        if plain.upper() not in known:
            self.names.say(
                rules.NAME, variable.line, found=f"type {plain}",
                expected=near(plain, known.values()),
            )  # fmt: skip
            return
        if isinstance(type_, syntax.Array) and type_.high < type_.low:
            self.names.say(
                rules.BOUNDS, variable.line, found=type_.high, name=variable.name,
                low=type_.low, high="more",
            )  # fmt: skip
            return
        initial = variable.initial
        if initial is None:
            if variable.section == "const":
                self.names.say(
                    rules.DECLARED, variable.line, found=variable.name, how="as a constant",
                    expected="a value for it",
                )  # fmt: skip
            return
        values = initial if isinstance(initial, tuple) else (initial,)
        if isinstance(type_, syntax.Array):
            count = type_.high - type_.low + 1
            if len(values) != count:
                self.names.say(
                    rules.COUNT, variable.line, found=len(values), name=variable.name,
                    expected=count,
                )  # fmt: skip
        elif isinstance(initial, tuple):
            self.names.wrong_type(variable.line, "a list", variable.name, plain)
            return
        for value in values:
            self.types.check(value, plain, variable.name)

    def _external(self, variable: syntax.Variable) -> None:
        """An external variable is a global one, of the same type."""
        other = self.shared.get(variable.name.upper())
        if other is None:
            expected = near(variable.name, [v.name for v in self.shared.values()])
            found = f"the external {variable.name}"
            self.names.say(rules.NAME, variable.line, found=found, expected=expected)
        elif other.type != variable.type or other.section == "const":
            self.names.wrong_type(
                variable.line, str(variable.type), f"the external {variable.name}", str(other.type)
            )

    def _block(self, block: syntax.ProgramBlock) -> None:
        self.names.locals = {}
        self._declare(block.variables, self.names.locals)
        self._statements(block.body)

    # -- statements -------------------------------------------------------------------------

    def _statements(self, body: Sequence[syntax.Statement]) -> None:
        for one in body:
            match one:
                case syntax.Assign():
                    type_name = self._target(one.target)
                    self.types.check(one.value, type_name, text_of(one.target))
                case syntax.Invoke(call=call):
                    self.types.call(call, as_statement=True)
                case syntax.If():
                    for condition, inner in one.branches:
                        self.types.check(condition, "BOOL", "a condition")
                        self._statements(inner)
                    self._statements(one.otherwise)
                case syntax.Case():
                    found = self.types.of(one.selector)
                    if found not in (*axes.INTEGERS, UNKNOWN):
                        self.names.wrong_type(one.line, found, "a CASE", "a whole number")
                    labels: list[int] = []
                    for branch, inner in one.branches:
                        for label in branch:
                            if label in labels:
                                self.names.twice(f"label {label}", one.line)
                            labels.append(label)
                        self._statements(inner)
                    self._statements(one.otherwise)
                case syntax.For():
                    type_name = self._target(syntax.Name(one.line, one.variable))
                    self.types.check(one.first, type_name, one.variable)
                    self.types.check(one.last, type_name, one.variable)
                    self._statements(one.body)
                case syntax.Leave():
                    pass

    def _target(self, target: syntax.Expression) -> str:
        if isinstance(target, syntax.Name):
            variable = self.names.variable(target.name)
            if variable is not None and variable.section == "external":
                variable = self.shared.get(target.name.upper())
            if variable is not None and variable.section in ("const", "input"):
                self.names.say(
                    rules.TYPE, target.line, found=f"a value for the {variable.section} "
                    f"{target.name}", what="an assignment",
                    expected="a variable that may be written",
                )  # fmt: skip
            elif variable is not None and variable.address.upper().startswith("%I"):
                self.names.say(
                    rules.TYPE, target.line, found=f"a value for the input {target.name}",
                    what="an assignment", expected="an output or a variable",
                )  # fmt: skip
        elif not isinstance(target, syntax.ArrayElement):
            return self.names.wrong_type(
                target.line, text_of(target), "an assignment", "a variable"
            )
        return self.types.of(target)
