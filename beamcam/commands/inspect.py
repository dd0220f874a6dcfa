"""`beamcam inspect`: what a file holds, for people or as data."""

import json
import os.path
import sys
from collections.abc import Callable
from contextlib import ExitStack
from typing import Any

import click

from beamcam.commands.common import REFUSED, as_record, say
from beamcam.commands.members import member_choice, member_options
from beamcam.commands.sheets import DRAWING_NAMES, drawing_options, taken
from beamcam.model.part_json import part_to_json
from beamcam.pipeline import read_file
from beamcam.readers.reading import Reading
from beamcam.report.member_table import member_table
from beamcam.report.part_table import part_table

SCHEMA = "beamcam/inspect/1"


def as_json_object(path: str, reading: Reading) -> dict[str, object]:
    """What `--json` prints: the parts as far as they were read, and every message."""
    return {
        "schema": SCHEMA,
        "file": os.path.basename(path),
        "format": reading.format,
        "parts": [part_to_json(part) for part in reading.parts],
        "diagnostics": [as_record(said) for said in reading.diagnostics],
    }


def show(path: str, reading: Reading) -> None:
    """Print a reading for people: a model's members a line each, other parts at length."""
    click.echo(f"{path}: {reading.format}, {len(reading.parts)} part(s)")
    if reading.format == "ifc":
        for line in member_table(reading.parts, reading.diagnostics):
            click.echo(line)
    else:
        for part in reading.parts:
            click.echo(part_table(part), nl=False)
    say(reading.diagnostics)


def shown_progress(stack: ExitStack, path: str) -> Callable[[int, int], None] | None:
    """A bar on the terminal that follows a long reading; None where there is no terminal."""
    if not sys.stderr.isatty():
        return None
    bar = stack.enter_context(click.progressbar(length=1, label=path, file=sys.stderr))

    def follow(done: int, of: int) -> None:
        bar.length = of
        bar.update(done - bar.pos)

    return follow


@click.command("inspect")
@click.argument("inputs", nargs=-1, required=True, metavar="INPUT...")
@member_options
@drawing_options
@click.option("--check", is_flag=True, help="Check members by the geometry kernel too.")
@click.option("--json", "as_json", is_flag=True, help="Print JSON, one object a file.")
@click.option("--strict", is_flag=True, help="Let warnings refuse a file as errors do.")
def command(inputs: tuple[str, ...], check: bool, as_json: bool, strict: bool, **more: Any) -> None:
    """Print what a file holds, and everything that is wrong with it.

    Exit status 1 if there is an error; what could be read is printed all the same.

    \b
    beamcam inspect M58.nc1
    beamcam inspect M58.nc1 --json | jq '.parts[0].holes | length'
    beamcam inspect --strict *.nc1
    beamcam inspect model.ifc --class IfcColumn
    """
    refused = False
    how = taken(more, DRAWING_NAMES) | member_choice(more, kernel=check)
    for path in inputs:
        with ExitStack() as stack:
            reading = read_file(path, strict, **how, progress=shown_progress(stack, path))
        if as_json:
            click.echo(json.dumps(as_json_object(path, reading), ensure_ascii=False))
        else:
            show(path, reading)
        refused |= reading.refused
    if refused:
        raise SystemExit(REFUSED)
