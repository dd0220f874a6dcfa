"""The exact curves of each kind of DXF entity, in mm, seen from above.

A function of the table `CURVES` takes an entity, the frame that it stands in and a list that it
adds heights to, and gives chains: tuples of curves that follow one another. It raises ValueError
for numbers that make no curve.
"""

from collections.abc import Callable, Iterable, Sequence
from itertools import pairwise
from math import atan, degrees, hypot, isfinite, tau
from typing import Any

from beamcam.geometry.conics import direction_deg, ellipse_of
from beamcam.geometry.curves import Arc, BSpline, Curve, EllipseArc, Line
from beamcam.geometry.plane import IDENTITY, Matrix, Point
from beamcam.readers.drawing import round_if_circle
from beamcam.readers.dxf.frame import Frame, Vector

Chain = tuple[Curve, ...]
Heights = list[float]

#: A bulge whose arc rises less than this above its chord is a straight line.
FLAT_BULGE = 1e-7


class EdgeOnError(ValueError):
    """A curve that stands upright on the plane of the drawing."""


# Flag of a vertex: a control point of the frame of a fitted polyline, which is not drawn.
SPLINE_FRAME = 16


def _vector(v: Any) -> Vector:
    return v.x, v.y, v.z


# --- the plane of an entity -----------------------------------------------------------------------


def _plane(entity: Any, frame: Frame, elevation: float) -> Matrix:
    """From the entity's own plane (OCS, by its extrusion) to mm.

    An extrusion of (0, 0, -1) shows the plane from behind: x is mirrored.
    """
    extrusion = entity.dxf.get("extrusion")
    if extrusion is None or (extrusion.x == 0.0 and extrusion.y == 0.0 and extrusion.z > 0.0):
        return frame.plane((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0), elevation)
    ocs = entity.ocs()
    return frame.plane(_vector(ocs.ux), _vector(ocs.uy), _vector(ocs.uz), elevation)


def _height(entity: Any, frame: Frame, point: Vector) -> float:
    extrusion = entity.dxf.get("extrusion")
    if extrusion is None or (extrusion.x == 0.0 and extrusion.y == 0.0 and extrusion.z > 0.0):
        return frame.height(point)
    return frame.height(_vector(entity.ocs().to_wcs(point)))


def _placed(curves: Iterable[Curve], matrix: Matrix) -> Chain:
    """The curves of an entity's plane in mm, without lines that are seen as points."""
    if matrix == IDENTITY:
        return tuple(curves)
    return tuple(c for c in (_mapped(c, matrix) for c in curves) if not _is_point(c))


def _mapped(curve: Curve, matrix: Matrix) -> Curve:
    try:
        placed = curve.transformed(matrix)
    except ValueError as error:
        raise EdgeOnError(str(error)) from error
    return round_if_circle(placed) if isinstance(placed, EllipseArc) else placed


def _is_point(curve: Curve) -> bool:
    return isinstance(curve, Line) and curve.start == curve.end


# --- lines, arcs, ellipses ------------------------------------------------------------------------


def line(entity: Any, frame: Frame, heights: Heights) -> list[Chain]:
    start, end = _vector(entity.dxf.start), _vector(entity.dxf.end)
    heights += (frame.height(start), frame.height(end))
    a, b = frame.point(start), frame.point(end)
    return [(Line(a, b),)] if a != b else []


def circle(entity: Any, frame: Frame, heights: Heights) -> list[Chain]:
    return _arc(entity, frame, heights, 0.0, 360.0)


def arc(entity: Any, frame: Frame, heights: Heights) -> list[Chain]:
    # Arcs run counter-clockwise from the start to the end angle, in their own plane.
    start, end = entity.dxf.start_angle, entity.dxf.end_angle
    return _arc(entity, frame, heights, start, (end - start) % 360.0 or 360.0)


def _arc(
    entity: Any, frame: Frame, heights: Heights, start_deg: float, sweep_deg: float
) -> list[Chain]:
    centre, radius = _vector(entity.dxf.center), entity.dxf.radius
    if not radius > 0.0:
        return []
    heights.append(_height(entity, frame, centre))
    own = Arc((centre[0], centre[1]), radius, start_deg, sweep_deg)
    return [_placed((own,), _plane(entity, frame, centre[2]))]


def ellipse(entity: Any, frame: Frame, heights: Heights) -> list[Chain]:
    centre, major = _vector(entity.dxf.center), entity.dxf.major_axis
    minor = entity.dxf.extrusion.normalize().cross(major) * entity.dxf.ratio
    start = entity.dxf.start_param
    # Parameters are eccentric angles in radians, not polar ones.
    sweep = (entity.dxf.end_param - start) % tau
    if sweep < 1e-9 or sweep > tau - 1e-9:
        sweep = tau
    u, v = frame.vector(_vector(major)), frame.vector(_vector(minor))
    if hypot(*u) == 0.0:
        return []
    heights.append(frame.height(centre))
    full = sweep == tau
    curve = ellipse_of(frame.point(centre), u, v, degrees(start), 360.0 if full else degrees(sweep))
    return [(round_if_circle(curve),)]


# --- polylines ------------------------------------------------------------------------------------


def lwpolyline(entity: Any, frame: Frame, heights: Heights) -> list[Chain]:
    vertices = [(float(x), float(y), float(b)) for x, y, b in entity.get_points("xyb")]
    elevation = entity.dxf.get("elevation", 0.0)
    return _flat_polyline(entity, vertices, bool(entity.closed), elevation, frame, heights)


def polyline(entity: Any, frame: Frame, heights: Heights) -> list[Chain]:
    drawn = [v.dxf for v in entity.vertices if not v.dxf.flags & SPLINE_FRAME]
    closed = bool(entity.is_closed)
    if entity.is_2d_polyline:
        vertices = [(v.location.x, v.location.y, v.get("bulge", 0.0)) for v in drawn]
        elevation = entity.dxf.get("elevation")
        height = elevation.z if elevation is not None else 0.0
        if elevation is None and drawn:
            height = drawn[0].location.z
        return _flat_polyline(entity, vertices, closed, height, frame, heights)
    points = [_vector(v.location) for v in drawn]
    heights += (frame.height(p) for p in points)
    flat = [frame.point(p) for p in points]
    if closed and flat:
        flat.append(flat[0])
    return _chain([(x, y, 0.0) for x, y in flat], IDENTITY)


def _flat_polyline(
    entity: Any,
    vertices: list[tuple[float, float, float]],
    closed: bool,
    elevation: float,
    frame: Frame,
    heights: Heights,
) -> list[Chain]:
    if not vertices:
        return []
    x, y, _ = vertices[0]
    heights.append(_height(entity, frame, (x, y, elevation)))
    if closed:
        vertices = [*vertices, vertices[0]]
    return _chain(vertices, _plane(entity, frame, elevation))


def _chain(vertices: Sequence[tuple[float, float, float]], matrix: Matrix) -> list[Chain]:
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


def spline(entity: Any, frame: Frame, heights: Heights) -> list[Chain]:
    tool = entity.construction_tool()
    points = [_vector(p) for p in tool.control_points]
    heights += (frame.height(p) for p in points)
    control = tuple(frame.point(p) for p in points)
    if all(p == control[0] for p in control):
        return []
    weights = tuple(float(w) for w in tool.weights()) or None
    if weights is not None and all(w == weights[0] for w in weights):
        weights = None
    knots = tuple(float(k) for k in tool.knots())
    return _splines(tool.order - 1, control, knots, weights)


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
            rest = _splines(degree, control[k:], knots[k:], weights and weights[k:])
            return [(first,), *rest]
    return [(BSpline(degree, control, knots, weights),)]


def by_fit_points(entity: Any) -> int:
    """Count of fit points of a spline that the file gives by nothing else; 0 for other curves."""
    if entity.dxftype() != "SPLINE" or entity.control_point_count():
        return 0
    return int(entity.fit_point_count())


def through_fit_points(entity: Any, frame: Frame, heights: Heights) -> list[Chain]:
    """The polyline through the fit points of a spline: the nodes of a polynomial that is asked
    for, where drawing programs show a cubic spline."""
    points: list[Vector] = [(float(x), float(y), float(z)) for x, y, z in entity.fit_points]
    heights += (frame.height(p) for p in points)
    return _chain([(*frame.point(p), 0.0) for p in points], IDENTITY)


CURVES: dict[str, Callable[[Any, Frame, Heights], list[Chain]]] = {
    "LINE": line,
    "ARC": arc,
    "CIRCLE": circle,
    "ELLIPSE": ellipse,
    "LWPOLYLINE": lwpolyline,
    "POLYLINE": polyline,
    "SPLINE": spline,
}


def is_curve(entity: Any) -> bool:
    """Whether an entity is one that `CURVES` reads; a mesh is called POLYLINE too."""
    kind = entity.dxftype()
    if kind == "POLYLINE":
        return bool(entity.is_2d_polyline or entity.is_3d_polyline)
    return kind in CURVES


def check_finite(chains: Iterable[Chain]) -> None:
    """Raises ValueError where a coordinate is no finite number."""
    for chain in chains:
        for curve in chain:
            points = curve.control if isinstance(curve, BSpline) else (curve.start, curve.end)
            if not all(isfinite(v) for p in points for v in p):
                raise ValueError("a coordinate that is no finite number")
