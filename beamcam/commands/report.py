"""`beamcam report`: the setup sheet of a program, with playback."""

from pathlib import PurePath
from typing import Any

import click
from msgspec.structs import replace

from beamcam.commands import options
from beamcam.commands.common import REFUSED, Voice, write
from beamcam.commands.comparison import is_part
from beamcam.commands.grouped import Grouped
from beamcam.commands.jobs import posted_job, read_program
from beamcam.commands.kinds import KINDS, expected
from beamcam.commands.parts import job_options, read_parts, request_of
from beamcam.commands.pictures import unit
from beamcam.commands.programs import input_bytes
from beamcam.commands.provenance import configuration_line, machine_line, reference
from beamcam.commands.quantities import quantity
from beamcam.commands.settings import files_read, settled
from beamcam.config.values import Config
from beamcam.errors import BeamcamError, errors_in
from beamcam.model.plan import Order
from beamcam.readers.content import shown_name


@click.command("report", cls=Grouped)
@options.inputs
@options.output(".html or .pdf; - is HTML on standard output.")
@unit
@options.machine
@options.config
@options.bar
@quantity
@options.job_name
@job_options
@options.voiced
def command(
    inputs: tuple[str, ...],
    output: str,
    unit: Any,
    order: Order,
    turn: bool,
    as_json: bool,
    voice: Voice,
    **asked: Any,
) -> None:
    """Write the setup sheet of a program: one file for the operator.

    INPUTs are parts, which are posted as `post` would, or a program, and behind it the parts that
    it has to make. The page holds the verdict of the read-back, the pictures, the operations with
    their times, the tools to load and a playback of the machine; it is self-contained. PDF needs
    beamcam[pictures].

    \b
    beamcam report M58.nc1 -o m58.html
    beamcam report M74.nc1 M58.nc1 M74.nc1 --machine beamline-annex -o bar.html
    beamcam report job.gcode M58.nc1 --machine beamline-annex -o job.pdf
    beamcam report plate.dxf --thickness 3 -o plate.html --unit inch
    """
    from beamcam.setup_sheet.content import SheetSources, content_of

    suffix = ".html" if output == "-" else PurePath(output).suffix.lower()
    if suffix not in KINDS["report"]:
        raise click.UsageError(expected(output, "report"))
    source = None
    try:
        config = settled(asked, inputs)
        first = input_bytes(inputs[0])
        if inputs[0] == "-" or not is_part(shown_name(inputs[0]), first):
            source = _of_program(first, inputs, config, asked, voice)
        else:
            job = posted_job(inputs, config, asked, output, order, turn, voice)
            source = SheetSources(job.program, job.posted.plan, (*job.said, *job.posted.remarks))
        used_file = machine_line(reference(source.program.machine, config))
        settings = (("Machine file", used_file), ("Configuration", configuration_line(config)))
        content = content_of(replace(source, settings=settings), unit)
        sheet: str | bytes
        if suffix == ".pdf":
            from beamcam.setup_sheet.paper import setup_pdf

            sheet = setup_pdf(content)
        else:
            from beamcam.setup_sheet.page import setup_page

            sheet = setup_page(content)
    except BeamcamError as error:
        voice.stop((*(source.said if source else ()), *error.diagnostics))
    voice.did(f"made the sheet of {source.program.name}")
    write(output, sheet, voice, files_read(config, inputs))
    voice.say((*source.said, *source.found))
    if errors_in(source.found):
        raise SystemExit(REFUSED)


def _of_program(
    data: bytes, inputs: tuple[str, ...], config: Config, asked: dict[str, Any], voice: Voice
) -> Any:
    """A program that is a file, compared with the parts behind it."""
    from beamcam.pipeline import read_back, whole_job
    from beamcam.setup_sheet.content import SheetSources

    parts, said = read_parts(inputs[1:], config, asked, voice) if inputs[1:] else ((), ())
    program = read_program(data, inputs[0], config)
    asked_for = request_of(parts, config, program.machine, asked["quantity"])
    request = replace(asked_for, name=shown_name(inputs[0]), style=program.style)
    program = replace(program, parts=whole_job(request).parts)
    return SheetSources(program, None, said, read_back(data, request, program.bar))
