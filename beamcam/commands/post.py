"""`beamcam post`: parts in, a program out."""

from typing import Any

import click

from beamcam.commands import options
from beamcam.commands.common import Voice, keep_apart, keep_refused, write
from beamcam.commands.grouped import Grouped
from beamcam.commands.kinds import program
from beamcam.commands.parts import part_options, read_parts
from beamcam.commands.settings import files_read, machine_for, map_remarks, settled
from beamcam.commands.tables import job_name, outputs, table_style, write_list
from beamcam.errors import BeamcamError, Diagnostic
from beamcam.model.plan import Order
from beamcam.pipeline import Posted, RefusedProgram, post, untold
from beamcam.planning.stock import from_store


@click.command("post", cls=Grouped)
@options.inputs
@options.output("The program's file; - is standard output.", kind=program)
@options.machine
@options.config
@options.bar
@options.job_name
@options.skips
@options.exit_left_out
@options.order
@click.option(
    "--style",
    type=click.Choice(["chain", "table"]),
    help="How a trigger program is written; by default as the machine and its length ask for.",
)
@options.turn
@part_options
@options.no_verify
@options.strict
@options.json_messages
@options.voiced
def command(
    inputs: tuple[str, ...],
    output: str,
    order: Order,
    style: str | None,
    turn: bool,
    no_verify: bool,
    exit_left_out: int | None,
    as_json: bool,
    voice: Voice,
    **asked: Any,
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
    said: tuple[Diagnostic, ...] = ()
    try:
        config = settled(asked, inputs)
        parts, said = read_parts(inputs, config, asked, voice)
        machine = machine_for(config, parts, output)
        said += map_remarks(config, parts, machine)
        style = table_style(machine, output, style)
        job = job_name(config, machine, output)

        def made(bar: float | None) -> Posted:
            return post(
                parts, machine, job, bar, config.allow_skips, not no_verify, order, turn,
                config.strict, style, voice.did if voice.verbose else untold,
            )  # fmt: skip

        posted = from_store(made, config.stock_lengths, max((p.length for p in parts), default=0.0))
    except RefusedProgram as error:
        kept = keep_refused(output, error.pieces(), files_read(config, inputs))
        voice.stop((*said, *error.diagnostics, *kept))
    except BeamcamError as error:
        voice.stop((*said, *error.diagnostics))
    if voice.verbose:
        from beamcam.report.ledger import ledger_of

        voice.did(f"{machine.name}: {ledger_of(posted.plan.outcomes)}")
    files, read = tuple(outputs(posted, machine, output)), files_read(config, inputs)
    keep_apart((path for path, _ in files), read, voice)
    write_list(posted, output, voice, read)
    for path, content in files:
        write(path, content, voice, read)
    voice.say((*said, *posted.remarks))
    if posted.leaves_out and exit_left_out is not None:
        raise SystemExit(exit_left_out)
