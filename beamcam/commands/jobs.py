"""What the commands share that look at work: parts posted without a file, or a program that is."""

from collections.abc import Mapping, Sequence
from functools import partial
from pathlib import PurePath
from typing import Any

import click
from msgspec import Struct

from beamcam.commands.common import STANDARD, Voice
from beamcam.commands.comparison import is_part
from beamcam.commands.parts import read_parts, request_of
from beamcam.commands.programs import input_bytes
from beamcam.commands.settings import machine_for_program, machines_for
from beamcam.config.values import Config
from beamcam.errors import Diagnostic
from beamcam.machine_choice import first_that_makes
from beamcam.model.plan import Order, Plan
from beamcam.pictures.program import ReadProgram
from beamcam.pipeline import Posted, begin, finished, untold
from beamcam.readers.content import shown_name


def one_program(inputs: Sequence[str]) -> bytes | None:
    """The program that is the only input; None where the inputs are parts. Raises ReadError.

    Standard input is a program: a part that comes from there can be posted first.
    """
    for path in inputs:
        data = input_bytes(path)
        if path == STANDARD or not is_part(shown_name(path), data):
            if len(inputs) > 1:
                raise click.UsageError(
                    f"found the program {path!r} among others; expected it alone."
                )
            return data
    return None


def read_program(data: bytes, path: str, config: Config) -> ReadProgram:
    """A program that is a file. Raises MachineError."""

    name = PurePath(shown_name(path)).name  # a picture is the same in each folder
    machine = machine_for_program(config, path, data)
    bar = config.stock_lengths[0] if config.stock_lengths else None
    return ReadProgram(data, machine, name, PurePath(name).suffix.lower(), bar=bar)


class PostedJob(Struct, frozen=True):
    """Parts and the program that makes them."""

    said: tuple[Diagnostic, ...]  #: about the parts
    posted: Posted
    program: ReadProgram


def posted_job(
    inputs: Sequence[str], config: Config, asked: Mapping[str, Any], output: str, order: Order,
    turn: bool, voice: Voice,
) -> PostedJob:  # fmt: skip
    """Inputs posted as `post` would, and read back. Raises BeamcamError."""
    parts, said = read_parts(inputs, config, asked, voice)
    machines = machines_for(config, parts, output)
    request = request_of(parts, config, machines[0], asked["quantity"], order, turn)
    stage = voice.did if voice.verbose else untold
    (begun,), choice = first_that_makes(
        request, machines, partial(begin, together=True, stage=stage)
    )
    posted = finished(begun, stage)
    # One part's program is called after its file, as a batch would; `post` is given a name.
    stem = PurePath(shown_name(inputs[0])).stem if len(inputs) == 1 else config.job
    return PostedJob((*said, *choice), posted, _program(posted, stem))


def _program(posted: Posted, stem: str) -> ReadProgram:
    plan, machine = posted.plan, posted.job.machine
    is_bar = isinstance(plan, Plan)
    return ReadProgram(
        b"".join(posted.pieces()), machine, f"{stem}{machine.suffix}", machine.suffix,
        tuple(piece.part for piece in plan.pieces) if is_bar else posted.job.parts,
        plan.bar.length if isinstance(plan, Plan) else None,
    )  # fmt: skip
