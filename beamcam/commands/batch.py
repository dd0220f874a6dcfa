"""`beamcam batch`: many files in, a folder of programs out."""

import os
import sys
from collections.abc import Iterator, Mapping, Sequence
from typing import Any

import click

from beamcam.api.shop_lists import label_lines
from beamcam.batch import NOT_OURS, WRITE
from beamcam.batch.find import find_inputs
from beamcam.batch.over_stock import StockRun
from beamcam.batch.record import path_from, recipe_of
from beamcam.batch.run import RunSetup, run
from beamcam.commands import options
from beamcam.commands.common import STANDARD, Console, keep_apart, over_input, say_lines
from beamcam.commands.running import (
    Progress,
    Report,
    batch_settings,
    end_run,
    run_options,
    settings_note,
    unmatched_keys,
    unused,
    workers_of,
)
from beamcam.commands.settings import files_read, settled
from beamcam.commands.value_types import of_kind
from beamcam.config.values import Config
from beamcam.errors import BeamcamError, Diagnostic, Source, errors_in
from beamcam.files import FilesRead, write_whole
from beamcam.reports.labels import SCHEMA, Label
from beamcam.reports.labels import as_json as labels_as_json
from beamcam.reports.part_list import BARS, CUTS, PARTS, bar_list, cutting_list, part_list
from beamcam.reports.run import FileRow, as_message
from beamcam.reports.tables import as_csv
from beamcam.system import asked_to_end, cores, portable_path

FILES_A_WORKER = 20  #: of setup sheets; for fewer a process of their own is not worth its start


@click.command("batch", cls=options.Grouped)
@click.argument("inputs", nargs=-1, required=True, metavar="IN...", type=options.FILE)
@run_options
@options.remnants
@click.option(
    "--nest/--each",
    default=None,
    help="Share bars and sheets among the parts of all files, or post each part by itself; by "
    "default --nest with --bar, --remnant or --sheet.",
)
@click.option(
    "--force",
    "redo",
    is_flag=True,
    help="Post unchanged inputs again as well, and write over what was edited or is locked.",
)
@click.option(
    "--dry-run", "dry", is_flag=True, help="Show what would be written where, and write nothing."
)
@click.option(
    "--report",
    callback=of_kind("batch", without=()),
    metavar="FILE",
    help="Write .json, .csv or .html; -.",
)
def command(
    inputs: tuple[str, ...], output: str, redo: bool, dry: bool, nest: bool | None,
    report: str | None, exit_left_out: int | None, console: Console, **values: Any,
) -> None:  # fmt: skip
    """Turn folders, patterns and files of parts into a folder of programs.

    IN is a folder (with all folders in it), a file, a pattern in quotes, or - for names from
    standard input, one a line. Each part is posted by itself, as post would. A file that is
    refused stops no other; an input that is unchanged since the last run is not done again.

    With --machines each part is made on as many of them as it needs, as split would: NAME-1-MACHINE
    is the first program, NAME-1-rest.nc1 the part as the next machine gets it, and so on, all of
    them or none. A part that one of them makes has one program, called as any.

    Over stock (--bar, --remnant, --sheet, or --nest) the parts of all files share bars, those of
    one section and grade in the order given, first fit, remnants first; and plates of one thickness
    share sheets. There is a program for each bar and sheet, and beside them parts.csv, bars.csv,
    cuts.csv and labels.json. What no machine makes is on no bar; exit status 1. Two parts that
    differ under one mark of an order refuse all of it before anything is written.

    The name of an output is made of {stem}, {mark}, {quantity}, {number}, {profile}, {grade},
    {order}, {drawing}, {phase}, {machine} and {suffix}.

    \b
    beamcam batch jobs -o programs
    beamcam batch jobs -o programs --dry-run
    beamcam batch jobs -o programs --machines beamline,coper-linuxcnc
    beamcam batch order --bar 12000 --remnant UPN200=4300 --sheet 3000x1500 -o programs
    beamcam batch jobs 'more/**/*.nc1' -o programs --jobs 4 --report report.html
    beamcam batch jobs -o programs --flat --name '{mark}_{quantity}.gcode'
    find . -newer stamp -name '*.nc1' | beamcam batch - -o programs
    """
    if console.as_json and report is not None:
        raise click.UsageError("--json prints the report; give --report or --json.")
    names = _names(inputs)
    config = settled(values, names)
    over_stock = _is_over_stock(nest, values, config)
    settings = batch_settings(config, values, timed=report is not None)
    console.say_remarks()
    result = find_inputs(names, leave_out=(output,))
    workers = workers_of(settings, config.jobs, config.dask, result.inputs)
    diagnostics = [*result.diagnostics, *unused(result, config)]
    account = Report(STANDARD if console.as_json else report)
    read = files_read(config, (one.path for one in result.inputs))
    if report is not None:
        keep_apart([report], read, console)
    stock_run: StockRun | None = None
    with Progress(0 if over_stock else len(result.inputs), console) as screen:
        screen.say(diagnostics)
        diagnostics += (*config.remarks, *settings_note(config, settings))
        with asked_to_end() as interrupted:
            if over_stock:
                of = [path_from(output, one.path) for one in result.inputs]
                values |= {"nest": True, "inputs": of}
            recipe = recipe_of(config, values, output)
            setup = RunSetup(output, settings, workers, read, recipe, redo, dry, interrupted)
            if over_stock:
                stock_run = StockRun(result.inputs, setup)
            rows = stock_run.rows() if stock_run else run(result.inputs, setup, config.flat)
            try:
                for row in rows:
                    screen.show(row)
                    account.add(row)
                    if dry and console.for_people:
                        say_lines(_would(row, output))
            except BeamcamError:
                screen.end(" (not finished)")
                raise
            finally:
                rows.close()

        def say(new: Sequence[Diagnostic]) -> None:
            screen.say(new)
            diagnostics.extend(new)

        if stock_run is not None and not (interrupted or dry):
            say((*stock_run.remarks, *write_lists(stock_run, output, read, redo)))
        say(unmatched_keys(config, screen.counts))
        jobs = min(config.jobs or cores(), max(1, screen.counts.total // FILES_A_WORKER))
        shares = () if stock_run is None else stock_run.tasks
        try:
            messages = [as_message(one) for one in diagnostics]
            account.write(screen.counts, messages, None if dry else settings, jobs, shares)
        except OSError as error:
            if report == STANDARD:
                raise  # its reader has gone, and there is no one to tell
            reason = error.strerror or str(error)
            say([WRITE.at(Source(str(report)), found=report, reason=reason)])
        screen.end(
            " (interrupted)" if interrupted else " (dry run, nothing written)" if dry else ""
        )
    end_run(screen.counts, bool(interrupted), exit_left_out, bool(errors_in(diagnostics)))


def _is_over_stock(nest: bool | None, options: Mapping[str, Any], config: Config) -> bool:
    """Whether parts share bars and sheets. Raises UsageError for options that exclude it."""
    stock = [option for option, value in (
        ("--bar", options["bar"]), ("--remnant", options["remnants"]),
        ("--sheet", options["sheet_size"])
    ) if value]  # fmt: skip
    if nest is False and options["remnants"]:
        raise click.UsageError("found --each with --remnant; a remnant is shared by parts.")
    over_stock = bool(stock) if nest is None else nest
    if over_stock:
        for option, value in (("--name", options["name"]), ("--tree", options["flat"] is False)):
            if value:
                raise click.UsageError(
                    f"found {option} over stock; expected it with --each, since a program over "
                    "stock is called by its section and grade."
                )
        if config.split:
            raise click.UsageError(
                "found --machines over stock; expected it with --each, or --machine for parts that "
                "share bars and sheets."
            )
    return over_stock


def _would(row: FileRow, folder: str) -> Iterator[str]:
    """Planned result for a file: "in/M58.nc1 -> out/M58.gcode, beamline"."""
    for part in row["parts"]:
        unchanged = " (unchanged)" if row["status"] == "unchanged" else ""
        output = os.path.join(folder, part["output"])
        yield f"{row['file']} -> {output}, {part['machine']}{unchanged}"
        if part["rest"] is not None:
            rest = os.path.join(folder, part["rest"]["output"])
            yield f"{row['file']} -> {rest}, for the next machine{unchanged}"
    if not row["parts"]:
        yield f"{row['file']}: {row['status']}"


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


#: How the lists begin.
HEADS = {
    "parts.csv": ",".join(PARTS), "bars.csv": ",".join(BARS), "cuts.csv": ",".join(CUTS),
    "labels.json": SCHEMA,
}  # fmt: skip


def is_stock_list(path: str) -> bool:
    """Whether a file is such a list, by its name and its beginning."""
    head = HEADS.get(os.path.basename(path))
    return head is not None and not _is_strange(path, head)


def write_lists(run: StockRun, folder: str, read: FilesRead, force: bool) -> Iterator[Diagnostic]:
    """Write the lists into the folder of the programs; an error for each that cannot be.

    They are of parts, bars and cuts, and a label for each piece that is made. A file that is no
    such list is not written over, unless it is forced.
    """
    bars = run.bars()
    labels = [
        Label(part.mark, tuple(label_lines(part, number, of)), program)
        for part, number, of, program in run.labelled()
    ]
    contents = (
        as_csv(part_list(run.counts)), as_csv(bar_list(bars)), as_csv(cutting_list(bars)),
        labels_as_json(labels),
    )  # fmt: skip
    for name, content in zip(HEADS, contents, strict=True):
        path = os.path.join(folder, name)
        if over := over_input(path, read):
            yield over
        elif not force and _is_strange(path, HEADS[name]):
            yield NOT_OURS.at(Source(path), found=name, why="which beamcam did not make")
        else:
            try:
                write_whole(path, content)
            except OSError as error:
                yield WRITE.at(Source(path), found=name, reason=error.strerror or error)


def _is_strange(path: str, head: str) -> bool:
    """Whether a file is there that does not begin as a list does."""
    try:
        with open(path, encoding="utf-8", errors="replace") as file:
            return head not in file.read(len(head) + 100)
    except FileNotFoundError:
        return False
    except OSError:
        return True
