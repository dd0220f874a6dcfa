"""Shared by the commands: messages, output and exit."""

import os
import re
import sys
from collections.abc import Callable, Iterable, Iterator
from contextlib import ExitStack, contextmanager, suppress
from pathlib import PurePath
from time import perf_counter
from typing import TYPE_CHECKING, Any, NoReturn

import click

from beamcam.commands import ACCOUNT, CANNOT_WRITE, OVER_INPUT
from beamcam.errors import Diagnostic, Severity, Source, errors_in, first_of_each_kind
from beamcam.files import REFUSED_SUFFIX, FilesRead, write_whole
from beamcam.machine.tables import DIALECTS, TABLE_CONTROLLERS
from beamcam.plain_text import json_text, terminal_text
from beamcam.system import is_reader_gone, is_unicode, taken_back

if TYPE_CHECKING:
    from beamcam.machine.machine import Machine
    from beamcam.pipeline import Posted
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
        self.messages: list[Diagnostic] = []  #: on the job; said at its end, or before its refusal
        self._account: list[Diagnostic] = []  #: what is kept for a JSON list
        self._remarks: dict[Diagnostic, bool] = {}  #: on the machine; whether they were said
        self._did: set[str] = set()  #: that is told once
        self._since = perf_counter()

    def wants(self, severity: Severity) -> bool:
        """Whether a message of that weight is said."""
        return not self.quiet or severity is Severity.ERROR

    def say(self, diagnostics: Iterable[Diagnostic] = ()) -> None:
        """Say what is kept, and these messages.

        As JSON they are one list with what was done, so this is said once.
        """
        new = [one for one, is_said in self._remarks.items() if not is_said]
        self._remarks |= dict.fromkeys(new, True)
        diagnostics = (*new, *self.messages, *diagnostics)
        self.messages.clear()
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
            self.say()

    def remark(self, diagnostics: Iterable[Diagnostic]) -> None:
        """Keep messages to be said with the next ones; what was said once is not said again."""
        for one in diagnostics:
            self._remarks.setdefault(one, False)

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

    @property
    def for_people(self) -> bool:
        """Whether people read the messages, and more than errors."""
        return not (self.quiet or self.as_json)

    def tell(self, line: str) -> None:
        """Say what came of it, to people who want more than errors."""
        if self.for_people:
            say_lines([line], err=True)

    def end(self) -> None:
        """Say what was kept of steps and remarks, where nothing else was to be said."""
        if self._account or not all(self._remarks.values()):
            self.say()

    def stop(self, diagnostics: Iterable[Diagnostic]) -> NoReturn:
        """Say messages and end with the status of a refused input."""
        self.say(diagnostics)
        raise SystemExit(REFUSED)

    def finish(self) -> None:
        """Say all messages; if one is an error, end with the status of a refused input."""
        is_refused = bool(errors_in(self.messages))
        self.say()
        if is_refused:
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
    for line in map(terminal_text, lines):
        if coloured and (match := _SEVERITY.search(line)):
            begin, end = match.span("word")
            styled = click.style(match["word"], fg=_COLOURS[match["word"]], bold=True)
            line = line[:begin] + styled + line[end:]
        click.echo(line, err=err, color=coloured or None)


def shows_colour(stream: Any) -> bool:
    """Whether text for a stream has colours: on a terminal, unless the user wants none.

    Source: no-color.org and force-color.org; a variable that is empty counts as none.
    """
    if os.environ.get("NO_COLOR"):
        return False
    if os.environ.get("FORCE_COLOR"):
        return True
    return stream.isatty() and os.environ.get("TERM") != "dumb"


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
            read = f"{reading.format}, {len(reading.parts)} part(s), {features} feature(s)"
            console.did(f"read {shown_name(path)}: {read}")
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
                # As click does at the end of a bar, which hides the cursor.
                show_cursor = b"\n\x1b[?25h"
                stack.enter_context(taken_back(lambda: os.write(sys.stderr.fileno(), show_cursor)))
                bar = click.progressbar(length=of, label=label, file=sys.stderr)
                bars.append(stack.enter_context(bar))
            bars[0].update(done - bars[0].pos)

        yield follow


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


# --- programs: the files of a program: how it may be called, its form, and what goes with it ------

PICTURES = (".svg", ".png", ".pdf")

#: Suffixes that are never programs, whatever suffix a machine uses.
NO_PROGRAMS = (*PICTURES, ".html", ".json", ".dxf", ".nc1", ".ifc", ".ifczip", ".toml")


def program(ctx: click.Context, param: click.Parameter, value: str | None) -> str | None:
    """Refuses an output that is called as a picture, a report or a part is."""
    if value is not None and suffix_of(value) in NO_PROGRAMS:
        who = {".json": "convert", ".dxf": "convert", ".nc1": "convert", ".html": "report"}
        command = "plot" if suffix_of(value) in PICTURES else who.get(suffix_of(value), "")
        hint = f" (`beamcam {command}` writes such)" if command else ""
        raise click.BadParameter(f"found {value!r}; expected the name of a program{hint}")
    return value


def suffix_of(name: str) -> str:
    """The suffix of a file's name, in small letters."""
    return PurePath(name).suffix.lower()


def table_style(machine: "Machine", output: str, style: str | None) -> str | None:
    """The form of the program: the style of a trigger program, the form of a step table.

    Raises click.UsageError where the machine has no styles, or no form of that suffix.
    """
    if style is not None and machine.controller not in DIALECTS:
        raise click.UsageError(f"--style is not for {machine.name}.")
    if machine.controller != "stepper":
        return style
    if output == STANDARD:
        return machine.suffix
    from beamcam.emitters.step_table import FORMS

    suffix = suffix_of(output)
    if suffix not in FORMS:
        raise click.UsageError(f"found {output!r}; expected a name in {', '.join(FORMS)}, or -")
    return suffix


def is_coded_sheet(machine: "Machine") -> bool:
    """Whether a machine cuts sheets by a program of contours."""
    return machine.stock == "sheet" and machine.controller not in TABLE_CONTROLLERS


def outputs(
    posted: "Posted", machine: "Machine", output: str
) -> Iterator[tuple[str, str | Iterable[bytes]]]:
    """Each file with what is to be written to it.

    A trigger program of several units becomes a file a unit, the set-points beside the main one
    and before it, so that it never stands there without them.
    """
    if machine.controller in DIALECTS and output != STANDARD:
        from beamcam.emitters.simotion import split_units

        (_, main), *more = split_units(posted.text)
        folder = PurePath(output).parent
        for name, text in more:
            yield str(folder / f"{name}{machine.suffix}"), text
        yield output, main
        return
    yield output, posted.pieces()
