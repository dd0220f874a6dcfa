"""The account of a run as a page for a browser: one file, no script, nothing fetched."""

from collections.abc import Iterable, Iterator
from html import escape

from beamcam.plain_text import terminal_text
from beamcam.report.ledger import ledger_line
from beamcam.report.run import STATUSES, Counts, Message, PartRow, Row, encoded, message_line

_STYLE = """
body { font: 15px/1.4 system-ui, sans-serif; margin: 2em; color: #222 }
table { border-collapse: collapse; width: 100% }
th, td { text-align: left; vertical-align: top; padding: .3em .6em; border-bottom: 1px solid #ddd }
td.n, th.n { text-align: right; white-space: nowrap; font-variant-numeric: tabular-nums }
.posted { color: #176b2c } .unchanged { color: #667 } .refused, .failed { color: #b3211b }
.error { color: #b3211b } .warning { color: #8a5a00 } .note { color: #667 }
.messages { font: 13px/1.4 ui-monospace, monospace }
"""


def as_html(rows: Iterable[Row], counts: Counts, said: Iterable[Message]) -> Iterator[bytes]:
    """The report as HTML, piece by piece."""
    yield encoded(
        '<!doctype html>\n<html lang="en"><meta charset="utf-8">'
        '<meta name="viewport" content="width=device-width">'
        f"<title>beamcam: {escape(str(counts))}</title><style>{_STYLE}</style>\n<h1>beamcam</h1>\n"
        + "<p>"
        + ", ".join(f'<b class="{s}">{getattr(counts, s)}</b> {s}' for s in STATUSES)
        + "</p>\n"
    )
    yield encoded(f'<div class="messages">{"".join(_message(m, file=True) for m in said)}</div>\n')
    yield encoded(
        "<table>\n<tr><th>file<th>result<th>time<th>part<th>machine<th>features<th>tools"
        "<th>machine time<th>messages</tr>\n"
    )
    whole = 0.0
    for row in rows:
        whole += _machine_time_s(row)
        yield encoded(_row(row))
    yield encoded(f'<tr><th>all<th><th><th><th><th><th><th class="n">{_clock(whole)}<th></tr>\n')
    yield b"</table>\n</html>\n"


def _row(row: Row) -> str:
    parts = row["parts"]
    return (
        f"<tr><td>{_shown(row['file'])}<td class={row['status']}>{row['status']}"
        f'<td class="n">{1000 * row["seconds"]:.0f} ms'
        f"<td>{'<br>'.join(map(_part, parts))}"
        f"<td>{'<br>'.join(_shown(part['machine']) for part in parts)}"
        f"<td>{'<br>'.join(map(_ledger, parts))}"
        f"<td>{'<br>'.join(_shown(', '.join(part['tools'])) for part in parts)}"
        f'<td class="n">{_clock(_machine_time_s(row)) if parts else ""}'
        f'<td class="messages">{"".join(map(_message, row["messages"]))}</tr>\n'
    )


def _machine_time_s(row: Row) -> float:
    """Of all pieces of a file's parts."""
    return sum((part["machine_time_s"] or 0.0) * part["quantity"] for part in row["parts"])


def _part(part: PartRow) -> str:
    times = f" ×{part['quantity']}" if part["quantity"] != 1 else ""
    return _shown(f"{part['mark']}{times} {part['profile']} {part['length']:g} → {part['output']}")


def _ledger(part: PartRow) -> str:
    return _shown(ledger_line(part["ledger"], part["skipped_by"]))


def _message(said: Message, file: bool = False) -> str:
    return f'<div class="{said["severity"]}">{_shown(message_line(said, file))}</div>'


def _shown(text: str) -> str:
    """A text of an input as HTML shows it."""
    return escape(terminal_text(text))


def _clock(seconds: float) -> str:
    """Hours, minutes and seconds, as far as there are any."""
    whole = round(seconds)
    if whole < 3600:
        return f"{whole // 60}:{whole % 60:02d} min"
    return f"{whole // 3600}:{whole % 3600 // 60:02d}:{whole % 60:02d} h"
