"""Shared by the commands: messages, output and exit."""

import os
import re
import sys
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import ExitStack, contextmanager, suppress
from time import perf_counter
from typing import TYPE_CHECKING, Any, NoReturn

import click

from beamcam.commands import ACCOUNT, CANNOT_WRITE, OVER_INPUT
from beamcam.errors import Diagnostic, Severity, Source, errors_in, first_of_each_kind
from beamcam.files import REFUSED_SUFFIX, FilesRead, write_whole
from beamcam.plain_text import json_text, terminal_text
from beamcam.system import is_reader_gone, is_unicode, taken_back

if TYPE_CHECKING:
    from beamcam.readers import Reading

REFUSED = 1  #: exit status if an input was refused
STANDARD = "-"  #: input or output
_COLOURS = {"error": "red", "warning": "yellow", "note": "cyan"}
_SEVERITY = re.compile(r"(?:^|: )(?P<word>error|warning|note) [a-z][a-z0-9-]*: ")
PATIENCE = 0.5  #: s of reading before a bar shows how far it is


class Console:
    """Messages of a command on standard error, a line each or as one JSON list.

    Quiet it says errors only; verbose also what it did and how long that took.
    """

    def __init__(self, quiet: bool = False, verbose: bool = False, as_json: bool = False) -> None:
        self.quiet, self.verbose, self.as_json = quiet, verbose, as_json
        self._account: list[Diagnostic] = []  #: what is kept for a JSON list
        self._remarks: dict[Diagnostic, bool] = {}  #: on the machine; whether they were said
        self._did: set[str] = set()  #: that is told once
        self._since = perf_counter()

    def wants(self, severity: Severity) -> bool:
        """Whether a message of that weight is said."""
        return not self.quiet or severity is Severity.ERROR

    def say(self, diagnostics: Iterable[Diagnostic]) -> None:
        """Say messages. As JSON they are one list with what was done, so this is said once."""
        diagnostics = (*self._new_remarks(), *diagnostics)
        shown = [d for d in first_of_each_kind(diagnostics) if self.wants(d.severity)]
        if self.as_json:
            from beamcam.reports.run import as_message

            say_json([as_message(d) for d in (*self._account, *shown)], None, err=True)
            self._account.clear()
        else:
            for one in shown:
                say_lines([str(one)], err=True)

    def say_remarks(self) -> None:
        """Say what is kept before the work begins; a JSON list waits for the end."""
        if not self.as_json:
            self.say(())

    def remark(self, diagnostics: Iterable[Diagnostic]) -> None:
        """Keep messages to be said with the next ones; what was said once is not said again."""
        for one in diagnostics:
            self._remarks.setdefault(one, False)

    def _new_remarks(self) -> Iterator[Diagnostic]:
        for one, is_said in self._remarks.items():
            if not is_said:
                self._remarks[one] = True
                yield one

    def did(self, what: str) -> None:
        """Tell a step that is done, and the time since the one before."""
        if not self.verbose:
            return
        now = perf_counter()
        text = f"{what} ({1000 * (now - self._since):.1f} ms)"
        self._since = now
        if self.as_json:
            self._account.append(ACCOUNT.at(Source("beamcam"), found=text))
        else:
            say_lines([text], err=True)

    def did_once(self, what: str) -> None:
        """`did`, of what several steps come by."""
        if what not in self._did:
            self._did.add(what)
            self.did(what)

    def tell(self, line: str) -> None:
        """Say what came of it, to people who want more than errors."""
        if not (self.quiet or self.as_json):
            say_lines([line], err=True)

    def end(self) -> None:
        """Say what was kept of steps and remarks, where nothing else was to be said."""
        if self._account or not all(self._remarks.values()):
            self.say(())

    def stop(self, diagnostics: Iterable[Diagnostic]) -> NoReturn:
        """Say messages and end with the status of a refused input."""
        self.say(diagnostics)
        raise SystemExit(REFUSED)

    def finish(self, diagnostics: Sequence[Diagnostic]) -> None:
        """Say messages; where an error is among them, end with the status of a refused input."""
        self.say(diagnostics)
        if errors_in(diagnostics):
            raise SystemExit(REFUSED)


def remark(diagnostics: Iterable[Diagnostic]) -> None:
    """Have the console of the running command say messages once."""
    console = running_console()
    if console is not None:
        console.remark(diagnostics)


def running_console() -> Console | None:
    """The console of the running command, if it has one."""
    context = click.get_current_context(silent=True)
    return context.meta.get(Console.__name__) if context else None


def say_lines(lines: Iterable[str], err: bool = False) -> None:
    """Print lines for people, without anything in them that a terminal obeys.

    On a terminal the severity of a message on standard error has its colour.
    """
    coloured = err and shows_colour(sys.stderr)
    for line in lines:
        text = terminal_text(line)
        click.echo(_coloured(text) if coloured else text, err=err, color=coloured or None)


def shows_colour(stream: Any) -> bool:
    """Whether text for a stream has colours: on a terminal, unless the user wants none.

    Source: no-color.org and force-color.org; a variable that is empty counts as none.
    """
    if os.environ.get("NO_COLOR"):
        return False
    if os.environ.get("FORCE_COLOR"):
        return True
    return stream.isatty() and os.environ.get("TERM") != "dumb"


def _coloured(line: str) -> str:
    """A message with the colour of its severity."""
    match = _SEVERITY.search(line)
    if match is None:
        return line
    begin, end = match.span("word")
    styled = click.style(match["word"], fg=_COLOURS[match["word"]], bold=True)
    return line[:begin] + styled + line[end:]


def as_json(value: object, indent: int | None = 1) -> str:
    """A value as JSON that a terminal can show."""
    import json

    only_ascii = not is_unicode(getattr(sys.stdout, "encoding", None))
    return json_text(json.dumps(value, ensure_ascii=only_ascii, indent=indent))


def say_json(value: object, indent: int | None = 1, err: bool = False) -> None:
    """Print a value as JSON."""
    click.echo(as_json(value, indent), err=err)


def read_all(
    inputs: Iterable[str], strict: bool, options: dict[str, object], console: Console
) -> "Iterator[Reading]":
    """Content of each input; `options` as `read_file` takes them."""
    from beamcam.pipeline import read_file
    from beamcam.readers import shown_name

    for path in inputs:
        with followed(path, console) as follow:
            reading = read_file(path, strict, **options, progress=follow)
        if console.verbose:
            features = sum(len(part.features) for part in reading.parts)
            found = f"{reading.format}, {len(reading.parts)} part(s), {features} feature(s)"
            console.did(f"read {shown_name(path)}: {found}")
        yield reading


@contextmanager
def followed(path: str, console: Console) -> Iterator[Callable[[int, int], None] | None]:
    """A bar on the terminal that follows a long reading; None where there is no terminal.

    The reader tells how far it is, of how much. The bar appears when that took `PATIENCE`.
    """
    if console.quiet or not sys.stderr.isatty():
        yield None
        return
    begun = perf_counter()
    label = terminal_text(path)
    with ExitStack() as stack:
        bars: list[Any] = []

        def follow(done: int, of: int) -> None:
            if not bars:
                if perf_counter() - begun < PATIENCE:
                    return
                stack.enter_context(taken_back(_show_cursor))
                bar = click.progressbar(length=of, label=label, file=sys.stderr)
                bars.append(stack.enter_context(bar))
            bars[0].update(done - bars[0].pos)

        yield follow


def _show_cursor() -> None:
    """What click does at the end of a bar, which hides the cursor."""
    os.write(sys.stderr.fileno(), b"\n\x1b[?25h")


def write(
    output: str, data: str | bytes | Iterable[bytes], console: Console, read: FilesRead
) -> None:
    """Write to a file, whole or not at all, or to standard output for `-`; else stop.

    `read` are the files that the command reads, none of which is written over.
    """
    if output == STANDARD:
        # Bytes, so that no system puts other line ends or another alphabet in.
        data = data.encode("utf-8") if isinstance(data, str) else data
        for piece in (data,) if isinstance(data, bytes) else data:
            click.echo(piece, nl=False)
        console.did("wrote stdout")
        return
    keep_apart([output], read, console)
    try:
        write_whole(output, data)
    except OSError as error:
        console.stop([cannot_write(output, error)])
    console.did(f"wrote {output}")


def keep_apart(outputs: Iterable[str], read: FilesRead, console: Console) -> None:
    """Stop if one of the outputs is a file that the command reads."""
    for output in outputs:
        if over := over_input(output, read):
            console.stop([over])


def over_input(output: str, read: FilesRead) -> Diagnostic | None:
    """The message for an output that is one of the input files."""
    other = None if output == STANDARD else read.written_over_by(output)
    return None if other is None else OVER_INPUT.at(Source(output), found=output, read=other)


def keep_refused(output: str, pieces: Iterable[bytes], read: FilesRead) -> Iterator[Diagnostic]:
    """Keep a program that the read-back refused beside its output, and say where it is."""
    if output == STANDARD or (os.path.exists(output) and not os.path.isfile(output)):
        return
    from beamcam.batch import KEPT

    kept = output + REFUSED_SUFFIX
    if over := over_input(kept, read):
        yield over
        return
    try:
        write_whole(kept, pieces)
    except OSError as error:
        yield cannot_write(kept, error)
    else:
        yield KEPT.at(Source(output), found=kept)


def cannot_write(output: str, error: OSError) -> Diagnostic:
    """The message for an output that the system does not allow to be written."""
    reason = error.strerror or str(error)
    if output.endswith(("/", os.sep)) or os.path.isdir(output):
        reason = "a folder: name a file in it, `beamcam batch` writes to folders"
    return CANNOT_WRITE.at(Source(output), found=output, reason=reason)


def stop_without_output(error: OSError) -> NoReturn:
    """Say that standard output cannot be written, and end."""
    # What is left in its buffer would be tried again at the end of the process.
    with suppress(OSError, ValueError):
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
    if is_reader_gone(error):
        raise SystemExit(REFUSED)  # who has had enough, as of a broken pipe
    Console().stop([cannot_write("stdout", error)])


# --- grouped --------------------------------------------------------------------------------------

# A command whose options stand in groups in its help.


SAID = "What is said"
OTHER = "Other"
#: Heading -> the options below it, by the names of their values, in this order.
GROUPS: Mapping[str, tuple[str, ...]] = {
    "Job": (
        "output", "folder", "machine", "by", "machines", "config_file", "trust", "job", "bar",
        "bars", "remnants", "nest", "order", "turn", "style", "corner", "lip",
        "show", "to", "table", "quantity", "against", "mark_from", "first", "contour", "after",
        "date", "frame", "rest_name", "rest_as", "size", "code", "profile", "solid",
    ),
    "Names and folders": ("name", "flat", "done", "refused", "samples"),
    "What may be left out": ("skips", "exit_left_out", "strict", "no_verify"),
    "Members of a building model": (
        "marks", "guids", "classes", "assemblies", "force", "letter", "check"
    ),
    "How files are read": ("units", "width", "layers", "fit", "wrap", "encoding"),
    "How sheets are cut": (
        "colours", "thickness", "material", "amps", "nozzle", "kerf", "kerf_by", "lead",
        "lead_in", "lead_out", "tabs", "tab_width",
        "inner_tabs", "overcut", "gap", "allow_open", "place", "origin", "mirror", "rotate",
        "copies", "spacing", "common_cuts", "chain_cuts", "skeleton_cuts", "sheet_size", "unrolled",
    ),
    "How the work is done": (
        "jobs", "scheduler", "redo", "dry", "settle", "end_wait", "every", "encoder", "modbus",
        "serve", "pace", "once", "update",
    ),
    SAID: ("as_json", "report", "unit", "paper", "quiet", "verbose", "schema"),
}  # fmt: skip


#: What matters most, in the order of use; `--help` of a command with many options shows these.
FIRST = (
    "output", "to", "machine", "machines", "folder", "against", "bar", "bars", "quantity",
    "sheet_size", "marks", "thickness", "colours", "skips", "as_json",
)  # fmt: skip
MOST_SHOWN = 20  #: options of a command whose help shows all of them


class Grouped(click.Command):
    """A command that prints its options by `GROUPS`; those of no group come last.

    Of many options `--help` shows those of `FIRST`, and `--help-all` all.
    """

    def get_params(self, ctx: click.Context) -> list[click.Parameter]:
        """The parameters, with --help-all where there are many."""
        params = super().get_params(ctx)
        if sum(isinstance(p, click.Option) for p in params) > MOST_SHOWN:
            text = "Show all options, in groups, and exit."
            more = click.Option(["--help-all"], is_flag=True, expose_value=False, is_eager=True,
                                help=text, callback=_show_all)  # fmt: skip
            params.append(more)
        return params

    def format_options(self, ctx: click.Context, formatter: click.HelpFormatter) -> None:
        """Write each group of options under its heading, or the first of them."""
        params = [p for p in self.get_params(ctx) if isinstance(p, click.Option)]
        helps = [p for p in params if {"--help", "--help-all"} & {*p.opts}]
        headings: dict[str, list[click.Option]] = {heading: [] for heading in (*GROUPS, OTHER)}
        if len(helps) == 2 and not ctx.meta.get(ALL):
            first = [p for p in params if p.name in FIRST]
            headings = {
                "Options": [*sorted(first, key=lambda p: FIRST.index(p.name or "")), *helps]
            }
        else:
            for param in params:
                headings[SAID if param in helps else heading_of(param.name or "")].append(param)
        for heading, options in headings.items():
            records = [r for r in (p.get_help_record(ctx) for p in options) if r is not None]
            if records:
                with formatter.section(heading):
                    formatter.write_dl(records)


ALL = "beamcam: all options"


def _show_all(ctx: click.Context, param: click.Parameter, value: bool) -> None:
    if value and not ctx.resilient_parsing:
        ctx.meta[ALL] = True
        click.echo(ctx.get_help(), color=ctx.color)
        ctx.exit()


def heading_of(name: str) -> str:
    """The heading of an option, by the name of its value."""
    return next((heading for heading, names in GROUPS.items() if name in names), OTHER)
