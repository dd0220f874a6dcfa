"""The rest of a program after a stop in mid bar: from one of its operations to the end.

    whole program   head | 1 | 2 | 3 | 4 | 5 | foot
    done            head | 1 | 2 | 3 |                 what was made when the line stopped
    rest                      head, what has to be true | 4 | 5 | foot

The rest is read back behind what was done, against the parts as the whole was, and by itself.

The frame of a job: a program that leads the head round all of its work with the tool off.

A laser may show its spot, at a power that marks nothing (`torch.frame_power`).

3 ------------- 2
|  o   ____     |     Run before the job: the operator sees whether the sheet lies
|     |    |    |     under it, and whether a clamp is in the way.
0 ------------- 1
"""

from collections.abc import Iterator, Sequence

from msgspec.structs import replace

from beamcam.checks.bars.remainder import verify_remainder
from beamcam.checks.sheets.remainder import frame_faults, said_of
from beamcam.emitters import cutting, gcode
from beamcam.errors import Diagnostic, PlanError, error, errors_in
from beamcam.machine.machine import Machine
from beamcam.model.plan import Operation, Plan, SawOp, SheetPlan
from beamcam.model.program import (
    Command,
    Comment,
    DrillCycle,
    Feed,
    PathCycle,
    PrintText,
    Program,
    SawStroke,
    SetFeed,
    StartBar,
    StartSheet,
    ToolOff,
    ToolOn,
    Traverse,
)
from beamcam.model.request import Job
from beamcam.pipeline import Posted, RefusedProgram, by_told_bar
from beamcam.planning.contours.layout import worked_box
from beamcam.planning.order import tool_loads

OPERATION = error("plan-operation",
    "found operation {found} to begin with; expected 2 to {expected}, as `beamcam plan` counts",
    "Operation 1 begins the whole program.")  # fmt: skip
RULES = (OPERATION,)
_WORK = (SawStroke, DrillCycle, PathCycle, PrintText)


def rest_of(posted: Posted, first: int) -> Posted:
    """The program from operation `first` on, of one that was posted for a bar.

    Raises PlanError if there is no such operation, RefusedProgram if what was done and the rest do
    not make the parts.
    """
    plan, whole, job = posted.plan, posted.program, posted.job
    machine = job.machine
    if not isinstance(plan, Plan) or not isinstance(whole, Program):
        raise TypeError(f"{machine.name} works on no bars")
    source = job.parts[0].source
    count = len(plan.operations)
    if not 2 <= first <= count:
        raise PlanError(OPERATION.at(source, found=first, expected=count))
    head, rest = _parted(whole.commands, first)
    notes = map(Comment, what_has_to_be_true(plan, first, machine))
    text = gcode.emit(replace(whole, commands=(*head, *notes, *rest)), machine)
    wrong = faults_of(text, posted.text, first, replace(job, bar=plan.bar.length))
    if errors_in(wrong):
        raise RefusedProgram(wrong, text)
    return replace(posted, written=text)


def _parted(
    commands: Sequence[Command], first: int
) -> tuple[tuple[Command, ...], tuple[Command, ...]]:
    """The head of a program, and its commands from an operation on."""
    work = [k for k, command in enumerate(commands) if isinstance(command, _WORK)]
    begin = next(k for k, c in enumerate(commands) if not isinstance(c, StartBar | Comment))
    cut = work[first - 2] + 1
    return tuple(commands[:begin]), tuple(commands[cut:])


def faults_of(
    rest: str, whole: str, first: int, job: Job, whole_name: str = "whole program"
) -> tuple[Diagnostic, ...]:
    """Everything that is wrong with the remainder of a whole program from operation `first` on."""

    def verify(job: Job) -> tuple[Diagnostic, ...]:
        w = job.request
        return verify_remainder(
            whole, rest, first, job.parts, w.machine, w.skips, w.name, whole_name, w.order, w.turn,
            job.bar,
        )  # fmt: skip

    return by_told_bar(rest, job, verify)


def what_has_to_be_true(plan: Plan, first: int, machine: Machine) -> Iterator[str]:
    """Conditions for the operator to check before starting the remainder, line by line."""
    done, left = plan.operations[: first - 1], plan.operations[first - 1 :]
    last = done[-1]
    yield f"REST FROM OPERATION {first} OF {len(plan.operations)}. START ONLY IF ALL THIS IS TRUE:"
    yield f"- OPERATIONS 1 TO {first - 1} ARE DONE, THE LAST ONE AT X {last.x:.3f}: {_called(last)}"
    if machine.saw is not None:
        off = [plan.pieces[p].part.mark for p in _parted_off(plan, left)]
        yield f"- PARTED OFF: {', '.join(off) if off else 'NOTHING YET'}"
    yield f"- THE BAR IS CLAMPED AS IT WAS AND STANDS AT X {last.x:.3f} BY THE SAME REFERENCE"
    yield "- ALL TOOLS ARE DRAWN BACK, SPINDLES AND COOLANT ARE OFF"
    held: dict[tuple[str, int], str] = {}
    for load in tool_loads(plan.operations, machine):
        if load.out is None or load.before < first - 1:
            held[load.spindle, load.station] = load.tool.name
    for (spindle, station), tool in sorted(held.items()):
        yield f"- {spindle} STATION {station} HOLDS {tool}"


def _called(operation: Operation) -> str:
    if isinstance(operation, SawOp):
        return f"SAW CUT AT {operation.angle:g} DEG"
    return f"{operation.tool.name} ON FACE {' AND '.join(operation.faces)}"


def _parted_off(plan: Plan, left: Sequence[Operation]) -> list[int]:
    """The pieces whose ends are cut."""
    to_cut = {op.pieces[0] for op in left if isinstance(op, SawOp) and op.at == "end"}
    return [p for p in range(len(plan.pieces)) if p not in to_cut]


def frame_of(posted: Posted) -> Posted:
    """The frame of a program that was posted for a sheet, read back beside it.

    Raises RefusedProgram if it would switch the tool on, or go elsewhere than round the work.
    """
    plan, whole, machine = posted.plan, posted.program, posted.job.machine
    if not isinstance(plan, SheetPlan) or not isinstance(whole, Program):
        raise TypeError(f"{machine.name} writes no program of contours")
    torch = machine.needed(machine.torch, "torch")
    x0, y0, x1, y1 = worked_box(plan.operations, torch.overscan)
    head = [c for c in whole.commands if isinstance(c, Comment)]
    corners = ((x1, y0), (x1, y1), (x0, y1), (x0, y0))
    feed, power = torch.frame_mm_min, torch.frame_power
    shown = ToolOn("cut", feed, power, 0.0, plan.pieces[0].part.source)
    program = replace(
        whole,
        commands=(
            StartSheet(plan.thickness), *head, Comment(said_of(torch)), Traverse(x0, y0),
            shown if power else SetFeed(feed), *(Feed(x, y) for x, y in corners),
            *([ToolOff("cut")] if power else []),
        ),
    )  # fmt: skip
    text = cutting.emit(program, machine)
    wrong = frame_faults(text, posted.text, machine, posted.job.request.name)
    if errors_in(wrong):
        raise RefusedProgram(wrong, text)
    return replace(posted, written=text, program=program, remarks=())
