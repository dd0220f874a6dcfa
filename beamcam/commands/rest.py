"""The rest of a part, for the next machine: its option, and its file."""

from collections.abc import Sequence

import click

from beamcam.commands import options
from beamcam.errors import Diagnostic, Source
from beamcam.pipeline import Posted
from beamcam.writers import TARGETS

OF_ONE = "--rest is for the programs of one part of a bar, as it was read: without --turn."
#: Formats that hold all of a part.
WHOLE = tuple(t for t in TARGETS if t.name != "faces-dxf")

option = click.option(
    "--rest", "rest_name", type=options.FILE, metavar="FILE",
    help="Write what the program does not make of its part too, for the next machine.",
)  # fmt: skip


def check_rest(path: str, made: Sequence[Posted]) -> None:
    """Raises click.UsageError where no rest can be written, or not in such a file."""
    from beamcam.commands.convert import target_of

    target = target_of(path, None)
    if target not in WHOLE:
        expected = ", ".join(suffix for t in WHOLE for suffix in t.suffixes)
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

    found = rest_of_part(posted, target_of(path, None))
    if found is None:
        return None, NO_REST.at(Source(path))
    part, text = found
    return text, REST.at(Source(path), found=len(part.features))
