"""`beamcam split`: one part on several machines, each making what the others cannot."""

import os
from pathlib import Path
from typing import Any

import click

from beamcam.batch.names import FileNames, cleaned
from beamcam.commands import options
from beamcam.commands.common import Console, cannot_write, keep_apart, write
from beamcam.commands.parts import part_options, read_parts, request_of
from beamcam.commands.post import success
from beamcam.commands.settings import files_read, machines_of_split, settled
from beamcam.planning.manual_list import LIST_SUFFIX, as_csv, manual_rows
from beamcam.writers import target_of_suffix


@click.command("split", cls=options.Grouped)
@options.inputs
@click.option(
    "-o", "--output", "folder", default=".", show_default=True, type=options.FILE,
    metavar="FOLDER", help="Where programs and rests are written.",
)  # fmt: skip
@options.machines
@options.by
@options.rest_as
@options.config
@options.skips
@part_options
@options.strict
@options.json_messages
@options.verbosity
def command(
    inputs: tuple[str, ...], folder: str, rest_as: str, as_json: bool, console: Console,
    **values: Any,
) -> None:  # fmt: skip
    """Make parts on several machines, each making what the others cannot.

    For each part the shortest chain of the machines is taken, in it first the one that leaves
    least, of equal ones the first in order or, with --by time, the quickest. MARK-1-MACHINE is the
    first program, MARK-1-rest.nc1 the part as the next machine gets it, MARK-2-MACHINE the program
    of that, and so on. Each program is read back against its part, and with its rest against the
    part before. The ends of a rest are there: the program of the next machine begins with how the
    piece lies. Nothing is written unless all parts are made.

    \b
    beamcam split M58.nc1 --machines beamline,coper-linuxcnc -o programs
    beamcam split parts/*.nc1 --machines beamline-pusher,coper-linuxcnc -o programs --rest-as json
    """
    from beamcam.rest_part import chain_for, stages_of

    files: list[tuple[str, str]] = []
    lines: list[str] = []
    names = FileNames()
    target = target_of_suffix(f".{rest_as}")
    config = settled(values, inputs)
    machines = machines_of_split(config)
    if not machines:
        raise click.UsageError("found no machines; expected --machines, or `split` in a file.")
    for part in read_parts(inputs, config, values, console):
        request = request_of((part,), config, machines[0], None, {})
        chain, choice = chain_for(request, machines)
        console.messages += choice
        mark = names.take(f"{cleaned(part.mark) or 'part'}.nc1", part.mark)[: -len(".nc1")]
        for k, stage in enumerate(stages_of(request, chain, target), 1):
            name, machine = os.path.join(folder, f"{mark}-{k}"), stage.posted.job.machine
            program = f"{name}-{machine.name}{machine.suffix}"
            files.append((program, stage.posted.text))
            if stage.rest:
                files.append((f"{name}-rest.{rest_as}", stage.rest))
            if rows := manual_rows(stage.plan):
                files.append((program + LIST_SUFFIX, as_csv(rows)))
            console.messages += stage.remarks
            lines.append(success(program, stage.posted))
    read = files_read(config, inputs)
    keep_apart([path for path, _ in files], read, console)
    try:
        Path(folder).mkdir(parents=True, exist_ok=True)
    except OSError as error:
        console.stop([cannot_write(folder, error)])
    for path, text in files:
        write(path, text.encode(), console, read)
    console.messages[:] = dict.fromkeys(console.messages)
    console.say()
    for line in lines:
        console.tell(line)
