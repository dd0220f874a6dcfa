"""The option that says how many of each part are wanted."""

from typing import Any

import click

from beamcam.commands.common import STANDARD
from beamcam.commands.rules import MORE_BARS
from beamcam.errors import PlanError, Source
from beamcam.planning.jobs import numbered

FROM_FILE = "file"


class QuantityType(click.ParamType):  # type: ignore[type-arg]
    """`file`, or a number of pieces."""

    name = "quantity"

    def convert(
        self, value: Any, param: click.Parameter | None, ctx: click.Context | None
    ) -> str | int:
        if value == FROM_FILE or isinstance(value, int):
            return value  # type: ignore[no-any-return]
        if value.isascii() and value.isdigit() and 0 < int(value[:9]) <= MAX_QUANTITY:
            return int(value)
        self.fail(f"found {value!r}; expected file, or 1 to {MAX_QUANTITY}", param, ctx)


MAX_QUANTITY = 100_000
quantity = click.option(
    "--quantity", type=QuantityType(), metavar="file|N",
    help="Pieces of each part: as many as its file says, or N.",
)  # fmt: skip


def program_names(output: str, count: int) -> tuple[str, ...]:
    """The names of `count` programs. Raises PlanError for several on standard output."""
    if output == STANDARD and count > 1:
        raise PlanError(MORE_BARS.at(Source("beamcam"), found=count))
    return numbered(output, count)
