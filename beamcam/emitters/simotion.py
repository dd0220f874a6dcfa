"""Trigger programs as SIMOTION Structured Text: complete units that a D425 takes.

Two styles. `chain`: a block of statements for each operation, which fires once its predecessor
is active and its end reached, and latches. `table`: set-points in arrays, split over units where
one would get too large, and one state machine that walks through them by the same rule.
"""

import re
from collections.abc import Iterator, Mapping, Sequence

from beamcam.emitters import simotion_text as text
from beamcam.emitters.numbers import number
from beamcam.emitters.simotion_units import UNIT_MARK, unit_name
from beamcam.machine.machine import Machine
from beamcam.machine.tables import Triggers
from beamcam.model.triggers import Round, Switch, Travel, TriggerOp, TriggerTable
from beamcam.plain_text import comment_text

#: Bytes of one operation in a unit of set-points: x, y, speed and kind; with path objects the
#: middle of arcs as well.
POINT_BYTES, ROUND_BYTES = 3 * 8 + 1, 5 * 8 + 1
VALUES_PER_LINE = 5
PROCESSES = ("cut", "mark", "engrave")
TRAVEL, ROUND = 0, 7  #: kinds of operations in a table; between them: on and off of each process


class ChainError(ValueError):
    """More operations than a chain may have."""

    def __init__(self, found: int, expected: int) -> None:
        super().__init__(f"{found} operations; expected at most {expected}")
        self.found, self.expected = found, expected


def emit(table: TriggerTable, machine: Machine, style: str | None = None) -> str:
    """The text of all units of a job, each behind a comment that names it.

    `style` is "chain" or "table", or None for the machine's own; a path beyond the machine's
    greatest chain is a table then. Raises ChainError for a chain that is asked for and too long.
    """
    triggers = machine.triggers
    if triggers is None:
        raise TypeError(f"{machine.name} has no trigger program")
    count = len(table.operations)
    if style == "chain" and count > triggers.greatest_chain:
        raise ChainError(count, triggers.greatest_chain)
    if style is None:
        style = "table" if count > triggers.greatest_chain else triggers.style
    name = unit_name(table.job)
    writer = _Writer(table, machine, triggers, name)
    text_ = writer.chain() if style == "chain" else writer.table()
    return _as_called(text_, triggers.names)


def _as_called(program: str, names: Mapping[str, str]) -> str:
    """A program with names of the controller's library as the project's package has them."""
    if not names:
        return program
    words = re.compile(rf"\b(?:{'|'.join(map(re.escape, names))})\b")
    return words.sub(lambda word: names[word[0]], program)


def lreal(value: float) -> str:
    """A typed literal."""
    plain = number(value, 6)
    return f"LREAL#{plain if '.' in plain else plain + '.0'}"


class _Writer:
    def __init__(
        self, table: TriggerTable, machine: Machine, triggers: Triggers, name: str
    ) -> None:
        self.operations = table.operations
        self.remarks = table.remarks
        self.machine, self.triggers, self.name = machine, triggers, name
        self.x, self.y = triggers.axes
        self.processes = [p for p in PROCESSES if p in triggers.outputs]
        self.rounds = triggers.path_objects

    def chain(self) -> str:
        """One unit with a block for each operation."""
        work = "\n".join(self._blocks())
        last = len(self.operations)
        body = self._program(
            globals_=f"        triggerActive : ARRAY [0..{last}] OF BOOL;",
            locals_=self._locals("            wait : TON;"),
            begin="                    triggerActive[0] := TRUE;",
            work=work,
        )
        return self._unit(body)

    def table(self) -> str:
        """A unit with the state machine, and as many with set-points as their size asks for."""
        size = ROUND_BYTES if self.rounds else POINT_BYTES
        per_unit = max(1, self.triggers.greatest_data // size)
        ops = self.operations
        chunks = [ops[k : k + per_unit] for k in range(0, len(ops), per_unit)]
        names = [f"{self.name}_{k}" for k in range(1, len(chunks) + 1)]
        body = self._program(
            globals_="\n".join(f"        {line}" for line in self._table_globals()),
            locals_=self._locals("            wait : TON;\n            fetch : FB_Fetch;"),
            begin="                    operation := DINT#0;\n"
            "                    triggerActive := TRUE;",
            work=self._machine(),
            uses=f"    USES {', '.join(names)};\n",
            exports="    FUNCTION_BLOCK FB_Fetch;\n",
            blocks=self._fetch(chunks, per_unit),
        )
        text_ = self._unit(body)
        start = 1
        for k, chunk in enumerate(chunks, 1):
            text_ += "\n" + self._data_unit(names[k - 1], k, chunk, start)
            start += len(chunk)
        return text_

    # -- what both styles share -------------------------------------------------------------

    def _unit(self, body: str) -> str:
        return UNIT_MARK.format(name=self.name) + "\n" + body

    def _locals(self, more: str) -> str:
        lines = [more]
        if self.rounds:
            lines += [
                "            pathLine : FB_PathLine;",
                "            pathCircle : FB_PathCircle;",
            ]
        else:
            lines.append("            line : FB_Line;")
        return "\n".join(lines)

    def _program(
        self, globals_: str, locals_: str, begin: str, work: str, uses: str = "",
        exports: str = "", blocks: str = "",
    ) -> str:  # fmt: skip
        t = self.triggers
        own = "FB_PathLine FB_PathCircle" if self.rounds else "FB_Line"
        interface = text.INTERFACE.format(
            package=t.package,
            uses=uses,
            last=len(self.operations),
            in_position=lreal(t.in_position)[6:],
            acceleration=lreal(t.acceleration)[6:],
            homing=lreal(t.homing_mm_s)[6:],
            back_off=lreal(t.back_off)[6:],
            pierces="\n".join(self._pierces()),
            limits=t.limits,
            start=t.start,
            outputs="\n".join(f"        {p}On AT {t.outputs[p]} : BOOL;" for p in self.processes),
            globals=globals_,
            exports=exports + "\n".join(f"    FUNCTION_BLOCK {name};" for name in own.split()),
        )
        back_off = text.pos("axis", "BACK_OFF", "HOMING_VELOCITY", "PATH_ACCELERATION")
        off = "\n".join(f"                {p}On := FALSE;" for p in self.processes)
        stops = [text.STOP.format(axis=axis) for axis in t.axes]
        if self.rounds:
            line = text.PATH.format(path=t.path_object)
            stops.append(text.STOP_PATH.format(path=t.path_object))
        else:
            line = text.LINE.format(
                pos_x=text.pos(self.x, "endX", "scaled.velocityX", "scaled.accelerationX"),
                pos_y=text.pos(self.y, "endY", "scaled.velocityY", "scaled.accelerationY"),
            )
        program = text.PROGRAM.format(
            x=self.x, y=self.y, locals=locals_, begin=begin, work=work, all_off=off,
            stops="\n".join(stops),
        )  # fmt: skip
        parts = [text.VELOCITY, line, text.HOME.format(back_off=back_off)]
        if blocks:
            parts.append(blocks)
        body = "\n".join([*parts, program])
        remarks = "".join(f"(* {comment_text(remark)} *)\n" for remark in self.remarks)
        return f"{remarks}{interface}\nIMPLEMENTATION\n{body}END_IMPLEMENTATION\n"

    def _pierces(self) -> Iterator[str]:
        for process in self.processes:
            waits = [op.wait_s for op in self.operations
                     if isinstance(op, Switch) and op.on and op.process == process]  # fmt: skip
            longest = round(1000 * max(waits, default=0.0))
            yield f"        PIERCE_{process.upper()} : TIME := T#{longest}ms;"

    # -- the chain --------------------------------------------------------------------------

    def _blocks(self) -> Iterator[str]:
        before: TriggerOp | None = None
        here = (0.0, 0.0)
        for k, op in enumerate(self.operations, 1):
            yield from self._trigger(k, before, op, here)
            if not isinstance(op, Switch):
                here = op.x, op.y
            before = op
        last = len(self.operations)
        pad = " " * 16
        yield f"{pad}IF triggerActive[{last}]"
        yield f"{pad}    AND {self._arrived(before, here)} THEN"
        yield f"{pad}    workState := INT#3;"
        yield f"{pad}END_IF;"

    def _trigger(
        self, k: int, before: TriggerOp | None, op: TriggerOp, here: tuple[float, float]
    ) -> Iterator[str]:
        pad = " " * 16
        yield f"{pad}(* {k}: {_said(op)} *)"
        yield f"{pad}IF triggerActive[{k - 1}] AND NOT triggerActive[{k}]"
        yield f"{pad}    AND {self._arrived(before, here)} THEN"
        yield f"{pad}    triggerActive[{k}] := TRUE;"
        for line in self._start(op, here):
            yield f"{pad}    {line}"
        yield f"{pad}END_IF;"
        if isinstance(op, Switch) and op.on:
            yield f"{pad}IF triggerActive[{k}] AND NOT triggerActive[{k + 1}] THEN"
            yield f"{pad}    wait(IN := TRUE, PT := PIERCE_{op.process.upper()});"
            yield f"{pad}END_IF;"

    def _arrived(self, before: TriggerOp | None, here: tuple[float, float]) -> str:
        if isinstance(before, Switch):
            return "wait.Q" if before.on else f"NOT {before.process}On"
        x, y = (
            f"(ABS({axis}.basicMotion.position - {lreal(value)}) <= IN_POSITION)"
            for axis, value in zip(self.triggers.axes, here, strict=True)
        )
        return f"axesAtRest\n                    AND {x}\n                    AND {y}"

    def _start(self, op: TriggerOp, here: tuple[float, float]) -> Iterator[str]:
        if isinstance(op, Switch):
            yield f"{op.process}On := {'TRUE' if op.on else 'FALSE'};"
            if op.on:
                yield f"wait(IN := FALSE, PT := PIERCE_{op.process.upper()});"
        elif isinstance(op, Round):
            yield f"pathCircle(middleX := {lreal(op.middle_x)}, middleY := {lreal(op.middle_y)},"
            yield f"    endX := {lreal(op.x)}, endY := {lreal(op.y)},"
            yield f"    speed := {lreal(op.speed_mm_s)});"
        elif self.rounds:
            yield f"pathLine(endX := {lreal(op.x)}, endY := {lreal(op.y)},"
            yield f"    speed := {lreal(op.speed_mm_s)});"
        else:
            yield f"line(startX := {lreal(here[0])}, startY := {lreal(here[1])},"
            yield f"    endX := {lreal(op.x)}, endY := {lreal(op.y)},"
            yield f"    speed := {lreal(op.speed_mm_s)});"

    # -- the table --------------------------------------------------------------------------

    def _table_globals(self) -> Iterator[str]:
        yield "operation : DINT := DINT#0;"
        yield "triggerActive : BOOL := FALSE;"
        yield "operationArrived : BOOL := FALSE;"
        yield "kind : USINT := USINT#0;"
        names = ["lastX", "lastY", "targetX", "targetY", "targetSpeed"]
        names += ["middleX", "middleY"] if self.rounds else []
        for name in names:
            yield f"{name} : LREAL := LREAL#0.0;"

    def _machine(self) -> str:
        if self.rounds:
            start = "pathLine(endX := targetX, endY := targetY, speed := targetSpeed);"
        else:
            start = (
                "line(startX := lastX, startY := lastY,\n"
                "                                endX := targetX, endY := targetY,"
                " speed := targetSpeed);"
            )
        on = off = waits = kinds = ""
        for process in self.processes:
            n = 2 * PROCESSES.index(process) + 1
            upper = process.upper()
            on += f"""
                            {n}:
                                {process}On := TRUE;
                                wait(IN := FALSE, PT := PIERCE_{upper});
                            {n + 1}:
                                {process}On := FALSE;"""
            waits += f"""
                        {n}:
                            wait(IN := TRUE, PT := PIERCE_{upper});
                            operationArrived := wait.Q;
                        {n + 1}:
                            operationArrived := NOT {process}On;"""
        if self.rounds:
            off = f"""
                            {ROUND}:
                                pathCircle(middleX := middleX, middleY := middleY,
                                    endX := targetX, endY := targetY, speed := targetSpeed);"""
        kinds = f"0, {ROUND}" if self.rounds else "0"
        return f"""\
                IF operation > DINT#0 THEN
                    operationArrived := FALSE;
                    CASE kind OF
                        {kinds}:
                            operationArrived := axesAtRest
                                AND (ABS({self.x}.basicMotion.position - targetX) <= IN_POSITION)
                                AND (ABS({self.y}.basicMotion.position - targetY) <= IN_POSITION);\
{waits}
                    END_CASE;
                    triggerActive := operationArrived;
                END_IF;
                IF triggerActive THEN
                    triggerActive := FALSE;
                    operation := operation + DINT#1;
                    IF operation > LAST_OPERATION THEN
                        workState := INT#3;
                    ELSE
                        fetch(index := operation);
                        CASE kind OF
                            0:
                                {start}{on}{off}
                        END_CASE;
                    END_IF;
                END_IF;"""

    def _fetch(self, chunks: Sequence[Sequence[TriggerOp]], per_unit: int) -> str:
        lines = ["    (* The set-points of an operation, from the unit that holds them. *)"]
        lines += ["    FUNCTION_BLOCK FB_Fetch", "        VAR_INPUT", "            index : DINT;"]
        lines += [
            "        END_VAR",
            "        VAR",
            "            row : DINT;",
            "        END_VAR",
            "",
        ]
        lines += ["        lastX := targetX;", "        lastY := targetY;"]
        first = 0
        for k, chunk in enumerate(chunks, 1):
            word = "IF" if k == 1 else "ELSIF"
            lines.append(f"        {word} index <= DINT#{first + len(chunk)} THEN")
            lines.append(f"            row := index - DINT#{first};")
            lines.append(f"            kind := pointKind_{k}[row];")
            indent = "            "
            for target, column in self._columns():
                lines.append(f"{indent}{target} := {column}_{k}[row];")
            first += len(chunk)
        lines += ["        END_IF;", "    END_FUNCTION_BLOCK", ""]
        return "\n".join(lines)

    def _columns(self) -> list[tuple[str, str]]:
        found = [("targetX", "pointX"), ("targetY", "pointY"), ("targetSpeed", "pointSpeed")]
        if self.rounds:
            found += [("middleX", "pointMiddleX"), ("middleY", "pointMiddleY")]
        return found

    def _data_unit(self, name: str, k: int, ops: Sequence[TriggerOp], start: int) -> str:
        """Arrays of set-points; a switch holds the place that the head stands at."""
        here = self._place_before(start)
        rows = []
        for op in ops:
            kind, speed, middle = TRAVEL, 0.0, here
            if isinstance(op, Switch):
                kind = 2 * PROCESSES.index(op.process) + (1 if op.on else 2)
            else:
                here = op.x, op.y
                speed = op.speed_mm_s
                if isinstance(op, Round):
                    kind, middle = ROUND, (op.middle_x, op.middle_y)
            rows.append((*here, speed, *middle, kind))
        columns = list(zip(*rows, strict=True))
        lines = [UNIT_MARK.format(name=name), "INTERFACE", "    VAR_GLOBAL CONSTANT"]
        for which, (_, column) in enumerate(self._columns()):
            values = [lreal(v) for v in columns[which]]
            lines += _array(f"{column}_{k}", "LREAL", values)
        lines += _array(f"pointKind_{k}", "USINT", [f"USINT#{v}" for v in columns[5]])
        lines += ["    END_VAR", "END_INTERFACE", "", "IMPLEMENTATION", "END_IMPLEMENTATION", ""]
        return "\n".join(lines)

    def _place_before(self, start: int) -> tuple[float, float]:
        for op in reversed(self.operations[: start - 1]):
            if not isinstance(op, Switch):
                return op.x, op.y
        return 0.0, 0.0


def _array(name: str, type_: str, values: Sequence[str]) -> list[str]:
    lines = [f"        {name} : ARRAY [1..{len(values)}] OF {type_} := ["]
    for k in range(0, len(values), VALUES_PER_LINE):
        comma = "," if k + VALUES_PER_LINE < len(values) else ""
        lines.append(f"            {', '.join(values[k : k + VALUES_PER_LINE])}{comma}")
    lines.append("        ];")
    return lines


def _said(op: TriggerOp) -> str:
    if isinstance(op, Switch):
        return f"{op.process} {'on' if op.on else 'off'}"
    kind = "line" if isinstance(op, Travel) else "arc"
    at = f"X {number(op.x, 3)} Y {number(op.y, 3)}"
    return f"{kind} to {at} at {number(op.speed_mm_s, 3)} mm/s"
