"""Structured Text run: a syntax tree written as Python, one function for each block.

Blocks are compiled once; the variables of an instance are a dictionary that its function is called
with. Commands go to a `World`, which knows axes and time. AND and OR stop at the first value
that decides, which makes no difference as expressions have no effects.
"""

from collections.abc import Callable, Container, Iterable, Iterator, Sequence
from math import sqrt
from types import CodeType
from typing import Any, Protocol

from beamcam.caches import cached
from beamcam.controllers.simotion import rules, syntax
from beamcam.errors import Rule, Source, VerifyError

Values = dict[str, Any]
#: By their names in capitals; None: outside the units.
Variables = dict[str, syntax.Variable | None]

_FIRST: dict[str, Any] = {"BOOL": False, "REAL": 0.0, "LREAL": 0.0, "TIME": 0.0}


class World(Protocol):
    """The environment of a program besides its variables."""

    clock_s: float
    objects: dict[str, Any]  #: axes and path objects by their names in capitals
    natives: dict[str, Callable[[], "Native"]]  #: function blocks of a library, by their types

    def command(self, name: str, values: Values, line: int) -> int:
        """Carry out a command; 0 if it was accepted."""

    def say(self, rule: Rule, line: int | None, **values: object) -> None:
        """Add a message."""


class Native(Protocol):
    """A function block of a library; `values` are its outputs."""

    values: Values

    def run(self, inputs: Values) -> None:
        """One call, with the inputs that it gives."""


class Timer(Native):
    """TON: Q follows IN after PT."""

    def __init__(self, world: World) -> None:
        self._world = world
        self._since: float | None = None
        self.values: Values = {"Q": False, "ET": 0.0}

    def run(self, inputs: Values) -> None:
        now = self._world.clock_s
        if not inputs["IN"]:
            self._since = None
            self.values.update(Q=False, ET=0.0)
            return
        if self._since is None:
            self._since = now
        elapsed = now - self._since
        self.values.update(Q=elapsed >= inputs["PT"] - 1e-9, ET=min(elapsed, inputs["PT"]))


class Instance:
    """A function block with its variables."""

    def __init__(self, block: syntax.ProgramBlock, machine: "ProjectInterpreter") -> None:
        self._key, self._machine = block.name.upper(), machine
        self.values: Values = {
            v.name.upper(): machine.first(v) for v in block.variables if v.section != "external"
        }

    def run(self, inputs: Values) -> None:
        self.values.update(inputs)
        self._machine.bodies[self._key](self.values)


class ProjectInterpreter:
    """The units of a project, loaded: global variables, and one instance of each program."""

    def __init__(
        self, units: Sequence[syntax.Unit], world: World, name: str,
        outside: Sequence[str] = (),
    ) -> None:  # fmt: skip
        """`outside` are BOOL variables of the project that no unit here declares."""
        self.world, self.name = world, name
        self.globals: Values = dict.fromkeys((key.upper() for key in outside), False)
        self.addresses: dict[str, str] = {}  #: of inputs and outputs: their variable
        self._blocks = {b.name.upper(): b for u in units for b in u.blocks}
        variables = {v.name.upper(): v for unit in units for v in unit.variables}
        self._known: Variables = {**dict.fromkeys(self.globals), **variables}
        self._names: Values = {
            "g": self.globals, "world": world, "at": self._at, "divide": self._divide, "sqrt": sqrt,
        }  # fmt: skip
        for key, variable in variables.items():
            self.globals[key] = self.first(variable)
            if variable.address:
                self.addresses[variable.address.upper()] = key
        self.bodies: dict[str, Callable[[Values], None]] = {}
        for key, block in self._blocks.items():
            exec(_compiled("\n".join(self._writer(block.variables).block(block))), self._names)
            self.bodies[key] = self._names["block"]
        self._programs = {
            key: Instance(b, self) for key, b in self._blocks.items() if b.kind == "PROGRAM"
        }

    def run(self, program: str) -> None:
        """One cycle of a program. Raises VerifyError; KeyError for a program that is not there."""
        self._programs[program.upper()].run({})

    def has(self, program: str) -> bool:
        """Whether there is a program of that name."""
        return program.upper() in self._programs

    def first(self, variable: syntax.Variable) -> Any:
        """The value that a variable begins with; an array is a list behind its bounds."""
        type_, initial = variable.type, variable.initial
        if isinstance(type_, syntax.Array):
            count = type_.high - type_.low + 1
            if isinstance(initial, tuple):
                return [self._constant(v) for v in initial]
            return [_FIRST.get(type_.of.upper(), 0)] * count
        if variable.section == "global" and variable.name.upper() in self.world.objects:
            return self.world.objects[variable.name.upper()]
        if type_.upper() == "TON":
            return Timer(self.world)
        if type_.upper() in self.world.natives:
            return self.world.natives[type_.upper()]()
        if type_.upper() in self._blocks:
            return Instance(self._blocks[type_.upper()], self)
        if initial is None or isinstance(initial, tuple):
            return _FIRST.get(type_.upper(), 0)
        return self._constant(initial)

    def _constant(self, value: syntax.Expression) -> Any:
        return eval(self._writer(()).expression(value), self._names)

    def _writer(self, variables: Sequence[syntax.Variable]) -> "_Writer":
        own: Variables = {v.name.upper(): v for v in variables if v.section != "external"}
        instances = {"TON", *self.world.natives, *self._blocks}
        return _Writer(own, self._known, self.world.objects, instances)

    def _at(self, index: int, low: int, high: int, name: str, line: int) -> int:
        """The place of an element in its array; raises VerifyError beyond its bounds."""
        if not low <= index <= high:
            source = Source(self.name, line)
            raise VerifyError(rules.BOUNDS.at(source, found=index, name=name, low=low, high=high))
        return index - low

    def _divide(self, operator: str, a: Any, b: Any, line: int) -> Any:
        """A quotient or the rest of one; of whole numbers a whole one, towards 0."""
        if b == 0:
            source = Source(self.name, line)
            raise VerifyError(rules.RUN.at(source, found="a division by 0", expected="none"))
        if operator == "MOD":
            return a - b * int(a / b)
        return int(a / b) if isinstance(a, int) else a / b


@cached("simotion.block")
def _compiled(text: str) -> CodeType:
    return compile(text, "<Structured Text>", "exec")


class _Writer:
    """Writes a block as a Python function: `v` are its own variables, `g` the global ones."""

    def __init__(
        self, own: Variables, known: Variables, objects: Container[str], instances: Container[str]
    ) -> None:
        """`known` are the global variables; `instances` types of function blocks, in capitals."""
        self._own, self._known = own, known
        self._objects, self._instances = objects, instances

    def block(self, block: syntax.ProgramBlock) -> list[str]:
        """The lines of the function `block`."""
        return ["def block(v):", *self._body(block.body)]

    def _body(self, statements: Iterable[syntax.Statement]) -> list[str]:
        lines = [" " + line for one in statements for line in self._statement(one)]
        return lines or [" pass"]

    def _statement(self, one: syntax.Statement) -> Iterator[str]:
        match one:
            case syntax.Assign(target=target, value=value):
                yield f"{self.expression(target)} = {self.expression(value)}"
            case syntax.Invoke(call=call):
                yield f"{self._name(call.callee.upper())}.run({self._inputs(call)})"
            case syntax.If(branches=branches, otherwise=otherwise):
                for k, (condition, body) in enumerate(branches):
                    yield f"{'elif' if k else 'if'} {self.expression(condition)}:"
                    yield from self._body(body)
                if otherwise:
                    yield "else:"
                    yield from self._body(otherwise)
            case syntax.Case(selector=selector, branches=branches, otherwise=otherwise):
                yield f"match {self.expression(selector)}:"
                for labels, body in branches:
                    yield f" case {' | '.join(map(str, labels))}:"
                    yield from (" " + line for line in self._body(body))
                yield " case _:"
                yield from (" " + line for line in self._body(otherwise))
            case syntax.For(variable=name, first=first, last=last, body=body):
                low, high = self.expression(first), self.expression(last)
                yield f"for {self._name(name.upper())} in range({low}, {high} + 1):"
                yield from self._body(body)
            case syntax.Leave():
                yield "return"

    def expression(self, value: syntax.Expression) -> str:
        """A Python expression, with parentheses where it has an operator."""
        match value:
            case syntax.Constant(value=plain):
                return repr(plain)
            case syntax.Name(name=name):
                return self._name(name.upper())
            case syntax.Member(base=base, name=name):
                if isinstance(base, syntax.Name) and self._is_instance(base.name.upper()):
                    return f"{self.expression(base)}.values[{name.upper()!r}]"
                return f"world.system({self.expression(base)}, {name.upper()!r})"
            case syntax.ArrayElement():
                return self._element(value)
            case syntax.Call(callee=callee, placed=placed):
                if callee.upper() in _FUNCTIONS:
                    return f"{callee.lower()}({self.expression(placed[0])})"
                return f"world.command({callee.upper()!r}, {self._inputs(value)}, {value.line})"
            case syntax.Unary(operator=operator, value=inner):
                return f"({operator.lower()} {self.expression(inner)})"
            case syntax.Binary(operator=operator):
                left, right = self.expression(value.left), self.expression(value.right)
                if operator in ("/", "MOD"):
                    return f"divide({operator!r}, {left}, {right}, {value.line})"
                return f"({left} {_OPERATORS.get(operator, operator)} {right})"

    def _name(self, key: str) -> str:
        """A variable; else an axis or a path object, else the word of an enumeration."""
        if key in self._own:
            return f"v[{key!r}]"
        if key in self._known:
            return f"g[{key!r}]"
        return f"world.objects[{key!r}]" if key in self._objects else repr(key)

    def _is_instance(self, key: str) -> bool:
        variable = self._own.get(key) or self._known.get(key)
        return (
            variable is not None
            and isinstance(variable.type, str)
            and variable.type.upper() in self._instances
        )

    def _element(self, value: syntax.ArrayElement) -> str:
        assert isinstance(value.base, syntax.Name)
        key = value.base.name.upper()
        variable = self._own.get(key) or self._known[key]
        assert variable is not None
        assert isinstance(variable.type, syntax.Array)
        bounds = f"{variable.type.low}, {variable.type.high}, {variable.name!r}, {value.line}"
        return f"{self._name(key)}[at({self.expression(value.index)}, {bounds})]"

    def _inputs(self, call: syntax.Call) -> str:
        named = (f"{name.upper()!r}: {self.expression(value)}" for name, value, _ in call.named)
        return "{" + ", ".join(named) + "}"


_FUNCTIONS = ("ABS", "SQRT")
_OPERATORS = {"AND": "and", "OR": "or", "XOR": "!=", "=": "==", "<>": "!="}
