"""The account of a run as a page for a browser: nothing fetched, refused files first.

head that stays: counts, filter -> totals by machine, tools to load -> a row for each file, with
small pictures and links to setup sheets where they were made
"""

from collections import Counter
from collections.abc import Callable, Iterable, Iterator, Mapping
from typing import TYPE_CHECKING
from urllib.parse import quote

from msgspec import Struct

from beamcam.plain_text import terminal_text
from beamcam.reports.run import (
    STATUSES,
    Counts,
    FileRow,
    Message,
    encoded,
    ledger_line,
    message_line,
)
from beamcam.reports.templates import as_it_stands, static_text, template

if TYPE_CHECKING:
    from markupsafe import Markup

REFUSED = ("refused", "failed")
COLUMNS = ("File", "Result", "Part", "Machine", "Features", "Tools", "Machine time", "Posted in",
           "Messages")  # fmt: skip


class Extra(Struct, frozen=True):
    """Additional data of a program in its row."""

    sheet: str = ""  #: path of its setup sheet from the page, with "/"
    picture: str = ""  #: a small one, as SVG


class Total(Struct):
    """Of the programs for one machine."""

    seconds: float = 0.0
    programs: int = 0
    pieces: int = 0
    stock: float = 0.0  #: mm of bars
    tools: Counter[str] = Counter()


def as_html(
    read: Callable[[], Iterable[FileRow]], counts: Counts, messages: Iterable[Message],
    extras: Mapping[str, Extra] | None = None, style: str = "",
) -> Iterator[bytes]:  # fmt: skip
    """The report as HTML, piece by piece; `read` gives its rows as often as it is called.

    `extras` are by the name of the output, `style` is that of their pictures.
    """
    totals, whole = _totals(read())
    extras_of = extras or {}
    pieces = template("reports", "run").stream(
        counts={"": str(counts)} | {status: getattr(counts, status) for status in STATUSES},
        statuses=STATUSES, said=messages, totals=totals, whole=whole, columns=COLUMNS,
        rows=(row for first in (True, False) for row in read()
              if (row["status"] in REFUSED) is first),
        style=as_it_stands(style),
        static=lambda name: static_text("reports", name), message=message_line, ledger=ledger_line,
        file=_broken, machine_time_s=lambda row: sum(
            (p["machine_time_s"] or 0.0) * p["quantity"] / p["pieces"] for p in row["parts"]),
         quote=quote,
        extras=lambda output: extras_of.get(output, Extra()),
        picture=lambda extra: as_it_stands(extra.picture),
    )  # fmt: skip
    pieces.enable_buffering(100)
    yield from map(encoded, pieces)


def _totals(rows: Iterable[FileRow]) -> tuple[dict[str, Total], Total]:
    """Machine time, pieces, stock and tools of the programs by machine, and those of all."""
    totals: dict[str, Total] = {}
    passed_on = 0  # pieces that another machine finishes
    for row in rows:
        for part in row["parts"]:
            passed_on += part["quantity"] if part["rest"] is not None else 0
            total = totals.setdefault(part["machine"], Total(tools=Counter()))
            runs = part["quantity"] / part["pieces"]
            total.seconds += (part["machine_time_s"] or 0.0) * runs
            total.programs += 1
            total.pieces += part["quantity"]
            total.stock += part["bar"] * runs
            total.tools.update(part["tools"])
    whole = Total(
        sum(t.seconds for t in totals.values()), sum(t.programs for t in totals.values()),
        sum(t.pieces for t in totals.values()) - passed_on, sum(t.stock for t in totals.values()),
    )  # fmt: skip
    return totals, whole


def _broken(path: str) -> "Markup":
    """A path that a line may be broken in behind each folder."""
    from markupsafe import escape

    return as_it_stands(str(escape(terminal_text(path))).replace("/", "/<wbr>"))
