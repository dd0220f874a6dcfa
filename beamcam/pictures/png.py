"""A scene as PNG, by Pillow (an extra): drawn large and made smaller, so that lines are smooth."""

import io
from collections.abc import Iterator, Sequence
from importlib.util import find_spec
from itertools import pairwise
from math import dist
from pathlib import PurePath
from typing import Any

from beamcam.errors import PictureError, Source
from beamcam.pictures import NEEDS
from beamcam.pictures.scene import Circle, Point, Polyline, Scene, Style, Text, style_of

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
    fonts = _fonts()
    image = Image.new("RGB", (width * FINER, height * FINER), style_of("paper").fill)
    pen = _Pen(image, ImageDraw.Draw(image), fonts)
    for shape in scene.shapes:
        pen.draw(shape)
    stream = io.BytesIO()
    image.resize((width, height), Image.Resampling.LANCZOS).save(stream, "PNG", optimize=True)
    return stream.getvalue()


def _fonts() -> tuple[str, str]:
    """The font of the letters and the bold one: those that reportlab brings.

    Pillow's own has no diameter sign, nor any letter beyond English.
    """
    found = find_spec("reportlab")
    if found is None or found.origin is None:
        diagnostic = NEEDS.at(Source("picture"), found="no reportlab", what="PNG")
        raise PictureError(diagnostic)
    folder = PurePath(found.origin).parent / "fonts"
    return str(folder / "Vera.ttf"), str(folder / "VeraBd.ttf")


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
    """The stretches of a chain that a dash pattern draws; all of it without one."""
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
