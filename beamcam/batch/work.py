"""The work on one file, as a worker does it: bytes in, programs and an account out.

It opens no file and knows no other file, so that it is the same in this process, in another one
and on another machine. What it needs besides the bytes is a `Shop`, which goes to each worker
once, frozen.
"""

import os
from collections import Counter
from collections.abc import Callable, Generator, Iterable, Mapping, Sequence, Set
from functools import partial
from hashlib import sha256
from typing import cast

from msgspec import Struct, field, json
from msgspec.structs import replace

from beamcam import budget
from beamcam.batch import rules
from beamcam.batch.names import FileNames, mark_key, other_content, output_name
from beamcam.budget import Limits
from beamcam.caches import cached
from beamcam.errors import BeamcamError, ReadError, Source
from beamcam.files import REFUSED_SUFFIX
from beamcam.machine.machine import Machine
from beamcam.machine_choice import on_best_machine
from beamcam.model.description import MarkFrom, marked
from beamcam.model.part import Part
from beamcam.model.plan import ContourOp, Order, stock_used
from beamcam.model.request import ChosenBy, Quantity, Remnant, Request
from beamcam.pipeline import (
    Begun,
    Posted,
    RefusedProgram,
    begin,
    counted,
    judged,
    parts_of,
    sound,
    stock_of,
)
from beamcam.planning.jobs import numbered
from beamcam.planning.rules import named_skips
from beamcam.readers import read
from beamcam.report.hand_list import hand_rows
from beamcam.report.part_list import PartCount
from beamcam.report.run import Ledger, Message, PartRow, Row, as_message
from beamcam.version import __version__


class Shop(Struct, frozen=True):
    """All that decides what becomes of a file's bytes."""

    machine: Machine  #: of bars
    job: str = "JOB"
    stock_lengths: tuple[float, ...] = ()  #: rising; a part takes the first that it fits on
    quantity: Quantity = None
    skips: tuple[str, ...] = ()
    strict: bool = False
    read_back: bool = True
    name: str | None = None  #: template of the outputs' names
    sheets: Machine | None = None  #: the machine of sheets, if it is another
    reading: Mapping[str, object] = field(default_factory=dict)  #: options of the readers
    version: str = __version__
    timed: bool = True  #: whether the machine's time is worked out
    clock: Callable[[], float] | None = None
    more: tuple[Machine, ...] = ()  #: machines of either stock that are tried after the first
    date: str = ""  #: for words of the machine
    order: Order = "given"  #: of the pieces on a bar
    turn: bool = False  #: whether parts may lie turned
    mark_from: MarkFrom = "mark"  #: where marks stand
    style: str | None = None  #: of trigger programs: "chain" or "table"
    remnants: tuple[Remnant, ...] = ()  #: bars that are there once, for a run over stock
    by: ChosenBy = "order"  #: which of the machines makes a part
    limits: Limits = field(default_factory=budget.limits)  #: how much each file may take

    @property
    def freeze(self) -> bytes:
        """The shop for a worker; `thaw` gives it back."""
        import pickle

        return pickle.dumps(self)

    @property
    def settings(self) -> bytes:
        """Everything besides the input that outputs depend on, as bytes to be hashed."""
        plain = repr(replace(self, timed=True, clock=None, reading={}))
        # Of sets the order differs from process to process.
        told = json.encode(self.reading, order="deterministic")
        # A record of rows of another form is not used.
        form = " ".join(PartRow.__annotations__)
        return f"{plain} {form} ".encode("utf-8", "backslashreplace") + told

    def machines_for(self, part: Part) -> tuple[Machine, ...]:
        """The machines that may make a part, by its stock, in the order they are tried in."""
        first = self._first_for(part)
        return (first, *(machine for machine in self.more if machine.stock == first.stock))

    def request_of(self, part: Part) -> Request:
        """What is asked of the first machine that may make a part."""
        style = self.style if stock_of((part,)) == "sheet" else None
        return Request(
            (part,), self._first_for(part), named_skips(self.skips), self.job,
            self.order, self.turn, self.stock_lengths, style,
            quantity=self.quantity, strict=self.strict,
            verified=self.read_back, date=self.date, by=self.by,
        )  # fmt: skip

    def lengths_for(self, part: Part) -> tuple[float, ...]:
        """The lengths of bars that a part may be cut from, remnants among them, rising."""
        if not self.stock_lengths:
            return ()
        return tuple(sorted({*self.stock_lengths, *(one.length for one in self.remnants)}))

    def machine_named(self, name: str) -> Machine:
        """The machine of that name; that of bars where there is none."""
        known = (self.machine, *(() if self.sheets is None else (self.sheets,)), *self.more)
        return next((machine for machine in known if machine.name == name), self.machine)

    def _first_for(self, part: Part) -> Machine:
        if self.sheets is not None and stock_of((part,)) == "sheet":
            return self.sheets
        return self.machine


@cached("batch.shop")
def thaw(frozen: bytes) -> Shop:
    """The shop that was frozen; the same object each time, so that what is known of it is kept."""
    import pickle

    shop: Shop = pickle.loads(frozen)
    return shop


class Task(Struct, frozen=True):
    """One file to be worked on."""

    index: int  #: place in the order of the inputs
    name: str  #: of the file, for messages
    data: bytes

    def post(self, shop: Shop, row: Row, found: "Found") -> Generator[str, None, None]:
        """Add the programs of all parts that can be made; the others refuse the file."""
        yield from _post_all(self, shop, row, found)


class Found(Struct):
    """What comes of a task besides its row."""

    outputs: list[tuple[str, bytes]] = field(default_factory=list)  #: programs by name
    refused: list[tuple[str, bytes]] = field(default_factory=list)  #: that the read-back refused
    looked: list[PartCount] = field(default_factory=list)  #: parts, where that is the task


class FileResult(Struct, frozen=True):
    """Result of one file: its programs by name, and its row in the account."""

    index: int
    row: Row
    outputs: tuple[tuple[str, bytes], ...]  #: names below the input's folder, and contents
    refused: tuple[tuple[str, bytes], ...] = ()  #: programs that the read-back refused, likewise
    looked: tuple[PartCount, ...] = ()  #: the parts with what makes them, where that was asked


def make_all(tasks: Sequence[Task], shop: Shop) -> list[FileResult]:
    """The programs of several files; any fault is reported in its file's row, never raised.

    All of them are read, then all are planned, and so on: a processor that does the same for many
    is quicker by a sixth than one that does everything for each in turn.
    """
    budget.set_limits(shop.limits)
    clock = shop.clock or _no_clock
    seconds = [0.0] * len(tasks)
    made: dict[int, FileResult] = {}
    under_way = {place: making(task, shop) for place, task in enumerate(tasks)}
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


def making(task: Task, shop: Shop) -> Generator[str, None, FileResult]:
    """The programs of one file, stage by stage."""
    row: Row = {
        "file": task.name, "status": "posted", "format": "", "seconds": 0.0, "parts": [],
        "messages": [],
    }  # fmt: skip
    found = Found()
    try:
        yield from task.post(shop, row, found)
    except BeamcamError as error:
        row["status"] = "refused"
        row["messages"] += map(as_message, error.diagnostics)
    except Exception as error:
        import traceback

        row["status"] = "failed"
        frame = traceback.extract_tb(error.__traceback__)[-1]
        what = f"{type(error).__name__} at {os.path.basename(frame.filename)}:{frame.lineno}"
        what = f"{what}: {error}" if str(error) else what
        said = rules.INTERNAL.at(Source(task.name), found=what)
        row["messages"].append(as_message(said))
        row["parts"], found.outputs = [], []
    return FileResult(
        task.index, row, tuple(found.outputs), tuple(found.refused), tuple(found.looked)
    )


def refused_row(path: str, said: Message) -> Row:
    """The row of a file that is refused before it is worked on."""
    return {
        "file": path, "status": "refused", "format": "", "seconds": 0.0, "parts": [],
        "messages": [said],
    }  # fmt: skip


def died(path: str) -> Row:
    """The row of a file that ended its worker."""
    return {**refused_row(path, as_message(rules.DIED.at(Source(path)))), "status": "failed"}


def _no_clock() -> float:
    return 0.0


def parts_in(task: Task, shop: Shop, row: Row) -> tuple[Part, ...]:
    """The sound parts of a file; what is said of it is added to its row.

    Raises ReadError for a file without any.
    """
    reading = judged(read(task.data, task.name, **shop.reading), shop.strict)
    row["format"] = reading.format
    if reading.format == "ifc" and reading.refused:
        # The members of a model are parts of their own: those that cannot be read stop no other.
        row["status"], parts, said = "refused", counted(sound(reading)), reading.diagnostics
    else:
        parts, said = parts_of((reading,), counted)
    row["messages"] += map(as_message, said)
    if not parts:
        raise ReadError(rules.NO_PART.at(Source(task.name)))
    return marked(parts, shop.mark_from)


def _post_all(task: Task, shop: Shop, row: Row, found: Found) -> Generator[str, None, None]:
    parts = parts_in(task, shop, row)
    yield "read the file"
    stem = os.path.splitext(os.path.basename(task.name))[0]
    names = FileNames()
    mixed = _mixed(parts, row)
    for number, part in enumerate(parts, 1):
        if part.source in mixed:
            continue
        try:
            planned, choice = on_best_machine(shop.request_of(part), shop.machines_for(part), begin)
        except BeamcamError as error:
            row["status"] = "refused"
            row["messages"] += map(as_message, error.diagnostics)
            continue
        yield "planned"
        row["messages"] += map(as_message, choice)
        name = output_name(shop.name, stem, part, number, len(parts) > 1, planned[0].job.machine)
        for each, called in zip(planned, numbered(name, len(planned)), strict=True):
            yield from _post_job(each, called, shop, row, names, found)


def _mixed(parts: Sequence[Part], row: Row) -> Set[Source]:
    """The sources of parts that differ from an earlier one with their mark; the row is refused."""
    if len({*map(mark_key, parts)}) == len(parts):
        return frozenset()
    said = tuple(other_content(parts))
    if said:
        row["status"] = "refused"
        row["messages"] += map(as_message, said)
    return {one.source for one in said}


def _post_job(
    planned: Begun,
    name: str,
    shop: Shop,
    row: Row,
    names: FileNames,
    found: Found,
) -> Generator[str, None, None]:
    """Add the program of a part, or of the pieces of it that lie on one bar."""
    part = planned.job.parts[0]
    refused_name = partial(names.take, name + REFUSED_SUFFIX, part.mark)
    posted = yield from posted_of(planned, refused_name, row, found)
    if posted is None:
        return
    other = names.owner(name)
    if other is not None and shop.name is not None:
        row["status"] = "refused"
        clash = rules.SAME_NAME.at(part.source, found=name, other=f"part {other}")
        row["messages"].append(as_message(clash))
        return
    name = names.take(name, part.mark)
    content = posted.text.encode("utf-8")
    found.outputs.append((name, content))
    row["parts"].append(part_row(posted, name, content, shop.timed))


def posted_of(
    planned: Begun, refused_name: Callable[[], str], row: Row, found: Found
) -> Generator[str, None, Posted | None]:
    """The program that was planned; None where it is refused, which its row says."""
    try:
        posted = yield from planned.stages
    except BeamcamError as error:
        if isinstance(error, RefusedProgram):
            found.refused.append((refused_name(), b"".join(error.pieces())))
        row["status"] = "refused"
        row["messages"] += map(as_message, error.diagnostics)
        return None
    row["messages"] += map(as_message, posted.remarks)
    return posted


#: Outcomes of a feature, as in the ledger.
OUTCOMES = ("made", "merged", "duplicate", "listed", "skipped")


def part_row(posted: Posted, name: str, content: bytes, timed: bool) -> PartRow:
    plan, machine, pieces = posted.plan, posted.job.machine, len(posted.job.pieces)
    part = posted.job.parts[0]
    how: list[str] = [outcome.how for outcome in plan.outcomes]
    ledger = {"read": len(how), **{word: how.count(word) for word in OUTCOMES}}
    skipped_by = (
        Counter(o.by for o in plan.outcomes if o.how == "skipped") if "skipped" in how else {}
    )
    return {
        "mark": part.mark,
        "quantity": max(part.quantity, pieces),
        "pieces": pieces,
        "profile": part.profile.name,
        "order": part.order,
        "phase": part.phase,
        "length": part.length,
        "machine": machine.name,
        "output": name,
        "sha256": sha256(content).hexdigest(),
        "bar": used.length if (used := stock_used(plan, posted.job.bar)) is not None else 0.0,
        "ledger": cast(Ledger, ledger),
        "by_hand": hand_rows(plan),
        "skipped_by": dict(sorted(skipped_by.items())),
        "mapped": _mapped(part, machine),
        "tools": sorted({_tool_name(op) for op in _of_each_tool(plan.operations)}),
        "operations": len(plan.operations),
        "stock": None,
        "machine_time_s": round(posted.time(machine).total_s, 3) if timed else None,
    }


def _mapped(part: Part, machine: Machine) -> dict[str, int]:
    """The curves that each key of the machine's map of colours and layers stands for."""
    if machine.torch is None:
        return {}
    from beamcam.planning.left_out import curves_by_key

    return dict(sorted(curves_by_key((part,), machine.torch.colours).items()))


def _of_each_tool(operations: Iterable[object]) -> Iterable[object]:
    """One of the operations of each tool."""
    return {id(getattr(op, "tool", None) or op): op for op in operations}.values()


def _tool_name(operation: object) -> str:
    tool = getattr(operation, "tool", None)
    if tool is not None:
        return f"{tool.kind} {tool.diameter:g}"
    return operation.row.process if isinstance(operation, ContourOp) else "saw"
