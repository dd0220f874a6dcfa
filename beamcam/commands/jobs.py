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
from beamcam.model.part import Part
from beamcam.model.plan import AnyPlan, Order, Plan
from beamcam.pictures import ReadProgram
from beamcam.pipeline import Posted, begin, finished, read_back, untold, whole_job
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
    bar = bar or bar_told(data) or (config.stock_lengths[0] if config.stock_lengths else None)
    return ReadProgram(data, machine, name, PurePath(name).suffix.lower(), bar=bar)


def bar_told(data: bytes) -> float | None:
    """The length of the bar that the head of a program names."""
    head = head_of(data.decode("utf-8", "replace"))
    return None if head is None else head.bar


class PostedJob(Struct, frozen=True):
    """Parts and the program that makes them."""

    diagnostics: tuple[Diagnostic, ...]  #: about the machine
    posted: Posted
    program: ReadProgram


#: Of commands that take a program and its parts, or parts alone.
against = click.option(
    "--against", is_flag=True, help="Compare the program with the parts that follow."
)


def is_program(inputs: Sequence[str], first: bytes, against: bool) -> bool:
    """Whether the first input is a program and the others its parts; or else all are parts.

    `first` is its content. Standard input is a program. Raises UsageError where --against does not
    stand between a program and parts, ReadError for a file of another format.
    """
    refuse_other_format(inputs[0], first)
    is_one = inputs[0] == STANDARD or not is_part(shown_name(inputs[0]), first)
    if against and not is_one:
        raise click.UsageError(
            f"found the part {inputs[0]!r} before --against; expected a program there. Without "
            "--against parts are posted."
        )
    if against and len(inputs) < 2:
        raise click.UsageError("--against needs at least one PART.")
    return is_one


class AskedProgram(Struct, frozen=True):
    """A program that is a file or was posted just now."""

    program: ReadProgram
    plan: AnyPlan | None  #: of one that was posted
    found: tuple[Diagnostic, ...]  #: where one that is a file differs from its parts


def asked_program(
    inputs: Sequence[str], against: bool, config: Config, options: Mapping[str, Any], output: str,
    order: Order, turn: bool, console: Console, diagnostics: list[Diagnostic],
) -> AskedProgram:  # fmt: skip
    """The program among the inputs, read back against the parts behind it; or that of the parts.

    What readers and planner say is added to `diagnostics`, also where it raises BeamcamError.
    """
    first = input_bytes(inputs[0])
    is_file = is_program(inputs, first, against)
    named = inputs[1:] if is_file else inputs
    parts, remarks = read_parts(named, config, options, console) if named else ((), ())
    diagnostics += remarks
    if not is_file:
        job = posted_job(inputs, parts, config, options, output, order, turn, console)
        diagnostics += (*job.diagnostics, *job.posted.remarks)
        return AskedProgram(job.program, job.posted.plan, ())
    program = read_program(first, inputs[0], config, options.get("bar"))
    asked_for = request_of(parts, config, program.machine, options["quantity"])
    request = replace(asked_for, name=shown_name(inputs[0]), style=program.style)
    program = replace(program, parts=whole_job(request).parts)
    bar = options.get("bar") if bar_told(first) else program.bar
    return AskedProgram(program, None, read_back(first, request, bar))


def posted_job(
    inputs: Sequence[str], parts: tuple[Part, ...], config: Config, options: Mapping[str, Any],
    output: str, order: Order, turn: bool, console: Console,
) -> PostedJob:  # fmt: skip
    """The parts of the inputs posted as `post` would, and read back. Raises BeamcamError."""
    machines = machines_for(config, parts, output)
    request = request_of(parts, config, machines[0], options["quantity"], order, turn)
    stage = console.did if console.verbose else untold
    (begun,), choice = on_best_machine(
        request, machines, partial(begin, together=True, stage=stage)
    )
    posted = finished(begun, stage)
    # One part's program is called after its file, as a batch would; `post` is given a name.
    stem = PurePath(shown_name(inputs[0])).stem if len(inputs) == 1 else config.job
    return PostedJob(choice, posted, _program(posted, stem))


def _program(posted: Posted, stem: str) -> ReadProgram:
    plan, machine = posted.plan, posted.job.machine
    is_bar = isinstance(plan, Plan)
    return ReadProgram(
        b"".join(posted.pieces()), machine, f"{stem}{machine.suffix}", machine.suffix,
        tuple(piece.part for piece in plan.pieces) if is_bar else posted.job.parts,
        plan.bar.length if isinstance(plan, Plan) else None,
    )  # fmt: skip
