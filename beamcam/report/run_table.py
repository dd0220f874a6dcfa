"""The account of a run as CSV: a row for each part, and one for each file that has none."""

import csv
import io
from collections.abc import Iterable, Iterator

from beamcam.plain_text import harmless_cell
from beamcam.report.run import Counts, Message, PartRow, Row, encoded, message_line

HEAD = (
    "file", "status", "format", "seconds", "mark", "quantity", "pieces", "profile", "length",
    "machine", "output", "bar", "features", "made", "merged", "duplicate", "listed", "skipped",
    "tools", "operations", "machine_time_s", "errors", "warnings", "notes", "messages",
)  # fmt: skip


def as_csv(rows: Iterable[Row], counts: Counts, said: Iterable[Message]) -> Iterator[bytes]:
    """The report as CSV, piece by piece, with a head. What is said of the run ends it as rows."""
    yield _line(HEAD)
    for row in rows:
        file = (row["file"], row["status"], row["format"], f"{row['seconds']:.4f}")
        severities = [m["severity"] for m in row["messages"]]
        weights = tuple(severities.count(kind) for kind in ("error", "warning", "note"))
        text = " | ".join(message_line(m, file=False) for m in row["messages"])
        parts = [_cells(part) for part in row["parts"]] or [("",) * len(_CELLS)]
        for number, cells in enumerate(parts):
            # What is said of a file stands in its first row, so that sums over a column hold.
            yield _line((*file, *cells, *(weights if number == 0 else (0, 0, 0)),
                         text if number == 0 else ""))  # fmt: skip
    for message in said:
        severity = message["severity"]
        weights = tuple(int(severity == kind) for kind in ("error", "warning", "note"))
        yield _line(
            (
                message["file"],
                "",
                "",
                "",
                *("",) * len(_CELLS),
                *weights,
                message_line(message, file=False),
            )
        )


_CELLS = HEAD[4:21]


def _cells(part: PartRow) -> tuple[object, ...]:
    ledger, seconds = part["ledger"], part["machine_time_s"]
    return (
        part["mark"], part["quantity"], part["pieces"], part["profile"],
        f"{part['length']:g}", part["machine"], part["output"], f"{part['bar']:g}",
        ledger["read"], ledger["made"], ledger["merged"],
        ledger["duplicate"], ledger["listed"], ledger["skipped"],
        " ".join(t.replace(" ", "-") for t in part["tools"]),
        part["operations"], "" if seconds is None else f"{seconds:.1f}",
    )  # fmt: skip


def _line(cells: Iterable[object]) -> bytes:
    out = io.StringIO()
    csv.writer(out, lineterminator="\n").writerow(harmless_cell(cell) for cell in cells)
    return encoded(out.getvalue())
