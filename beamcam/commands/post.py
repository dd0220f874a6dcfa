"""`beamcam post`: parts in, a program out."""

from typing import Any

import click

from beamcam.commands.common import say, stop, write
from beamcam.commands.members import counted, member_choice, member_options
from beamcam.commands.sheets import (
    DRAWING_NAMES,
    drawing_options,
    taken,
    torch_options,
    with_options,
)
from beamcam.commands.tables import outputs, table_style
from beamcam.errors import BeamcamError
from beamcam.machine import load
from beamcam.pipeline import default_machine, parts_of, post, read_file
from beamcam.planning import SKIP_NAMES, Order


@click.command("post")
@click.argument("inputs", nargs=-1, required=True, metavar="INPUT...")
@click.option("-o", "--output", required=True, help="The program's file; - is standard output.")
@click.option("--machine", help="Name or TOML file; by default what suits parts and output.")
@click.option("--bar", type=click.FloatRange(min=0, min_open=True), help="Length of the bar, mm.")
@click.option("--job", default="JOB", show_default=True, help="Name in the program's first line.")
@click.option(
    "--allow-skips",
    "skips",
    multiple=True,
    type=click.Choice(SKIP_NAMES),
    help="Leave out what the machine cannot make, of this kind only; may be repeated.",
)
@click.option(
    "--order",
    type=click.Choice(["given", "best"]),
    default="given",
    show_default=True,
    help="Whether parts lie as named, or so that mitres nest.",
)
@click.option(
    "--style",
    type=click.Choice(["chain", "table"]),
    help="How a trigger program is written; by default as the machine and its length ask for.",
)
@click.option("--turn", is_flag=True, help="Let parts be turned on the rollers.")
@member_options
@drawing_options
@torch_options
@click.option(
    "--no-verify", is_flag=True, help="Do not read the program back; a comment in it says so."
)
@click.option("--strict", is_flag=True, help="Let warnings refuse a part as errors do.")
@click.option("--json", "as_json", is_flag=True, help="Print messages as JSON.")
def command(
    inputs: tuple[str, ...],
    output: str,
    machine: str | None,
    bar: float | None,
    job: str,
    skips: tuple[str, ...],
    order: Order,
    style: str | None,
    turn: bool,
    no_verify: bool,
    strict: bool,
    as_json: bool,
    **more: Any,
) -> None:
    """Turn parts into a machine program.

    Several INPUTs are laid on one bar in the order given; an input named twice is made twice. A
    sheet takes one. Without --machine bars go to beamline, sheets by the suffix of the output to
    plate-linuxcnc (.ngc), plate-codesys (.gcode), laser-grbl (.nc), table-simotion (.st) or
    laser-stepper (.steps, .csv, .bin, .h). Nothing is written unless all of it can be made.

    \b
    beamcam post gasket.dxf -o gasket.ngc --map blue=cut --thickness 3
    beamcam post M58.nc1 -o job.gcode
    beamcam post M74.nc1 M58.nc1 M74.nc1 --machine beamline-annex -o job.gcode
    beamcam post M58.nc1 --bar 12000 -o - | less
    beamcam post model.ifc --mark B12 -o b12.gcode
    """
    try:
        how = taken(more, DRAWING_NAMES) | member_choice(more, kernel=True)
        parts, said = parts_of((read_file(path, strict, **how) for path in inputs), counted)
        loaded = with_options(load(machine or default_machine(parts, output)), more)
        style = table_style(loaded, output, style)
        posted = post(parts, loaded, job, bar, skips, not no_verify, order, turn, strict, style)
    except BeamcamError as error:
        stop(error.diagnostics, as_json)
    for path, content in outputs(posted, loaded, output):
        write(path, content)
    say((*said, *posted.remarks), as_json)
