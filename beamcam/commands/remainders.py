"""The remainder of a program after a stop in mid bar: its option, and what is wrong with one."""

from pathlib import PurePath

import click

from beamcam.commands import options
from beamcam.commands.programs import input_bytes
from beamcam.config.values import Config
from beamcam.errors import Diagnostic
from beamcam.machine.machine import Machine
from beamcam.pipeline import post
from beamcam.planning.jobs import jobs_of
from beamcam.planning.rules import named_skips
from beamcam.planning.stock import from_store
from beamcam.posts import Request
from beamcam.readers.content import shown_name

ONE_BAR = "--from-operation is for the program of one bar."


def from_operation(help_text: str) -> options.Decorator:
    """The option --from-operation."""
    return click.option(
        "--from-operation", "first", type=click.IntRange(min=2), metavar="N", help=help_text
    )


after = click.option(
    "--after",
    type=options.FILE,
    metavar="WHOLE",
    help="The program that was stopped; by default the one that `post` makes of the PARTs.",
)


def faults_of_rest(
    rest: bytes | str, request: Request, first: int, whole: str | None, config: Config
) -> tuple[Diagnostic, ...]:
    """Everything that is wrong with the remainder from operation `first` on of a program.

    `whole` is the file of the program that was stopped; without it, it is posted anew.
    """
    from beamcam.remainder import faults_of

    if request.machine.stock != "beam":
        raise click.UsageError(ONE_BAR)
    if whole is None:
        name = f"program posted of {PurePath(shown_name(request.parts[0].source.file)).name}"
        text = _posted(request, config)
    else:
        name, text = shown_name(whole), _text(input_bytes(whole))
    return faults_of(_text(rest), text, first, request, name)


def _posted(request: Request, config: Config) -> str:
    """The program that `post` makes of the parts. Raises PlanError."""
    machine: Machine = request.machine
    skips = named_skips(request.skips)
    jobs = jobs_of(request.parts, machine, config.quantity, config.stock_lengths, skips)
    if len(jobs) != 1:
        raise click.UsageError(ONE_BAR)
    longest = max(part.length for part in request.parts)

    def made(bar: float | None) -> str:
        return post(
            jobs[0].parts, machine, "JOB", bar, skips, False, request.order, request.turn
        ).text

    return from_store(made, jobs[0].lengths, longest)


def _text(program: bytes | str) -> str:
    return program if isinstance(program, str) else program.decode("utf-8", "replace")
