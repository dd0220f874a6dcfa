"""Trigger programs as Structured Text: complete units that a D425 takes, or plain IEC 61131-3.

The runtime of the machine, which is the same for every job, and in it what is the job's own.
Two styles: `chain`, a block of statements for each operation, which fires once its predecessor is
active and has arrived, and latches; `table`, set-points in arrays, split over units where one would
get too large. What a dialect calls the sections of a job stands in machine/tables.py.
"""

import re
from collections.abc import Iterator, Sequence
from math import ceil
from zlib import crc32

from msgspec import Struct

from beamcam.machine.machine import Machine
from beamcam.machine.runtime import PROCESSES, dialect_of, lreal, runtime_of
from beamcam.machine.tables import TableDialect, Triggers
from beamcam.model.program import LiftTorch, SwitchTool, Travel, TriggerOp, TriggerTable
from beamcam.plain_text import comment_text

# --- units of a trigger program: their names, and a program taken apart into them -----------------


UNIT_MARK = "(* ===== UNIT {name} ===== *)"
_MARK = re.compile(r"\(\* ===== UNIT (\w+) ===== \*\)")
MAX_NAME = 24


def unit_name(job: str) -> str:
    """An ASCII name for the units of a job: letters, digits and single underscores.

    What is too long ends in a check sum, so that two jobs that begin alike keep two names.
    """
    plain = re.sub(r"[^A-Za-z0-9]+", "_", job).strip("_")
    if len(plain) > MAX_NAME:
        plain = f"{plain[: MAX_NAME - 9].strip('_')}_{crc32(plain.encode()):08x}"
    return f"unit_{plain}" if plain else "unit_job"


def units(program: str) -> tuple[tuple[str, str], ...]:
    """Name and text of each unit of a program, the main one first."""
    pieces = _MARK.split(program)
    return tuple((pieces[k], pieces[k + 1].lstrip("\n")) for k in range(1, len(pieces), 2))


def split_units(program: str) -> tuple[tuple[str, str], ...]:
    """Name and text of each unit with its mark, so that joined files are the program again."""
    marks = list(_MARK.finditer(program))
    ends = [*(mark.start() for mark in marks[1:]), len(program)]
    return tuple(
        (mark[1], program[mark.start() : end]) for mark, end in zip(marks, ends, strict=True)
    )


#: Bytes of one operation in a unit of set-points: x, y, speed and kind; the place in the middle of
#: an arc, for path objects; the height, for a torch that is lifted.
POINT_BYTES, MIDDLE_BYTES, HEIGHT_BYTES = 3 * 8 + 1, 2 * 8, 8
VALUES_PER_LINE = 5
LINE, ARC, LIFT = 0, 7, 8  #: kinds of operations; between them: on and off of each process


class _Row(Struct, frozen=True):
    """One operation as numbers; a switch holds the place that the head stands at."""

    name: str
    kind: int
    x: float
    y: float
    height: float  #: of the torch over the sheet
    speed: float
    via: tuple[float, float]


class _Chunk(Struct, frozen=True):
    """The set-points of one unit."""

    unit: str
    number: int
    first: int  #: operation, counted from 1
    rows: tuple[_Row, ...]


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
    triggers = machine.needed(machine.triggers, "trigger program")
    count = len(table.operations)
    if style == "chain" and count > triggers.max_chain:
        raise ChainError(count, triggers.max_chain)
    if style is None:
        style = "table" if count > triggers.max_chain else triggers.style
    rows = tuple(_rows(table.operations, triggers.home_over(table.thickness)))
    name = unit_name(table.job)
    size = POINT_BYTES + MIDDLE_BYTES * triggers.path_objects + HEIGHT_BYTES * bool(triggers.z)
    dialect = dialect_of(machine)
    per_unit = max(1, triggers.max_data // size) if dialect.has_units else max(1, count)
    starts = range(0, len(rows), per_unit) if style == "table" else ()
    chunks = [_Chunk(f"{name}_{k}", k, at + 1, rows[at : at + per_unit])
              for k, at in enumerate(starts, 1)]  # fmt: skip
    uses = (*triggers.uses, *(chunk.unit for chunk in chunks if dialect.has_units))
    runtime = runtime_of(machine, style)
    pieces = [
        UNIT_MARK.format(name=name) + "\n",
        *(f"(* {comment_text(remark)} *)\n" for remark in table.remarks),
        runtime.head,
        f"    USES {', '.join(uses)};\n" if uses else "",
        *_declarations(table, chunks, triggers, dialect),
        runtime.middle,
        *(_fetches(chunks, triggers) if style == "table" else _blocks(rows, triggers)),
        runtime.end,
    ]
    for chunk in chunks if dialect.has_units else ():
        lines = ["", UNIT_MARK.format(name=chunk.unit), "INTERFACE", f"    {dialect.constants}"]
        lines += _arrays(chunk, triggers)
        lines += ["    END_VAR", "END_INTERFACE", "", "IMPLEMENTATION", "END_IMPLEMENTATION", ""]
        pieces.append("\n".join(lines))
    return "".join(pieces)


def _rows(operations: Sequence[TriggerOp], height: float) -> Iterator[_Row]:
    """The operations as numbers, from the corner of the work area and the torch at a height on."""
    here = (0.0, 0.0)
    for op in operations:
        if isinstance(op, SwitchTool):
            kind = 2 * PROCESSES.index(op.process) + (1 if op.on else 2)
            yield _Row(f"{op.process} {'on' if op.on else 'off'}", kind, *here, height, 0.0, here)
        elif isinstance(op, LiftTorch):
            direction, height = "up" if op.height > height else "down", op.height
            yield _Row(direction, LIFT, *here, height, op.speed_mm_s, here)
        elif isinstance(op, Travel):
            here = op.x, op.y
            yield _Row("line", LINE, *here, height, op.speed_mm_s, here)
        else:
            here = op.x, op.y
            yield _Row("arc", ARC, *here, height, op.speed_mm_s, (op.middle_x, op.middle_y))


def _declarations(
    table: TriggerTable, chunks: Sequence[_Chunk], triggers: Triggers, dialect: TableDialect
) -> Iterator[str]:
    """Constants, and the triggers of a chain, or the set-points of a table without units."""
    yield f"    {dialect.constants}\n"
    yield f"        LAST_OPERATION : DINT := DINT#{len(table.operations)};\n"
    if triggers.z is not None:
        yield f"        SHEET_THICKNESS : LREAL := {lreal(table.thickness)};\n"
    for process in PROCESSES:
        waits = (op.wait_s for op in table.operations
                 if isinstance(op, SwitchTool) and op.on and op.process == process)  # fmt: skip
        longest = ceil(1000 * max(waits, default=0.0) - 1e-9)
        yield f"        PIERCE_{process.upper()} : TIME := T#{longest}ms;\n"
    yield "    END_VAR\n"
    if chunks and dialect.has_units:
        return
    yield f"    {dialect.variables}\n"
    if not chunks:
        yield f"        triggerActive : ARRAY [0..{len(table.operations)}] OF BOOL;\n"
    for chunk in chunks:
        yield from (f"{line}\n" for line in _arrays(chunk, triggers))
    yield "    END_VAR\n"


def _blocks(rows: Sequence[_Row], triggers: Triggers) -> Iterator[str]:
    """The chain: a latched block for each operation."""
    for k, row in enumerate(rows, 1):
        via = ""
        if triggers.path_objects:
            via = (
                f",\n                middleX := {lreal(row.via[0])}, middleY := {lreal(row.via[1])}"
            )
        height = f"z := {lreal(row.height)}, " if triggers.z else ""
        yield f"""\
        (* {k}: {row.name} *)
        IF operationArrived AND triggerActive[{k - 1}] AND NOT triggerActive[{k}] THEN
            triggerActive[{k}] := TRUE;
            next(kind := USINT#{row.kind}, x := {lreal(row.x)}, y := {lreal(row.y)},
                {height}speed := {lreal(row.speed)}{via});
        END_IF;
"""


def _fetches(chunks: Sequence[_Chunk], triggers: Triggers) -> Iterator[str]:
    """The table: the row of an operation, from the unit that holds it."""
    for chunk in chunks:
        k, last = chunk.number, chunk.first + len(chunk.rows) - 1
        via, height = "", f"z := pointZ_{k}[row], " if triggers.z else ""
        if triggers.path_objects:
            via = f",\n                middleX := pointViaX_{k}[row], middleY := pointViaY_{k}[row]"
        yield f"""\
        IF (row >= DINT#{chunk.first}) AND (row <= DINT#{last}) THEN
            next(kind := pointKind_{k}[row], x := pointX_{k}[row], y := pointY_{k}[row],
                {height}speed := pointSpeed_{k}[row]{via});
        END_IF;
"""


def _arrays(chunk: _Chunk, triggers: Triggers) -> Iterator[str]:
    """Arrays of set-points, with the numbers of the operations as their bounds."""
    rows = chunk.rows
    columns = [
        ("pointX", "LREAL", [lreal(row.x) for row in rows]),
        ("pointY", "LREAL", [lreal(row.y) for row in rows]),
        ("pointSpeed", "LREAL", [lreal(row.speed) for row in rows]),
    ]
    if triggers.z is not None:
        columns.insert(2, ("pointZ", "LREAL", [lreal(row.height) for row in rows]))
    if triggers.path_objects:
        columns.append(("pointViaX", "LREAL", [lreal(row.via[0]) for row in rows]))
        columns.append(("pointViaY", "LREAL", [lreal(row.via[1]) for row in rows]))
    columns.append(("pointKind", "USINT", [f"USINT#{row.kind}" for row in rows]))
    bounds = f"{chunk.first}..{chunk.first + len(rows) - 1}"
    for name, type_, values in columns:
        yield f"        {name}_{chunk.number} : ARRAY [{bounds}] OF {type_} := ["
        for at in range(0, len(values), VALUES_PER_LINE):
            comma = "," if at + VALUES_PER_LINE < len(values) else ""
            yield f"            {', '.join(values[at : at + VALUES_PER_LINE])}{comma}"
        yield "        ];"
