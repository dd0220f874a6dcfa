"""Regions of a plane: cut and joined as fine polygons, given back as lines and arcs.

Arcs become polygons whose sagitta is SAGITTA; every circle is remembered, and after cutting the
edges that lie on it become arcs again, with the centre and radius that came in.
"""

from collections import Counter
from collections.abc import Sequence
from itertools import groupby
from math import acos, atan2, ceil, degrees, hypot, pi, radians
from typing import Any

import numpy as np
from msgspec import Struct, field
from numpy.typing import NDArray

from beamcam.budget import check_member
from beamcam.geometry.curves import Arc, Curve, Line, Point
from beamcam.readers.ifc.brep import Cylinder
from beamcam.readers.ifc.curves2d import Chain
from beamcam.readers.ifc.entities import Unreadable
from beamcam.readers.ifc.outline import joined, with_arcs
from beamcam.readers.ifc.space import Vec, dot

SAGITTA = 5e-4  #: mm between an arc and its polygon
MOST_POINTS = 20_000  #: of an arc's polygon; a whole circle of 40 m
ON_CIRCLE = 2e-3
ELLIPSE_POINTS = 180  #: on a stretch of an ellipse, which only a skew cut leaves
FAR = 1e10  #: mm; beyond where a plane that is tilted by rounding alone crosses a wall's plane
TINY_AREA = 0.01  #: mm2 of a scrap that cutting leaves

Shape = Any  #: a shapely polygon or a collection of them


class Circles(Struct):
    """The circles that arcs of a member's regions lie on."""

    known: list[tuple[Point, float]] = field(default_factory=list)

    def add(self, centre: Point, radius: float) -> None:
        for (x, y), r in self.known:
            if abs(r - radius) < 1e-4 and hypot(x - centre[0], y - centre[1]) < 1e-4:
                return
        self.known.append((centre, radius))


def points_of(chain: Chain, circles: Circles) -> list[Point]:
    """The vertices of a chain's polygon; its circles are remembered.

    Raises Unreadable for an arc that would take more than `MOST_POINTS`.
    """
    points: list[Point] = []
    for curve in chain:
        if isinstance(curve, Line):
            points.append(curve.start)
        elif isinstance(curve, Arc):
            circles.add(curve.centre, curve.radius)
            step = 2 * acos(max(0.0, 1 - SAGITTA / curve.radius))
            sweep = radians(abs(curve.sweep_deg))
            if sweep > MOST_POINTS * step:
                raise Unreadable(f"an arc of radius {curve.radius:g} mm")
            count = max(2, ceil(sweep / step))
            points += [curve.point(i / count) for i in range(count)]
        else:
            points += [curve.point(i / ELLIPSE_POINTS) for i in range(ELLIPSE_POINTS)]
    return points


def polygon_of(chain: Chain, holes: tuple[Chain, ...], circles: Circles) -> Shape:
    """The region inside a chain, without its hollows."""
    from shapely import Polygon

    shape = Polygon(points_of(chain, circles), [points_of(h, circles) for h in holes])
    return shape if shape.is_valid else shape.buffer(0)


def half_plane(a: float, b: float, d: float) -> Shape:
    """The region where a x + b y >= d, as far as any member reaches."""
    from shapely import Polygon

    by = hypot(a, b)
    nx, ny = a / by, b / by
    ox, oy = nx * d / by, ny * d / by
    tx, ty = -ny * FAR, nx * FAR
    ux, uy = nx * FAR, ny * FAR
    return Polygon(
        [
            (ox - tx, oy - ty),
            (ox - tx + ux, oy - ty + uy),
            (ox + tx + ux, oy + ty + uy),
            (ox + tx, oy + ty),
        ]
    )


def rectangle(x0: float, y0: float, x1: float, y1: float) -> Shape:
    from shapely import box

    return box(x0, y0, x1, y1)


def pieces_of(shape: Shape) -> list[Any]:
    """The polygons of a region that are more than scraps, the largest first."""
    parts = [shape] if shape.geom_type == "Polygon" else list(getattr(shape, "geoms", ()))
    found = [p for p in parts if p.geom_type == "Polygon" and p.area > TINY_AREA]
    return sorted(found, key=lambda p: -float(p.area))


def cleaned(shape: Shape) -> Shape:
    """The region without slivers thinner than 0.02 mm that touching cuts leave."""
    from shapely import MultiPolygon

    solid = [p for p in pieces_of(shape) if p.area > 0.01 * p.length]
    return MultiPolygon(solid)


def chain_of_ring(ring: Any, circles: Circles) -> Chain:
    """The lines and arcs of a ring, counter-clockwise."""
    coordinates = [(float(x), float(y)) for x, y in ring.coords][:-1]
    points = [p for i, p in enumerate(coordinates) if _apart(p, coordinates[i - 1])]
    n = len(points)
    if n < 3:
        return ()
    area = sum(points[i - 1][0] * points[i][1] - points[i - 1][1] * points[i][0] for i in range(n))
    if area < 0:
        points.reverse()
    if not circles.known:
        return joined(tuple(Line(p, points[(i + 1) % n]) for i, p in enumerate(points)))
    on = [_circle_of(points[i], points[(i + 1) % n], circles) for i in range(n)]
    start = next((i for i in range(n) if on[i] is None or on[i] != on[i - 1]), None)
    if start is None and on[0] is not None:
        centre, radius = circles.known[on[0]]
        return (Arc(centre, radius, 0.0, 360.0),)
    out: list[Curve] = []
    order = [(i + (start or 0)) % n for i in range(n)]
    for kind, run in groupby(order, key=on.__getitem__):
        edges = [(points[i], points[(i + 1) % n]) for i in run]
        if kind is None:
            out += [Line(a, b) for a, b in edges]
        else:
            (a, then), (_, b) = edges[0], edges[-1]
            out.append(_arc(circles.known[kind], a, then, b))
    return joined(tuple(out))


def _apart(a: Point, b: Point) -> bool:
    return hypot(a[0] - b[0], a[1] - b[1]) > 1e-5


def _circle_of(a: Point, b: Point, circles: Circles) -> int | None:
    """The circle that an edge is a chord of."""
    mx, my = (a[0] + b[0]) / 2, (a[1] + b[1]) / 2
    for i, ((x, y), r) in enumerate(circles.known):
        if (
            abs(hypot(a[0] - x, a[1] - y) - r) < ON_CIRCLE
            and abs(hypot(b[0] - x, b[1] - y) - r) < ON_CIRCLE
            and abs(hypot(mx - x, my - y) - r) < 2 * ON_CIRCLE
            and hypot(a[0] - b[0], a[1] - b[1]) <= 2 * r
        ):
            return i
    return None


def _arc(circle: tuple[Point, float], a: Point, then: Point, b: Point) -> Curve:
    (x, y), r = circle
    start = atan2(a[1] - y, a[0] - x)
    way = (a[0] - x) * (then[1] - y) - (a[1] - y) * (then[0] - x)
    end = atan2(b[1] - y, b[0] - x)
    turn = (end - start) % (2 * pi) if way > 0 else -((start - end) % (2 * pi))
    if abs(turn) * r < 0.05:  # too short to tell from a chord
        return Line(a, b)
    return Arc((x, y), r, degrees(start), degrees(turn))


def chains_of(polygon: Any, circles: Circles) -> tuple[Chain, tuple[Chain, ...]]:
    """The border of a polygon and its hollows, with arcs, each counter-clockwise."""
    outer = with_arcs(chain_of_ring(polygon.exterior, circles))
    inner = tuple(with_arcs(chain_of_ring(r, circles)) for r in polygon.interiors)
    return outer, tuple(c for c in inner if c)


# --- exact ----------------------------------------------------------------------------------------
# Arcs of a section as the solid has them, not as a circle laid through its facets.
#
# The corners of a solid's facets lie on its surfaces, so that a chord both of whose ends are on a
# cylinder is that cylinder's arc.

SAME = 1e-6  #: mm between equal circles, and between a circle and a corner that is on it
UPRIGHT = 1e-9  #: by which the axis of a circle's cylinder may be off the plane's normal, squared
FACET_RAD = 0.5  #: that a facet spans at most, twice the angle that the kernel is asked for

Circle = tuple[Point, float]


def circles_in(cylinders: Sequence[Cylinder], normal: Vec, u: Vec, v: Vec) -> tuple[Circle, ...]:
    """Centre (in u and v) and radius of the cylinders that run along a normal, each once."""
    found: list[Circle] = []
    for one in cylinders:
        if 1.0 - dot(one.axis, normal) ** 2 > UPRIGHT:
            continue
        x, y = dot(one.frame.o, u), dot(one.frame.o, v)
        if not any(
            abs(r - one.radius) < SAME and hypot(x - p, y - q) < SAME for (p, q), r in found
        ):
            found.append(((x, y), one.radius))
    return tuple(found)


def with_exact_arcs(chain: Chain, circles: Sequence[Circle]) -> Chain:
    """The chain with each facet of a known circle as the circle's arc, its corners kept."""
    return joined(tuple(_exact(curve, circles) for curve in chain)) if circles else chain


def _exact(curve: Curve, circles: Sequence[Circle]) -> Curve:
    if not isinstance(curve, Line):
        return curve
    for centre, radius in circles:
        start, end = _angle(centre, radius, curve.start), _angle(centre, radius, curve.end)
        if start is None or end is None:
            continue
        turn = (end - start + pi) % (2 * pi) - pi
        if 0.0 < abs(turn) < FACET_RAD:
            return Arc(centre, radius, degrees(start), degrees(turn))
    return curve


def _angle(centre: Point, radius: float, p: Point) -> float | None:
    """The angle in radians at which a point is on a circle; None where it is not."""
    x, y = p[0] - centre[0], p[1] - centre[1]
    return atan2(y, x) if abs(hypot(x, y) - radius) < SAME else None


GRID = 1e-3  #: mm of the grid that section lines are joined on; cracks are narrower
MIN_CELL = 1e-3  #: mm2

Segments = NDArray[np.float64]  #: (n, 2, 2): start and end, each by its two coordinates


def region_within(segments: Segments) -> Shape:
    """The region that segments enclose, each of which may be there more than once."""
    check_member()
    from shapely import point_on_surface, union_all

    start, end = segments[:, 0], segments[:, 1]
    back = (start[:, 0] > end[:, 0]) | ((start[:, 0] == end[:, 0]) & (start[:, 1] > end[:, 1]))
    turned = np.where(back[:, None, None], segments[:, ::-1], segments)
    counts = Counter(map(tuple, turned.reshape(-1, 4).tolist()))
    lines = np.array(list(counts)).reshape(-1, 2, 2)
    odd = lines[np.array(list(counts.values()), int) % 2 == 1]
    if not len(odd):
        return union_all([])
    cells = _cells(lines)
    inside = [c for c, p in zip(cells, point_on_surface(cells), strict=True) if _within(odd, p)]
    return cleaned(union_all(inside)) if inside else union_all([])


def _cells(lines: Segments) -> list[Any]:
    """The cells that lines enclose; across cracks narrower than the grid if there are any."""
    from shapely import linestrings, polygonize_full, union_all

    drawn = linestrings(lines)
    cells, cuts, dangles, rings = polygonize_full([union_all(drawn)])
    if not (cuts.is_empty and dangles.is_empty and rings.is_empty):
        cells = polygonize_full([union_all(drawn, grid_size=GRID)])[0]
    return [c for c in cells.geoms if c.area > MIN_CELL]


def _within(segments: Segments, point: Any) -> bool:
    """Whether a ray from a point to the right crosses an odd number of segments."""
    x, y = float(point.x), float(point.y)
    crossed = segments[(segments[:, 0, 1] > y) != (segments[:, 1, 1] > y)]
    (ax, ay), (bx, by) = crossed[:, 0].T, crossed[:, 1].T
    return bool(np.count_nonzero(ax + (y - ay) * (bx - ax) / (by - ay) > x) % 2)


def with_circles(shape: Shape, circles: Circles, exact: Sequence[Circle] = ()) -> Shape:
    """The region with arcs where its polygon follows circles; `circles` remembers them."""
    from shapely import union_all

    out = []
    for piece in getattr(shape, "geoms", (shape,)):
        if piece.is_empty:
            continue
        outer, inner = arcs_of(piece, exact)
        if outer:
            out.append(polygon_of(outer, inner, circles))
    return union_all(out) if out else shape


def arcs_of(piece: Any, exact: Sequence[Circle]) -> tuple[Chain, tuple[Chain, ...]]:
    """The border of a polygon and its hollows, with the arcs of `exact` circles and fitted ones."""
    hollows = tuple(ring_arcs(ring, exact) for ring in piece.interiors)
    return ring_arcs(piece.exterior, exact), tuple(c for c in hollows if c)


def ring_arcs(ring: Any, exact: Sequence[Circle]) -> Chain:
    """The lines and arcs of a polygon's ring, those of `exact` circles and fitted ones."""
    return with_arcs(with_exact_arcs(chain_of_ring(ring, Circles()), exact))
