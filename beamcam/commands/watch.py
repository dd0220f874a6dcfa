"""`beamcam watch`: a hot folder."""

import os
import time
from typing import Any

import click

from beamcam.batch import NO_END, NOTHING, WRITE
from beamcam.batch.find import Input, find_inputs
from beamcam.batch.names import MarkKey
from beamcam.batch.recipe import recipe_of
from beamcam.batch.record import claims_of
from beamcam.batch.run import BatchError, run
from beamcam.commands import options
from beamcam.commands.common import Console, Grouped, say_lines
from beamcam.commands.running import (
    Progress,
    batch_settings,
    end_run,
    run_options,
    unused,
    workers_of,
)
from beamcam.commands.settings import files_read, settled
from beamcam.errors import BeamcamError, Diagnostic, Source
from beamcam.reports.run import FileRow, as_message
from beamcam.system import asked_to_end
from beamcam.watch import END_S, HotFolder, file_away, look


@click.command("watch", cls=Grouped)
@click.argument("folder", metavar="IN_FOLDER", type=click.Path(exists=True, file_okay=False))
@run_options
@click.option("--done", metavar="FOLDER", help="Move posted inputs to this folder.")
@click.option(
    "--refused", metavar="FOLDER", help="Move refused inputs to this folder, each with a .txt file."
)
@click.option(
    "--settle", default=2.0, show_default=True, type=options.Number(least=0),
    help="Seconds for which a file has to be unchanged.",
)  # fmt: skip
@click.option(
    "--end-wait", default=END_S, show_default=True, type=options.Number(least=0),
    help="Seconds that a file without its end (EN, END-ISO-10303-21, EOF, </svg>, "
    "closing bracket) is left.",
)  # fmt: skip
@click.option(
    "--every", default=1.0, show_default=True, type=options.Number(least=0.01, most=86400),
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
    try:
        config = settled(values, (folder,))
        settings = batch_settings(config, values)
        console.say_remarks()
        for place in (output, done, refused):
            if place is not None:
                _make(place)
    except BeamcamError as error:
        console.stop(error.diagnostics)
    hot = HotFolder(settle, end_wait)
    recipe = recipe_of(config, values, output)
    leave_out = tuple(place for place in (output, done, refused) if place is not None)
    claims = claims_of(output, folder)
    marks: dict[MarkKey, str] = {}
    last: tuple[Diagnostic, ...] = ()
    if not (console.quiet or console.as_json):
        ending = "" if once else "; Ctrl-C ends it"
        say_lines(
            [f"watching {folder} every {every:g} s, programs go to {output}{ending}"], err=True
        )
    with Progress(None, console) as progress, asked_to_end() as interrupted:
        try:
            while not interrupted:
                inputs = find_inputs((folder,), leave_out)
                # An empty folder is nothing wrong; what else there is to say is said once.
                diagnostics = tuple(d for d in inputs.diagnostics if d.code != NOTHING.code)
                diagnostics += unused(inputs, config)
                if diagnostics != last:
                    progress.say(map(as_message, diagnostics))
                    last = diagnostics
                ready = hot.take(look(inputs.inputs), time.monotonic())
                progress.say(
                    as_message(NO_END.at(Source(one.path), found=f"{end_wait:g}"))
                    for one in hot.endless
                )
                if ready:
                    workers = workers_of(settings, config.jobs, config.dask, ready)
                    read = files_read(config, (one.path for one in ready))
                    rows = run(
                        ready, output, settings, workers, config.flat, claims=claims, read=read,
                        recipe=recipe, interrupt=interrupted, marks=marks,
                    )  # fmt: skip
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
        except BeamcamError as error:
            console.stop(error.diagnostics)
        progress.end()
    end_run(progress.counts, bool(interrupted), exit_left_out)


def _make(folder: str) -> None:
    try:
        os.makedirs(folder, exist_ok=True)
    except OSError as error:
        reason = error.strerror or str(error)
        raise BatchError(WRITE.at(Source(folder), found=folder, reason=reason)) from error


def _file_away(
    found: Input,
    row: FileRow,
    hot: HotFolder,
    done: str | None,
    refused: str | None,
    progress: Progress,
) -> None:
    """Move an input to where it belongs now; one that failed is tried again later."""
    if row["status"] == "failed":
        hot.again(found, time.monotonic())
        return
    place = refused if row["status"] == "refused" else done
    if place is None or not hot.is_as_seen(found):
        return
    try:
        file_away(found, place, row if row["status"] == "refused" else None)
    except OSError as error:
        diagnostic = WRITE.at(Source(found.path), found=place, reason=error.strerror or str(error))
        progress.say([as_message(diagnostic)])
