"""Pieces of HTML that the pages share."""

from collections.abc import Iterable, Sequence
from html import escape
from importlib.resources import files
from typing import TypeVar

from beamcam.errors import Diagnostic
from beamcam.pictures.scene import SPEED_COLOURS, css
from beamcam.plain_text import terminal_text
from beamcam.report.run import as_message, message_line


def shown(text: str) -> str:
    """A text of an input as HTML shows it."""
    return escape(terminal_text(text))


def length(mm: float | None) -> str:
    """A length that a page shows in the reader's unit and language; nothing for none."""
    return "" if mm is None else f'<data class="mm" value="{mm + 0:.6g}">{mm + 0:.1f}</data>'


def number(value: float | None, classes: str = "") -> str:
    """A number that a page shows in the reader's language; nothing for none."""
    named = f' class="{classes}"' if classes else ""
    return "" if value is None else f'<data{named} value="{value + 0:.6g}">{value + 0:.6g}</data>'


_Head = TypeVar("_Head")
Heads = Sequence[tuple[str, bool]]  #: name of each column, and whether it holds numbers


def table(name: str, heads: Heads, rows: Iterable[str]) -> str:
    """A table whose rows become cards where the page is narrow.

    What a column is called, and how it is set, stands once in a style for all of its cells.
    """
    cells = "".join(f'<th scope="col">{head}</th>' for head, _ in heads)
    right = ",".join(
        f"#{name} tr>:nth-child({k})" for k, (_, is_number) in enumerate(heads, 1) if is_number
    )
    labels = "".join(
        f'#{name} td:nth-child({k})::before{{content:"{_plain(head)} "}}'
        for k, (head, _) in enumerate(heads, 1)
    )
    aligned = f"@media print,(min-width:761px){{{right}{{text-align:right}}}}" if right else ""
    return (
        f"<style>{aligned}@media screen and (max-width:760px){{{labels}}}</style>"
        f'<table class="rows" id="{name}"><thead><tr>{cells}</tr></thead>'
        f"<tbody>{''.join(rows)}</tbody></table>"
    )


def used_columns(
    heads: Sequence[_Head], rows: Sequence[Sequence[str]]
) -> tuple[list[_Head], list[list[str]]]:
    """The columns of a table without those that are empty in all rows."""
    used = [k for k in range(len(heads)) if any(row[k] for row in rows)]
    return [heads[k] for k in used], [[row[k] for k in used] for row in rows]


def row(cells: Sequence[str], attributes: str = "") -> str:
    """A row of cells."""
    return f"<tr{attributes}>{''.join(f'<td>{cell}' for cell in cells)}</tr>"


def _plain(head: str) -> str:
    """The name of a column without its unit."""
    return escape(head.split("<", 1)[0].strip(" ,"))


def messages(said: Iterable[Diagnostic]) -> str:
    """Messages, a line each."""
    lines = "".join(
        f'<div class="{d.severity.value}">{shown(message_line(as_message(d)))}</div>' for d in said
    )
    return f'<div class="messages">{lines}</div>'


# --- static files ---------------------------------------------------------------------------------

# The scripts and the styles of a page, as they stand in the package.


SCRIPTS = (
    "sha256", "numbers", "trace", "canvas", "gestures", "cell", "table", "guide", "listing",
    "mesh", "solid", "sheet",
)  # fmt: skip


def static_text(name: str) -> str:
    """Content of a file beside this one."""
    return files("beamcam.setup_sheet").joinpath("static", name).read_text(encoding="utf-8")


def page_script() -> str:
    """All scripts as one, in their order."""
    parts = "\n".join(static_text(f"{name}.js") for name in SCRIPTS)
    return f'"use strict";\n{parts}'


def page_style() -> str:
    """The style of the page and of the pictures in it, in the light and in the dark."""
    light = "".join(f"--speed-{k}:{c};" for k, (c, _) in enumerate(SPEED_COLOURS))
    dark = "".join(f"--speed-{k}:{d};" for k, (_, d) in enumerate(SPEED_COLOURS))
    return (
        f"{static_text('page.css')}:root{{{light}}}svg text{{font-family:system-ui,sans-serif}}"
        f"{css('svg ')}\n@media screen and (prefers-color-scheme: dark){{:root{{{dark}}}"
        f"{css('svg ', dark=True)}}}"
    )
