"""The rest of a sheet's program after a stop: from the pierce of one of its contours to the end.

What is cut stays cut and marks are made already, so that nothing before that contour is in it.
"""

from collections.abc import Iterator

from msgspec.structs import replace

from beamcam.checks.sheets.remainder import SAID, rest_faults
from beamcam.emitters import cutting
from beamcam.errors import Diagnostic, PlanError, error, errors_in
from beamcam.model.plan import SheetPlan
from beamcam.model.program import Comment, Program
from beamcam.model.request import Job
from beamcam.motion.sheet import sheet_program
from beamcam.pipeline import Posted, RefusedProgram
from beamcam.posts import post_of

CONTOUR = error("plan-contour",
    "found contour {found} to begin with; expected the number of a contour to cut from 2 to "
    "{expected}, as `beamcam plan` counts",
    "Contour 1 begins the whole program, and marks are made before the first cut.")  # fmt: skip
LINKED = error("plan-contour-linked",
    "found contour {found}, which the torch goes on to from the one before; expected {expected}, "
    "where it pierces",
    "A chain of parts is cut in one go, and begins with its first part.")  # fmt: skip
RULES = (CONTOUR, LINKED)


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
    notes = map(Comment, what_has_to_be_true(plan, first))
    rest = replace(rest, about=whole.about, commands=(start, *head, *notes, *work))
    text = cutting.emit(rest, job.machine)
    wrong = faults_of_sheet_rest(text, posted.text, first, job)
    if errors_in(wrong):
        raise RefusedProgram(wrong, text)
    return replace(posted, written=text)


def faults_of_sheet_rest(
    rest: str, whole: str, first: int, job: Job, whole_name: str = "whole program"
) -> tuple[Diagnostic, ...]:
    """Everything that is wrong with the rest of a whole program from contour `first` on.

    The whole has to make the parts, and the rest its strokes from that contour on.
    """
    request = job.request
    named = replace(job, request=replace(request, name=whole_name))
    said = post_of(job.machine).verify(whole, named)
    if errors_in(said):
        return said
    return rest_faults(
        whole, rest, first, job.parts, job.machine, request.skips, request.name, whole_name
    )


def what_has_to_be_true(plan: SheetPlan, first: int) -> Iterator[str]:
    """Conditions for the operator to check before starting the rest, line by line."""
    done, left = plan.operations[: first - 1], plan.operations[first - 1 :]
    (x, y), (x0, y0) = left[0].start, done[-1].end
    yield SAID.format(first=first, count=len(plan.operations)) + " START ONLY IF ALL THIS IS TRUE:"
    yield f"- CONTOURS 1 TO {first - 1} ARE DONE, THE LAST ONE UP TO X {x0:.3f} Y {y0:.3f}"
    marks = sum(op.row.process != "cut" for op in done)
    if marks:
        yield f"- {marks} OF THEM ARE MARKS AND ARE NOT MADE AGAIN"
    open_pieces = {piece for op in left for piece, _ in op.features}
    free = [p.part.mark for k, p in enumerate(plan.pieces) if k not in open_pieces]
    yield f"- FREE OF THE SHEET: {', '.join(free) if free else 'NO PART YET'}"
    yield "- THE SHEET LIES AS IT LAY, AND X 0 Y 0 IS WHERE IT WAS"
    yield f"- THE TORCH IS OFF AND PIERCES FIRST AT X {x:.3f} Y {y:.3f}"
