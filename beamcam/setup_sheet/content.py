"""Content of a setup sheet, as data.

A coper's program for a setup sheet: the way of the torch over the surface of the bar, unrolled.

y   o   height + (width - Z)      the flange above v, its edge beside v at the height
    v   Y                         the web from the front
    u   -(width - Z)              the flange below
of a tube that turns the way round its surface, from the middle of its lowest line towards v
"""

from collections.abc import Iterable, Sequence
from pathlib import PurePath
from typing import Literal

import numpy as np
from msgspec import Struct
from msgspec.structs import replace

from beamcam.checks.coping.tube import tube_section
from beamcam.errors import Diagnostic, Severity, errors_in
from beamcam.geometry.array_types import Floats
from beamcam.machine.coper import Coper
from beamcam.model.part import Part
from beamcam.model.plan import AnyPlan, Plan, clock
from beamcam.model.rounds import rolled
from beamcam.pictures import ReadProgram
from beamcam.pictures.bar_made import BarMade
from beamcam.pictures.coper import part_of, strokes_of
from beamcam.pictures.scene import Scene, Unit
from beamcam.pictures.table import TableMade
from beamcam.planning.manual_list import ManualRow, manual_rows
from beamcam.reports.run import ledger_of
from beamcam.setup_sheet.operations import SheetOperation, operations_of, table_operations
from beamcam.simulation.limits import run_warnings
from beamcam.simulation.program import simulate_program
from beamcam.simulation.trace import Trace, TraceAxis

ROUND = TraceAxis("round the bar", "mm", has_encoder=False)


def coper_made(program: ReadProgram, trace: Trace) -> TableMade:
    """The way of the torch as that of a head over a table: along the bar, and round it.

    Raises VerifyError where the section is not known.
    """
    machine = program.machine
    coper = machine.needed(machine.coper, "coper")
    round_bar = _round(trace.positions, rolled(part_of(program)), coper)
    positions = np.insert(trace.positions, 1, round_bar, axis=1)
    axes = (trace.axes[0], ROUND, *trace.axes[1:])
    return TableMade(
        replace(trace, axes=axes, positions=positions), machine, program.name, program.sha256
    )


def _round(positions: Floats, part: Part, coper: Coper) -> Floats:
    """Where the torch is round the bar at each knot, mm."""
    profile = part.profile
    if coper.y == "fixed":
        positions = np.insert(positions, 1, 0.0, axis=1)
    _, y, z, a_deg, *tilts = positions.T
    if coper.a_unit == "mm":
        around: Floats = a_deg.copy()
        return around
    if coper.unrolls(part.profile.code):
        place = tube_section(part, coper).place
        sizes: Floats = np.array([place(*row)[0] for row in positions[:, 1:].tolist()])
        return sizes
    a, pivot = np.radians(a_deg), coper.pivot
    if tilts:
        pivot = pivot * np.cos(np.radians(tilts[0]))
    tip_y, tip_z = y + pivot * np.sin(a), z - pivot * np.cos(a)
    if coper.turns == "bar":  # as seen from it
        tip_y = profile.height / 2 + y * np.cos(a) - z * np.sin(a)
        tip_z = profile.width / 2 + y * np.sin(a) + z * np.cos(a)
    beside = profile.width - tip_z
    sizes = np.select(
        [a_deg < -45.0, a_deg > 45.0], [profile.height + beside, -beside], default=tip_y
    )
    return sizes


def coper_operations(program: ReadProgram, made: TableMade) -> tuple[SheetOperation, ...]:
    """The cuts with the faces that they are on; X is the machine's."""
    part = part_of(program)
    strokes = strokes_of(program, part)
    is_round = part.profile.code == "RO" or rolled(part) is not part
    return tuple(
        replace(op, what="cut" if is_round else f"cut on face {stroke.face}", y=None)
        for op, stroke in zip(table_operations(made), strokes, strict=True)
    )


class Total(Struct, frozen=True):
    """A row of the times."""

    what: str  #: a tool, a process, or travel
    count: int | None  #: of operations or paths
    work_s: float  #: in the steel, or with the tool on
    seconds: float  #: with the way to each of them
    length: float | None = None  #: of a table's way


def bar_totals(operations: Sequence[SheetOperation], trace: Trace) -> tuple[Total, ...]:
    """The times of a bar's tools: at work is the block that feeds or saws."""
    lasts = np.diff(trace.time_s)
    rows: dict[str, list[SheetOperation]] = {}
    for op in operations:
        rows.setdefault(op.tool or "saw", []).append(op)
    totals = [
        Total(
            tool, len(ops), float(lasts[np.isin(trace.line, [op.line for op in ops])].sum()),
            sum(op.seconds for op in ops),
        )
        for tool, ops in rows.items()
    ]  # fmt: skip
    work = sum(row.work_s for row in totals)
    travel = Total("travel and changes", None, 0.0, trace.duration_s - work)
    return (*totals, travel, Total("together", len(operations), work, trace.duration_s))


def table_totals(table: TableMade) -> tuple[Total, ...]:
    """Times and lengths of a table by process, and of the ways between with nothing on."""
    trace, totals = table.trace, []
    lasts = np.diff(trace.time_s)
    ways = np.hypot(*np.diff(trace.positions[:, :2], axis=0).T)
    process = [state.process for state in trace.states]
    of = np.array([process[k] for k in trace.state.tolist()], dtype=object)
    for name in dict.fromkeys(p for _, _, p in table.strokes):
        own = of == name
        count = sum(p == name for _, _, p in table.strokes)
        on = float(lasts[own].sum())
        totals.append(Total(name, count, on, on, float(ways[own].sum())))
    off = of == ""
    on, length = float(lasts[~off].sum()), float(ways.sum())
    travel = Total("travel", None, 0.0, float(lasts[off].sum()), float(ways[off].sum()))
    together = Total("together", len(table.strokes), on, trace.duration_s, length)
    return (*totals, travel, together)


LEFT_OUT = ("plan-left-out", "verify-left-out")


class ToolRow(Struct, frozen=True):
    """A tool to load."""

    where: str  #: spindle, or head
    station: str  #: blank where the program does not say
    tool: str


class BarStretch(Struct, frozen=True):
    """A piece of the bar, a trim or the remnant."""

    what: str
    start: float
    end: float


class SheetContent(Struct, frozen=True):
    """All that the sheet says."""

    program: ReadProgram
    made: BarMade | TableMade  #: what it makes
    unit: Unit
    trace: Trace
    header: tuple[tuple[str, str], ...]
    pictures: tuple[Scene, ...]  #: the program's first, then the parts
    operations: tuple[SheetOperation, ...]
    totals: tuple[Total, ...]  #: of work and travel, by tool
    tools: tuple[ToolRow, ...]
    bar: tuple[BarStretch, ...]
    left_out: tuple[str, ...]
    hand: tuple[ManualRow, ...]  #: marks on the list of manual work
    messages: tuple[Diagnostic, ...]  #: of readers, planner, read-back and simulator
    ledger: str  #: blank where no part is known
    verdict: Literal["made", "alone", "wrong"]

    @property
    def seconds(self) -> float:
        """Machine time."""
        return self.trace.duration_s


class SheetSources(Struct, frozen=True):
    """Sources of a setup sheet."""

    program: ReadProgram
    plan: AnyPlan | None = None  #: of a program that was posted just now
    diagnostics: tuple[Diagnostic, ...] = ()  #: by readers and the planner
    read_back: tuple[Diagnostic, ...] = ()  #: what is wrong by it
    compared: bool = True  #: with the parts, if there are any
    settings: tuple[tuple[str, str], ...] = ()  #: rows of the header about where they come from


def content_of(source: SheetSources, unit: Unit = "mm") -> SheetContent:
    """Content of a program's setup sheet. Raises VerifyError where none of it is understood."""
    from beamcam.pictures.bar import bar_scene
    from beamcam.pictures.coper import coper_scene
    from beamcam.pictures.part import part_scene
    from beamcam.pictures.program import bar_made, table_made
    from beamcam.pictures.table import table_scene

    program = source.program
    machine = program.machine
    done = simulate_program(program.data, machine, program.name, program.style, program.parts)
    trace = done.trace
    parts = tuple(dict.fromkeys(program.parts))
    table = machine.torch.colours if machine.torch is not None else None
    drawn = [part_scene(part, unit, table) for part in parts]
    bar: tuple[BarStretch, ...] = ()
    made: BarMade | TableMade
    if machine.stock == "beam":
        made = bar_made(program)
        scene = bar_scene(made, unit)
        operations = operations_of(made, trace)
        totals = bar_totals(operations, trace)
        tools = _bar_tools(source, operations)
        bar = tuple(
            BarStretch(piece.mark or piece.kind, start, end)
            for piece in made.pieces()
            if piece.kind != "remnant" or made.bar is not None  # else its end is not known
            for start, end in (made.extent(piece),)
            if end - start > machine.format.resolution
        )
    elif machine.stock == "profile":
        made = coper_made(program, trace)
        trace = made.trace
        scene = coper_scene(program, unit)
        operations = coper_operations(program, made)
        totals = table_totals(made)
        tools = (ToolRow("torch", "", "cut"),)
    else:
        made = table_made(program, done)
        scene = table_scene(made, unit)
        operations = table_operations(made)
        totals = table_totals(made)
        tools = tuple(ToolRow("head", "", p) for p in dict.fromkeys(o.what for o in operations))
    run = run_warnings(trace, machine, done.section, program.name)
    messages = tuple(  # without folders, so that they are the same in each
        replace(d, source=replace(d.source, file=PurePath(d.source.file).name))
        for d in (*source.diagnostics, *source.read_back, *run)
    )
    verdict: Literal["made", "alone", "wrong"] = "made" if program.parts else "alone"
    if errors_in(source.read_back) or not source.compared:
        verdict = "wrong"
    return SheetContent(
        program, made, unit, trace, (*_header(program, trace), *source.settings), (scene, *drawn),
        operations, totals, tools, bar,
        tuple(f"{d.source}: {d.message}" for d in messages if d.code in LEFT_OUT),
        tuple(manual_rows(source.plan)) if source.plan is not None else (),
        tuple(d for d in messages if d.severity is not Severity.NOTE or d.code not in LEFT_OUT),
        ledger_of(source.plan.outcomes) if source.plan is not None else "",
        verdict,
    )  # fmt: skip


def _header(program: ReadProgram, trace: Trace) -> Sequence[tuple[str, str]]:
    parts = program.parts
    quantities = []  #: that this program makes, of those that are required
    for part in dict.fromkeys(parts):
        here = sum(1 for p in parts if p == part)
        quantities.append(f"{part.mark or 'part'}: {here} of {max(part.quantity, here)}")
    rows = [
        ("Program", program.name), ("Machine", f"{program.machine.name}: {program.machine.title}"),
        ("Mark", _joined(p.mark for p in parts)), ("Order", _joined(p.order for p in parts)),
        ("Drawing", _joined(p.drawing for p in parts)),
        ("Section", _joined(p.profile.name for p in parts)),
        ("Grade", _joined(p.grade for p in parts)), ("Quantity", ", ".join(quantities)),
        ("Machine time", clock(trace.duration_s)),
    ]  # fmt: skip
    return [(label, value) for label, value in rows if value]


def _joined(values: Iterable[str]) -> str:
    return ", ".join(dict.fromkeys(v for v in values if v))


def _bar_tools(source: SheetSources, operations: Sequence[SheetOperation]) -> tuple[ToolRow, ...]:
    """The tools by station as the plan loads them; by spindle alone where no plan is known."""
    machine = source.program.machine
    if isinstance(source.plan, Plan):
        from beamcam.planning.order import tool_loads

        return tuple(
            ToolRow(load.spindle, str(load.station) if load.out is None else
                    f"{load.station}, changed manually before operation {load.before + 1}",
                    load.tool.name)
            for load in tool_loads(source.plan.operations, machine)
        )  # fmt: skip
    names: dict[str, str] = {s.face: s.name for s in machine.spindles}
    tools = {
        (names.get(face, face), op.tool): None for op in operations if op.tool for face in op.faces
    }
    order = list(dict.fromkeys([*names.values(), *(where for where, _ in tools)]))
    rows = sorted(tools, key=lambda row: order.index(row[0]))
    return tuple(ToolRow(where, "", tool) for where, tool in rows)
