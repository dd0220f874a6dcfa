"""Many points of a curve at once, as float64 arrays."""

import itertools

import numpy as np

from beamcam.geometry.array_types import Floats
from beamcam.geometry.curves import Arc, Bezier, BSpline, Curve, EllipseArc, Line, NewtonCurve


def points_at(curve: Curve, t: Floats) -> Floats:
    """The points at parameters `t` of shape (n,): an array of shape (n, 2).

    Where `t` is 0 or 1 the ends come back exactly.
    """
    t = np.asarray(t, dtype=np.float64)
    match curve:
        case Line():
            points = _line_points(curve, t)
        case Arc():
            angle = np.radians(curve.start_deg + t * curve.sweep_deg)
            circle = np.column_stack((np.cos(angle), np.sin(angle)))
            points = np.asarray(curve.centre) + curve.radius * circle
        case EllipseArc():
            angle = np.radians(curve.start_deg + t * curve.sweep_deg)
            (ax, ay), r = curve.axis, curve.ratio
            c, s = np.cos(angle), r * np.sin(angle)
            points = np.asarray(curve.centre) + np.column_stack((c * ax - s * ay, c * ay + s * ax))
        case Bezier():
            points = bezier_points(curve, t)
        case BSpline():
            points = _spline_points(curve, t)
        case NewtonCurve():
            points = bezier_points(curve.as_bezier(), t)
    points[t == 0.0] = curve.start
    points[t == 1.0] = curve.end
    return points


def _line_points(line: Line, t: Floats) -> Floats:
    start = np.asarray(line.start)
    points: Floats = start + t[:, None] * (np.asarray(line.end) - start)
    return points


def bezier_points(curve: Bezier, t: Floats) -> Floats:
    """Points of a Bezier curve by de Casteljau, array (n, 2)."""
    rows = [np.asarray(p)[:, None] for p in curve.homogeneous]
    # One row for each coordinate keeps the arrays contiguous.
    while len(rows) > 1:
        rows = [a + t * (b - a) for a, b in itertools.pairwise(rows)]
    x, y, w = rows[0]
    return np.column_stack((x / w, y / w))


def _spline_points(spline: BSpline, t: Floats) -> Floats:
    pieces, breaks = spline.pieces(), np.asarray(spline.breaks())
    which = np.clip(np.searchsorted(breaks, t, side="right") - 1, 0, len(pieces) - 1)
    points = np.empty((len(t), 2))
    for k, piece in enumerate(pieces):
        mine = which == k
        local = (t[mine] - breaks[k]) / (breaks[k + 1] - breaks[k])
        points[mine] = bezier_points(piece, local)
    return points
