"""Options of the commands that take drawings and cut sheets."""

from collections.abc import Callable, Mapping
from typing import Any

import click

from beamcam.errors import PlanError, Source
from beamcam.machine.machine import Machine
from beamcam.machine.overlay import MEANINGS, Meaning, with_torch
from beamcam.planning.contours import rules

Function = Callable[..., Any]
_POSITIVE = click.FloatRange(min=0, min_open=True)

DRAWING_NAMES = ("units", "width", "layers")
_TORCH_NAMES = ("thickness", "material", "kerf", "kerf_by", "lead", "tabs", "place")


def _map(ctx: click.Context, param: click.Parameter, values: tuple[str, ...]) -> dict[str, Meaning]:
    """ "red=cut" as {"red": "cut"}."""
    table: dict[str, Meaning] = {}
    for value in values:
        key, _, wanted = value.rpartition("=")
        meaning = next((m for m in MEANINGS if m == wanted.strip()), None)
        if not key.strip() or meaning is None:
            raise click.BadParameter(rules.MAP.message.format(found=value))
        table[key.strip()] = meaning
    return table


def drawing_options(function: Function) -> Function:
    """Adds how a drawing is read: `units`, `width` and `layers`."""
    for option in (
        click.option("--layers", multiple=True, help="Read this layer only; may be repeated."),
        click.option("--width", help="Width of an SVG's page, as 600mm."),
        click.option("--units", help="Unit of a drawing's numbers: mm, in, cm, ..."),
    ):
        function = option(function)
    return function


def torch_options(function: Function) -> Function:
    """Adds what is said about a sheet and its cuts, over what the machine's file says."""
    for option in (
        click.option("--place", type=click.Choice(["corner", "drawn"]),
                     help="Move a sheet to the corner of the table, or leave it as drawn."),
        click.option("--tabs", type=click.IntRange(min=0), help="Bridges in each outer contour."),
        click.option("--lead", type=click.Choice(["none", "line", "arc"]),
                     help="The way from the pierced hole to the contour."),
        click.option("--kerf-by", type=click.Choice(["none", "offset", "machine"]),
                     help="Who keeps half a kerf off the contours."),
        click.option("--kerf", type=click.FloatRange(min=0), help="Width of the cut, mm."),
        click.option("--material", help="What the sheet is made of, as the machine's file has it."),
        click.option("--thickness", type=_POSITIVE, help="Thickness of a drawing's sheet, mm."),
        click.option("--map", "colours", multiple=True, callback=_map, metavar="KEY=PROCESS",
                     help="What is done with a colour or layer: cut, mark, engrave or ignore."),
    ):  # fmt: skip
        function = option(function)
    return function


def taken(values: Mapping[str, Any], names: tuple[str, ...]) -> dict[str, Any]:
    """Those of the options that were given."""
    return {name: values[name] for name in names if values[name] not in (None, ())}


def with_options(machine: Machine, values: Mapping[str, Any]) -> Machine:
    """The machine as the options of `torch_options` want it. Raises PlanError if it cannot be."""
    try:
        return with_torch(machine, values["colours"], **taken(values, _TORCH_NAMES))
    except ValueError as error:
        raise PlanError(rules.OPTION.at(Source(machine.name), found=error)) from error
