"""`beamcam verify`: a program against the parts that it should make."""

from pathlib import PurePath
from typing import Any

import click

from beamcam.commands import options
from beamcam.commands.common import REFUSED, STANDARD, Voice, say_json
from beamcam.commands.parts import looking_options, read_parts
from beamcam.commands.programs import input_bytes
from beamcam.commands.settings import machine_for, machine_for_program, settled
from beamcam.errors import BeamcamError, Diagnostic, errors_in
from beamcam.pipeline import read_back
from beamcam.posts import Wanted
from beamcam.readers.content import shown_name
from beamcam.report.run import as_message


@click.command("verify")
@click.argument("program", type=options.FILE)
@click.option("--against", is_flag=True, help="Compare with the PARTs that follow.")
@click.argument("parts", nargs=-1, metavar="[PART]...", type=options.FILE)
@options.machine
@options.config
@looking_options
def command(
    program: str,
    against: bool,
    parts: tuple[str, ...],
    as_json: bool,
    voice: Voice,
    **asked: Any,
) -> None:
    """Read PROGRAM back and say what it makes otherwise than its parts.

    The PARTs are given in their order on the bar. Without them the program is only checked by
    itself: syntax, limits, spindles, feeds. Nothing is said of a program that is right.

    \b
    beamcam verify job.gcode --against M58.nc1
    beamcam verify gasket.ngc --against gasket.dxf --machine plate-linuxcnc
    beamcam verify job.gcode --against M74.nc1 M58.nc1 M74.nc1 --machine beamline-annex --json
    beamcam post M58.nc1 -o - | beamcam verify - --against M58.nc1
    """
    if against and not parts:
        raise click.UsageError("--against needs at least one PART.")
    if parts and not against:
        raise click.UsageError("PARTs stand behind --against.")
    if (program, *parts).count(STANDARD) > 1:
        raise click.UsageError("found - twice; expected it once, standard input is read once.")
    said: tuple[Diagnostic, ...] = ()
    try:
        config = settled(asked, parts or (program,))
        wanted, said = read_parts(parts, config, asked, voice)
        data = input_bytes(program)
        if wanted:
            machine = machine_for(config, wanted, program)
        else:
            machine = machine_for_program(config, program)
        style = PurePath(program).suffix.lower()
        found = read_back(
            data,
            Wanted(
                tuple(wanted), machine, tuple(config.allow_skips), shown_name(program), style=style
            ),
        )
    except BeamcamError as error:
        voice.stop((*said, *error.diagnostics))
    voice.did(f"read {shown_name(program)} back on {machine.name}: {len(found)} message(s)")
    if as_json:
        records = [as_message(d) for d in (*said, *found) if voice.wants(d.severity)]
        say_json(records)
        voice.end()
    else:
        voice.say((*said, *found))
    if errors_in(found):
        raise SystemExit(REFUSED)
