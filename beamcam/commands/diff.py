"""`beamcam diff`: two programs, or two parts, compared by what they mean."""

import json

import click
from msgspec.structs import asdict

from beamcam import readers
from beamcam.commands.common import REFUSED, say, stop
from beamcam.commands.programs import read_program, shown_name
from beamcam.errors import BeamcamError, VerifyError
from beamcam.machine import Machine, load
from beamcam.pipeline import DEFAULT_MACHINE, parts_of, read_file
from beamcam.verify import Made, run
from beamcam.verify import rules as verify_rules
from beamcam.verify.differ import Difference, diff_parts, diff_programs
from beamcam.verify.statements import diff_sheets

#: What a program may not have if its meaning is to be known.
NOT_UNDERSTOOD = {r.code for r in (verify_rules.SYNTAX, verify_rules.WORD, verify_rules.ARC)}


@click.command("diff")
@click.argument("a")
@click.argument("b")
@click.option("--machine", default=DEFAULT_MACHINE, show_default=True, help="Of both programs.")
@click.option("--json", "as_json", is_flag=True, help="Print the differences as a JSON list.")
def command(a: str, b: str, machine: str, as_json: bool) -> None:
    """Say what program or part B makes otherwise than A.

    Block numbers, comments, spacing, and the order of holes in a part's file count for nothing.
    Exit status: 0 they mean the same, 1 they differ or one cannot be read.

    \b
    beamcam diff yesterday.gcode today.gcode --machine beamline-annex
    beamcam diff M58.nc1 M58-revised.nc1
    """
    try:
        loaded = load(machine)
        kinds = [_is_part(path) for path in (a, b)]
        if kinds[0] != kinds[1]:
            raise click.UsageError("A and B have to be two programs or two parts.")
        if kinds[0]:
            first, _ = parts_of([read_file(a)])
            second, _ = parts_of([read_file(b)])
            found = diff_parts(first, second)
        elif loaded.stock == "sheet":
            found, said = diff_sheets(read_program(a), read_program(b), loaded, shown_name(a))
            if said:
                raise VerifyError(said)
        else:
            found = diff_programs(_made(a, loaded), _made(b, loaded), loaded.format.resolution)
    except BeamcamError as error:
        stop(error.diagnostics, as_json)
    show(found, as_json)
    if found:
        raise SystemExit(REFUSED)


def show(found: tuple[Difference, ...], as_json: bool) -> None:
    """Print differences on standard output."""
    if as_json:
        click.echo(json.dumps([asdict(d) for d in found], ensure_ascii=False, indent=1))
    else:
        for difference in found:
            click.echo(difference.text)


def _is_part(path: str) -> bool:
    """Whether a file is of a format that a reader knows."""
    if any(path.lower().endswith(f.suffixes) for f in readers.FORMATS):
        return True
    data = read_program(path).encode() if path != "-" else b""
    return any(f.looks_like(data) for f in readers.FORMATS)


def _made(path: str, machine: Machine) -> Made:
    """What a program makes, faults and all; VerifyError where its blocks are not understood."""
    done = run(read_program(path), machine, None, shown_name(path))
    if any(d.code in NOT_UNDERSTOOD for d in done.diagnostics):
        raise VerifyError(done.diagnostics)
    say(done.diagnostics)
    return done.made
