"""`beamcam simulate`: the axes of the cell over time, from a program."""

import re
from typing import Any

import click

from beamcam.commands import options
from beamcam.commands.common import Voice, say_lines, write
from beamcam.commands.kinds import of_kind
from beamcam.commands.programs import program_text
from beamcam.commands.settings import files_read, machine_for_program, settled
from beamcam.errors import BeamcamError, VerifyError, errors_in
from beamcam.readers.content import shown_name
from beamcam.simulate.course import rows, stretches, trace
from beamcam.verify.bars import run

_UNITS_S = {"ms": 0.001, "s": 1.0}


class Duration(click.ParamType):  # type: ignore[type-arg]  # older versions take none
    """A time such as 10ms or 0.5s, in seconds."""

    name = "time"

    def convert(
        self, value: object, param: click.Parameter | None, ctx: click.Context | None
    ) -> float:
        match = re.fullmatch(r"(\d+(?:\.\d+)?)(ms|s)", str(value))
        if match is None or float(match[1]) <= 0:
            self.fail(f"found {value!r}; expected a time above 0 such as 10ms or 0.5s", param, ctx)
        return float(match[1]) * _UNITS_S[match[2]]


class Address(click.ParamType):  # type: ignore[type-arg]
    """HOST:PORT."""

    name = "host:port"

    def convert(
        self, value: object, param: click.Parameter | None, ctx: click.Context | None
    ) -> tuple[str, int]:
        host, colon, port = str(value).rpartition(":")
        if not (colon and host and port.isdigit() and 0 < int(port) < 65536):
            self.fail(f"found {value!r}; expected HOST:PORT such as localhost:502", param, ctx)
        return host.strip("[]"), int(port)


@click.command("simulate")
@click.argument("program", type=options.FILE)
@options.machine
@options.config
@click.option(
    "-o", "--output", type=options.FILE, callback=of_kind("simulate"),
    help="The trace's CSV file; - is standard output.",
)  # fmt: skip
@click.option("--every", type=Duration(), help="Sample at this step, such as 10ms; else by event.")
@click.option("--modbus", type=Address(), help="Send the trace to this Modbus TCP server.")
@click.option(
    "--pace",
    type=options.Number(least=0),
    default=0.0,
    show_default=True,
    help="Seconds to send a second of the cell in; 0 is as fast as it goes.",
)
@options.json_messages
@options.voiced
def command(
    program: str,
    output: str | None,
    every: float | None,
    modbus: tuple[str, int] | None,
    pace: float,
    as_json: bool,
    voice: Voice,
    **asked: Any,
) -> None:
    """Run PROGRAM on a model of the cell and write where its axes are when.

    \b
    beamcam simulate job.gcode --machine beamline -o trace.csv
    beamcam simulate job.gcode -o trace.csv --every 10ms
    beamcam simulate job.gcode --every 100ms --modbus localhost:502 --pace 1
    """
    if output is None and modbus is None:
        raise click.UsageError("Say where the trace goes: -o FILE or --modbus HOST:PORT.")
    try:
        config = settled(asked, (program,))
        text = program_text(program)
        machine = machine_for_program(config, program, text)
        if machine.stock != "beam":
            raise click.UsageError(f"{machine.name} is no cell; simulate runs programs for bars.")
        done = run(text, machine, None, shown_name(program))
        if errors_in(done.diagnostics):
            raise VerifyError(done.diagnostics)
        course = stretches(done.events, done.dialect, dict(done.made.section), machine)
        voice.did(f"ran {shown_name(program)} on {machine.name}")
        if modbus is not None:
            from beamcam.simulate.modbus import send

            sent = send(rows(course, every), *modbus, pace)
            if not (voice.quiet or as_json):
                say_lines([f"{sent} rows sent to {modbus[0]}:{modbus[1]}"], err=True)
    except BeamcamError as error:
        voice.stop(error.diagnostics)
    if output is not None:
        write(output, trace(course, machine, every), voice, files_read(config, (program,)))
    voice.say(done.diagnostics)
