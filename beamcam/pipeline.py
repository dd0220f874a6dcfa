"""The architecture on one screen: how an input becomes a program.

    bytes -> readers -> Part -> planning -> Plan -> motion -> Program -> emitters -> text
                                                                     verify <- text

Which planner, motion step, emitter and read-back belong together stands in `posts`.
"""

import re
from collections import Counter
from collections.abc import Callable, Collection, Generator, Iterable, Iterator, Mapping, Sequence
from typing import Any, Literal

from msgspec import Struct
from msgspec.structs import replace

from beamcam import readers
from beamcam.asked import AnyMachine, check_asked, machine_of
from beamcam.errors import (
    Diagnostic,
    PlanError,
    ReadError,
    Severity,
    Source,
    VerifyError,
    errors_in,
)
from beamcam.machine.machine import Machine
from beamcam.model.part import Part
from beamcam.model.plan import Order, Plan, SheetPlan
from beamcam.model.program import Program
from beamcam.model.work_time import WorkTime
from beamcam.planning.by_hand import TEXT_MOVED
from beamcam.planning.left_out import BY_HAND, LEFT_OUT, by_hand_sources, left_out_sources, told
from beamcam.planning.rules import named_skips
from beamcam.posts import Job, Request, Written, carries_head, head_lines, post_of
from beamcam.readers.content import content, shown_name
from beamcam.readers.reading import Reading
from beamcam.texts_told import other_places, stand_ins
from beamcam.verify.bar_rules import BAR_NEEDED, BAR_TOLD
from beamcam.verify.by_hand import BY_HAND as FOR_HAND
from beamcam.verify.by_hand import TEXT_MOVED as MOVED
from beamcam.verify.head import head_faults, head_of
from beamcam.verify.left_out import LEDGER
from beamcam.verify.left_out import LEFT_OUT as MISSING
from beamcam.verify.uncut import UNCUT, UNCUT_TOLD

Stage = Callable[[str], None]  #: callback with the finished stage


def untold(stage: str) -> None:
    """Default callback after a stage; does nothing."""


#: Rules for features that a program does not make, as allowed or as the machine file says.
NOT_MADE = (LEFT_OUT.code, BY_HAND.code)


_UNCUT = re.compile(r"found (\S+) mm of waste .* at x (\S+), y (\S+) ")
_NEEDED = re.compile(r"; (\S+) mm are needed")
TOLD_BAR = 0.001  #: mm that lengths of bars in messages are rounded to


class Posted(Struct, frozen=True):
    """A program and how it came about."""

    written: Written
    plan: Plan | SheetPlan
    remarks: tuple[Diagnostic, ...]
    program: object  #: as it was printed: commands, or a table

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

    @property
    def leaves_out(self) -> bool:
        """Whether a feature of the parts is missing from the program, allowed or left to hand."""
        return any(said.code in NOT_MADE for said in self.remarks)

    def pieces(self) -> Iterable[bytes]:
        """Content of the file."""
        return pieces_of(self.written)


class RefusedProgram(VerifyError):
    """A program that was read back and does not make the parts; it can be looked at."""

    def __init__(self, diagnostics: Iterable[Diagnostic], written: Written) -> None:
        super().__init__(diagnostics)
        self.written = written

    def __reduce__(self) -> tuple[Any, ...]:
        return type(self), (self.diagnostics, self.written)

    def pieces(self) -> Iterable[bytes]:
        """The program as it would have stood in the file."""
        return pieces_of(self.written)


def pieces_of(written: Written) -> Iterable[bytes]:
    """The bytes of a program, piece by piece."""
    return (written.encode(),) if isinstance(written, str) else written()


def stock_of(parts: Sequence[Part]) -> Literal["beam", "sheet"]:
    """The kind of stock that parts are made of: a sheet if all of them are plates."""
    return "sheet" if parts and all(part.profile.code == "B" for part in parts) else "beam"


def read_file(path: str, strict: bool = False, **options: object) -> Reading:
    """Content of a file, `-` for standard input; a file that cannot be opened is refused.

    `strict` makes its warnings errors. `options` go to a reader that takes them: units, width and
    layers of a drawing.
    """
    name, data = shown_name(path), content(path)
    if isinstance(data, Diagnostic):
        return Reading("unknown", (), (data,))
    return judged(readers.read(data, name, **options), strict)


def judged(reading: Reading, strict: bool) -> Reading:
    """A reading, under `strict` with its warnings as errors."""
    if not strict:
        return reading
    return replace(reading, diagnostics=tuple(map(as_error, reading.diagnostics)))


def as_error(said: Diagnostic) -> Diagnostic:
    """A warning as an error; anything else as it is, also what the user or the machine allows."""
    if said.code in NOT_MADE:
        return said
    return replace(said, severity=Severity.ERROR) if said.severity is Severity.WARNING else said


def parts_of(
    readings: Iterable[Reading], parts_in: Callable[[Reading], Iterable[Part]] | None = None
) -> tuple[tuple[Part, ...], tuple[Diagnostic, ...]]:
    """All parts in order, and the remarks of their readers. Raises ReadError for any error.

    `parts_in` says what the parts of a reading are, where that is not just `parts`.
    """
    parts: list[Part] = []
    said: list[Diagnostic] = []
    for reading in readings:
        parts += reading.parts if parts_in is None else parts_in(reading)
        said += reading.diagnostics
    if errors_in(said):
        raise ReadError(said)
    return tuple(parts), tuple(said)


def counted(reading: Reading) -> Sequence[Part]:
    """The parts of a reading, equal members of a model as one with their number as quantity."""
    if reading.format != "ifc":
        return reading.parts
    from beamcam.readers.ifc.quantities import equal_parts

    return equal_parts(reading.parts)


def sound(reading: Reading) -> Reading:
    """A reading with those of its parts only that no error is said of.

    Errors of a model name their members, which are parts of their own; in any other file they
    refuse all of it.
    """
    refused = {said.source.where for said in errors_in(reading.diagnostics)}
    if not refused:
        return reading
    is_model = reading.format == "ifc"
    parts = tuple([part for part in reading.parts if is_model and part.guid not in refused])
    return replace(reading, parts=parts)


def read_back(program: str | bytes, request: Request) -> tuple[Diagnostic, ...]:
    """All faults of a program for bars, sheets or tables, as its machine reads it.

    Raises PlanError where a sheet's own features cannot be listed.
    """
    written: Written = program if isinstance(program, str) else lambda: (program,)
    return post_of(request.machine).verify(written, request)


def post(
    parts: Sequence[Part],
    machine: Machine,
    job: str = "JOB",
    bar: float | None = None,
    skips: Collection[str] = (),
    verified: bool = True,
    order: Order = "given",
    turn: bool = False,
    strict: bool = False,
    style: str | None = None,
    stage: Stage = untold,
    date: str = "",
) -> Posted:
    """The program that makes `parts` from one bar or sheet, read back and compared with them.

    `style` is the form of program for a controller that knows several: "chain" or "table" of
    triggers; of step tables the suffix of the output. Unless `verified` a comment in the program
    says so. `stage` is called with each step that is done. `date` is what `{date}` of the machine's
    words says. Raises PlanError if the machine cannot
    make the parts, or under `strict` if there is a warning; VerifyError if
    the program would make anything else.
    """
    check_asked(job, bar, skips)  # before a text is taken for a list of letters
    asked = Job(tuple(parts), machine, job, bar, named_skips(skips), order, turn, style, date)
    stages = posting(asked, verified, strict)
    while True:
        try:
            stage(next(stages))
        except StopIteration as end:
            posted: Posted = end.value
            return posted


def posting(
    asked: Job, verified: bool = True, strict: bool = False
) -> Generator[str, None, Posted]:
    """`post` stage by stage, planning first: yields each one when done, returns the result."""
    check_asked(asked.name, asked.bar, asked.skips)
    kind = post_of(asked.machine)
    plan = kind.plan(asked)
    yield f"planned {len(plan.operations)} operation(s)"
    remarks = remarks_on(plan, strict)
    program = kind.motion(plan, asked.machine, asked.name)
    by_hand = sum(1 for _ in by_hand_sources(plan))
    if asked.date and isinstance(program, Program):
        program = replace(program, about={**program.about, "date": asked.date})
    program = kind.with_head(program, tuple(head_lines(asked, verified, by_hand)))
    yield "put in motion"
    written = kind.emit(program, asked)
    yield "printed the program"
    said: tuple[Diagnostic, ...] = ()
    if verified:
        found = kind.verify(written, _request(asked))
        hand = sum(one.code == FOR_HAND.code for one in found)
        said = (*_other_than_planned(plan, found, asked), *_head_faults(asked, written, hand))
        yield "read the program back"
        if errors_in(said):
            raise RefusedProgram(said, written)
    return Posted(written, plan, (*remarks, *said), program)


def remarks_on(plan: Plan | SheetPlan, strict: bool) -> tuple[Diagnostic, ...]:
    """All that is said of a plan. Raises PlanError under `strict` if there is a warning."""
    remarks = (*plan.remarks, *told(plan))
    if strict:
        refuse_warnings(remarks)
    return remarks


def refuse_warnings(remarks: Iterable[Diagnostic]) -> None:
    """Raises PlanError with all remarks if there is a warning among them."""
    refused = tuple(map(as_error, remarks))
    if errors_in(refused):
        raise PlanError(refused)


def _other_than_planned(
    plan: Plan | SheetPlan, found: Iterable[Diagnostic], asked: Job
) -> Iterator[Diagnostic]:
    """What the read-back found; what is not made only where the plan says otherwise.

    The features that it found missing, and that may be, are those that the plan left out by name;
    the marks that it found to be manual work are those on the plan's list; the contours with waste
    that no beam reaches are those that the plan reports; the bar that it needs where nobody gave
    its length is no longer than the plan's.
    """
    missing: list[tuple[str, Source]] = []
    refused = False
    moved: list[Diagnostic] = []
    for said in found:
        if said.code in (MISSING.code, FOR_HAND.code):
            missing.append((said.code, said.source))
        elif said.code == MOVED.code:
            moved.append(said)
        elif said.code == UNCUT.code:
            yield from _untold(plan, said)
        elif said.code == BAR_NEEDED.code and isinstance(plan, Plan):
            yield from _too_short(plan, said, asked.machine.format.resolution)
        else:
            refused = refused or said.severity is Severity.ERROR
            yield said
    if refused:  # what is missing may not have been looked for
        return
    hand = [*by_hand_sources(plan)]
    told = [said for said in plan.remarks if said.code == TEXT_MOVED.code]
    named = [(MISSING.code, source) for source in left_out_sources(plan)]
    named += [(FOR_HAND.code, source) for source in hand]
    if not (told or moved or missing or named):  # as of nearly every plan
        return
    alike = stand_ins(asked.parts)
    yield from other_places(told, moved, alike, hand)
    lacking, planned = _of_the_first(missing, alike), _of_the_first(named, alike)
    for code, source in (lacking - planned) + (planned - lacking):
        one = code, source
        yield LEDGER.at(source, found=lacking[one], expected=planned[one])


def _of_the_first(
    missing: Iterable[tuple[str, Source]], alike: Mapping[Source, Source]
) -> Counter[tuple[str, Source]]:
    """What is missing, each text by the first of those that are alike."""
    return Counter((code, alike.get(source, source)) for code, source in missing)


def _untold(plan: Plan | SheetPlan, uncut: Diagnostic) -> Iterator[Diagnostic]:
    """An error for waste that stays in a corner of a contour, unless the plan reports it."""
    from beamcam.planning.contours.rules import LEFT

    told = [d for d in plan.remarks if d.code == LEFT.code]
    depth, x, y = _UNCUT.findall(uncut.message)[0]
    if not any(d.source == uncut.source or f"at x {x}, y {y}" in d.message for d in told):
        yield UNCUT_TOLD.at(uncut.source, found=depth, x=x, y=y)


def _too_short(plan: Plan, needed: Diagnostic, step: float) -> Iterator[Diagnostic]:
    """An error if the plan's bar is shorter than its program needs, by more than `step`."""
    (found,) = _NEEDED.findall(needed.message)
    if float(found) > plan.bar.length + step + TOLD_BAR:
        yield BAR_TOLD.at(needed.source, found=found, expected=f"{plan.bar.length:.3f}")


def _head_faults(job: Job, written: Written, by_hand: int) -> Iterable[Diagnostic]:
    """Differences of a program's head from the job and its read-back."""
    if not carries_head(job):
        return ()
    text = written if isinstance(written, str) else next(iter(written())).decode("latin-1")
    return head_faults(head_of(text), job.machine, job.skips, job.name, by_hand)


def _request(job: Job) -> Request:
    """Requirements of a job's program."""
    return Request(
        job.parts, job.machine, job.skips, job.name, job.order, job.turn, job.bar, job.style
    )
