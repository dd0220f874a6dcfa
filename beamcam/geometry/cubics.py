"""The free curves of a drawing as cubics, all of them together."""

from collections.abc import Sequence
from itertools import chain

import numpy as np

from beamcam.geometry.array_types import Counts, Floats
from beamcam.geometry.arrays import rows
from beamcam.geometry.curves import Bezier, BSpline, Curve, NewtonCurve
from beamcam.geometry.plane import Point
from beamcam.geometry.splines import spline_cubics


def cubics_of(curves: Sequence[Curve]) -> tuple[Floats, Counts, list[int]]:
    """The control points (n, 4, 2) of all cubics without weights, and the curve of each (n,).

    They come in the order of the curves, those of a spline from its start to its end, and are the
    same numbers as `bezier_pieces` gives. The third value names the curves that are not cubics.
    """
    plain: list[int] = []
    splines: list[int] = []
    others: list[int] = []
    points: list[Sequence[Point]] = []
    for k, curve in enumerate(curves):
        piece = curve.as_bezier() if isinstance(curve, NewtonCurve) else curve
        if not isinstance(piece, Bezier | BSpline) or piece.weights or piece.degree != 3:
            others.append(k)
        elif isinstance(piece, BSpline):
            splines.append(k)
        else:
            plain.append(k)
            points.append(piece.points)
    control, owner = spline_cubics([curves[k] for k in splines])  # type: ignore[misc]
    control = np.concatenate((rows(chain.from_iterable(points), 8).reshape(-1, 4, 2), control))
    owners = np.concatenate((plain, np.array(splines, dtype=np.int64)[owner])).astype(np.int64)
    order = np.argsort(owners, kind="stable")
    return control[order], owners[order], others
