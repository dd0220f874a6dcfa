"""Parabolas and ellipses in the numbers that are written, where the controller has words for them.

A controller sees ends and centre after they were rounded, and solves the curve from these. Nothing
is ever written that it would take for another curve.
"""

from collections.abc import Iterator
from math import atan2, cos, degrees, hypot, radians, sin, sqrt

from beamcam.geometry.curves import Bezier, EllipseArc, Line
from beamcam.geometry.plane import Point, cross
from beamcam.model.program import EllipseFeed, Feed, Movement, ParabolaFeed
from beamcam.motion.numbers import Numbers

#: An ellipse rounder than this is fitted with arcs, since its axes cannot be told apart.
ROUND_RATIO = 0.999


def ellipse_feeds(start: Point, ellipse: EllipseArc, numbers: Numbers) -> list[Movement] | None:
    """The moves along an ellipse by its own word; None where that would be another ellipse.

    It is cut at the ends of its axes, for between them both end points determine it best. The
    axes follow from the rounded ends, as CODESYS solves them: x^2 / a^2 + y^2 / b^2 = 1 twice.
    """
    moves: list[Movement] = []
    here = start
    for piece in _quarters(ellipse):
        end = numbers.at(piece.end)
        if end == here:
            continue
        move = _written_ellipse(here, end, piece, numbers)
        if move is None:
            return None
        moves.append(move)
        here = end
    return moves


def _quarters(ellipse: EllipseArc) -> Iterator[EllipseArc]:
    """Pieces that pass no end of an axis."""
    sign = 1.0 if ellipse.sweep_deg > 0 else -1.0
    done, rest = 0.0, ellipse
    total = abs(ellipse.sweep_deg)
    first = (-sign * ellipse.start_deg) % 90.0 or 90.0
    at = first
    while at < total - 1e-9:
        left, rest = rest.split((at - done) / (total - done))
        yield left
        done, at = at, at + 90.0
    yield rest


def _written_ellipse(
    start: Point, end: Point, piece: EllipseArc, numbers: Numbers
) -> EllipseFeed | None:
    d = numbers.decimals
    i = round(piece.centre[0] - start[0], d) + 0.0
    j = round(piece.centre[1] - start[1], d) + 0.0
    angle = round(degrees(atan2(piece.axis[1], piece.axis[0])), numbers.angle_decimals) + 0.0
    ratio = round(piece.ratio, 6)
    centre = (start[0] + i, start[1] + j)
    c, s = cos(radians(angle)), sin(radians(angle))

    def local(p: Point) -> Point:
        x, y = p[0] - centre[0], p[1] - centre[1]
        return c * x + s * y, c * y - s * x

    (x1, y1), (x2, y2) = local(start), local(end)
    det = x1 * x1 * y2 * y2 - x2 * x2 * y1 * y1
    if abs(det) < 1e-9 * piece.major**2 * piece.minor**2:
        return None
    over_a2, over_b2 = (y2 * y2 - y1 * y1) / det, (x1 * x1 - x2 * x2) / det
    if over_a2 <= 0.0 or over_b2 <= over_a2:
        return None
    for share in (0.25, 0.5, 0.75):
        x, y = local(piece.point(share))
        size = sqrt(over_a2 * x * x + over_b2 * y * y)
        if abs(size - 1.0) * hypot(x, y) > 4 * numbers.step:
            return None
    return EllipseFeed(end[0], end[1], i, j, angle, ratio, piece.sweep_deg < 0)


def parabola_feed(start: Point, curve: Bezier, numbers: Numbers) -> list[Movement]:
    """The move along a Bezier curve of degree two; a line where it is too flat to differ.

    Its vertex, where the tangent is parallel to the chord, is its point at t = 1/2.
    """
    (x0, y0), (x1, y1), (x2, y2) = curve.points
    end = numbers.at(curve.end)
    vertex = (x0 / 4 + x1 / 2 + x2 / 4, y0 / 4 + y1 / 2 + y2 / 4)
    if end == start:
        return []
    chord = (x2 - x0, y2 - y0)
    if abs(cross(chord, (vertex[0] - x0, vertex[1] - y0))) < numbers.step / 2 * hypot(*chord):
        return [Feed(*end)]
    d = numbers.decimals
    i, j = round(vertex[0] - start[0], d) + 0.0, round(vertex[1] - start[1], d) + 0.0
    drawn = (end[0] - start[0], end[1] - start[1])
    if abs(cross(drawn, (i, j))) < numbers.step / 4 * hypot(*drawn):
        return [Feed(*end)]  # rounding took the vertex onto the chord, where no parabola has it
    return [ParabolaFeed(end[0], end[1], i, j)]


def is_parabola(curve: Bezier) -> bool:
    """Whether a curve is a parabola that its chord sees from the side.

    A control point that does not lie over the chord makes the curve turn back on it, where the
    word of the controller says less than the curve is.
    """
    if curve.degree != 2 or curve.weights is not None or curve.start == curve.end:
        return False
    chord = Line(curve.start, curve.end)
    along = (curve.points[1][0] - chord.start[0], curve.points[1][1] - chord.start[1])
    share = (
        along[0] * (chord.end[0] - chord.start[0]) + along[1] * (chord.end[1] - chord.start[1])
    ) / chord.length**2
    flat = abs(cross(along, (chord.end[0] - chord.start[0], chord.end[1] - chord.start[1])))
    return 0.0 <= share <= 1.0 or flat > 1e-6 * chord.length**2
