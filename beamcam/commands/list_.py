"""`beamcam list`: the part list and the cutting list of a folder's parts."""

from collections.abc import Sequence
from pathlib import PurePath
from typing import Any

import click
from msgspec.structs import replace

from beamcam.api.shop_lists import bars_of, left_to_hand
from beamcam.commands import options
from beamcam.commands.common import REFUSED, Voice, write
from beamcam.commands.listed import counted_parts, refuse_missing
from beamcam.commands.members import member_options
from beamcam.commands.quantities import quantity
from beamcam.commands.rules import OUTPUT_FORMAT
from beamcam.commands.settings import files_read, machine_of_stock, machines_of_stock, settled
from beamcam.commands.sheets import drawing_options
from beamcam.config.values import Config
from beamcam.errors import BeamcamError, Diagnostic, Source, errors_in
from beamcam.model.part import Part
from beamcam.pipeline import stock_of
from beamcam.plain_text import terminal_text
from beamcam.planning.rules import named_skips
from beamcam.report.part_list import (
    ByHand,
    CutBar,
    PartCount,
    bar_list,
    cutting_list,
    part_list,
    total_row,
)
from beamcam.report.tables import Table, as_csv, as_json, as_lines, as_xlsx

SCHEMA = "beamcam/list/1"
SUFFIXES = (".txt", ".csv", ".xlsx", ".json")


@click.command("list")
@options.inputs
@options.output("A .txt, .csv, .xlsx or .json; text on standard output if not given.", False)
@options.machine
@options.config
@click.option(
    "--bar", "bars", type=options.Number(above=0), multiple=True, metavar="MM",
    help="Length of stock bars; may be repeated. By default from the configuration.",
)  # fmt: skip
@quantity
@click.option(
    "--table", type=click.Choice(["parts", "bars", "cuts"]), default="parts", show_default=True,
    help="Which table a .csv holds.",
)  # fmt: skip
@member_options
@drawing_options
@options.strict
@options.voiced
def command(
    inputs: tuple[str, ...], output: str, bars: tuple[float, ...], table: str,
    voice: Voice, **asked: Any,
) -> None:  # fmt: skip
    """Write the part list of files and folders, and the cutting list of their bars.

    The part list has mark, profile, length, quantity, grade, weight, holes and marks, and the
    manual work that the machine's program leaves: marks and bevels. Beams are laid on bars of stock
    in the order given, first fit, one section and grade to a bar, with the kerfs and trims of the
    machine. Exit status 1 if an input is refused; the others are listed.

    \b
    beamcam list jobs/
    beamcam list jobs/ --bar 6000 --bar 12000 -o list.xlsx
    beamcam list *.nc1 --quantity 1 -o cuts.csv --table cuts
    """
    try:
        config = settled(asked, inputs)
        counts, said = counted_parts(inputs, config, asked, voice)
        counts = tuple(replace(one, by_hand=_by_hand(one.part, config)) for one in counts)
        nested, refused = _bars(counts, config, tuple(bars) or config.stock_lengths)
        data = _written(output, counts, nested, table)
    except BeamcamError as error:
        voice.stop(error.diagnostics)
    write(output, data, voice, files_read(config, inputs))
    said = (*said, *refused)
    voice.say(said)
    if errors_in(said):
        raise SystemExit(REFUSED)


def _by_hand(part: Part, config: Config) -> ByHand | None:
    """The manual work left by the first machine that makes a part; None if none does."""
    machines = machines_of_stock(config, stock_of([part]), "", is_one_of_two=True)
    return left_to_hand(part, machines, named_skips(config.allow_skips))


def _bars(
    counts: Sequence[PartCount], config: Config, lengths: Sequence[float]
) -> tuple[tuple[CutBar, ...], tuple[Diagnostic, ...]]:
    """The bars that the beams are cut from, and why some beams are on none."""
    if all(one.part.profile.code == "B" for one in counts):
        return (), ()
    return bars_of(counts, machine_of_stock(config, "beam", "", is_one_of_two=True), lengths)


def _written(
    output: str, counts: Sequence[PartCount], bars: Sequence[CutBar], chosen: str
) -> str | bytes:
    """The lists as the suffix of the output says. Raises ReadError for another suffix."""
    parts = part_list(counts)
    tables = {"parts": parts, "bars": bar_list(bars), "cuts": cutting_list(bars)}
    shown = [parts, *((tables["bars"], tables["cuts"]) if bars else ())]
    match PurePath(output).suffix.lower():
        case ".json":
            return as_json(tables.values(), SCHEMA)
        case ".csv":
            return as_csv(tables[chosen])
        case ".xlsx":
            try:
                return as_xlsx(shown)
            except ImportError as error:
                raise refuse_missing(error, "xlsx") from error
        case ".txt":
            return _text(shown)
    if output != "-":
        found = OUTPUT_FORMAT.at(
            Source(output), found=PurePath(output).suffix, expected=", ".join(SUFFIXES)
        )
        raise BeamcamError((found,))
    return _text(shown)


def _text(tables: Sequence[Table]) -> str:
    parts, *others = tables
    whole = replace(parts, rows=(*parts.rows, total_row(parts)))
    return "".join(f"{terminal_text(line)}\n" for line in as_lines([whole, *others]))
