"""`beamcam plot`: a part, or what a program makes, as a picture."""

from typing import Any

import click

from beamcam.commands import options
from beamcam.commands.common import Console, write
from beamcam.commands.jobs import one_program, posted_job, read_program
from beamcam.commands.parts import job_options, read_parts
from beamcam.commands.settings import files_read, machines_for, settled
from beamcam.commands.value_types import check_paper, paper, picture_suffix, unit


@click.command("plot", cls=options.Grouped)
@options.inputs
@options.output(".svg, .png or .pdf; - is an SVG on standard output.")
@click.option(
    "--show",
    type=click.Choice(["part", "program"]),
    help="What to draw: by default a single part itself, several parts as their bar.",
)
@unit
@paper
@options.machine
@options.config
@options.bar
@options.quantity
@job_options
@options.verbosity
def command(
    inputs: tuple[str, ...], output: str, show: str | None, unit: Any, paper: Any, as_json: bool,
    console: Console, **values: Any,
) -> None:  # fmt: skip
    """Draw a part with its faces unfolded, or what a program makes.

    A program is drawn as its machine reads it: tools or speeds by colour, rapid moves dashed, the
    operations numbered in their order; the picture carries the program's SHA-256. A PDF has a page
    for each part, and needs beamcam[pictures], as a PNG does.

    \b
    beamcam plot M58.nc1 -o m58.svg
    beamcam plot job.gcode --machine beamline-annex -o job.png
    beamcam plot M74.nc1 M58.nc1 M74.nc1 -o bar.svg
    beamcam plot plate.dxf --thickness 3 --show program -o plate.pdf
    """
    from beamcam.pictures.formats import picture
    from beamcam.pictures.part import part_scene
    from beamcam.pictures.program import program_scene

    suffix = picture_suffix(output)
    check_paper(paper, suffix)
    config = settled(values, inputs)
    data = one_program(inputs)
    if data is not None:
        scenes = [program_scene(read_program(data, inputs[0], config, values["bar"]), unit)]
    elif show == "program" or (show is None and len(inputs) > 1):
        scenes = [program_scene(posted_job(inputs, config, values, output, console).program, unit)]
    else:
        parts = read_parts(inputs, config, values, console)
        if not parts or (len(parts) > 1 and suffix != ".pdf"):
            console.say()
            result = f"found {len(parts)} parts for {output!r}"
            raise click.UsageError(f"{result}; expected one, or a .pdf of many pages")
        is_drawn = any(part.measures is not None for part in parts)
        torch = machines_for(config, parts, output)[0].torch if is_drawn else None
        colours = None if torch is None else torch.colours
        scenes = [part_scene(part, unit, colours) for part in parts]
    drawn = picture(scenes, suffix, paper)
    console.did(f"drew {len(scenes)} picture(s)")
    write(output, drawn, console, files_read(config, inputs))
    console.say()
