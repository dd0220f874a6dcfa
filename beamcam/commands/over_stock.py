"""The lists of a batch over stock, beside its programs."""

import os
from collections.abc import Iterator

from beamcam.api.shop_lists import label_lines
from beamcam.batch.over_stock import StockRun
from beamcam.batch.rules import NOT_OURS, WRITE
from beamcam.commands.common import over_input
from beamcam.errors import Diagnostic, Source
from beamcam.files import FilesRead, write_whole
from beamcam.report.labels import SCHEMA, Label
from beamcam.report.labels import as_json as labels_as_json
from beamcam.report.part_list import BARS, CUTS, PARTS, bar_list, cutting_list, part_list
from beamcam.report.tables import as_csv

#: How the lists begin.
HEADS = {
    "parts.csv": ",".join(PARTS), "bars.csv": ",".join(BARS), "cuts.csv": ",".join(CUTS),
    "labels.json": SCHEMA,
}  # fmt: skip


def is_stock_list(path: str) -> bool:
    """Whether a file is such a list, by its name and its beginning."""
    head = HEADS.get(os.path.basename(path))
    return head is not None and not _is_strange(path, head)


def stock_lists(run: StockRun) -> Iterator[tuple[str, str]]:
    """Name and content of each list: parts, bars, cuts, and a label for each piece that is made."""
    bars = run.bars()
    yield "parts.csv", as_csv(part_list(run.counts))
    yield "bars.csv", as_csv(bar_list(bars))
    yield "cuts.csv", as_csv(cutting_list(bars))
    labels = [
        Label(part.mark, tuple(label_lines(part, number, of)), program)
        for part, number, of, program in run.labelled()
    ]
    yield "labels.json", labels_as_json(labels)


def write_lists(run: StockRun, folder: str, read: FilesRead, force: bool) -> Iterator[Diagnostic]:
    """Write the lists into the folder of the programs; an error for each that cannot be.

    A file that is no such list is not written over, unless it is forced.
    """
    for name, content in stock_lists(run):
        path = os.path.join(folder, name)
        if over := over_input(path, read):
            yield over
        elif not force and _is_strange(path, HEADS[name]):
            why = "which beamcam did not make"
            yield NOT_OURS.at(Source(path), found=name, why=why)
        else:
            try:
                write_whole(path, content)
            except OSError as error:
                yield WRITE.at(Source(path), found=name, reason=error.strerror or error)


def _is_strange(path: str, head: str) -> bool:
    """Whether a file is there that does not begin as a list does."""
    try:
        with open(path, encoding="utf-8", errors="replace") as file:
            return head not in file.read(len(head) + 100)
    except FileNotFoundError:
        return False
    except OSError:
        return True
