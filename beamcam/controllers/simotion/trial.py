"""The fixed part of a machine's programs, proved once: checked, and run with simulated axes.

A small job is put into it: a line with each tool, home again. The names, addresses, windows and
times of the machine's file are those that it will run with, and its axes are read in counts of the
encoder that the file tells.
"""

from collections.abc import Mapping, Sequence
from functools import partial
from math import hypot

from beamcam.caches import PerObject
from beamcam.controllers.simotion import axes, rules, syntax
from beamcam.controllers.simotion.cutting_table import CuttingTable
from beamcam.controllers.simotion.names import UNKNOWN, Names, text_of
from beamcam.controllers.simotion.parser import KEYWORDS, parse
from beamcam.controllers.simotion.syntax import Unit
from beamcam.controllers.simotion.types import Types, parse_plain
from beamcam.errors import Diagnostic, Source, VerifyError, errors_in
from beamcam.machine.machine import Machine
from beamcam.machine.runtime import (
    PROCESSES,
    STYLES,
    dialect_of,
    is_address,
    library_runtime,
    shipped,
)
from beamcam.machine.tables import Triggers

AT = (1.0, 2.0)  #: where each line of the trial begins
SIZE = (3.0, 1.5)  #: of it
SPEED = 10.0
LIFT = 8  #: kind of an operation up or down
MOST_CYCLES = 40_000  #: of the trial, which takes some hundreds where axes and cycles are usual


def parsed(text: str, machine: Machine, name: str) -> tuple[list[Unit], list[Diagnostic]]:
    """The units of a program, with the blocks that it calls where these are Structured Text."""
    library_text = dialect_of(machine).library
    if library_text:
        return parse_plain(shipped(library_text) + text, name)
    return parse(text, name)


def project_objects(machine: Machine) -> dict[str, str]:
    """Names of the project that a program uses, with their types; a plain one declares its own."""
    if dialect_of(machine).library:
        return {}
    triggers = machine.needed(machine.triggers, "trigger program")
    places = (*triggers.inputs, *triggers.outputs.values(), triggers.fault_lamp)
    types = {place: "BOOL" for place in places if place and not is_address(place)}
    types |= dict.fromkeys(triggers.all_axes, axes.AXIS)
    if triggers.path_objects:
        types[triggers.path_object] = axes.PATH_OBJECT
    return types


def _trial(machine: Machine) -> tuple[Diagnostic, ...]:
    name = f"machine {machine.name}"
    all_said: list[Diagnostic] = []
    for style in STYLES:
        units, diagnostics = parsed(_program(machine, style), machine, name)
        diagnostics = diagnostics or check(units, project_objects(machine), name)
        if not errors_in(diagnostics):
            diagnostics += _run(units, machine, name)
        all_said += (d for d in diagnostics if d not in all_said)
    return tuple(all_said)


#: Faults in the fixed part of a machine's programs; none for one that works.
trial = PerObject("simotion.trial", _trial)


def _program(machine: Machine, style: str) -> str:
    """The runtime with a line for each process that the machine has."""
    assert machine.triggers is not None
    rows = _rows(machine.triggers)
    last = len(rows)
    via = ", middleX := LREAL#0.0, middleY := LREAL#0.0" if machine.triggers.path_objects else ""
    tail = f"speed := LREAL#{SPEED}{via});"
    dialect, has_z = dialect_of(machine), machine.triggers.z is not None
    declarations = f"{dialect.constants} LAST_OPERATION : DINT := DINT#{last};\n"
    declarations += "SHEET_THICKNESS : LREAL := LREAL#0.0;\n" * has_z
    declarations += "".join(f"PIERCE_{p.upper()} : TIME := T#100ms;\n" for p in PROCESSES)
    declarations += f"END_VAR {dialect.variables} "
    if style == "chain":
        declarations += f"triggerActive : ARRAY [0..{last}] OF BOOL;\n"
        work = "".join(
            f"IF operationArrived AND triggerActive[{k - 1}] AND NOT triggerActive[{k}] THEN "
            f"triggerActive[{k}] := TRUE; "
            f"next(kind := USINT#{kind}, x := LREAL#{x}, y := LREAL#{y}, "
            f"{f'z := LREAL#{z}, ' * has_z}{tail} END_IF;\n"
            for k, (kind, x, y, z) in enumerate(rows, 1)
        )
    else:
        for name, values in zip("KXYZ"[: 3 + has_z], zip(*rows, strict=True), strict=False):
            type_ = "USINT" if name == "K" else "LREAL"
            typed = ", ".join(f"{type_}#{value}" for value in values)
            declarations += f"point{name} : ARRAY [1..{last}] OF {type_} := [{typed}];\n"
        height = "z := pointZ[row], " * has_z
        work = f"next(kind := pointK[row], x := pointX[row], y := pointY[row], {height}{tail}\n"
    runtime = library_runtime(machine, style)
    return f"{runtime.head}{declarations}END_VAR\n{runtime.middle}{work}{runtime.end}"


def _rows(triggers: Triggers) -> list[tuple[int, float, float, float]]:
    """Kind, X, Y and height of each operation: a line with each tool, and home.

    A torch that is lifted pierces at half its clearance, and cuts at a quarter of it.
    """
    end = AT[0] + SIZE[0], AT[1] + SIZE[1]
    rows: list[tuple[int, float, float, float]] = []
    if (z := triggers.z) is None:
        for kind in _kinds(triggers):
            rows += [(0, *AT, 0.0), (kind, *AT, 0.0), (0, *end, 0.0), (kind + 1, *end, 0.0)]
        return [*rows, (0, 0.0, 0.0, 0.0)]
    top, pierce, cut = z.clearance, z.clearance / 2, z.clearance / 4
    rows.append((LIFT, 0.0, 0.0, top))
    for kind in _kinds(triggers):
        rows += [(0, *AT, top), (LIFT, *AT, pierce), (kind, *AT, pierce), (LIFT, *AT, cut),
                 (0, *end, cut), (kind + 1, *end, cut), (LIFT, *end, top)]  # fmt: skip
    return [*rows, (0, 0.0, 0.0, top), (LIFT, 0.0, 0.0, z.home_height)]


def _kinds(triggers: Triggers) -> list[int]:
    """Kinds of the operations that start a tool of the machine."""
    return [2 * k + 1 for k, process in enumerate(PROCESSES) if process in triggers.outputs]


def _run(units: list[Unit], machine: Machine, name: str) -> list[Diagnostic]:
    """Events of a run from the start button to the end."""
    assert machine.triggers is not None
    table = CuttingTable(units, machine, name)
    for axis, count in zip(table.axes, machine.triggers.counts(), strict=True):
        axis.reads = partial(machine.triggers.read, count=count)
    ends = (0.0, 0.0, machine.triggers.home_over(0.0))
    try:
        table.cycle()
        table.start = True
        for _ in range(MOST_CYCLES):
            if table.value("workDone") or table.value("workFault"):
                break
            table.cycle()
    except VerifyError as fault:
        return [*table.diagnostics, *fault.diagnostics]
    diagnostics = list(table.diagnostics)

    def wrong(found: str, expected: str) -> None:
        diagnostics.append(rules.RUN.at(Source(name), found=found, expected=expected))

    if not table.value("workDone") and not table.value("workFault"):
        cycle_s = machine.triggers.cycle_s
        found = f"no end of a line of {hypot(*SIZE):.1f} mm after {MOST_CYCLES * cycle_s:g} s"
        wrong(f"{found}, {MOST_CYCLES} cycles", "fewer, by back_off, homing_mm_s and cycle_s")
    elif table.value("workFault"):
        wrong(f"fault {table.value('faultNumber')}", "work to its end")
    elif any(
        abs(axis.position - end) > machine.triggers.in_position
        for axis, end in zip(table.axes, ends, strict=False)
    ):
        wrong("an end elsewhere", "all axes where homing ends")
    elif table.tool_on:
        wrong("a tool on at the end", "it off")
    elif not errors_in(diagnostics):
        for process in machine.triggers.outputs:
            if not _drew(table, process):
                wrong(f"no line by the tool to {process}", "one from end to end")
    return diagnostics


def _drew(table: "CuttingTable", process: str) -> bool:
    """Whether a tool went along its line, and nowhere else."""
    points = table.points.get(process, [])
    length = hypot(*SIZE)
    along = [((x - AT[0]) * SIZE[0] + (y - AT[1]) * SIZE[1]) / length for x, y in points]
    off = [((x - AT[0]) * SIZE[1] - (y - AT[1]) * SIZE[0]) / length for x, y in points]
    near = table.torch.tolerance
    if (z := table.triggers.z) is not None:
        heights = table.heights.get(process, [])
        # Where it goes along its line it cuts; before that it comes down from where it pierced.
        cuts = [h for a, h in zip(along, heights, strict=True) if near < a]
        apart = max((abs(h - z.clearance / 4) for h in cuts), default=near + 1)
        if apart > near or not z.clearance / 4 - near <= min(heights) <= max(heights) <= (
            z.clearance / 2 + near
        ):
            return False
    return bool(
        points
        and max(map(abs, off)) <= near
        and abs(min(along)) <= near
        and abs(max(along) - length) <= near
    )


# --- names, types, parameters and bounds, each fault with its line --------------------------------

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
        values = {"found": variable.name, "how": how, "expected": expected}
        self.names.say(rules.DECLARED, variable.line, **values)

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
            bounds = {"found": type_.high, "name": variable.name, "low": type_.low, "high": "more"}
            self.names.say(rules.BOUNDS, variable.line, **bounds)
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
