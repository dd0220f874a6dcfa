"""The free curves of a drawing as cubics, all of them together."""

from collections.abc import Sequence
from itertools import chain

import numpy as np

from beamcam.geometry.array_types import Counts, Floats
from beamcam.geometry.arrays import by_kind, rows
from beamcam.geometry.curves import Bezier, BSpline, Curve, NewtonCurve
from beamcam.geometry.plane import Point
from beamcam.geometry.splines import spline_cubics


def cubics_of(curves: Sequence[Curve]) -> tuple[Floats, Counts, list[int]]:
    """The control points (n, 4, 2) of all cubics without weights, and the curve of each (n,).

    They come in the order of the curves, those of a spline from its start to its end, and are the
    same numbers as `bezier_pieces` gives. The third value names the curves that are not cubics.
    """
    kinds = by_kind(curves)
    plain: list[int] = []
    splines: list[int] = []
    others: list[int] = []
    for kind, which in kinds.items():
        if kind is Bezier:
            for k in which:
                curve = curves[k]
                assert isinstance(curve, Bezier)
                is_cubic = curve.weights is None and len(curve.points) == 4
                (plain if is_cubic else others).append(k)
        elif kind is BSpline:
            for k in which:
                curve = curves[k]
                assert isinstance(curve, BSpline)
                is_cubic = curve.weights is None and curve.degree == 3
                (splines if is_cubic else others).append(k)
        elif kind is NewtonCurve:
            for k in which:
                curve = curves[k]
                assert isinstance(curve, NewtonCurve)
                piece = curve.as_bezier()
                (plain if piece.weights is None and piece.degree == 3 else others).append(k)
        else:
            others += which
    points = chain.from_iterable(_cubic_points(curves[k]) for k in plain)
    control, owner = spline_cubics([curves[k] for k in splines])  # type: ignore[misc]
    control = np.concatenate((rows(points, 8).reshape(-1, 4, 2), control))
    owners = np.concatenate((plain, np.array(splines, dtype=np.int64)[owner])).astype(np.int64)
    order = np.argsort(owners, kind="stable")
    return control[order], owners[order], sorted(others)


def _cubic_points(curve: Curve) -> Sequence[Point]:
    piece = curve.as_bezier() if isinstance(curve, NewtonCurve) else curve
    assert isinstance(piece, Bezier)
    return piece.points
