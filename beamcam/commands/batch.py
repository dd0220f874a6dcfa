"""`beamcam batch`: many files in, a folder of programs out."""

import sys
from typing import Any

import click

from beamcam.batch import find_inputs, run
from beamcam.batch.rules import WRITE
from beamcam.commands import options
from beamcam.commands.common import REFUSED, STANDARD, Voice, keep_apart
from beamcam.commands.running import (
    Report,
    Screen,
    checked_report,
    ended_by_term,
    run_options,
    shop_of,
    unmatched_keys,
    unused,
    workers_of,
)
from beamcam.commands.settings import files_read, settled
from beamcam.errors import BeamcamError, Source
from beamcam.report.run import as_message
from beamcam.system import portable_path

INTERRUPTED = 130  #: exit status after Ctrl-C, as shells have it


@click.command("batch")
@click.argument("inputs", nargs=-1, required=True, metavar="IN...", type=options.FILE)
@run_options
@click.option("--force", "redo", is_flag=True, help="Post unchanged inputs again too.")
@click.option(
    "--report", callback=checked_report, metavar="FILE", help="Write .json, .csv or .html; -."
)
def command(
    inputs: tuple[str, ...],
    output: str,
    scheduler: str | None,
    redo: bool,
    report: str | None,
    exit_left_out: int | None,
    voice: Voice,
    **asked: Any,
) -> None:
    """Turn folders, patterns and files of parts into a folder of programs.

    IN is a folder (with all folders in it), a file, a pattern in quotes, or - for names from
    standard input, one a line. Each part is posted by itself, as post would. A file that is
    refused stops no other; an input that is unchanged since the last run is not done again.

    The name of an output is made of {stem}, {mark}, {quantity}, {number}, {profile}, {grade},
    {order}, {drawing}, {phase}, {machine} and {suffix}.

    \b
    beamcam batch jobs -o programs
    beamcam batch jobs 'more/**/*.nc1' -o programs --jobs 4 --report report.html
    beamcam batch jobs -o programs --flat --name '{mark}_{quantity}.gcode'
    find . -newer stamp -name '*.nc1' | beamcam batch - -o programs
    """
    names = _names(inputs)
    try:
        config = settled(asked, names)
        shop = shop_of(config, asked, timed=report is not None)
        found = find_inputs(names, leave_out=(output,))
        workers = workers_of(shop, config.jobs, scheduler, len(found.inputs))
    except BeamcamError as error:
        voice.stop(error.diagnostics)
    said = [as_message(d) for d in (*found.diagnostics, *unused(found, config))]
    account = Report(report)
    read = files_read(config, (one.path for one in found.inputs))
    if report is not None:
        keep_apart([report], read, voice)
    interrupted = False
    with Screen(len(found.inputs), voice) as screen, ended_by_term():
        screen.say(said)
        rows = run(found.inputs, output, shop, workers, config.flat, redo, read=read)
        try:
            for row in rows:
                screen.show(row)
                account.add(row)
        except KeyboardInterrupt:
            interrupted = True
        except BeamcamError as error:
            voice.stop(error.diagnostics)
        finally:
            rows.close()
        unmatched = [as_message(d) for d in unmatched_keys(config, screen.counts)]
        screen.say(unmatched)
        said += unmatched
        try:
            account.write(screen.counts, said)
        except OSError as error:
            if report == STANDARD:
                raise  # whoever reads it has gone, and there is no one to tell
            reason = error.strerror or str(error)
            unwritten = as_message(WRITE.at(Source(str(report)), found=report, reason=reason))
            screen.say([unwritten])
            said.append(unwritten)
        screen.end(interrupted)
    if interrupted:
        raise SystemExit(INTERRUPTED)
    if screen.counts.refused or screen.counts.failed or any(m["severity"] == "error" for m in said):
        raise SystemExit(REFUSED)
    if screen.counts.left_out and exit_left_out is not None:
        raise SystemExit(exit_left_out)


def _names(inputs: tuple[str, ...]) -> tuple[str, ...]:
    """The inputs, those that standard input names in the place of `-`."""
    names: list[str] = []
    for word in inputs:
        if word == STANDARD:
            lines = (line.strip("\r\n\ufeff") for line in sys.stdin)
            names += [portable_path(line) for line in lines if line]
        else:
            names.append(word)
    return tuple(names)
