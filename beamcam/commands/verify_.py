"""`beamcam verify`: a program against the parts that it should make."""

from pathlib import PurePath
from typing import Any

import click
from msgspec.structs import replace

from beamcam.checks.job import head_of, head_remarks
from beamcam.checks.rules import LEFT_OUT, MANUAL_WORK
from beamcam.commands import options
from beamcam.commands.common import (
    REFUSED,
    STANDARD,
    Console,
    is_coded_sheet,
    say_json,
    suffix_of,
)
from beamcam.commands.diff import refuse_part
from beamcam.commands.parts import (
    input_bytes,
    looking_options,
    program_text,
    read_parts,
    request_of,
)
from beamcam.commands.settings import machine_for_program, settled
from beamcam.errors import Diagnostic, errors_in
from beamcam.model.plan import named_skips
from beamcam.model.request import Request
from beamcam.pipeline import begin, finished, read_back, whole_job
from beamcam.readers import shown_name
from beamcam.reports.run import as_message

#: Rules for features that a program may be without.
NOT_MADE = (LEFT_OUT.code, MANUAL_WORK.code)

after = click.option(
    "--after",
    type=options.FILE,
    metavar="WHOLE",
    help="The program that was stopped; by default the one that `post` makes of the PARTs.",
)


@click.command("verify", cls=options.Grouped)
@click.argument("program", type=options.FILE)
@click.option("--against", is_flag=True, help="Compare with the PARTs that follow.")
@click.argument("parts", nargs=-1, metavar="[PART]...", type=options.FILE)
@options.machine
@options.config
@options.bar_of_program
@options.order
@options.turn
@options.from_operation("PROGRAM is the remainder of one, from operation N of `plan`.")
@options.from_contour("PROGRAM is the rest of one of a sheet, from contour N of `plan`.")
@after
@click.option("--solid", is_flag=True, help="Machine PROGRAM as a solid as well, and compare.")
@looking_options
@options.exit_left_out
def command(
    program: str, against: bool, parts: tuple[str, ...], first: int | None, contour: int | None,
    after: str | None, solid: bool, exit_left_out: int | None, as_json: bool, console: Console,
    **values: Any,
) -> None:  # fmt: skip
    """Read PROGRAM back and say where it differs from its parts.

    The PARTs are given in their order on the bar, --quantity says how many of each. Without them
    the program is only checked by itself: syntax, limits, spindles, feeds, clearances, tools.
    Nothing is printed for a correct program.

    Only features that --allow-skips or the configuration names may be missing; where these name
    none, those of the program's head, which --strict and --allow-skips none ignore.

    The remainder that `post --from-operation` made is read back by itself and behind the
    operations before it, of the program that was stopped (--after) or of the one that `post`
    makes of the PARTs; so is the rest of a sheet's program (--from-contour).

    --solid asks for a third opinion: bar, profile, tube or plate are machined as a solid from
    PROGRAM alone, and each piece is compared with the solid of its part.

    \b
    beamcam verify job.gcode --against M58.nc1
    beamcam verify gasket.ngc --against gasket.dxf --machine plate-linuxcnc
    beamcam verify job.gcode --against M74.nc1 M58.nc1 M74.nc1 --machine beamline-annex --json
    beamcam verify sheet.ngc --against gusset.nc1 --quantity 12
    beamcam verify job.gcode --against M58.nc1 --solid
    beamcam post M58.nc1 -o - | beamcam verify - --against M58.nc1
    beamcam verify rest.gcode --from-operation 7 --after job.gcode --against M58.nc1
    """
    where = "--from-contour" if first is None else "--from-operation"
    start = contour if first is None else first
    options.refuse_usage(
        (against and not parts, "--against needs at least one PART."),
        (parts and not against, "PARTs come after --against."),
        (None not in (first, contour), "--from-operation and --from-contour exclude each other."),
        (start is not None and not parts, f"{where} needs the PARTs, behind --against."),
        (after and start is None, "--after needs --from-operation, where PROGRAM goes on."),
        (solid and (not parts or start is not None),
         "--solid needs the PARTs of a whole program, behind --against."),
        ((program, after, *parts).count(STANDARD) > 1,
         "found - twice; expected it once, standard input is read once."),
    )  # fmt: skip
    config = settled(values, parts or (program,))
    expected_parts = read_parts(parts, config, values, console)
    data = input_bytes(program)
    refuse_part(program, data)
    machine = machine_for_program(config, program, data, expected_parts)
    name, bar = shown_name(program), values["bar"]
    head = head_of(data.decode("utf-8", "replace"))
    options.refuse_usage(
        (first is not None and machine.stock != "beam", options.ONE_BAR),
        (contour is not None and not is_coded_sheet(machine), options.ONE_SHEET),
    )
    allowed = config.allow_skips
    if head is not None and not config.strict and "allow_skips" not in config.sources:
        allowed = head.allowed
    request = replace(
        request_of(expected_parts, config, machine, values["quantity"], values),
        name=name, style=suffix_of(program), skips=named_skips(allowed),
    )  # fmt: skip
    diagnostics = list(head_remarks(head, machine, name))
    if start is None:
        diagnostics += read_back(data, request, bar)
    else:
        diagnostics += faults_of_rest(data, request, start, bar, after)
    if solid:
        from beamcam.solid.opinion import solid_faults

        diagnostics += solid_faults(data, request, bar)
    console.did(f"read {name} back on {machine.name}: {len(diagnostics)} message(s)")
    if as_json:
        messages = (*console.messages, *diagnostics)
        say_json([as_message(one) for one in messages if console.wants(one.severity)])
        console.messages.clear()
    else:
        console.say(diagnostics)
    if errors_in(diagnostics):
        raise SystemExit(REFUSED)
    if exit_left_out is not None and any(d.code in NOT_MADE for d in diagnostics):
        raise SystemExit(exit_left_out)


def faults_of_rest(
    rest: bytes, request: Request, first: int, bar: float | None, whole: str | None
) -> tuple[Diagnostic, ...]:
    """Everything that is wrong with the remainder from operation `first` on of a program.

    Of a sheet that is a contour. `whole` is the file of the program that was stopped; without it,
    it is posted anew. `bar` is the bar's length where it is known.
    """
    from beamcam.remainder import faults_of, faults_of_sheet_rest

    of_sheet = is_coded_sheet(request.machine)
    rule = options.ONE_SHEET if of_sheet else options.ONE_BAR
    job = whole_job(request, bar)
    if whole is None:
        name = f"program posted of {PurePath(shown_name(request.parts[0].source.file)).name}"
        begun = begin(replace(request, verified=False, strict=False, name="JOB"))
        if len(begun) != 1:
            raise click.UsageError(rule)
        text = finished(begun[0]).text
    else:
        name, text = shown_name(whole), program_text(whole)
    faults = faults_of_sheet_rest if of_sheet else faults_of
    return faults(rest.decode("utf-8", "replace"), text, first, job, name)
