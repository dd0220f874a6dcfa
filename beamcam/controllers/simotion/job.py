"""The job data of a trigger program, read line by line: operations and pierce times.

declarations -> LAST_OPERATION, PIERCE_CUT, ...
operations   -> a latched block for each (chain), or a block for each unit of rows (table)
data         -> arrays of set-points, in units
"""

import re
from collections.abc import Iterable, Iterator, Sequence
from typing import Any, NoReturn

from msgspec import Struct

from beamcam.controllers.simotion import rules
from beamcam.errors import Diagnostic, Rule, Source, VerifyError
from beamcam.machine.machine import Machine
from beamcam.machine.runtime import PROCESSES, STYLES, dialect_of, runtime_of

END = "the end of the program"
UNIT = re.compile(r"\(\* ===== UNIT (\w+) ===== \*\)")
_REMARK = re.compile(r"\(\* (?:(?!\*\)|\(\*).)+ \*\)")
_BOUNDARY = "(* ----- Runtime ----- *)"
_ARRAY = "        triggerActive : ARRAY ["
_REAL = r"LREAL#(-?\d+\.\d+)"
_KIND = r"USINT#(\d+)"
_USES = re.compile(r"    USES (\w+(?:, \w+)*);")
_LAST = re.compile(r"        LAST_OPERATION : DINT := DINT#(\d+);")
_THICKNESS = re.compile(rf"        SHEET_THICKNESS : LREAL := {_REAL};")
_LATCHES = re.compile(r"        triggerActive : ARRAY \[0\.\.(\d+)\] OF BOOL;")
_COMMENT = re.compile(r"        \(\* \d+: [a-z ]+ \*\)")
_TRIGGER = re.compile(
    r"        IF operationArrived AND triggerActive\[(\d+)\] AND NOT triggerActive\[(\d+)\] THEN"
)
_LATCH = re.compile(r"            triggerActive\[(\d+)\] := TRUE;")
_PLACE = re.compile(rf"            next\(kind := {_KIND}, x := {_REAL}, y := {_REAL},")
_VIA = re.compile(rf"                middleX := {_REAL}, middleY := {_REAL}\);")
_END = re.compile(r"        END_IF;")
_RANGE = re.compile(r"        IF \(row >= DINT#(\d+)\) AND \(row <= DINT#(\d+)\) THEN")
_VALUES = {"LREAL": re.compile(_REAL), "USINT": re.compile(_KIND)}


class TableOperation(Struct, frozen=True):
    """One operation as the controller gets it."""

    line: int
    kind: int
    x: float
    y: float
    speed: float
    via: tuple[float, float] | None = None
    height: float = 0.0  #: of the torch over the sheet, where the table lifts it


class JobRead(Struct, frozen=True):
    """A job: its operations in their order, and seconds to pierce by process."""

    operations: tuple[TableOperation, ...]
    pierce_s: dict[str, float]
    thickness: float = 0.0  #: of the sheet, where the table lifts its torch
    thickness_line: int = 1  #: that says so


Line = tuple[int, str]  #: number in the program, and text


class _Lines:
    """Lines taken one by one, each of a form. Raises VerifyError at the first that is another."""

    def __init__(self, lines: Sequence[Line], name: str) -> None:
        self.lines, self.name, self.at = lines, name, 0

    @property
    def here(self) -> Line:
        if self.at < len(self.lines):
            return self.lines[self.at]
        last = self.lines[-1][0] if self.lines else 1
        return last, END

    @property
    def left(self) -> bool:
        return self.at < len(self.lines)

    def fixed(self, piece: str) -> None:
        """The lines of a piece that is the same in every program, byte by byte."""
        for expected in piece.split("\n")[:-1]:
            ended = self.at + 1 >= len(self.lines)  # what follows its last line end is a line too
            text = END if ended else self.here[1]
            if text != expected:
                self.wrong(rules.RUNTIME, found=text.strip(), expected=expected.strip())
            self.at += 1

    def own(self) -> "_Lines":
        """The job's lines up to the next fixed piece, which begins with a comment of its own."""
        start = self.at
        while self.left and self.here[1].strip() != _BOUNDARY:
            self.at += 1
        if not self.left:
            self.wrong(rules.RUNTIME, found=END, expected=_BOUNDARY)
        return _Lines(self.lines[start : self.at], self.name)

    def exact(self, *texts: str) -> None:
        for text in texts:
            if not self.left or self.here[1] != text:
                self.wrong(rules.SYNTAX, found=self.here[1].strip(), expected=text.strip())
            self.at += 1

    def match(self, form: re.Pattern[str], expected: str) -> re.Match[str]:
        match = form.fullmatch(self.here[1]) if self.left else None
        if match is None:
            self.wrong(rules.SYNTAX, found=self.here[1].strip() or END, expected=expected)
        self.at += 1
        return match

    def end(self, expected: str = END) -> None:
        if self.left:
            self.wrong(rules.SYNTAX, found=self.here[1].strip(), expected=expected)

    def wrong(self, rule: Rule, line: int | None = None, **values: object) -> NoReturn:
        source = Source(self.name, self.here[0] if line is None else line)
        raise VerifyError(rule.at(source, **values))


def read_program(
    text: str, machine: Machine, name: str = "program"
) -> tuple[JobRead | None, list[Diagnostic]]:
    """The job of a program; None and what is wrong where it cannot be read."""
    try:
        return _read_job(text, machine, name), []
    except VerifyError as error:
        return None, list(error.diagnostics)


def _read_job(text: str, machine: Machine, name: str) -> JobRead:
    """The operations of a program's job. Raises VerifyError at the first thing that is wrong.

    The fixed part of a program is shipped and proved by itself, see `trial`.
    """
    numbered = list(enumerate(text.replace("\r\n", "\n").split("\n"), 1))
    lines = _Lines(numbered, name)
    if not UNIT.fullmatch(lines.here[1]):
        lines.wrong(rules.SYNTAX, found=lines.here[1], expected="(* ===== UNIT name ===== *)")
    lines.at = 1
    head = runtime_of(machine, STYLES[0]).head
    first = head.partition("\n")[0]
    while lines.left and lines.here[1] != first and _REMARK.fullmatch(lines.here[1]):
        lines.at += 1
    lines.fixed(head)
    declarations = lines.own()
    chained = any(text.startswith(_ARRAY) for _, text in declarations.lines)
    runtime = runtime_of(machine, "chain" if chained else "table")
    lines.fixed(runtime.middle)
    operations = lines.own()
    lines.fixed(runtime.end)
    data = _Lines(numbered[lines.at :], name)
    return _Job(chained, operations, data, machine).read(declarations)


class _Job:
    def __init__(self, chained: bool, lines: _Lines, data: _Lines, machine: Machine) -> None:
        """`lines` hold the operations, `data` the units of set-points."""
        self.chained, self.lines, self.data = chained, lines, data
        self.triggers = machine.needed(machine.triggers, "trigger program")
        self.paths, self.has_z = self.triggers.path_objects, self.triggers.z is not None
        self.dialect = dialect_of(machine)
        height = rf"z := {_REAL}, " if self.has_z else ""
        end = "," if self.paths else r"\);"  # the middle of an arc stands behind it
        self.speed_form = re.compile(rf"                {height}speed := {_REAL}{end}")
        self.declared: list[TableOperation] = []  #: a table's, where it has no units for them

    def read(self, lines: _Lines) -> JobRead:
        """The job by its declarations and what they announce."""
        units: list[str] = []
        uses_line = lines.here[0]
        if lines.left and _USES.fullmatch(lines.here[1]):
            units = lines.match(_USES, "USES")[1].split(", ")
        lines.exact(f"    {self.dialect.constants}")
        last = int(lines.match(_LAST, "LAST_OPERATION : DINT := DINT#...;")[1])
        thickness, thickness_line = 0.0, lines.here[0]
        if self.has_z:
            thickness = float(lines.match(_THICKNESS, "SHEET_THICKNESS : LREAL := LREAL#...;")[1])
        pierce_s = {}
        for process in PROCESSES:
            form = re.compile(rf"        PIERCE_{process.upper()} : TIME := T#(\d+)ms;")
            match = lines.match(form, f"PIERCE_{process.upper()} : TIME := T#...ms;")
            pierce_s[process] = int(match[1]) / 1000
        lines.exact("    END_VAR")
        if self.chained:
            lines.exact(f"    {self.dialect.variables}")
            latches = int(lines.match(_LATCHES, "triggerActive : ARRAY [0..n] OF BOOL;")[1])
            if latches != last:
                lines.wrong(rules.BOUNDS, lines.here[0] - 1, found=latches, name="triggerActive",
                            low=0, high=last)  # fmt: skip
            lines.exact("    END_VAR")
        elif not self.dialect.has_units:
            lines.exact(f"    {self.dialect.variables}")
            self.declared = self._set_points(lines, 1, 1, last)
            lines.exact("    END_VAR")
        lines.end("the runtime")
        own = list(self.triggers.uses)
        if units[: len(own)] != own:
            expected = ", ".join(own)
            lines.wrong(rules.NAME, uses_line, found=", ".join(units) or "no USES",
                        expected=expected)  # fmt: skip
        read = self._chain if self.chained else self._table
        operations = read(last, units[len(own) :], uses_line)
        return JobRead(operations, pierce_s, thickness, thickness_line)

    # -- chains -----------------------------------------------------------------------------

    def _chain(self, last: int, units: Sequence[str], uses_line: int) -> tuple[TableOperation, ...]:
        if units:
            self.lines.wrong(rules.NAME, uses_line, found=f"unit {units[0]}",
                             expected="no unit of set-points")  # fmt: skip
        operations = tuple(self._blocks())
        self._check_count(len(operations), last)
        self.data.exact("")
        self.data.end()
        return operations

    def _check_count(self, count: int, last: int) -> None:
        if count != last:
            expected = f"{last}, as LAST_OPERATION"
            self.lines.wrong(rules.TRIGGER, found=f"{count} operations", expected=expected)

    def _blocks(self) -> Iterator[TableOperation]:
        lines = self.lines
        k = 0
        while lines.left:
            k += 1
            lines.match(_COMMENT, f"(* {k}: ... *)")
            line = lines.here[0]
            match = lines.match(_TRIGGER, "IF operationArrived AND ... THEN")
            before, barred = int(match[1]), int(match[2])
            sets = int(lines.match(_LATCH, f"triggerActive[{k}] := TRUE;")[1])
            if (before, barred, sets) != (k - 1, k, k):
                lines.wrong(
                    rules.TRIGGER, line, found=f"trigger {sets} behind {before}, but not {barred}",
                    expected=f"trigger {k} behind {k - 1}, but not {k}",
                )  # fmt: skip
            place = lines.match(_PLACE, "next(kind := USINT#..., x := LREAL#..., y := LREAL#...,")
            kind, x, y = int(place[1]), float(place[2]), float(place[3])
            expected = f"{'z := LREAL#..., ' * self.has_z}speed := LREAL#..."
            expected += "," if self.paths else ");"
            *height, speed = lines.match(self.speed_form, expected).groups()
            middle = None
            if self.paths:
                via = lines.match(_VIA, "middleX := LREAL#..., middleY := LREAL#...);")
                middle = float(via[1]), float(via[2])
            lines.match(_END, "END_IF;")
            yield TableOperation(line, kind, x, y, float(speed), middle, *map(float, height))

    # -- tables -----------------------------------------------------------------------------

    def _table(self, last: int, units: Sequence[str], uses_line: int) -> tuple[TableOperation, ...]:
        lines, data, operations = self.lines, self.data, self.declared
        data.exact("")
        if operations and (rows := self._fetch(lines, 1)) != (1, last):
            lines.wrong(rules.BOUNDS, lines.here[0] - 4, found=f"{rows[0]} to {rows[1]}",
                        name="rows of the table", low=1, high=last)  # fmt: skip
        for k, unit in enumerate(units, 1):
            low, high = self._fetch(lines, k)
            if low != len(operations) + 1 or high < low:
                lines.wrong(rules.BOUNDS, lines.here[0] - 4, found=low, name=f"rows of {unit}",
                            low=len(operations) + 1, high="more")  # fmt: skip
            mark = f"(* ===== UNIT {unit} ===== *)"
            other = data.match(UNIT, f"{mark}; join the file of that unit behind this one")[1]
            if other != unit:
                data.wrong(rules.NAME, uses_line, found=f"unit {unit}", expected=other)
            data.exact("INTERFACE", f"    {self.dialect.constants}")
            operations += self._set_points(data, k, low, high)
            data.exact("    END_VAR", "END_INTERFACE", "", "IMPLEMENTATION", "END_IMPLEMENTATION",
                       "")  # fmt: skip
        lines.end("the runtime")
        data.end()
        self._check_count(len(operations), last)
        return tuple(operations)

    def _fetch(self, lines: _Lines, k: int) -> tuple[int, int]:
        """The rows that the block of a unit takes."""
        bounds = lines.match(_RANGE, "IF (row >= DINT#...) AND (row <= DINT#...) THEN")
        via, height = [");"], f"z := pointZ_{k}[row], " * self.has_z
        if self.paths:
            via = [",", f"                middleX := pointViaX_{k}[row], "
                   f"middleY := pointViaY_{k}[row]);"]  # fmt: skip
        lines.exact(
            f"            next(kind := pointKind_{k}[row], x := pointX_{k}[row], "
            f"y := pointY_{k}[row],",
            f"                {height}speed := pointSpeed_{k}[row]{via[0]}",
            *via[1:],
            "        END_IF;",
        )
        return int(bounds[1]), int(bounds[2])

    def _set_points(self, data: _Lines, k: int, low: int, high: int) -> list[TableOperation]:
        """The operations that the arrays of a number hold."""
        line = data.here[0]
        names = ["pointX", "pointY", *["pointZ"] * self.has_z, "pointSpeed"]
        names += ["pointViaX", "pointViaY"] if self.paths else []
        x, y, *more = (self._array(data, f"{name}_{k}", "LREAL", low, high) for name in names)
        kinds = self._array(data, f"pointKind_{k}", "USINT", low, high)
        heights = more.pop(0) if self.has_z else [0.0] * len(x)
        speed, *via = more
        middles: Iterable[Any] = zip(*via, strict=True) if via else [None] * len(x)
        return [
            TableOperation(line, int(kind), *row)
            for kind, *row in zip(kinds, x, y, speed, middles, heights, strict=True)
        ]

    def _array(self, data: _Lines, name: str, type_: str, low: int, high: int) -> list[float]:
        """The values of one array, as many as it has rows."""
        line = data.here[0]
        data.exact(f"        {name} : ARRAY [{low}..{high}] OF {type_} := [")
        start = data.at
        while data.left and data.here[1] != "        ];":
            data.at += 1
        rows = "\n".join(row for _, row in data.lines[start : data.at])
        data.exact("        ];")
        form = _VALUES[type_]
        values = []
        for text in map(str.strip, rows.split(",")):
            match = form.fullmatch(text)
            if match is None:
                data.wrong(rules.SYNTAX, line, found=text, expected=f"a value of {type_}")
            values.append(float(match[1]))
        if len(values) != high - low + 1:
            data.wrong(rules.COUNT, line, found=len(values), name=name, expected=high - low + 1)
        return values
