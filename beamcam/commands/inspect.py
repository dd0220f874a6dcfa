"""`beamcam inspect`: what a file holds, for people or as data."""

import os.path
from typing import Any

import click

from beamcam.commands import options
from beamcam.commands.common import REFUSED, Console, followed, say_json, say_lines
from beamcam.commands.parts import (
    drawing_choice,
    drawing_options,
    member_choice,
    member_options,
    thickness,
)
from beamcam.commands.settings import settled, with_thickness
from beamcam.model.part_json import part_to_json
from beamcam.pipeline import read_file
from beamcam.readers import shown_name
from beamcam.reports.run import as_message
from beamcam.reports.tables import member_table, part_table

SCHEMA = "beamcam/inspect/1"


@click.command("inspect", cls=options.Grouped)
@options.inputs
@options.config
@member_options
@drawing_options
@thickness
@click.option(
    "--check/--no-check",
    default=True,
    help="Check the cuts of a model's members against the geometry kernel.",
)
@click.option("--json", "as_json", is_flag=True, help="Print JSON, one object per file.")
@options.strict
@options.verbosity
def command(
    inputs: tuple[str, ...], check: bool, as_json: bool, console: Console, **values: Any
) -> None:
    """Print what a file holds, and everything that is wrong with it.

    Exit status 1 if there is an error; what could be read is printed all the same.

    \b
    beamcam inspect M58.nc1
    beamcam inspect M58.nc1 --json | jq '.parts[0].holes | length'
    beamcam inspect --strict *.nc1
    beamcam inspect gasket.dxf --thickness 3
    beamcam inspect model.ifc --class IfcColumn
    """
    config = settled(values, inputs)
    refused = False
    how = drawing_choice(values) | member_choice(values, kernel=check)
    for path in inputs:
        with followed(path, console) as follow:
            read = read_file(path, config.strict, **how, progress=follow)
        reading = with_thickness(read, config)
        console.did(f"read {shown_name(path)}")
        if as_json:  # the parts as far as they were read, and every message
            whole = {
                "schema": SCHEMA, "file": os.path.basename(path), "format": reading.format,
                "parts": [part_to_json(part) for part in reading.parts],
                "diagnostics": [as_message(diagnostic) for diagnostic in reading.diagnostics],
            }  # fmt: skip
            say_json(whole, None)
        else:
            say_lines([f"{path}: {reading.format}, {len(reading.parts)} part(s)"])
            if reading.format == "ifc":  # a member a line
                say_lines(member_table(reading.parts, reading.diagnostics))
            else:
                say_lines(line for part in reading.parts for line in part_table(part))
            console.say(reading.diagnostics)
        refused |= reading.refused
    if refused:
        raise SystemExit(REFUSED)
