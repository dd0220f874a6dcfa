"""Options of the commands that take building models: which members, how far they are trusted."""

from collections.abc import Mapping
from typing import Any

import click

from beamcam.commands.options import group
from beamcam.system import cores

#: Which members of a model are meant: `marks`, `guids`, `classes` and `assemblies`.
selection_options = group(
    click.option("--mark", "marks", multiple=True, help="Members of a model with this mark."),
    click.option("--guid", "guids", multiple=True, help="The member with this GlobalId."),
    click.option("--class", "classes", multiple=True, help="Members of this IFC class."),
    click.option("--assembly", "assemblies", multiple=True, help="Members of this assembly."),
)
letter = click.option(
    "--letter", type=click.Choice(["mark"]), help="Letter the members of a model with their marks."
)
#: The same, and `force`: whether they are trusted where their data contradict each other.
member_options = group(
    selection_options,
    click.option("--force", is_flag=True, help="Accept members with contradictory data."),
    letter,
)


def member_choice(
    values: Mapping[str, Any], kernel: bool, workers: int | None = None
) -> dict[str, object]:
    """The options of a reader of models; `kernel` has every member checked by a second route.

    So many `workers` read the members of a large model, or as many as there are cores. Two at
    least: while the kernel builds in another process, this one hears of an interrupt.
    """
    from beamcam.readers.ifc import Options, Selection

    names = ("marks", "guids", "classes", "assemblies")
    return {
        "selection": Selection(*(frozenset(values[name]) for name in names)),
        "options": Options(
            values.get("force", False),
            kernel,
            letter=values.get("letter") == "mark",
            workers=workers or max(cores(), 2),
        ),
    }
