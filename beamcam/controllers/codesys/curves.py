"""The curves of CODESYS SoftMotion CNC: arcs, parabolas and ellipses.

    G02 G03 X Y I J, or R  arc about a centre, or below 180 degrees with a radius
    G06 X Y I J            parabola, I and J its vertex: there the tangent is parallel to the chord
    G08 G09 X Y I J K R    ellipse, K the direction of its main axis in degrees, R minor / major

Both ends and the centre determine an ellipse; R counts where both ends are equally far from the
main axis. What cannot be becomes a straight line without a word, so it is checked here. Source:
CODESYS online help, "CNC: DIN 66025".
"""

from math import atan2, cos, degrees, radians, sin, sqrt

from beamcam.controllers.arcs import arc_of
from beamcam.controllers.codesys.arcs import arc_fault, radius_centre, radius_fault
from beamcam.controllers.events import Curve
from beamcam.geometry.curves import Arc, Bezier, EllipseArc
from beamcam.geometry.plane import Point, cross


def curve_of(
    motion: int,
    start: Point,
    end: Point,
    words: dict[str, float],
    origin: Point,
    resolution: float,
) -> Curve | str:
    """The curve of a block, whose I and J count from `origin`, or what is wrong with it.

    `resolution` is the step of the numbers.
    """
    clockwise = motion in (2, 8)
    if motion in (2, 3) and "R" in words:
        return _arc_by_radius(start, end, words, clockwise)
    if not {"I", "J"} <= words.keys():
        return "without I, J or R" if motion in (2, 3) else "without I and J"
    at = (origin[0] + words["I"], origin[1] + words["J"])
    if motion == 6:
        return _parabola(start, end, at)
    if motion in (2, 3):
        fault = arc_fault(start, end, at, resolution)
        return fault or arc_of(start, end, at, clockwise)
    angle, ratio = words.get("K", 0.0), words.get("R", 0.0)
    return _ellipse(start, end, at, angle, ratio, clockwise, resolution)


def _arc_by_radius(start: Point, end: Point, words: dict[str, float], clockwise: bool) -> Arc | str:
    if "I" in words or "J" in words:
        return "with R as well as I and J"
    fault = radius_fault(start, end, words["R"])
    if fault:
        return fault
    return arc_of(start, end, radius_centre(start, end, words["R"], clockwise), clockwise)


def _parabola(start: Point, end: Point, vertex: Point) -> Bezier | str:
    """The Bezier curve of degree two whose point at t = 1/2 is the vertex."""
    if start == end:
        return "that is a parabola from a point to itself"
    chord = (end[0] - start[0], end[1] - start[1])
    if cross(chord, (vertex[0] - start[0], vertex[1] - start[1])) == 0.0:
        return "that is a parabola whose vertex lies on its chord"
    control = (
        2 * vertex[0] - (start[0] + end[0]) / 2,
        2 * vertex[1] - (start[1] + end[1]) / 2,
    )
    return Bezier((start, control, end))


def _ellipse(
    start: Point,
    end: Point,
    centre: Point,
    angle: float,
    ratio: float,
    clockwise: bool,
    resolution: float,
) -> EllipseArc | str:
    c, s = cos(radians(angle)), sin(radians(angle))

    def local(p: Point) -> Point:
        x, y = p[0] - centre[0], p[1] - centre[1]
        return c * x + s * y, c * y - s * x

    (x1, y1), (x2, y2) = local(start), local(end)
    if abs(abs(y1) - abs(y2)) <= resolution:
        if not 0.0 < ratio <= 1.0:
            return f"that is an ellipse of ratio {ratio:g} whose ends do not determine it"
        major = sqrt(x1 * x1 + (y1 / ratio) ** 2)
        minor = major * ratio
    else:
        det = x1 * x1 * y2 * y2 - x2 * x2 * y1 * y1
        if det == 0.0:
            return "that is an ellipse whose ends lie on one line with its centre"
        over_a2, over_b2 = (y2 * y2 - y1 * y1) / det, (x1 * x1 - x2 * x2) / det
        if over_a2 <= 0.0 or over_b2 <= 0.0:
            return "that is an ellipse on which its ends do not lie"
        major, minor = 1 / sqrt(over_a2), 1 / sqrt(over_b2)
    if minor > major:
        return f"that is an ellipse whose main axis {major:.4f} is shorter than {minor:.4f}"
    first = degrees(atan2(y1 / minor, x1 / major))
    sweep = 360.0
    if start != end:
        last = degrees(atan2(y2 / minor, x2 / major))
        sweep = ((first - last) if clockwise else (last - first)) % 360.0 or 360.0
    return EllipseArc(
        centre, (major * c, major * s), minor / major, first, -sweep if clockwise else sweep
    )
