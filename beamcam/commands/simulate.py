"""`beamcam simulate`: the axes of a machine over time, from a program."""

import re
from collections.abc import Iterable
from hashlib import sha256
from pathlib import PurePath
from typing import TYPE_CHECKING, Any, Literal

import click

from beamcam.commands import options
from beamcam.commands.common import PICTURES, STANDARD, Console, suffix_of, write
from beamcam.commands.jobs import against, asked_program
from beamcam.commands.parts import job_options
from beamcam.commands.settings import files_read, settled
from beamcam.commands.value_types import Number, address, of_kind, parsed
from beamcam.errors import Diagnostic, Source, VerifyError, errors_in
from beamcam.system import INTERRUPTED, asked_to_end

if TYPE_CHECKING:
    from beamcam.machine.machine import Machine
    from beamcam.pictures.graphs import Study
    from beamcam.simulation.encoder import Encoder
    from beamcam.simulation.trace import Trace, TraceRow

_ENCODER = re.compile(r"(\d{1,9})(x4)?/(\d{1,6}(?:\.\d{1,6})?)(?:/(floor|centre))?")


def _seconds(text: str) -> float:
    """A time such as 10ms or 0.5s."""
    match = re.fullmatch(r"(\d+(?:\.\d+)?)(ms|s)", text)
    if match is None or float(match[1]) <= 0:
        raise ValueError(text)
    return float(match[1]) * {"ms": 0.001, "s": 1.0}[match[2]]


def _encoder(text: str) -> "Encoder | Literal['machine']":
    """COUNTS/TRAVEL: counts of a turn, and the mm that an axis travels in it.

    `x4` behind the counts is quadrature, `/centre` the count that is nearest; `machine` stands for
    the encoder of the machine's file.
    """
    from beamcam.simulation.encoder import Encoder

    if text == "machine":
        return "machine"
    match = _ENCODER.fullmatch(text)
    if match is None or int(match[1]) == 0 or float(match[3]) == 0.0:
        raise ValueError(text)
    return Encoder(int(match[1]), float(match[3]), bool(match[2]), match[4] == "centre")


@click.command("simulate", cls=options.Grouped)
@options.inputs
@against
@options.machine
@options.config
@options.bar
@options.quantity
@click.option(
    "-o", "--output", type=options.FILE, callback=of_kind("simulate"),
    help="The trace as .csv or .json; with --encoder its staircase as .svg, .png, .pdf or .html; "
    "- is CSV on standard output.",
)  # fmt: skip
@click.option(
    "--every", metavar="TIME", callback=parsed(_seconds, "a time above 0 such as 10ms or 0.5s"),
    help="Sample at this step, such as 10ms; else by event.",
)  # fmt: skip
@click.option(
    "--encoder",
    metavar="COUNTS/MM",
    callback=parsed(
        _encoder, "COUNTS/TRAVEL of a turn such as 512/65, 512x4/65/centre, or machine"
    ),
    help="Add encoder readings: counts and travel per turn, such as 512/65 or 512x4/65/centre, or "
    "`machine`: those of the machine's file.",
)
@click.option(
    "--modbus", callback=address(), metavar="HOST:PORT",
    help="Send the trace to this Modbus TCP server.",
)  # fmt: skip
@click.option(
    "--serve", callback=address(), metavar="HOST:PORT",
    help="Act as the controller: a Modbus TCP server, until Ctrl-C.",
)  # fmt: skip
@click.option(
    "--pace",
    type=Number(least=0),
    help="Real seconds per second of machine time; 0 is as fast as possible. "
    "By default 0 to send, 1 to serve.",
)
@job_options
@options.verbosity
def command(
    inputs: tuple[str, ...], against: bool, output: str | None, every: float | None,
    encoder: "Encoder | Literal['machine'] | None", modbus: tuple[str, int] | None,
    serve: tuple[str, int] | None, pace: float | None, as_json: bool, console: Console,
    **values: Any,
) -> None:  # fmt: skip
    """Run a program on a model of its machine and write its axes over time.

    INPUTs are a program, and behind it (and --against) the parts that it has to make; or parts,
    which are posted as `post` would. Of any machine: bars, profiles, plates, lasers, trigger
    programs and step tables. Axes beyond their limits, cuts beyond the saw's reach and
    colliding bodies of the machine are warnings with their time and block. --encoder adds what
    an encoder reads of each axis in mm, a row for each count unless --every is given, and says
    what is lost by its resolution; as a picture it is the staircase about the corner that is
    read furthest off. PNG and PDF need beamcam[pictures].

    \b
    beamcam simulate job.gcode --machine beamline -o trace.csv
    beamcam simulate M58.nc1 -o trace.csv
    beamcam simulate job.gcode --against M58.nc1 -o trace.csv
    beamcam simulate job.gcode -o trace.json --every 10ms
    beamcam simulate shield.st -o stairs.csv --encoder 512/65
    beamcam simulate shield.st -o study.svg --encoder 512/65
    beamcam simulate job.gcode --every 100ms --modbus localhost:502 --pace 1
    beamcam simulate job.gcode --every 50ms --serve 127.0.0.1:5020
    """
    if output is None and modbus is None and serve is None:
        raise click.UsageError(
            "Say where the trace goes: -o FILE, --modbus HOST:PORT or --serve HOST:PORT."
        )
    drawn = output is not None and suffix_of(output) in (*PICTURES, ".html")
    if drawn and encoder is None:
        raise click.UsageError(f"Found {output!r}; expected --encoder, whose staircase it draws.")
    config = settled(values, inputs)
    job = asked_program(inputs, against, config, values, STANDARD, console)
    if len(inputs) > 1 and errors_in(job.faults):
        raise VerifyError(job.faults)
    data, machine, name = job.program.data, job.program.machine, job.program.name
    from beamcam.simulation.encoder import Encoder
    from beamcam.simulation.limits import run_warnings
    from beamcam.simulation.modbus import check_range, send
    from beamcam.simulation.program import simulate_program
    from beamcam.simulation.trace import trace_rows

    done = simulate_program(data, machine, name, job.program.style)
    if errors_in(done.diagnostics):
        raise VerifyError(done.diagnostics)
    trace = done.trace
    console.messages += (*done.diagnostics, *run_warnings(trace, machine, done.section, name))
    if encoder == "machine":
        if (own := machine.triggers) is None:
            fault = f"the file of {machine.name} says nothing of encoders"
            raise click.UsageError(f"Found --encoder machine, but {fault}; expected COUNTS/TRAVEL.")
        centred = own.counted == "centre"
        encoder = Encoder(own.counts_per_turn, own.travel_per_turn, own.quadrature, centred)
    if encoder is not None:
        console.messages.append(_precision(trace, encoder, name))
    console.did(f"ran {name} on {machine.name}")
    if modbus is not None or serve is not None:
        check_range(trace, machine.modbus, Source(machine.name))
    if modbus is not None:
        sent = send(trace_rows(trace, every), machine.modbus, *modbus, pace or 0.0)
        console.tell(f"{sent} rows sent to {modbus[0]}:{modbus[1]}")
    if output is not None:
        content: str | bytes
        if drawn and encoder is not None:
            from beamcam.pictures.graphs import Study

            study = Study(
                PurePath(name).name, sha256(data).hexdigest(), machine.name, trace, encoder
            )
            content = _drawn(output, study)
        else:
            content = _text(output, trace, machine, every, encoder, tuple(console.messages))
        write(output, content, console, files_read(config, inputs))
    console.say()
    if serve is not None:
        pace = 1.0 if pace is None else pace
        _serve(trace_rows(trace, every), machine, serve, pace, console)


def _serve(
    rows: "Iterable[TraceRow]", machine: "Machine", place: tuple[str, int], pace: float,
    console: Console,
) -> None:  # fmt: skip
    """Serve the rows of a trace as registers until they end, or with the exit status of Ctrl-C."""
    from beamcam.simulation.modbus import serve

    def tell(host: str, port: int) -> None:
        console.tell(f"{machine.name} at {host}:{port}; Ctrl-C ends it")

    with asked_to_end() as interrupted:
        serve(rows, machine.modbus, *place, pace, tell, interrupt=interrupted)
    if interrupted:
        raise SystemExit(INTERRUPTED)


def _precision(trace: "Trace", encoder: "Encoder", name: str) -> Diagnostic:
    """Loss of precision by an encoder, with the block of the corner with the largest error."""
    from beamcam.simulation import PRECISION
    from beamcam.simulation.encoder import precision

    study = precision(trace, encoder)
    return PRECISION.at(
        Source(name, study.worst_line or None), count=f"{study.count:.4f}",
        corner=f"{study.max_corner_error:.4f}", step=f"{study.smallest_step:.4f}",
        lost=study.lost_moves, moves=study.moves,
    )  # fmt: skip


def _drawn(output: str, study: "Study") -> str | bytes:
    """The staircase of an encoder as a picture, or as a page. Raises PictureError."""
    from beamcam.pictures.formats import picture
    from beamcam.pictures.graphs import encoder_scene

    if suffix_of(output) == ".html":
        from beamcam.setup_sheet.study_page import study_page

        return study_page(study)
    return picture([encoder_scene(study)], suffix_of(output))


def _text(
    output: str, trace: "Trace", machine: Any, every: float | None, encoder: "Encoder | None",
    diagnostics: tuple[Diagnostic, ...],
) -> str:  # fmt: skip
    from beamcam.plain_text import json_text
    from beamcam.simulation.text import csv_text, json_data

    if suffix_of(output) != ".json":
        return csv_text(trace, machine, every, encoder)
    import msgspec

    text = msgspec.json.encode(json_data(trace, machine, every, encoder, diagnostics))
    return json_text(text.decode("utf-8", "replace")) + "\n"
