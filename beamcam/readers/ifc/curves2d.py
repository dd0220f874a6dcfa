"""The curves of profiles and of cuts' outlines, exact: lines and arcs in mm."""

import itertools
from math import atan2, degrees, dist, hypot, pi
from typing import Any

from beamcam.geometry.arc_fitting import fit_chains
from beamcam.geometry.conics import arc_by_points
from beamcam.geometry.curves import Arc, BSpline, Curve, Line, Point
from beamcam.geometry.plane import Box
from beamcam.readers.ifc.entities import Entity, Model, Unreadable
from beamcam.readers.ifc.records import Typed

Chain = tuple[Curve, ...]
SPLINE_FIT = 0.005  #: mm that the arcs which stand for a spline may lie off it
SAME_POINT = 1e-4  #: mm between the end of a curve and the start of the next


def chain_of(model: Model, entity: Entity) -> Chain:
    """A closed chain of lines and arcs of an IFC curve. Raises Unreadable for other curves."""
    chain = tuple(c for c in _curve(model, entity) if c.length > SAME_POINT)
    if not chain:
        raise Unreadable(f"an empty {entity.is_a()}")
    first, last = chain[0].start, chain[-1].end
    if dist(first, last) > SAME_POINT and len(chain) > 1:
        chain = (*chain, Line(last, first))
    return chain


def box_around(chain: Chain) -> Box:
    """The bounding box of a chain that is not empty."""
    x0, y0, x1, y1 = zip(*(curve.bbox for curve in chain), strict=True)
    return min(x0), min(y0), max(x1), max(y1)


def points_chain(points: list[Point]) -> Chain:
    """The polygon of `points`, closed."""
    return tuple(_polyline([*points, points[0]]))


def _curve(model: Model, entity: Entity) -> list[Curve]:
    """The curves of an entity."""
    kind, kinds = entity.type.name, entity.type.kinds
    if kind == "IfcPolyline":
        mm = model.mm
        return _polyline([(c[0] * mm, c[1] * mm) for c in entity.values[0]])
    if "IfcCompositeCurve" in kinds:
        chain: list[Curve] = []
        for segment in entity.values[0]:
            if segment.type.name != "IfcCompositeCurveSegment":
                raise Unreadable(f"a curve segment {segment.is_a()}")
            _, forward, parent, *_ = segment.values
            pieces = _curve(model, parent)
            chain += pieces if forward else [c.reversed() for c in reversed(pieces)]
        return chain
    if kind == "IfcIndexedPolyCurve":
        return _indexed(model, entity)
    if kind == "IfcTrimmedCurve":
        return [_trimmed(model, entity)]
    if kind == "IfcCircle":
        frame = model.axes(entity.Position)
        start, radius = degrees(atan2(frame.x[1], frame.x[0])), entity.Radius * model.mm
        if not radius > 0.0:
            raise Unreadable(f"a circle of radius {radius:g}")
        return [Arc((frame.o[0], frame.o[1]), radius, start, 360.0)]
    if "IfcBSplineCurve" in kinds:
        (arcs,) = fit_chains([[spline_of(model, entity)]], SPLINE_FIT)
        return [*arcs]
    raise Unreadable(f"an outline by {kind}")


def spline_of(model: Model, entity: Entity) -> BSpline:
    """An IfcBSplineCurve in a plane. Raises Unreadable for one that is not well formed."""
    degree, listed, *_ = entity.values
    control = tuple((c[0] * model.mm, c[1] * model.mm) for c in listed)
    if entity.is_a("IfcBSplineCurveWithKnots"):
        rows = zip(entity.Knots, entity.KnotMultiplicities, strict=True)
        knots = tuple(float(knot) for knot, often in rows for _ in range(often))
    else:  # Bezier curves, one behind the other
        pieces = (len(control) - 1) // degree
        inner = (float(k) for k in range(1, pieces) for _ in range(degree))
        knots = (*(degree + 1) * (0.0,), *inner, *(degree + 1) * (float(pieces),))
    weights = entity.WeightsData if "WeightsData" in entity.type.places else None
    try:
        return BSpline(degree, control, knots, weights and tuple(map(float, weights)))
    except ValueError as fault:
        raise Unreadable(f"an outline by a spline that is not well formed ({fault})") from fault


def _polyline(points: list[Point]) -> list[Curve]:
    return [Line(a, b) for a, b in itertools.pairwise(points) if dist(a, b) > SAME_POINT]


def _indexed(model: Model, entity: Entity) -> list[Curve]:
    points = [(c[0] * model.mm, c[1] * model.mm) for c in entity.Points.CoordList]
    if entity.Segments is None:
        return _polyline(points)
    chain: list[Curve] = []
    for segment in entity.Segments:
        run = [points[i - 1] for i in segment.value]
        if segment.is_a("IfcArcIndex"):
            chain.append(arc_by_points(run[0], run[1], run[2]) or Line(run[0], run[2]))
        else:
            chain += _polyline(run)
    return chain


def _trimmed(model: Model, entity: Entity) -> Curve:
    basis = entity.values[0]
    ends = [_trim(model, entity, trim) for trim in (entity.values[1], entity.values[2])]
    if basis.is_a("IfcLine"):
        x, y, _ = model.point(basis.Pnt)
        dx, dy = basis.Dir.Orientation[:2]
        by = basis.Dir.Magnitude * model.mm / hypot(dx, dy)
        start, end = (
            (x + dx * by * one, y + dy * by * one) if isinstance(one, float) else one
            for one in ends
        )
        return Line(start, end)
    if not basis.is_a("IfcCircle"):
        raise Unreadable(f"an outline by a trimmed {basis.is_a()}")
    frame = model.axes(basis.values[0])
    (ox, oy, _), (ax, ay, _), (bx, by, _) = frame.o, frame.x, frame.y
    start_rad, end_rad = (
        one * model.radians
        if isinstance(one, float)
        else atan2((one[0] - ox) * bx + (one[1] - oy) * by, (one[0] - ox) * ax + (one[1] - oy) * ay)
        for one in ends
    )
    way = 1 if entity.values[3] else -1
    turn = way * (end_rad - start_rad) % (2 * pi)
    if turn < 1e-9:
        turn = 2 * pi
    start_deg = degrees(start_rad + atan2(ay, ax))
    return Arc((ox, oy), basis.values[1] * model.mm, start_deg, degrees(way * turn))


def _trim(model: Model, entity: Entity, trim: tuple[Any, ...]) -> Point | float:
    """Trimming point of a curve: a parameter, or a point if the file has one."""
    points = [model.point(t)[:2] for t in trim if isinstance(t, tuple)]
    values = [float(t.value) for t in trim if isinstance(t, Typed)]
    if values and (entity.MasterRepresentation != "CARTESIAN" or not points):
        return values[0]
    if not points:
        raise Unreadable("a trimmed curve without trims")
    return points[0]
