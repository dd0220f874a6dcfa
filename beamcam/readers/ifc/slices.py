"""Regions out of the lines in which a plane cuts the faces of a shell.

What is inside is told by counting crossings, so that the way faces are turned does not matter
and faces that lie twice on each other vanish, as they have to where an exporter let boxes touch
in one shell.
"""

from collections import Counter
from collections.abc import Sequence
from math import atan2, degrees, hypot, pi
from typing import Any

import numpy as np
from numpy.typing import NDArray

from beamcam.budget import check_member
from beamcam.geometry.curves import Arc, Curve, Line, Point
from beamcam.readers.ifc.brep import Cylinder
from beamcam.readers.ifc.curves2d import Chain
from beamcam.readers.ifc.outline import joined, with_arcs
from beamcam.readers.ifc.region import Circles, Shape, chain_of_ring, cleaned, pieces_of, polygon_of
from beamcam.readers.ifc.space import Vec, dot

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
MIN_STEP = 1e-5  #: mm between two corners of a ring

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


def hollows(shape: Shape) -> int:
    """How many hollows the pieces of a region have, without those that are no more than a line."""
    return sum(_has_room(ring) for piece in pieces_of(shape) for ring in piece.interiors)


def _has_room(ring: Any) -> bool:
    """Whether a ring has three corners that stand apart."""
    from shapely import get_coordinates

    steps = np.diff(get_coordinates(ring), axis=0)
    return int(np.count_nonzero(np.hypot(*steps.T) > MIN_STEP)) >= 3


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
