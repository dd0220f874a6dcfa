"""The account of a run over many files: what became of each, as data and as JSON.

The rows are plain data, so that they pass between processes and into a report as they are.
"""

import csv
import io
import json
from collections import Counter
from collections.abc import Iterable, Iterator, Mapping
from typing import Any, Literal, TypedDict

import msgspec
from msgspec import Struct, field

from beamcam.errors import Diagnostic
from beamcam.model.plan import Outcome
from beamcam.plain_text import harmless_cell, json_text, terminal_text
from beamcam.planning.manual_list import ManualRow

SCHEMA = "beamcam/run/1"

#: What can become of a file: posted; nothing to do, since its outputs stand as they were made;
#: refused for what is in it; failed for what is around it (the disk, a process, a fault here).
Status = Literal["posted", "unchanged", "refused", "failed"]
STATUSES: tuple[Status, ...] = ("posted", "unchanged", "refused", "failed")


#: How the ledger calls what is missing though it was not allowed by name: what the map of colours
#: and layers ignores, and what is too small to be cut.
NOT_BY_NAME = ("map-ignore", "plan-tiny")


class Message(TypedDict):
    """A diagnostic as data."""

    file: str
    line: int | None
    where: str | None
    severity: str
    code: str
    message: str


class Ledger(TypedDict):
    """Outcomes of a part's features; `read` is the sum of the others."""

    read: int
    made: int
    merged: int
    duplicate: int
    listed: int  #: for manual work
    skipped: int
    passed_on: int  #: to the next machine, by the file of the rest


class LaidPiece(TypedDict):
    """A piece of a program that is made of the parts of several files."""

    piece: int  #: which of the pieces that were to go on the bar or sheet
    at: float  #: x of its x 0 on the bar, mm
    turn: str  #: how it lies


class StockRow(TypedDict):
    """The bar of such a program; of a sheet its pieces alone."""

    remnant: float  #: mm that are left
    cuts: float  #: mm of kerfs and trims
    pieces: list[LaidPiece]


class RestRow(TypedDict):
    """The file of what a program leaves to the next machine, whose program is in the next row."""

    output: str  #: below the output folder, with "/"
    sha256: str
    features: int


class PartRow(TypedDict):
    """One program that was posted, and its part."""

    mark: str
    quantity: int
    pieces: int  #: that the program makes
    profile: str
    order: str
    phase: str
    length: float
    machine: str  #: that the program is for
    output: str  #: below the output folder, with "/"
    sha256: str  #: of the output
    rest: RestRow | None  #: where several machines make a part one after the other, but the last
    bar: float  #: length of the bar, mm; 0 for a sheet, and a piece that comes cut
    ledger: Ledger
    by_hand: list[ManualRow]  #: marks on the list of manual work
    skipped_by: dict[str, int]  #: code -> number of features
    mapped: dict[str, int]  #: colour or layer of the map -> number of curves of a drawing
    tools: list[str]
    operations: int
    stock: StockRow | None  #: of a program of several parts over stock
    machine_time_s: float | None  #: None where it was not asked for


class FileRow(TypedDict):
    """One file."""

    file: str
    status: Status
    format: str
    seconds: float  #: that the work took; 0 for a file with nothing to do
    parts: list[PartRow]
    messages: list[Message]


def names_in(row: FileRow) -> dict[str, str]:
    """Output -> SHA-256 of the programs of an input, and of the rests between them."""
    parts = row["parts"]  # of older versions they have no rests
    rests = (rest for part in parts if (rest := part.get("rest")) is not None)
    return {one["output"]: one["sha256"] for one in (*parts, *rests)}


class Counts(Struct):
    """Number of files of a run by outcome, and messages on the run as a whole."""

    posted: int = 0
    unchanged: int = 0
    refused: int = 0
    failed: int = 0
    left_out: int = 0  #: features that --allow-skips let be missing from programs
    by_hand: int = 0  #: marks left for manual work
    mapped: Counter[str] = field(default_factory=Counter)  #: curves by key of the map

    def add(self, row: FileRow) -> None:
        """Count one file, and what its programs leave out."""
        setattr(self, row["status"], getattr(self, row["status"]) + 1)
        for part in row["parts"]:
            self.left_out += sum(
                count for code, count in part["skipped_by"].items() if code not in NOT_BY_NAME
            )
            self.by_hand += part["ledger"]["listed"]
            # A contour with bevelled edges is made, and its edges are left.
            self.by_hand += len({r["source"] for r in part["by_hand"] if r["kind"] == "bevel"})
            self.mapped.update(part["mapped"])

    @property
    def not_made(self) -> int:
        """Features that programs leave out, as allowed or for manual work."""
        return self.left_out + self.by_hand

    @property
    def total(self) -> int:
        return self.posted + self.unchanged + self.refused + self.failed

    def __str__(self) -> str:
        counts = [f"{getattr(self, status)} {status}" for status in STATUSES]
        left = {"left out": self.left_out, "left for manual work": self.by_hand}
        return ", ".join([*counts, *(f"{count} {how}" for how, count in left.items() if count)])


def as_message(diagnostic: Diagnostic) -> Message:
    """A diagnostic as data."""
    source = diagnostic.source
    return {
        "file": source.file, "line": source.line, "where": source.where,
        "severity": diagnostic.severity.value, "code": diagnostic.code,
        "message": diagnostic.message,
    }  # fmt: skip


def message_line(message: Message, file: bool = True) -> str:
    """A message as the one line that it is printed as; without its file where that is known."""
    place = [message["file"] if file else None, message["line"], message["where"]]
    shown = ":".join(str(word) for word in place if word is not None)
    what = f"{message['severity']} {message['code']}: {message['message']}"
    return terminal_text(f"{shown}: {what}" if shown else what)


def dumped(data: object) -> bytes:
    """`data` as JSON on one line, in UTF-8 even where a file's name is not."""
    try:
        return msgspec.json.encode(data)
    except UnicodeEncodeError:  # json is slower, and knows what to do with such a name
        return encoded(json.dumps(data, ensure_ascii=False, separators=(",", ":")))


def loaded(line: bytes) -> Any:
    """What was `dumped`. Raises ValueError."""
    try:
        return msgspec.json.decode(line)
    except msgspec.DecodeError:
        return json.loads(line)


def encoded(text: str) -> bytes:
    """`text` as UTF-8; what a file's name has beyond it as `\\udcXX`, which JSON reads."""
    return text.encode("utf-8", "backslashreplace")


def as_json(
    rows: Iterable[FileRow], counts: Counts, messages: Iterable[Message]
) -> Iterator[bytes]:
    """The report as JSON, piece by piece: a row a line, so that rows are found by line too."""
    head = {status: getattr(counts, status) for status in STATUSES}
    yield encoded(
        f'{{"schema": "{SCHEMA}", "counts": {json.dumps(head)}, '
        f'"messages": {json_text(json.dumps(list(messages), ensure_ascii=False))},\n"files": ['
    )
    comma = b""
    for row in rows:
        yield comma + b"\n" + encoded(json_text(dumped(row).decode("utf-8", "surrogateescape")))
        comma = b","
    yield b"\n]}\n"


# --- ledger of a part's features as a line of text ------------------------------------------------


def ledger_of(outcomes: Iterable[Outcome]) -> str:
    """`ledger_line` of what became of each feature."""
    counted = tuple(outcomes)
    how = Counter(outcome.how for outcome in counted)
    ledger: Ledger = {
        "read": len(counted), "made": how["made"], "merged": how["merged"],
        "duplicate": how["duplicate"], "listed": how["listed"], "skipped": how["skipped"],
        "passed_on": 0,
    }  # fmt: skip
    return ledger_line(ledger, Counter(o.by for o in counted if o.how == "skipped"))


def ledger_line(ledger: Ledger, skipped_by: Mapping[str, int]) -> str:
    """ "12 read = 9 made + 2 merged + 1 skipped (1 plan-slot)"."""
    counts = {
        "made": ledger["made"], "merged": ledger["merged"], "duplicate": ledger["duplicate"],
        "listed": ledger["listed"], "skipped": ledger["skipped"],
        "passed on": ledger["passed_on"],
    }  # fmt: skip
    words = [f"{count} {how}" for how, count in counts.items() if count]
    reasons = ", ".join(f"{count} {code}" for code, count in sorted(skipped_by.items()))
    shown = f" ({reasons})" if reasons else ""
    return f"{ledger['read']} read = {' + '.join(words) or '0 made'}{shown}"


# --- CSV: a row for each part, and one for each file that has none --------------------------------


HEAD = (
    "file", "status", "format", "seconds", "mark", "quantity", "pieces", "profile", "length",
    "machine", "output", "rest", "bar", "features", "made", "merged", "duplicate", "listed",
    "skipped", "passed_on",
    "tools", "operations", "machine_time_s", "errors", "warnings", "notes", "messages",
)  # fmt: skip


def as_csv(rows: Iterable[FileRow], counts: Counts, messages: Iterable[Message]) -> Iterator[bytes]:
    """The report as CSV, piece by piece, with a head. What is said of the run ends it as rows."""
    yield _line(HEAD)
    for row in rows:
        file = (row["file"], row["status"], row["format"], f"{row['seconds']:.4f}")
        severities = [m["severity"] for m in row["messages"]]
        counts_ = [severities.count(kind) for kind in SEVERITIES]
        text = " | ".join(message_line(m, file=False) for m in row["messages"])
        for cells in [_cells(part) for part in row["parts"]] or [NO_PART]:
            yield _line((*file, *cells, *counts_, text))
            # Messages of a file stand in its first row, so that sums over a column hold.
            counts_, text = [0, 0, 0], ""
    for message in messages:
        counts_ = [int(message["severity"] == kind) for kind in SEVERITIES]
        text = message_line(message, file=False)
        yield _line((message["file"], "", "", "", *NO_PART, *counts_, text))


SEVERITIES = ("error", "warning", "note")
NO_PART = ("",) * 19  #: the cells of a part, from its mark to its machine time


def _cells(part: PartRow) -> tuple[object, ...]:
    ledger, seconds = part["ledger"], part["machine_time_s"]
    return (
        part["mark"], part["quantity"], part["pieces"], part["profile"],
        f"{part['length']:g}", part["machine"], part["output"],
        "" if part["rest"] is None else part["rest"]["output"], f"{part['bar']:g}",
        ledger["read"], ledger["made"], ledger["merged"],
        ledger["duplicate"], ledger["listed"], ledger["skipped"], ledger["passed_on"],
        " ".join(t.replace(" ", "-") for t in part["tools"]),
        part["operations"], "" if seconds is None else f"{seconds:.1f}",
    )  # fmt: skip


def _line(cells: Iterable[object]) -> bytes:
    out = io.StringIO()
    csv.writer(out, lineterminator="\n").writerow(harmless_cell(cell) for cell in cells)
    return encoded(out.getvalue())
