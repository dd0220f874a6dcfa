"""Scenes as PDF, by reportlab (an extra): a page each, on A4 or A3."""

import io
from collections.abc import Sequence
from typing import Any, Literal

from beamcam.errors import PictureError, Source
from beamcam.pictures import NEEDS
from beamcam.pictures.scene import Circle, Polyline, Scene, Style, Text, style_of

POINTS_PER_PIXEL = 0.75
Paper = Literal["a4", "a3"]
#: Points of a page that stands upright.
SIZES: dict[Paper, tuple[float, float]] = {"a4": (595.276, 841.89), "a3": (841.89, 1190.551)}
MARGIN = 28.0


def to_pdf(scenes: Sequence[Scene], paper: Paper = "a4") -> bytes:
    """The pictures, one a page; the same scenes give the same bytes.

    Each is made to fit its page, upright or not as it fits better. Raises PictureError without
    reportlab.
    """
    size = SIZES[paper]
    canvas_of = needed_canvas()
    stream = io.BytesIO()
    canvas = canvas_of(stream, size)
    canvas.setTitle(scenes[0].title)
    canvas.setCreator("beamcam")
    for scene in scenes:
        page = size if scene.height > scene.width else (size[1], size[0])
        canvas.setPageSize(page)
        scale = min(
            largest(paper), (page[0] - 2 * MARGIN) / scene.width,
            (page[1] - 2 * MARGIN) / scene.height,
        )  # fmt: skip
        draw_scene(canvas, scene, MARGIN, page[1] - MARGIN, scale)
        canvas.showPage()
    canvas.save()
    return stream.getvalue()


def largest(paper: Paper) -> float:
    """Points that a pixel has at most on a paper: on A3 as much more as it is wider."""
    return POINTS_PER_PIXEL * SIZES[paper][0] / SIZES["a4"][0]


def needed_canvas() -> Any:
    """A maker of canvases whose files carry no time. Raises PictureError without reportlab."""
    try:
        from reportlab.pdfgen.canvas import Canvas
    except ImportError as error:
        diagnostic = NEEDS.at(Source("picture"), found="no reportlab", what="PDF")
        raise PictureError(diagnostic) from error
    return lambda stream, size: Canvas(stream, size, invariant=1)


def draw_scene(canvas: Any, scene: Scene, left: float, top: float, scale: float) -> None:
    """Draws a picture with its upper left corner at a place of the page, in points."""
    canvas.saveState()
    canvas.translate(left, top)
    canvas.scale(scale, scale)
    for shape in scene.shapes:
        _draw(canvas, shape)
    canvas.restoreState()


def _draw(canvas: Any, shape: Circle | Polyline | Text) -> None:
    style = style_of(shape.classes)
    if isinstance(shape, Text):
        _text(canvas, shape, style)
        return
    stroke, fill = int(style.stroke is not None), int(style.fill is not None)
    if style.stroke:
        canvas.setStrokeColor(_colour(style.stroke))
        canvas.setLineWidth(style.width)
        canvas.setDash(*((list(style.dash),) if style.dash else ()))
    if style.fill:
        canvas.setFillColor(_colour(style.fill))
    if isinstance(shape, Circle):
        canvas.circle(shape.at[0], -shape.at[1], shape.radius, stroke=stroke, fill=fill)
        return
    path = canvas.beginPath()
    path.moveTo(shape.points[0][0], -shape.points[0][1])
    for x, y in shape.points[1:]:
        path.lineTo(x, -y)
    if shape.closed:
        path.close()
    canvas.drawPath(path, stroke=stroke, fill=fill and int(shape.closed))


def _text(canvas: Any, shape: Text, style: Style) -> None:
    canvas.saveState()
    canvas.setFillColor(_colour(style.fill or "#000000"))
    canvas.setFont("Helvetica-Bold" if style.bold else "Helvetica", shape.size)
    canvas.translate(shape.at[0], -shape.at[1])
    canvas.rotate(shape.turn_deg)
    write = {"start": canvas.drawString, "middle": canvas.drawCentredString,
             "end": canvas.drawRightString}[shape.anchor]  # fmt: skip
    write(0, 0, plain_letters(shape.text))
    canvas.restoreState()


def plain_letters(text: str) -> str:
    """A text in the letters that the fonts of every PDF have; `?` for any other."""
    return text.encode("cp1252", "replace").decode("cp1252")


def _colour(code: str) -> Any:
    from reportlab.lib.colors import HexColor

    return HexColor(code)
