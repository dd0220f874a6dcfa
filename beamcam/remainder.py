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

from collections.abc import Iterator

from msgspec.structs import replace

from beamcam.checks.bars.remainder import verify_remainder
from beamcam.checks.sheets.remainder import COMMENT, frame_comment, frame_faults, rest_faults
from beamcam.emitters import cutting, gcode
from beamcam.errors import Diagnostic, PlanError, error, errors_in
from beamcam.machine.machine import Machine
from beamcam.model.plan import Plan, SawOp, SheetPlan
from beamcam.model.program import (
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
from beamcam.motion.sheet import sheet_program
from beamcam.pipeline import Posted, RefusedProgram, by_bar_of_head
from beamcam.planning.contours.plate import worked_box
from beamcam.planning.order import tool_loads
from beamcam.posts import post_of

OPERATION = error("plan-operation",
    "found operation {found} to begin with; expected 2 to {expected}, as `beamcam plan` counts",
    "Operation 1 begins the whole program.")  # fmt: skip
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
    commands = whole.commands
    work = [k for k, command in enumerate(commands) if isinstance(command, _WORK)]
    begin = next(k for k, c in enumerate(commands) if not isinstance(c, StartBar | Comment))
    notes = map(Comment, what_has_to_be_true(plan, first, machine))
    commands = (*commands[:begin], *notes, *commands[work[first - 2] + 1 :])
    text = gcode.emit(replace(whole, commands=commands), machine)
    job = replace(job, bar=plan.bar.length)
    return _checked(posted, text, faults_of(text, posted.text, first, job))


def _checked(posted: Posted, text: str, faults: tuple[Diagnostic, ...]) -> Posted:
    """The text as a program that was posted. Raises RefusedProgram."""
    if errors_in(faults):
        raise RefusedProgram(faults, text)
    return replace(posted, written=text)


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

    return by_bar_of_head(rest, job, verify)


def what_has_to_be_true(plan: Plan, first: int, machine: Machine) -> Iterator[str]:
    """Conditions for the operator to check before starting the remainder, line by line."""
    done, left = plan.operations[: first - 1], plan.operations[first - 1 :]
    last = done[-1]
    if isinstance(last, SawOp):
        called = f"SAW CUT AT {last.angle:g} DEG"
    else:
        called = f"{last.tool.name} ON FACE {' AND '.join(last.faces)}"
    yield f"REST FROM OPERATION {first} OF {len(plan.operations)}. START ONLY IF ALL THIS IS TRUE:"
    yield f"- OPERATIONS 1 TO {first - 1} ARE DONE, THE LAST ONE AT X {last.x:.3f}: {called}"
    if machine.saw is not None:
        to_cut = {op.pieces[0] for op in left if isinstance(op, SawOp) and op.at == "end"}
        off = [piece.part.mark for p, piece in enumerate(plan.pieces) if p not in to_cut]
        yield f"- PARTED OFF: {', '.join(off) if off else 'NOTHING YET'}"
    yield f"- THE BAR IS CLAMPED AS IT WAS AND STANDS AT X {last.x:.3f} BY THE SAME REFERENCE"
    yield "- ALL TOOLS ARE DRAWN BACK, SPINDLES AND COOLANT ARE OFF"
    held: dict[tuple[str, int], str] = {}
    for load in tool_loads(plan.operations, machine):
        if load.out is None or load.before < first - 1:
            held[load.spindle, load.station] = load.tool.name
    for (spindle, station), tool in sorted(held.items()):
        yield f"- {spindle} STATION {station} HOLDS {tool}"


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
            StartSheet(plan.thickness), *head, Comment(frame_comment(torch)), Traverse(x0, y0),
            shown if power else SetFeed(feed), *(Feed(x, y) for x, y in corners),
            *([ToolOff("cut")] if power else []),
        ),
    )  # fmt: skip
    text = cutting.emit(program, machine)
    faults = frame_faults(text, posted.text, machine, posted.job.request.name)
    return _checked(replace(posted, program=program, remarks=()), text, faults)


# --- sheets ---------------------------------------------------------------------------------------

# The rest of a sheet's program after a stop: from the pierce of one of its contours to the end.
#
# What is cut stays cut and marks are made already, so that nothing before that contour is in it.

CONTOUR = error("plan-contour",
    "found contour {found} to begin with; expected the number of a contour to cut from 2 to "
    "{expected}, as `beamcam plan` counts",
    "Contour 1 begins the whole program, and marks are made before the first cut.")  # fmt: skip
LINKED = error("plan-contour-linked",
    "found contour {found}, which the torch goes on to from the one before; expected {expected}, "
    "where it pierces",
    "A chain of parts is cut in one go, and begins with its first part.")  # fmt: skip


def rest_of_sheet(posted: Posted, first: int) -> Posted:
    """The program from contour `first` on, of one that was posted for a sheet.

    Raises PlanError if there is no such contour to cut, RefusedProgram if the rest is not that of
    the whole program.
    """
    plan, whole, job = posted.plan, posted.program, posted.job
    if not isinstance(plan, SheetPlan) or not isinstance(whole, Program):
        raise TypeError(f"{job.machine.name} writes no program of contours")
    count = len(plan.operations)
    if not 2 <= first <= count or plan.operations[first - 1].row.process != "cut":
        raise PlanError(CONTOUR.at(job.parts[0].source, found=first, expected=count))
    if plan.operations[first - 1].is_linked:
        pierced = [k for k, op in enumerate(plan.operations[:first], 1) if not op.is_linked]
        raise PlanError(LINKED.at(job.parts[0].source, found=first, expected=pierced[-1]))
    left = replace(plan, operations=plan.operations[first - 1 :])
    rest = sheet_program(left, job.machine, job.request.name)
    start, *work = rest.commands
    head = [c for c in whole.commands[1:] if isinstance(c, Comment)]
    notes = map(Comment, sheet_conditions(plan, first))
    rest = replace(rest, about=whole.about, commands=(start, *head, *notes, *work))
    text = cutting.emit(rest, job.machine)
    return _checked(posted, text, faults_of_sheet_rest(text, posted.text, first, job))


def faults_of_sheet_rest(
    rest: str, whole: str, first: int, job: Job, whole_name: str = "whole program"
) -> tuple[Diagnostic, ...]:
    """Everything that is wrong with the rest of a whole program from contour `first` on.

    The whole has to make the parts, and the rest its strokes from that contour on.
    """
    request = job.request
    named = replace(job, request=replace(request, name=whole_name))
    diagnostics = post_of(job.machine).verify(whole, named)
    if errors_in(diagnostics):
        return diagnostics
    return rest_faults(
        whole, rest, first, job.parts, job.machine, request.skips, request.name, whole_name
    )


def sheet_conditions(plan: SheetPlan, first: int) -> Iterator[str]:
    """Conditions for the operator to check before starting the rest, line by line."""
    done, left = plan.operations[: first - 1], plan.operations[first - 1 :]
    (x, y), (x0, y0) = left[0].start, done[-1].end
    comment = COMMENT.format(first=first, count=len(plan.operations))
    yield f"{comment} START ONLY IF ALL THIS IS TRUE:"
    yield f"- CONTOURS 1 TO {first - 1} ARE DONE, THE LAST ONE UP TO X {x0:.3f} Y {y0:.3f}"
    marks = sum(op.row.process != "cut" for op in done)
    if marks:
        yield f"- {marks} OF THEM ARE MARKS AND ARE NOT MADE AGAIN"
    open_pieces = {piece for op in left for piece, _ in op.features}
    free = [p.part.mark for k, p in enumerate(plan.pieces) if k not in open_pieces]
    yield f"- FREE OF THE SHEET: {', '.join(free) if free else 'NO PART YET'}"
    yield "- THE SHEET LIES AS IT LAY, AND X 0 Y 0 IS WHERE IT WAS"
    yield f"- THE TORCH IS OFF AND PIERCES FIRST AT X {x:.3f} Y {y:.3f}"
