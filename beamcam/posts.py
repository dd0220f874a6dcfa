"""Stages of each kind of machine (planner, motion, emitter, read-back), and what the read-back has
to find as planned.

`post_of` gives the row of a machine. Its functions load what they need when they are called, so
that a bar never loads what only a sheet needs.
"""

from collections import Counter
from collections.abc import Callable, Iterable, Iterator, Sequence
from functools import partial
from typing import Any

from msgspec import Struct
from msgspec.structs import replace

from beamcam.caches import cached
from beamcam.checks.job import HEAD_TEXT, head_faults, head_of
from beamcam.checks.rules import BAR_NEEDED, BAR_TOLD, LEDGER, UNCUT, UNCUT_TOLD
from beamcam.checks.rules import LEFT_OUT as MISSING
from beamcam.checks.rules import MANUAL_WORK as FOR_MANUAL_WORK
from beamcam.checks.rules import TEXT_MOVED as MOVED
from beamcam.errors import Diagnostic, PlanError, Severity, Source, errors_in
from beamcam.machine.machine import Machine
from beamcam.model.plan import (
    AnyPlan,
    CopePlan,
    Plan,
    SheetPlan,
    WorkTime,
    left_out_sources,
    manual_work_sources,
)
from beamcam.model.program import Comment, Program, ToolOff, ToolOn
from beamcam.model.request import Job
from beamcam.planning.left_out import TEXT_MOVED
from beamcam.reconcile import other_places, stand_ins

#: A program as it is written: its text, or bytes piece by piece where it may be of any length.
Written = str | Callable[[], Iterable[bytes]]


class Post(Struct, frozen=True):
    """Functions that make and read back the programs of a kind of machine."""

    plan: Callable[[Job], AnyPlan]
    motion: Callable[[Any, Machine, str], Any]
    emit: Callable[[Any, Job], Written]
    verify: Callable[[Written, Job], tuple[Diagnostic, ...]]
    with_head: Callable[[Any, Sequence[str]], Any]  #: the program with these remarks first
    time: Callable[[Any, Any, Machine], WorkTime]  #: of a plan and its program, where it is asked


def post_of(machine: Machine) -> Post:
    """The row of a machine."""
    return _row(machine.stock, machine.controller)


def plan_seconds(plan: AnyPlan, job: Job) -> float:
    """How long the machine of a job works by a plan, s. Raises PlanError as `motion` does."""
    kind = post_of(job.machine)
    program = kind.motion(plan, job.machine, job.request.name)
    return kind.time(plan, program, job.machine).total_s


@cached("machine.post")
def _row(stock: str, controller: str) -> Post:
    return POSTS[stock, controller]()


def bar_post() -> Post:
    """Of a saw and drilling line."""
    from beamcam.checks.bars import unseen_faults, verify
    from beamcam.emitters import gcode
    from beamcam.motion.beam import beam_program
    from beamcam.planning.beam import plan_oriented
    from beamcam.planning.operations.work import round_remarks

    def plan(job: Job) -> Plan:
        w = job.request
        _refuse_begun(job)
        given = [w.parts[place] for place in dict.fromkeys(job.pieces)]
        remarks = tuple(one for part in given for one in round_remarks(part, w.machine, w.skips))
        if errors_in(remarks):
            raise PlanError(remarks)
        plan = plan_oriented(job.parts, w.machine, job.bar, w.skips, w.order, w.turn)
        return replace(plan, remarks=(*remarks, *plan.remarks)) if remarks else plan

    def read_back(program: Written, job: Job) -> tuple[Diagnostic, ...]:
        w = job.request
        given = [w.parts[place] for place in dict.fromkeys(job.pieces)]
        faults = () if "cutout" in w.skips else unseen_faults(given, w.machine)
        return faults or verify(
            _text(program), job.parts, w.machine, w.skips, w.name, w.order, w.turn, job.bar
        )

    def time(plan: Plan, _: Program, machine: Machine) -> WorkTime:
        from beamcam.planning.times import work_time

        return work_time(plan, machine)

    return Post(plan, beam_program, _by_machine(gcode), read_back, _with_comments, time)


def sheet_post() -> Post:
    """Of a torch or laser that runs G-code."""
    from beamcam.checks.sheets.compare import verify_sheet
    from beamcam.emitters import cutting
    from beamcam.motion.sheet import sheet_program

    def time(plan: SheetPlan, program: Program, machine: Machine) -> WorkTime:
        from beamcam.motion.sheet_times import program_time

        lifts = machine.torch is not None and machine.torch.z == "program"
        return program_time(plan, program, machine, _standing(machine) if lifts else None)

    emit, read_back = _by_machine(cutting), partial(_read_text_back, verify_sheet)
    return Post(_plan_sheet, sheet_program, emit, read_back, _with_comments, time)


def _by_machine(emitter: Any) -> Callable[[Any, Job], Written]:
    return lambda program, job: emitter.emit(program, job.machine)


def _standing(machine: Machine) -> Callable[[ToolOn], float]:
    """How long the head stands while a tool is started and stopped, its torch moved in Z."""
    from beamcam.controllers import table_events
    from beamcam.emitters import cutting
    from beamcam.motion.sheet_times import standing_seconds

    bare = replace(machine, words=replace(machine.words, footer=()))
    known: dict[ToolOn, float] = {}

    def seconds(start: ToolOn) -> float:
        alike = replace(start, source=Source(machine.name))
        if alike not in known:
            text = cutting.emit(Program("", (start, ToolOff(start.process))), bare)
            known[alike] = standing_seconds(table_events(text, machine)[0], machine)
        return known[alike]

    return seconds


def trigger_post() -> Post:
    """Of a table run by triggers in Structured Text."""
    from beamcam.checks.st import verify_triggers
    from beamcam.emitters import simotion
    from beamcam.motion.triggers import trigger_table, trigger_time
    from beamcam.planning.contours.rules import CHAIN

    def emit(program: Any, job: Job) -> str:
        try:
            return simotion.emit(program, job.machine, job.request.style)
        except simotion.ChainError as error:
            diagnostic = CHAIN.at(job.parts[0].source, found=error.found, expected=error.expected)
            raise PlanError(diagnostic) from error

    read_back = partial(_read_text_back, verify_triggers)
    return Post(_plan_sheet, trigger_table, emit, read_back, _with_remarks, trigger_time)


def step_post() -> Post:
    """Of a table whose motors are run step by step; its style is the suffix of the file."""
    from beamcam.checks.steps import FORMS as READ_BACK
    from beamcam.checks.steps import verify_table
    from beamcam.emitters.step_table import FORMS
    from beamcam.motion.steps import step_table, step_time

    def emit(program: Any, job: Job) -> Written:
        form = FORMS[job.request.style or job.machine.suffix]
        return partial(form, program)  # which can be pickled

    def read_back(program: Written, job: Job) -> tuple[Diagnostic, ...]:
        style = job.request.style
        form = style if style in READ_BACK else job.machine.suffix
        return _of_asked(partial(verify_table, form), job, bytes_of(program), beginning(program))

    return Post(
        _plan_sheet, step_table, emit, read_back, _with_remarks,
        lambda plan, _, machine: step_time(plan, machine),
    )  # fmt: skip


def coping_post() -> Post:
    """Of a torch that goes round a profile."""
    from beamcam.checks.coping import verify_coping
    from beamcam.emitters import coping
    from beamcam.motion.coping import coping_program, coping_time
    from beamcam.planning.coping.plan import plan_coping

    def plan(job: Job) -> CopePlan:
        _refuse_begun(job)
        return plan_coping(job.parts, job.machine, job.bar, job.request.skips)

    def read_back(program: Written, job: Job) -> tuple[Diagnostic, ...]:
        w = job.request
        return verify_coping(_text(program), job.parts, w.machine, w.skips, w.name)

    emit = _by_machine(coping)
    return Post(plan, coping_program, emit, read_back, _with_comments, coping_time)


class Planned(Struct, frozen=True):
    """One program of a request as it is planned."""

    job: Job
    plan: AnyPlan


#: By the kind of stock and the family of the controller.
POSTS = {
    ("beam", "codesys"): bar_post, ("beam", "linuxcnc"): bar_post,
    ("sheet", "codesys"): sheet_post, ("sheet", "linuxcnc"): sheet_post,
    ("sheet", "grbl"): sheet_post, ("sheet", "mach3"): sheet_post,
    ("sheet", "simotion"): trigger_post, ("sheet", "plcopen"): trigger_post,
    ("sheet", "stepper"): step_post, ("profile", "linuxcnc"): coping_post,
}  # fmt: skip


def _refuse_begun(job: Job) -> None:
    """Raise PlanError for a part that another machine has begun, where whole ones are taken."""
    if any(part.made is not None for part in job.parts):
        from beamcam.planning.begun import refuse_begun

        refused = tuple(refuse_begun(job.parts, job.machine))
        if refused:
            raise PlanError(refused)


def _plan_sheet(job: Job) -> SheetPlan:
    from beamcam.planning.contours.plate import laid
    from beamcam.planning.contours.plate_edges import with_bevels
    from beamcam.planning.sheet import plan_sheet

    machine = job.machine
    _refuse_begun(job)
    parts, notes = laid(with_bevels(job.parts, machine.torch), machine.torch)
    plan = plan_sheet(parts, machine, job.request.skips)
    return replace(plan, remarks=(*notes, *plan.remarks)) if notes else plan


def _of_asked(
    verify: Callable[..., tuple[Diagnostic, ...]], job: Job, program: object, begin: str
) -> tuple[Diagnostic, ...]:
    """What a check of sheets says of a program, by the parts as they were asked to lie.

    `begin` is the text that the program begins with.
    """
    from beamcam.checks.sheets.required_layout import laid_out

    parts, diagnostics = laid_out(job.parts, job.machine.torch)
    if diagnostics:
        return tuple(diagnostics)
    w = job.request
    head = begin if carries_head(job) else ""
    return verify(program, parts, job.machine, w.skips, w.name, head)


def _read_text_back(
    verify: Callable[..., tuple[Diagnostic, ...]], program: Written, job: Job
) -> tuple[Diagnostic, ...]:
    return _of_asked(verify, job, _text(program), _text(program))


def carries_head(job: Job) -> bool:
    """Whether the form of a program has a place for remarks; a binary table has none."""
    form = job.request.style or job.machine.suffix
    return job.machine.controller != "stepper" or form != ".bin"


def bytes_of(written: Written) -> Iterable[bytes]:
    """The bytes of a program, piece by piece."""
    return (written.encode(),) if isinstance(written, str) else written()


def beginning(program: Written) -> str:
    """The text of a program; of one that comes piece by piece its first piece."""
    if isinstance(program, str):
        return program
    return next(iter(program()), b"").decode("latin-1")


def _with_comments(program: Program, lines: Sequence[str]) -> Program:
    start, *work = program.commands
    return replace(program, commands=(start, *map(Comment, lines), *work))


def _with_remarks(program: Any, lines: Sequence[str]) -> Any:
    return replace(program, remarks=(*lines, *program.remarks))


def _text(program: Written) -> str:
    """A program as text; each byte that is not text becomes `\\ufffd`."""
    return program if isinstance(program, str) else b"".join(program()).decode("utf-8", "replace")


# --- beside the plan ------------------------------------------------------------------------------

# What the read-back found, beside what the plan and the job say.
#
# What is left out, moved or for manual work has to be the same in both.


TOLD_BAR = 0.001  #: mm that lengths of bars in messages are rounded to


def other_than_planned(
    plan: AnyPlan, diagnostics: Iterable[Diagnostic], job: Job
) -> Iterator[Diagnostic]:
    """What the read-back found; what is not made only where the plan says otherwise.

    The features that it found missing, and that may be, are those that the plan left out by name;
    the marks that it found to be manual work are those on the plan's list; the contours with waste
    that no beam reaches are those that the plan reports; the bar that it needs where none gave
    its length is no longer than the plan's.
    """
    missing: list[tuple[str, Source]] = []
    refused = False
    moved: list[Diagnostic] = []
    for diagnostic in diagnostics:
        if diagnostic.code in (MISSING.code, FOR_MANUAL_WORK.code):
            missing.append((diagnostic.code, diagnostic.source))
        elif diagnostic.code == MOVED.code:
            moved.append(diagnostic)
        elif diagnostic.code == UNCUT.code:  # waste that stays in a corner of a contour
            from beamcam.planning.contours.rules import LEFT

            reported = [d for d in plan.remarks if d.code == LEFT.code]
            at = diagnostic["x"], diagnostic["y"]
            if not any(d.source == diagnostic.source or (d["x"], d["y"]) == at for d in reported):
                yield UNCUT_TOLD.at(diagnostic.source, **dict(diagnostic.values))
        elif diagnostic.code == HEAD_TEXT.code:  # which was written for these very parts
            refused = True
            yield replace(diagnostic, severity=Severity.ERROR)
        elif diagnostic.code == BAR_NEEDED.code and isinstance(plan, Plan):
            tolerance = job.machine.format.resolution + TOLD_BAR
            if float(diagnostic["found"]) > plan.bar.length + tolerance:
                expected = f"{plan.bar.length:.3f}"
                yield BAR_TOLD.at(diagnostic.source, found=diagnostic["found"], expected=expected)
        else:
            refused = refused or diagnostic.severity is Severity.ERROR
            yield diagnostic
    if refused:  # what is missing may not have been looked for
        return
    hand = [*manual_work_sources(plan)]
    remarks = [diagnostic for diagnostic in plan.remarks if diagnostic.code == TEXT_MOVED.code]
    named = [(MISSING.code, source) for source in left_out_sources(plan)]
    named += [(FOR_MANUAL_WORK.code, source) for source in hand]
    if not (remarks or moved or missing or named):  # as of nearly every plan
        return
    alike = stand_ins(job.parts)
    yield from other_places(remarks, moved, alike, hand)
    missed, planned = (  # each text by the first of those that are alike
        Counter((code, alike.get(source, source)) for code, source in of) for of in (missing, named)
    )
    for one in (missed - planned) + (planned - missed):
        yield LEDGER.at(one[1], found=missed[one], expected=planned[one])


def head_differences(
    job: Job, plan: AnyPlan, written: Written, diagnostics: Sequence[Diagnostic]
) -> Iterable[Diagnostic]:
    """Differences of a program's head from the job and from what its read-back said."""
    if not carries_head(job):
        return ()
    bar = plan.bar.length if isinstance(plan, Plan) and job.machine.saw is not None else None
    missing, manual_work = (
        sum(one.code == of.code for one in diagnostics) for of in (MISSING, FOR_MANUAL_WORK)
    )
    return head_faults(head_of(beginning(written)), job, bar, missing, manual_work)
