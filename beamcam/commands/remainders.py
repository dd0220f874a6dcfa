"""The remainder of a program after a stop in mid bar: its option, and what is wrong with one."""

from collections.abc import Sequence
from pathlib import PurePath

import click
from msgspec.structs import replace

from beamcam.commands import options
from beamcam.commands.parts import input_bytes
from beamcam.errors import Diagnostic, Source
from beamcam.machine.faults import TABLE_CONTROLLERS
from beamcam.machine.machine import Machine
from beamcam.model.request import Request
from beamcam.pipeline import Posted, begin, finished, whole_job
from beamcam.readers import shown_name

ONE_BAR = "--from-operation is for the program of one bar."
ONE_SHEET = "--from-contour is for the program of one sheet, in G-code."


def from_operation(help_text: str) -> options.Decorator:
    """The option --from-operation."""
    return click.option(
        "--from-operation", "first", type=click.IntRange(min=2), metavar="N", help=help_text
    )


def from_contour(help_text: str) -> options.Decorator:
    """The option --from-contour."""
    return click.option(
        "--from-contour", "contour", type=click.IntRange(min=2), metavar="N", help=help_text
    )


def is_coded_sheet(machine: Machine) -> bool:
    """Whether a machine cuts sheets by a program of contours."""
    return machine.stock == "sheet" and machine.controller not in TABLE_CONTROLLERS


after = click.option(
    "--after",
    type=options.FILE,
    metavar="WHOLE",
    help="The program that was stopped; by default the one that `post` makes of the PARTs.",
)


def faults_of_rest(
    rest: bytes | str, request: Request, first: int, bar: float | None, whole: str | None
) -> tuple[Diagnostic, ...]:
    """Everything that is wrong with the remainder from operation `first` on of a program.

    Of a sheet that is a contour. `whole` is the file of the program that was stopped; without it,
    it is posted anew. `bar` is the bar's length where it is known.
    """
    from beamcam.remainder import faults_of, faults_of_sheet_rest

    of_sheet = is_coded_sheet(request.machine)
    rule = ONE_SHEET if of_sheet else ONE_BAR
    job = whole_job(request, bar)
    if whole is None:
        name = f"program posted of {PurePath(shown_name(request.parts[0].source.file)).name}"
        begun = begin(replace(request, verified=False, strict=False, name="JOB"))
        if len(begun) != 1:
            raise click.UsageError(rule)
        text = finished(begun[0]).text
    else:
        name, text = shown_name(whole), _text(input_bytes(whole))
    return (faults_of_sheet_rest if of_sheet else faults_of)(_text(rest), text, first, job, name)


def _text(program: bytes | str) -> str:
    return program if isinstance(program, str) else program.decode("utf-8", "replace")


OF_ONE = "--rest is for the programs of one part of a bar, as it was read: without --turn."
NOT_WHOLE = "faces-dxf"  #: the format that holds no more than the faces of a part

rest_option = click.option(
    "--rest", "rest_name", type=options.FILE, metavar="FILE",
    help="Write what the program does not make of its part too, for the next machine.",
)  # fmt: skip


def check_rest(path: str, made: Sequence[Posted]) -> None:
    """Raises click.UsageError where no rest can be written, or not in such a file."""
    from beamcam.commands.convert import target_of
    from beamcam.writers import TARGETS

    if target_of(path, None).name == NOT_WHOLE:
        expected = ", ".join(s for t in TARGETS if t.name != NOT_WHOLE for s in t.suffixes)
        raise click.UsageError(f"--rest {path!r}: expected a name in {expected}")
    request = made[0].job.request
    if len(request.parts) != 1 or request.turn or request.machine.stock == "sheet":
        raise click.UsageError(OF_ONE)


def rest_file(path: str, posted: Posted) -> tuple[str | None, Diagnostic]:
    """The text of the rest, None where nothing is left, and a note of it.

    Raises BeamcamError as `rest_of_part` does.
    """
    from beamcam.commands.convert import target_of
    from beamcam.rest_part import NO_REST, REST, rest_of_part

    rest = rest_of_part(posted, target_of(path, None))
    if rest is None:
        return None, NO_REST.at(Source(path))
    part, text = rest
    return text, REST.at(Source(path), found=len(part.features))
