"""Shared by `batch` and `watch`: options, workers, and printing a run."""

import os
import sys
from collections import Counter
from collections.abc import Iterable, Iterator, Mapping, Sequence
from contextlib import suppress
from functools import partial
from pathlib import PurePath
from time import monotonic, perf_counter
from typing import IO, Any, Self

import click
from msgspec.structs import replace

from beamcam.arguments import check_arguments
from beamcam.batch.find import FoundInputs, Input
from beamcam.batch.names import template_fault
from beamcam.batch.pool import Here, Workers
from beamcam.batch.shares import ShareTask
from beamcam.batch.work import BatchSettings
from beamcam.commands import SETTINGS, options
from beamcam.commands.common import REFUSED, Console, say_lines
from beamcam.commands.options import refuse_usage
from beamcam.commands.parts import (
    drawing_choice,
    drawing_options,
    letter,
    member_choice,
    request_of,
    selection_options,
    torch_options,
)
from beamcam.commands.settings import machines_of_split, machines_of_stock
from beamcam.config import UNUSED
from beamcam.config.values import Config, Dask
from beamcam.errors import Diagnostic, Severity, Source
from beamcam.files import write_whole
from beamcam.machine.tables import DIALECTS
from beamcam.model.request import remnant_of
from beamcam.plain_text import json_text
from beamcam.readers import is_interruptible
from beamcam.reports.run import (
    Counts,
    FileRow,
    Message,
    as_message,
    dumped,
    ledger_line,
    loaded,
    message_line,
)
from beamcam.system import INTERRUPTED, cores


def _template(ctx: click.Context, param: click.Parameter, value: str | None) -> str | None:
    if value is not None and (fault := template_fault(value)) is not None:
        raise click.BadParameter("found {}; expected {}".format(*fault))
    return value


#: The options of a command that posts many files.
run_options = options.group(
    options.output("Folder that programs go to."),
    options.machine,
    options.by,
    options.machines,
    options.rest_as,
    options.config,
    options.bar,
    options.quantity,
    options.job_name,
    options.job_date,
    click.option(
        "--name", callback=_template, metavar="TEMPLATE", help='As "{mark}_{quantity}.gcode".'
    ),
    click.option(
        "--flat/--tree",
        default=None,
        help="Write all outputs to one folder, or in the folder tree of the inputs.",
    ),
    options.skips,
    options.exit_left_out,
    options.order,
    options.turn,
    options.style,
    options.mark_from,
    selection_options,
    letter,
    drawing_options,
    torch_options,
    options.strict,
    options.no_verify,
    click.option("--jobs", type=click.IntRange(min=1), help="Worker processes; default all cores."),
    click.option("--scheduler", metavar="ADDRESS", help="Work on this Dask cluster."),
    click.option(
        "--json", "as_json", is_flag=True, help="Print only the outcome of each file, as JSON.",
    ),
    options.verbosity,
)  # fmt: skip


def batch_settings(
    config: Config, options: Mapping[str, Any], timed: bool = False
) -> BatchSettings:
    """Everything that determines the outputs: the job's configuration and reading options.

    Raises MachineError, ConfigError and PlanError; UsageError for names that programs cannot have.
    """
    name = config.name or ""
    check_arguments(config.job, None, config.allow_skips)
    if config.split:
        excluded = "found {} with --machines; expected {}.".format
        refuse_usage(
            (options.get("machine"), excluded("--machine", "one of the two")),
            (config.quantity,
             excluded("a quantity", "programs of one piece, each run as often as needed")),
            (options.get("turn"), excluded("--turn", "parts as they were read")),
            (options.get("no_verify"), excluded("--no-verify", "programs that are read back")),
        )  # fmt: skip
        bars, *more_bars = machines_of_split(config)
        sheets, more_sheets = bars, []
    else:
        bars, *more_bars = machines_of_stock(config, "beam", name, is_one_of_two=True)
        sheets, *more_sheets = machines_of_stock(
            config, "sheet", name, is_one_of_two=bars.torch is not None
        )
    for machine in (bars, sheets, *more_bars, *more_sheets):
        suffix = PurePath(name.replace("{suffix}", machine.suffix)).suffix
        if name and machine.controller == "stepper" and suffix != machine.suffix:
            raise click.UsageError(
                f"found {name!r} for names of {machine.name}; expected them to end with "
                f"{machine.suffix}, post writes the other forms of its table"
            )
    style = options.get("style")
    of_sheets = [m for m in (sheets, *more_sheets, *more_bars) if m.torch is not None]
    if style is not None and {one.controller for one in of_sheets} - {*DIALECTS}:
        raise click.UsageError(f"--style is not for {sheets.name}.")
    request = replace(
        request_of((), config, bars, config.quantity, options),
        verified=not options["no_verify"], date=options.get("date") or "", style=style,
    )  # fmt: skip
    return BatchSettings(
        request, config.name, None if sheets == bars else sheets,
        drawing_choice(options, config) | member_choice(options, kernel=True, workers=1),
        timed=timed, clock=perf_counter, more=(*more_bars, *more_sheets),
        mark_from=options.get("mark_from", "mark"),
        remnants=tuple(map(remnant_of, options.get("remnants", ()))),
        rest_suffix=f".{options.get('rest_as', 'nc1')}" if config.split else "",
    )  # fmt: skip


def settings_note(config: Config, settings: BatchSettings) -> tuple[Diagnostic, ...]:
    """Whose configuration and machines a run has, for its report."""
    from beamcam.commands.configuration import reference, settings_line

    names = [reference(machine, config) for machine in settings.machines]
    return (SETTINGS.at(Source("beamcam"), found=settings_line(config, names)),)


def unused(inputs: FoundInputs, config: Config) -> tuple[Diagnostic, ...]:
    """A warning for each configuration among the inputs that is not the one of the run."""
    used = {os.path.realpath(path) for path in config.files}
    others = (path for path in inputs.configurations if os.path.realpath(path) not in used)
    return tuple(UNUSED.at(Source(path)) for path in others)


def unmatched_keys(config: Config, counts: Counts) -> tuple[Diagnostic, ...]:
    """A note for each key of the job's map that no drawing of a whole run has curves for."""
    if not config.map or not counts.mapped:
        return ()
    from beamcam.planning.left_out import idle

    return tuple(idle(config.map, counts.mapped, config.sources.get("map", Source("--map"))))


#: An input of more, as a drawing of hundreds of curves, may take longer than who stops a run waits.
QUICK_BYTES = 32 * 1024
#: Of fewer inputs all go to the cluster: they would wait for it anyway.
FILES_OF_HEAD_START = 32


def workers_of(
    settings: BatchSettings, jobs: int | None, dask: Dask, inputs: Sequence[Input]
) -> Workers:
    """The workers for some files: a cluster, processes up to the number of cores, or this process.

    What may take long goes to another process, even a single file: there it can be ended at once.
    Raises SchedulerError.
    """
    if dask.scheduler is not None:
        from beamcam.batch.cluster import Cluster

        connect = partial(Cluster, settings, dask.scheduler, dask.answer_s, dask.chunks)
        if len(inputs) < FILES_OF_HEAD_START:
            return connect()
        from beamcam.batch.pool import HeadStart

        return HeadStart(settings, len(inputs), connect)
    count = min(jobs or cores(), len(inputs))
    if count <= 1 and all(_is_quick(one.path) for one in inputs):
        return Here(settings)
    from beamcam.batch.pool import Processes

    return Processes(settings, max(count, 1))


def _is_quick(path: str) -> bool:
    """Whether posting a file takes a moment."""
    with suppress(OSError, ValueError):
        return is_interruptible(path) and os.path.getsize(path) <= QUICK_BYTES
    return True


#: Messages of one code that a run prints one by one; thousands would hide what is different.
SHOWN_OF_A_CODE = {"error": 20, "warning": 1, "note": 1}


class Progress:
    """Prints a run: messages, a line for each file if wanted, and a bar on a terminal."""

    WIDTH = 30
    EVERY_S = 0.1

    def __init__(self, total: int | None, console: Console) -> None:
        self.counts = Counts()
        self._total, self._console = total, console
        self._json_rows = console.as_json and total is None
        # A note is harmless, and thousands of them would hide what is not.
        self._wanted = {
            severity.value
            for severity in Severity
            if console.wants(severity) and (console.verbose or severity is not Severity.NOTE)
        }
        self._bar = total is not None and console.for_people and sys.stderr.isatty()
        self._drawn = -1.0
        self._said: Counter[tuple[str, str]] = Counter()  #: messages by severity and code

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self._clear()

    def show(self, row: FileRow) -> None:
        """Count a file and print what there is to be said about it."""
        self.counts.add(row)
        if self._console.as_json:
            if self._json_rows:  # a run without an end has no account that could be one text
                click.echo(json_text(dumped(row).decode("utf-8", "surrogateescape")))
            if self._console.verbose:
                self._console.did("; ".join(line.strip() for line in account_lines(row)))
            return
        lines = [message_line(m) for m in row["messages"] if self._is_shown(m)]
        if self._console.verbose:
            lines += account_lines(row)
        elif self._total is None and not self._console.quiet:
            lines.append(what_became_of(row))  # who watches sees what is done
        if lines:
            self._clear()
            say_lines(lines, err=True)
        if self._bar:
            self._draw()

    def _is_shown(self, message: Message) -> bool:
        """Whether a message of a file is printed: of one code the first ones only.

        All are in the report, and under --verbose; `watch` has no end at which to print a count.
        """
        if message["severity"] not in self._wanted:
            return False
        if self._console.verbose or self._total is None:
            return True
        kind = message["severity"], message["code"]
        self._said[kind] += 1
        return self._said[kind] <= SHOWN_OF_A_CODE[message["severity"]]

    def _more(self) -> Iterator[str]:
        """A line for each code of which messages were not printed."""
        for (severity, code), count in self._said.items():
            more = count - SHOWN_OF_A_CODE[severity]
            if more > 0:
                yield f"{severity} {code}: {more} more; --verbose or the report shows them"

    def say(self, diagnostics: Iterable[Diagnostic]) -> None:
        """Print what is said about the run as a whole; it is little, so that notes count too."""
        for one in () if self._console.as_json else diagnostics:
            if self._console.wants(one.severity):
                self._clear()
                say_lines([message_line(as_message(one))], err=True)

    def end(self, note: str = "") -> None:
        """Print the line of counts, and what else is to be known of the run."""
        self._clear()
        say_lines(self._more(), err=True)
        self._console.tell(f"{self.counts}{note}")

    def _clear(self) -> None:
        if self._bar and self._drawn >= 0:
            click.echo("\r\x1b[K", nl=False, err=True)
            self._drawn = -1.0

    def _draw(self) -> None:
        now = monotonic()
        if self._total and now - self._drawn >= self.EVERY_S:
            done = self.counts.total
            full = done * self.WIDTH // self._total
            bar = "#" * full + "-" * (self.WIDTH - full)
            click.echo(f"\r\x1b[K[{bar}] {done}/{self._total}", nl=False, err=True)
            self._drawn = now


def what_became_of(row: FileRow) -> str:
    """A file in one line: "in/M58.nc1: posted M58.gcode"."""
    outputs = "".join(f" {part['output']}" for part in row["parts"])
    return f"{row['file']}: {row['status']}{outputs}"


def account_lines(row: FileRow) -> Iterator[str]:
    """What is printed of a file under --verbose: what became of it and its parts, and the time."""
    yield f"{what_became_of(row)} ({1000 * row['seconds']:.1f} ms)"
    for part in row["parts"]:
        ledger = ledger_line(part["ledger"], part["skipped_by"])
        yield f"  {part['mark']}: {ledger}"


class Report:
    """The rows of a run, kept on disk until the report is written from them."""

    def __init__(self, path: str | None) -> None:
        self.path = path
        self._rows: IO[bytes] | None = None

    def add(self, row: FileRow) -> None:
        if self.path is not None:
            if self._rows is None:
                import tempfile

                self._rows = tempfile.TemporaryFile()  # noqa: SIM115  closed by `write`
            self._rows.write(dumped(row) + b"\n")

    def write(
        self, counts: Counts, messages: Iterable[Message], settings: BatchSettings | None = None,
        jobs: int = 1, shares: Sequence[ShareTask] = (),
    ) -> None:  # fmt: skip
        """Write the report in the format that its name says; `-` prints JSON.

        A page has a setup sheet for each program beside it, made as `settings` says; `shares` are
        those of a run over stock. Raises OSError.
        """
        if self.path is None:
            return
        from beamcam.reports.run import as_json

        suffix = PurePath(self.path).suffix.lower()
        pieces: Iterable[bytes]
        if suffix == ".csv":
            from beamcam.reports.run import as_csv

            # A table has rows of files and of what is wrong, for programs that read it.
            rows = [one for one in messages if one["code"] != SETTINGS.code]
            pieces = as_csv(self._read(), counts, rows)
        elif suffix == ".html":
            from beamcam.reports.run_page import as_html

            beside: tuple[Any, ...] = ()
            if settings is not None:
                from beamcam.batch.sheets import picture_style, sheets_beside

                sheets = sheets_beside(self.path, self._read(), settings, jobs, shares)
                beside = sheets, picture_style()
            pieces = as_html(self._read, counts, messages, *beside)
        else:
            pieces = as_json(self._read(), counts, messages)
        if self.path == "-":
            for piece in pieces:
                click.echo(piece, nl=False)
        else:
            write_whole(self.path, pieces)
        if self._rows is not None:
            self._rows.close()

    def _read(self) -> Iterator[FileRow]:
        if self._rows is not None:
            self._rows.seek(0)
            yield from map(loaded, self._rows)


def end_run(counts: Counts, interrupted: bool, left_out: int | None, refused: bool = False) -> None:
    """Exit with the status of a run, if it has one; `left_out` is that of what is left out."""
    if interrupted:
        raise SystemExit(INTERRUPTED)
    if refused or counts.refused or counts.failed:
        raise SystemExit(REFUSED)
    if counts.not_made and left_out is not None:
        raise SystemExit(left_out)
