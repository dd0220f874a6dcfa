"""The work on one file, as a worker does it: bytes in, programs and an account out.

It opens no file and knows no other file, so that it is the same in this process, in another one
and on another machine. What it needs besides the bytes is a `BatchSettings`, which goes to each
worker once, frozen.
"""

import os
import pickle
from collections.abc import Callable, Generator, Iterable, Mapping, Sequence
from functools import partial
from hashlib import sha256

from msgspec import Struct, field, json
from msgspec.structs import replace

from beamcam import budget
from beamcam.arguments import on_best_machine
from beamcam.batch import INTERNAL, NO_PART, SAME_NAME
from beamcam.batch.names import FileNames, mark_key, other_content, stage_names
from beamcam.batch.part_rows import part_row
from beamcam.budget import Limits
from beamcam.caches import cached
from beamcam.errors import BeamcamError, Diagnostic, ReadError, Source, VerifyError
from beamcam.files import REFUSED_SUFFIX
from beamcam.machine.machine import Machine
from beamcam.model.part import Part
from beamcam.model.request import (
    MarkFrom,
    Remnant,
    Request,
    are_flats,
    marked,
    numbered,
    stock_of,
)
from beamcam.pipeline import Begun, Posted, RefusedProgram, begin, counted, judged, parts_of
from beamcam.readers import read, sound
from beamcam.reports.part_list import PartCount
from beamcam.reports.run import FileRow, PartRow, RestRow, Status, as_message
from beamcam.version import __version__
from beamcam.writers import target_of_suffix


class BatchSettings(Struct, frozen=True):
    """All that decides what becomes of a file's bytes."""

    request: Request  #: of each part, still without it; its machine is that of bars
    name: str | None = None  #: template of the outputs' names
    sheets: Machine | None = None  #: the machine of sheets, if it is another
    reading: Mapping[str, object] = field(default_factory=dict)  #: options of the readers
    version: str = __version__
    timed: bool = True  #: whether the machine's time is worked out
    clock: Callable[[], float] | None = None
    more: tuple[Machine, ...] = ()  #: machines of either stock that are tried after the first
    mark_from: MarkFrom = "mark"  #: where marks stand
    remnants: tuple[Remnant, ...] = ()  #: bars that are there once, for a run over stock
    #: of what one machine leaves to the next where `machine` and `more` make parts one after the
    #: other; "" where one of them makes a part
    rest_suffix: str = ""
    #: how much each file may take
    limits: Limits = field(default_factory=lambda: budget.InForce.limits)

    @property
    def machine(self) -> Machine:
        """That of bars."""
        return self.request.machine

    @property
    def machines(self) -> tuple[Machine, ...]:
        """All of them, those of bars and of sheets first."""
        return (self.machine, *(() if self.sheets is None else (self.sheets,)), *self.more)

    @property
    def freeze(self) -> bytes:
        """The shop for a worker; `thaw` gives it back."""
        return pickle.dumps(self)

    @property
    def identity(self) -> bytes:
        """Everything besides the input that outputs depend on, as bytes to be hashed."""
        plain = repr(replace(self, timed=True, clock=None, reading={}))
        # Of sets the order differs from process to process.
        reading = json.encode(self.reading, order="deterministic")
        # A record of rows of another form is not used.
        form = " ".join(PartRow.__annotations__)
        return f"{plain} {form} ".encode("utf-8", "backslashreplace") + reading

    def machines_for(self, part: Part) -> tuple[Machine, ...]:
        """The machines that may make a part, by its stock, in the order they are tried in."""
        first = self._first_for(part)
        is_sheet = first.stock == "sheet"
        alike = (one for one in self.more if (one.stock == "sheet") is is_sheet)
        if not (is_sheet and are_flats((part,))):
            return first, *alike
        lines = (one for one in (self.machine, *self.more) if one.stock == "beam")
        return first, *alike, *lines

    @property
    def chain(self) -> tuple[Machine, ...]:
        """The machines that make a part one after the other; none where one of them does."""
        return (self.machine, *self.more) if self.rest_suffix else ()

    def request_of(self, part: Part) -> Request:
        """What is asked of the first machine that may make a part."""
        style = self.request.style if stock_of((part,)) == "sheet" else None
        return replace(self.request, parts=(part,), machine=self._first_for(part), style=style)

    def machine_named(self, name: str) -> Machine:
        """The machine of that name; that of bars where there is none."""
        return next((machine for machine in self.machines if machine.name == name), self.machine)

    def _first_for(self, part: Part) -> Machine:
        if self.sheets is not None:
            torch = self.sheets.needed(self.sheets.torch, "torch")
            if stock_of((part,), torch.unrolled) == "sheet":
                return self.sheets
        return self.machine


@cached("batch.shop")
def thaw(frozen: bytes) -> BatchSettings:
    """The shop that was frozen; the same object each time, so that what is known of it is kept."""
    settings: BatchSettings = pickle.loads(frozen)
    return settings


class Task(Struct, frozen=True):
    """One file to be worked on."""

    index: int  #: place in the order of the inputs
    name: str  #: of the file, for messages
    data: bytes

    def post(self, settings: BatchSettings, made: "FileResult") -> Generator[str, None, None]:
        """Add the programs of all parts that can be made; the others refuse the file."""
        parts = parts_in(self, settings, made)
        yield "read the file"
        stem = os.path.splitext(os.path.basename(self.name))[0]
        names = FileNames()
        # Parts that differ from an earlier one with their mark refuse the file.
        mixed = () if len({*map(mark_key, parts)}) == len(parts) else tuple(other_content(parts))
        if mixed:
            made.refuse(mixed)
        sources = {one.source for one in mixed}
        for number, part in enumerate(parts, 1):
            if part.source in sources:
                continue
            called = partial(stage_names, settings.name, stem, part, number, len(parts) > 1)
            if settings.chain:
                yield from _post_chain(part, called, settings, names, made)
                continue
            try:
                planned, choice = on_best_machine(
                    settings.request_of(part), settings.machines_for(part), begin
                )
            except BeamcamError as error:
                made.refuse(error.diagnostics)
                continue
            yield "planned"
            made.say(choice)
            name, _ = called(planned[0].job.machine, 0, "")
            for each, numbered_name in zip(planned, numbered(name, len(planned)), strict=True):
                yield from _post_job(each, numbered_name, settings, names, made)


class FileResult(Struct):
    """What becomes of one file: its programs by name, and its row in the account."""

    index: int
    row: FileRow
    outputs: list[tuple[str, bytes]] = field(default_factory=list)  #: by names below the input's
    refused: list[tuple[str, bytes]] = field(default_factory=list)  #: that the read-back refused
    looked: list[PartCount] = field(default_factory=list)  #: parts, where that is the task
    rests: list[tuple[str, bytes]] = field(default_factory=list)  #: between programs, by name

    def say(self, diagnostics: Iterable[Diagnostic]) -> None:
        """Add messages to the row."""
        self.row["messages"] += map(as_message, diagnostics)

    def refuse(self, diagnostics: Iterable[Diagnostic]) -> None:
        """The file is refused, for what the messages say."""
        self.row["status"] = "refused"
        self.say(diagnostics)


def make_all(tasks: Sequence[Task], settings: BatchSettings) -> list[FileResult]:
    """The programs of several files; any fault is reported in its file's row, never raised.

    All of them are read, then all are planned, and so on: a processor that does the same for many
    is quicker by a sixth than one that does everything for each in turn.
    """
    budget.InForce.limits = settings.limits
    clock = settings.clock or (lambda: 0.0)
    seconds = [0.0] * len(tasks)
    made: dict[int, FileResult] = {}
    under_way = {place: making(task, settings) for place, task in enumerate(tasks)}
    while under_way:
        for place, stages in tuple(under_way.items()):
            begun = clock()
            try:
                next(stages)
            except StopIteration as end:
                made[place] = end.value
                del under_way[place]
            seconds[place] += clock() - begun
    for place, one in made.items():
        one.row["seconds"] = round(seconds[place], 6)
    return [made[place] for place in range(len(tasks))]


def making(task: Task, settings: BatchSettings) -> Generator[str, None, FileResult]:
    """The programs of one file, stage by stage."""
    made = FileResult(task.index, row_of(task.name, "posted"))
    try:
        yield from task.post(settings, made)
    except BeamcamError as error:
        made.refuse(error.diagnostics)
    except Exception as error:
        import traceback

        frame = traceback.extract_tb(error.__traceback__)[-1]
        what = f"{type(error).__name__} at {os.path.basename(frame.filename)}:{frame.lineno}"
        what = f"{what}: {error}" if str(error) else what
        made.say([INTERNAL.at(Source(task.name), found=what)])
        made.row["status"], made.row["parts"], made.outputs, made.rests = "failed", [], [], []
    return made


def row_of(path: str, status: Status, *diagnostics: Diagnostic) -> FileRow:
    """The row of a file of which nothing is made yet."""
    return {
        "file": path, "status": status, "format": "", "seconds": 0.0, "parts": [],
        "messages": [*map(as_message, diagnostics)],
    }  # fmt: skip


def parts_in(task: Task, settings: BatchSettings, made: FileResult) -> tuple[Part, ...]:
    """The sound parts of a file; what is said of it is added to its row.

    Raises ReadError for a file without any.
    """
    reading = judged(read(task.data, task.name, **settings.reading), settings.request.strict)
    made.row["format"] = reading.format
    if reading.format == "ifc" and reading.refused:
        # The members of a model are parts of their own: those that cannot be read stop no other.
        made.refuse(reading.diagnostics)
        parts = counted(sound(reading))
    else:
        parts, diagnostics = parts_of((reading,), counted)
        made.say(diagnostics)
    if not parts:
        raise ReadError(NO_PART.at(Source(task.name)))
    return marked(parts, settings.mark_from)


def _post_job(
    planned: Begun, name: str, settings: BatchSettings, names: FileNames, made: FileResult
) -> Generator[str, None, None]:
    """Add the program of a part, or of the pieces of it that lie on one bar."""
    part = planned.job.parts[0]
    refused_name = partial(names.take, name + REFUSED_SUFFIX, part.mark)
    posted = yield from posted_of(planned, refused_name, made)
    if posted is None:
        return
    other = names.owner(name)
    if other is not None and settings.name is not None:
        made.refuse([SAME_NAME.at(part.source, found=name, other=f"part {other}")])
        return
    name = names.take(name, part.mark)
    content = posted.text.encode("utf-8")
    made.outputs.append((name, content))
    made.row["parts"].append(part_row(posted, name, content, settings.timed))


def _post_chain(
    part: Part, called: Callable[[Machine, int, str], tuple[str, str]], settings: BatchSettings,
    names: FileNames, made: FileResult,
) -> Generator[str, None, None]:  # fmt: skip
    """Add the programs of a part on several machines, all of them or none, and what is between.

    One that a machine makes by itself is called as that of any part.
    """
    from beamcam.rest_part import Stage, chain_for, stages_of

    stages: list[Stage] = []
    request = settings.request_of(part)
    try:
        chain, diagnostics = chain_for(request, settings.chain)
        yield "planned"
        first = 0 if len(chain) == 1 else 1
        names_of_links = [
            called(one.machine, k, settings.rest_suffix) for k, one in enumerate(chain, first)
        ]
        for stage in stages_of(request, chain, target_of_suffix(settings.rest_suffix)):
            stages.append(stage)
            yield "read a program back"
    except BeamcamError as error:

        def refused_name() -> str:
            name = names_of_links[len(stages)][0]
            return names.take(name + REFUSED_SUFFIX, part.mark)

        _refuse_program(error, refused_name, made)
        return
    made.say((*diagnostics, *(one for stage in stages for one in stage.remarks)))
    taken = [name for pair in names_of_links for name in pair if names.owner(name) is not None]
    if taken and settings.name is not None:
        other = f"part {names.owner(taken[0])}"
        made.refuse([SAME_NAME.at(part.source, found=taken[0], other=other)])
        return
    for stage, (name, rest_name) in zip(stages, names_of_links, strict=True):
        name = names.take(name, part.mark)
        content = stage.posted.text.encode("utf-8")
        rest: RestRow | None = None
        if stage.rest:
            rest_name = names.take(rest_name, part.mark)
            data = stage.rest.encode("utf-8")
            digest = sha256(data).hexdigest()
            rest = {"output": rest_name, "sha256": digest, "features": stage.passed_on}
            made.rests.append((rest_name, data))
        made.outputs.append((name, content))
        posted = replace(stage.posted, plan=stage.plan)
        made.row["parts"].append(part_row(posted, name, content, settings.timed, rest))


def posted_of(
    planned: Begun, refused_name: Callable[[], str], made: FileResult
) -> Generator[str, None, Posted | None]:
    """The program that was planned; None where it is refused, which its row says."""
    try:
        posted = yield from planned.stages
    except BeamcamError as error:
        _refuse_program(error, refused_name, made)
        return None
    made.say(posted.remarks)
    return posted


def _refuse_program(error: BeamcamError, name: Callable[[], str], made: FileResult) -> None:
    """The file is refused; a program that the read-back refused is kept under a name."""
    if isinstance(error, RefusedProgram):
        kept = name()
        made.refused.append((kept, b"".join(error.pieces())))
        error = VerifyError(error.named(kept))
    made.refuse(error.diagnostics)
