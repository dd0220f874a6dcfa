"""The setup sheet on A4 or A3 on its side, by reportlab (an extra).

The same program gives the same bytes.
"""

import io
from collections.abc import Iterator, Sequence
from html import escape
from typing import Any

from beamcam.model.plan import clock
from beamcam.pictures.bar import BarMade
from beamcam.pictures.pdf import (
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
from beamcam.report.run import as_message, message_line
from beamcam.setup_sheet.content import Content
from beamcam.setup_sheet.html import used_columns
from beamcam.setup_sheet.operations import Operation
from beamcam.setup_sheet.page import MAX_ROWS, verdict_of
from beamcam.setup_sheet.solid_data import solids_of
from beamcam.setup_sheet.still import Still, still_of
from beamcam.version import __version__

BODY = 9.0
MAX_STILLS = 4  #: parts of a bar that are shown in space
WIDE, HIGH, LOW = 1600, 420, 250  #: pixels of such a picture: alone, and with another on a page
FOOT = 48.0  #: points of a page for its footer, and for the heading above a picture


def setup_pdf(content: Content, paper: Paper = "a4") -> bytes:
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


def _story(content: Content, paper: Paper) -> Iterator[Any]:
    """Contents of the pages, in order."""
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
        yield from _hand(content)
    if content.messages:
        yield _title("Warnings and remarks")
        yield from (_text(message_line(as_message(d)), 8) for d in content.messages)
    yield from _space(content, paper)
    yield _title("What the program makes")
    for scene in content.pictures:
        yield _picture(scene, paper)
    yield from _tables(content)


def _space(content: Content, paper: Paper) -> Iterator[Any]:
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
    from reportlab.platypus import Flowable

    rows, columns, _ = still.pixels.shape
    high = wide * rows / columns

    class Picture(Flowable):  # type: ignore[misc]
        def __init__(self) -> None:
            super().__init__()
            self.width, self.height = wide, high

        def draw(self) -> None:
            self.canv.drawImage(ImageReader(Image.fromarray(still.pixels)), 0, 0, wide, high)
            self.canv.setFont("Helvetica-Bold", BODY)
            for letter, x, y in still.letters:
                self.canv.setFillColor("#ffffff")
                self.canv.circle(x * wide, high - y * high, 0.8 * BODY, stroke=1, fill=1)
                self.canv.setFillColor("#1c2530")
                self.canv.drawCentredString(x * wide, high - y * high - 0.35 * BODY, letter)
            self.canv.drawString(0, high - BODY, _letters(mark))

    return Picture()


def _hand(content: Content) -> Iterator[Any]:
    """The marks that are made manually."""
    if content.hand:
        unit = content.unit
        rows = [[h["mark"], f"{h['kind']} {h['text']}", h["face"], shown(h["x"], unit),
                 shown(h["y"], unit), str(h["pieces"])] for h in content.hand]  # fmt: skip
        head = ["Part", "Mark", "Face", f"X, {unit}", f"Y, {unit}", "Pieces"]
        yield _table([head, *rows], [90, 200, 40, 70, 70, 60], (3, 4, 5), True)


def _tables(content: Content) -> Iterator[Any]:
    unit = content.unit
    if content.bar:
        yield _title("Bar")
        rows = [[s.what, *(shown(v, unit) for v in (s.start, s.end, s.end - s.start))]
                for s in content.bar]  # fmt: skip
        head = ["What", f"From, {unit}", f"To, {unit}", f"Length, {unit}"]
        yield _table([head, *rows], [200, 100, 100, 100], (1, 2, 3), True)
    if content.tools:
        yield _title("Tools to load")
        rows = [[t.where, t.station, t.tool] for t in content.tools]
        heads, rows = used_columns([("Where", 180.0), ("Station", 180.0), ("Tool", 170.0)], rows)
        yield _table([[head for head, _ in heads], *rows], [wide for _, wide in heads], (), True)
    yield _title("Time by tool")
    rows = [
        [t.what, "" if t.count is None else str(t.count), f"{t.work_s:.1f}" if t.work_s else "",
         f"{t.seconds:.1f}", "" if t.length is None else shown(t.length, unit)]
        for t in content.totals
    ]  # fmt: skip
    columns = [("What", 170.0), ("Operations", 80.0), ("At work, s", 80.0), ("In all, s", 80.0),
               (f"Length, {unit}", 100.0)]  # fmt: skip
    heads, rows = used_columns(columns, rows)
    yield _table([[head for head, _ in heads], *rows], [wide for _, wide in heads],
                 range(1, len(heads)), True)  # fmt: skip
    count = len(content.operations)
    yield _title(f"Operations ({count}, {clock(content.seconds)})")
    if not count:  # a program that does nothing
        return
    head = ["No.", "Operation", "Face", f"X, {unit}", f"Y, {unit}", f"Depth, {unit}",
            f"Feed, {unit}/min", "Speed, rpm", "Time, s"]  # fmt: skip
    rows = [_operation(op, unit) for op in content.operations[:MAX_ROWS]]
    widths = (28.0, 110.0, 40.0, 62.0, 58.0, 58.0, 65.0, 60.0, 50.0)
    used, rows = used_columns(list(zip(head, widths, strict=True)), rows)
    right = [k for k, (name, _) in enumerate(used) if name not in ("Operation", "Face")]
    yield _table([[name for name, _ in used], *rows], [wide for _, wide in used], right, True)
    if count > MAX_ROWS:
        yield _text(f"{count - MAX_ROWS} more operations are not listed.")


def _operation(op: Operation, unit: Unit) -> list[str]:
    def figure(value: float | None) -> str:
        return "" if value is None else shown(value, unit)

    deep = "through" if op.is_through else figure(op.depth)
    speed = "" if op.speed_rpm is None else f"{op.speed_rpm:g}"
    return [str(op.number), op.what, ", ".join(op.faces), figure(op.x), figure(op.y),
            deep, figure(op.feed_mm_min), speed, f"{op.seconds:.1f}"]  # fmt: skip


def _letters(text: str) -> str:
    return plain_letters(terminal_text(text))


def _text(text: str, size: float = BODY, colour: str = "#1c2530", bold: bool = False) -> Any:
    from reportlab.lib.styles import ParagraphStyle
    from reportlab.platypus import Paragraph

    font = "Helvetica-Bold" if bold else "Helvetica"
    style = ParagraphStyle(
        "text", fontName=font, fontSize=size, leading=size * 1.3, textColor=colour,
        splitLongWords=1, spaceAfter=1,
    )  # fmt: skip
    return Paragraph(escape(_letters(text)), style)


def _title(text: str) -> Any:
    from reportlab.lib.styles import ParagraphStyle
    from reportlab.platypus import Paragraph

    style = ParagraphStyle(
        "title", fontName="Helvetica-Bold", fontSize=11, leading=14, spaceBefore=8, spaceAfter=3,
        keepWithNext=1,
    )  # fmt: skip
    return Paragraph(escape(_letters(text)), style)


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
    from reportlab.platypus import Flowable

    high, wide = (side - 2 * MARGIN for side in SIZES[paper])
    scale = min(wide / scene.width, (high - FOOT) / scene.height, largest(paper))

    class Picture(Flowable):  # type: ignore[misc]
        def __init__(self) -> None:
            super().__init__()
            self.width, self.height = scene.width * scale, scene.height * scale

        def draw(self) -> None:
            draw_scene(self.canv, scene, 0.0, self.height, scale)

    return Picture()
