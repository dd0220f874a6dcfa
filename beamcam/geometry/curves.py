"""Exact curves in the plane.

Every curve is an immutable record with `start`, `end`, `length`, `bbox`, `point(t)`,
`tangent(t)` and `split(t)` for t in [0, 1], `reversed()` and `transformed(matrix)`. Nothing here
needs numpy; many points at once are `sampling`'s.
"""

from collections.abc import Sequence
from math import atan2, degrees, dist

from beamcam.geometry.bezier import Bezier
from beamcam.geometry.bspline import BSpline
from beamcam.geometry.conics import Arc, EllipseArc, Line, arc_through, segment_area
from beamcam.geometry.newton import NewtonCurve
from beamcam.geometry.plane import Box, Matrix, Point, cross, integrate, join_boxes, unit_vector

Curve = Line | Arc | EllipseArc | Bezier | BSpline | NewtonCurve

__all__ = [
    "Arc",
    "BSpline",
    "Bezier",
    "Box",
    "Curve",
    "EllipseArc",
    "Line",
    "Matrix",
    "NewtonCurve",
    "Point",
    "arc_through",
    "bezier_pieces",
    "circle_of",
    "join_boxes",
    "signed_area",
    "slot_of",
    "unit_vector",
]


def bezier_pieces(curve: Bezier | BSpline | NewtonCurve) -> tuple[Bezier, ...]:
    """A free curve as Bezier curves that follow one another."""
    match curve:
        case Bezier():
            return (curve,)
        case BSpline():
            return curve.pieces()
        case NewtonCurve():
            return (curve.as_bezier(),)


def circle_of(curves: Sequence[Curve]) -> tuple[Point, float] | None:
    """Centre and radius of a chain that is a whole circle."""
    if not curves or not all(isinstance(curve, Arc) for curve in curves):
        return None
    arcs = [curve for curve in curves if isinstance(curve, Arc)]
    first = arcs[0]
    same = all(
        dist(a.centre, first.centre) < 1e-6 and abs(a.radius - first.radius) < 1e-6 for a in arcs
    )
    is_whole = abs(abs(sum(a.sweep_deg for a in arcs)) - 360.0) < 1e-6
    return (first.centre, first.radius) if same and is_whole else None


def slot_of(curves: Sequence[Curve]) -> tuple[Point, float, float, float] | None:
    """Middle, length, width and angle in degrees of a chain of two lines and two half circles."""
    lines = [curve for curve in curves if isinstance(curve, Line)]
    ends = [curve for curve in curves if isinstance(curve, Arc)]
    if not len(lines) == len(ends) == 2 or len(curves) != 4:
        return None
    (x0, y0), (x1, y1) = (end.centre for end in ends)
    apart, radius = dist(ends[0].centre, ends[1].centre), ends[0].radius
    alike = all(
        abs(end.radius - radius) < 1e-6 and abs(abs(end.sweep_deg) - 180.0) < 1e-6 for end in ends
    )
    if not alike or any(abs(line.length - apart) > 1e-6 for line in lines):
        return None
    angle = degrees(atan2(y1 - y0, x1 - x0)) % 180.0
    return ((x0 + x1) / 2, (y0 + y1) / 2), apart + 2 * radius, 2 * radius, angle


def signed_area(curves: tuple[Curve, ...]) -> float:
    """Area inside a closed chain of curves in mm2, positive if it runs counter-clockwise.

    Green's theorem: the polygon of the ends, plus the area between each curve and its chord.
    """
    total = 0.0
    for curve in curves:
        total += cross(curve.start, curve.end) / 2
        match curve:
            case Line():
                pass
            case Arc():
                total += segment_area(curve.sweep_deg, curve.radius, curve.radius)
            case EllipseArc():
                total += segment_area(curve.sweep_deg, curve.major, curve.minor)
            case _:
                total += sum(_area_beside_chord(piece) for piece in bezier_pieces(curve))
                points = [piece.start for piece in bezier_pieces(curve)]
                ends = zip(points, [*points[1:], curve.end], strict=True)
                total += sum(cross(a, b) for a, b in ends) / 2 - cross(curve.start, curve.end) / 2
    return total


def _area_beside_chord(curve: Bezier) -> float:
    """Half of the integral of r x r' about the start of the curve, less the chord's share (0)."""
    x0, y0 = curve.start

    def swept(t: float) -> float:
        (x, y), velocity, _ = curve.derivatives(t)
        return cross((x - x0, y - y0), velocity)

    reach = max(abs(x - x0) + abs(y - y0) for x, y in curve.points)
    return integrate(swept, floor=1e-13 * (reach + abs(x0) + abs(y0)) * reach) / 2
