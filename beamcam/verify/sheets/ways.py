"""Curves as polylines in bulk, and questions about many points at once."""

from collections.abc import Sequence
from typing import Any

import numpy as np
import shapely
from numpy.typing import NDArray

from beamcam.geometry.curves import Curve
from beamcam.geometry.polylines import polylines

Floats = NDArray[np.float64]
Counts = NDArray[np.int64]
Shapes = NDArray[Any]


class Ways:
    """Many curves as polylines, each within `tolerance` of its curve, with a tree over them."""

    def __init__(
        self, curves: Sequence[Curve], tolerance: float, shift: tuple[float, float] = (0.0, 0.0)
    ) -> None:
        self.count = len(curves)
        drawn = polylines(curves, tolerance)
        counts = np.diff(drawn.begins)
        self.points: Floats = drawn.points + np.array(shift)
        owner = np.repeat(np.arange(len(curves)), counts)
        self.lines: Shapes = shapely.linestrings(self.points, indices=owner)
        step = np.diff(self.points, axis=0)
        sizes = np.sqrt(step[:, 0] ** 2 + step[:, 1] ** 2)
        sizes[owner[1:] != owner[:-1]] = 0.0  # no way leads from one to the next
        self.reached: Floats = np.concatenate(([0.0], np.cumsum(sizes)))
        self.begins: Floats = self.reached[drawn.begins[:-1]]
        self.lengths: Floats = self.reached[drawn.begins[1:] - 1] - self.begins
        self.tree = shapely.STRtree(self.lines)
        last = np.cumsum(counts) - 1
        self.starts: Floats = self.points[last - counts + 1]
        self.ends: Floats = self.points[last]

    def nearest(self, points: Floats, likely: float = 0.0) -> tuple[Floats, Counts]:
        """Distance to the nearest way, and which one that is, for points (n, 2).

        `likely` is a distance that most have a way within, which is quicker to look for.
        """
        asked = shapely.points(points)
        distances = np.full(len(points), np.inf)
        owners = np.zeros(len(points), dtype=np.int64)
        if likely > 0.0:
            source, which = self.tree.query(asked, "dwithin", distance=likely)
            away = shapely.distance(asked[source], self.lines[which])
            order = np.lexsort((which, away, source))
            source, which, away = source[order], which[order], away[order]
            first = np.ones(len(source), dtype=bool)
            first[1:] = source[1:] != source[:-1]
            distances[source[first]], owners[source[first]] = away[first], which[first]
        rest = np.flatnonzero(np.isinf(distances))
        if len(rest):
            (source, which), away = self.tree.query_nearest(
                asked[rest], return_distance=True, all_matches=False
            )
            distances[rest[source]], owners[rest[source]] = away, which
        return distances, owners

    def within(self, points: Floats, reach: float) -> tuple[Counts, Counts]:
        """Pairs of a point and a way no farther than `reach` from it."""
        source, which = self.tree.query(shapely.points(points), "dwithin", distance=reach)
        return source, which

    def along(self, points: Floats, which: Counts) -> Floats:
        """How far along its way the place nearest to each point lies."""
        places: Floats = shapely.line_locate_point(self.lines[which], shapely.points(points))
        return places


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
    place = ways.begins[owner] + at
    # The chord that a place lies on: the last point before it, never the last of all.
    chord = np.clip(np.searchsorted(ways.reached, place, "right") - 1, 0, len(ways.points) - 2)
    step = ways.points[chord + 1] - ways.points[chord]
    size = ways.reached[chord + 1] - ways.reached[chord]
    size[size == 0.0] = 1.0
    unit = step / size[:, None]
    points = ways.points[chord] + unit * (place - ways.reached[chord])[:, None]
    return points, np.column_stack((-unit[:, 1], unit[:, 0])), owner, at
