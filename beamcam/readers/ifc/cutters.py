"""Solids subtracted from a member: half-spaces, prisms and their combinations; its ends and bevels.

Every cutter stands in the member's coordinates (x along it, Y, Z) and tells its `slice` on a
wall: the region of the plane c = const that it removes.
"""

from collections.abc import Iterable, Sequence
from math import atan, atan2, copysign, degrees, hypot

import shapely
from msgspec import Struct
from msgspec.structs import replace

from beamcam.caches import cached
from beamcam.geometry.curves import Line, Point
from beamcam.geometry.plane import determinant
from beamcam.model.part import Bevel
from beamcam.readers.ifc.outline import Chain, Round, Slotted, box_around, shape_of, with_arcs
from beamcam.readers.ifc.profiles import Outline
from beamcam.readers.ifc.region import FAR, Circles, Shape, half_plane, pieces_of, polygon_of
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
        return self if self.side == side else replace(self, normal=scale(self.normal, -1.0))

    @property
    def slopes(self) -> tuple[float, float]:
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

    @property
    def sides(self) -> list[HalfSpace]:
        """The planes of its flat sides and ends; normals point into it."""
        f, outer = self.frame, self.outline.outer
        normal = cross(f.x, f.y)
        x0, y0, x1, y1 = box_around(outer)
        middle = f.point(((x0 + x1) / 2, (y0 + y1) / 2, 0.5))
        rows = [(f.o, normal), (add(f.o, f.z), normal)]
        for side in (curve for curve in outer if isinstance(curve, Line)):
            a, b = f.point((*side.start, 0.0)), f.point((*side.end, 0.0))
            rows.append((a, cross(sub(b, a), f.z)))
        return [
            HalfSpace(a, unit(scale(n, copysign(1.0, dot(n, sub(middle, a))))), self.where)
            for a, n in rows
            if size(n) > 1e-9
        ]

    def slice(self, wall: Wall, c: float, circles: Circles) -> Shape:
        """The prism's section by the wall's plane at `c`."""
        across = abs(dot(self.frame.z, wall.direction)) > LEVEL * size(self.frame.z)
        return self._across(wall, c, circles) if across else self._along(wall, c)

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
        """Where the plane runs along the rulings: a strip for each part of the outline."""
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


# --- ends -----------------------------------------------------------------------------------------
# Which plane cuts each end of a member, and its angles in DSTV's signs.
#
#     x = a Y + b Z + c        web angle = -atan a, flange angle = -atan b
#
# which is DSTV's atan2(x(lowest y) - x(highest y), y_high - y_low) at either end. Where several
# planes or cuts form an end, the plane that holds most of the end's height and width counts, and
# what it does not explain stays in the contours.

MIN_EDGE = 1.0  #: mm across the member of an edge that counts for an end
SAME_REACH = 1e-4  #: mm by which one plane may be before the sole one
REACHED = 0.01  #: mm by which an end's plane may miss the end of the member
LEVEL_REACH = 0.08  #: mm that the outer levels of a wall lie inside it, at most
UNEXPLAINED = 0.05  #: mm, the width of what no end plane explains
SQUARE = 0.9  #: share of what a square end holds by which a plane of a face is taken before it
FILM = 0.05  #: mm before a plane in which the walls that end at it are seen


class Trim(Struct, frozen=True, gc=False):
    """Limits of a stock by the planes at one end, along the lines of its section's corners."""

    planes: tuple[HalfSpace, ...]  #: the stock's own square end, and those that cut it
    sole: HalfSpace | None  #: the one plane that cuts the whole section; None if several share it
    reach: float  #: side * x that the sole plane reaches at most; as `most` without one
    least: float  #: side * x up to which no plane takes anything
    most: float  #: side * x beyond which nothing is left


def trim(square: HalfSpace, cuts: Sequence[HalfSpace], corners: Sequence[Point]) -> Trim:
    """The end of a stock that is `square` before its cuts, at the (Y, Z) of the corners."""
    planes, level = (square, *cuts), square.side * square.point[0]
    if not cuts:
        return Trim(planes, square, level, level, level)
    lines = [[level] * len(corners), *(reaches(one, corners) for one in cuts)]
    left = list(map(min, *lines))
    least, most = min(left), max(left)
    for one, line in zip(planes, lines, strict=True):
        if max(a - b for a, b in zip(line, left, strict=True)) <= SAME_REACH:
            return Trim(planes, one, max(line), least, most)
    return Trim(planes, None, most, least, most)


def reaches(end: HalfSpace, corners: Sequence[Point]) -> list[float]:
    """side * x of an end at each of the corners."""
    (a, b), c, side = end.slopes, end.x(0.0, 0.0), end.side
    return [side * (a * y + b * z + c) for y, z in corners]


Level = tuple[Wall, float, Shape]  #: a wall, c, and its region there


def end_of(
    side: int,
    planes: Iterable[HalfSpace],
    levels: Sequence[Level],
    corners: Sequence[Point],
    x: float | None = None,
) -> tuple[HalfSpace, float]:
    """The plane that most of an end lies in, and the x in which the member ends there.

    That is one of `planes` which reaches the end of the member at one of its section's corners, and
    leaves no wall beyond it: a shoulder of copes is not an end. Without one the end is square. `x`
    is where the member ends, if that is known better than from `levels`.
    """
    bounds = [p.bounds for _, _, s in levels for p in pieces_of(s)]
    outermost = max(b[2] for b in bounds) if side > 0 else min(b[0] for b in bounds)
    # A level lies a little inside its wall, and a leaning end reaches further at the surface.
    last, inside = (outermost, LEVEL_REACH) if x is None else (x, 0.0)
    best, best_x = HalfSpace.at(side, last), last
    most = SQUARE * _weight(best, levels)
    for one in planes:
        plane = one.facing(side)
        reached = side * max(reaches(plane, corners))
        if abs(reached - last) >= inside * sum(map(abs, one.slopes)) + REACHED:
            continue
        over = (s.intersection(plane.slice(wall, c)) for wall, c, s in levels)
        weight = _weight(plane, levels)
        if weight > most and all(shape.buffer(-UNEXPLAINED).is_empty for shape in over):
            best, best_x, most = plane, reached, weight
    return best, best_x if x is None else x


def _weight(end: HalfSpace, levels: Sequence[Level]) -> float:
    """mm across the walls in which they end at a plane."""
    film = replace(end, point=add(end.point, (-end.side * FILM, 0.0, 0.0)))
    areas = (float(s.intersection(film.slice(wall, c)).area) for wall, c, s in levels)
    return sum(areas) / FILM


# --- bevels ---------------------------------------------------------------------------------------
# Edges that lean through their wall: bevels, each with its angle and its land.
#
#      looked-at surface
#   ____________________
#  /                        angle from square, until `land` is left;
# |    land                 an X has another one from the far side
# |_____________________

SET_BACK = 0.05  #: mm by which a level stands back behind the outermost
STRAIGHT = 0.1  #: mm that a level may be off the plane of a bevel
MIN_LAND = 0.02  #: share of the thickness; less counts as no land

Run = list[tuple[float, float]]  #: depth below a surface, and how far the edge stands back there


def bevels_of(outer: Chain, wall: Wall, levels: Sequence[tuple[float, Shape]]) -> tuple[Bevel, ...]:
    """The bevels of an outline that goes round the wall at all its levels together."""
    by_depth = sorted(levels, key=lambda level: -level[0] if wall.outer else level[0])
    bevels: list[Bevel] = []
    for i, curve in enumerate(outer):
        if not isinstance(curve, Line) or curve.length < MIN_EDGE:
            continue
        middle = shapely.Point(curve.point(0.5))
        run = [
            (abs(wall.surface - c), 0.0 if s.is_empty else float(s.distance(middle)))
            for c, s in by_depth
        ]
        if max(back for _, back in run) <= SET_BACK:
            continue
        behind = [(wall.thickness - depth, back) for depth, back in reversed(run)]
        sides = [_bevel(i, one, wall.thickness, way) for one, way in ((run, 1.0), (behind, -1.0))]
        own = [bevel for bevel in sides if bevel is not None]
        if not own:  # from surface to surface, of an edge of another form
            (top, near), (deepest, far) = run[0], run[-1]
            angle = degrees(atan2(max(near, far), deepest - top))
            own = [Bevel(i, angle if near > far else -angle, 0.0)]
        bevels += own
    return tuple(bevels)


def _bevel(curve: int, run: Run, thickness: float, way: float) -> Bevel | None:
    """The bevel that begins at a surface and gets shallower; None if the edge has none there."""
    (top, back), (under, then), *_ = run
    if back <= SET_BACK or back - then <= SET_BACK / 2:
        return None
    grade = (back - then) / (under - top)
    deep = top + back / grade
    plane = (max(0.0, grade * (deep - depth)) for depth, _ in run)
    # An edge that is set back again on the far side has a bevel of its own there.
    for expected, (depth, found) in zip(plane, run, strict=True):
        if depth <= deep and abs(expected - found) > STRAIGHT:
            return None
    land = max(0.0, thickness - deep)
    if land < MIN_LAND * thickness:
        land = 0.0
    if way < 0.0 and land:  # which counts from the far side, where this one begins
        land = deep
    return Bevel(curve, way * degrees(atan(grade)), land)
