"""The account of a run as a page for a browser: nothing fetched, refused files first.

head that stays: counts, filter -> totals by machine, tools to load -> a row for each file, with
small pictures and links to setup sheets where they were made
"""

from collections import Counter
from collections.abc import Callable, Iterable, Iterator, Mapping
from html import escape
from importlib.resources import files
from urllib.parse import quote

from msgspec import Struct

from beamcam.model.plan import clock
from beamcam.plain_text import terminal_text
from beamcam.report.run import (
    STATUSES,
    Counts,
    Message,
    PartRow,
    Row,
    encoded,
    ledger_line,
    message_line,
)

REFUSED = ("refused", "failed")
MM_PER_M = 1000.0
COLUMNS = ("File", "Result", "Part", "Machine", "Features", "Tools", "Machine time", "Posted in",
           "Messages")  # fmt: skip


class Extra(Struct, frozen=True):
    """Additional data of a program in its row."""

    sheet: str = ""  #: path of its setup sheet from the page, with "/"
    picture: str = ""  #: a small one, as SVG


class _Total(Struct):
    """Of the programs for one machine."""

    seconds: float = 0.0
    programs: int = 0
    pieces: int = 0
    stock: float = 0.0  #: mm of bars
    tools: Counter[str] = Counter()


def as_html(
    read: Callable[[], Iterable[Row]],
    counts: Counts,
    said: Iterable[Message],
    extras: Mapping[str, Extra] | None = None,
    style: str = "",
) -> Iterator[bytes]:
    """The report as HTML, piece by piece; `read` gives its rows as often as it is called.

    `extras` are by the name of the output, `style` is that of their pictures.
    """
    yield encoded(_head(counts, style))
    yield encoded(f'<div class="messages">{"".join(_message(m, file=True) for m in said)}</div>\n')
    yield encoded(_totals(read()))
    heads = "".join(f'<th scope="col"><button>{name}</button></th>' for name in COLUMNS)
    yield encoded(f'<h2>Files</h2>\n<table id="files"><thead><tr>{heads}</tr></thead>\n<tbody>\n')
    for first in (True, False):
        for row in read():
            if (row["status"] in REFUSED) is first:
                yield encoded(_row(row, extras or {}))
    yield encoded(f"</tbody></table>\n<script>{_static('run.js')}</script>\n</html>\n")


def _static(name: str) -> str:
    return files("beamcam.report").joinpath("static", name).read_text(encoding="utf-8")


def _head(counts: Counts, style: str) -> str:
    numbers = {s: getattr(counts, s) for s in STATUSES}
    shown = ", ".join(f"<b{f' class={s}' if n else ''}>{n}</b> {s}" for s, n in numbers.items())
    choices = "".join(f"<option>{s}</option>" for s in STATUSES)
    return (
        '<!doctype html>\n<html lang="en"><meta charset="utf-8">'
        '<meta name="viewport" content="width=device-width, initial-scale=1">'
        f'<link rel="icon" href="data:,"><title>beamcam: {escape(str(counts))}</title>'
        f"<style>{_static('run.css')}{style}</style>\n"
        f"<header><h1>beamcam</h1><span>{shown}</span>"
        '<label>Filter <input id="filter" type="search"></label>'
        f'<label>Result <select id="status"><option value="">all</option>{choices}</select></label>'
        '<span id="shown" role="status"></span></header>\n'
    )


def _totals(rows: Iterable[Row]) -> str:
    """Machine time, pieces and stock by machine, and the tools that its programs need."""
    found: dict[str, _Total] = {}
    passed_on = 0  # pieces that another machine finishes
    for row in rows:
        for part in row["parts"]:
            passed_on += part["quantity"] if part["rest"] is not None else 0
            total = found.setdefault(part["machine"], _Total(tools=Counter()))
            runs = part["quantity"] / part["pieces"]
            total.seconds += (part["machine_time_s"] or 0.0) * runs
            total.programs += 1
            total.pieces += part["quantity"]
            total.stock += part["bar"] * runs
            total.tools.update(part["tools"])
    if not found:
        return ""
    whole = _Total(
        sum(t.seconds for t in found.values()), sum(t.programs for t in found.values()),
        sum(t.pieces for t in found.values()) - passed_on, sum(t.stock for t in found.values()),
    )  # fmt: skip
    lines = [_total_row(name, total) for name, total in found.items()]
    if len(found) > 1:
        lines.append(_total_row("all", whole))
    tools = [
        f"<tr><td>{_shown(name)}<td>"
        + ", ".join(f"{_shown(tool)} ({count})" for tool, count in sorted(total.tools.items()))
        for name, total in found.items()
    ]
    return (
        '<div class="totals"><section><h2>Totals</h2><table><tr><th>Machine<th class="n">Time'
        '<th class="n">Programs<th class="n">Pieces<th class="n">Stock, m</tr>'
        f"{''.join(lines)}</table></section>\n<section><h2>Tools to load (programs)</h2>"
        f"<table><tr><th>Machine<th>Tools</tr>{''.join(tools)}</table></section></div>\n"
    )


def _total_row(name: str, total: _Total) -> str:
    return (
        f'<tr><td>{_shown(name)}<td class="n">{clock(total.seconds)}'
        f'<td class="n">{total.programs}<td class="n">{total.pieces}'
        f'<td class="n">{f"{total.stock / MM_PER_M:.2f}" if total.stock else ""}</tr>'
    )


def _row(row: Row, extras: Mapping[str, Extra]) -> str:
    parts = row["parts"]
    seconds = _machine_time_s(row)
    return (
        f"<tr data-status={row['status']}><td>{_shown(row['file']).replace('/', '/<wbr>')}"
        f"<td class={row['status']}>{row['status']}"
        f"<td>{''.join(_part(part, extras.get(part['output'], Extra())) for part in parts)}"
        f"<td>{'<br>'.join(_shown(part['machine']) for part in parts)}"
        f"<td>{'<br>'.join(map(_ledger, parts))}"
        f"<td>{'<br>'.join(_tools(part['tools']) for part in parts)}"
        f'<td class="n" data-value="{seconds:.3f}">{clock(seconds) if parts else ""}'
        f'<td class="n" data-value="{row["seconds"]:.6f}">{1000 * row["seconds"]:.0f} ms'
        f'<td class="messages">{"".join(map(_message, row["messages"]))}</tr>\n'
    )


def _tools(names: Iterable[str]) -> str:
    return ", ".join(f"<span>{_shown(name)}</span>" for name in names)


def _machine_time_s(row: Row) -> float:
    """Of all pieces of a file's parts."""
    return sum(
        (part["machine_time_s"] or 0.0) * part["quantity"] / part["pieces"] for part in row["parts"]
    )


def _part(part: PartRow, extra: Extra) -> str:
    """A part with its program, the sheet of it and a small picture where there are any."""
    times = f" ×{part['quantity']}" if part["quantity"] != 1 else ""
    name = _shown(part["output"])
    if extra.sheet:
        name = f'<a href="{escape(quote(extra.sheet))}">{name}</a>'
    text = _shown(f"{part['mark']}{times} {part['profile']} {part['length']:g}")
    return f'<div class="small">{text} → {name}{extra.picture}</div>'


def _ledger(part: PartRow) -> str:
    return _shown(ledger_line(part["ledger"], part["skipped_by"]))


def _message(said: Message, file: bool = False) -> str:
    return f'<div class="{said["severity"]}">{_shown(message_line(said, file))}</div>'


def _shown(text: str) -> str:
    """A text of an input as HTML shows it."""
    return escape(terminal_text(text))
