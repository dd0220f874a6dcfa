"""Regions of a plane: cut and joined as fine polygons, given back as lines and arcs.

Arcs become polygons whose sagitta is SAGITTA; every circle is remembered, and after cutting the
edges that lie on it become arcs again, with the centre and radius that came in. Likewise facets of
a solid whose cylinders are known.
"""

from collections.abc import Sequence
from itertools import groupby
from math import acos, ceil, dist, hypot, radians
from typing import Any

import numpy as np
import shapely
from msgspec import Struct, field

from beamcam.budget import check_member
from beamcam.geometry.array_types import Floats
from beamcam.geometry.curves import Arc, Curve, Line, Point
from beamcam.geometry.plane import cross
from beamcam.readers.ifc.entities import Unreadable
from beamcam.readers.ifc.outline import Chain, joined, with_arcs
from beamcam.readers.ifc.space import Cylinder, Vec, dot

SAGITTA = 5e-4  #: mm between an arc and its polygon
MOST_POINTS = 20_000  #: of an arc's polygon; a whole circle of 40 m
ON_CIRCLE = 2e-3
ELLIPSE_POINTS = 180  #: on a part of an ellipse, which only a skew cut leaves
FAR = 1e10  #: mm; beyond where a plane that is tilted by rounding alone crosses a wall's plane
SAME = 1e-6  #: mm between equal circles of a solid, and between a circle and a corner that is on it
UPRIGHT = 1e-9  #: by which the axis of a circle's cylinder may be off the plane's normal, squared
FACET_RAD = 0.5  #: that a facet spans at most, twice the angle that the kernel is asked for
SAME_POINT = 1e-5
SHORTEST = 0.05  #: mm of an arc
GRID = 1e-3  #: mm of the grid that section lines are joined on; cracks are narrower
TINY_AREA = 0.01  #: mm2 of a scrap that cutting leaves

Shape = Any  #: a shapely polygon or a collection of them
Circle = tuple[Point, float]


class Circles(Struct):
    """Circles that curves of a region lie on: those of arcs that became polygons, or of facets.

    The corners of a solid's facets lie on its surfaces, so that a chord both of whose ends are on a
    cylinder is that cylinder's arc, with its exact radius.
    """

    known: list[Circle] = field(default_factory=list)
    facets: bool = False  #: of a solid of the kernel, as wide as a mesh has them

    def add(self, centre: Point, radius: float, off: float = 1e-4) -> None:
        if not any(abs(r - radius) < off and dist(o, centre) < off for o, r in self.known):
            self.known.append((centre, radius))


def points_of(chain: Chain, circles: Circles) -> list[Point]:
    """The vertices of a chain's polygon; its circles are remembered.

    Raises Unreadable for an arc that would take more than `MOST_POINTS`.
    """
    points: list[Point] = []
    for curve in chain:
        if isinstance(curve, Line):
            points.append(curve.start)
            continue
        count = ELLIPSE_POINTS
        if isinstance(curve, Arc):
            circles.add(curve.centre, curve.radius)
            step = 2 * acos(max(0.0, 1 - SAGITTA / curve.radius))
            sweep = radians(abs(curve.sweep_deg))
            if sweep > MOST_POINTS * step:
                raise Unreadable(f"an arc of radius {curve.radius:g} mm")
            count = max(2, ceil(sweep / step))
        points += [curve.point(i / count) for i in range(count)]
    return points


def polygon_of(chain: Chain, holes: tuple[Chain, ...], circles: Circles) -> Shape:
    """The region inside a chain, without its hollows."""
    shape = shapely.Polygon(points_of(chain, circles), [points_of(h, circles) for h in holes])
    return shape if shape.is_valid else shape.buffer(0)


def half_plane(a: float, b: float, d: float) -> Shape:
    """The region where a x + b y >= d, as far as any member reaches."""
    by = hypot(a, b)
    nx, ny = a / by, b / by
    ox, oy = nx * d / by, ny * d / by
    ux, uy = nx * FAR, ny * FAR
    return shapely.Polygon([(ox + uy, oy - ux), (ox + uy + ux, oy - ux + uy),
                    (ox - uy + ux, oy + ux + uy), (ox - uy, oy + ux)])  # fmt: skip


def pieces_of(shape: Shape) -> list[Any]:
    """The polygons of a region that are more than scraps, the largest first."""
    parts = [shape] if shape.geom_type == "Polygon" else list(getattr(shape, "geoms", ()))
    polygons = [p for p in parts if p.geom_type == "Polygon" and p.area > TINY_AREA]
    return sorted(polygons, key=lambda p: -float(p.area))


def cleaned(shape: Shape) -> Shape:
    """The region without slivers thinner than 0.02 mm that touching cuts leave."""
    solid = [p for p in pieces_of(shape) if p.area > 0.01 * p.length]
    return shapely.MultiPolygon(solid)


def chain_of_ring(ring: Any, circles: Circles) -> Chain:
    """The lines and arcs of a ring, counter-clockwise; none if it encloses nothing."""
    coordinates = [(float(x), float(y)) for x, y in ring.coords][:-1]
    points = [p for i, p in enumerate(coordinates) if dist(p, coordinates[i - 1]) > SAME_POINT]
    if len(points) < 3:
        return ()
    if sum(map(cross, points, [*points[1:], points[0]])) < 0:
        points.reverse()
    lines = tuple(Line(p, q) for p, q in zip(points, [*points[1:], points[0]], strict=True))
    chain = on_circles(lines, circles)
    # A crack may be no more than a line there and back.
    return chain if len(chain) > 2 or any(isinstance(c, Arc) for c in chain) else ()


def on_circles(chain: Chain, circles: Circles) -> Chain:
    """A closed chain of lines with arcs where it follows circles, its corners kept."""
    if circles.facets or not circles.known:
        chain = joined(chain)  # a facet's corners are on its circle, and no points between them
    if not circles.known:
        return chain
    centres = np.array([centre for centre, _ in circles.known])
    radii = np.array([radius for _, radius in circles.known])
    a, b = (
        np.array(ends)[:, None] - centres
        for ends in zip(*((c.start, c.end) for c in chain), strict=True)
    )
    off = np.maximum(*(np.abs(np.hypot(e[..., 0], e[..., 1]) - radii) for e in (a, b)))
    turns = np.arctan2(a[..., 0] * b[..., 1] - a[..., 1] * b[..., 0], (a * b).sum(axis=2))
    fits = (
        (off < (SAME if circles.facets else ON_CIRCLE))
        & (np.abs(turns) > 0)
        & (np.abs(turns) < FACET_RAD)
    )
    if not circles.facets:  # of which chords are as fine as those of `points_of`
        fits &= radii * (1 - np.cos(turns / 2)) < 2 * ON_CIRCLE
    which = np.where(fits.any(axis=1), fits.argmax(axis=1), -1)
    first = int(np.argmax((which < 0) | (which != np.roll(which, 1))))
    out: list[Curve] = []
    for k, run in groupby(np.roll(np.arange(len(chain)), -first).tolist(), key=which.__getitem__):
        lines = [*run]
        i, j = lines[0], lines[-1]
        if k < 0:
            out += [chain[one] for one in lines]
            continue
        start, sweep = np.arctan2(a[i, k, 1], a[i, k, 0]), turns[lines, k].sum()
        arc = Arc(*circles.known[k], *np.degrees((start, sweep)).clip(-360.0, 360.0).tolist())
        # What is too short to tell from a chord is one.
        out.append(arc if arc.length > SHORTEST else Line(chain[i].start, chain[j].end))
    return joined(tuple(out))


def chains_of(polygon: Any, circles: Circles) -> tuple[Chain, tuple[Chain, ...]]:
    """The border of a polygon and its hollows, counter-clockwise, with arcs, also fitted ones."""
    outer, *inner = (
        with_arcs(chain_of_ring(ring, circles)) for ring in (polygon.exterior, *polygon.interiors)
    )
    return outer, tuple(c for c in inner if c)


def with_circles(shape: Shape, circles: Circles, exact: Circles) -> Shape:
    """The region with arcs where its polygon follows circles; `circles` remembers them."""
    chains = [chains_of(p, exact) for p in getattr(shape, "geoms", (shape,)) if not p.is_empty]
    out = [polygon_of(outer, inner, circles) for outer, inner in chains if outer]
    return shapely.union_all(out) if out else shape


def circles_in(cylinders: Sequence[Cylinder], normal: Vec, u: Vec, v: Vec) -> Circles:
    """The circles (in u and v) of the cylinders that run along a normal, each once."""
    circles = Circles(facets=True)
    for one in cylinders:
        if 1.0 - dot(one.axis, normal) ** 2 <= UPRIGHT:
            circles.add((dot(one.point, u), dot(one.point, v)), one.radius, SAME)
    return circles


def region_within(segments: Floats) -> Shape:
    """The region that segments (n, 2, 2) enclose, each of which may be there more than once.

    Inside is what a ray leaves through an odd number of them. Cracks narrower than the grid are
    closed if there are any.
    """
    check_member()
    start, end = segments[:, 0], segments[:, 1]
    back = (start[:, 0] > end[:, 0]) | ((start[:, 0] == end[:, 0]) & (start[:, 1] > end[:, 1]))
    turned = np.where(back[:, None, None], segments[:, ::-1], segments)
    lines, counts = np.unique(turned, axis=0, return_counts=True)
    odd = lines[counts % 2 == 1]
    drawn = shapely.linestrings(odd)
    cells, *loose = shapely.polygonize_full([shapely.union_all(drawn)])
    if not all(one.is_empty for one in loose):
        cells = shapely.polygonize_full([shapely.union_all(drawn, grid_size=GRID)])[0]
    inside = [cell for cell in cells.geoms if _within(odd, cell.representative_point())]
    return cleaned(shapely.union_all(inside))


def _within(segments: Floats, point: Any) -> bool:
    """Whether a ray from a point to the right crosses an odd number of segments."""
    x, y = float(point.x), float(point.y)
    crossed = segments[(segments[:, 0, 1] > y) != (segments[:, 1, 1] > y)]
    (ax, ay), (bx, by) = crossed[:, 0].T, crossed[:, 1].T
    return bool(np.count_nonzero(ax + (y - ay) * (bx - ax) / (by - ay) > x) % 2)
