"""Shared by the commands that take parts: their options, and reading the parts."""

from collections.abc import Callable, Iterable, Mapping, Sequence
from itertools import compress
from typing import Any

import click

from beamcam.batch.find import FoundInputs, find_inputs
from beamcam.batch.names import other_content
from beamcam.budget import refused_pieces
from beamcam.commands import options
from beamcam.commands.common import Voice, read_all
from beamcam.commands.options import group, quantity
from beamcam.commands.rules import MISSING_EXTRA
from beamcam.commands.settings import machines_of_stock, with_thickness
from beamcam.commands.sheets import drawing_choice, drawing_options, torch_options
from beamcam.config.values import Config, Stock
from beamcam.errors import BeamcamError, Diagnostic, ReadError, Source
from beamcam.machine.machine import Machine
from beamcam.model.description import marked
from beamcam.model.part import Part
from beamcam.model.plan import Order
from beamcam.model.request import Quantity, Request
from beamcam.pipeline import counted, parts_of, sound, stock_of
from beamcam.planning.jobs import number_of
from beamcam.planning.rules import named_skips
from beamcam.readers.content import content
from beamcam.report.part_list import PartCount
from beamcam.system import cores

# --- members --------------------------------------------------------------------------------------

# Options of the commands that take building models: which members, how far they are trusted.


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


#: Which parts are meant, and how drawings and sheets are taken.
part_options = options.group(member_options, options.mark_from, drawing_options, torch_options)
#: What a job is posted by, for commands that show what comes of it.
job_options = options.group(
    options.by,
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
        config.stock_lengths, quantity=quantity, strict=config.strict, by=config.by,
    )  # fmt: skip


# --- programs -------------------------------------------------------------------------------------

# Shared by the commands that read programs.


def input_bytes(path: str) -> bytes:
    """Content of a file, `-` for standard input. Raises ReadError."""
    data = content(path)
    if isinstance(data, Diagnostic):
        raise ReadError(data)
    return data


def program_text(path: str) -> str:
    """The text of a program; bytes that are no text become `\\ufffd`. Raises ReadError."""
    return input_bytes(path).decode("utf-8", "replace")


def counted_parts(
    names: Sequence[str], config: Config, asked: Mapping[str, Any], voice: Voice
) -> tuple[tuple[PartCount, ...], tuple[Diagnostic, ...]]:
    """The parts in order with their quantities, and everything that was said of their files.

    The quantities are those of the files where the job does not say. A part that an error is said
    of is left out, as are files that hold none and parts of which there are too many. Raises
    ReadError for two parts that differ under one mark of an order: nothing is listed then.
    """
    found: FoundInputs = find_inputs(names)
    said: list[Diagnostic] = [*found.diagnostics]
    parts: list[Part] = []
    how = drawing_choice(asked, config.map) | member_choice(asked, kernel=False)
    for reading in read_all((i.path for i in found.inputs), config.strict, how, voice):
        reading = with_thickness(reading, config)
        said += reading.diagnostics
        parts += marked(counted(sound(reading)), asked["mark_from"])
    if mixed := tuple(other_content(parts)):
        raise ReadError((*said, *mixed))
    counts = [PartCount(part, number_of(part, config.quantity)) for part in parts]
    refused = list(refused_pieces((one.part.source, one.quantity) for one in counts))
    said += [one for one in refused if one is not None]
    return tuple(compress(counts, (one is None for one in refused))), tuple(said)


def machines_in_shop(config: Config, name: str) -> Callable[[Part], Sequence[Machine]]:
    """The machines that may make a part, as a batch whose programs are called `name` tries them."""
    of_stock: dict[Stock, Sequence[Machine]] = {}

    def machines_for(part: Part) -> Sequence[Machine]:
        stock = stock_of((part,))
        if stock not in of_stock:
            of_stock[stock] = machines_of_stock(config, stock, name, is_one_of_two=True)
        return of_stock[stock]

    return machines_for


def refuse_missing(error: ImportError, extra: str) -> BeamcamError:
    """The message where a library of an extra is not installed."""
    said = MISSING_EXTRA.at(Source("beamcam"), found=error.name or str(error), extra=extra)
    return ReadError((said,))
