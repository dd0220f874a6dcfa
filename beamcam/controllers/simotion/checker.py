"""Names, types, parameters and bounds of Structured Text, each fault with its line."""

from collections.abc import Mapping, Sequence

from beamcam.controllers.simotion import axes, rules, syntax
from beamcam.controllers.simotion.names import UNKNOWN, Names, text_of
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
                    self.names.unknown(word.line, f"unit {word.text}", word.text, by_name)
                else:
                    used |= {v.name.upper(): v for v in other.variables}
            self._exports(unit)
            self.names.globals, self.names.locals = used, {}
            self._declare(unit.variables, used)
            if unit.plain:  # a block sees of the global variables those that it declares itself
                self.shared, self.names.globals = used, {}
            for block in unit.blocks:
                self.names.locals = {}
                self._declare(block.variables, self.names.locals)
                self._statements(block.body)
        return sorted(self.names.diagnostics, key=lambda d: d.source.line or 0)

    def _exports(self, unit: syntax.Unit) -> None:
        own = {b.name.upper(): b for b in unit.blocks}
        for kind, name, line in unit.exports:
            block = own.get(name.upper())
            if block is None or block.kind != kind:
                self.names.unknown(line, f"{kind} {name}", name, own)
        exported = {name.upper() for _, name, _ in unit.exports}
        for block in unit.blocks:
            if block.kind == "PROGRAM" and block.name.upper() not in exported:
                expected = "its name in the INTERFACE, so that a task can call it"
                found = f"PROGRAM {block.name}"
                self.names.say(rules.NAME, block.line, found=found, expected=expected)
            if [b.name.upper() for b in unit.blocks].count(block.name.upper()) > 1:
                self.names.twice(block.name, block.line)

    def _declare(
        self, variables: Sequence[syntax.Variable], seen: dict[str, syntax.Variable]
    ) -> None:
        """Put variables to those that can be seen already."""
        for variable in variables:
            key = variable.name.upper()
            if key in KEYWORDS or key in self.names.reserved:
                expected = "another, as it means something already"
                self._misdeclared(variable, "as a variable", expected)
            if "__" in key or len(key) > MAX_NAME:
                self._misdeclared(variable, "so", f"at most {MAX_NAME} letters without __")
            if key in seen or key in self.names.objects:
                self.names.twice(variable.name, variable.line)
            seen[key] = variable
            self._variable(variable)

    def _misdeclared(self, variable: syntax.Variable, how: str, expected: str) -> None:
        found, line = variable.name, variable.line
        self.names.say(rules.DECLARED, line, found=found, how=how, expected=expected)

    def _variable(self, variable: syntax.Variable) -> None:
        type_ = variable.type
        if variable.section == "external":
            self._external(variable)
        plain = type_.of if isinstance(type_, syntax.Array) else type_
        known = self.names.types()
        if plain.upper() not in known:
            self.names.unknown(variable.line, f"type {plain}", plain, known.values())
            return
        if isinstance(type_, syntax.Array) and type_.high < type_.low:
            found, name = type_.high, variable.name
            line, low = variable.line, type_.low
            self.names.say(rules.BOUNDS, line, found=found, name=name, low=low, high="more")
            return
        initial = variable.initial
        if initial is None:
            if variable.section == "const":
                self._misdeclared(variable, "as a constant", "a value for it")
            return
        values = initial if isinstance(initial, tuple) else (initial,)
        if isinstance(type_, syntax.Array):
            count = type_.high - type_.low + 1
            if len(values) != count:
                name, found = variable.name, len(values)
                self.names.say(rules.COUNT, variable.line, found=found, name=name, expected=count)
        elif isinstance(initial, tuple):
            self.names.wrong_type(variable.line, "a list", variable.name, plain)
            return
        for value in values:
            self.types.check(value, plain, variable.name)

    def _external(self, variable: syntax.Variable) -> None:
        """An external variable is a global one, of the same type."""
        other, external = self.shared.get(variable.name.upper()), f"the external {variable.name}"
        if other is None:
            known = [v.name for v in self.shared.values()]
            self.names.unknown(variable.line, external, variable.name, known)
        elif other.type != variable.type or other.section == "const":
            type_, expected = str(variable.type), str(other.type)
            self.names.wrong_type(variable.line, type_, external, expected)

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
                    selector = self.types.of(one.selector)
                    if selector not in (*axes.INTEGERS, UNKNOWN):
                        self.names.wrong_type(one.line, selector, "a CASE", "a whole number")
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
                name = f"{variable.section} {target.name}"
                self._not_written(target.line, name, "a variable that may be written")
            elif variable is not None and variable.address.upper().startswith("%I"):
                self._not_written(target.line, f"input {target.name}", "an output or a variable")
        elif not isinstance(target, syntax.ArrayElement):
            text = text_of(target)
            return self.names.wrong_type(target.line, text, "an assignment", "a variable")
        return self.types.of(target)

    def _not_written(self, line: int, name: str, expected: str) -> None:
        found, what = f"a value for the {name}", "an assignment"
        self.names.say(rules.TYPE, line, found=found, what=what, expected=expected)
