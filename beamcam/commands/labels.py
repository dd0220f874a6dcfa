"""`beamcam labels`: a label for each piece, with a code that a scanner reads."""

from collections import Counter
from collections.abc import Sequence
from pathlib import PurePath
from typing import Any

import click

from beamcam.api.shop_lists import label_lines
from beamcam.batch.names import FileNames, output_name
from beamcam.commands import options
from beamcam.commands.common import REFUSED, Voice, write
from beamcam.commands.listed import counted_parts, refuse_missing
from beamcam.commands.members import member_options
from beamcam.commands.quantities import quantity
from beamcam.commands.rules import OUTPUT_FORMAT
from beamcam.commands.settings import files_read, machine_of_stock, settled
from beamcam.commands.sheets import drawing_options
from beamcam.config.values import Config
from beamcam.errors import BeamcamError, Diagnostic, Source, errors_in
from beamcam.model.part import Part
from beamcam.pipeline import stock_of
from beamcam.report.labels import CODES, Code, Label, Size, as_pdf, as_zpl, code_fault
from beamcam.report.part_list import PartCount

SUFFIXES = (".pdf", ".zpl")


def _size(ctx: click.Context, param: click.Parameter, value: str) -> Size:
    try:
        width, height = (float(text) for text in value.lower().split("x"))
    except ValueError:
        width = height = 0.0
    if not (40 <= width <= 300 and 25 <= height <= 300):
        raise click.BadParameter(
            f"found {value!r}; expected WIDTHxHEIGHT in mm, 40x25 to 300x300, such as 100x60"
        )
    return Size(width, height)


@click.command("labels")
@options.inputs
@options.output("A .pdf, or a .zpl for Zebra printers.")
@options.machine
@options.config
@quantity
@click.option(
    "--size", callback=_size, default="100x60", show_default=True, metavar="WxH",
    help="Width and height of a label, mm.",
)  # fmt: skip
@click.option(
    "--code", type=click.Choice(CODES), default="qr", show_default=True, help="Kind of code."
)
@click.option("--name", metavar="TEMPLATE", help="Names of the programs, as of `batch`.")
@member_options
@drawing_options
@options.strict
@options.voiced
def command(
    inputs: tuple[str, ...], output: str, size: Size, code: Code, voice: Voice,
    **asked: Any,
) -> None:  # fmt: skip
    """Write a label for each piece of the parts in files and folders.

    A label has the mark, profile, length, grade, order, drawing, the number of the piece and a QR
    code or DataMatrix: the mark and the name of the program that makes it, a line each. Exit status
    1 if an input is refused; the others have their labels.

    \b
    beamcam labels jobs/ -o labels.pdf
    beamcam labels jobs/ -o labels.zpl --size 80x50
    beamcam labels jobs/ -o labels.pdf --code datamatrix
    """
    try:
        config = settled(asked, inputs)
        counts, said = counted_parts(inputs, config, asked, voice)
        labels, too_long = _labels(counts, config, code)
        said = (*said, *too_long)
        data = _written(output, labels, size, code)
    except BeamcamError as error:
        voice.stop(error.diagnostics)
    write(output, data, voice, files_read(config, inputs))
    voice.say(said)
    if errors_in(said):
        raise SystemExit(REFUSED)


def _labels(
    counts: Sequence[PartCount], config: Config, code: Code
) -> tuple[tuple[Label, ...], tuple[Diagnostic, ...]]:
    """The labels of all pieces, those of one part one behind the other; an error for a part whose
    code would be too long, which has none."""
    labels: list[Label] = []
    said: list[Diagnostic] = []
    names = FileNames()
    parts_of = Counter(one.part.source.file for one in counts)
    before: Counter[str] = Counter()
    for one in counts:
        file = one.part.source.file
        before[file] += 1
        program = _program(one.part, before[file], parts_of[file] > 1, config)
        program = names.take(program, one.part.mark)
        fault = code_fault(Label(one.part.mark, (), program), code, one.part.source)
        if fault is not None:
            said.append(fault)
            continue
        labels += (
            Label(one.part.mark, tuple(label_lines(one.part, piece, one.quantity)), program)
            for piece in range(1, one.quantity + 1)
        )
    return tuple(labels), tuple(said)


def _program(part: Part, number: int, several: bool, config: Config) -> str:
    """Name of a part's program in a batch."""
    machine = machine_of_stock(config, stock_of([part]), config.name or "", is_one_of_two=True)
    stem = PurePath(part.source.file).stem
    return output_name(config.name, stem, part, number, several, machine)


def _written(output: str, labels: Sequence[Label], size: Size, code: Code) -> str | bytes:
    """The labels as the suffix of the output says. Raises BeamcamError for another suffix."""
    suffix = PurePath(output).suffix.lower()
    if suffix == ".zpl":
        return as_zpl(labels, size, code)
    if suffix != ".pdf":
        found = OUTPUT_FORMAT.at(Source(output), found=suffix, expected=", ".join(SUFFIXES))
        raise BeamcamError((found,))
    try:
        return as_pdf(labels, size, code)
    except ImportError as error:
        raise refuse_missing(error, "labels") from error
