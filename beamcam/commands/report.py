"""`beamcam report`: the setup sheet of a program, with playback."""

from pathlib import PurePath
from typing import Any

import click
from msgspec.structs import replace

from beamcam.commands import options
from beamcam.commands.common import REFUSED, Console, write
from beamcam.commands.configuration import configuration_line, machine_line, reference
from beamcam.commands.jobs import against, asked_program
from beamcam.commands.options import Grouped, quantity
from beamcam.commands.outputs import KINDS, check_paper, expected, paper, unit
from beamcam.commands.parts import job_options
from beamcam.commands.settings import files_read, settled
from beamcam.errors import BeamcamError, Diagnostic, errors_in
from beamcam.model.plan import Order


@click.command("report", cls=Grouped)
@options.inputs
@options.output(".html or .pdf; - is HTML on standard output.")
@against
@unit
@paper
@options.machine
@options.config
@options.bar
@quantity
@options.job_name
@job_options
@options.verbosity
def command(
    inputs: tuple[str, ...], output: str, against: bool, unit: Any, paper: Any, order: Order,
    turn: bool, as_json: bool, console: Console, **values: Any,
) -> None:  # fmt: skip
    """Write the setup sheet of a program: one file for the operator.

    INPUTs are parts, which are posted as `post` would, or a program, and behind it (and --against)
    the parts that it has to make. The page holds the verdict of the read-back, the pictures, the
    operations with their times, the tools to load and a playback of the machine; it is
    self-contained. PDF needs beamcam[pictures].

    \b
    beamcam report M58.nc1 -o m58.html
    beamcam report M74.nc1 M58.nc1 M74.nc1 --machine beamline-annex -o bar.html
    beamcam report job.gcode --against M58.nc1 --machine beamline-annex -o job.pdf
    beamcam report plate.dxf --thickness 3 -o plate.html --unit inch
    """
    from beamcam.setup_sheet.content import SheetSources, content_of

    suffix = ".html" if output == "-" else PurePath(output).suffix.lower()
    if suffix not in KINDS["report"]:
        raise click.UsageError(expected(output, "report"))
    check_paper(paper, suffix)
    diagnostics: list[Diagnostic] = []
    try:
        config = settled(values, inputs)
        job = asked_program(
            inputs, against, config, values, output, order, turn, console, diagnostics
        )
        source = SheetSources(job.program, job.plan, tuple(diagnostics), job.found)
        used_file = machine_line(reference(source.program.machine, config))
        settings = (("Machine file", used_file), ("Configuration", configuration_line(config)))
        content = content_of(replace(source, settings=settings), unit)
        sheet: str | bytes
        if suffix == ".pdf":
            from beamcam.setup_sheet.paper import setup_pdf

            sheet = setup_pdf(content, paper)
        else:
            from beamcam.setup_sheet.page import setup_page

            sheet = setup_page(content)
    except BeamcamError as error:
        console.stop((*diagnostics, *error.diagnostics))
    console.did(f"made the sheet of {source.program.name}")
    write(output, sheet, console, files_read(config, inputs))
    console.say((*source.diagnostics, *source.read_back))
    if errors_in(source.read_back):
        raise SystemExit(REFUSED)
