"""The curve of a move, from the current position of the head."""

from math import atan2, cos, degrees, hypot, radians, sin

from beamcam.geometry.curves import Arc, Bezier, EllipseArc, Line
from beamcam.geometry.plane import Point
from beamcam.model.program import ArcFeed, EllipseFeed, Feed, Movement, ParabolaFeed


def curve_of(here: Point, move: Movement) -> Line | Arc | Bezier | EllipseArc:
    """The curve of a move that starts `here`; an arc that ends where it starts is a circle."""
    end = move.x, move.y
    match move:
        case Feed():
            return Line(here, end)
        case ArcFeed(i=i, j=j, clockwise=clockwise):
            centre = here[0] + i, here[1] + j
            first = degrees(atan2(-j, -i))
            last = degrees(atan2(end[1] - centre[1], end[0] - centre[0]))
            return Arc(centre, hypot(i, j), first, _sweep_deg(here, end, first, last, clockwise))
        case ParabolaFeed(i=i, j=j):
            vertex = here[0] + i, here[1] + j
            control = tuple(2 * v - (a + b) / 2 for v, a, b in zip(vertex, here, end, strict=True))
            return Bezier((here, (control[0], control[1]), end))
        case EllipseFeed():
            return _ellipse(here, end, move)


def _ellipse(here: Point, end: Point, move: EllipseFeed) -> EllipseArc:
    centre = here[0] + move.i, here[1] + move.j
    c, s = cos(radians(move.angle)), sin(radians(move.angle))

    def eccentric(point: Point) -> tuple[float, float]:
        """The place in the circle that the ellipse is the image of."""
        x, y = point[0] - centre[0], point[1] - centre[1]
        return c * x + s * y, (c * y - s * x) / move.ratio

    (ax, ay), (bx, by) = eccentric(here), eccentric(end)
    first, last = degrees(atan2(ay, ax)), degrees(atan2(by, bx))
    major = hypot(ax, ay)
    sweep = _sweep_deg(here, end, first, last, move.clockwise)
    return EllipseArc(centre, (major * c, major * s), move.ratio, first, sweep)


def _sweep_deg(start: Point, end: Point, first: float, last: float, clockwise: bool) -> float:
    if start == end:
        return -360.0 if clockwise else 360.0
    if clockwise:
        return -((first - last) % 360.0)
    return (last - first) % 360.0
