"""Stages of each kind of machine: planner, motion, emitter and read-back.

`post_of` gives the row of a machine. Its functions load what they need when they are called, so
that a bar never loads what only a sheet needs.
"""

from collections.abc import Callable, Iterable, Iterator, Sequence
from functools import partial
from typing import Any

from msgspec import Struct
from msgspec.structs import replace

from beamcam.caches import cached
from beamcam.errors import Diagnostic, PlanError
from beamcam.machine.machine import Machine
from beamcam.machine.torch import Torch
from beamcam.model.part import Part
from beamcam.model.plan import Order, Plan, SheetPlan
from beamcam.model.program import Comment, Program
from beamcam.model.work_time import WorkTime
from beamcam.plain_text import one_word

NOT_READ_BACK = "NOT VERIFIED: THIS PROGRAM WAS NOT READ BACK"
FORM = 1  #: of a program and its head; a change that a reader has to know of counts it up
KINDS_A_LINE = 4  #: of those that may be left out, so that no comment is too long for a controller

#: A program as it is written: its text, or bytes piece by piece where it may be of any length.
Written = str | Callable[[], Iterable[bytes]]


class Job(Struct, frozen=True):
    """A job: parts, machine and options."""

    parts: tuple[Part, ...]
    machine: Machine
    name: str = "JOB"
    bar: float | None = None
    skips: tuple[str, ...] = ()  #: names of `--allow-skips`
    order: Order = "given"
    turn: bool = False
    style: str | None = None  #: "chain" or "table" of triggers; the suffix of a step table
    date: str = ""  #: for words of the machine; only where it is asked for


class Request(Struct, frozen=True):
    """The requirements of a program; nothing in it comes from a plan."""

    parts: tuple[Part, ...]  #: as they were given, in the order given
    machine: Machine
    skips: tuple[str, ...] = ()  #: kinds of features that may be missing, as `--allow-skips` names
    name: str = "program"  #: of the program, for messages
    order: Order = "given"  #: of the parts on the bar; "best" is any
    turn: bool = False  #: whether parts may lie turned
    bar: float | None = None  #: length of the bar, where it is known
    style: str | None = None


class Post(Struct, frozen=True):
    """Functions that make and read back the programs of a kind of machine."""

    plan: Callable[[Job], Plan | SheetPlan]
    motion: Callable[[Any, Machine, str], Any]
    emit: Callable[[Any, Job], Written]
    verify: Callable[[Written, Request], tuple[Diagnostic, ...]]
    with_head: Callable[[Any, Sequence[str]], Any]  #: the program with these remarks first
    time: Callable[[Any, Any, Machine], WorkTime]  #: of a plan and its program, where it is asked


def post_of(machine: Machine) -> Post:
    """The row of a machine."""
    return _row(machine.stock, machine.controller)


@cached("machine.post")
def _row(stock: str, controller: str) -> Post:
    return POSTS[stock, controller]()


def bar_post() -> Post:
    """Of a saw and drilling line."""
    from beamcam.emitters import gcode
    from beamcam.motion.beam import beam_program
    from beamcam.planning.orientation import plan_oriented
    from beamcam.verify.bars import verify

    def plan(job: Job) -> Plan:
        return plan_oriented(job.parts, job.machine, job.bar, job.skips, job.order, job.turn)

    def read_back(program: Written, request: Request) -> tuple[Diagnostic, ...]:
        w = request
        return verify(_text(program), w.parts, w.machine, w.skips, w.name, w.order, w.turn, w.bar)

    def emit(program: Program, job: Job) -> str:
        return gcode.emit(program, job.machine)

    def time(plan: Plan, _: Program, machine: Machine) -> WorkTime:
        from beamcam.planning.times import work_time

        return work_time(plan, machine)

    return Post(plan, beam_program, emit, read_back, _with_comments, time)


def sheet_post() -> Post:
    """Of a torch or laser that runs G-code."""
    from beamcam.emitters import cutting
    from beamcam.motion.sheet import sheet_program
    from beamcam.verify.sheets import verify_sheet

    def read_back(program: Written, request: Request) -> tuple[Diagnostic, ...]:
        w = request
        return verify_sheet(_text(program), _laid(w.parts, w.machine), w.machine, w.skips, w.name)

    def emit(program: Program, job: Job) -> str:
        return cutting.emit(program, job.machine)

    def time(plan: SheetPlan, program: Program, machine: Machine) -> WorkTime:
        from beamcam.motion.sheet_times import program_time

        return program_time(plan, program, machine)

    return Post(_plan_sheet, sheet_program, emit, read_back, _with_comments, time)


def trigger_post() -> Post:
    """Of a table run by triggers in Structured Text."""
    from beamcam.emitters import simotion
    from beamcam.motion.triggers import trigger_table
    from beamcam.planning.contours.rules import CHAIN
    from beamcam.verify.st import verify_triggers

    def emit(program: Any, job: Job) -> str:
        try:
            return simotion.emit(program, job.machine, job.style)
        except simotion.ChainError as error:
            said = CHAIN.at(job.parts[0].source, found=error.found, expected=error.expected)
            raise PlanError(said) from error

    def read_back(program: Written, request: Request) -> tuple[Diagnostic, ...]:
        w = request
        return verify_triggers(
            _text(program), _laid(w.parts, w.machine), w.machine, w.skips, w.name
        )

    def time(plan: SheetPlan, table: Any, machine: Machine) -> WorkTime:
        from beamcam.motion.table_times import trigger_time

        return trigger_time(plan, table, machine)

    return Post(_plan_sheet, trigger_table, emit, read_back, _with_remarks, time)


def step_post() -> Post:
    """Of a table whose motors are run step by step; its style is the suffix of the file."""
    from beamcam.emitters.step_table import FORMS
    from beamcam.motion.steps import step_table
    from beamcam.verify.steps import FORMS as READ_BACK
    from beamcam.verify.steps import verify_table

    def emit(program: Any, job: Job) -> Written:
        form = FORMS[job.style or job.machine.suffix]
        return partial(form, program)  # which can be pickled

    def read_back(program: Written, request: Request) -> tuple[Diagnostic, ...]:
        w = request
        form = w.style if w.style in READ_BACK else w.machine.suffix
        pieces = (program.encode("utf-8"),) if isinstance(program, str) else program()
        return verify_table(form, pieces, _laid(w.parts, w.machine), w.machine, w.skips, w.name)

    def time(plan: SheetPlan, _: Any, machine: Machine) -> WorkTime:
        from beamcam.motion.table_times import step_time

        return step_time(plan, machine)

    return Post(_plan_sheet, step_table, emit, read_back, _with_remarks, time)


#: By the kind of stock and the family of the controller.
POSTS = {
    ("beam", "codesys"): bar_post,
    ("beam", "linuxcnc"): bar_post,
    ("sheet", "codesys"): sheet_post,
    ("sheet", "linuxcnc"): sheet_post,
    ("sheet", "grbl"): sheet_post,
    ("sheet", "simotion"): trigger_post,
    ("sheet", "stepper"): step_post,
}


def _plan_sheet(job: Job) -> SheetPlan:
    from beamcam.planning.sheet import plan_sheet

    return plan_sheet(_laid(job.parts, job.machine), job.machine, job.skips)


def _laid(parts: tuple[Part, ...], machine: Machine) -> tuple[Part, ...]:
    """Parts of a sheet as the job wants them: laid out, and hatched. Raises PlanError."""
    from beamcam.model.hatch import hatched, not_filled
    from beamcam.model.sheet_layout import is_laid_otherwise

    torch = machine.torch
    if torch is None or not (torch.settings or is_laid_otherwise(torch)):
        return parts
    from beamcam.planning.contours.rules import HATCH

    if is_laid_otherwise(torch):
        parts = _laid_out(parts, torch)
    said = [
        HATCH.at(part.source, key=key, found=what)
        for part in parts
        for key, what in not_filled(part, torch)
    ]
    if said:
        raise PlanError(said)
    return tuple([hatched(part, torch) for part in parts])


def _laid_out(parts: tuple[Part, ...], torch: Torch) -> tuple[Part, ...]:
    """Parts mirrored, turned and copied. Raises PlanError."""
    from beamcam.model.sheet_layout import cannot_lie, laid_out, size_of
    from beamcam.planning.contours.rules import LAYOUT, SHEET_SIZE

    said = [
        LAYOUT.at(source, found=what) for part in parts for source, what in cannot_lie(part, torch)
    ]
    for part in () if said else parts:
        length, width = size_of(part, torch)
        if length > torch.length + torch.gap or width > torch.width + torch.gap:
            found, expected = f"{length:.1f} x {width:.1f}", f"{torch.length:g} x {torch.width:g}"
            said.append(SHEET_SIZE.at(part.source, found=found, expected=expected))
    if said:
        raise PlanError(said)
    return tuple([laid_out(part, torch) for part in parts])


def head_lines(job: Job, verified: bool, by_hand: int = 0) -> Iterator[str]:
    """Head of every program: how it was made, and what may be missing in it.

    `by_hand` marks are left for manual work.
    """
    yield f"BEAMCAM {FORM} MACHINE {one_word(job.machine.name)} {job.machine.checksum}".rstrip()
    kinds = sorted(job.skips)
    for at in range(0, len(kinds), KINDS_A_LINE):
        yield f"ALLOWED TO BE LEFT OUT: {', '.join(kinds[at : at + KINDS_A_LINE])}"
    if by_hand:
        yield f"LEFT TO THE HAND: {by_hand}"
    if not verified:
        yield NOT_READ_BACK


def carries_head(job: Job) -> bool:
    """Whether the form of a program has a place for remarks; a binary table has none."""
    return job.machine.controller != "stepper" or (job.style or job.machine.suffix) != ".bin"


def _with_comments(program: Program, lines: Sequence[str]) -> Program:
    start, *work = program.commands
    return replace(program, commands=(start, *map(Comment, lines), *work))


def _with_remarks(program: Any, lines: Sequence[str]) -> Any:
    return replace(program, remarks=(*lines, *program.remarks))


def _text(program: Written) -> str:
    """A program as text; each byte that is not text becomes `\\ufffd`."""
    return program if isinstance(program, str) else b"".join(program()).decode("utf-8", "replace")
