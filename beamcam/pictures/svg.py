"""A scene as SVG: a file by itself, or a drawing within a page that has the styles."""

from collections.abc import Iterator
from html import escape

from beamcam.pictures.scene import (
    Circle,
    Point,
    Polyline,
    Scene,
    Shape,
    Text,
    Unit,
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
    words = (
        "".join([_piece(one, shape.unit) for one in shape.pieces])
        if shape.pieces
        else _t(shape.text)
    )
    return f"<text {start} {place}>{tip}{words}</text>"


def _piece(one: str | float, unit: Unit) -> str:
    """Words of a text, or a length among them that a page may show in another unit."""
    if isinstance(one, str):
        return _t(one)
    return f'<tspan data-mm="{one:.6g}">{shown(one, unit)}</tspan>'


def _c(hundredths: int) -> str:
    """Hundredths as a number without needless signs."""
    text = f"{hundredths / 100:.2f}".rstrip("0").rstrip(".")
    return "0" if text == "-0" else text


def _n(value: float) -> str:
    return _c(round(value * 100))


def _t(text: str) -> str:
    """A text of an input as XML may hold it."""
    return escape(terminal_text(text))
