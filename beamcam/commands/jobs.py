"""What the commands share that look at work: parts posted without a file, or a program that is."""

from collections.abc import Mapping, Sequence
from functools import partial
from pathlib import PurePath
from typing import Any

import click
from msgspec import Struct
from msgspec.structs import replace

from beamcam.arguments import on_best_machine
from beamcam.checks.job import head_of
from beamcam.commands.common import STANDARD, Console
from beamcam.commands.diff import is_part, refuse_other_format
from beamcam.commands.parts import input_bytes, read_parts, request_of
from beamcam.commands.settings import machine_for_program, machines_for
from beamcam.config.values import Config
from beamcam.errors import Diagnostic
from beamcam.model.plan import AnyPlan, Plan
from beamcam.pictures import ReadProgram
from beamcam.pipeline import begin, finished, read_back, untold, whole_job
from beamcam.readers import shown_name


def one_program(inputs: Sequence[str]) -> bytes | None:
    """The program that is the only input; None where the inputs are parts. Raises ReadError.

    Standard input is a program: a part that comes from there can be posted first.
    """
    for path in inputs:
        data = input_bytes(path)
        refuse_other_format(path, data)
        if path == STANDARD or not is_part(shown_name(path), data):
            if len(inputs) > 1:
                raise click.UsageError(
                    f"found the program {path!r} among others; expected it alone."
                )
            return data
    return None


def read_program(data: bytes, path: str, config: Config, bar: float | None = None) -> ReadProgram:
    """A program that is a file; its `bar` as it is given, as its head says, or as in store.

    Raises MachineError.
    """
    name = PurePath(shown_name(path)).name  # a picture is the same in each folder
    machine = machine_for_program(config, path, data)
    bar = bar or bar_of_head(data) or (config.stock_lengths[0] if config.stock_lengths else None)
    return ReadProgram(data, machine, name, PurePath(name).suffix.lower(), bar=bar)


def bar_of_head(data: bytes) -> float | None:
    """The length of the bar that the head of a program names."""
    head = head_of(data.decode("utf-8", "replace"))
    return None if head is None else head.bar


#: Of commands that take a program and its parts, or parts alone.
against = click.option(
    "--against", is_flag=True, help="Compare the program with the parts that follow."
)


class AskedProgram(Struct, frozen=True):
    """A program that is a file or was posted just now."""

    program: ReadProgram
    plan: AnyPlan | None = None  #: of one that was posted
    faults: tuple[Diagnostic, ...] = ()  #: where one that is a file differs from its parts


def asked_program(
    inputs: Sequence[str], against: bool, config: Config, options: Mapping[str, Any], output: str,
    console: Console,
) -> AskedProgram:  # fmt: skip
    """The program that is the first input, read back against the parts behind it; or that of parts.

    Standard input is a program. What readers and planner say is among the messages of the console.
    Raises BeamcamError.
    """
    first = input_bytes(inputs[0])
    refuse_other_format(inputs[0], first)
    is_one = inputs[0] == STANDARD or not is_part(shown_name(inputs[0]), first)
    if against and not is_one:
        raise click.UsageError(
            f"found the part {inputs[0]!r} before --against; expected a program there. Without "
            "--against parts are posted."
        )
    if against and len(inputs) < 2:
        raise click.UsageError("--against needs at least one PART.")
    if not is_one:
        return posted_job(inputs, config, options, output, console)
    parts = read_parts(inputs[1:], config, options, console) if inputs[1:] else ()
    program = read_program(first, inputs[0], config, options.get("bar"))
    as_given = request_of(parts, config, program.machine, options["quantity"], {})
    request = replace(as_given, name=shown_name(inputs[0]), style=program.style)
    program = replace(program, parts=whole_job(request).parts)
    bar = options.get("bar") if bar_of_head(first) else program.bar
    return AskedProgram(program, faults=read_back(first, request, bar))


def posted_job(
    inputs: Sequence[str], config: Config, options: Mapping[str, Any], output: str, console: Console
) -> AskedProgram:
    """The parts of the inputs posted as `post` would, and read back. Raises BeamcamError."""
    parts = read_parts(inputs, config, options, console)
    machines = machines_for(config, parts, output)
    request = request_of(parts, config, machines[0], options["quantity"], options)
    stage = console.did if console.verbose else untold
    (begun,), choice = on_best_machine(
        request, machines, partial(begin, together=True, stage=stage)
    )
    posted = finished(begun, stage)
    console.messages += (*choice, *posted.remarks)
    # One part's program is called after its file, as a batch would; `post` is given a name.
    stem = PurePath(shown_name(inputs[0])).stem if len(inputs) == 1 else config.job
    plan, machine, laid = posted.plan, posted.job.machine, posted.job.parts
    bar = plan.bar.length if isinstance(plan, Plan) else None
    if isinstance(plan, Plan):
        laid = tuple(piece.part for piece in plan.pieces)
    data, name = b"".join(posted.pieces()), f"{stem}{machine.suffix}"
    return AskedProgram(ReadProgram(data, machine, name, machine.suffix, laid, bar), plan)
