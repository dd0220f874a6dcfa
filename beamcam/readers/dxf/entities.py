"""The numbers of an entity that ezdxf holds, and the curves that they make.

A function of the table `CURVES` takes the frame that an entity stands in, a list that it adds
heights to, and the entity, and gives chains, as the functions of `curves` do.
"""

from collections.abc import Callable
from typing import Any

from beamcam.readers.dxf import curves
from beamcam.readers.dxf.curves import Chain, Heights
from beamcam.readers.dxf.frame import FROM_ABOVE, Axes, Frame, Vector

# Flag of a vertex: a control point of the frame of a fitted polyline, which is not drawn.
SPLINE_FRAME = 16


def _vector(v: Any) -> Vector:
    return v.x, v.y, v.z


def _axes(entity: Any) -> Axes:
    """The axes of the entity's own plane (OCS, by its extrusion).

    An extrusion of (0, 0, -1) shows the plane from behind: x is mirrored.
    """
    extrusion = entity.dxf.get("extrusion")
    if extrusion is None or (extrusion.x == 0.0 and extrusion.y == 0.0 and extrusion.z > 0.0):
        return FROM_ABOVE
    ocs = entity.ocs()
    return _vector(ocs.ux), _vector(ocs.uy), _vector(ocs.uz)


def _line(frame: Frame, heights: Heights, entity: Any) -> list[Chain]:
    return curves.line(frame, heights, _vector(entity.dxf.start), _vector(entity.dxf.end))


def _circle(frame: Frame, heights: Heights, entity: Any) -> list[Chain]:
    centre, radius = _vector(entity.dxf.center), entity.dxf.radius
    return curves.arc(frame, heights, centre, radius, axes=_axes(entity))


def _arc(frame: Frame, heights: Heights, entity: Any) -> list[Chain]:
    centre, radius = _vector(entity.dxf.center), entity.dxf.radius
    start, end = entity.dxf.start_angle, entity.dxf.end_angle
    return curves.arc(frame, heights, centre, radius, start, end, _axes(entity))


def _ellipse(frame: Frame, heights: Heights, entity: Any) -> list[Chain]:
    dxf = entity.dxf
    normal = _vector(dxf.extrusion.normalize())
    axis = _vector(dxf.major_axis)
    ends = dxf.start_param, dxf.end_param
    return curves.ellipse(frame, heights, _vector(dxf.center), axis, normal, dxf.ratio, *ends)


def _lwpolyline(frame: Frame, heights: Heights, entity: Any) -> list[Chain]:
    vertices = [(float(x), float(y), float(b)) for x, y, b in entity.get_points("xyb")]
    elevation = entity.dxf.get("elevation", 0.0)
    return curves.polyline(frame, heights, vertices, bool(entity.closed), elevation, _axes(entity))


def _polyline(frame: Frame, heights: Heights, entity: Any) -> list[Chain]:
    drawn = [v.dxf for v in entity.vertices if not v.dxf.flags & SPLINE_FRAME]
    closed = bool(entity.is_closed)
    if entity.is_2d_polyline:
        vertices = [(v.location.x, v.location.y, v.get("bulge", 0.0)) for v in drawn]
        elevation = entity.dxf.get("elevation")
        height = elevation.z if elevation is not None else 0.0
        if elevation is None and drawn:
            height = drawn[0].location.z
        return curves.polyline(frame, heights, vertices, closed, height, _axes(entity))
    points = [_vector(v.location) for v in drawn]
    if closed and points:
        points.append(points[0])
    return curves.polyline_through(frame, heights, points)


def _spline(frame: Frame, heights: Heights, entity: Any) -> list[Chain]:
    tool = entity.construction_tool()
    points = [_vector(p) for p in tool.control_points]
    knots = tuple(float(k) for k in tool.knots())
    weights = tuple(float(w) for w in tool.weights())
    return curves.spline(frame, heights, tool.order - 1, points, knots, weights)


def by_fit_points(entity: Any) -> int:
    """Count of fit points of a spline that the file gives by nothing else; 0 for other curves."""
    if entity.dxftype() != "SPLINE" or entity.control_point_count():
        return 0
    return int(entity.fit_point_count())


def through_fit_points(frame: Frame, heights: Heights, entity: Any) -> list[Chain]:
    """The polyline through the fit points of a spline: the nodes of a polynomial that is asked
    for, where drawing programs show a cubic spline."""
    points = [(float(x), float(y), float(z)) for x, y, z in entity.fit_points]
    return curves.polyline_through(frame, heights, points)


CURVES: dict[str, Callable[[Frame, Heights, Any], list[Chain]]] = {
    "LINE": _line,
    "ARC": _arc,
    "CIRCLE": _circle,
    "ELLIPSE": _ellipse,
    "LWPOLYLINE": _lwpolyline,
    "POLYLINE": _polyline,
    "SPLINE": _spline,
}


def is_curve(entity: Any) -> bool:
    """Whether an entity is one that `CURVES` reads; a mesh is called POLYLINE too."""
    kind = entity.dxftype()
    if kind == "POLYLINE":
        return bool(entity.is_2d_polyline or entity.is_3d_polyline)
    return kind in CURVES
