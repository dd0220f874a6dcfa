"""A closed shell of planar faces: its sections, its extents, its volume.

A section is cut out face by face, and what is inside is told by counting crossings, so that the
way faces are turned does not matter and faces that lie twice on each other vanish, as they have
to where an exporter let boxes touch in one shell.
"""

import itertools
from collections.abc import Sequence
from typing import Any

from msgspec import Struct

from beamcam.geometry.curves import Point
from beamcam.readers.ifc.curves2d import Chain
from beamcam.readers.ifc.exact import Circle, circles_in, with_exact_arcs
from beamcam.readers.ifc.outline import with_arcs
from beamcam.readers.ifc.region import Circles, Shape, chain_of_ring, cleaned, polygon_of
from beamcam.readers.ifc.space import ORIGIN, Frame, Vec, add, cross, dot, scale, size, sub, unit
from beamcam.readers.ifc.surfaces import Cylinder
from beamcam.readers.ifc.walls import Wall

ALONG = (1.0, 0.0, 0.0)  #: a member
MOST_WAYS = 400  #: directions of edges that are told apart
GRID = 1e-3  #: mm of the grid that section lines are joined on; cracks are narrower


class Face3(Struct, frozen=True):
    """A planar face: its border, then its hollows, and its normal times its area."""

    rings: tuple[tuple[Vec, ...], ...]
    area_normal: Vec


class Shell(Struct, frozen=True):
    """A solid by its faces; also a cutter."""

    faces: tuple[Face3, ...]
    where: str | None = None
    cylinders: tuple[Cylinder, ...] = ()  #: that its facets stand for, where they are known

    @property
    def points(self) -> list[Vec]:
        return [p for face in self.faces for p in face.rings[0]]

    @property
    def box(self) -> tuple[Vec, Vec]:
        points = self.points
        low = tuple(min(p[i] for p in points) for i in range(3))
        high = tuple(max(p[i] for p in points) for i in range(3))
        return (low[0], low[1], low[2]), (high[0], high[1], high[2])

    @property
    def volume(self) -> float | None:
        """mm3; None where the faces are not turned alike, or leave a gap."""
        faces = self.faces
        rest = [sum(f.area_normal[i] for f in faces) for i in range(3)]
        if max(map(abs, rest)) > 1e-3 * max(size(f.area_normal) for f in faces):
            return None
        return abs(sum(dot(f.rings[0][0], f.area_normal) for f in faces)) / 3

    def moved(self, by: Frame) -> "Shell":
        faces = []
        for face in self.faces:
            rings = tuple(tuple(by.point(p) for p in ring) for ring in face.rings)
            faces.append(Face3(rings, _area_normal(rings)))
        return Shell(tuple(faces), self.where, tuple(c.moved(by) for c in self.cylinders))

    def slice(self, wall: Wall, c: float, circles: Circles) -> Shape:
        """The shell's section by the wall's plane at `c`, its arcs found again."""
        return with_circles(self.raw_slice(wall, c), circles, self.circles(wall))

    def raw_slice(self, wall: Wall, c: float) -> Shape:
        """The shell's section by the wall's plane at `c`, as polygons."""
        n = wall.direction
        return section(self, scale(n, c), n, ALONG, wall.across)

    def circles(self, wall: Wall) -> tuple[Circle, ...]:
        """The circles in which the shell's cylinders go through a wall."""
        return circles_in(self.cylinders, wall.direction, ALONG, wall.across)


def with_circles(shape: Shape, circles: Circles, exact: Sequence[Circle] = ()) -> Shape:
    """A region whose polygon runs on circles are arcs, remembered in `circles`."""
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


def planar_face(rings: Sequence[Sequence[Vec]]) -> Face3 | None:
    """The face of rings in space; None where they hold no area."""
    kept = tuple(tuple(_without_repeats(ring)) for ring in rings)
    kept = tuple(ring for ring in kept if len(ring) >= 3)
    if not kept:
        return None
    normal = _area_normal(kept)
    return Face3(kept, normal) if size(normal) > 1e-9 else None


def _without_repeats(ring: Sequence[Vec]) -> list[Vec]:
    return [p for i, p in enumerate(ring) if p != ring[i - 1] or len(ring) == 1]


def _area_normal(rings: tuple[tuple[Vec, ...], ...]) -> Vec:
    """The normal of a face times its area, hollows taken off whichever way they run."""
    total = _ring_normal(rings[0])
    if size(total) == 0.0:
        return ORIGIN
    for ring in rings[1:]:
        hollow = _ring_normal(ring)
        total = sub(total, scale(hollow, 1.0 if dot(hollow, total) > 0 else -1.0))
    return total


def _ring_normal(ring: tuple[Vec, ...]) -> Vec:
    total = ORIGIN
    first = ring[0]
    for a, b in itertools.pairwise(ring):
        total = add(total, cross(sub(a, first), sub(b, first)))
    return scale(total, 0.5)


def section(shell: Shell, at: Vec, normal: Vec, u: Vec, v: Vec) -> Shape:
    """The region in which the plane through `at` cuts the shell, in (u, v)."""
    from shapely import union_all

    segments = _segments(shell, at, normal, u, v)
    kept: dict[tuple[Point, Point], int] = {}
    for a, b in segments:
        key = (a, b) if a < b else (b, a)
        kept[key] = kept.get(key, 0) + 1
    odd = [key for key, count in kept.items() if count % 2]
    if not odd:
        return union_all([])
    inside = [c for c in _cells(list(kept)) if _crossings(odd, c.representative_point()) % 2]
    return cleaned(union_all(inside)) if inside else union_all([])


def _cells(lines: list[tuple[Point, Point]]) -> list[Any]:
    """The cells that lines enclose; across cracks narrower than the grid if there are any."""
    from shapely import LineString, polygonize_full, union_all

    drawn = [LineString(key) for key in lines]
    cells, cuts, dangles, rings = polygonize_full([union_all(drawn)])
    if not (cuts.is_empty and dangles.is_empty and rings.is_empty):
        cells = polygonize_full([union_all(drawn, grid_size=GRID)])[0]
    return [c for c in cells.geoms if c.area > 1e-3]


def _segments(shell: Shell, at: Vec, normal: Vec, u: Vec, v: Vec) -> list[tuple[Point, Point]]:
    """Where a plane cuts the faces; a vertex on the plane counts as just above it."""
    found: list[tuple[Point, Point]] = []
    (ox, oy, oz), (nx, ny, nz) = at, normal
    for face in shell.faces:
        hits: list[Vec] = []
        for ring in face.rings:
            heights = [(x - ox) * nx + (y - oy) * ny + (z - oz) * nz for x, y, z in ring]
            if min(heights) >= 0 or max(heights) < 0:  # as of most faces
                continue
            for i, (p, h) in enumerate(zip(ring, heights, strict=True)):
                q, g = ring[i - 1], heights[i - 1]
                if (h >= 0) != (g >= 0):
                    # Both faces of an edge have to give the very same point.
                    if g < 0:
                        p, q, h, g = q, p, g, h
                    hits.append(add(q, scale(sub(p, q), g / (g - h))))
        if len(hits) < 2:
            continue
        along = cross(face.area_normal, normal)
        hits.sort(key=lambda p: dot(p, along))
        for p, q in zip(hits[::2], hits[1::2], strict=False):
            a, b = _flat(p, at, u, v), _flat(q, at, u, v)
            if a != b:
                found.append((a, b))
    return found


def _flat(p: Vec, at: Vec, u: Vec, v: Vec) -> Point:
    return dot(p, u) + 0.0, dot(p, v) + 0.0


def _crossings(segments: list[tuple[Point, Point]], point: Any) -> int:
    """How many segments a ray from a point to the right crosses."""
    x, y = float(point.x), float(point.y)
    count = 0
    for (ax, ay), (bx, by) in segments:
        if (ay > y) != (by > y) and ax + (y - ay) * (bx - ax) / (by - ay) > x:
            count += 1
    return count


def longest_direction(shell: Shell) -> Vec:
    """The direction that most of the shell's edges run along, by their length."""
    ways: list[Vec] = []
    lengths: list[float] = []
    known: dict[Vec, int] = {}  # edges of two faces run the very same way, or back
    for face in shell.faces:
        for ring in face.rings:
            for i, p in enumerate(ring):
                edge = sub(p, ring[i - 1])
                length = size(edge)
                if length < 1e-6:
                    continue
                way = scale(edge, 1 / length)
                k = known.get(way)
                if k is None:
                    k = _parallel(way, ways)
                    if k == len(ways):
                        if k == MOST_WAYS:
                            continue
                        ways.append(way)
                        lengths.append(0.0)
                    known[way] = known[scale(way, -1.0)] = k
                lengths[k] += length
    return ways[lengths.index(max(lengths))] if ways else ALONG


def _parallel(way: Vec, ways: Sequence[Vec]) -> int:
    """The place of a direction among those that are known, either way; their count if it is new."""
    x, y, z = way
    for k, (kx, ky, kz) in enumerate(ways):
        if abs(kx * x + ky * y + kz * z) > 1 - 1e-7:
            return k
    return len(ways)


def broadest_normal(shell: Shell) -> Vec:
    """The normal of the planes that hold most of the shell's area."""
    sums: list[tuple[Vec, float]] = []
    for face in shell.faces:
        area = size(face.area_normal)
        way = unit(face.area_normal)
        for k, (known, total) in enumerate(sums):
            if abs(dot(known, way)) > 1 - 1e-6:
                sums[k] = (known, total + area)
                break
        else:
            sums.append((way, area))
    return max(sums, key=lambda s: s[1])[0]


def extent(shell: Shell, direction: Vec) -> tuple[float, float]:
    """Least and greatest coordinate of the shell along a unit vector."""
    values = [dot(p, direction) for p in shell.points]
    return min(values), max(values)
