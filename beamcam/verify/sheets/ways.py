"""Curves as polylines in bulk, and questions about many points at once."""

from collections.abc import Sequence
from math import ceil, radians, sqrt
from typing import Any

import numpy as np
import shapely
from numpy.typing import NDArray

from beamcam.geometry.curves import Arc, BSpline, Curve, EllipseArc, Line, bezier_pieces
from beamcam.geometry.sampling import points_at

Floats = NDArray[np.float64]
Counts = NDArray[np.int64]
Shapes = NDArray[Any]


class Ways:
    """Many curves as polylines, each within `tolerance` of its curve, with a tree over them."""

    def __init__(
        self, curves: Sequence[Curve], tolerance: float, shift: tuple[float, float] = (0.0, 0.0)
    ) -> None:
        self.count = len(curves)
        pieces = _flattened(curves, tolerance)
        counts = np.array([len(p) for p in pieces])
        self.points: Floats = np.concatenate(pieces) + np.array(shift)
        owner = np.repeat(np.arange(len(pieces)), counts)
        self.lines: Shapes = shapely.linestrings(self.points, indices=owner)
        self.lengths: Floats = shapely.length(self.lines)
        self.begins: Floats = np.concatenate(([0.0], np.cumsum(self.lengths)))[:-1]
        self.tree = shapely.STRtree(self.lines)
        last = np.cumsum(counts) - 1
        self.starts: Floats = self.points[last - counts + 1]
        self.ends: Floats = self.points[last]

    def nearest(self, points: Floats) -> tuple[Floats, Counts]:
        """Distance to the nearest way, and which one that is, for points (n, 2)."""
        asked = shapely.points(points)
        (source, which), away = self.tree.query_nearest(
            asked, return_distance=True, all_matches=False
        )
        distances, owners = np.empty(len(points)), np.empty(len(points), dtype=np.int64)
        distances[source], owners[source] = away, which
        return distances, owners

    def within(self, points: Floats, reach: float) -> tuple[Counts, Counts]:
        """Pairs of a point and a way no farther than `reach` from it."""
        source, which = self.tree.query(shapely.points(points), "dwithin", distance=reach)
        return source, which

    def along(self, points: Floats, which: Counts) -> Floats:
        """How far along its way the place nearest to each point lies."""
        places: Floats = shapely.line_locate_point(self.lines[which], shapely.points(points))
        return places


def _flattened(curves: Sequence[Curve], tolerance: float) -> list[Floats]:
    found: list[Floats] = []
    for curve in curves:
        if isinstance(curve, Line):
            found.append(np.array((curve.start, curve.end)))
        elif isinstance(curve, Arc):
            step = min(sqrt(8 * tolerance / curve.radius), 0.5)
            count = max(2, ceil(abs(radians(curve.sweep_deg)) / step))
            found.append(points_at(curve, np.linspace(0.0, 1.0, count + 1)))
        else:
            found.append(_free(curve, tolerance))
    return found


def _free(curve: Curve, tolerance: float) -> Floats:
    """Points of a free curve, twice as many until their chords change no more."""
    count = 8
    if isinstance(curve, BSpline):
        count = 8 * len(bezier_pieces(curve))
    if isinstance(curve, EllipseArc):
        count = max(8, ceil(abs(curve.sweep_deg) / 10.0))
    while True:
        points = points_at(curve, np.linspace(0.0, 1.0, 2 * count + 1))
        sag = points[1::2] - (points[:-1:2] + points[2::2]) / 2
        if np.max(np.hypot(sag[:, 0], sag[:, 1])) <= tolerance or count >= 8192:
            return points
        count *= 2


def samples(ways: Ways, spacing: float) -> tuple[Floats, Floats, Counts, Floats]:
    """Points inside each way, three or more, at most `spacing` apart.

    Also the left normal there (n, 2), the way of each, and how far along it the point lies. Ends
    are left out, since ways meet there.
    """
    count = np.maximum(3, np.ceil(ways.lengths / spacing)).astype(np.int64)
    owner = np.repeat(np.arange(ways.count), count)
    first = np.cumsum(count) - count
    share = (np.arange(len(owner)) - first[owner] + 0.5) / count[owner]
    at = share * ways.lengths[owner]
    step = np.minimum(1e-4 * np.maximum(ways.lengths[owner], 1e-3), 1e-3)
    lines = ways.lines[owner]
    points = shapely.get_coordinates(shapely.line_interpolate_point(lines, at))
    ahead = shapely.get_coordinates(shapely.line_interpolate_point(lines, at + step))
    behind = shapely.get_coordinates(shapely.line_interpolate_point(lines, at - step))
    tangent = ahead - behind
    size = np.hypot(tangent[:, 0], tangent[:, 1])
    size[size == 0.0] = 1.0
    normal = np.column_stack((-tangent[:, 1] / size, tangent[:, 0] / size))
    return points, normal, owner, at
