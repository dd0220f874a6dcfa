"""The frame of a job: a program that leads the head round all of its work with the tool off.

A laser may show its spot, at a power that marks nothing (`torch.frame_power`).

3 ------------- 2
|  o   ____     |     Run before the job: the operator sees whether the sheet lies
|     |    |    |     under it, and whether a clamp is in the way.
0 ------------- 1
"""

from msgspec.structs import replace

from beamcam.emitters import cutting
from beamcam.errors import errors_in
from beamcam.model.plan import SheetPlan
from beamcam.model.program import (
    Comment,
    Feed,
    Pace,
    Program,
    StartSheet,
    ToolOff,
    ToolOn,
    Traverse,
)
from beamcam.pipeline import Posted, RefusedProgram
from beamcam.planning.contours.place import worked_box
from beamcam.verify.sheets.remainder import frame_faults, said_of


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
            shown if power else Pace(feed), *(Feed(x, y) for x, y in corners),
            *([ToolOff("cut")] if power else []),
        ),
    )  # fmt: skip
    text = cutting.emit(program, machine)
    wrong = frame_faults(text, posted.text, machine, posted.job.request.name)
    if errors_in(wrong):
        raise RefusedProgram(wrong, text)
    return replace(posted, written=text, program=program, remarks=())
