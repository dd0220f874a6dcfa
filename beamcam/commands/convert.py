"""`beamcam convert`: a part from one format to another."""

import os
from collections.abc import Sequence
from pathlib import Path, PurePath
from typing import Any

import click

from beamcam.batch.names import FileNames, cleaned
from beamcam.commands import NO_PART, ONE_PART, OUTPUT_FORMAT, RENAMED, WRITTEN, options
from beamcam.commands.common import Console, cannot_write, over_input, read_all, say_json, write
from beamcam.commands.parts import (
    drawing_choice,
    drawing_options,
    member_choice,
    member_options,
    thickness,
)
from beamcam.commands.settings import files_read, settled, with_thickness
from beamcam.errors import BeamcamError, ReadError, Source
from beamcam.files import FilesRead, write_whole
from beamcam.model.part import Part
from beamcam.pipeline import counted
from beamcam.readers import sound
from beamcam.writers import TARGETS, Target


def target_of(output: str, name: str | None) -> Target:
    """The format called `name`, or else the one that the output's suffix says."""
    suffix = PurePath(output).suffix.lower()
    for target in TARGETS:
        if target.name == name or (name is None and suffix in target.suffixes):
            return target
    if name is None and is_folder(output):
        return TARGETS[0]
    expected = ", ".join(s for t in TARGETS for s in t.suffixes)
    raise ReadError(OUTPUT_FORMAT.at(Source(output), found=suffix or output, expected=expected))


def is_folder(output: str) -> bool:
    """Whether an output is a folder, which gets a file for each part."""
    return output.endswith(("/", os.sep)) or Path(output).is_dir()


def _print_schema(ctx: click.Context, param: click.Parameter, asked_for: bool) -> None:
    if asked_for:
        from beamcam.model.part_json import part_schema

        say_json(part_schema())
        ctx.exit()


@click.command("convert", cls=options.Grouped)
@click.argument("source", metavar="INPUT", type=options.FILE)
@options.output("File, folder/ for a file a part, or -.")
@options.config
@click.option("--to", "to", type=click.Choice([t.name for t in TARGETS]), help="Format.")
@member_options
@drawing_options
@thickness
@options.strict
@options.json_messages
@click.option(
    "--schema",
    is_flag=True,
    is_eager=True,
    expose_value=False,
    callback=_print_schema,
    help="Print the JSON schema of a part and exit.",
)
@options.verbosity
def command(
    source: str, output: str, to: str | None, as_json: bool, console: Console, **values: Any
) -> None:
    """Write a part in another format: DSTV, JSON, or a drawing of its faces.

    The suffix of the output says which, unless --to does: .nc1 and .nc are DSTV, .json is the
    JSON form, .dxf a drawing with each face on a layer of its own. Into a folder all members of a
    model are written that can be read, and exit status 1 says that there are others.

    \b
    beamcam convert M58.nc1 -o M58.json
    beamcam convert M58.json -o M58.nc1
    beamcam convert M58.nc1 -o faces.dxf
    beamcam convert gasket.dxf -o gasket.nc1 --thickness 3
    beamcam convert model.ifc -o nc/
    beamcam convert --schema > part.schema.json
    """
    how = drawing_choice(values) | member_choice(values, kernel=True)
    config = settled(values, (source,))
    target = target_of(output, to)
    (read_in,) = read_all((source,), config.strict, how, console)
    reading = with_thickness(read_in, config)
    console.messages += reading.diagnostics
    parts = counted(sound(reading))
    # A drawing of filled shapes alone is a part without any length.
    if not (any(part.length > 0 for part in parts) or reading.refused):
        raise ReadError(NO_PART.at(Source(source)))
    if not reading.refused or (parts and is_folder(output)):
        write_parts(source, parts, target, output, console, files_read(config, (source,)))
    console.finish()


def write_parts(
    source: str, parts: Sequence[Part], target: Target, output: str, console: Console,
    read: FilesRead,
) -> None:  # fmt: skip
    """Write the only part of a file in another format, or all into a folder, called by their marks.

    What is said of those in a folder is among the messages of the console: one that cannot be
    written stops no other. None of the files `read` is written over. Raises BeamcamError unless
    there is exactly one for a file.
    """
    if not is_folder(output):
        if len(parts) != 1:
            raise ReadError(ONE_PART.at(Source(source), found=len(parts), output=output))
        write(output, target.write(parts[0]), console, read)
        return
    try:
        Path(output).mkdir(parents=True, exist_ok=True)
    except OSError as error:
        console.messages.append(cannot_write(output, error))
        return
    names, written = FileNames(), 0
    for part in parts:
        mark_name = (cleaned(part.mark) or "part") + target.suffixes[0]
        other, name = names.owner(mark_name), names.take(mark_name, part.mark)
        if other is not None:
            renamed = RENAMED.at(part.source, found=part.mark, of=mark_name, other=other, name=name)
            console.messages.append(renamed)
        path = os.path.join(output, name)
        try:
            if over := over_input(path, read):
                raise ReadError(over)
            write_whole(path, target.write(part))
        except BeamcamError as error:
            console.messages += error.diagnostics
        except OSError as error:
            console.messages.append(cannot_write(path, error))
        else:
            console.did(f"wrote {path}")
            written += 1
    members = sum(part.quantity for part in parts)
    count = WRITTEN.at(Source(output), found=written, of=len(parts), members=members)
    console.messages.append(count)
