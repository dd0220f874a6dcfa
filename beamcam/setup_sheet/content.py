"""Content of a setup sheet, as data."""

from collections.abc import Iterable, Iterator, Sequence
from pathlib import PurePath
from typing import Literal

from msgspec import Struct
from msgspec.structs import replace

from beamcam.errors import Diagnostic, Severity, errors_in
from beamcam.model.part import Part
from beamcam.model.plan import AnyPlan, Plan, clock
from beamcam.pictures.bar import BarMade
from beamcam.pictures.program import ReadProgram
from beamcam.pictures.scene import Scene, Unit
from beamcam.pictures.table import TableMade
from beamcam.report.hand_list import HandRow, hand_rows
from beamcam.report.run import ledger_of
from beamcam.setup_sheet.operations import Operation, operations_of, table_operations
from beamcam.setup_sheet.totals import Total, bar_totals, table_totals
from beamcam.simulate.limits import run_warnings
from beamcam.simulate.program import simulate_program
from beamcam.simulate.trace import Trace

LEFT_OUT = ("plan-left-out", "verify-left-out")


class ToolRow(Struct, frozen=True):
    """A tool to load."""

    where: str  #: spindle, or head
    station: str  #: blank where the program does not say
    tool: str


class BarStretch(Struct, frozen=True):
    """A stretch of the bar."""

    what: str
    start: float
    end: float


class Content(Struct, frozen=True):
    """All that the sheet says."""

    program: ReadProgram
    made: BarMade | TableMade  #: what it makes
    unit: Unit
    trace: Trace
    header: tuple[tuple[str, str], ...]
    pictures: tuple[Scene, ...]  #: the program's first, then the parts
    operations: tuple[Operation, ...]
    totals: tuple[Total, ...]  #: of work and travel, by tool
    tools: tuple[ToolRow, ...]
    bar: tuple[BarStretch, ...]
    left_out: tuple[str, ...]
    hand: tuple[HandRow, ...]  #: marks on the list of manual work
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
    said: tuple[Diagnostic, ...] = ()  #: by readers and the planner
    found: tuple[Diagnostic, ...] = ()  #: by the read-back
    compared: bool = True  #: with the parts, if there are any
    settings: tuple[tuple[str, str], ...] = ()  #: rows of the header about where they come from


def content_of(source: SheetSources, unit: Unit = "mm") -> Content:
    """Content of a program's setup sheet. Raises VerifyError where none of it is understood."""
    from beamcam.pictures.bar import bar_scene
    from beamcam.pictures.coper import coper_scene
    from beamcam.pictures.part import part_scene
    from beamcam.pictures.program import bar_made, coper_program, table_made
    from beamcam.pictures.table import table_scene
    from beamcam.setup_sheet.unrolled import coper_made, coper_operations

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
        bar = tuple(_stretches(made))
    elif machine.stock == "profile":
        known = coper_program(program)
        made = coper_made(known, trace)
        trace = made.trace
        scene = coper_scene(known, unit)
        operations = coper_operations(known, made)
        totals = table_totals(made)
        tools = (ToolRow("torch", "", "cut"),)
    else:
        made = table_made(program, done)
        scene = table_scene(made, unit)
        operations = table_operations(made)
        totals = table_totals(made)
        tools = tuple(ToolRow("head", "", p) for p in dict.fromkeys(o.what for o in operations))
    run = run_warnings(trace, machine, done.section, program.name)
    messages = tuple(map(_without_folder, (*source.said, *source.found, *run)))
    verdict: Literal["made", "alone", "wrong"] = "made" if program.parts else "alone"
    if errors_in(source.found) or not source.compared:
        verdict = "wrong"
    return Content(
        program, made, unit, trace, (*_header(program, trace), *source.settings), (scene, *drawn),
        operations,
        totals,
        tools, bar,
        tuple(f"{d.source}: {d.message}" for d in messages if d.code in LEFT_OUT),
        tuple(hand_rows(source.plan)) if source.plan is not None else (),
        tuple(d for d in messages if d.severity is not Severity.NOTE or d.code not in LEFT_OUT),
        ledger_of(source.plan.outcomes) if source.plan is not None else "",
        verdict,
    )  # fmt: skip


def _without_folder(said: Diagnostic) -> Diagnostic:
    """A message that is the same in each folder."""
    return replace(said, source=replace(said.source, file=PurePath(said.source.file).name))


def _header(program: ReadProgram, trace: Trace) -> Sequence[tuple[str, str]]:
    """The lines of the header, empty ones left out."""
    parts = program.parts
    rows = [
        ("Program", program.name),
        ("Machine", f"{program.machine.name}: {program.machine.title}"),
        ("Mark", _joined(p.mark for p in parts)),
        ("Order", _joined(p.order for p in parts)),
        ("Drawing", _joined(p.drawing for p in parts)),
        ("Section", _joined(p.profile.name for p in parts)),
        ("Grade", _joined(p.grade for p in parts)),
        ("Quantity", _quantities(parts)),
        ("Machine time", clock(trace.duration_s)),
    ]
    return [(label, value) for label, value in rows if value]


def _joined(values: Iterable[str]) -> str:
    return ", ".join(dict.fromkeys(v for v in values if v))


def _quantities(parts: Sequence[Part]) -> str:
    """Required quantity, and the quantity that this program makes."""
    rows = []
    for part in dict.fromkeys(parts):
        here = sum(1 for p in parts if p == part)
        rows.append(f"{part.mark or 'part'}: {here} of {max(part.quantity, here)}")
    return ", ".join(rows)


def _bar_tools(source: SheetSources, operations: Sequence[Operation]) -> tuple[ToolRow, ...]:
    """The tools by station as the plan loads them; by spindle alone where no plan is known."""
    machine = source.program.machine
    if isinstance(source.plan, Plan):
        from beamcam.planning.order import tool_loads

        return tuple(
            ToolRow(load.spindle, _station(load.station, load.before, load.out is not None),
                    load.tool.name)
            for load in tool_loads(source.plan.operations, machine)
        )  # fmt: skip
    names: dict[str, str] = {s.face: s.name for s in machine.spindles}
    found = {
        (names.get(face, face), op.tool): None
        for op in operations if op.tool for face in op.faces
    }  # fmt: skip
    order = list(dict.fromkeys([*names.values(), *(where for where, _ in found)]))
    rows = sorted(found, key=lambda row: order.index(row[0]))
    return tuple(ToolRow(where, "", tool) for where, tool in rows)


def _station(station: int, before: int, changed: bool) -> str:
    return f"{station}, changed manually before operation {before + 1}" if changed else str(station)


def _stretches(made: BarMade) -> Iterator[BarStretch]:
    """Trims, parts and remnant, each from its first to its last corner."""
    for piece in made.pieces():
        start, end = made.extent(piece)
        if piece.kind == "remnant" and made.bar is None:
            continue  # nobody knows where it ends
        if end - start > made.machine.format.resolution:
            yield BarStretch(piece.mark or piece.kind, start, end)
