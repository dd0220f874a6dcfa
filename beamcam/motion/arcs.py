"""Arcs, ellipses and parabolas in the numbers that are written.

A controller sees ends and centre after they were rounded, and checks them against each other. So
the centre is solved again from the rounded ends; where that leaves the controller's limit the arc
is split, and where nothing helps it becomes lines. Nothing is ever written that would turn the
other way round or the long way.
"""

from collections.abc import Iterator
from math import atan2, cos, degrees, dist, hypot, pi, radians, sin, sqrt, tan

from msgspec import Struct

from beamcam.geometry.curves import Arc, Bezier, EllipseArc, Line
from beamcam.geometry.plane import Point, cross
from beamcam.model.program import ArcFeed, EllipseFeed, Feed, Movement, ParabolaFeed

#: Above this sweep an arc is written as two, so that no controller can take the other way round.
MAX_SWEEP_DEG = 180.0
SWEEP_SLACK_DEG = 1e-9

#: How far the written centre may lie beside the bisector of the written chord, by the radius;
#: CODESYS mends a tenth and drives a line beyond.
BISECTOR_SHARE = 0.02

#: Below this sweep the radius is kept and above it the sweep, which is what each depends on least.
KEEP_SWEEP_DEG = 90.0

MAX_SPLITS = 12

#: An ellipse rounder than this is fitted with arcs, since its axes cannot be told apart.
ROUND_RATIO = 0.999


class Numbers(Struct, frozen=True):
    """How the controller's numbers are written and what it accepts."""

    decimals: int
    angle_decimals: int
    tolerance: float  #: left for chords that stand for an arc
    arc_limit: float  #: greatest difference of the radii at both ends
    min_radius: float
    max_radius: float

    @property
    def step(self) -> float:
        """The smallest length that is written."""
        return 10.0**-self.decimals

    def at(self, point: Point) -> Point:
        """A point as it is written; never -0."""
        d = self.decimals
        return round(point[0], d) + 0.0, round(point[1], d) + 0.0


def arc_feeds(start: Point, arc: Arc, numbers: Numbers, splits: int = MAX_SPLITS) -> list[Movement]:
    """The moves that follow an arc from `start`, the written place where the last one ended.

    Arcs up to half a circle; lines where an arc is too flat to differ from one, or too small or
    too large for the controller. Moves of no length are left out.
    """
    if abs(arc.sweep_deg) > MAX_SWEEP_DEG + SWEEP_SLACK_DEG:
        return _halves(start, arc, numbers, splits)
    end = numbers.at(arc.end)
    if end == start:
        return []
    sagitta = arc.radius * (1 - cos(radians(arc.sweep_deg) / 2))
    if sagitta < numbers.step / 2:
        return [Feed(*end)]
    if numbers.min_radius <= arc.radius <= numbers.max_radius:
        move = _written_arc(start, end, arc, numbers)
        if move is not None:
            return [move]
    if sagitta <= numbers.tolerance:
        return [Feed(*end)]
    if splits == 0:
        raise AssertionError("an arc that halving does not make flat")
    return _halves(start, arc, numbers, splits - 1)


def _halves(start: Point, arc: Arc, numbers: Numbers, splits: int) -> list[Movement]:
    first, last = arc.split(0.5)
    moves = arc_feeds(start, first, numbers, splits)
    here = (moves[-1].x, moves[-1].y) if moves else start
    return moves + arc_feeds(here, last, numbers, splits)


def _written_arc(start: Point, end: Point, arc: Arc, numbers: Numbers) -> ArcFeed | None:
    """The arc in written numbers; None if the controller would not take it for the same arc."""
    chord = dist(start, end)
    sweep = abs(radians(arc.sweep_deg))
    half = chord / 2
    if abs(arc.sweep_deg) < KEEP_SWEEP_DEG:
        if arc.radius < half:
            return None
        height = sqrt(arc.radius * arc.radius - half * half)
    else:
        height = half / tan(sweep / 2)
    side = 1.0 if arc.sweep_deg > 0 else -1.0
    ux, uy = (end[0] - start[0]) / chord, (end[1] - start[1]) / chord
    d = numbers.decimals
    i = round((end[0] - start[0]) / 2 - side * height * uy, d) + 0.0
    j = round((end[1] - start[1]) / 2 + side * height * ux, d) + 0.0
    centre = (start[0] + i, start[1] + j)
    near, far = hypot(i, j), dist(centre, end)
    if abs(near - far) > numbers.arc_limit or near < numbers.min_radius:
        return None
    beside = abs(
        (centre[0] - (start[0] + end[0]) / 2) * ux + (centre[1] - (start[1] + end[1]) / 2) * uy
    )
    if beside > BISECTOR_SHARE * near:
        return None
    first = atan2(start[1] - centre[1], start[0] - centre[0])
    last = atan2(end[1] - centre[1], end[0] - centre[0])
    turned = side * (last - first) % (2 * pi)
    middle_angle = first + side * turned / 2
    middle = (centre[0] + near * cos(middle_angle), centre[1] + near * sin(middle_angle))
    if dist(middle, arc.point(0.5)) > 3 * numbers.step:
        return None
    return ArcFeed(end[0], end[1], i, j, side < 0)


def ellipse_feeds(start: Point, ellipse: EllipseArc, numbers: Numbers) -> list[Movement] | None:
    """The moves along an ellipse by its own word; None where that would be another ellipse.

    It is cut at the ends of its axes, for between them both end points determine it best. The
    axes follow from the rounded ends, as CODESYS solves them: x^2 / a^2 + y^2 / b^2 = 1 twice.
    """
    if ellipse.ratio > ROUND_RATIO:
        return None
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
