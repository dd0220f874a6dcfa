"""`beamcam diff`: two programs, or two parts, compared by what they mean."""

import os
from pathlib import Path
from typing import Any

import click

from beamcam.commands import options
from beamcam.commands.common import REFUSED, STANDARD, Voice, say_json, say_lines, write
from beamcam.commands.comparison import differences_of, drawn_over
from beamcam.commands.programs import input_bytes
from beamcam.commands.settings import files_read, machine_for_program, settled
from beamcam.diff.pairing import Difference
from beamcam.errors import BeamcamError, errors_in
from beamcam.readers.content import shown_name


@click.command("diff")
@click.argument("a", type=options.FILE)
@click.argument("b", type=options.FILE, required=False, metavar="B")
@click.option(
    "-o",
    "--output",
    type=options.FILE,
    help="Overlay picture of both: .html with the list, .svg, .png or .pdf.",
)
@options.machine
@options.config
@options.strict
@options.as_json
@options.voiced
def command(
    a: str, b: str | None, output: str | None, as_json: bool, voice: Voice, **asked: Any
) -> None:
    """Say what program or part B makes differently from A; of two folders, file by file.

    Each program is read by the machine that its own header names, unless --machine names one.
    Files of two folders belong together that have the same name below them. A change that
    several share is one line.

    With -o both are drawn over each other: what moved, what is new, what is gone.

    Block numbers, comments, spacing, and the order of holes in a part's file count for nothing.
    Exit status: 0 they mean the same, 1 they differ, or one cannot be read, or would be
    refused: for a missing word, retract, feed or tool.

    \b
    beamcam diff yesterday.gcode today.gcode --machine beamline-annex
    beamcam diff M58.nc1 M58-revised.nc1
    beamcam diff M58.nc1 M58-revised.nc1 -o diff.html
    beamcam diff golden programs
    beamcam post M58.nc1 -o - | beamcam diff yesterday.gcode -
    """
    if b is None and os.path.isdir(a):
        raise click.UsageError(
            f"found the folder {a!r} alone; expected another one. `beamcam check {a}` posts its "
            f"programs again and says what differs, `beamcam diff {a} B` compares two folders."
        )
    if b is None:
        raise click.UsageError("Missing argument 'B'.")
    folders = [os.path.isdir(path) for path in (a, b)]
    if all(folders):
        from beamcam.commands.folders import diff_folders

        if output is not None:
            raise click.UsageError("-o draws two files over each other, not two folders.")
        diff_folders(Path(a), Path(b), as_json, voice, asked)
        return
    if any(folders):
        raise click.UsageError("A and B have to be two files or two folders.")
    if a == b == STANDARD:
        raise click.UsageError("found - twice; expected it once, standard input is read once.")
    try:
        config = settled(asked, (a, b))
        contents = [input_bytes(path) for path in (a, b)]
        data = [(shown_name(path), content) for path, content in zip((a, b), contents, strict=True)]
        machines = [machine_for_program(config, *one) for one in zip((a, b), contents, strict=True)]
        for (name, _), machine in zip(data, machines, strict=True):
            voice.did(f"read {name}, a program as one of {machine.name}")
        found, said = differences_of(data, machines, config.strict)
        if output is not None:
            drawn = drawn_over(data, machines, found, output)
    except BeamcamError as error:
        voice.stop(error.diagnostics)
    voice.did(f"compared them: {len(found)} difference(s)")
    if output is not None:
        write(output, drawn, voice, files_read(config, (a, b)))
    else:
        show(found, as_json)
    if said:
        voice.say(said)
    if found or errors_in(said):
        raise SystemExit(REFUSED)


def show(found: tuple[Difference, ...], as_json: bool) -> None:
    """Print differences on standard output."""
    if as_json:
        say_json([d.as_data() for d in found])
    else:
        say_lines(difference.text for difference in found)
