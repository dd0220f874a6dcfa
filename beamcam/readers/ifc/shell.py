"""A closed shell of planar faces: its sections, its extents, its volume.

A member has some hundred faces and is cut through a dozen times, and a solid of the geometry
kernel has thousands, so that a shell is held in arrays and no face is looked at by itself.
"""

from collections.abc import Sequence

import numpy as np
from msgspec import Struct
from msgspec.structs import replace

from beamcam.budget import check_member
from beamcam.geometry.array_types import Counts, Flags, Floats
from beamcam.readers.ifc.region import Circles, Shape, circles_in, region_within, with_circles
from beamcam.readers.ifc.section import Wall
from beamcam.readers.ifc.space import ORIGIN, Cylinder, Frame, Vec, cross, scale

ALONG = (1.0, 0.0, 0.0)  #: a member
MOST_WAYS = 400  #: distinct directions of edges
MIN_EDGES = 8  #: along a straight piece, each counted from both faces that meet in it
MIN_KINK_DEG = 1.0  #: less is how the facets of a round lie
MOST_KINK_DEG = 75.0  #: more is a corner of the section
MIN_KINK = 0.25  #: of the edges' length of the longer piece
MOST_PLANES = 32  #: that an end is looked for in
MIN_AREA = 1e-9  #: mm2 of a face
NEARLY, EXACTLY = 1 - 1e-7, 1 - 1e-13  #: cosines between edges that run one way
MIN_EDGE = 1e-6  #: mm of an edge that has a direction


class Shell(Struct, frozen=True, eq=False):
    """A solid by its faces, each of them by rings of corners; also a cutter.

    Rings and faces stand one after another. A face's first ring is its border, and its other rings
    are hollows.
    """

    points: Floats  #: (n, 3), the corners of all rings
    before: Counts  #: of each corner the one before it in its ring
    face: Counts  #: of each corner
    area_normals: Floats  #: (m, 3), of each face its normal times its area
    where: str | None = None
    cylinders: tuple[Cylinder, ...] = ()  #: that its facets stand for, where they are known

    @property
    def count(self) -> int:
        return len(self.area_normals)

    @property
    def firsts(self) -> Floats:
        """The first corner of each face's border."""
        return self.points[np.flatnonzero(np.diff(self.face, prepend=-1))]

    @property
    def areas(self) -> Floats:
        return lengths(self.area_normals)

    @property
    def box(self) -> tuple[Vec, Vec]:
        return vec(self.points.min(axis=0)), vec(self.points.max(axis=0))

    @property
    def volume(self) -> float | None:
        """mm3; None where the faces are not turned alike, or leave a gap."""
        if np.abs(self.area_normals.sum(axis=0)).max() > 1e-3 * self.areas.max():
            return None
        thrice: float = sum(dots(self.firsts, self.area_normals).tolist())
        return abs(thrice) / 3

    def moved(self, by: Frame) -> "Shell":
        areas = Frame(ORIGIN, cross(by.y, by.z), cross(by.z, by.x), cross(by.x, by.y))
        return replace(
            self,
            points=moved(self.points, by),
            area_normals=moved(self.area_normals, areas),
            cylinders=tuple(c.moved(by) for c in self.cylinders),
        )

    def planes_across(self, axis: Vec, least: float) -> list[tuple[Vec, Vec]]:
        """Point and normal of the planes that hold most of the shell's area, the first the most.

        Only of those whose normal has `least` along a unit vector.
        """
        areas = self.areas
        faces = np.flatnonzero(np.abs(coordinates(self.area_normals, axis)) > least * areas)
        faces = faces[np.argsort(-areas[faces], kind="stable")]
        points, ways = self.firsts[faces], self.area_normals[faces] * (1 / areas[faces])[:, None]
        rows = np.column_stack((ways.round(4), dots(points, ways).round(1)))
        _, first, group = np.unique(rows, axis=0, return_index=True, return_inverse=True)
        most = np.argsort(-np.bincount(group.ravel(), areas[faces], len(first)), kind="stable")
        return [(vec(points[k]), vec(ways[k])) for k in first[most[:MOST_PLANES]]]

    def slice(self, wall: Wall, c: float, circles: Circles) -> Shape:
        """The shell's section by the wall's plane at `c`, its arcs found again."""
        return with_circles(self.raw_slice(wall, c), circles, self.circles(wall))

    def raw_slice(self, wall: Wall, c: float) -> Shape:
        """The shell's section by the wall's plane at `c`, as polygons."""
        n = wall.direction
        return section(self, scale(n, c), n, ALONG, wall.across)

    def circles(self, wall: Wall) -> Circles:
        """The circles in which the shell's cylinders go through a wall."""
        return circles_in(self.cylinders, wall.direction, ALONG, wall.across)


def shell(
    points: Floats, sizes: Sequence[int], faces: Sequence[int], where: str | None = None
) -> Shell:
    """The shell of rings that stand one after another: how many corners each has, and its face.

    Corners on the one before them, rings of less than three corners and faces without an area
    are left out, so that it may have no faces at all.
    """
    ring = np.repeat(np.arange(len(sizes)), sizes)
    apart = (points != points[_before(ring)]).any(axis=1)
    apart &= np.bincount(ring, apart, len(sizes))[ring] >= 3
    kept, ring = np.unique(ring[apart], return_inverse=True)
    _, borders, of_ring = np.unique(np.array(faces)[kept], return_index=True, return_inverse=True)
    points, before = points[apart], _before(ring)
    off = points - points[np.flatnonzero(np.diff(ring, prepend=-1))][ring]
    twice = np.cross(off[before], off)
    by_ring = np.column_stack([np.bincount(ring, column, len(kept)) for column in twice.T]) / 2
    normals = by_ring[borders]
    for k in np.setdiff1d(np.arange(len(kept)), borders).tolist():
        hollow, border = by_ring[k], by_ring[borders[of_ring[k]]]
        normals[of_ring[k]] -= hollow if hollow @ border > 0 else -hollow  # whichever way it runs
    solid = lengths(normals) > MIN_AREA
    face, there = of_ring[ring], solid[of_ring[ring]]
    numbers = np.cumsum(solid) - 1
    return Shell(points[there], _before(ring[there]), numbers[face[there]], normals[solid], where)


def _before(ring: Counts) -> Counts:
    """Of each corner the one before it, by the ring of each."""
    before = np.arange(-1, len(ring) - 1)
    starts = np.flatnonzero(np.diff(ring, prepend=-1))
    before[starts] = np.append(starts[1:], len(ring))[: len(starts)] - 1
    return before


def moved(points: Floats, by: Frame) -> Floats:
    """Points of a frame in the frame that it stands in."""
    u, v, w = points.T
    columns = zip(by.o, by.x, by.y, by.z, strict=True)
    return np.column_stack([o + (x * u + y * v + z * w) for o, x, y, z in columns])


def vec(row: Floats) -> Vec:
    """A row of an array as the plain vector that it is."""
    x, y, z = row.tolist()
    return x, y, z


def coordinates(points: Floats, way: Vec) -> Floats:
    """The coordinates of points along a vector, the same for the same point wherever it stands.

    A matrix product would not do: its last digits depend on the place in the array.
    """
    x, y, z = points.T
    numbers: Floats = x * way[0] + y * way[1] + z * way[2]
    return numbers


def dots(a: Floats, b: Floats) -> Floats:
    (ax, ay, az), (bx, by, bz) = a.T, b.T
    numbers: Floats = ax * bx + ay * by + az * bz
    return numbers


def lengths(vectors: Floats) -> Floats:
    numbers: Floats = np.linalg.norm(vectors, axis=1)
    return numbers


def section(shell: Shell, at: Vec, normal: Vec, u: Vec, v: Vec) -> Shape:
    """The region in which the plane through `at` cuts the shell, in (u, v)."""
    return region_within(segments(shell, at, normal, u, v))


def segments(shell: Shell, at: Vec, normal: Vec, u: Vec, v: Vec) -> Floats:
    """Where a plane cuts the faces; a vertex on the plane counts as just above it."""
    points = shell.points
    heights = coordinates(points - np.array(at), normal)
    above = heights >= 0
    after = np.flatnonzero(above != above[shell.before])
    before = shell.before[after]
    # Both faces of an edge have to give the very same point.
    up, down = np.where(above[after], (after, before), (before, after))
    share = heights[down] / (heights[down] - heights[up])
    hits = points[down] + (points[up] - points[down]) * share[:, None]
    # The plane goes into a face and out of it by turns, along the line in which they meet.
    face = shell.face[after]
    ways = np.cross(shell.area_normals[face], np.broadcast_to(np.array(normal), hits.shape))
    order = np.lexsort((dots(hits, ways), face))
    flat = np.column_stack((coordinates(hits, u), coordinates(hits, v)))[order] + 0.0
    lines: Floats = flat.reshape(-1, 2, 2)
    edges: Floats = lines[(lines[:, 0] != lines[:, 1]).any(axis=1)]
    return edges


def longest_direction(shell: Shell) -> Vec:
    """The direction that most of the shell's edges run along, by their length."""
    ways, length, counted = _edges(shell)
    way = heaviest(ways[counted], length[counted], NEARLY, MOST_WAYS)
    if way is None:
        return ALONG
    # The facets of a small round may run slantwise, nearly along it.
    near = counted & (np.abs(coordinates(ways, way)) > NEARLY)
    exact = heaviest(ways[near], length[near], EXACTLY, MOST_WAYS) or way
    if np.count_nonzero(np.abs(coordinates(ways[near], exact)) > EXACTLY) >= MIN_EDGES:
        way = exact
    along = coordinates(ways, way)  # which way it runs, the first of all says
    return scale(way, float(np.sign(along[np.abs(along) > NEARLY][0])))


def kinked(shell: Shell) -> float | None:
    """The degrees by which a member bends once, from most of its edges to the rest; None if none.

    Edges shorter than a tenth of the longest do not count.
    """
    ways, length, creased = _edges(shell)
    long = creased & (length > float(length[creased].max(initial=0.0)) / 10)
    ways, length = ways[long], length[long]
    first = heaviest(ways, length, NEARLY, MOST_WAYS)
    if first is None:
        return None
    rest = np.abs(coordinates(ways, first)) < 1 - 1e-5
    second = heaviest(ways[rest], length[rest], NEARLY, MOST_WAYS)
    if second is None:
        return None
    along = [np.abs(coordinates(ways, w)) > NEARLY for w in (first, second)]
    if min(int(np.count_nonzero(one)) for one in along) < MIN_EDGES:
        return None
    shares = [float(length[one].sum()) for one in along]
    angle = float(np.degrees(np.arccos(min(1.0, abs(float(np.dot(first, second)))))))
    bent = MIN_KINK_DEG <= angle <= MOST_KINK_DEG
    return angle if bent and shares[1] >= MIN_KINK * shares[0] else None


def _edges(shell: Shell) -> tuple[Floats, Floats, Flags]:
    """The directions and the lengths of a shell's edges, and which of them are to be counted.

    Those between two faces of one plane, as in a mesh of triangles, are not.
    """
    _, corner = np.unique(shell.points.round(3), axis=0, return_inverse=True)
    ends = np.sort(np.column_stack((corner.ravel()[shell.before], corner.ravel())), axis=1)
    _, edge, count = np.unique(ends, axis=0, return_inverse=True, return_counts=True)
    total = np.zeros((len(count), 3))
    np.add.at(total, edge.ravel(), (shell.area_normals / shell.areas[:, None])[shell.face])
    flat = (count == 2) & (lengths(total) > 2 - 1e-6)
    edges = shell.points - shell.points[shell.before]
    length = lengths(edges)
    real = length >= MIN_EDGE
    return edges[real] * (1 / length[real])[:, None], length[real], ~flat[edge.ravel()][real]


def broadest_normal(shell: Shell) -> Vec:
    """The normal of the planes that hold most of the shell's area."""
    areas = shell.areas
    ways = shell.area_normals * (1 / areas)[:, None]
    return heaviest(ways, areas, 1 - 1e-6, len(ways)) or ALONG


def heaviest(ways: Floats, weights: Floats, near: float, most: int) -> Vec | None:
    """The unit vector about which most of the weight lies, either way; None if there are none.

    Vectors whose cosine is above `near` go with the first of them that stands alone. Of such
    firsts there are at most `most`; what is near none of those does not count.
    """
    best, heaviest_way = 0.0, None
    left = np.arange(len(ways))
    for _ in range(most):
        check_member()
        if not len(left) or weights[left].sum() < 0.99 * best:
            break
        first = vec(ways[left[0]])
        same = np.abs(coordinates(ways[left], first)) > near
        same[0] = True
        # Summed in their order: numpy's own sum may tell equal sums apart.
        weight = float(np.cumsum(weights[left[same]])[-1])
        if weight > best:
            best, heaviest_way = weight, first
        left = left[~same]
    return heaviest_way


def extent(shell: Shell, direction: Vec) -> tuple[float, float]:
    """Minimum and maximum coordinate of the shell along a unit vector."""
    values = coordinates(shell.points, direction)
    return float(values.min()), float(values.max())
