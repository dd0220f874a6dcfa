"""The setup sheet on paper, by reportlab (an extra): A4, the same bytes for the same program."""

import io
from collections.abc import Iterator, Sequence
from html import escape
from typing import Any

from beamcam.model.plan import clock
from beamcam.pictures.pdf import MARGIN, POINTS_PER_PIXEL, draw_scene, needed_canvas, plain_letters
from beamcam.pictures.scene import Scene, Unit, shown
from beamcam.plain_text import terminal_text
from beamcam.report.run import as_message, message_line
from beamcam.setup_sheet.content import Content
from beamcam.setup_sheet.html import used_columns
from beamcam.setup_sheet.operations import Operation
from beamcam.setup_sheet.page import MAX_ROWS, verdict_of
from beamcam.version import __version__

BODY = 9.0
ROOM = 539.0  #: points between the margins of an A4 page
HIGH = 760.0


def setup_pdf(content: Content) -> bytes:
    """The sheet without playback. Raises PictureError without reportlab."""
    needed_canvas()
    from reportlab.platypus import SimpleDocTemplate

    stream = io.BytesIO()
    title = f"{content.program.name}: setup sheet"
    document = SimpleDocTemplate(
        stream, leftMargin=MARGIN, rightMargin=MARGIN, topMargin=MARGIN, bottomMargin=MARGIN + 8,
        title=title, author="beamcam", invariant=1,
    )  # fmt: skip
    foot = plain_letters(f"{content.program.name}   sha-256 {content.program.sha256}")

    def footer(canvas: Any, _: Any) -> None:
        canvas.setFont("Helvetica", 6.5)
        canvas.drawString(MARGIN, 20, foot)
        page = f"beamcam {__version__}, page {canvas.getPageNumber()}"
        canvas.drawRightString(595 - MARGIN, 20, page)

    document.build(list(_story(content)), onFirstPage=footer, onLaterPages=footer)
    return stream.getvalue()


def _story(content: Content) -> Iterator[Any]:
    """Contents of the pages, in order."""
    from reportlab.platypus import Spacer

    program = content.program
    yield _text(program.name, 15, bold=True)
    yield Spacer(1, 4)
    rows = [[label, value] for label, value in content.header if label != "Program"]
    yield _table([*rows, ["SHA-256", program.sha256]], [70, ROOM - 70], ())
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
    yield _title("What the program makes")
    for scene in content.pictures:
        yield _picture(scene)
    yield from _tables(content)


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

    speed = "" if op.speed_rpm is None else f"{op.speed_rpm:g}"
    return [str(op.number), op.what, ", ".join(op.faces), figure(op.x), figure(op.y),
            figure(op.depth), figure(op.feed_mm_min), speed, f"{op.seconds:.1f}"]  # fmt: skip


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


def _picture(scene: Scene) -> Any:
    """A picture as wide as the page, or as high as what it leaves."""
    from reportlab.platypus import Flowable

    scale = min(ROOM / scene.width, HIGH / scene.height, POINTS_PER_PIXEL)

    class Picture(Flowable):  # type: ignore[misc]
        def __init__(self) -> None:
            super().__init__()
            self.width, self.height = scene.width * scale, scene.height * scale

        def draw(self) -> None:
            draw_scene(self.canv, scene, 0.0, self.height, scale)

    return Picture()
