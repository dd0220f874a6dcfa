"""A batch from one end to the other: rows in the order of the inputs, outputs in their folder.

    inputs -> read, hashed -> unchanged? ------------------------> row
                                 \\_ no: chunk -> workers -> made -> written -> row

Only this process reads and writes, so that workers may be anywhere and a run that is ended leaves
whole files. Rows come out in the order of the inputs whatever the order of finishing: what is
done early is held back, up to a limit, and so is who may have a name that two would have.
"""

import os
from collections import deque
from collections.abc import Generator, Iterable, Iterator, Sequence
from contextlib import contextmanager, suppress
from hashlib import sha256

from msgspec import Struct

from beamcam.batch import KEPT, OWN_REST, RECORD, STALE, WRITE
from beamcam.batch.find import Input, read_input
from beamcam.batch.names import MarkKey, folded, mixed_marks, other_content
from beamcam.batch.outputs import Outputs
from beamcam.batch.pool import CHUNK_BYTES, Chunk, Workers, results_of
from beamcam.batch.record import RECORD_NAME, Recipe, Record, noted_in, partly, rests_of
from beamcam.batch.work import BatchSettings, FileResult, Task, row_of
from beamcam.errors import BeamcamError, Diagnostic, Source
from beamcam.files import FilesRead
from beamcam.model.part import Part
from beamcam.model.request import marked
from beamcam.pipeline import counted, judged
from beamcam.readers import read, sound
from beamcam.reports.run import FileRow, PartRow, as_message, names_in
from beamcam.system import NEVER, EndRequest, can_sync_all

MOST_HELD = 64 * 1024 * 1024  #: bytes of programs that wait for an earlier one
MOST_FLYING = 256 * 1024 * 1024  #: bytes of inputs that workers have


class BatchError(BeamcamError):
    """A batch that cannot be begun."""


class QueuedInput(Struct):
    """One input on its way to its row."""

    index: int
    input: Input
    key: bytes = b""
    size: int = 0  #: bytes of the input, while workers have it; then of its programs
    row: FileRow | None = None  #: of an input that needs no work
    made: FileResult | None = None


class RunSetup(Struct, frozen=True):
    """Where a run writes, by which settings and workers, and how."""

    folder: str
    settings: BatchSettings
    workers: Workers
    read: FilesRead | None = None  #: none of which is written over; by default the inputs
    recipe: Recipe | None = None  #: what the record says that was asked for
    force: bool = False  #: does again what is unchanged, writes over what is not as a batch made it
    dry: bool = False  #: writes nothing
    interrupt: EndRequest = NEVER  #: once it asks for the end no further row comes


def run(
    inputs: Sequence[Input], setup: RunSetup, flat: bool = False,
    claims: dict[str, str] | None = None, marks: dict[MarkKey, str] | None = None,
) -> Generator[FileRow, None, None]:  # fmt: skip
    """Post every input into a folder and give its row, in the order of the inputs.

    `flat` puts all outputs into one folder, else they lie as their inputs do. `claims` keeps names
    apart over several runs: it holds which input has which, and is added to; so does `marks` with
    the first input that has a mark of an order. Raises BatchError if the folder cannot be used;
    closes the workers.
    """
    with recorded(setup) as record:
        yield from Run(inputs, setup, record, flat, claims, marks).rows()


@contextmanager
def recorded(setup: RunSetup) -> Generator[Record, None, None]:
    """The record of a run into a folder; at its end the workers are closed.

    Raises BatchError if the folder cannot be used.
    """
    folder, dry = setup.folder, setup.dry
    try:
        if not dry:
            os.makedirs(folder, exist_ok=True)
        record = Record(folder, setup.recipe, not dry)
    except OSError as error:
        setup.workers.close()
        reason = error.strerror or str(error)
        raise BatchError(WRITE.at(Source(folder), found=folder, reason=reason)) from error
    try:
        yield record
    finally:
        setup.workers.close()
        record.close()
        if can_sync_all() and not dry:
            os.sync()  # once for all, in place of waiting for the disk after each file


class Run:
    """A run under way; see `run`."""

    def __init__(
        self, inputs: Sequence[Input], setup: RunSetup, record: Record, flat: bool,
        claims: dict[str, str] | None = None, marks: dict[MarkKey, str] | None = None,
    ) -> None:  # fmt: skip
        self._inputs, self._setup, self._record, self._flat = inputs, setup, record, flat
        self._folder, self._settings, self._workers = setup.folder, setup.settings, setup.workers
        self._settings_hash = sha256(setup.settings.identity).digest()
        self._next = 0
        self._slots: deque[QueuedInput] = deque()
        self._away: dict[int, QueuedInput] = {}  #: what workers have, by index
        self._again: deque[Chunk] = deque()
        self._held = self._flying = 0
        self._claims = {} if claims is None else claims  #: name of an output -> input that has it
        read = setup.read or FilesRead(one.path for one in inputs)
        self._outputs = Outputs(setup.folder, record, self._claims, read, setup.force, setup.dry)
        self._marks = {} if marks is None else marks
        self._keeps_record = True
        self._own: frozenset[str] = frozenset()
        #: outputs of earlier runs by input, as the record has it; other machines may make it now
        self._before: dict[str, list[str]] = {}
        self._mixed: dict[str, Diagnostic] = {}  #: inputs that differ under one mark, and why

    def rows(self) -> Iterator[FileRow]:
        if self._settings.chain:
            self._look_back()
        paths = [one.path for one in self._inputs if one.path not in self._own]
        interrupt = self._setup.interrupt
        self._mixed = mixed_marks(paths, self._settings.mark_from, self._parts_of, interrupt)
        while not interrupt:
            fed = self._feed()
            while self._slots and not interrupt:
                if self._slots[0].row is None and self._slots[0].made is None:
                    break  # it is not done
                yield self._finish(self._slots.popleft())
            if self._next == len(self._inputs) and not self._slots:
                return
            if not fed:
                for outcome in self._workers.wait():
                    for made in results_of(outcome, self._again):
                        slot = self._away.pop(made.index)
                        self._flying -= slot.size
                        slot.made = made
                        slot.size = sum(len(data) for _, data in (*made.outputs, *made.rests))
                        self._held += slot.size

    def _look_back(self) -> None:
        """Note which outputs of earlier runs there are, and which inputs are such outputs."""
        with suppress(OSError):
            for noted in noted_in(self._folder):
                names = [*noted.outputs, *rests_of(noted)]
                self._before.setdefault(noted.input, []).extend(names)
        outputs = (name for names in self._before.values() for name in names)
        made = {os.path.realpath(os.path.join(self._folder, name)) for name in outputs}
        self._own = frozenset(
            one.path for one in self._inputs if os.path.realpath(one.path) in made
        )

    def _feed(self) -> bool:
        """Take some inputs, if there is room for them, and say whether that was so.

        One after the other they are read, and what there is to do is handed on as one chunk: a
        processor is quicker at doing the same for several than at everything for each in turn.
        """
        if not self._workers.has_room():
            return False
        if self._again:
            self._workers.submit(self._again.popleft())
            return True
        # A chunk is a quarter of a worker's share at most.
        share = len(self._inputs) // self._workers.at_once // 4
        most_files = max(1, min(self._workers.most_files, share))
        end = min(self._next + most_files, len(self._inputs))
        if self._next == end or self._held >= MOST_HELD or self._flying >= MOST_FLYING:
            return False
        chunk: list[Task] = []
        size = 0
        while self._next < end and size < CHUNK_BYTES:
            task = self._read(self._next)
            self._next += 1
            if task is not None:
                chunk.append(task)
                size += len(task.data)
        if chunk:
            self._workers.submit(tuple(chunk))
        return True

    def _read(self, index: int) -> Task | None:
        """Read an input, and give what is to be done if there is anything."""
        item = self._inputs[index]
        slot = QueuedInput(index, item)
        self._slots.append(slot)
        if item.path in self._own:
            slot.row = row_of(item.path, "unchanged", OWN_REST.at(Source(item.path)))
            return None
        data = self._mixed.get(item.path) or read_input(item.path)
        if isinstance(data, Diagnostic):
            slot.row = row_of(item.path, "refused", data)
            return None
        about = f"{item.path}\0{'' if self._flat else item.tree}\0"
        key = about.encode("utf-8", "surrogateescape") + data
        return self.to_do(slot, key, Task(index, item.path, data))

    def to_do(self, slot: QueuedInput, key: bytes, task: Task) -> Task | None:
        """The task of an input; None where it was done by an earlier run, as its key says."""
        slot.key = sha256(self._settings_hash + key).digest()
        done = None if self._setup.force else self._record.find(slot.key, slot.input)
        # A run that did not ask for times has not noted any.
        lacks_time = done is not None and any(p["machine_time_s"] is None for p in done["parts"])
        if done is not None and not (self._settings.timed and lacks_time):
            slot.row = {**done, "status": "unchanged", "seconds": 0.0}
            return None
        slot.size = len(task.data)
        self._flying += slot.size
        self._away[slot.index] = slot
        return task

    def _finish(self, slot: QueuedInput) -> FileRow:
        """The row of an input that is done, its outputs written and noted."""
        if slot.made is None:
            row = slot.row
            if row is None:
                raise AssertionError("a slot that is done has a row or what was made")
            if row["status"] == "unchanged":
                # An earlier input may have taken the name of its output.
                clash = self._outputs.claim(names_in(row), row["file"])
                if clash is not None:
                    row = {**row_of(row["file"], "refused", clash), "format": row["format"]}
                self._refuse_mixed(row)
        else:
            row = slot.made.row
            self._held -= slot.size
            self._refuse_mixed(row)
            self._write_all(slot, slot.made, row)
            if row["parts"] and self._keeps_record:
                key = slot.key if row["status"] == "posted" else partly(slot.key)
                try:
                    self._record.add(key, row, slot.input)
                except OSError as error:
                    self._keeps_record = False
                    source = Source(os.path.join(self._folder, RECORD_NAME))
                    diagnostic = RECORD.at(source, found=error.strerror or error)
                    row["messages"].append(as_message(diagnostic))
        before = self._before.get(self._record.input_of(slot.input)) if self._before else None
        if before is not None and slot.made is not None:
            self._warn_of(slot, row, before)
        elif row["status"] in ("refused", "failed") and not row["parts"]:
            self._warn_of_older(slot, row)
        return row

    def _refuse_mixed(self, row: FileRow) -> None:
        """Refuse a row if a part of it differs from one of the same mark and order before.

        Files are read for it only where marks meet; a worker looks at those within one file.
        """
        for part in row["parts"]:
            key = part["order"], part["phase"], part["mark"]
            other = self._marks.setdefault(key, row["file"]) if part["mark"] else row["file"]
            if other == row["file"]:
                continue
            both = (*self._parts_of(other), *self._parts_of(row["file"]))
            wrong = [one for one in other_content(both) if one["found"] == part["mark"]]
            if wrong:
                row["status"], row["parts"] = "refused", []
                row["messages"] += map(as_message, wrong)
                return

    def _parts_of(self, path: str) -> tuple[Part, ...]:
        """The parts of an input that was posted; none where it cannot be read any more."""
        data = read_input(path)
        if isinstance(data, Diagnostic):
            return ()
        reading = judged(read(data, path, **self._settings.reading), self._settings.request.strict)
        return marked(counted(sound(reading)), self._settings.mark_from)

    def _write_all(self, slot: QueuedInput, made: FileResult, row: FileRow) -> None:
        """Write the outputs of an input; keep in its row those that stand."""
        below = "" if self._flat else slot.input.tree.rpartition("/")[0]
        written: list[PartRow] = []
        outputs = made.outputs if row["parts"] else ()
        rests = dict(made.rests)
        of_one: list[PartRow] = []  #: the programs of a part, of several machines with all rests
        files: dict[str, bytes] = {}
        for part, (name, content) in zip(row["parts"], outputs, strict=True):
            part["output"] = f"{below}/{name}" if below else name
            of_one.append(part)
            files[part["output"]] = content
            if (rest := part["rest"]) is not None:
                content = rests[rest["output"]]
                rest["output"] = f"{below}/{rest['output']}" if below else rest["output"]
                files[rest["output"]] = content
                continue
            diagnostic, status = self._outputs.write_together(of_one, files, slot.input.path)
            if diagnostic is None:
                written += of_one
            else:
                row["status"] = status
                row["messages"].append(as_message(diagnostic))
            of_one, files = [], {}
        row["parts"] = written
        for name, content in made.refused:
            output = f"{below}/{name}" if below else name
            path = slot.input.path
            diagnostic = self._outputs.refusal(output, content, path) or self._outputs.write(
                {output: content}, path
            )
            if diagnostic is None and not self._setup.dry:
                diagnostic = KEPT.at(Source(path), found=output)
            if diagnostic is not None:
                row["messages"].append(as_message(diagnostic))

    def _warn_of_older(self, slot: QueuedInput, row: FileRow) -> None:
        """Say so if an output of an earlier run stands where this input's would be."""
        if self._settings.name is not None:
            return  # without the part there is no name to look for
        tree = os.path.basename(slot.input.tree) if self._flat else slot.input.tree
        suffixes = dict.fromkeys(machine.suffix for machine in self._settings.machines)
        self._warn_of(slot, row, (os.path.splitext(tree)[0] + suffix for suffix in suffixes))

    def _warn_of(self, slot: QueuedInput, row: FileRow, outputs: Iterable[str]) -> None:
        """Say so of each of these outputs that stands and is none of this run."""
        for output in outputs:
            stands = False
            with suppress(OSError):
                stands = os.path.lexists(os.path.join(self._folder, output))
            if stands and folded(output) not in self._claims:
                diagnostic = STALE.at(Source(slot.input.path), found=output)
                row["messages"].append(as_message(diagnostic))
