"""What `batch` and `watch` share: their options, their workers, and how they print a run."""

import os
import sys
import tempfile
from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager
from pathlib import PurePath
from time import monotonic, perf_counter
from types import TracebackType
from typing import IO, Any, Self

import click

from beamcam.batch import Here, Processes, Shop, Workers, check_template
from beamcam.config import Config, apply_tolerances, find, load
from beamcam.files import write_whole
from beamcam.machine import load as load_machine
from beamcam.pipeline import DEFAULT_MACHINE
from beamcam.planning import SKIP_NAMES
from beamcam.report.run import Counts, Message, Row, dumped, encoded, message_line

REPORTS = (".json", ".csv", ".html")
Function = Callable[..., Any]


def _template(ctx: click.Context, param: click.Parameter, value: str | None) -> str | None:
    if value is not None:
        try:
            check_template(value)
        except ValueError as error:
            raise click.BadParameter(str(error)) from error
    return value


def checked_report(ctx: click.Context, param: click.Parameter, value: str | None) -> str | None:
    if value not in (None, "-") and not value.lower().endswith(REPORTS):
        raise click.BadParameter(f"found {value!r}; expected a name in {', '.join(REPORTS)}, or -")
    return value


def _machines(ctx: click.Context, param: click.Parameter, incomplete: str) -> list[str]:
    from beamcam.machine import shipped

    return [name for name in shipped() if name.startswith(incomplete)]


_OPTIONS = (
    click.option("-o", "--output", required=True, metavar="FOLDER", help="Where programs go."),
    click.option("--machine", shell_complete=_machines, help="Name or TOML file."),
    click.option("--config", "config_file", metavar="FILE", help="Instead of beamcam.toml."),
    click.option("--bar", type=click.FloatRange(min=0, min_open=True), help="Length of bars, mm."),
    click.option("--job", help="Name in each program's first line."),
    click.option(
        "--name", callback=_template, metavar="TEMPLATE", help='As "{mark}_{quantity}.gcode".'
    ),
    click.option("--flat/--tree", default=None, help="All outputs in one folder, or as inputs."),
    click.option(
        "--allow-skips",
        "skips",
        multiple=True,
        type=click.Choice(SKIP_NAMES),
        help="Leave out what the machine cannot make, of this kind only; may be repeated.",
    ),
    click.option("--strict", is_flag=True, help="Let warnings refuse a part as errors do."),
    click.option("--no-verify", is_flag=True, help="Do not read programs back; they say so."),
    click.option("--jobs", type=click.IntRange(min=1), help="Worker processes; default all cores."),
    click.option("--scheduler", metavar="ADDRESS", help="Work on this Dask cluster."),
    click.option("-q", "--quiet", is_flag=True, help="Print errors only."),
    click.option("-v", "--verbose", is_flag=True, help="Print a line for every file."),
)


def run_options(function: Function) -> Function:
    """The options of a command that posts many files."""
    for option in reversed(_OPTIONS):
        function = option(function)
    return function


def settled(config_file: str | None, inputs: Iterable[str]) -> Config:
    """The configuration of a run, the templates and names in it checked. Raises ConfigError."""
    config = load(config_file if config_file is not None else find(inputs))
    for key, check in (("name", _check_name), ("allow_skips", _check_skips)):
        value = getattr(config, key)
        if value and (expected := check(value)):
            from beamcam.config import ConfigError
            from beamcam.config.rules import WRONG_VALUE

            said = WRONG_VALUE.at(
                config.sources[key], key=key, found=repr(value), expected=expected
            )
            raise ConfigError(said)
    return config


def _check_name(template: str) -> str:
    try:
        check_template(template)
    except ValueError as error:
        return str(error).partition("; expected ")[2]
    return ""


def _check_skips(skips: tuple[str, ...]) -> str:
    known = ", ".join(SKIP_NAMES)
    return "" if set(skips) <= set(SKIP_NAMES) else f"names of {known}"


def shop_of(
    config: Config,
    machine: str | None,
    bar: float | None,
    job: str | None,
    name: str | None,
    skips: tuple[str, ...],
    strict: bool,
    no_verify: bool,
    timed: bool = False,
) -> Shop:
    """What decides about the outputs: the command line over the configuration.

    Raises MachineError and ConfigError.
    """
    loaded = load_machine(machine or config.machine or DEFAULT_MACHINE)
    return Shop(
        apply_tolerances(loaded, config),
        job or config.job,
        bar,
        () if bar is not None else config.stock_lengths,
        tuple(sorted({*skips, *config.allow_skips})),
        strict or config.strict,
        not no_verify,
        name if name is not None else config.name,
        tuple(sorted(config.map.items())),
        timed=timed,
        clock=perf_counter,
    )


def workers_of(shop: Shop, jobs: int | None, scheduler: str | None, most: int) -> Workers:
    """Who does the work: a cluster, as many processes as there are cores, or this process.

    `most` is the number of files, and no more workers are of use. Raises SchedulerError.
    """
    if scheduler is not None:
        from beamcam.batch.cluster import Cluster

        return Cluster(shop, scheduler)
    count = min(jobs or cores(), most)
    return Processes(shop, count) if count > 1 else Here(shop)


def cores() -> int:
    """How many cores this process may use."""
    if hasattr(os, "sched_getaffinity"):
        return len(os.sched_getaffinity(0))
    return os.cpu_count() or 1


class Screen:
    """Prints a run: messages, a line for each file if wanted, and a bar on a terminal."""

    WIDTH = 30
    EVERY_S = 0.1

    def __init__(self, total: int | None, quiet: bool, verbose: bool) -> None:
        self.counts = Counts()
        self._total, self._quiet, self._verbose = total, quiet, verbose
        self._bar = total is not None and not quiet and sys.stderr.isatty()
        self._drawn = -1.0

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        at: TracebackType | None,
    ) -> None:
        self._clear()

    def show(self, row: Row) -> None:
        """Count a file and print what there is to be said about it."""
        self.counts.add(row)
        lines = [message_line(m) for m in row["messages"] if self._wanted(m)]
        if self._verbose:
            outputs = ", ".join(part["output"] for part in row["parts"])
            lines.append(f"{row['file']}: {row['status']}{' ' + outputs if outputs else ''}")
        if lines:
            self._clear()
            click.echo("\n".join(lines), err=True)
        self._draw()

    def say(self, messages: Iterable[Message]) -> None:
        """Print what is said about the run as a whole."""
        for said in messages:
            if self._wanted(said):
                self._clear()
                click.echo(message_line(said), err=True)

    def end(self, interrupted: bool = False) -> None:
        """Print the line of counts."""
        self._clear()
        if not self._quiet:
            click.echo(f"{self.counts}{' (interrupted)' if interrupted else ''}", err=True)

    def _wanted(self, said: Message) -> bool:
        if self._quiet:
            return said["severity"] == "error"
        # A note is harmless, and thousands of them would hide what is not.
        return self._verbose or said["severity"] != "note"

    def _clear(self) -> None:
        if self._bar and self._drawn >= 0:
            click.echo("\r\x1b[K", nl=False, err=True)
            self._drawn = -1.0

    def _draw(self) -> None:
        now = monotonic()
        if self._bar and self._total and now - self._drawn >= self.EVERY_S:
            done = self.counts.total
            full = done * self.WIDTH // self._total
            bar = "#" * full + "-" * (self.WIDTH - full)
            click.echo(f"\r\x1b[K[{bar}] {done}/{self._total}", nl=False, err=True)
            self._drawn = now


class Report:
    """The rows of a run, kept on disk until the report is written from them."""

    def __init__(self, path: str | None) -> None:
        self.path = path
        self._rows: IO[bytes] | None = None

    def add(self, row: Row) -> None:
        if self.path is not None:
            if self._rows is None:
                self._rows = tempfile.TemporaryFile()  # noqa: SIM115  closed by `write`
            self._rows.write(encoded(dumped(row) + "\n"))

    def write(self, counts: Counts, said: Iterable[Message]) -> None:
        """Write the report in the format that its name says; `-` prints JSON. Raises OSError."""
        if self.path is None:
            return
        from beamcam.report.run import as_json

        suffix = PurePath(self.path).suffix.lower()
        made = as_json
        if suffix == ".csv":
            from beamcam.report.run_table import as_csv as made
        elif suffix == ".html":
            from beamcam.report.run_page import as_html as made
        pieces = made(self._read(), counts, said)
        if self.path == "-":
            for piece in pieces:
                click.echo(piece, nl=False)
        else:
            write_whole(self.path, pieces)
        if self._rows is not None:
            self._rows.close()

    def _read(self) -> Iterator[Row]:
        import json

        if self._rows is not None:
            self._rows.seek(0)
            yield from map(json.loads, self._rows)


@contextmanager
def ended_by_term() -> Iterator[None]:
    """Let SIGTERM end a run as Ctrl-C does, so that it closes what it has open and counts."""
    import signal

    def interrupt(*_: object) -> None:
        raise KeyboardInterrupt

    before = signal.signal(signal.SIGTERM, interrupt)
    try:
        yield
    finally:
        signal.signal(signal.SIGTERM, before)
