"""The architecture on one screen: how an input becomes a program.

    bytes -> readers -> Part -> planning -> Plan -> motion -> Program -> emitters -> text
                                                                     verify <- text

Which planner, motion step, emitter and read-back belong together stands in `posts`.
"""

from collections.abc import Callable, Collection, Generator, Iterable, Sequence
from functools import partial
from typing import Any

from msgspec import Struct
from msgspec.structs import replace

from beamcam.arguments import AnyMachine, check_arguments, machine_of
from beamcam.budget import check_pieces
from beamcam.checks.job import head_of, job_faults, other_bar, pieces_asked
from beamcam.checks.rules import BAR_NEEDED
from beamcam.emitters.gcode import head_lines
from beamcam.errors import Diagnostic, PlanError, ReadError, Severity, VerifyError, errors_in
from beamcam.machine.machine import Machine
from beamcam.model.part import Part
from beamcam.model.plan import (
    AnyPlan,
    Order,
    SheetPlan,
    WorkTime,
    left_out_kinds,
    manual_work_sources,
    named_skips,
    unfinished,
)
from beamcam.model.program import Program
from beamcam.model.request import Job, Request, Share, pieces_of
from beamcam.planning.left_out import LEFT_OUT, MANUAL_WORK, map_remarks, unfinished_remarks
from beamcam.planning.rules import is_too_short
from beamcam.posts import (
    Planned,
    Written,
    beginning,
    bytes_of,
    head_differences,
    other_than_planned,
    post_of,
)
from beamcam.readers import Reading, content, read, shown_name

Stage = Callable[[str], None]  #: callback with the finished stage


def untold(stage: str) -> None:
    """Default callback after a stage; does nothing."""


#: Rules for features that a program does not make, as allowed or as the machine file says.
NOT_MADE = (LEFT_OUT.code, MANUAL_WORK.code)


class Posted(Struct, frozen=True):
    """A program and how it came about."""

    written: Written
    plan: AnyPlan
    remarks: tuple[Diagnostic, ...]
    program: object  #: as it was printed: commands, or a table
    job: Job

    def time(self, machine: AnyMachine) -> WorkTime:
        """How long the machine takes for it: that of a name, of a file, or itself."""
        loaded = machine_of(machine)
        return post_of(loaded).time(self.plan, self.program, loaded)

    @property
    def text(self) -> str:
        """The whole program; of bytes that are not text, each as the letter of its number."""
        if isinstance(self.written, str):
            return self.written
        return b"".join(self.written()).decode("latin-1")

    def pieces(self) -> Iterable[bytes]:
        """Content of the file."""
        return bytes_of(self.written)


class StrictError(PlanError):
    """Warnings that the request does not allow; another machine or option is not looked for."""


class RefusedProgram(VerifyError):
    """A program that was read back and does not make the parts; it can be looked at."""

    def __init__(self, diagnostics: Iterable[Diagnostic], written: Written, name: str = "") -> None:
        super().__init__(diagnostics)
        self.written, self.name = written, name  #: name of the program where they speak of it

    def __reduce__(self) -> tuple[Any, ...]:
        return type(self), (self.diagnostics, self.written, self.name)

    def named(self, file: str) -> tuple[Diagnostic, ...]:
        """The diagnostics, those of the program with the file that it is kept in."""
        return tuple(
            replace(one, source=replace(one.source, file=file))
            if self.name and one.source.file == self.name else one for one in self.diagnostics
        )  # fmt: skip

    def pieces(self) -> Iterable[bytes]:
        """The program as it would have stood in the file."""
        return bytes_of(self.written)


def read_file(path: str, strict: bool = False, **options: object) -> Reading:
    """Content of a file, `-` for standard input; a file that cannot be opened is refused.

    `strict` makes its warnings errors. `options` go to a reader that takes them: units, width and
    layers of a drawing.
    """
    name, data = shown_name(path), content(path)
    if isinstance(data, Diagnostic):
        return Reading("unknown", (), (data,))
    return judged(read(data, name, **options), strict)


def judged(reading: Reading, strict: bool) -> Reading:
    """A reading, under `strict` with its warnings as errors."""
    if not strict:
        return reading
    return replace(reading, diagnostics=tuple(map(as_error, reading.diagnostics)))


def as_error(diagnostic: Diagnostic) -> Diagnostic:
    """A warning as an error; anything else as it is, also what the user or the machine allows."""
    if diagnostic.code in NOT_MADE:
        return diagnostic
    return (
        replace(diagnostic, severity=Severity.ERROR)
        if diagnostic.severity is Severity.WARNING
        else diagnostic
    )


def parts_of(
    readings: Iterable[Reading], parts_in: Callable[[Reading], Iterable[Part]] | None = None
) -> tuple[tuple[Part, ...], tuple[Diagnostic, ...]]:
    """All parts in order, and the remarks of their readers. Raises ReadError for any error.

    `parts_in` says what the parts of a reading are, where that is not just `parts`.
    """
    parts: list[Part] = []
    diagnostics: list[Diagnostic] = []
    for reading in readings:
        parts += reading.parts if parts_in is None else parts_in(reading)
        diagnostics += reading.diagnostics
    if errors_in(diagnostics):
        raise ReadError(diagnostics)
    return tuple(parts), tuple(diagnostics)


def counted(reading: Reading) -> Sequence[Part]:
    """The parts of a reading, equal members of a model as one with their number as quantity."""
    if reading.format != "ifc":
        return reading.parts
    from beamcam.comparison.parts import equal_parts

    return equal_parts(reading.parts)


def read_back(
    program: str | bytes, request: Request, bar: float | None = None
) -> tuple[Diagnostic, ...]:
    """All faults of a program for bars, sheets or tables, as its machine reads it.

    It has to make all parts of the request, each as often as it was asked for, from one bar of
    length `bar` (mm, where it is known) or one sheet. Where it is not, the program has to be right
    for any bar, and also for the one that its head names.
    """
    written: Written = program if isinstance(program, str) else lambda: (program,)
    verify = post_of(request.machine).verify
    return by_bar_of_head(beginning(written), whole_job(request, bar), partial(verify, written))


def by_bar_of_head(
    text: str, job: Job, verify: Callable[[Job], tuple[Diagnostic, ...]]
) -> tuple[Diagnostic, ...]:
    """What `verify` says of a program for a bar, which the head of its `text` may name.

    A head is no more than a text: it may add faults, and takes none away.
    """
    head = head_of(text) if job.machine.stock == "beam" and job.machine.saw is not None else None
    if head is None or head.bar is None:
        return verify(job)
    if job.bar is not None:
        return (*other_bar(head, job.bar, job.request.name), *verify(job))
    diagnostics = [one for one in verify(job) if one.code != BAR_NEEDED.code]
    return tuple(dict.fromkeys((*diagnostics, *verify(replace(job, bar=head.bar)))))


def whole_job(request: Request, bar: float | None = None) -> Job:
    """All that a request asks for as one program. Raises LimitError for too many pieces."""
    counts = pieces_asked(request)
    check_pieces((part.source, counts[place]) for place, part in enumerate(request.parts))
    return Job(request, tuple(counts.elements()), bar)


def post(
    parts: Sequence[Part], machine: Machine, job: str = "JOB", bar: float | None = None,
    skips: Collection[str] = (), verified: bool = True, order: Order = "given", turn: bool = False,
    strict: bool = False, style: str | None = None, date: str = "",
) -> Posted:  # fmt: skip
    """The program that makes `parts` from one bar or sheet, read back and compared with them.

    `style` is the form of program for a controller that knows several: "chain" or "table" of
    triggers; of step tables the suffix of the output. Unless `verified` a comment in the program
    says so. `date` is what `{date}` of the machine's words says. Raises PlanError if the machine
    cannot make the parts, or under `strict` if there is a warning; VerifyError if the program would
    make anything else.
    """
    check_arguments(job, bar, skips)  # before a text is taken for a list of letters
    request = Request(
        tuple(parts), machine, named_skips(skips), job, order, turn,
        () if bar is None else (bar,), style, None, strict, verified, date,
    )  # fmt: skip
    (begun,) = begin(request, together=True)
    return finished(begun)


class Begun(Planned, frozen=True):
    """A program that was planned, and the stages of its post behind the plan."""

    stages: Generator[str, None, Posted]


def shares_of(request: Request, together: bool = False) -> tuple[Share, ...]:
    """The share of each program, in the order given; `together` is one for all.

    Raises PlanError for a part that fits on no bar.
    """
    machine, pieces = request.machine, pieces_of(request)
    is_sheet = machine.torch is not None
    if together or (is_sheet and len(pieces) == 1) or (not is_sheet and request.quantity is None):
        return (Share(pieces, () if is_sheet else _in_store(request)),)
    if is_sheet:
        from beamcam.planning.sheet_rows import sheet_shares

        return tuple(map(Share, sheet_shares(request, pieces)))
    if machine.saw is None:
        bars = _in_store(request) if machine.stock == "profile" else ()
        return tuple(Share((place,), bars) for place in pieces)
    from beamcam.planning.stock import bar_shares

    return bar_shares(request, pieces)


def _in_store(request: Request) -> tuple[float, ...]:
    """The lengths of all bars that there are, rising."""
    return tuple(sorted({*request.stock, *request.remnants}))


def begin(request: Request, together: bool = False, stage: Stage = untold) -> list[Begun]:
    """The programs of a request, planned, each on the shortest bar in store that takes it.

    `together` lays all of it on one bar or sheet. `stage` is called with each step that is done.
    Raises PlanError where the machine cannot make it, of bars that are all too short for the
    longest; and VerifyError if the programs together are not what was asked for.
    """
    check_arguments(request.name, None, request.skips)
    shares = shares_of(request, together)
    begun = [
        begin_share(request, share, stage, (number, len(shares)))
        for number, share in enumerate(shares, 1)
    ]
    faults = job_faults(request, [one.job for one in begun])
    if faults:
        raise VerifyError(faults)
    return begun


def begin_share(
    request: Request, share: Share, stage: Stage = untold, program: tuple[int, int] = (1, 1)
) -> Begun:
    """The program of a share, planned on the shortest of its bars that takes it.

    `program` is its number, and of how many. Raises PlanError; where all bars are too short, for
    the longest.
    """
    longest_part = max((request.parts[place].length for place in share.pieces), default=0.0)
    *shorter, longest = share.lengths or (None,)  # without any a bar as long as the parts need
    for bar in (*(one for one in shorter if one is None or one >= longest_part), longest):
        job = Job(request, share.pieces, bar, *program)
        try:
            plan = post_of(job.machine).plan(job)  # which is all that a bar can be too short for
            break
        except PlanError as error:
            if bar == longest or not is_too_short(error.diagnostics):
                raise
    stage(f"planned {len(plan.operations)} operation(s)")
    return Begun(job, plan, posting(job, plan))


def plan_share(request: Request, share: Share) -> Planned:
    """The plan by which `begin` makes the program of a share. Raises PlanError as `begin` does."""
    begun = begin_share(request, share)
    remarks_on(begun.plan, begun.job.machine, request.strict)
    return begun


def plans_of(request: Request) -> list[Planned]:
    """The plans of all programs of a request, without the programs. Raises PlanError."""
    return [plan_share(request, share) for share in shares_of(request)]


def finished(begun: Begun, stage: Stage = untold) -> Posted:
    """The program that was begun. Raises StrictError, and VerifyError as `post` does."""
    while True:
        try:
            stage(next(begun.stages))
        except StopIteration as end:
            posted: Posted = end.value
            return posted


def posting(job: Job, plan: AnyPlan) -> Generator[str, None, Posted]:
    """The program of a job by its plan, stage by stage: yields each one when it is done."""
    request = job.request
    kind = post_of(job.machine)
    remarks = remarks_on(plan, job.machine, request.strict)
    program = kind.motion(plan, job.machine, request.name)
    manual_work = sum(1 for _ in manual_work_sources(plan))
    head = head_lines(job, plan, left_out_kinds(plan), manual_work)
    if request.date and isinstance(program, Program):
        program = replace(program, about={**program.about, "date": request.date})
    program = kind.with_head(program, tuple(head))
    yield "put in motion"
    written = kind.emit(program, job)
    yield "printed the program"
    differences: tuple[Diagnostic, ...] = ()
    if request.verified:
        diagnostics = kind.verify(written, job)
        differences = (
            *other_than_planned(plan, diagnostics, job),
            *head_differences(job, plan, written, diagnostics),
        )
        yield "read the program back"
        if errors_in(differences):
            raise RefusedProgram(differences, written, request.name)
        if request.strict:
            refuse_warnings(differences)
    return Posted(written, plan, (*remarks, *differences), program, job)


def remarks_on(plan: AnyPlan, machine: Machine, strict: bool) -> tuple[Diagnostic, ...]:
    """All that is said of a plan. Raises StrictError under `strict` if there is a warning."""
    remarks = plan.remarks
    if unfinished(plan.outcomes):
        remarks += tuple(unfinished_remarks(plan))
    if isinstance(plan, SheetPlan) and machine.torch is not None:
        remarks += tuple(map_remarks(plan, machine.torch))
    if strict:
        refuse_warnings(remarks)
    return remarks


def refuse_warnings(remarks: Iterable[Diagnostic]) -> None:
    """Raises StrictError with all remarks if there is a warning among them."""
    refused = tuple(map(as_error, remarks))
    if errors_in(refused):
        raise StrictError(refused)
