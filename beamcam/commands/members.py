"""Options of the commands that take building models: which members, how far they are trusted."""

from collections.abc import Callable, Mapping, Sequence
from typing import TYPE_CHECKING, Any

import click

if TYPE_CHECKING:
    from beamcam.model.part import Part
    from beamcam.readers.reading import Reading

Function = Callable[..., Any]


def member_options(function: Function) -> Function:
    """Adds `marks`, `guids`, `classes`, `assemblies` and `force`: which members are meant."""
    for option in (
        click.option("--force", is_flag=True, help="Take members whose data contradict them."),
        click.option("--assembly", "assemblies", multiple=True, help="Members of this assembly."),
        click.option("--class", "classes", multiple=True, help="Members of this IFC class."),
        click.option("--guid", "guids", multiple=True, help="The member with this GlobalId."),
        click.option("--mark", "marks", multiple=True, help="Members of a model with this mark."),
    ):
        function = option(function)
    return function


def member_choice(values: Mapping[str, Any], kernel: bool) -> dict[str, object]:
    """What a reader of models is told; `kernel` has every member checked by a second route."""
    from beamcam.readers.ifc import Options, Selection

    names = ("marks", "guids", "classes", "assemblies")
    return {
        "selection": Selection(*(frozenset(values[name]) for name in names)),
        "options": Options(force=values["force"], kernel=kernel),
    }


def counted(reading: "Reading") -> "Sequence[Part]":
    """The parts of a reading, equal members of a model as one with their number as quantity."""
    if reading.format != "ifc":
        return reading.parts
    from beamcam.readers.ifc.quantities import equal_parts

    return equal_parts(reading.parts)
