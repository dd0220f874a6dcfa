"""`beamcam post`: parts in, a program out."""

from collections.abc import Mapping, Sequence
from typing import Any

import click
from msgspec.structs import replace

from beamcam.commands import options
from beamcam.commands.common import Voice, keep_apart, keep_refused, write
from beamcam.commands.grouped import Grouped
from beamcam.commands.kinds import program
from beamcam.commands.parts import part_options, read_parts, request_of
from beamcam.commands.quantities import program_names, quantity
from beamcam.commands.remainders import ONE_BAR, from_operation
from beamcam.commands.settings import (
    files_read,
    machine_asked,
    machines_for,
    map_remarks,
    settled,
)
from beamcam.commands.tables import job_name, outputs, table_style, write_list
from beamcam.config.values import Config
from beamcam.errors import BeamcamError, Diagnostic, PlanError
from beamcam.files import FilesRead
from beamcam.machine.machine import Machine
from beamcam.machine_choice import first_that_makes
from beamcam.model.plan import Order
from beamcam.model.request import Request
from beamcam.pipeline import (
    Begun,
    Posted,
    RefusedProgram,
    StrictError,
    begin,
    finished,
    stock_of,
    untold,
)


@click.command("post", cls=Grouped)
@options.inputs
@options.output("The program's file; - is standard output.", kind=program)
@options.machine
@options.config
@options.bar
@quantity
@options.job_name
@options.job_date
@options.skips
@options.exit_left_out
@options.order
@click.option(
    "--style",
    type=click.Choice(["chain", "table"]),
    help="Form of a trigger program; by default set by the machine and the length.",
)
@options.turn
@from_operation("Write only the remainder of the program, from operation N of `plan`.")
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
    first: int | None,
    no_verify: bool,
    exit_left_out: int | None,
    as_json: bool,
    voice: Voice,
    **asked: Any,
) -> None:
    """Turn parts into a machine program.

    Several INPUTs are laid on one bar in the order given; an input named twice is made twice. With
    --quantity each is made as often as its file or the option says, on as many bars as they need
    (first fit), a program each: NAME-1, NAME-2, and so on. Plates lie on a sheet (--sheet) in rows
    by their boxes, in the order given, on as many sheets as they need. Without --machine the first
    machine that makes all parts is taken: for bars beamline, then beamline-pusher; for sheets, by
    the suffix of the output, plate-linuxcnc, then plate-oxyfuel (.ngc), plate-codesys (.gcode),
    laser-grbl (.nc), plate-mach3 (.tap), table-simotion (.st) or laser-stepper (.steps, .csv, .bin,
    .h). Nothing is written unless everything can be made.

    After a stop in mid bar --from-operation writes the rest of the program: its head says in which
    state the machine has to be, and it is read back as the continuation of what was done.

    \b
    beamcam post gasket.dxf -o gasket.ngc --map blue=cut --thickness 3
    beamcam post M58.nc1 -o job.gcode
    beamcam post M74.nc1 M58.nc1 M74.nc1 --machine beamline-annex -o job.gcode
    beamcam post M58.nc1 --bar 12000 -o - | less
    beamcam post M74.nc1 M58.nc1 --quantity file --bar 12000 -o job.gcode
    beamcam post model.ifc --mark B12 -o b12.gcode
    beamcam post M58.nc1 --from-operation 7 -o rest.gcode
    """
    said: tuple[Diagnostic, ...] = ()
    request: Request | None = None
    strict = bool(asked["strict"])
    try:
        config = settled(asked, inputs)
        strict = config.strict
        parts, said = read_parts(inputs, config, asked, voice)
        machines = machines_for(config, parts, output)
        said += map_remarks(config, parts, machines[0])
        request = request_of(parts, config, machines[0], config.quantity, order, turn)
        request = replace(request, verified=not no_verify, date=asked["date"] or "")
        stage = voice.did if voice.verbose else untold

        def planned(wanted: Request) -> list[tuple[str, Begun]]:
            job = job_name(config, wanted.machine, output)
            told = table_style(wanted.machine, output, style)
            begun = begin(replace(wanted, name=job, style=told), stage=stage)
            return list(zip(program_names(output, len(begun)), begun, strict=True))

        begun, choice = first_that_makes(request, machines, planned)
        said += choice
        made = [(name, finished(each, stage)) for name, each in begun]
        if first is not None:
            made = [(output, _rest(made, first))]
    except RefusedProgram as error:
        kept = keep_refused(output, error.pieces(), files_read(config, inputs))
        voice.stop((*said, *error.diagnostics, *kept))
    except StrictError as error:
        voice.stop((*said, *error.diagnostics))
    except PlanError as error:
        way = () if request is None else (_way_out(request, machines, config, asked),)
        voice.stop((*said, *error.diagnostics, *way))
    except BeamcamError as error:
        from beamcam.pipeline import read_file
        from beamcam.ways_out import ways_to_read

        ways = tuple(ways_to_read(error.diagnostics, read_file, strict))
        voice.stop((*said, *error.diagnostics, *ways))
    _write(made, files_read(config, inputs), voice)
    voice.say((*said, *dict.fromkeys(one for _, each in made for one in each.remarks)))
    if exit_left_out is not None and any(each.leaves_out for _, each in made):
        raise SystemExit(exit_left_out)


def _way_out(
    request: Request, tried: Sequence[Machine], config: Config, asked: Mapping[str, Any]
) -> Diagnostic:
    """What could be asked for instead, of the machines that are shipped for such stock."""
    from beamcam.commands.sheets import drawing_choice
    from beamcam.machine import shipped
    from beamcam.pipeline import read_file
    from beamcam.ways_out import ways_out

    known = {machine.name for machine in tried}
    others = [machine_asked(name, config) for name in shipped() if name not in known]
    stocks = (tried[0].stock, stock_of(request.parts))
    alike = [one for one in others if one is not None and one.stock in stocks]
    how = drawing_choice(asked, config.map)
    read = None if how.get("units") else lambda path, **other: read_file(path, **{**how, **other})
    return ways_out(request, tried, alike, read)


def _rest(made: Sequence[tuple[str, Posted]], first: int) -> Posted:
    """The rest of the only program, from an operation on. Raises PlanError and RefusedProgram."""
    from beamcam.remainder import rest_of

    if made[0][1].job.machine.stock != "beam" or len(made) != 1:
        raise click.UsageError(ONE_BAR)
    return rest_of(made[0][1], first)


def _write(made: Sequence[tuple[str, Posted]], read: FilesRead, voice: Voice) -> None:
    """Write the programs and their lists of manual work, none if one would be written over."""
    files = [
        (name, posted, tuple(outputs(posted, posted.job.machine, name))) for name, posted in made
    ]
    keep_apart((path for _, _, pieces in files for path, _ in pieces), read, voice)
    for name, posted, pieces in files:
        if voice.verbose:
            from beamcam.report.ledger import ledger_of

            voice.did(f"{posted.job.machine.name}: {ledger_of(posted.plan.outcomes)}")
        write_list(posted, name, voice, read)
        for path, content in pieces:
            write(path, content, voice, read)
