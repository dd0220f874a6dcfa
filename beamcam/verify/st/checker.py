"""Names, types, parameters and bounds of Structured Text, each fault with its line."""

from collections.abc import Sequence

from beamcam.errors import Diagnostic, Rule, Source
from beamcam.verify.st import library, rules
from beamcam.verify.st.library import BLOCKS, COMMANDS, fits, shown
from beamcam.verify.st.parser import KEYWORDS
from beamcam.verify.st.syntax import (
    Array,
    Assign,
    Binary,
    Block,
    Call,
    Case,
    Constant,
    Element,
    Expression,
    For,
    If,
    Invoke,
    Leave,
    Member,
    Name,
    Statement,
    Unary,
    Unit,
    Variable,
)

UNKNOWN = "?"  #: the type of what has been complained about already
GREATEST_NAME = 32
_NUMERIC = (*library.NUMBERS, "integer", "real")


def check(
    units: Sequence[Unit], axes: Sequence[str], paths: Sequence[str], name: str
) -> list[Diagnostic]:
    """Everything that is wrong with units by themselves.

    `axes` and `paths` are the names of the project's axes and path objects.
    """
    return _Checker(units, axes, paths, name).check()


class _Checker:
    def __init__(
        self, units: Sequence[Unit], axes: Sequence[str], paths: Sequence[str], name: str
    ) -> None:
        self.units, self.name = units, name
        self.said: list[Diagnostic] = []
        self.blocks = {b.name.upper(): b for u in units for b in u.blocks}
        self.objects = {a.upper(): "posAxis" for a in axes} | {
            p.upper(): "pathObject" for p in paths
        }
        self.globals: dict[str, Variable] = {}
        self.locals: dict[str, Variable] = {}

    def say(self, rule: Rule, line: int, **values: object) -> str:
        self.said.append(rule.at(Source(self.name, line), **values))
        return UNKNOWN

    # -- units ------------------------------------------------------------------------------

    def check(self) -> list[Diagnostic]:
        names = {u.name.upper() for u in self.units}
        for unit in self.units:
            for used, line in unit.uses:
                if used.upper() not in names:
                    self.say(rules.NAME, line, found=f"unit {used}", expected=_near(used, names))
            self._exports(unit)
        by_name = {u.name.upper(): u for u in self.units}
        for unit in self.units:
            seen: dict[str, Variable] = {}
            for other in (
                *(by_name[u.upper()] for u, _ in unit.uses if u.upper() in by_name),
                unit,
            ):
                for variable in other.variables:
                    self._declare(variable, seen, others=other is unit)
            self.globals = seen
            self.locals = {}
            for variable in unit.variables:
                self._variable(variable)
            for block in unit.blocks:
                self._block(block)
        return sorted(self.said, key=lambda d: d.source.line or 0)

    def _exports(self, unit: Unit) -> None:
        own = {b.name.upper(): b for b in unit.blocks}
        for kind, name, line in unit.exports:
            block = own.get(name.upper())
            if block is None or block.kind != kind:
                self.say(rules.NAME, line, found=f"{kind} {name}", expected=_near(name, own))
        exported = {name.upper() for _, name, _ in unit.exports}
        for block in unit.blocks:
            if block.kind == "PROGRAM" and block.name.upper() not in exported:
                found = f"PROGRAM {block.name}"
                expected = "its name in the INTERFACE, so that a task can take it"
                self.say(rules.NAME, block.line, found=found, expected=expected)
            if [b.name.upper() for b in unit.blocks].count(block.name.upper()) > 1:
                self._twice(block.name, block.line)

    def _twice(self, name: str, line: int) -> None:
        self.say(rules.DECLARED, line, found=name, how="twice", expected="it once")

    def _declare(self, variable: Variable, seen: dict[str, Variable], others: bool) -> None:
        key = variable.name.upper()
        line = variable.line
        if others:
            if key in KEYWORDS or key in library.ENUMERATORS:
                how, expected = "as a variable", "another, as it means something already"
                self.say(rules.DECLARED, line, found=variable.name, how=how, expected=expected)
            if "__" in key or len(key) > GREATEST_NAME:
                expected = f"at most {GREATEST_NAME} letters without __"
                self.say(rules.DECLARED, line, found=variable.name, how="so", expected=expected)
            if key in seen or key in self.objects:
                self._twice(variable.name, line)
        seen[key] = variable

    def _variable(self, variable: Variable) -> None:
        type_ = variable.type
        plain = type_.of if isinstance(type_, Array) else type_
        known = {t.upper(): t for t in (*library.TYPES, *BLOCKS)} | {
            b.name.upper(): b.name for b in self.blocks.values() if b.kind == "FUNCTION_BLOCK"
        }
        if plain.upper() not in known:
            self.say(
                rules.NAME, variable.line, found=f"type {plain}",
                expected=_near(plain, known.values()),
            )  # fmt: skip
            return
        if isinstance(type_, Array) and type_.high < type_.low:
            self.say(
                rules.BOUNDS, variable.line, found=type_.high, name=variable.name,
                low=type_.low, high="more",
            )  # fmt: skip
            return
        initial = variable.initial
        if initial is None:
            if variable.section == "const":
                self.say(
                    rules.DECLARED, variable.line, found=variable.name, how="as a constant",
                    expected="a value for it",
                )  # fmt: skip
            return
        if isinstance(type_, Array):
            values = initial if isinstance(initial, tuple) else (initial,)
            wanted = type_.high - type_.low + 1
            if len(values) != wanted:
                self.say(
                    rules.COUNT, variable.line, found=len(values), name=variable.name,
                    expected=wanted,
                )  # fmt: skip
            for value in values:
                self._fits(value, plain, variable.name)
        elif isinstance(initial, tuple):
            self.say(rules.TYPE, variable.line, found="a list", what=variable.name, expected=plain)
        else:
            self._fits(initial, plain, variable.name)

    def _block(self, block: Block) -> None:
        self.locals = {}
        for variable in block.variables:
            self._declare(variable, self.locals, others=True)
            self._variable(variable)
        self._statements(block.body)

    # -- statements -------------------------------------------------------------------------

    def _statements(self, body: Sequence[Statement]) -> None:
        for one in body:
            match one:
                case Assign():
                    wanted = self._target(one.target)
                    self._fits(one.value, wanted, _text(one.target))
                case Invoke(call=call):
                    self._call(call, as_statement=True)
                case If():
                    for condition, inner in one.branches:
                        self._fits(condition, "BOOL", "a condition")
                        self._statements(inner)
                    self._statements(one.otherwise)
                case Case():
                    found = self._type(one.selector)
                    if found not in (*library.INTEGERS, UNKNOWN):
                        self._wrong_type(one.line, found, "a CASE", "a whole number")
                    labels: list[int] = []
                    for branch, inner in one.branches:
                        for label in branch:
                            if label in labels:
                                self._twice(f"label {label}", one.line)
                            labels.append(label)
                        self._statements(inner)
                    self._statements(one.otherwise)
                case For():
                    wanted = self._target(Name(one.line, one.variable))
                    self._fits(one.first, wanted, one.variable)
                    self._fits(one.last, wanted, one.variable)
                    self._statements(one.body)
                case Leave():
                    pass

    def _target(self, target: Expression) -> str:
        if isinstance(target, Name):
            variable = self._lookup(target.name)
            if variable is not None and variable.section in ("const", "input"):
                expected = "a variable that may be written"
                self.say(
                    rules.TYPE, target.line, found=f"a value for the {variable.section} "
                    f"{target.name}", what="an assignment", expected=expected,
                )  # fmt: skip
            elif variable is not None and variable.address.upper().startswith("%I"):
                self.say(
                    rules.TYPE, target.line, found=f"a value for the input {target.name}",
                    what="an assignment", expected="an output or a variable",
                )  # fmt: skip
        elif not isinstance(target, Element):
            return self._wrong_type(target.line, _text(target), "an assignment", "a variable")
        return self._type(target)

    def _fits(self, value: Expression, wanted: str, what: str) -> None:
        found = self._type(value)
        if UNKNOWN not in (found, wanted) and not fits(found, wanted):
            self._wrong_type(value.line, found, what, wanted)
        if isinstance(value, Constant) and value.type == "integer":
            from beamcam.verify.st.parser import INTEGERS

            low, high = INTEGERS.get(wanted, (value.value, value.value))
            if not low <= value.value <= high:
                self._wrong_type(value.line, str(value.value), what, wanted)

    def _wrong_type(self, line: int, found: str, what: str, wanted: str) -> str:
        return self.say(rules.TYPE, line, found=shown(found), what=what, expected=shown(wanted))

    # -- expressions ------------------------------------------------------------------------

    def _lookup(self, name: str) -> Variable | None:
        key = name.upper()
        return self.locals.get(key) or self.globals.get(key)

    def _type(self, value: Expression) -> str:
        match value:
            case Constant():
                return value.type
            case Name():
                return self._name(value)
            case Member():
                return self._member(value)
            case Element():
                return self._element(value)
            case Call():
                return self._call(value, as_statement=False)
            case Unary():
                return self._unary(value)
            case Binary():
                return self._binary(value)

    def _name(self, value: Name) -> str:
        variable = self._lookup(value.name)
        if variable is not None:
            if isinstance(variable.type, Array):
                return self._wrong_type(
                    value.line, f"the array {value.name}", "a value", "one of its elements"
                )
            return self._canonical(variable.type)
        key = value.name.upper()
        if key in self.objects:
            return self.objects[key]
        if key in library.ENUMERATORS:
            return f"enum:{key}"
        known = (
            *(v.name for v in self.locals.values()), *(v.name for v in self.globals.values()),
            *self.objects, *library.ENUMERATORS,
        )  # fmt: skip
        return self.say(rules.NAME, value.line, found=value.name, expected=_near(value.name, known))

    def _canonical(self, type_: str) -> str:
        for known in (*library.TYPES, *BLOCKS):
            if known.upper() == type_.upper():
                return known
        return type_

    def _member(self, value: Member) -> str:
        base = self._type(value.base)
        if base == UNKNOWN:
            return UNKNOWN
        if base in BLOCKS:
            known = BLOCKS[base][1]
        elif base == "posAxis":
            known = library.AXIS_VARIABLES
        elif base == "basicMotion":
            known = library.BASIC_MOTION
        elif base.upper() in self.blocks:
            known = {
                v.name: self._canonical(v.type)
                for v in self.blocks[base.upper()].variables
                if v.section == "output" and isinstance(v.type, str)
            }
        else:
            return self._wrong_type(value.line, base, f".{value.name}", "something with components")
        for name, type_ in known.items():
            if name.upper() == value.name.upper():
                return type_
        return self.say(
            rules.NAME, value.line, found=f".{value.name}", expected=_near(value.name, known)
        )

    def _element(self, value: Element) -> str:
        if not isinstance(value.base, Name):
            return self._wrong_type(value.line, _text(value.base), "an element", "an array")
        variable = self._lookup(value.base.name)
        if variable is None:
            return self._name(value.base)
        if not isinstance(variable.type, Array):
            return self._wrong_type(value.line, str(variable.type), "an element", "an array")
        index = self._type(value.index)
        if index not in (*library.INTEGERS, "integer", UNKNOWN):
            self._wrong_type(value.line, index, "an index", "a whole number")
        if isinstance(value.index, Constant) and index != UNKNOWN:
            low, high = variable.type.low, variable.type.high
            if not low <= value.index.value <= high:
                self.say(
                    rules.BOUNDS, value.line, found=value.index.value, name=variable.name,
                    low=low, high=high,
                )  # fmt: skip
        return self._canonical(variable.type.of)

    def _unary(self, value: Unary) -> str:
        found = self._type(value.value)
        allowed = ("BOOL",) if value.operator == "NOT" else _NUMERIC
        if found not in (*allowed, UNKNOWN):
            return self._wrong_type(value.line, found, value.operator, " or ".join(allowed))
        return found

    def _binary(self, value: Binary) -> str:
        left, right = self._type(value.left), self._type(value.right)
        if UNKNOWN in (left, right):
            return "BOOL" if value.operator in _GIVES_BOOL else UNKNOWN
        if value.operator in ("AND", "OR", "XOR"):
            for one in (left, right):
                if one != "BOOL":
                    self._wrong_type(value.line, one, value.operator, "BOOL")
            return "BOOL"
        common = right if fits(left, right) else left
        together = fits(left, right) or fits(right, left)
        if left.startswith("enum:") and right.startswith("enum:"):
            together = bool(set(left[5:].split("|")) & set(right[5:].split("|")))
            if value.operator not in ("=", "<>"):
                together = False
        if not together:
            self._wrong_type(value.line, right, f"{value.operator} with {shown(left)}", left)
        elif value.operator in ("=", "<>") and common in ("REAL", "LREAL", "real"):
            expected = "a difference within a tolerance"
            self._wrong_type(value.line, "an equality of numbers with a point", "a test", expected)
        elif value.operator not in ("=", "<>") and common not in (*_NUMERIC, "TIME"):
            self._wrong_type(value.line, common, value.operator, "numbers")
        return "BOOL" if value.operator in _GIVES_BOOL else common

    # -- calls ------------------------------------------------------------------------------

    def _call(self, call: Call, as_statement: bool) -> str:
        name = call.callee
        if name.upper() in ("ABS", "SQRT"):
            return self._numeric(call)
        command = next((n for n in COMMANDS if n.upper() == name.upper()), None)
        if command is not None:
            if as_statement:
                self._wrong_type(
                    call.line, f"{command} without its answer", "a command",
                    "a variable for it, as a dropped command says so only there",
                )  # fmt: skip
            self._parameters(call, COMMANDS[command].parameters, COMMANDS[command].needed)
            return "DINT"
        variable = self._lookup(name)
        inputs: dict[str, str] | None = None
        if variable is not None and isinstance(variable.type, str):
            type_ = self._canonical(variable.type)
            if type_ in BLOCKS:
                inputs = BLOCKS[type_][0]
            elif type_.upper() in self.blocks:
                inputs = {
                    v.name: self._canonical(v.type)
                    for v in self.blocks[type_.upper()].variables
                    if v.section in ("input", "inout") and isinstance(v.type, str)
                }
        if inputs is None:
            known = [*COMMANDS, "ABS", "SQRT", *(v.name for v in self.locals.values())]
            return self.say(rules.NAME, call.line, found=f"{name}()", expected=_near(name, known))
        self._parameters(call, inputs, tuple(inputs))
        if not as_statement:
            self._wrong_type(call.line, f"the function block {name}", "a value", "a function")
        return UNKNOWN

    def _numeric(self, call: Call) -> str:
        if len(call.placed) != 1 or call.named:
            found = f"{len(call.placed) + len(call.named)} values"
            self.say(rules.PARAMETER, call.line, found=found, callee=call.callee, expected="one")
            return UNKNOWN
        found = self._type(call.placed[0])
        allowed = _NUMERIC if call.callee.upper() == "ABS" else ("REAL", "LREAL", "real")
        if found not in (*allowed, UNKNOWN):
            return self._wrong_type(call.line, found, call.callee, " or ".join(allowed))
        return found

    def _parameters(self, call: Call, known: dict[str, str], needed: Sequence[str]) -> None:
        by_upper = {name.upper(): name for name in known}
        given: set[str] = set()
        if call.placed:
            self.say(
                rules.PARAMETER, call.line, found="a value without its name", callee=call.callee,
                expected="names, as in position := ...",
            )  # fmt: skip
        for name, value, line in call.named:
            real = by_upper.get(name.upper())
            if real is None:
                self.say(
                    rules.PARAMETER, line, found=name, callee=call.callee,
                    expected=_near(name, known),
                )  # fmt: skip
                self._type(value)
                continue
            if real in given:
                self.say(
                    rules.PARAMETER, line, found=f"{name} twice", callee=call.callee,
                    expected="it once",
                )  # fmt: skip
            given.add(real)
            self._fits(value, known[real], f"{real} of {call.callee}")
        for name in needed:
            if name not in given and not call.placed:
                self.say(
                    rules.PARAMETER, call.line, found=f"no {name}", callee=call.callee,
                    expected=f"{name} := ...",
                )  # fmt: skip


_GIVES_BOOL = ("AND", "OR", "XOR", "=", "<>", "<", ">", "<=", ">=")


def _text(value: Expression) -> str:
    match value:
        case Name():
            return value.name
        case Member():
            return f"{_text(value.base)}.{value.name}"
        case Element():
            return f"{_text(value.base)}[...]"
    return "an expression"


def _near(word: str, known: object) -> str:
    """What was meant perhaps."""
    from collections.abc import Iterable
    from difflib import get_close_matches

    assert isinstance(known, Iterable)
    names = {str(k).upper(): str(k) for k in known}
    close = get_close_matches(word.upper(), list(names), 1, 0.6)
    return names[close[0]] if close else "a name that is"
