"""`beamcam split`: one part on several machines, each making what the others cannot."""

import os
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click
from msgspec.structs import replace

from beamcam.batch.names import FileNames, cleaned
from beamcam.commands import options
from beamcam.commands.common import Grouped, Voice, cannot_write, keep_apart, write
from beamcam.commands.parts import part_options, read_parts, request_of
from beamcam.commands.post import success
from beamcam.commands.settings import files_read, machine_asked, settled
from beamcam.errors import BeamcamError, Diagnostic
from beamcam.model.plan import NOT_MADE
from beamcam.planning.left_out import BY_HAND, LEFT_OUT
from beamcam.report.hand_list import LIST_SUFFIX, as_csv, hand_rows
from beamcam.writers import TARGETS

if TYPE_CHECKING:
    from beamcam.rest_part import Stage

FORMATS = {"nc1": TARGETS[0], "json": TARGETS[1]}  #: of a rest, by its suffix


@click.command("split", cls=Grouped)
@options.inputs
@click.option(
    "-o", "--output", "folder", default=".", show_default=True, type=options.FILE,
    metavar="FOLDER", help="Where programs and rests are written.",
)  # fmt: skip
@click.option(
    "--machines", required=True, metavar="NAMES",
    help="Names or TOML files of the machines, set off by commas.",
)  # fmt: skip
@click.option(
    "--rest-as", type=click.Choice(list(FORMATS)), default="nc1", show_default=True,
    help="Form of the rests.",
)  # fmt: skip
@options.config
@options.skips
@part_options
@options.strict
@options.json_messages
@options.voiced
def command(
    inputs: tuple[str, ...],
    folder: str,
    machines: str,
    rest_as: str,
    as_json: bool,
    voice: Voice,
    **asked: Any,
) -> None:
    """Make parts on several machines, each making what the others cannot.

    For each part the shortest chain of the machines is taken, in it first the one that leaves
    least. MARK-1-MACHINE is the first program, MARK-1-rest.nc1 the part as the next machine gets
    it, MARK-2-MACHINE the program of that, and so on. Each program is read back against its part,
    and with its rest against the part before. The ends of a rest are there: the program of the
    next machine begins with how the piece lies. Nothing is written unless all parts are made.

    \b
    beamcam split M58.nc1 --machines beamline,coper-linuxcnc -o programs
    beamcam split parts/*.nc1 --machines beamline-pusher,coper-linuxcnc -o programs --rest-as json
    """
    from beamcam.rest_part import split_part

    said: tuple[Diagnostic, ...] = ()
    files: list[tuple[str, str]] = []
    told: list[str] = []
    names = FileNames()
    try:
        config = settled(asked | {"machine": None}, inputs)
        of_names = [machine_asked(name.strip(), config) for name in machines.split(",")]
        shop = [one for one in of_names if one is not None]
        if not shop:
            raise click.UsageError("--machines names no machine.")
        parts, said = read_parts(inputs, config, asked, voice)
        for part in parts:
            request = request_of((part,), config, shop[0], None)
            stages, more = split_part(request, shop, FORMATS[rest_as])
            said += more
            mark = names.take(f"{cleaned(part.mark) or 'part'}.nc1", part.mark)[: -len(".nc1")]
            for k, stage in enumerate(stages, 1):
                name = os.path.join(folder, f"{mark}-{k}")
                program, of_stage = _files(stage, name, rest_as)
                files += of_stage
                said += _said_of(stage)
                told.append(success(program, stage.posted))
    except BeamcamError as error:
        voice.stop((*said, *error.diagnostics))
    read = files_read(config, inputs)
    keep_apart([path for path, _ in files], read, voice)
    try:
        Path(folder).mkdir(parents=True, exist_ok=True)
    except OSError as error:
        voice.stop((*said, cannot_write(folder, error)))
    for path, text in files:
        write(path, text.encode(), voice, read)
    voice.say((*dict.fromkeys(said),))
    if not (voice.quiet or voice.as_json):
        for line in told:
            voice.tell(line)


def _files(stage: "Stage", name: str, rest_as: str) -> tuple[str, list[tuple[str, str]]]:
    """The name of a program, and all files of its stage: it, the rest, the list of manual work.

    What the next machine gets is no manual work.
    """
    machine, plan = stage.posted.job.machine, stage.posted.plan
    program = f"{name}-{machine.name}{machine.suffix}"
    files = [(program, stage.posted.text)]
    if stage.rest:
        files.append((f"{name}-rest.{rest_as}", stage.rest))
        plan = replace(plan, outcomes=tuple(o for o in plan.outcomes if o.how not in NOT_MADE))
    if rows := hand_rows(plan):
        files.append((program + LIST_SUFFIX, as_csv(rows)))
    return program, files


def _said_of(stage: "Stage") -> tuple[Diagnostic, ...]:
    """The remarks on a program, but on what the next machine gets."""
    left = (LEFT_OUT.code, BY_HAND.code) if stage.rest else ()
    return tuple(one for one in stage.posted.remarks if one.code not in left)
