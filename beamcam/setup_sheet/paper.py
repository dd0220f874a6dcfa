"""The setup sheet on A4 or A3 on its side, by reportlab (an extra).

The same program gives the same bytes.
"""

import io
from collections.abc import Callable, Iterator, Sequence
from html import escape
from typing import Any

from beamcam.pictures.bar_made import BarMade
from beamcam.pictures.formats import (
    MARGIN,
    SIZES,
    Paper,
    draw_scene,
    largest,
    needed_canvas,
    plain_letters,
)
from beamcam.pictures.scene import Scene, Unit, shown
from beamcam.plain_text import terminal_text
from beamcam.reports.run import as_message, message_line
from beamcam.setup_sheet.content import SheetContent
from beamcam.setup_sheet.page import verdict_of
from beamcam.setup_sheet.solid_data import solids_of
from beamcam.setup_sheet.still import Still, still_of
from beamcam.setup_sheet.tables import Cell, Column, SheetTable, manual_work, tables_of
from beamcam.version import __version__

BODY = 9.0
MAX_STILLS = 4  #: parts of a bar that are shown in space
WIDE, HIGH, LOW = 1600, 420, 250  #: pixels of such a picture: alone, and with another on a page
FOOT = 48.0  #: points of a page for its footer, and for the heading above a picture


def setup_pdf(content: SheetContent, paper: Paper = "a4") -> bytes:
    """The sheet without playback. Raises PictureError without reportlab."""
    needed_canvas()
    from reportlab.platypus import SimpleDocTemplate

    stream = io.BytesIO()
    title = f"{content.program.name}: setup sheet"
    size = (SIZES[paper][1], SIZES[paper][0])
    document = SimpleDocTemplate(
        stream, pagesize=size, leftMargin=MARGIN, rightMargin=MARGIN, topMargin=MARGIN,
        bottomMargin=MARGIN + 8, title=title, author="beamcam", invariant=1,
    )  # fmt: skip
    foot = plain_letters(f"{content.program.name}   sha-256 {content.program.sha256}")

    def footer(canvas: Any, _: Any) -> None:
        canvas.setFont("Helvetica", 6.5)
        canvas.drawString(MARGIN, 20, foot)
        page = f"beamcam {__version__}, page {canvas.getPageNumber()}"
        canvas.drawRightString(size[0] - MARGIN, 20, page)

    document.build(list(_story(content, paper)), onFirstPage=footer, onLaterPages=footer)
    return stream.getvalue()


def _story(content: SheetContent, paper: Paper) -> Iterator[Any]:
    from reportlab.platypus import Spacer

    program = content.program
    yield _text(program.name, 15, bold=True)
    yield Spacer(1, 4)
    rows = [[label, value] for label, value in content.header if label != "Program"]
    yield _table([*rows, ["SHA-256", program.sha256]], [70, SIZES[paper][1] - 2 * MARGIN - 70], ())
    colour = {"made": "#176b2c", "alone": "#7a5000", "wrong": "#b3261e"}[content.verdict]
    yield _text(verdict_of(content), 10, colour, bold=True)
    if content.ledger:
        yield _text(content.ledger)
    if content.left_out or content.hand:
        yield _title("Manual work")
        yield from (_text(line, bold=True) for line in content.left_out)
        yield from _printed(manual_work(content), content.unit)
    if content.messages:
        yield _title("Warnings and remarks")
        yield from (_text(message_line(as_message(d)), 8) for d in content.messages)
    yield from _space(content, paper)
    yield _title("What the program makes")
    for scene in content.pictures:
        yield _picture(scene, paper)
    for table in tables_of(content):
        yield _title(table.title)
        yield from _printed(table, content.unit)


def _space(content: SheetContent, paper: Paper) -> Iterator[Any]:
    """The pieces as shaded pictures: of a bar each mark once, of a sheet all together."""
    solids = solids_of(content.program, content.made)
    yield _title("The pieces in space")
    if not solids.pieces:
        yield _text(f"No solid: {solids.without}.")
        return
    parts: dict[str, tuple[dict[str, Any], ...]] = {"": solids.pieces}
    if isinstance(content.made, BarMade):
        first: dict[str, tuple[dict[str, Any], ...]] = {}
        for piece in solids.pieces:
            if piece["kind"] == "part":
                first.setdefault(piece["mark"], (piece,))
        parts = first or parts
    for mark, pieces in list(parts.items())[:MAX_STILLS]:
        yield _still(
            still_of(pieces, solids.faces, WIDE, HIGH if len(parts) == 1 else LOW),
            SIZES[paper][1] - 2 * MARGIN,
            mark,
        )
    if len(parts) > MAX_STILLS:
        yield _text(f"{len(parts) - MAX_STILLS} more parts are not shown.")


def _still(still: Still, wide: float, mark: str) -> Any:
    """A shaded picture as wide as it is given, with its letters and its mark."""
    from PIL import Image
    from reportlab.lib.utils import ImageReader

    rows, columns, _ = still.pixels.shape
    high = wide * rows / columns

    def draw(canvas: Any) -> None:
        canvas.drawImage(ImageReader(Image.fromarray(still.pixels)), 0, 0, wide, high)
        canvas.setFont("Helvetica-Bold", BODY)
        for letter, x, y in still.letters:
            canvas.setFillColor("#ffffff")
            canvas.circle(x * wide, high - y * high, 0.8 * BODY, stroke=1, fill=1)
            canvas.setFillColor("#1c2530")
            canvas.drawCentredString(x * wide, high - y * high - 0.35 * BODY, letter)
        canvas.drawString(0, high - BODY, _letters(mark))

    return _flowable(wide, high, draw)


def _flowable(wide: float, high: float, draw: Callable[[Any], None]) -> Any:
    """A picture of a size, in points, that stands where the text has come to."""
    from reportlab.platypus import Flowable

    class Picture(Flowable):  # type: ignore[misc]
        def __init__(self) -> None:
            super().__init__()
            self.width, self.height = wide, high

        def draw(self) -> None:
            draw(self.canv)

    return Picture()


def _printed(table: SheetTable, unit: Unit) -> Iterator[Any]:
    if not table.rows:  # a program that does nothing
        return
    units = {"length": unit, "rate": f"{unit}/min"}
    heads = [", ".join(filter(None, (c.head, units.get(c.kind, c.unit)))) for c in table.columns]

    def text(value: Cell, column: Column) -> str:
        if value is None or isinstance(value, str):
            return value or ""
        if column.kind in ("length", "rate"):
            return shown(value, unit)
        return f"{value:.1f}" if column.kind == "seconds" else f"{value:g}"

    rows = [list(map(text, row, table.columns)) for row in table.rows]
    right = [k for k, column in enumerate(table.columns) if column.is_number]
    yield _table([heads, *rows], [column.wide for column in table.columns], right, True)
    if table.more:
        yield _text(f"{table.more} more {table.noun} are not listed.")


def _letters(text: str) -> str:
    return plain_letters(terminal_text(text))


def _paragraph(text: str, name: str, **style: Any) -> Any:
    from reportlab.lib.styles import ParagraphStyle
    from reportlab.platypus import Paragraph

    return Paragraph(escape(_letters(text)), ParagraphStyle(name, **style))


def _text(text: str, size: float = BODY, colour: str = "#1c2530", bold: bool = False) -> Any:
    return _paragraph(
        text, "text", fontName="Helvetica-Bold" if bold else "Helvetica", fontSize=size,
        leading=size * 1.3, textColor=colour, splitLongWords=1, spaceAfter=1,
    )  # fmt: skip


def _title(text: str) -> Any:
    return _paragraph(
        text, "title", fontName="Helvetica-Bold", fontSize=11, leading=14, spaceBefore=8,
        spaceAfter=3, keepWithNext=1,
    )  # fmt: skip


def _table(
    rows: Sequence[Sequence[str]], widths: Sequence[float], right: Sequence[int],
    has_head: bool = False,
) -> Any:  # fmt: skip
    """A table whose header is repeated on each page."""
    from reportlab.platypus import LongTable, TableStyle

    commands: list[tuple[Any, ...]] = [
        ("FONT", (0, 0), (-1, -1), "Helvetica", 8), ("VALIGN", (0, 0), (-1, -1), "TOP"),
        ("TOPPADDING", (0, 0), (-1, -1), 1.5), ("BOTTOMPADDING", (0, 0), (-1, -1), 1.5),
        ("LEFTPADDING", (0, 0), (-1, -1), 2), ("RIGHTPADDING", (0, 0), (-1, -1), 4),
        *(("ALIGN", (k, 0), (k, -1), "RIGHT") for k in right),
    ]  # fmt: skip
    if has_head:
        commands += [("FONT", (0, 0), (-1, 0), "Helvetica-Bold", 8),
                     ("LINEBELOW", (0, 0), (-1, -1), 0.3, "#c3ccd6")]  # fmt: skip
    else:
        commands.append(("TEXTCOLOR", (0, 0), (0, -1), "#59636e"))
    cells = [[_letters(cell) for cell in row] for row in rows]
    made = LongTable(cells, colWidths=list(widths), hAlign="LEFT", repeatRows=int(has_head))
    made.setStyle(TableStyle(commands))
    return made


def _picture(scene: Scene, paper: Paper) -> Any:
    """A picture as wide as the page, or as high as what it leaves."""
    high, wide = (side - 2 * MARGIN for side in SIZES[paper])
    scale = min(wide / scene.width, (high - FOOT) / scene.height, largest(paper))
    height = scene.height * scale
    return _flowable(
        scene.width * scale, height, lambda canvas: draw_scene(canvas, scene, 0.0, height, scale)
    )
