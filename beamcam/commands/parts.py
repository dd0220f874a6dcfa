"""Shared by the commands that take parts: their options, and reading the parts."""

from collections.abc import Iterable, Mapping
from typing import Any

from beamcam.commands import options
from beamcam.commands.common import Voice, read_all
from beamcam.commands.members import member_choice, member_options
from beamcam.commands.quantities import quantity
from beamcam.commands.sheets import drawing_choice, drawing_options, torch_options
from beamcam.config.values import Config
from beamcam.errors import Diagnostic
from beamcam.machine.machine import Machine
from beamcam.model.description import marked
from beamcam.model.part import Part
from beamcam.model.plan import Order
from beamcam.model.request import Quantity, Request
from beamcam.pipeline import counted, parts_of
from beamcam.planning.rules import named_skips

#: Which parts are meant, and how drawings and sheets are taken.
part_options = options.group(member_options, options.mark_from, drawing_options, torch_options)
#: What a job is posted by, for commands that show what comes of it.
job_options = options.group(
    options.skips,
    options.order,
    options.turn,
    part_options,
    options.strict,
    options.json_messages,
)
#: Of a command that only looks at the work which parts are: `plan` and `verify`.
looking_options = options.group(
    quantity, options.skips, part_options, options.strict, options.as_json, options.voiced
)


def read_parts(
    inputs: Iterable[str], config: Config, asked: Mapping[str, Any], voice: Voice
) -> tuple[tuple[Part, ...], tuple[Diagnostic, ...]]:
    """All parts of the inputs, and what is said of them.

    `asked` holds the values of `part_options`. Raises ReadError.
    """
    how = drawing_choice(asked, config.map) | member_choice(asked, kernel=True)
    parts, said = parts_of(read_all(inputs, config.strict, how, voice), counted)
    return marked(parts, asked["mark_from"]), said


def request_of(
    parts: tuple[Part, ...], config: Config, machine: Machine, quantity: Quantity,
    order: Order = "given", turn: bool = False,
) -> Request:  # fmt: skip
    """What is asked for by options and configuration."""
    return Request(
        parts, machine, named_skips(config.allow_skips), config.job, order, turn,
        config.stock_lengths, quantity=quantity, strict=config.strict,
    )  # fmt: skip
