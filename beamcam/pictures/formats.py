"""Scenes as SVG, PNG and PDF.

An SVG is a file by itself, or a drawing within a page that has the styles. A PNG, by Pillow (an
extra), is drawn large and made smaller, so that lines are smooth. A PDF, by reportlab (an extra),
has a page each, on A4 or A3.
"""

import io
from collections.abc import Iterator, Sequence
from html import escape
from importlib.util import find_spec
from itertools import pairwise
from math import dist
from pathlib import PurePath
from typing import Any, Literal

from beamcam.errors import PictureError, Source
from beamcam.pictures import NEEDS
from beamcam.pictures.scene import (
    Circle,
    Point,
    Polyline,
    Scene,
    Shape,
    Style,
    Text,
    css,
    shown,
    style_of,
)
from beamcam.plain_text import terminal_text

FONT = "Helvetica, Arial, 'Liberation Sans', 'DejaVu Sans', sans-serif"


def to_svg(scene: Scene) -> str:
    """The picture as a file; the same scene gives the same bytes."""
    used = {shape.classes.split(" ", 1)[0] for shape in scene.shapes} | {"paper"}
    rules = "".join(f"{rule}}}" for rule in css().split("}") if rule[1:].split("{", 1)[0] in used)
    paper = f'<rect class="paper" width="{_n(scene.width)}" height="{_n(scene.height)}"/>'
    size = f'width="{_n(scene.width)}" height="{_n(scene.height)}" '
    return "\n".join(_drawing(scene, size, f"<style>{rules}</style>\n{paper}")) + "\n"


def inline_svg(scene: Scene) -> str:
    """The picture for a page that has the rules of `styles.css`."""
    return "\n".join(_drawing(scene, "", ""))


def _drawing(scene: Scene, size: str, before: str) -> Iterator[str]:
    yield (
        f'<svg xmlns="http://www.w3.org/2000/svg" {size}'
        f'viewBox="0 0 {_n(scene.width)} {_n(scene.height)}" role="img" '
        f'font-family="{FONT}" font-size="11">'
    )
    yield f"<title>{_t(scene.title)}</title>"
    yield f"<desc>{_t(scene.about)}</desc>"
    if before:
        yield before
    for shape in scene.shapes:
        yield _shape(shape)
    yield "</svg>"


def _shape(shape: Shape) -> str:
    more = f' data-line="{shape.line}"' if shape.line else ""
    tip = f"<title>{_t(shape.tip)}</title>" if shape.tip else ""
    start = f'class="{shape.classes}"{more}'
    match shape:
        case Circle(at=(x, y), radius=radius):
            return f'<circle {start} cx="{_n(x)}" cy="{_n(y)}" r="{_n(radius)}"' + _end(
                "circle", tip
            )
        case Polyline():
            return f'<path {start} d="{_path(shape.points, shape.closed)}"' + _end("path", tip)
        case Text():
            return _text(shape, start, tip)


def _end(name: str, inner: str) -> str:
    return f">{inner}</{name}>" if inner else "/>"


def _path(points: tuple[Point, ...], closed: bool) -> str:
    """Steps from point to point, so that long paths stay short; the rounding does not add up."""
    x, y = round(points[0][0] * 100), round(points[0][1] * 100)
    words = [f"M{_c(x)} {_c(y)}"]
    if len(points) > 1:
        words.append("l")
    for px, py in points[1:]:
        to_x, to_y = round(px * 100), round(py * 100)
        words.append(f"{_c(to_x - x)} {_c(to_y - y)} ")
        x, y = to_x, to_y
    return "".join(words).rstrip() + ("z" if closed else "")


def _text(shape: Text, start: str, tip: str) -> str:
    x, y = shape.at
    size = f' font-size="{_n(shape.size)}"' if shape.size != 11.0 else ""
    anchor = f' text-anchor="{shape.anchor}"' if shape.anchor != "start" else ""
    turn = f' transform="rotate({_n(-shape.turn_deg)} {_n(x)} {_n(y)})"' if shape.turn_deg else ""
    mm = f' data-mm="{shape.mm:.6g}"' if shape.mm is not None else ""
    if style_of(shape.classes).bold:
        size += ' font-weight="bold"'
    place = f'x="{_n(x)}" y="{_n(y)}"{size}{anchor}{turn}{mm}'
    # A page may show the lengths among the words in another unit.
    words = "".join(
        _t(one) if isinstance(one, str)
        else f'<tspan data-mm="{one:.6g}">{shown(one, shape.unit)}</tspan>'
        for one in shape.pieces or (shape.text,)
    )  # fmt: skip
    return f"<text {start} {place}>{tip}{words}</text>"


def _c(hundredths: int) -> str:
    """Hundredths as a number without needless signs."""
    text = f"{hundredths / 100:.2f}".rstrip("0").rstrip(".")
    return "0" if text == "-0" else text


def _n(value: float) -> str:
    return _c(round(value * 100))


def _t(text: str) -> str:
    """A text of an input as XML may hold it."""
    return escape(terminal_text(text))


FINER = 3  #: pixels drawn for one of the picture, each way
NARROW = 0.88  #: of the letters, which are wider than those of the other formats
MAX_SIDE = 5000  #: of the picture, in pixels


def to_png(scene: Scene) -> bytes:
    """The picture; the same scene gives the same bytes. Raises PictureError without Pillow."""
    try:
        from PIL import Image, ImageDraw
    except ImportError as error:
        diagnostic = NEEDS.at(Source("picture"), found="no Pillow", what="PNG")
        raise PictureError(diagnostic) from error
    width, height = (min(round(v), MAX_SIDE) for v in (scene.width, scene.height))
    # The fonts that reportlab brings: Pillow's own has no letter beyond English.
    reportlab = find_spec("reportlab")
    if reportlab is None or reportlab.origin is None:
        diagnostic = NEEDS.at(Source("picture"), found="no reportlab", what="PNG")
        raise PictureError(diagnostic)
    folder = PurePath(reportlab.origin).parent / "fonts"
    fonts = str(folder / "Vera.ttf"), str(folder / "VeraBd.ttf")
    image = Image.new("RGB", (width * FINER, height * FINER), style_of("paper").fill)
    pen = _Pen(image, ImageDraw.Draw(image), fonts)
    for shape in scene.shapes:
        pen.draw(shape)
    stream = io.BytesIO()
    image.resize((width, height), Image.Resampling.LANCZOS).save(stream, "PNG", optimize=True)
    return stream.getvalue()


class _Pen:
    """Draws shapes on an image of Pillow."""

    def __init__(self, image: Any, draw: Any, fonts: tuple[str, str]) -> None:
        self.image, self.pen, self.fonts = image, draw, fonts

    def draw(self, shape: Circle | Polyline | Text) -> None:
        style = style_of(shape.classes)
        match shape:
            case Circle(at=(x, y), radius=radius):
                box = [FINER * v for v in (x - radius, y - radius, x + radius, y + radius)]
                self.pen.ellipse(box, style.fill, style.stroke, self._width(style))
            case Polyline():
                self._chain(shape, style)
            case Text():
                self._text(shape, style)

    def _width(self, style: Style) -> int:
        return max(1, round(style.width * FINER))

    def _chain(self, shape: Polyline, style: Style) -> None:
        points = [(x * FINER, y * FINER) for x, y in shape.points]
        if shape.closed:
            points.append(points[0])
        if style.fill and shape.closed and len(points) > 3:
            self.pen.polygon(points, style.fill)
        if style.stroke is None:
            return
        for run in dashes(points, [d * FINER for d in style.dash]):
            if len(run) > 1:
                self.pen.line(run, style.stroke, self._width(style), "curve")

    def _text(self, shape: Text, style: Style) -> None:
        from PIL import Image, ImageDraw, ImageFont

        font = ImageFont.truetype(self.fonts[style.bold], shape.size * FINER * NARROW)
        anchor = {"start": "ls", "middle": "ms", "end": "rs"}[shape.anchor]
        x, y = (FINER * v for v in shape.at)
        if not shape.turn_deg:
            self.pen.text((x, y), shape.text, style.fill, font, anchor)
            return
        half = int(font.getlength(shape.text)) + 4 * FINER
        mask = Image.new("L", (2 * half, 2 * half), 0)
        ImageDraw.Draw(mask).text((half, half), shape.text, 255, font, anchor)
        turned = mask.rotate(shape.turn_deg, Image.Resampling.BICUBIC)
        self.image.paste(style.fill, (round(x) - half, round(y) - half), turned)


def dashes(points: Sequence[Point], pattern: Sequence[float]) -> Iterator[list[Point]]:
    """The pieces of a chain that a dash pattern draws; all of it without one."""
    if not pattern:
        yield list(points)
        return
    k, left = 0, pattern[0]
    run = [points[0]]
    for a, b in pairwise(points):
        length = dist(a, b)
        done = 0.0
        while length - done >= left:
            done += left
            share = done / length
            at = (a[0] + share * (b[0] - a[0]), a[1] + share * (b[1] - a[1]))
            if k % 2 == 0:
                yield [*run, at]
            run = [at]
            k += 1
            left = pattern[k % len(pattern)]
        left -= length - done
        run.append(b)
    if k % 2 == 0 and len(run) > 1:
        yield run


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
        _pdf_text(canvas, shape, style)
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


def _pdf_text(canvas: Any, shape: Text, style: Style) -> None:
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


def picture(scenes: Sequence[Scene], suffix: str, paper: Paper = "a4") -> str | bytes:
    """Pictures in the format of a suffix; only a PDF has room for more than the first.

    Raises PictureError where the library for the format is not installed.
    """
    if suffix == ".pdf":
        return to_pdf(scenes, paper)
    return to_png(scenes[0]) if suffix == ".png" else to_svg(scenes[0])
