"""`beamcam verify`: a program against the parts that it should make."""

import json

import click

from beamcam.commands.common import REFUSED, as_record, say, stop
from beamcam.commands.programs import read_program, shown_name
from beamcam.errors import BeamcamError, errors_in
from beamcam.machine import load
from beamcam.pipeline import default_machine, left_out, parts_of, read_back, read_file
from beamcam.planning import SKIP_NAMES


@click.command("verify")
@click.argument("program")
@click.option("--against", is_flag=True, help="Compare with the PARTs that follow.")
@click.argument("parts", nargs=-1, metavar="[PART]...")
@click.option("--machine", help="Name or TOML file; by default what suits parts and program.")
@click.option(
    "--allow-skips",
    "skips",
    multiple=True,
    type=click.Choice(SKIP_NAMES),
    help="What of this kind is not made may be missing; may be repeated.",
)
@click.option("--json", "as_json", is_flag=True, help="Print what differs as a JSON list.")
def command(
    program: str,
    against: bool,
    parts: tuple[str, ...],
    machine: str | None,
    skips: tuple[str, ...],
    as_json: bool,
) -> None:
    """Read PROGRAM back and say what it makes otherwise than its parts.

    The PARTs are given in their order on the bar. Without them the program is only checked by
    itself: syntax, limits, spindles, feeds. Nothing is said of a program that is right.

    \b
    beamcam verify job.gcode --against M58.nc1
    beamcam verify gasket.ngc --against gasket.dxf --machine plate-linuxcnc
    beamcam verify job.gcode --against M74.nc1 M58.nc1 M74.nc1 --machine beamline-annex --json
    """
    if against and not parts:
        raise click.UsageError("--against needs at least one PART.")
    if parts and not against:
        raise click.UsageError("PARTs stand behind --against.")
    try:
        wanted, said = parts_of(read_file(path) for path in parts)
        loaded = load(machine or default_machine(wanted, program))
        skipped = left_out(wanted, loaded, skips)
    except BeamcamError as error:
        stop(error.diagnostics, as_json)
    text = read_program(program)
    found = read_back(text, wanted, loaded, skipped, shown_name(program))
    if as_json:
        records = [as_record(d) for d in (*said, *found)]
        click.echo(json.dumps(records, ensure_ascii=False, indent=1))
    else:
        say((*said, *found))
    if errors_in(found):
        raise SystemExit(REFUSED)
