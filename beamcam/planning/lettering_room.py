"""Room for texts on a face: how clear a box is of edges, holes and other texts, or would be.

The search goes by squares over the face, the nearest to its own place first: a square is given
up where the box at its middle lies deeper in obstacles than the corners of the square are away.
"""

from collections.abc import Callable, Iterator, Sequence
from heapq import heappop, heappush
from itertools import pairwise, product
from math import acos, ceil, dist, hypot, inf, pi
from typing import TYPE_CHECKING

from msgspec import Struct

from beamcam.geometry.curves import Curve
from beamcam.geometry.plane import Box, Point

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray
    from shapely import Polygon, STRtree

    from beamcam.geometry.array_types import Floats

STEP = 0.1  #: mm that places and heights of moved texts are rounded to
FINEST = 0.25  #: mm, half the side of the smallest square that is looked at
MOST_SQUARES = 10_000  #: of a face that are looked at for all of its texts
SAGITTA = 0.005  #: mm by which chords of an edge are off it at most
WIDEST = 20_000.0  #: mm of a face or radius of a hole; of larger ones chords are longer
RUN = 16  #: chords that stand together in the index of edges
BETWEEN = 0.1  #: mm from the box of one text to that of another, both where the part has them
BESIDE = 1.0  #: mm from other texts to one that is moved, if so much is kept from edges
TEXTS_OF_A_SQUARE = 256  #: texts beside which a square takes as much effort again
SEEN = 1 / 32  #: of the effort for a square is that for one which was looked at before
CIRCLES = 4  #: in a box on each side of its middle, that show how deep it lies


class Exhausted(Exception):
    """All squares of a face that may be looked at have been."""


class Placed(Struct, frozen=True):
    """The box around a text: its middle, the directions of its sides and half their lengths."""

    middle: Point
    u: Point
    v: Point
    half_u: float
    half_v: float

    def at(self, along_u: float, along_v: float) -> Point:
        """A point of it, from its middle along its sides."""
        (x, y), (a, b), (c, d) = self.middle, self.u, self.v
        return x + along_u * a + along_v * c, y + along_u * b + along_v * d

    @property
    def corners(self) -> tuple[Point, ...]:
        signs = ((-1, -1), (1, -1), (1, 1), (-1, 1))
        return tuple(self.at(s * self.half_u, t * self.half_v) for s, t in signs)

    @property
    def circles(self) -> Iterator[tuple[Point, float]]:
        """Circles in it: along its middle line, and its corners."""
        yield from ((corner, 0.0) for corner in self.corners)
        radius = min(self.half_u, self.half_v)
        for k in range(-CIRCLES, CIRCLES + 1):
            share = k / CIRCLES
            yield self.at(share * (self.half_u - radius), share * (self.half_v - radius)), radius


class Room:
    """Obstacles on a face, in its coordinates: where a text may be placed.

    All edges are taken before the first text is placed.
    """

    def __init__(self, box: Box) -> None:
        self.box = box  #: that holds every place
        self.squares = float(MOST_SQUARES)  #: that may still be looked at
        self._seen: dict[object, dict[Point, float]] = {}  #: clearance at middles of squares
        #: Of boxes by their shape at height 1: the least height for which there is no place. Texts
        #: are only added, so that none comes free later.
        self.without_place: dict[object, float] = {}
        self._extent = max(box[2] - box[0], box[3] - box[1])
        self._chains: list[Floats] = []
        self._outline: Sequence[Point] = ()
        self._voids: list[Polygon] = []
        self._texts: Floats | None = None  #: a column for each: middle, sides, half lengths
        self._index: _Edges | None = None

    def add(self, curves: Sequence[Curve]) -> None:
        """Take the curves of an edge or a hole; they close."""
        from beamcam.geometry.polylines import polylines

        drawn = polylines(curves, SAGITTA * max(1.0, self._extent / WIDEST))
        self._chains += (drawn.points[a:b] for a, b in pairwise(drawn.begins.tolist()))

    def bound(self, corners: Sequence[Point]) -> None:
        """Take the outline of the steel; holes are taken from what is inside."""
        self._outline = corners

    def remove(self, corners: Sequence[Point]) -> None:
        """Take what is inside of some corners from the steel."""
        import shapely

        self._voids.append(shapely.Polygon(corners))

    def drill(self, centre: Point, radius: float) -> None:
        """Take a round hole from the steel."""
        import shapely

        radius = max(radius, SAGITTA)
        segments = ceil(pi / 4 / acos(max(0.5, 1.0 - SAGITTA / min(radius, WIDEST))))
        self._voids.append(shapely.Point(centre).buffer(radius, quad_segs=segments))

    def take(self, box: Placed) -> None:
        """Take a text that is placed as an obstacle for later ones."""
        import numpy as np

        row = np.array([*box.middle, *box.u, *box.v, box.half_u, box.half_v])[:, None]
        self._texts = row if self._texts is None else np.hstack((self._texts, row))

    def clearance(self, box: Placed, distance: float, gap: float = BETWEEN) -> float:
        """How clear a box is: at least `distance` where it is so far from edges, `gap` from texts.

        Less where it is not, and then changing by no more than the box is moved, so that it bounds
        the places around.
        """
        clear = self._edges.clearance(box) if self._chains or self._outline else inf
        if self._texts is None:
            return clear
        import numpy as np

        # The least gap to another text; where they overlap, how deep (below 0): the greatest gap
        # between the shadows of two boxes on the directions of their sides (separating axes).
        x, y, ux, uy, vx, vy, half_u, half_v = self._texts
        dx, dy = x - box.middle[0], y - box.middle[1]
        apart = np.full_like(x, -inf)
        own = ((np.full_like(x, nx), np.full_like(x, ny)) for nx, ny in (box.u, box.v))
        for nx, ny in (*own, (ux, uy), (vx, vy)):
            theirs = half_u * abs(ux * nx + uy * ny) + half_v * abs(vx * nx + vy * ny)
            ours = box.half_u * abs(box.u[0] * nx + box.u[1] * ny)
            ours = ours + box.half_v * abs(box.v[0] * nx + box.v[1] * ny)
            apart = np.maximum(apart, abs(dx * nx + dy * ny) - theirs - ours)
        return min(clear, float(apart.min()) - gap + distance)

    @property
    def _edges(self) -> "_Edges":
        if self._index is not None:
            return self._index
        import numpy as np
        import shapely

        chains = [*self._chains]
        if self._outline:
            # The outline without what is taken from it; holes may lie over one another. That of a
            # part whose end cuts cross passes itself.
            whole = shapely.make_valid(shapely.Polygon(self._outline))
            steel = whole.difference(shapely.union_all(self._voids))
            parts = [p for p in shapely.get_parts(shapely.get_parts(steel)) if p.area > 0.0]
            for part in parts:
                chains += map(shapely.get_coordinates, (part.exterior, *part.interiors))
            if not parts:  # the outline twice, with no steel between
                chains += [np.array([*self._outline, self._outline[0]])] * 2
        self._index = _Edges(chains)
        return self._index

    def nearest(
        self, start: Point, distance: float, shape: object, box_at: Callable[[float, float], Placed]
    ) -> Point | None:
        """The place nearest to `start` where a box is clear by `distance`; None if there is none.

        Boxes of one `shape` are equal but for their place: as texts are only added, a square that
        was given up for one of them stays so. Raises Exhausted where too many squares would have to
        be looked at.
        """
        low_x, low_y, high_x, high_y = self.box
        xs, ys = zip(*box_at(*start).corners, strict=True)
        if max(xs) - min(xs) > high_x - low_x or max(ys) - min(ys) > high_y - low_y:
            return None
        seen = self._seen.setdefault(shape, {})
        half = max(high_x - low_x, high_y - low_y) / 2
        #: How far each is from `start`, its middle, half its side.
        squares = [(0.0, (low_x + high_x) / 2, (low_y + high_y) / 2, half)]
        best, place = inf, None
        while squares and squares[0][0] < best:
            _, x, y, half = heappop(squares)
            clear = seen.get((x, y), inf)
            if clear >= distance:
                if self.squares <= 0.0:
                    raise Exhausted
                texts = 0 if self._texts is None else self._texts.shape[1]
                self.squares -= 1.0 + texts / TEXTS_OF_A_SQUARE
                gap = min(BESIDE, distance)
                clear = seen[x, y] = self.clearance(box_at(x, y), distance, gap)
            self.squares -= SEEN
            if clear >= distance and (way := dist((x, y), start)) < best:
                best, place = way, (x, y)
            if half <= FINEST or clear + half * hypot(1.0, 1.0) + STEP < distance:
                continue
            half /= 2
            for mx, my in product((x - half, x + half), (y - half, y + half)):
                a, b = max(abs(mx - start[0]) - half, 0.0), max(abs(my - start[1]) - half, 0.0)
                heappush(squares, (hypot(a, b), mx, my, half))
        return place


class _Edges:
    """An index of the edges around the steel of a face."""

    def __init__(self, chains: Sequence["Floats"]) -> None:
        import numpy as np
        import shapely

        runs = [c[k : k + RUN + 1] for c in chains for k in range(0, max(1, len(c) - 1), RUN)]
        owner = np.repeat(np.arange(len(runs)), [len(run) for run in runs])
        lines = shapely.linestrings(np.concatenate(runs), indices=owner)
        self._tree: STRtree = shapely.STRtree(lines)
        self._from = np.concatenate([chain[:-1] for chain in chains])
        self._to = np.concatenate([chain[1:] for chain in chains])

    def clearance(self, box: Placed) -> float:
        """From a box in the steel to the nearest edge; else how deep it lies in obstacles.

        That is bounded by circles inside it, all of which have to come into the steel.
        """
        import numpy as np
        import shapely

        edge = self._away(shapely.polygons(box.corners))[0]
        if edge > 0.0 and self._is_steel(np.array([box.middle]))[0]:
            return float(edge)
        centres, radii = zip(*box.circles, strict=True)
        points = np.array(centres)
        away = self._away(shapely.points(points))
        return min(0.0, float((np.where(self._is_steel(points), away, -away) - radii).min()))

    def _away(self, shapes: object) -> "Floats":
        """The distance of each shape from the nearest edge."""
        _, away = self._tree.query_nearest(shapes, return_distance=True, all_matches=False)
        return away  # type: ignore[no-any-return]

    def _is_steel(self, points: "Floats") -> "NDArray[np.bool_]":
        """Whether there is steel at each point, by the edges that a ray from it crosses."""
        (x, y), (ax, ay), (bx, by) = points.T[:, :, None], self._from.T, self._to.T
        passed = (ay > y) != (by > y)
        # The side of an edge on which a point lies needs no division.
        left = ((bx - ax) * (y - ay) > (x - ax) * (by - ay)) == (by > ay)
        is_steel: NDArray[np.bool_] = (passed & left).sum(axis=1) % 2 == 1
        return is_steel
