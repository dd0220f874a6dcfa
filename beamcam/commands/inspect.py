"""`beamcam inspect`: what a file holds, for people or as data."""

import json
from pathlib import PurePath

import click

from beamcam.commands.common import REFUSED, as_record, say
from beamcam.errors import Severity
from beamcam.model.part_json import part_to_json
from beamcam.pipeline import read_file
from beamcam.readers.reading import Reading
from beamcam.report.part_table import part_table

SCHEMA = "beamcam/inspect/1"


def as_json_object(path: str, reading: Reading) -> dict[str, object]:
    """What `--json` prints: the parts as far as they were read, and every message."""
    return {
        "schema": SCHEMA,
        "file": PurePath(path).name,
        "format": reading.format,
        "parts": [part_to_json(part) for part in reading.parts],
        "diagnostics": [as_record(said) for said in reading.diagnostics],
    }


@click.command("inspect")
@click.argument("inputs", nargs=-1, required=True, metavar="INPUT...")
@click.option("--json", "as_json", is_flag=True, help="Print JSON, one object a file.")
@click.option("--strict", is_flag=True, help="Let warnings refuse a file as errors do.")
def command(inputs: tuple[str, ...], as_json: bool, strict: bool) -> None:
    """Print what a file holds, and everything that is wrong with it.

    Exit status 1 if there is an error; what could be read is printed all the same.

    \b
    beamcam inspect M58.nc1
    beamcam inspect M58.nc1 --json | jq '.parts[0].holes | length'
    beamcam inspect --strict *.nc1
    """
    refused = False
    for path in inputs:
        reading = read_file(path, strict)
        if as_json:
            click.echo(json.dumps(as_json_object(path, reading), ensure_ascii=False))
        else:
            click.echo(f"{path}: {reading.format}, {len(reading.parts)} part(s)")
            for part in reading.parts:
                click.echo(part_table(part), nl=False)
            say(reading.diagnostics)
        refused |= any(said.severity is Severity.ERROR for said in reading.diagnostics)
    if refused:
        raise SystemExit(REFUSED)
