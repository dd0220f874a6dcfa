"""`beamcam recover`: the parts that a program makes."""

import os
from pathlib import PurePath
from typing import Any

import click

from beamcam.commands import SECTION, options
from beamcam.commands.common import STANDARD, Console, read_all
from beamcam.commands.convert import is_folder, target_of, write_parts
from beamcam.commands.diff import refuse_part
from beamcam.commands.parts import input_bytes, torch_options
from beamcam.commands.settings import files_read, machine_for_program, settled
from beamcam.config.values import Config
from beamcam.errors import ReadError, Source, errors_in
from beamcam.model.part import Profile
from beamcam.model.section import measures_of
from beamcam.pipeline import as_error
from beamcam.readers import shown_name
from beamcam.recovery import KnownStock, recover, with_marks
from beamcam.writers import TARGETS

#: controllers whose programs are understood here
READ_BY = ("codesys", "linuxcnc", "grbl", "mach3")


@click.command("recover", cls=options.Grouped)
@click.argument("program", type=options.FILE)
@options.output("File, folder/ for a file a part, or -.")
@options.machine
@options.config
@click.option("--to", type=click.Choice([t.name for t in TARGETS]), help="Format.")
@click.option(
    "--profile",
    metavar="FILE|NAME",
    help="Section of the bar: a part's file, or a name such as IPE200.",
)
@torch_options
@options.strict
@options.json_messages
@options.verbosity
def command(
    program: str, output: str, to: str | None, profile: str | None, as_json: bool,
    console: Console, **values: Any,
) -> None:  # fmt: skip
    """Write the part that PROGRAM makes as DSTV, JSON or a drawing of its faces.

    Of a bar each piece between two cuts is a part, with its end cuts, holes, slots and marks;
    alike ones are one file with their number. Of a sheet it is its contours, without leads and
    kerf; of a coper what falls out of each wall. The program is read back against what was
    found: nothing is written that it does not make exactly.

    \b
    beamcam recover job.gcode --profile UPN200 -o part.nc1
    beamcam recover job.gcode --machine beamline-pusher --profile M58.nc1 -o parts/
    beamcam recover gasket.ngc --machine plate-linuxcnc --thickness 3 -o gasket.json
    """
    config = settled(values, (program,))
    target = target_of(output, to)
    data = input_bytes(program)
    refuse_part(program, data)
    text = data.decode("utf-8", "replace")
    machine = machine_for_program(config, program, text)
    if machine.controller not in READ_BY:
        raise click.UsageError(
            f"found the machine {machine.name}; expected one for bars, or a table that runs "
            "G-code: recover reads no triggers and no step tables."
        )
    stock = _stock(profile, config, console)
    name = shown_name(program)
    result = recover(text, machine, name, stock)
    console.messages += result.diagnostics
    if config.strict:
        console.messages[:] = map(as_error, console.messages)
    if errors_in(console.messages):
        console.finish()
    console.did(f"read {name} on {machine.name}: {len(result.parts)} part(s)")
    named = name if output == STANDARD or is_folder(output) else output
    parts = result.parts if result.marked else with_marks(result.parts, PurePath(named).stem)
    read = files_read(config, (program, *((profile,) if profile else ())))
    write_parts(name, parts, target, output, console, read)
    console.finish()


def _stock(profile: str | None, config: Config, console: Console) -> KnownStock:
    """The bar's section and steel, of a part's file or by the section's name. Raises ReadError."""
    if profile is None:
        return KnownStock(has_thickness=config.sheet.thickness is not None)
    by_name = measures_of(profile)
    if by_name is not None and not os.path.exists(profile):
        code, sizes = by_name
        return KnownStock(Profile(code, profile.upper(), *sizes))
    if not os.path.exists(profile):
        raise ReadError(SECTION.at(Source(profile), found=profile))
    (reading,) = read_all((profile,), bool(config.strict), {}, console)
    if errors_in(reading.diagnostics) or not reading.parts:
        raise ReadError(reading.diagnostics or (SECTION.at(Source(profile), found=profile),))
    console.messages += reading.diagnostics
    part = reading.parts[0]
    return KnownStock(part.profile, part.grade)
