"""Sheets for the tests of cutting tables."""

from beamcam.errors import Source
from beamcam.geometry.curves import Arc, Curve, Line
from beamcam.machine import Machine, load
from beamcam.machine.overlay import with_torch
from beamcam.model.part import Contour, Feature, Measures, Part, Process, Profile

FILE = "sheet.dxf"
S = Source("p.nc1", 7)


def lines(*points: tuple[float, float], closed: bool = True) -> tuple[Curve, ...]:
    """Lines from point to point, and back to the first."""
    ends = [*points[1:], points[0]] if closed else points[1:]
    return tuple(Line(a, b) for a, b in zip(points, ends, strict=False))


def box(x: float, y: float, width: float, height: float) -> tuple[Curve, ...]:
    return lines((x, y), (x + width, y), (x + width, y + height), (x, y + height))


def circle(x: float, y: float, diameter: float) -> tuple[Curve, ...]:
    return (Arc((x, y), diameter / 2, 0.0, 360.0),)


def contour(
    curves: tuple[Curve, ...],
    colour: str | None = "#ff0000",
    layer: str | None = None,
    process: Process = "cut",
    line: int = 1,
) -> Contour:
    closed = curves[0].start == curves[-1].end
    kind = "outer" if closed else "open"
    return Contour(
        "v", kind, curves, Source(FILE, line), process, closed, layer=layer, colour=colour
    )  # fmt: skip


def drawing(*features: Feature, thickness: float | None = 6.0, grade: str = "") -> Part:
    """A drawing, which needs no outline of its own."""
    return Part(
        "SHEET",
        Profile("B", "", 100.0, 0.0, 0.0, thickness),
        200.0,
        Source(FILE),
        grade=grade,
        features=features,
        measures=Measures(),
    )


def plate(*features: Feature, quantity: int = 1) -> Part:
    """A DSTV plate of 200 x 100 x 6."""
    profile = Profile("B", "PL6*100", 100.0, 0.0, 0.0, 6.0)
    return Part("P1", profile, 200.0, Source("p.nc1"), quantity=quantity, features=features)


def table(name: str = "plate-linuxcnc", **values: object) -> Machine:
    return with_torch(load(name), **values)  # type: ignore[arg-type]


#: A plate with a hole in it, a plate in the hole, and a line that is marked.
NESTED = drawing(
    contour(box(0, 0, 200, 100), line=1),
    contour(circle(60, 50, 70), line=2),
    contour(box(45, 40, 30, 20), line=3),
    contour(lines((150, 20), (180, 20), closed=False), "#0000ff", line=4),
    contour(circle(150, 60, 10), line=5),
)
