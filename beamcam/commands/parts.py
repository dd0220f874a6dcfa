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
from beamcam.model.part import Part
from beamcam.pipeline import counted, parts_of
from beamcam.planning.bar_jobs import repeated

#: Which parts are meant, and how drawings and sheets are taken.
part_options = options.group(member_options, drawing_options, torch_options)
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
    return parts_of(read_all(inputs, config.strict, how, voice), counted)


def read_pieces(
    inputs: Iterable[str], config: Config, asked: Mapping[str, Any], voice: Voice
) -> tuple[tuple[Part, ...], tuple[Diagnostic, ...]]:
    """The pieces of one program: the parts of the inputs, each as often as `--quantity` says."""
    parts, said = read_parts(inputs, config, asked, voice)
    wanted = asked["quantity"]
    return (parts if wanted is None else repeated(parts, wanted)), said
