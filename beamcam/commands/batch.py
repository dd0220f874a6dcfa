"""`beamcam batch`: many files in, a folder of programs out."""

import sys

import click

from beamcam.batch import find_inputs, run
from beamcam.batch.rules import WRITE
from beamcam.commands.common import REFUSED, stop
from beamcam.commands.running import (
    Report,
    Screen,
    checked_report,
    ended_by_term,
    run_options,
    settled,
    shop_of,
    workers_of,
)
from beamcam.errors import BeamcamError, Source
from beamcam.pipeline import STANDARD_INPUT
from beamcam.report.run import as_message

STANDARD_OUTPUT = "-"
INTERRUPTED = 130  #: exit status after Ctrl-C, as shells have it


@click.command("batch")
@click.argument("inputs", nargs=-1, required=True, metavar="IN...")
@run_options
@click.option("--force", is_flag=True, help="Post unchanged inputs again too.")
@click.option(
    "--report", callback=checked_report, metavar="FILE", help="Write .json, .csv or .html; -."
)
def command(
    inputs: tuple[str, ...],
    output: str,
    machine: str | None,
    config_file: str | None,
    bar: float | None,
    job: str | None,
    name: str | None,
    flat: bool | None,
    skips: tuple[str, ...],
    strict: bool,
    no_verify: bool,
    jobs: int | None,
    scheduler: str | None,
    quiet: bool,
    verbose: bool,
    force: bool,
    report: str | None,
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
        config = settled(config_file, names)
        shop = shop_of(
            config, machine, bar, job, name, skips, strict, no_verify, report is not None
        )
        found = find_inputs(names, leave_out=(output,))
        workers = workers_of(shop, jobs or config.jobs, scheduler, len(found.inputs))
    except BeamcamError as error:
        stop(error.diagnostics)
    said = [as_message(d) for d in found.diagnostics]
    account = Report(report)
    interrupted = False
    in_one = config.flat if flat is None else flat
    with Screen(len(found.inputs), quiet, verbose) as screen, ended_by_term():
        screen.say(said)
        rows = run(found.inputs, output, shop, workers, in_one, force)
        try:
            for row in rows:
                screen.show(row)
                account.add(row)
        except KeyboardInterrupt:
            interrupted = True
        except BeamcamError as error:
            stop(error.diagnostics)
        finally:
            rows.close()
        try:
            account.write(screen.counts, said)
        except OSError as error:
            if report == STANDARD_OUTPUT:
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


def _names(inputs: tuple[str, ...]) -> tuple[str, ...]:
    """The inputs, those that standard input names in the place of `-`."""
    names: list[str] = []
    for word in inputs:
        if word == STANDARD_INPUT:
            lines = (line.rstrip("\r\n") for line in sys.stdin)
            names += [line for line in lines if line]
        else:
            names.append(word)
    return tuple(names)
