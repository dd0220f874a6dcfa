"""The exact curves of each kind of DXF entity, in mm, seen from above, from its numbers.

Each function takes the frame that an entity stands in, a list that it adds heights to, and the
entity's numbers, and gives chains: tuples of curves that follow one another. It raises ValueError
for numbers that make no curve.
"""

from collections.abc import Callable, Iterable, Sequence
from itertools import pairwise
from math import atan, degrees, hypot, tau
from typing import Any

from msgspec import Struct

from beamcam.geometry.conics import direction_deg, ellipse_of
from beamcam.geometry.curves import Arc, BSpline, Curve, EllipseArc, Line
from beamcam.geometry.plane import IDENTITY, MAX_COORDINATE, Matrix, Point
from beamcam.readers.drawing import is_in_bounds, round_if_circle

Vector = tuple[float, float, float]
Axes = tuple[Vector, Vector, Vector]  #: x, y and z of a plane, each of length 1
Row = tuple[float, float, float, float]  #: x' = a x + b y + c z + d

#: The axes of a plane that is seen from above, as the drawing is.
FROM_ABOVE: Axes = ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0))


class InsertFrame(Struct, frozen=True):
    """An affine map of space, as its three rows; the third gives the height above the drawing."""

    x: Row
    y: Row
    z: Row

    def height(self, v: Vector) -> float:
        return _value(self.z, v)

    def point(self, v: Vector) -> Point:
        """A point in plan view."""
        return _value(self.x, v), _value(self.y, v)

    def vector(self, v: Vector) -> Point:
        """The image of a direction, seen from above."""
        return _slope(self.x, v), _slope(self.y, v)

    def inside(self, matrix: Any) -> "InsertFrame":
        """The frame of a block that an insert places by `matrix` (ezdxf's, vectors are rows)."""
        ux, uy, uz, origin = (
            (row[0], row[1], row[2]) for row in (matrix.get_row(k) for k in range(4))
        )

        def composed(row: Row) -> Row:
            return _slope(row, ux), _slope(row, uy), _slope(row, uz), _value(row, origin)

        return InsertFrame(composed(self.x), composed(self.y), composed(self.z))

    def plane(self, axes: Axes, elevation: float) -> Matrix:
        """The map of the plane of the first two axes at `elevation` along the third, to mm."""
        ux, uy, uz = axes
        base = (uz[0] * elevation, uz[1] * elevation, uz[2] * elevation)
        x, y = ((_slope(row, ux), _slope(row, uy), _value(row, base)) for row in (self.x, self.y))
        return x, y


def in_world(axes: Axes, point: Vector) -> Vector:
    """A point of an entity's own plane in the coordinates of the drawing."""
    if axes is FROM_ABOVE:
        return point
    (ux, uy, uz), (x, y, z) = axes, point
    return (
        ux[0] * x + uy[0] * y + uz[0] * z,
        ux[1] * x + uy[1] * y + uz[1] * z,
        ux[2] * x + uy[2] * y + uz[2] * z,
    )


def scaled(mm: float) -> InsertFrame:
    """The frame of a drawing whose unit is `mm` long."""
    return InsertFrame((mm, 0.0, 0.0, 0.0), (0.0, mm, 0.0, 0.0), (0.0, 0.0, mm, 0.0))


def _value(row: Row, v: Vector) -> float:
    return row[0] * v[0] + row[1] * v[1] + row[2] * v[2] + row[3]


def _slope(row: Row, v: Vector) -> float:
    return row[0] * v[0] + row[1] * v[1] + row[2] * v[2]


Chain = tuple[Curve, ...]
Heights = list[float]
Vertex = tuple[float, float, float]  #: x, y and the bulge of the line or arc behind it

#: A bulge whose arc rises less than this above its chord is a straight line.
FLAT_BULGE = 1e-7


class EdgeOnError(ValueError):
    """A curve perpendicular to the plane of the drawing."""


def _placed(curves: Iterable[Curve], matrix: Matrix) -> Chain:
    """The curves of an entity's plane in mm, without lines that are seen as points."""
    if matrix == IDENTITY:
        return tuple(curves)
    try:
        placed = [curve.transformed(matrix) for curve in curves]
    except ValueError as error:
        raise EdgeOnError(str(error)) from error
    placed = [round_if_circle(c) if isinstance(c, EllipseArc) else c for c in placed]
    return tuple(c for c in placed if not (isinstance(c, Line) and c.start == c.end))


# --- lines, arcs, ellipses ------------------------------------------------------------------------


def line(frame: InsertFrame, heights: Heights, start: Vector, end: Vector) -> list[Chain]:
    heights += (frame.height(start), frame.height(end))
    a, b = frame.point(start), frame.point(end)
    return [(Line(a, b),)] if a != b else []


def arc(
    frame: InsertFrame,
    heights: Heights,
    centre: Vector,
    radius: float,
    start_deg: float = 0.0,
    end_deg: float = 360.0,
    axes: Axes = FROM_ABOVE,
) -> list[Chain]:
    """An arc counter-clockwise from the start to the end angle in the plane of `axes`, or a
    circle."""
    if not radius > 0.0:
        return []
    sweep_deg = (end_deg - start_deg) % 360.0 or 360.0
    heights.append(frame.height(in_world(axes, centre)))
    own = Arc((centre[0], centre[1]), radius, start_deg, sweep_deg)
    return [_placed((own,), frame.plane(axes, centre[2]))]


def ellipse(
    frame: InsertFrame,
    heights: Heights,
    centre: Vector,
    major: Vector,
    normal: Vector,
    ratio: float,
    start_rad: float,
    end_rad: float,
) -> list[Chain]:
    """An ellipse by half of its major axis; `normal` has length 1 and stands on its plane."""
    (a, b, c), (x, y, z) = normal, major
    minor = ((b * z - c * y) * ratio, (c * x - a * z) * ratio, (a * y - b * x) * ratio)
    # Parameters are eccentric angles in radians, not polar ones.
    sweep = (end_rad - start_rad) % tau
    sweep_deg = degrees(sweep) if 1e-9 <= sweep <= tau - 1e-9 else 360.0
    u, v = frame.vector(major), frame.vector(minor)
    if hypot(*u) == 0.0:
        return []
    heights.append(frame.height(centre))
    curve = ellipse_of(frame.point(centre), u, v, degrees(start_rad), sweep_deg)
    return [(round_if_circle(curve),)]


# --- polylines ------------------------------------------------------------------------------------


def polyline(
    frame: InsertFrame,
    heights: Heights,
    vertices: Sequence[Vertex],
    closed: bool,
    elevation: float,
    axes: Axes = FROM_ABOVE,
) -> list[Chain]:
    """A polyline of lines and arcs, all of it at one elevation over the plane of `axes`."""
    if not vertices:
        return []
    x, y, _ = vertices[0]
    heights.append(frame.height(in_world(axes, (x, y, elevation))))
    if closed:
        vertices = [*vertices, vertices[0]]
    return _chain(vertices, frame.plane(axes, elevation))


def polyline_through(frame: InsertFrame, heights: Heights, points: Sequence[Vector]) -> list[Chain]:
    """Straight lines from point to point, as seen from above."""
    heights += (frame.height(p) for p in points)
    return _chain([(*frame.point(p), 0.0) for p in points], IDENTITY)


def _chain(vertices: Sequence[Vertex], matrix: Matrix) -> list[Chain]:
    """One chain of lines and arcs through vertices (x, y, bulge); none if it has no length."""
    curves: list[Curve] = []
    for (x0, y0, bulge), (x1, y1, _) in pairwise(vertices):
        if (x0, y0) != (x1, y1):
            curves.append(bulge_curve((x0, y0), (x1, y1), bulge))
    placed = _placed(curves, matrix)
    return [placed] if placed else []


def bulge_curve(start: Point, end: Point, bulge: float) -> Line | Arc:
    """The line or arc between two vertices; a positive bulge runs counter-clockwise.

    The bulge is the tangent of a quarter of the sweep: the arc rises bulge * chord / 2 above its
    chord, and the centre lies chord (1 - bulge^2) / (4 bulge) to the left of it.
    Source: Autodesk DXF reference, LWPOLYLINE, group 42.
    """
    dx, dy = end[0] - start[0], end[1] - start[1]
    chord = hypot(dx, dy)
    if abs(bulge) * chord / 2 < FLAT_BULGE:
        return Line(start, end)
    offset = (1.0 - bulge * bulge) / (4.0 * bulge)
    centre = ((start[0] + end[0]) / 2 - offset * dy, (start[1] + end[1]) / 2 + offset * dx)
    radius = chord * (1.0 + bulge * bulge) / (4.0 * abs(bulge))
    start_deg = direction_deg((start[0] - centre[0], start[1] - centre[1]))
    return Arc(centre, radius, start_deg, degrees(4.0 * atan(bulge)))


# --- splines --------------------------------------------------------------------------------------


def spline(
    frame: InsertFrame,
    heights: Heights,
    degree: int,
    points: Sequence[Vector],
    knots: tuple[float, ...],
    weights: tuple[float, ...],
) -> list[Chain]:
    """A spline by its control points; `weights` is empty where all of them weigh the same."""
    heights += (frame.height(p) for p in points)
    control = tuple(frame.point(p) for p in points)
    if all(p == control[0] for p in control):
        return []
    if all(w == weights[0] for w in weights):
        weights = ()
    return _splines(degree, control, knots, weights or None)


def _splines(
    degree: int,
    control: tuple[Point, ...],
    knots: tuple[float, ...],
    weights: tuple[float, ...] | None,
) -> list[Chain]:
    """A spline, or several where a knot inside is there `degree` + 1 times: it tears there."""
    for k in range(degree + 1, len(control)):
        if knots[k] == knots[k + degree] and knots[degree] < knots[k] < knots[len(control)]:
            first = BSpline(degree, control[:k], knots[: k + degree + 1], weights and weights[:k])
            return [(first,), *_splines(degree, control[k:], knots[k:], weights and weights[k:])]
    return [(BSpline(degree, control, knots, weights),)]


#: By kind of entity the function that takes its values, as `plain` gives them.
BY_VALUES: dict[str, Callable[..., list[Chain]]] = {
    "LINE": line,
    "ARC": arc,
    "CIRCLE": arc,
    "ELLIPSE": ellipse,
    "LWPOLYLINE": polyline,
    "SPLINE": spline,
}


def check_bounds(chains: Iterable[Chain]) -> None:
    """Raises ValueError where a coordinate is not a number, or one beyond all drawings."""
    for chain in chains:
        for curve in chain:
            if not is_in_bounds(curve):
                raise ValueError(f"a coordinate that is no number up to {MAX_COORDINATE:g} mm")
