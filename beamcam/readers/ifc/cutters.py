"""Solids subtracted from a member: half-spaces, prisms and their combinations.

Every cutter stands in the member's coordinates (x along it, Y, Z) and tells its `slice` on a
wall: the region of the plane c = const that it removes.
"""

from math import atan, copysign, degrees, hypot

import shapely
from msgspec import Struct
from msgspec.structs import replace

from beamcam.caches import cached
from beamcam.geometry.curves import Line, Point
from beamcam.geometry.plane import determinant
from beamcam.readers.ifc.curves2d import box_around
from beamcam.readers.ifc.outline import Round, Slotted, shape_of, with_arcs
from beamcam.readers.ifc.profiles import Outline
from beamcam.readers.ifc.region import FAR, Circles, Shape, half_plane, polygon_of
from beamcam.readers.ifc.section import Wall
from beamcam.readers.ifc.shell import ALONG, Shell
from beamcam.readers.ifc.space import Frame, Vec, add, cross, dot, scale, size, sub, unit

Box3 = tuple[Vec, Vec]
MIN_LEAN = 0.17  #: of a normal along the member; a plane nearer to the axis is not an end
LEVEL = 1e-6  #: sine below which a direction counts as lying in a plane
EVERYWHERE: Box3 = ((-1e9, -1e9, -1e9), (1e9, 1e9, 1e9))


class HalfSpace(Struct, frozen=True, gc=False):
    """All that lies on one side of a plane.

    One that crosses the member is an end of it: x = a Y + b Z + c.
    """

    point: Vec
    normal: Vec  #: unit vector into the side that is removed
    where: str | None = None

    @classmethod
    def of(cls, plane: Frame, side: float, where: str | None) -> "HalfSpace":
        """All on one side of the x, y of a frame: 1 for that of its z, -1 for the other.

        The normal goes with the two directions in the plane, so that scales and mirrors are right.
        """
        normal = cross(plane.x, plane.y)
        return cls(plane.o, unit(scale(normal, copysign(side, side * dot(normal, plane.z)))), where)

    @classmethod
    def at(cls, side: int, x: float, a: float = 0.0, b: float = 0.0) -> "HalfSpace":
        """The end of a member at x, of slopes a along Y and b along Z."""
        return cls((x, 0.0, 0.0), unit((side, -side * a, -side * b)))

    @property
    def box(self) -> Box3:
        return EVERYWHERE

    @property
    def side(self) -> int:
        """1 of the member's end, -1 of its start."""
        return 1 if self.normal[0] > 0 else -1

    def facing(self, side: int) -> "HalfSpace":
        """The plane as an end of that side."""
        return self if self.side == side else replace(self, normal=scale(self.normal, -1.0))

    @property
    def slopes(self) -> tuple[float, float]:
        """a and b."""
        x, y, z = self.normal
        return -y / x, -z / x

    @property
    def angles(self) -> tuple[float, float]:
        """Of web and flange in degrees, in DSTV's signs."""
        web, flange = (round(-degrees(atan(slope)), 9) + 0.0 for slope in self.slopes)
        return web, flange

    def x(self, y: float, z: float) -> float:
        """Where the plane crosses the line along the member at (y, z)."""
        n = self.normal
        return self.point[0] - (n[1] * (y - self.point[1]) + n[2] * (z - self.point[2])) / n[0]

    def slice(self, wall: Wall, c: float, circles: Circles | None = None) -> Shape:
        """The half of the wall's plane that is removed."""
        nq, nc = wall.split(self.normal)
        d = dot(self.normal, self.point) - nc * c
        if abs(self.normal[0]) < LEVEL and abs(nq) < LEVEL:
            return shapely.box(-FAR, -FAR, FAR, FAR) if d < 0 else shapely.Polygon()
        return half_plane(self.normal[0], nq, d)


class Prism(Struct, frozen=True, gc=False):
    """An outline pushed along a vector: frame.o + s x + t y + k z, k from 0 to 1."""

    frame: Frame
    outline: Outline
    where: str | None = None
    shape: Round | Slotted | None = None

    @property
    def box(self) -> Box3:
        f = self.frame
        (x0, y0, z0), (x1, y1, z1) = (add(f.o, one) for one in _spread(f.x, f.y, self.outline))
        x, y, z = f.z
        return (
            (x0 + min(x, 0.0), y0 + min(y, 0.0), z0 + min(z, 0.0)),
            (x1 + max(x, 0.0), y1 + max(y, 0.0), z1 + max(z, 0.0)),
        )

    def start(self, shape: Round | Slotted) -> Vec:
        """Where the axis of a round or slotted prism begins."""
        s, t = shape.centre
        return self.frame.o if s == 0.0 == t else self.frame.point((s, t, 0.0))

    @property
    def sides(self) -> list[HalfSpace]:
        """The planes of its flat sides and ends; normals point into it."""
        f, outer = self.frame, self.outline.outer
        normal = cross(f.x, f.y)
        x0, y0, x1, y1 = box_around(outer)
        middle = f.point(((x0 + x1) / 2, (y0 + y1) / 2, 0.5))
        rows = [(f.o, normal), (add(f.o, f.z), normal)]
        for curve in outer:
            if isinstance(curve, Line):
                a, b = f.point((*curve.start, 0.0)), f.point((*curve.end, 0.0))
                rows.append((a, cross(sub(b, a), f.z)))
        return [
            HalfSpace(a, unit(scale(n, copysign(1.0, dot(n, sub(middle, a))))), self.where)
            for a, n in rows
            if size(n) > 1e-9
        ]

    def slice(self, wall: Wall, c: float, circles: Circles) -> Shape:
        """The prism's section by the wall's plane at `c`."""
        f, n = self.frame, wall.direction
        if abs(dot(f.z, n)) > LEVEL * size(f.z):
            return self._across(wall, c, circles)
        return self._along(wall, c)

    def _across(self, wall: Wall, c: float, circles: Circles) -> Shape:
        """Where every ruling of the prism meets the plane once: an affine image of the outline."""
        f, n = self.frame, wall.direction
        u, v, e = dot(f.x, n), dot(f.y, n), dot(f.z, n)
        at = c - dot(f.o, n)

        def image(s: float, t: float) -> Point:
            p = f.point((s, t, (at - s * u - t * v) / e))
            return p[0], wall.split(p)[0]

        o, s1, t1 = image(0.0, 0.0), image(1.0, 0.0), image(0.0, 1.0)
        matrix = ((s1[0] - o[0], t1[0] - o[0], o[0]), (s1[1] - o[1], t1[1] - o[1], o[1]))
        flat = abs(u) < LEVEL and abs(v) < LEVEL
        if (flat and not -1e-9 <= at / e <= 1 + 1e-9) or abs(determinant(matrix)) < 1e-9:
            return shapely.Polygon()
        outer = tuple(c.transformed(matrix) for c in self.outline.outer)
        inner = tuple(tuple(c.transformed(matrix) for c in hole) for hole in self.outline.inner)
        shape = polygon_of(outer, inner, circles)
        if flat:
            return shape
        first, last = (cap.slice(wall, c) for cap in self.sides[:2])
        return shape.intersection(first.intersection(last))

    def _along(self, wall: Wall, c: float) -> Shape:
        """Where the plane runs along the rulings: a strip for each stretch of the outline."""
        f, n = self.frame, wall.direction
        u, v, at = dot(f.x, n), dot(f.y, n), c - dot(f.o, n)
        grade = u * u + v * v
        if grade < LEVEL * LEVEL:
            return shapely.Polygon()
        s0, t0 = u * at / grade, v * at / grade
        far = 1e6 / grade**0.5
        line = shapely.LineString([(s0 - v * far, t0 + u * far), (s0 + v * far, t0 - u * far)])
        inside = polygon_of(self.outline.outer, self.outline.inner, Circles()).intersection(line)
        strips = []
        for piece in getattr(inside, "geoms", (inside,)):
            if piece.geom_type != "LineString" or piece.length < 1e-6:
                continue
            ends = [self.frame.point((s, t, 0.0)) for s, t in (piece.coords[0], piece.coords[-1])]
            ring = [*ends, *(add(p, self.frame.z) for p in reversed(ends))]
            strips.append(shapely.Polygon([(p[0], wall.split(p)[0]) for p in ring]))
        return shapely.union_all(strips) if strips else shapely.Polygon()


class Combined(Struct, frozen=True):
    """A cutter within others, or less others: what is taken from it stays on the member."""

    first: "Cutter"
    others: tuple["Cutter", ...]
    less: bool
    where: str | None = None

    @property
    def box(self) -> Box3:
        if self.less:
            return self.first.box
        lows, highs = zip(*(one.box for one in (self.first, *self.others)), strict=True)
        (x0, y0, z0), (x1, y1, z1) = map(max, *lows), map(min, *highs)
        return (x0, y0, z0), (x1, y1, z1)

    def slice(self, wall: Wall, c: float, circles: Circles) -> Shape:
        shape = self.first.slice(wall, c, circles)
        for one in self.others:
            other = one.slice(wall, c, circles)
            shape = shape.difference(other) if self.less else shape.intersection(other)
        return shape


Cutter = HalfSpace | Prism | Combined | Shell  #: a solid that is subtracted


def planes_of(cutter: Cutter) -> list[HalfSpace]:
    """The planes that a cutter leaves a member in, where they may be an end of it."""
    match cutter:
        case HalfSpace():
            planes = [cutter]
        case Prism():
            planes = cutter.sides
        case Combined():
            planes = [plane for one in (cutter.first, *cutter.others) for plane in planes_of(one)]
        case Shell():
            planes = [HalfSpace(p, n) for p, n in cutter.planes_across(ALONG, MIN_LEAN)]
    return [plane for plane in planes if abs(plane.normal[0]) > MIN_LEAN]


@cached("ifc.spread")
def _spread(x: Vec, y: Vec, outline: Outline) -> Box3:
    """The box of an outline in a plane of the axes x and y about the origin."""
    (x0, x1), (y0, y1), (z0, z1) = (
        box_around(tuple(
            c.transformed(((a, b, 0.0), (-b, a, 0.0))) for c in with_arcs(outline.outer)
        ))[::2]
        if hypot(a, b) > LEVEL else (0.0, 0.0)
        for a, b in zip(x, y, strict=True)
    )  # fmt: skip
    return (x0, y0, z0), (x1, y1, z1)


def hole_of(outline: Outline) -> Round | Slotted | None:
    """The hole or slot that an outline is; None if it is neither."""
    return None if outline.inner else shape_of(outline.outer)
