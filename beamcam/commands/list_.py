"""`beamcam list`: the part list and the cutting list of a folder's parts."""

import sys
from collections.abc import Callable, Mapping, Sequence
from itertools import compress
from typing import Any

import click
from msgspec.structs import replace

from beamcam.api.shop_lists import bars_of, not_made, planned_counts
from beamcam.batch.find import FoundInputs, find_inputs
from beamcam.batch.names import other_content
from beamcam.budget import refused_pieces
from beamcam.commands import MISSING_EXTRA, options
from beamcam.commands.common import STANDARD, Console, read_all, shows_colour, write
from beamcam.commands.parts import drawing_choice, list_options, member_choice, request_of
from beamcam.commands.settings import (
    files_read,
    machines_of_stock,
    settled,
    with_thickness,
)
from beamcam.commands.value_types import Number
from beamcam.config.values import Config, Stock
from beamcam.errors import BeamcamError, ReadError, Source
from beamcam.machine.machine import Machine
from beamcam.model.part import Part
from beamcam.model.request import are_flats, marked, number_of, remnant_of, stock_of
from beamcam.pipeline import counted
from beamcam.plain_text import terminal_text
from beamcam.readers import sound
from beamcam.reports.part_list import (
    CutBar,
    PartCount,
    bar_list,
    cutting_list,
    part_list,
    total_row,
)
from beamcam.reports.tables import as_csv, as_lines, as_xlsx
from beamcam.reports.tables import as_json as as_json_text

SCHEMA = "beamcam/list/1"
FORMATS = ("txt", "csv", "xlsx", "json")


@click.command("list", cls=options.Grouped)
@options.inputs
@options.output("A .txt, .csv, .xlsx or .json; text on standard output if not given.", False)
@options.to(FORMATS)
@options.machine
@options.by
@options.config
@click.option(
    "--bar", "bars", type=Number(above=0), multiple=True, metavar="MM",
    help="Length of stock bars; may be repeated. By default from the configuration.",
)  # fmt: skip
@options.remnants
@options.quantity
@click.option(
    "--table", type=click.Choice(["parts", "bars", "cuts"]), default="parts", show_default=True,
    help="Which table a .csv holds.",
)  # fmt: skip
@list_options
def command(
    inputs: tuple[str, ...], output: str, to: str | None, bars: tuple[float, ...],
    remnants: tuple[str, ...], table: str, as_json: bool, console: Console, **values: Any,
) -> None:  # fmt: skip
    """Write the part list of files and folders, and the cutting list of their bars.

    The part list has mark, profile, length, quantity, grade, weights, holes and marks, the machine
    that makes the part, and the manual work that its program leaves: marks and bevels. Bars and
    cutting list are those of the plans by which `post` makes the parts, in the order given, first
    fit, one section and grade to a bar, remnants first. A part that no machine makes stands in red
    with its reason and is on no bar. Exit status 1 for such a part, or if an input is refused; the
    others are listed.

    \b
    beamcam list jobs/
    beamcam list jobs/ --bar 6000 --bar 12000 -o list.xlsx
    beamcam list jobs/ --bar 12000 --remnant UPN200=4300
    beamcam list *.nc1 --quantity 1 -o cuts.csv --table cuts
    beamcam list jobs/ --json | jq '.bars'
    """
    form = options.form_of(output, to, as_json, FORMATS, "txt")
    config = settled(values, inputs)
    counts = counted_parts(inputs, config, values, console)
    machine = machines_of_stock(config, "beam", "", is_one_of_two=True)[0]
    lengths = tuple(sorted(bars)) or config.stock_lengths
    request = replace(request_of((), config, machine, None, values), stock=lengths)
    machines = machines_in_shop(config, "")
    there = tuple(map(remnant_of, remnants))
    counts = planned_counts(counts, machines, request, there)
    counts, nested = bars_of(counts, machines, request, there)
    data = _written(form, counts, nested, table, output == STANDARD)
    write(output, data, console, files_read(config, inputs))
    console.messages += not_made(counts)
    console.finish()


def _written(
    form: str, counts: Sequence[PartCount], bars: Sequence[CutBar], chosen: str, is_shown: bool
) -> str | bytes:
    """The lists in a form. Raises ReadError where a library is missing."""
    parts = part_list(counts)
    tables = {"parts": parts, "bars": bar_list(bars), "cuts": cutting_list(bars)}
    shown = [parts, *((tables["bars"], tables["cuts"]) if bars else ())]
    match form:
        case "json":
            return as_json_text(tables.values(), SCHEMA)
        case "csv":
            return as_csv(tables[chosen])
        case "xlsx":
            try:
                return as_xlsx(shown)
            except ImportError as error:
                raise refuse_missing(error, "xlsx") from error
    shown[0] = replace(parts, rows=(*parts.rows, total_row(parts)))
    is_coloured = is_shown and shows_colour(sys.stdout)
    lines = ((terminal_text(line), is_not_made) for line, is_not_made in as_lines(shown))
    return "".join(
        f"{click.style(line, fg='red') if is_not_made and is_coloured else line}\n"
        for line, is_not_made in lines
    )


def counted_parts(
    names: Sequence[str], config: Config, options: Mapping[str, Any], console: Console
) -> tuple[PartCount, ...]:
    """The parts in order with their quantities; the console has what is said of their files.

    The quantities are those of the files where the job does not say. A part that an error is said
    of is left out, as are files that hold none and parts of which there are too many. Raises
    ReadError for two parts that differ under one mark of an order: nothing is listed then.
    """
    inputs: FoundInputs = find_inputs(names)
    console.messages += inputs.diagnostics
    parts: list[Part] = []
    how = drawing_choice(options, config) | member_choice(options, kernel=False)
    for reading in read_all((i.path for i in inputs.inputs), config.strict, how, console):
        reading = with_thickness(reading, config)
        console.messages += reading.diagnostics
        parts += marked(counted(sound(reading)), options["mark_from"])
    if mixed := tuple(other_content(parts)):
        raise ReadError(mixed)
    counts = [PartCount(part, number_of(part, config.quantity)) for part in parts]
    refused = list(refused_pieces((one.part.source, one.quantity) for one in counts))
    console.messages += [one for one in refused if one is not None]
    return tuple(compress(counts, (one is None for one in refused)))


def machines_in_shop(config: Config, name: str) -> Callable[[Part], Sequence[Machine]]:
    """The machines that may make a part, as a batch whose programs are called `name` tries them."""
    of_stock: dict[tuple[Stock, bool], Sequence[Machine]] = {}

    def machines_for(part: Part) -> Sequence[Machine]:
        stock = stock_of((part,), bool(config.sheet.unrolled))
        key = stock, stock == "sheet" and are_flats((part,))
        if key not in of_stock:
            of_stock[key] = machines_of_stock(config, stock, name, True, key[1])
        return of_stock[key]

    return machines_for


def refuse_missing(error: ImportError, extra: str) -> BeamcamError:
    """The message where a library of an extra is not installed."""
    diagnostic = MISSING_EXTRA.at(Source("beamcam"), found=error.name or str(error), extra=extra)
    return ReadError((diagnostic,))
