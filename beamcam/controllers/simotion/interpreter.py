"""Structured Text run: a syntax tree turned into Python functions, one for each node.

Blocks are compiled once; the variables of an instance are a dictionary that its functions are
called with. Commands go to a `World`, which knows axes and time. AND and OR stop at the first
value that decides, which makes no difference as expressions have no effects.
"""

from collections.abc import Callable, Sequence
from math import sqrt
from typing import Any, Protocol

from beamcam.controllers.simotion import rules, syntax
from beamcam.errors import Diagnostic, Source

Values = dict[str, Any]
Get = Callable[[Values], Any]
Do = Callable[[Values], None]

_FIRST: dict[str, Any] = {"BOOL": False, "REAL": 0.0, "LREAL": 0.0, "TIME": 0.0}


class World(Protocol):
    """The environment of a program besides its variables."""

    clock_s: float
    objects: dict[str, Any]  #: axes and path objects by their names in capitals
    natives: dict[str, Callable[[], "Native"]]  #: function blocks of a library, by their types

    def command(self, name: str, values: dict[str, Any], line: int) -> int:
        """Carry out a command; 0 if it was accepted."""

    def system(self, base: Any, name: str) -> Any:
        """A system variable of an object."""


class Fault(Exception):
    """A fault that stops the controller."""

    def __init__(self, diagnostic: Diagnostic) -> None:
        super().__init__(str(diagnostic))
        self.diagnostic = diagnostic


class _Return(Exception):
    """RETURN: the rest of the block is passed over."""


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

    def __init__(self, block: syntax.Block, machine: "Interpreter") -> None:
        self._key, self._machine = block.name.upper(), machine
        self.values: Values = {
            v.name.upper(): machine.first(v) for v in block.variables if v.section != "external"
        }

    def run(self, inputs: Values) -> None:
        self.values.update(inputs)
        try:
            for do in self._machine.bodies[self._key]:
                do(self.values)
        except _Return:
            pass


class Interpreter:
    """The units of a project, loaded: global variables, and one instance of each program."""

    def __init__(
        self, units: Sequence[syntax.Unit], world: World, name: str, outside: Sequence[str] = ()
    ) -> None:
        """`outside` are BOOL variables of the project that no unit here declares."""
        self.world, self.name = world, name
        self.globals: Values = dict.fromkeys((key.upper() for key in outside), False)
        self.addresses: dict[str, str] = {}  #: of inputs and outputs: their variable
        self._variables: dict[str, syntax.Variable] = {}
        self._blocks = {b.name.upper(): b for u in units for b in u.blocks}
        self.bodies: dict[str, tuple[Do, ...]] = {}
        self._locals: dict[str, syntax.Variable] = {}
        for unit in units:
            for variable in unit.variables:
                key = variable.name.upper()
                self._variables[key] = variable
                self.globals[key] = self.first(variable)
                if variable.address:
                    self.addresses[variable.address.upper()] = key
        for key, block in self._blocks.items():
            self._locals = {v.name.upper(): v for v in block.variables if v.section != "external"}
            self.bodies[key] = self._body(block.body)
        self._programs = {
            key: Instance(b, self) for key, b in self._blocks.items() if b.kind == "PROGRAM"
        }

    def run(self, program: str) -> None:
        """One cycle of a program. Raises Fault; KeyError for a program that is not there."""
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
        return self._get(value)({})

    # -- statements -------------------------------------------------------------------------

    def _statement(self, one: syntax.Statement) -> Do:
        match one:
            case syntax.Assign():
                return self._assign(one)
            case syntax.Invoke(call=call):
                return self._invoke(call)
            case syntax.If():
                return self._if(one)
            case syntax.Case():
                return self._case(one)
            case syntax.For():
                return self._for(one)
            case syntax.Leave():
                return _leave

    def _body(self, statements: Sequence[syntax.Statement]) -> tuple[Do, ...]:
        return tuple(self._statement(s) for s in statements)

    def _assign(self, one: syntax.Assign) -> Do:
        get = self._get(one.value)
        if isinstance(one.target, syntax.Element):
            array, at = self._element(one.target)

            def put(values: Values) -> None:
                array(values)[at(values)] = get(values)

            return put
        assert isinstance(one.target, syntax.Name)
        key = one.target.name.upper()
        local, known = key in self._locals, self.globals

        def keep(values: Values) -> None:
            (values if local else known)[key] = get(values)

        return keep

    def _invoke(self, call: syntax.Call) -> Do:
        key = call.callee.upper()
        inputs = [(name.upper(), self._get(value)) for name, value, _ in call.named]
        instance = self._get(syntax.Name(call.line, key))

        def invoke(values: Values) -> None:
            instance(values).run({name: get(values) for name, get in inputs})

        return invoke

    def _if(self, one: syntax.If) -> Do:
        branches = [(self._get(c), self._body(b)) for c, b in one.branches]
        branches.append((lambda values: True, self._body(one.otherwise)))

        def choose(values: Values) -> None:
            for condition, body in branches:
                if condition(values):
                    for do in body:
                        do(values)
                    return

        return choose

    def _case(self, one: syntax.Case) -> Do:
        selector = self._get(one.selector)
        table = {label: self._body(b) for labels, b in one.branches for label in labels}
        otherwise = self._body(one.otherwise)

        def choose(values: Values) -> None:
            for do in table.get(selector(values), otherwise):
                do(values)

        return choose

    def _for(self, one: syntax.For) -> Do:
        first, last = self._get(one.first), self._get(one.last)
        body, key = self._body(one.body), one.variable.upper()
        local = key in self._locals

        def loop(values: Values) -> None:
            where = values if local else self.globals
            for k in range(first(values), last(values) + 1):
                where[key] = k
                for do in body:
                    do(values)

        return loop

    # -- expressions ------------------------------------------------------------------------

    def _get(self, value: syntax.Expression) -> Get:
        match value:
            case syntax.Constant(value=plain):
                return lambda values: plain
            case syntax.Name():
                return self._name(value)
            case syntax.Member():
                return self._member(value)
            case syntax.Element():
                array, at = self._element(value)
                return lambda values: array(values)[at(values)]
            case syntax.Call():
                return self._call(value)
            case syntax.Unary():
                inner = self._get(value.value)
                if value.operator == "NOT":
                    return lambda values: not inner(values)
                return lambda values: -inner(values)
            case syntax.Binary():
                return self._binary(value)

    def _name(self, value: syntax.Name) -> Get:
        key = value.name.upper()
        if key in self._locals:
            return lambda values: values[key]
        if key in self._variables or key in self.globals:
            known = self.globals
            return lambda values: known[key]
        plain = self.world.objects.get(key, key)
        return lambda values: plain

    def _member(self, value: syntax.Member) -> Get:
        base, key, world = self._get(value.base), value.name.upper(), self.world

        def read(values: Values) -> Any:
            found = base(values)
            return found.values[key] if hasattr(found, "values") else world.system(found, key)

        return read

    def _element(self, value: syntax.Element) -> tuple[Get, Get]:
        """An array, and the place of an element in it; that raises Fault beyond its bounds."""
        assert isinstance(value.base, syntax.Name)
        key = value.base.name.upper()
        variable = self._locals.get(key) or self._variables[key]
        assert isinstance(variable.type, syntax.Array)
        index, low, high = self._get(value.index), variable.type.low, variable.type.high

        def at(values: Values) -> int:
            k: int = index(values)
            if not low <= k <= high:
                source = Source(self.name, value.line)
                said = rules.BOUNDS.at(source, found=k, name=variable.name, low=low, high=high)
                raise Fault(said)
            return k - low

        return self._name(value.base), at

    def _call(self, value: syntax.Call) -> Get:
        name = value.callee
        function = _FUNCTIONS.get(name.upper())
        if function is not None:
            inner = self._get(value.placed[0])
            return lambda values: function(inner(values))
        inputs = [(key.upper(), self._get(given)) for key, given, _ in value.named]
        world, line = self.world, value.line

        def command(values: Values) -> int:
            return world.command(name.upper(), {k: get(values) for k, get in inputs}, line)

        return command

    def _binary(self, value: syntax.Binary) -> Get:
        left, right = self._get(value.left), self._get(value.right)
        operator = value.operator
        if operator in ("/", "MOD"):
            return self._divide(value, left, right)
        return _BINARY[operator](left, right)

    def _divide(self, value: syntax.Binary, left: Get, right: Get) -> Get:
        def divide(values: Values) -> Any:
            a, b = left(values), right(values)
            if b == 0:
                source = Source(self.name, value.line)
                raise Fault(rules.RUN.at(source, found="a division by 0", expected="none"))
            if value.operator == "MOD":
                return a - b * int(a / b)
            return int(a / b) if isinstance(a, int) else a / b

        return divide


def _leave(values: Values) -> None:
    raise _Return


_FUNCTIONS: dict[str, Callable[[float], float]] = {"ABS": abs, "SQRT": sqrt}

_BINARY: dict[str, Callable[[Get, Get], Get]] = {
    "AND": lambda a, b: lambda v: a(v) and b(v),
    "OR": lambda a, b: lambda v: a(v) or b(v),
    "XOR": lambda a, b: lambda v: a(v) != b(v),
    "=": lambda a, b: lambda v: a(v) == b(v),
    "<>": lambda a, b: lambda v: a(v) != b(v),
    "<": lambda a, b: lambda v: a(v) < b(v),
    ">": lambda a, b: lambda v: a(v) > b(v),
    "<=": lambda a, b: lambda v: a(v) <= b(v),
    ">=": lambda a, b: lambda v: a(v) >= b(v),
    "+": lambda a, b: lambda v: a(v) + b(v),
    "-": lambda a, b: lambda v: a(v) - b(v),
    "*": lambda a, b: lambda v: a(v) * b(v),
}
