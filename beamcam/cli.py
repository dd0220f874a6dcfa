"""The command line: a table of commands, each imported when it is called.

Only the modules of `beamcam.commands` print, exit or read the environment.
"""

import signal
import sys
from collections.abc import Callable
from importlib import import_module
from io import TextIOWrapper
from typing import Any

import click

from beamcam.plain_text import terminal_lines
from beamcam.system import collector_seldom, end_here, is_unicode, one_thread
from beamcam.version import __version__

#: name -> module of beamcam.commands whose `command` it is, and its help in a line
COMMANDS = {
    "post": ("post", "Turn parts into a machine program."),
    "inspect": ("inspect", "Print what a file holds, and what is wrong with it."),
    "convert": ("convert", "Write a part as DSTV, JSON or a drawing of its faces."),
    "plan": ("plan", "Explain the work that makes parts, step by step."),
    "verify": ("verify_", "Read a program back and compare it with its parts."),
    "diff": ("diff", "Compare two programs, or two parts, by what they mean."),
    "recover": ("recover", "Write the part that a program makes."),
    "check": ("check", "Post a folder of golden programs again and compare."),
    "simulate": ("simulate", "Write where the axes of a machine are when."),
    "monitor": ("monitor", "Draw the axes of a controller in a page while they move."),
    "plot": ("plot", "Draw a part, or what a program makes."),
    "report": ("report", "Write the setup sheet of a program, with playback."),
    "profile": ("profile", "Write the velocity profile of an axis, as a table or a picture."),
    "machines": ("machines", "List the machines, or show one with all its values."),
    "split": ("split", "Make parts on several machines, each making what others cannot."),
    "batch": ("batch", "Turn folders of parts into folders of programs."),
    "watch": ("watch", "Post what is put into a folder, as it comes."),
    "list": ("list_", "Write part lists and cutting lists."),
    "labels": ("labels", "Write a label with a code for each piece."),
    "doctor": ("doctor", "Show what is installed here, and whether it works."),
    "config": ("config", "Show the configuration and where each value comes from."),
    "completion": ("completion", "Print what makes a shell complete the commands."),
    "codes": ("codes", "List the codes of all messages."),
}


class Commands(click.Group):
    """A group that knows its commands by name and imports only the one that runs."""

    loading: Callable[..., object] | None = None  #: handler of Ctrl-C until a command begins

    def main(self, *args: Any, **values: Any) -> Any:
        """Run a command; a fault of standard output is reported like that of any other output."""
        collector_seldom()
        one_thread()
        for stream in (sys.stdout, sys.stderr):
            if isinstance(stream, TextIOWrapper) and not is_unicode(stream.encoding):
                stream.reconfigure(errors="backslashreplace")
        try:
            return super().main(*args, **values)
        except BrokenPipeError:
            raise  # its reader has had enough
        except OSError as error:
            if error.filename is not None:
                raise
            from beamcam.commands.common import stop_without_output

            stop_without_output(error)

    def invoke(self, ctx: click.Context) -> Any:
        """Run a command; messages about wrong usage name files, and must not steer a terminal."""
        if self.loading is not None and signal.getsignal(signal.SIGINT) is self.loading:
            signal.signal(signal.SIGINT, end_here)
        try:
            return super().invoke(ctx)
        except click.ClickException as error:
            vars(error)["message"] = terminal_lines(error.message)  # click calls it final
            raise

    def list_commands(self, ctx: click.Context) -> list[str]:
        return list(COMMANDS)

    def get_command(self, ctx: click.Context, cmd_name: str) -> click.Command | None:
        if cmd_name not in COMMANDS:
            return None
        command: click.Command = import_module(f"beamcam.commands.{COMMANDS[cmd_name][0]}").command
        return command

    def format_commands(self, ctx: click.Context, formatter: click.HelpFormatter) -> None:
        with formatter.section("Commands"):
            formatter.write_dl([(name, text) for name, (_, text) in COMMANDS.items()])

    def resolve_command(
        self, ctx: click.Context, args: list[str]
    ) -> tuple[str | None, click.Command | None, list[str]]:
        if args and args[0] not in COMMANDS and not args[0].startswith("-"):
            from difflib import get_close_matches

            close = get_close_matches(args[0], COMMANDS, 1)
            hint = f" Did you mean {close[0]!r}?" if close else ""
            ctx.fail(f"No such command {args[0]!r}.{hint}")
        return super().resolve_command(ctx, args)


#: First steps, shown when beamcam is called without a command.
FIRST = """\
beamcam turns steel members and drawings into machine programs, and reads each one back.

  beamcam inspect PART.nc1               content and faults of a file (DSTV, IFC, DXF, SVG, JSON)
  beamcam post PART.nc1 -o PART.gcode    its program, verified; a bar goes to the machine beamline
  beamcam plot PART.gcode -o PART.svg    a picture of what a program makes
  beamcam batch FOLDER -o PROGRAMS       a folder of parts to a folder of programs
  beamcam machines list                  the machines that there are
  beamcam doctor                         what is installed here, and whether it works

`beamcam --help` lists all commands, `beamcam COMMAND --help` says what one does."""


@click.command(
    cls=Commands,
    context_settings={"help_option_names": ["-h", "--help"]},
    invoke_without_command=True,
)
@click.version_option(__version__, prog_name="beamcam")
@click.pass_context
def main(ctx: click.Context) -> None:
    """Turn steel members and drawings into programs for saws, drills, torches and lasers.

    Nothing is dropped in silence: what a machine cannot make refuses the part, with the file and
    the line. Exit status: 0 all posted, 1 an input was refused, 2 wrong usage.
    """
    if ctx.invoked_subcommand is None:
        click.echo(FIRST)
