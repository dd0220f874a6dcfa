"""A batch over stock: the parts of all files share bars and sheets, those of one section and grade.

    inputs -> looked at (workers): parts, and the machine that makes each
           -> lots: parts of one machine and section or thickness, and one grade
           -> shares: first fit over remnants and bars; rows on sheets
           -> programs (workers) -> written -> rows

What no machine makes is on no bar, and stands in the row of its file. A program whose pieces and
stock are those of the last run is not made again.
"""

import os
from collections import deque
from collections.abc import Generator, Iterator, Sequence
from contextlib import suppress
from hashlib import sha256

from msgspec.structs import replace

from beamcam.batch import STALE_SHARE
from beamcam.batch.find import Input, read_input
from beamcam.batch.names import other_content
from beamcam.batch.pool import driven
from beamcam.batch.record import Record
from beamcam.batch.run import BatchError, QueuedInput, Run, RunSetup, recorded
from beamcam.batch.shares import FileState, Lot, ShareTask, stems_of, tasks_of
from beamcam.batch.work import Task, row_of
from beamcam.checks.job import job_faults
from beamcam.errors import BeamcamError, Diagnostic, PlanError, Source, VerifyError
from beamcam.files import FilesRead
from beamcam.model.part import Part
from beamcam.model.request import Job, LotKey
from beamcam.pipeline import shares_of
from beamcam.reports.part_list import CutBar, CutPiece, PartCount
from beamcam.reports.run import FileRow, Message, PartRow, as_message

THICKNESS_DECIMALS = 2


class ShareRun(Run):
    """The programs of shares, written and recorded as those of files are."""

    def __init__(self, tasks: Sequence[ShareTask], setup: RunSetup, record: Record) -> None:
        inputs = [Input(task.parts[0].source.file, task.name) for task in tasks]
        super().__init__(inputs, setup, record, flat=True)
        self._tasks = tasks
        # Other bars in store change no program that lies on the same bar.
        request = replace(setup.settings.request, stock=())
        without = replace(setup.settings, request=request, remnants=())
        self._settings_hash = sha256(without.identity).digest()

    def _read(self, index: int) -> Task | None:
        task = self._tasks[index]
        slot = QueuedInput(index, self._inputs[index])
        self._slots.append(slot)
        return self.to_do(slot, task.key, task)

    def _refuse_mixed(self, row: FileRow) -> None:
        """Marks were compared before the first program."""

    def _warn_of_older(self, slot: QueuedInput, row: FileRow) -> None:
        """Programs of earlier runs are looked for at the end."""


class StockRun:
    """A run over stock. `counts` and `made` say what became of each part once it is done."""

    def __init__(self, inputs: Sequence[Input], setup: RunSetup) -> None:
        self._inputs, self._setup, self._settings = inputs, setup, setup.settings
        self.counts: list[PartCount] = []
        self.tasks: list[ShareTask] = []
        self.made: list[tuple[ShareTask, PartRow]] = []  #: the programs, made now or before
        self.remarks: list[Diagnostic] = []  #: on the run as a whole
        self._messages: dict[str, list[Message]] = {}  #: by file, for its first program

    def rows(self) -> Generator[FileRow, None, None]:
        """The rows of files that are refused or failed, then those of the programs.

        Raises BatchError before anything is written, for parts that differ under one mark of an
        order and for a folder that cannot be used; PlanError for remnants of which it is not known
        what they are.
        """
        with recorded(self._setup) as record:
            yield from self.planned()
            if not self._setup.interrupt:
                yield from self._programs(record)

    def planned(self) -> Iterator[FileRow]:
        """The rows of files that are refused or failed; then `tasks` are all programs.

        Raises BatchError and PlanError as `rows` does.
        """
        rows: dict[int, FileRow] = {}

        def tasks() -> Iterator[FileState]:
            for index, one in enumerate(self._inputs):
                data = read_input(one.path)
                if isinstance(data, Diagnostic):
                    rows[index] = row_of(one.path, "refused", data)
                else:
                    yield FileState(index, one.path, data)

        looked: dict[int, list[PartCount]] = {}
        for made in driven(self._setup.workers, tasks(), self._setup.interrupt):
            rows[made.index], looked[made.index] = made.row, made.looked
        refused: list[FileRow] = []
        for index, row in sorted(rows.items()):
            self.counts += looked.get(index, ())
            if row["status"] == "posted":
                self._messages[row["file"]] = row["messages"]
            else:
                refused.append(row)
        if self._setup.interrupt:
            return
        if mixed := tuple(other_content([one.part for one in self.counts])):
            raise BatchError(mixed)
        lots, unplanned = self._lots()
        stems = stems_of(lots)
        for lot, stem in zip(lots, stems, strict=True):
            self.tasks += tasks_of(lot, stem, len(self.tasks))
        for row in refused:
            row["messages"] += unplanned.pop(row["file"], [])
            yield row
        for file, messages in unplanned.items():
            before = self._messages.pop(file, [])
            yield {**row_of(file, "refused"), "messages": before + messages}

    def _lots(self) -> tuple[list[Lot], dict[str, list[Message]]]:
        """The lots in the order of their first parts; what is said of those without shares."""
        from beamcam.planning.stock import remnants_of

        of_key: dict[LotKey, list[int]] = {}
        for place, one in enumerate(self.counts):
            if one.machine:
                of_key.setdefault(self._key(one), []).append(place)
        bars = (key for key in of_key if self._settings.machine_named(key[0]).saw is not None)
        remnants = remnants_of(self._settings.remnants, bars)
        lots: list[Lot] = []
        unplanned: dict[str, list[Message]] = {}
        waiting = deque(of_key.items())
        while waiting:
            key, places = waiting.popleft()
            if not places:
                continue
            parts = tuple([self.counts[place].part for place in places])
            request = replace(
                self._settings.request_of(parts[0]), parts=parts,
                machine=self._settings.machine_named(key[0]),
                quantity=self._settings.request.quantity or "file", remnants=remnants.get(key, ()),
            )  # fmt: skip
            try:
                shares = shares_of(request)
                longest = ((one, one.lengths[0] if one.lengths else None) for one in shares)
                jobs = [Job(request, share.pieces, bar) for share, bar in longest]
                if faults := job_faults(request, jobs):
                    raise VerifyError(faults)
            except (PlanError, VerifyError) as error:
                waiting.append((key, self._refused(error, places, unplanned)))
                continue
            lots.append((request, shares))
        return lots, unplanned

    def _refused(
        self, error: BeamcamError, places: Sequence[int], unplanned: dict[str, list[Message]]
    ) -> list[int]:
        """The parts of a lot that are left once those that an error is said of are refused."""
        sources = {diagnostic.source for diagnostic in error.diagnostics}
        wrong = [k for k in places if self.counts[k].part.source in sources] or [*places]
        refused = tuple(error.diagnostics)
        for place in wrong:
            self.counts[place] = replace(self.counts[place], machine="", refused=refused)
        for file in dict.fromkeys(self.counts[k].part.source.file for k in wrong):
            unplanned.setdefault(file, []).extend(map(as_message, refused))
        return [k for k in places if k not in {*wrong}]

    def _key(self, one: PartCount) -> LotKey:
        part, machine = one.part, self._settings.machine_named(one.machine)
        if machine.torch is None:
            return one.machine, part.profile, part.grade
        own = part.profile.web_thickness
        thickness = own if own is not None else machine.torch.thickness or 0.0
        material = part.grade or machine.torch.material
        return one.machine, round(thickness, THICKNESS_DECIMALS), material

    def _programs(self, record: Record) -> Iterator[FileRow]:
        before, setup = {**record.made}, self._setup
        if setup.read is None:
            setup = replace(setup, read=FilesRead(one.path for one in self._inputs))
        run = ShareRun(self.tasks, setup, record)
        for task, row in zip(self.tasks, run.rows(), strict=False):
            row["file"] = task.name
            for file in dict.fromkeys(part.source.file for part in task.parts):
                row["messages"] += self._messages.pop(file, [])
            self.made += ((task, part) for part in row["parts"])
            yield row
        for output in sorted(before.keys() - {task.name for task in self.tasks}):
            with suppress(OSError), open(os.path.join(setup.folder, output), "rb") as program:
                if sha256(program.read()).hexdigest() == before[output]:
                    self.remarks.append(STALE_SHARE.at(Source(output), found=output))

    def bars(self) -> tuple[CutBar, ...]:
        """The bars that programs are for, as a cutting list has them."""
        return tuple(
            CutBar(
                tuple(
                    CutPiece(task.parts[task.pieces[laid["piece"]]], laid["at"], laid["turn"])
                    for laid in stock["pieces"]
                ),
                row["bar"], stock["cuts"], stock["remnant"], row["machine"],
            )
            for task, row in self.made
            if (stock := row["stock"]) is not None
        )  # fmt: skip

    def labelled(self) -> Iterator[tuple[Part, int, int, str]]:
        """Each piece that a program makes: its part, its number, of how many, and the program."""
        of_part: dict[int, list[str]] = {}
        for task, row in self.made:
            for place in task.pieces:
                of_part.setdefault(id(task.parts[place]), []).append(row["output"])
        for count in self.counts:
            programs = of_part.get(id(count.part), [])
            for number, program in enumerate(programs, 1):
                yield count.part, number, count.quantity, program
