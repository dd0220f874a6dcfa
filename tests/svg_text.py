"""SVG files for tests, and what is read from them."""

from beamcam.errors import errors_in
from beamcam.geometry.curves import Curve
from beamcam.model.lengths import total_length
from beamcam.model.part import extent
from beamcam.readers import Reading, svg

PAGE = 'width="100mm" height="100mm" viewBox="0 0 100 100"'


def drawing(body: str, head: str = PAGE) -> bytes:
    """A file whose shapes have a red stroke and no fill, unless they say otherwise."""
    root = f'<svg xmlns="http://www.w3.org/2000/svg" fill="none" stroke="red" {head}>'
    return f"{root}\n{body}\n</svg>\n".encode()


def read(body: str, head: str = PAGE, **options: object) -> Reading:
    return svg.read(drawing(body, head), "a.svg", **options)  # type: ignore[arg-type]


def curves_of(body: str, head: str = PAGE, **options: object) -> tuple[Curve, ...]:
    """All curves of a drawing that must not be refused."""
    reading = read(body, head, **options)
    assert errors_in(reading.diagnostics) == ()
    return tuple(curve for contour in reading.parts[0].contours for curve in contour.curves)


def box_of(body: str, head: str = PAGE, **options: object) -> tuple[float, ...]:
    box = extent(curves_of(body, head, **options))
    assert box is not None
    return box


def length_of(body: str, head: str = PAGE, **options: object) -> float:
    return total_length(curves_of(body, head, **options))


def codes(body: str, head: str = PAGE, **options: object) -> list[str]:
    return [d.code for d in read(body, head, **options).diagnostics]
