"""`beamcam watch`: a hot folder, which of its files are complete, and where they go when done.

    seen     size and time of change as before?   for long enough?   has its end?   handed over?
    M58.nc1  no: it is being written -> wait      no -> wait         no -> wait     yes -> leave it

A file that changes after it was handed over is complete again some time later.
"""

import os
import shutil
import time
from collections.abc import Callable, Iterable, Mapping
from contextlib import suppress
from itertools import chain, count
from typing import Any

import click
from msgspec import Struct
from msgspec.structs import replace

from beamcam.batch import NO_END, NOTHING, WRITE
from beamcam.batch.find import Input, find_inputs
from beamcam.batch.names import MarkKey
from beamcam.batch.record import claims_of, recipe_of
from beamcam.batch.run import RunSetup, run
from beamcam.commands import options
from beamcam.commands.common import Console
from beamcam.commands.running import (
    Progress,
    batch_settings,
    end_run,
    run_options,
    unused,
    workers_of,
)
from beamcam.commands.settings import files_read, settled
from beamcam.commands.value_types import Number
from beamcam.errors import Diagnostic, Source
from beamcam.files import write_whole
from beamcam.readers import has_end
from beamcam.reports.run import FileRow, encoded, message_line
from beamcam.system import asked_to_end

AGAIN_S = 30.0  #: after which what failed for the disk or a process is tried again
END_S = 60.0  #: after which a file without its end is handed over all the same

Stamp = tuple[int, int, int]  #: size, time of change in ns and inode of a file: they tell a change


class Sight(Struct, frozen=True):
    """A file as it was last seen."""

    stamp: Stamp
    since_s: float  #: when it was first seen so; of one to be tried again, when from
    handed: bool = False
    endless: bool = False  #: handed over though its end is missing


def look(inputs: Iterable[Input]) -> dict[Input, Stamp]:
    """The stamp of each input that is there."""
    stamps = {}
    for item in inputs:
        with suppress(OSError):  # it was taken away since the folder was listed
            at = os.stat(item.path)
            stamps[item] = at.st_size, at.st_mtime_ns, at.st_ino
    return stamps


class HotFolder:
    """State of the files of a folder between two scans."""

    def __init__(
        self, settle_s: float, end_s: float = END_S, ends: Callable[[str], bool] = has_end
    ) -> None:
        """`ends` says of a path whether the file has its end, which is waited for `end_s`."""
        self._settle_s, self._end_s, self._ends = settle_s, end_s, ends
        self._seen: dict[Input, Sight] = {}
        self.endless: tuple[Input, ...] = ()

    def take(self, stamps: Mapping[Input, Stamp], now_s: float) -> tuple[Input, ...]:
        """The inputs that are complete now, each handed over once as long as it stays the same.

        Those among them whose end was waited for in vain are then `endless`.
        """
        fresh = {}
        ready = []
        self.endless = ()
        for item, stamp in stamps.items():
            sight = self._seen.get(item)
            if sight is None or sight.stamp != stamp:
                sight = Sight(stamp, now_s)
            fresh[item] = sight
            stood_s = now_s - sight.since_s
            if sight.handed or stood_s < self._settle_s:
                continue
            endless = not (sight.endless or self._ends(item.path))
            if endless and stood_s < self._end_s:
                continue
            if endless:
                self.endless = (*self.endless, item)
            fresh[item] = replace(sight, handed=True, endless=endless or sight.endless)
            ready.append(item)
        self._seen = fresh
        return tuple(ready)

    @property
    def is_waiting(self) -> bool:
        """Whether there is a file that has not been handed over."""
        return not all(sight.handed for sight in self._seen.values())

    def again(self, item: Input, now_s: float) -> None:
        """Hand an input over again after a while, even if it has not changed."""
        self._seen[item] = replace(self._seen[item], handed=False, since_s=now_s + AGAIN_S)

    def is_as_seen(self, item: Input) -> bool:
        """Whether an input is still what was handed over."""
        return look([item]).get(item) == self._seen[item].stamp


def file_away(item: Input, folder: str, row: FileRow | None = None) -> str:
    """Move an input into `folder`, below it as below the hot folder, and give its path there.

    An older one of the name is kept and the new one numbered. With `row` its messages are written
    beside it. Raises OSError.
    """
    place = os.path.join(folder, *item.tree.split("/"))
    os.makedirs(os.path.dirname(place), exist_ok=True)
    stem, suffix = os.path.splitext(place)
    numbered = chain([place], (f"{stem}-{number}{suffix}" for number in count(2)))
    target = next(path for path in numbered if not os.path.lexists(path))
    if row is not None:
        text = "".join(message_line(message) + "\n" for message in row["messages"])
        write_whole(f"{target}.txt", encoded(text))
    shutil.move(item.path, target)
    return target


@click.command("watch", cls=options.Grouped)
@click.argument("folder", metavar="IN_FOLDER", type=click.Path(exists=True, file_okay=False))
@run_options
@click.option("--done", metavar="FOLDER", help="Move posted inputs to this folder.")
@click.option(
    "--refused", metavar="FOLDER", help="Move refused inputs to this folder, each with a .txt file."
)
@click.option(
    "--settle", default=2.0, show_default=True, type=Number(least=0),
    help="Seconds for which a file has to be unchanged.",
)  # fmt: skip
@click.option(
    "--end-wait", default=END_S, show_default=True, type=Number(least=0),
    help="Seconds that a file without its end (EN, END-ISO-10303-21, EOF, </svg>, "
    "closing bracket) is left.",
)  # fmt: skip
@click.option(
    "--every", default=1.0, show_default=True, type=Number(least=0.01, most=86400),
    help="Polling interval in seconds.",
)  # fmt: skip
@click.option("--once", is_flag=True, help="Exit once all present files have been posted.")
def command(
    folder: str, output: str, done: str | None, refused: str | None, settle: float,
    end_wait: float, every: float, once: bool, exit_left_out: int | None, console: Console,
    **values: Any,
) -> None:  # fmt: skip
    """Post the files put into IN_FOLDER as they arrive, until Ctrl-C.

    A file that is still being written is left until it stays the same for a while and has its
    end; one that changes later is posted again. What was posted before the command began is known
    and not done again. It prints the folder and the result of each file. Exit status:
    130 after Ctrl-C, 1 if a file was refused under --once.

    \b
    beamcam watch hot -o programs
    beamcam watch hot -o programs --done hot/done --refused hot/refused
    beamcam watch hot -o programs --once --settle 0
    """
    config = settled(values, (folder,))
    settings = batch_settings(config, values)
    console.say_remarks()
    leave_out = tuple(place for place in (output, done, refused) if place is not None)
    for place in leave_out:
        try:
            os.makedirs(place, exist_ok=True)
        except OSError as error:
            reason = error.strerror or str(error)
            console.stop([WRITE.at(Source(place), found=place, reason=reason)])
    hot = HotFolder(settle, end_wait)
    recipe = recipe_of(config, values, output)
    claims = claims_of(output, folder)
    marks: dict[MarkKey, str] = {}
    last: tuple[Diagnostic, ...] = ()
    ending = "" if once else "; Ctrl-C ends it"
    console.tell(f"watching {folder} every {every:g} s, programs go to {output}{ending}")
    with Progress(None, console) as progress, asked_to_end() as interrupted:
        while not interrupted:
            inputs = find_inputs((folder,), leave_out)
            # An empty folder is nothing wrong; what else there is to say is said once.
            diagnostics = tuple(d for d in inputs.diagnostics if d.code != NOTHING.code)
            diagnostics += unused(inputs, config)
            if diagnostics != last:
                progress.say(diagnostics)
                last = diagnostics
            ready = hot.take(look(inputs.inputs), time.monotonic())
            progress.say(NO_END.at(Source(one.path), found=f"{end_wait:g}") for one in hot.endless)
            if ready:
                workers = workers_of(settings, config.jobs, config.dask, ready)
                read = files_read(config, (one.path for one in ready))
                setup = RunSetup(output, settings, workers, read, recipe, interrupt=interrupted)
                rows = run(ready, setup, config.flat, claims, marks)
                try:
                    for one, row in zip(ready, rows, strict=False):
                        progress.show(row)
                        _file_away(one, row, hot, done, refused, progress)
                finally:
                    rows.close()
            elif once and not hot.is_waiting:
                break
            else:
                interrupted.wait(every)
        progress.end()
    end_run(progress.counts, bool(interrupted), exit_left_out)


def _file_away(
    item: Input, row: FileRow, hot: HotFolder, done: str | None, refused: str | None,
    progress: Progress,
) -> None:  # fmt: skip
    """Move an input to where it belongs now; one that failed is tried again later."""
    is_refused = row["status"] == "refused"
    folder = refused if is_refused else done
    if row["status"] == "failed":
        hot.again(item, time.monotonic())
    elif folder is not None and hot.is_as_seen(item):
        try:
            file_away(item, folder, row if is_refused else None)
        except OSError as error:
            reason = error.strerror or str(error)
            progress.say([WRITE.at(Source(item.path), found=folder, reason=reason)])
