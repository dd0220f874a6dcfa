"""Regions out of the lines in which a plane cuts the faces of a shell.

What is inside is told by counting crossings, so that the way faces are turned does not matter
and faces that lie twice on each other vanish, as they have to where an exporter let boxes touch
in one shell.
"""

from collections import Counter
from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from beamcam.budget import check_member
from beamcam.readers.ifc.curves2d import Chain
from beamcam.readers.ifc.exact import Circle, with_exact_arcs
from beamcam.readers.ifc.outline import with_arcs
from beamcam.readers.ifc.region import Circles, Shape, chain_of_ring, cleaned, pieces_of, polygon_of

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
