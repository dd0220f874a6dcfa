"""`beamcam labels`: a label for each piece, with a code that a scanner reads."""

from collections import Counter
from collections.abc import Mapping, Sequence
from itertools import chain, repeat
from pathlib import PurePath
from typing import Any

import click

from beamcam.api.shop_lists import label_lines
from beamcam.arguments import on_best_machine
from beamcam.batch.names import FileNames, output_name
from beamcam.commands import options
from beamcam.commands.common import STANDARD, Console, write
from beamcam.commands.list_ import counted_parts, machines_in_shop, refuse_missing
from beamcam.commands.parts import list_options, request_of
from beamcam.commands.settings import files_read, settled
from beamcam.commands.value_types import parsed
from beamcam.config.values import Config
from beamcam.errors import Diagnostic, PlanError, Source
from beamcam.model.request import numbered
from beamcam.pipeline import plans_of
from beamcam.readers import content
from beamcam.reports.labels import (
    CODES,
    SCHEMA,
    Code,
    Label,
    LabelSize,
    as_pdf,
    as_zpl,
    code_fault,
    labels_in,
)
from beamcam.reports.labels import as_json as labels_as_json
from beamcam.reports.part_list import PartCount

FORMATS = ("pdf", "zpl", "json")
HEAD_BYTES = 100  #: in which a file says what it is


def _size(text: str) -> LabelSize:
    width, height = map(float, text.lower().split("x"))
    if not (40 <= width <= 300 and 25 <= height <= 300):
        raise ValueError(text)
    return LabelSize(width, height)


@click.command("labels", cls=options.Grouped)
@options.inputs
@options.output("A .pdf, a .zpl for Zebra printers, or a .json.", False)
@options.to(FORMATS)
@options.machine
@options.by
@options.config
@options.quantity
@click.option(
    "--size", default="100x60", show_default=True, metavar="WxH",
    callback=parsed(_size, "WIDTHxHEIGHT in mm, 40x25 to 300x300, such as 100x60"),
    help="Width and height of a label, mm.",
)  # fmt: skip
@click.option(
    "--code", type=click.Choice(CODES), default="qr", show_default=True, help="Kind of code."
)
@click.option("--name", metavar="TEMPLATE", help="Names of the programs, as of `batch`.")
@options.bar
@list_options
def command(
    inputs: tuple[str, ...], output: str, to: str | None, size: LabelSize, code: Code,
    as_json: bool, console: Console, **values: Any,
) -> None:  # fmt: skip
    """Write a label for each piece of the parts in files and folders.

    A label has the mark, profile, length, grade, order, drawing, the number of the piece and a QR
    code or DataMatrix: the mark and the name of the program that makes the piece in a batch, a line
    each. The only INPUT may be the labels.json that a batch over stock wrote. Exit status 1 if an
    input is refused or no machine makes a part; the others have their labels.

    \b
    beamcam labels jobs/ -o labels.pdf
    beamcam labels jobs/ -o labels.zpl --size 80x50
    beamcam labels programs/labels.json -o labels.pdf
    beamcam labels jobs/ -o labels.pdf --code datamatrix
    beamcam labels jobs/ --json
    """
    if output == STANDARD and to is None and not as_json:
        raise click.UsageError("Say where the labels go: -o labels.pdf, or --to FORM, or --json.")
    form = options.form_of(output, to, as_json, FORMATS)
    config = settled(values, inputs)
    data = content(inputs[0]) if inputs[0].lower().endswith(".json") and len(inputs) == 1 else b""
    if isinstance(data, bytes) and SCHEMA.encode() in data[:HEAD_BYTES]:  # of a batch over stock
        labels = labels_in(data, inputs[0])
        faults = (code_fault(label, code, Source(inputs[0])) for label in labels)
        if too_long := [fault for fault in faults if fault is not None]:
            raise PlanError(too_long)
    else:
        counts = counted_parts(inputs, config, values, console)
        labels = _labels(counts, config, values, code, console)
    try:
        written = (
            as_zpl(labels, size, code) if form == "zpl"
            else labels_as_json(labels) if form == "json"
            else as_pdf(labels, size, code)
        )  # fmt: skip
    except ImportError as error:
        raise refuse_missing(error, "labels") from error
    write(output, written, console, files_read(config, inputs))
    console.finish()


def _labels(
    counts: Sequence[PartCount], config: Config, options: Mapping[str, Any], code: Code,
    console: Console,
) -> tuple[Label, ...]:  # fmt: skip
    """The labels of all pieces, those of one part one behind the other.

    A part that no machine makes, or whose code would be too long, has none: the console has errors.
    """
    labels: list[Label] = []
    diagnostics: list[Diagnostic] = []
    names = FileNames()
    machines = machines_in_shop(config, config.name or "")
    parts_of = Counter(one.part.source.file for one in counts)
    before: Counter[str] = Counter()
    for one in counts:
        part, file = one.part, one.part.source.file
        before[file] += 1
        tried = machines(part)
        request = request_of((part,), config, tried[0], config.quantity, options)
        try:
            planned, _ = on_best_machine(request, tried, plans_of)
        except PlanError as error:
            diagnostics += error.diagnostics
            continue
        stem, several = PurePath(file).stem, parts_of[file] > 1
        machine, pieces = planned[0].job.machine, [len(one.job.pieces) for one in planned]
        name = output_name(config.name, stem, part, before[file], several, machine)
        programs = [names.take(each, part.mark) for each in numbered(name, len(pieces))]
        fault = code_fault(Label(part.mark, (), programs[-1]), code, part.source)
        if fault is not None:
            diagnostics.append(fault)
            continue
        # Without a quantity one program makes one piece, and runs as often as they are wanted.
        of_piece = [*chain.from_iterable(map(repeat, programs, pieces))]
        labels += (
            Label(part.mark, tuple(label_lines(part, k + 1, one.quantity)),
                  of_piece[min(k, len(of_piece) - 1)])
            for k in range(one.quantity)
        )  # fmt: skip
    console.messages += dict.fromkeys(diagnostics)
    return tuple(labels)
