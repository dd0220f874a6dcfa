"""The golden programs that a batch made: posted again as its record says, and compared."""

import os
from collections.abc import Iterator, Mapping, Sequence
from contextlib import suppress
from hashlib import sha256
from pathlib import Path
from typing import Any

import click

from beamcam.batch import LINK
from beamcam.batch.find import Input, read_input
from beamcam.batch.over_stock import StockRun
from beamcam.batch.pool import Here
from beamcam.batch.record import (
    RECORD_NAME,
    Noted,
    Record,
    asked_again,
    is_within,
    noted_in,
    partly,
    path_below,
    rests_of,
)
from beamcam.batch.run import RunSetup
from beamcam.batch.work import BatchSettings, Task, make_all
from beamcam.commands import GONE, NEW
from beamcam.commands.golden import Checked, compared, named, sample_of
from beamcam.commands.running import batch_settings
from beamcam.commands.settings import settled_again
from beamcam.comparison.pairing import Difference
from beamcam.errors import BeamcamError, Diagnostic, ReadError, Source
from beamcam.files import remove_made, write_whole
from beamcam.machine import Machine
from beamcam.planning.manual_list import LIST_BEGIN, LIST_SUFFIX, ManualRow, as_csv
from beamcam.reports.run import FileRow, as_message

DEFAULT_SAMPLES = Path("samples")


def record_folders(folder: Path) -> tuple[Path, ...]:
    """The folders that hold a record: those at and below `folder`, else the nearest above."""
    below = sorted(path.parent for path in folder.rglob(RECORD_NAME))
    if below:
        return tuple(below)
    folder_of_record = next(
        (one for one in folder.resolve().parents if (one / RECORD_NAME).is_file()), None
    )
    return () if folder_of_record is None else (Path(os.path.relpath(folder_of_record)),)


class Recorded:
    """The programs of one record, and how they are posted again."""

    def __init__(
        self, folder: Path, samples: Path | None, options: Mapping[str, Any], update: bool
    ) -> None:
        """`options` holds what the command line asks for, over what the record says."""
        self._folder, self._samples, self._asked, self._update = folder, samples, options, update
        self._shops: dict[str, tuple[bool, BatchSettings] | BeamcamError] = {}
        self._noted = noted_in(str(folder))
        self._known = {part["output"] for noted in self._noted for part in noted.row["parts"]}

    @property
    def paths(self) -> frozenset[Path]:
        """The programs that the record knows, and the rests between them."""
        return frozenset(
            self._path(name) for one in self._noted for name in (*one.outputs, *rests_of(one))
        )

    def machines(self) -> dict[str, Machine]:
        """The machine of each program that the record knows, as far as it can be had."""
        machines: dict[str, Machine] = {}
        for noted in self._noted:
            with suppress(BeamcamError):
                outputs = (part["output"] for part in noted.row["parts"])
                made_on = machines_of(noted.row, self._settings(noted)[1])
                machines |= dict(zip(outputs, made_on, strict=True))
        return machines

    def check(self, below: Path) -> Iterator[Checked]:
        """The outcome of each program below a folder. Raises OSError."""
        refused: set[str] = set()  #: recipes
        over_stock: dict[str, list[Noted]] = {}
        for noted in self._noted:
            if not any(self._path(n).resolve().is_relative_to(below.resolve())
                       for n in noted.outputs):  # fmt: skip
                continue
            name = noted.recipe.name
            try:
                flat, settings = self._settings(noted)
            except BeamcamError as error:
                if name not in refused:  # once for all that were made so
                    yield _refused(str(self._folder), error.diagnostics)
                refused.add(name)
                continue
            if noted.recipe.asked.get("nest"):
                over_stock.setdefault(name, []).append(noted)
            else:
                yield from self._input(noted, flat, settings)
        for of_run in over_stock.values():
            yield from self._over_stock(of_run, self._settings(of_run[0])[1])

    def _over_stock(self, of_run: Sequence[Noted], settings: BatchSettings) -> Iterator[Checked]:
        """The outcome of the programs of a run over stock, all of whose files are read again."""
        inputs = [
            Input(path_below(str(self._folder), path), os.path.basename(path))
            for path in of_run[0].recipe.asked.get("inputs", ())
        ]
        run = StockRun(inputs, RunSetup(str(self._folder), settings, Here(settings), dry=True))
        try:
            messages = [one for row in run.planned() for one in row["messages"]]
        except BeamcamError as error:
            yield _refused(str(self._folder), error.diagnostics)
            return
        results = make_all(run.tasks, settings)
        made = {task.name: one for task, one in zip(run.tasks, results, strict=True)}
        for noted in of_run:
            (name,) = noted.outputs
            one = made.get(name)
            row: FileRow = (
                {**noted.row, "parts": [], "messages": messages} if one is None else one.row
            )
            new = {} if one is None else dict(one.outputs)
            yield from self._outputs(noted, row, new, machines_of(row, settings))
            before, now = ({part["sha256"] for part in r["parts"]} for r in (noted.row, row))
            if self._update and new and now != before:
                self._note(noted, row, tuple(new), path_below(str(self._folder), noted.input))
        for name, one in made.items():
            if name not in self._known:
                for called, content in one.outputs:
                    yield self._is_new(called, content, one.row["parts"][0]["by_hand"])

    def _path(self, output: str) -> Path:
        return self._folder / output

    def _settings(self, noted: Noted) -> tuple[bool, BatchSettings]:
        """Whether all outputs lie in one folder, and how they were made. Raises BeamcamError."""
        name = noted.recipe.name
        if name not in self._shops:
            files, again = asked_again(noted.recipe, str(self._folder))
            given = {n: value for n, value in self._asked.items() if value is not None}
            from beamcam.commands.batch import command

            unasked: click.Context = command.make_context("batch", ["in", "-o", "out"])
            options = {**unasked.params, **again, **given}
            try:
                if "machine" in given:  # in place of all that the record names
                    options["machines"] = None
                named = (options.get("machine"), *(options.get("machines") or ()))
                strange = (name for name in named if name and name not in given.values())
                config = settled_again(options, files, strange)
                self._shops[name] = bool(config.flat), batch_settings(config, options)
            except BeamcamError as error:
                self._shops[name] = error
        shop = self._shops[name]
        if isinstance(shop, BeamcamError):
            raise shop
        return shop

    def _input(self, noted: Noted, flat: bool, settings: BatchSettings) -> Iterator[Checked]:
        """The outcome of the programs of one input."""
        for name in noted.outputs:
            if not is_within(str(self._folder), name):
                at = str(self._path(name))
                diagnostic = LINK.at(Source(at), found=name, to=os.path.realpath(at))
                yield _refused(at, (diagnostic,))
                return
        try:
            sample = self._sample(noted)
        except ReadError as error:
            shown = named([str(self._path(name)) for name in noted.outputs])
            yield Checked(shown, "missing", (), tuple(map(as_message, error.diagnostics)))
            return
        data = read_input(sample)
        if isinstance(data, Diagnostic):
            yield _refused(str(self._path(noted.outputs[0])), (data,))
            return
        (made,) = make_all((Task(0, sample, data),), settings)
        below = "" if flat else noted.tree.rpartition("/")[0]
        new, rests = (
            {f"{below}/{name}" if below else name: content for name, content in of}
            for of in (made.outputs, made.rests)
        )
        for part in made.row["parts"]:
            if (rest := part["rest"]) is not None and below:
                rest["output"] = f"{below}/{rest['output']}"
        yield from self._outputs(noted, made.row, new, machines_of(made.row, settings))
        yield from self._rests(noted, rests)
        now, before = ({part["sha256"] for part in row["parts"]} for row in (made.row, noted.row))
        if self._update and (now != before or not new.keys() <= self._known):
            self._note(noted, made.row, tuple(new), sample)

    def _outputs(
        self, noted: Noted, row: FileRow, new: dict[str, bytes], machines: Sequence[Machine]
    ) -> Iterator[Checked]:
        of_name = dict(zip(new, machines, strict=True))
        manual_work = dict(zip(new, (part["by_hand"] for part in row["parts"]), strict=True))
        known = [part["output"] for part in noted.row["parts"]]
        messages = tuple(m for m in row["messages"] if m["severity"] == "error")
        for name in noted.outputs:
            path = self._path(name)
            stands = path.is_file()
            if name in new and stands:
                data = path.read_bytes()
                yield compared(str(path), data, new[name], of_name[name], manual_work[name])
            elif name in new:
                yield self._is_new(name, new[name], manual_work[name])
            elif stands and messages:
                yield Checked(str(path), "refused", (), messages)
                messages = ()  # it is said once for the input
            elif stands and self._update and len(new) == len(known):
                path.unlink()  # the program has another name now, which is written
            elif stands:
                yield _refused(str(path), [GONE.at(Source(str(path)), found=name)])
        more = (name for name in new if name not in self._known)
        yield from (self._is_new(name, new[name], manual_work[name]) for name in more)

    def _rests(self, noted: Noted, new: Mapping[str, bytes]) -> Iterator[Checked]:
        """What lies otherwise between the programs of an input than it is made now."""
        for name in dict.fromkeys((*rests_of(noted), *new)):
            path = self._path(name)
            if name not in new:
                if path.is_file() and self._update:
                    path.unlink()  # no machine is the next one now
                elif path.is_file():
                    yield _refused(str(path), [GONE.at(Source(str(path)), found=name)])
            elif not path.is_file():
                yield self._is_new(name, new[name], ())
            elif path.read_bytes() != new[name]:
                text = f"{path.name}: found another part in the making than is left now"
                changed = Difference("feature", "changed", text)
                yield Checked(str(path), "differs", (changed,), (), new[name])

    def _is_new(self, name: str, content: bytes, manual_work: Sequence[ManualRow]) -> Checked:
        path = str(self._path(name))
        message = as_message(NEW.at(Source(path), found=name))
        return Checked(path, "differs", (), (message,), content, manual_work)

    def _sample(self, noted: Noted) -> str:
        """The path of an input as it is now. Raises ReadError."""
        samples = self._samples or DEFAULT_SAMPLES
        if self._samples is None:
            own = path_below(str(self._folder), noted.input)
            if os.path.isfile(own):
                return own
        if (samples / noted.tree).is_file():
            return str(samples / noted.tree)
        stem, suffix = os.path.splitext(os.path.basename(noted.input))
        return str(sample_of(samples, stem, str(self._path(noted.outputs[0])), suffix.lower()))

    def _note(self, noted: Noted, row: FileRow, outputs: tuple[str, ...], sample: str) -> None:
        """Let the record know programs that have other names now, or are new."""
        for part, output in zip(row["parts"], outputs, strict=True):
            part["output"] = output
        record = Record(str(self._folder), noted.recipe)
        try:
            key = partly(sha256("\0".join(outputs).encode("utf-8", "backslashreplace")).digest())
            record.add(key, row, Input(sample, noted.tree))
        finally:
            record.close()


def accept(results: Sequence[Checked]) -> tuple[Checked, ...]:
    """Write every program that is another now in the place of its golden one. Raises OSError."""
    for one in results:
        if one.new is not None:
            os.makedirs(os.path.dirname(one.path) or os.curdir, exist_ok=True)
            write_whole(one.path, one.new)
            if one.manual_work:
                write_whole(one.path + LIST_SUFFIX, as_csv(one.manual_work))
            else:
                remove_made(one.path + LIST_SUFFIX, LIST_BEGIN)
    return tuple(one for one in results if one.new is None)


def machines_of(row: FileRow, settings: BatchSettings) -> list[Machine]:
    """The machine of each program of an input."""
    return [settings.machine_named(part["machine"]) for part in row["parts"]]


def _refused(path: str, diagnostics: Sequence[Diagnostic]) -> Checked:
    return Checked(path, "refused", (), tuple(map(as_message, diagnostics)))
