"""A scene as PNG, by Pillow (an extra): drawn large and made smaller, so that lines are smooth."""

import io
from collections.abc import Iterator, Sequence
from itertools import pairwise
from math import dist
from typing import Any

from beamcam.errors import PictureError, Source
from beamcam.pictures import rules
from beamcam.pictures.scene import Circle, Point, Polyline, Scene, Text
from beamcam.pictures.styles import Style, style_of

FINER = 3  #: pixels drawn for one of the picture, each way
MAX_SIDE = 5000  #: of the picture, in pixels


def to_png(scene: Scene) -> bytes:
    """The picture; the same scene gives the same bytes. Raises PictureError without Pillow."""
    try:
        from PIL import Image, ImageDraw
    except ImportError as error:
        said = rules.NEEDS.at(Source("picture"), found="no Pillow", what="PNG")
        raise PictureError(said) from error
    width, height = (min(round(v), MAX_SIDE) for v in (scene.width, scene.height))
    image = Image.new("RGB", (width * FINER, height * FINER), style_of("paper").fill)
    pen = _Pen(image, ImageDraw.Draw(image))
    for shape in scene.shapes:
        pen.draw(shape)
    stream = io.BytesIO()
    image.resize((width, height), Image.Resampling.LANCZOS).save(stream, "PNG", optimize=True)
    return stream.getvalue()


class _Pen:
    """Draws shapes on an image of Pillow."""

    def __init__(self, image: Any, draw: Any) -> None:
        self.image, self.pen = image, draw

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

        font = ImageFont.load_default(shape.size * FINER)
        anchor = {"start": "ls", "middle": "ms", "end": "rs"}[shape.anchor]
        x, y = (FINER * v for v in shape.at)
        if not shape.turn_deg:
            bold = 1 if style.bold else 0  # the font has no bold letters: a rim around each
            self.pen.text((x, y), shape.text, style.fill, font, anchor, stroke_width=bold)
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
