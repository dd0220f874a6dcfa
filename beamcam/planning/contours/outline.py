"""The polygon of a contour, for questions that need no exact curve: inside, near, crossing."""

from collections.abc import Sequence
from dataclasses import dataclass
from math import acos, ceil, pi, radians, sqrt
from typing import TYPE_CHECKING

from beamcam.geometry.curves import Arc, Curve, EllipseArc, Line, bezier_pieces, unit_vector
from beamcam.geometry.plane import Point

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray


@dataclass(frozen=True, slots=True)
class Outline:
    """Points of a chain, the first not repeated at the end of a closed one."""

    points: "NDArray[np.float64]"  #: (n, 2)
    at: tuple[int, ...]  #: index of each curve's first point


def outline(curves: Sequence[Curve], tolerance: float) -> Outline:
    """Points along curves whose chords stay within `tolerance` of them."""
    import numpy as np

    points: list[Point] = []
    at: list[int] = []
    for curve in curves:
        at.append(len(points))
        if isinstance(curve, Line):
            points.append(curve.start)
        else:
            points += _points(curve, tolerance)
    end = curves[-1].end
    if points[0] != end and (
        abs(points[0][0] - end[0]) > 1e-9 or abs(points[0][1] - end[1]) > 1e-9
    ):
        points.append(end)
    while len(points) < 3:  # a ring of two half circles flattened to one chord has no area
        points.append(points[-1])
    return Outline(np.array(points), tuple(at))


def _points(curve: Curve, tolerance: float) -> list[Point]:
    """Points from the start of a curve on, without its end."""
    if isinstance(curve, Arc):
        step = min(2 * acos(max(-1.0, 1 - tolerance / curve.radius)), pi / 4)
        count = max(1, ceil(abs(radians(curve.sweep_deg)) / step))
        (x, y), r = curve.centre, curve.radius
        turn = curve.sweep_deg / count
        around = (unit_vector(curve.start_deg + k * turn) for k in range(count))
        return [(x + r * c, y + r * s) for c, s in around]
    if isinstance(curve, Line):
        return [curve.start]
    if isinstance(curve, EllipseArc):
        # |f''| is at most the major half axis by sweep squared, and a chord errs by h^2 / 8 of it.
        count = max(1, ceil(abs(radians(curve.sweep_deg)) * sqrt(curve.major / tolerance / 8)))
        return _sampled(curve, max(count, ceil(abs(curve.sweep_deg) / 45.0)))
    found: list[Point] = []
    for piece in bezier_pieces(curve):
        # Wang's bound on the number of chords of a Bezier curve of degree d.
        p, d = piece.points, piece.degree
        bend = max(
            (abs(a[0] - 2 * b[0] + c[0]) + abs(a[1] - 2 * b[1] + c[1]))
            for a, b, c in zip(p, p[1:], p[2:], strict=False)
        ) if d > 1 else 0.0  # fmt: skip
        found += _sampled(piece, max(1, ceil(sqrt(d * (d - 1) / 8 * bend / tolerance))))
    return found


def _sampled(curve: Curve, count: int) -> list[Point]:
    import numpy as np

    from beamcam.geometry.sampling import points_at

    points = points_at(curve, np.arange(count) / count)
    return [(x, y) for x, y in points.tolist()]
