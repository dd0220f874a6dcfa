"""The solid of a part, rebuilt from its features: a stock, two end planes and the cut-outs.

It is given by its sections across the part, in (Z, Y). A through hole or an opening in a wall goes
on into the root fillet behind it, as a drill does; a cope of a web takes the fillets with it.
"""

from collections.abc import Callable, Iterator, Sequence
from math import cos, hypot, inf, pi, radians, sin, sqrt, tan

import numpy as np
from msgspec import Struct
from numpy.typing import NDArray

from beamcam.budget import check_member
from beamcam.geometry.curves import Point
from beamcam.model.part import Bevel, Contour, Hole, Slot
from beamcam.readers.ifc.ends import End
from beamcam.readers.ifc.faceted import area_of, outline_of, polygon
from beamcam.readers.ifc.finish import Shaped
from beamcam.readers.ifc.region import Shape, pieces_of, rectangle
from beamcam.readers.ifc.section import Section
from beamcam.readers.ifc.walls import Wall, corner_points, walls_of

Numbers = NDArray[np.float64]

BEYOND = 10.0  #: mm by which what is cut out reaches over the stock
LEAN_STEPS = 12  #: stretches of a leaning end
LAYERS = 8  #: of a bevel's wedge
BESIDE = 0.01  #: mm beside an edge
SLICES = 24  #: of a hole across a round section
GAUSS = (-1 / sqrt(3), 1 / sqrt(3))  #: points of a rule that is exact for cubic polynomials


class Cut(Struct, frozen=True, eq=False):
    """A cut-out of a wall: a shape in (x, q) between two depths."""

    shape: Shape
    wall: Wall
    low: float
    high: float


class Strip(Struct, frozen=True):
    """A hole across a round section, on the side that `angle_rad` says, from u over v."""

    x: float
    radius: float
    angle_rad: float
    both: bool  #: through a solid bar


class Rebuilt(Struct, frozen=True, eq=False):
    """A stock of one section between two planes, and what is cut out of it."""

    stock: Shape  #: the section in (Z, Y)
    start: End
    end: End
    length: float
    cuts: tuple[Cut, ...]
    holes: tuple[tuple[Cut, float], ...]  #: with their volumes
    strips: tuple[Strip, ...]

    @property
    def events(self) -> list[float]:
        """Positions x at which its sections change."""
        found = [0.0, self.length]
        for shape in (*(c.shape for c in self.cuts), *(c.shape for c, _ in self.holes)):
            found += _abscissas(shape)
        for strip in self.strips:
            found += [strip.x - strip.radius, strip.x, strip.x + strip.radius]
        for end in (self.start, self.end):
            found += _lean(end, self.stock)
        return sorted({round(min(max(x, 0.0), self.length), 4) for x in found})

    @property
    def volume(self) -> float:
        """mm3."""
        marks = [0.0, self.length]
        for cut in self.cuts:
            marks += _abscissas(cut.shape)
        for end in (self.start, self.end):
            marks += _lean(end, self.stock)
        marks = sorted({min(max(x, 0.0), self.length) for x in marks})
        edges = np.array(marks)
        middle, half = (edges[1:] + edges[:-1]) / 2, (edges[1:] - edges[:-1]) / 2
        xs = np.concatenate([middle + g * half for g in GAUSS])
        areas = self._areas(xs)
        total = float(areas @ np.concatenate([half for _ in GAUSS]))
        total -= sum(volume for _, volume in self.holes)
        total -= sum(self._across(strip) for strip in self.strips)
        return total

    def sections(self, xs: Numbers) -> list[Shape]:
        """The sections at these places, holes included."""
        every = (*self.cuts, *(cut for cut, _ in self.holes))
        return [
            self._section(x, cuts, self.strips)
            for x, cuts in zip(xs.tolist(), _cuts_at(every, xs), strict=True)
        ]

    def walls_drilled(self, xs: Numbers) -> Numbers:
        """mm of walls that holes go through at these places."""
        wide = self.stock.bounds[2] - self.stock.bounds[0]
        there = _cuts_at([cut for cut, _ in self.holes], xs)
        found = np.array([sum(cut.high - cut.low for cut in cuts) for cuts in there], np.float64)
        for strip in self.strips:
            found += np.where(np.abs(strip.x - xs) < strip.radius, wide, 0.0)
        return found

    def _areas(self, xs: Numbers) -> Numbers:
        there = zip(xs.tolist(), _cuts_at(self.cuts, xs), strict=True)
        return np.array([float(self._section(x, cuts, ()).area) for x, cuts in there])

    def _section(self, x: float, cuts: Sequence[Cut], strips: Sequence[Strip]) -> Shape:
        from shapely import union_all

        left = self.stock
        for end in (self.start, self.end):
            left = _behind(left, end, x)
        out = [box for cut in cuts for box in _taken(cut, x)]
        out += [s for strip in strips if (s := self._strip(strip, x)) is not None]
        return left.difference(union_all(out)) if out else left

    def _strip(self, strip: Strip, x: float) -> Shape | None:
        from shapely import Polygon

        if abs(x - strip.x) >= strip.radius:
            return None
        x0, y0, x1, y1 = self.stock.bounds
        wide = sqrt(strip.radius**2 - (x - strip.x) ** 2)
        far, near = max(x1 - x0, y1 - y0), 0.0
        if strip.both:
            near = -far
        wz, wy = sin(strip.angle_rad), -cos(strip.angle_rad)
        cz, cy = (x0 + x1) / 2, (y0 + y1) / 2
        corners = ((near, wide), (near, -wide), (far, -wide), (far, wide))
        return Polygon([(cz + t * wz - s * wy, cy + t * wy + s * wz) for t, s in corners])

    def _across(self, strip: Strip) -> float:
        """Material removed by a hole across the section, in closer slices where it is narrow."""
        check_member()
        total = 0.0
        for i in range(SLICES):
            angle = pi * ((i + 0.5) / SLICES - 0.5)
            x = strip.x + strip.radius * sin(angle)
            taken = self._strip(strip, x)
            width = strip.radius * cos(angle) * pi / SLICES
            total += width * float(self.stock.intersection(taken).area) if taken is not None else 0
        return total


Corners = Callable[[Wall], Sequence[Point]]


def rebuilt(shaped: Shaped, stock: Shape, corners: Corners | None = None) -> Rebuilt:
    """The solid of a part whose stock has the section `stock`, in (Z, Y).

    `corners` are those of a mesh in (x, q) of a wall: arcs are made of the chords between them.
    """
    on = {w.face: corners(w) if corners else None for w in walls_of(shaped.section)}
    section = shaped.section
    cuts: list[Cut] = []
    holes: list[tuple[Cut, float]] = []
    strips: list[Strip] = []
    walls = {w.face: w for w in walls_of(section)}
    outer: dict[str, list[Contour]] = {}
    for f in shaped.features:
        if isinstance(f, Hole) and section.code in ("RO", "RU"):
            r = section.height / 2
            strips.append(Strip(f.x, f.diameter / 2, f.y / r, section.code == "RU"))
        elif isinstance(f, (Hole, Slot)):
            cut = _hole(f, walls, on)
            holes.append((cut, float(cut.shape.area) * (cut.high - cut.low)))
            if corners is None:
                holes[-1] = (cut, area_of(f) * (cut.high - cut.low))
            cuts += _behind_hole(cut, section) if f.depth is None else ()
        elif isinstance(f, Contour):
            wall = walls[f.face]
            cuts += (c for b in f.bevels for c in _bevel(f, b, wall, on[f.face]))
            if f.kind == "outer":
                outer.setdefault(f.face, []).append(f)
            else:
                cuts += _cut_through(polygon(f.curves, on[f.face]), wall, section)
    for face, contours in outer.items():
        wall = walls[face]
        gone = rectangle(-BEYOND, 0.0, shaped.length + BEYOND, wall.width)
        for contour in contours:
            gone = gone.difference(polygon(contour.curves, on[face]))
        cuts += _cut_through(gone, wall, section)
    start, end = planes(shaped)
    cuts += _crossing_others(holes, cuts)
    return Rebuilt(stock, start, end, shaped.length, tuple(cuts), tuple(holes), tuple(strips))


def _crossing_others(holes: list[tuple[Cut, float]], cuts: Sequence[Cut]) -> list[Cut]:
    """Remove the `holes` that share steel with other cuts, as their volumes do not add up."""
    every = [cut for cut, _ in holes] + list(cuts)
    shared = [
        one
        for one in holes
        if any(
            other is not one[0]
            and other.wall == one[0].wall
            and other.shape.intersects(one[0].shape)
            for other in every
        )
    ]
    for one in shared:
        holes.remove(one)
    return [cut for cut, _ in shared]


def planes(shaped: Shaped) -> tuple[End, End]:
    """The planes of both ends by the angles and the length of a part."""
    cuts = shaped.cuts
    corners = corner_points(shaped.section)
    found = []
    for side, web, flange in (
        (-1, cuts.web_start, cuts.flange_start), (1, cuts.web_end, cuts.flange_end)
    ):  # fmt: skip
        a, b = -tan(radians(web)), -tan(radians(flange))
        reach = [a * y + b * z for y, z in corners]
        c = shaped.length - max(reach) if side > 0 else -min(reach)
        found.append(End(side, a, b, c))
    return found[0], found[1]


def _cut_through(shape: Shape, wall: Wall, section: Section) -> Iterator[Cut]:
    """Material that a shape removes from a wall, and from the fillets on it between other walls."""
    if shape.is_empty:
        return
    yield Cut(shape, wall, wall.low, wall.high)
    low, high = _between(wall, section)
    if high <= low:
        return
    x0, _, x1, _ = shape.bounds
    inner = shape.intersection(rectangle(x0 - 1, low, x1 + 1, high))
    if not pieces_of(inner):
        return
    if section.code == "M":  # the round inner corners
        deep = max(0.0, section.radius - wall.thickness) + 1e-3
        inside_low = wall.face in ("v", "o")
        span = (wall.low - deep, wall.high) if inside_low else (wall.low, wall.high + deep)
        yield Cut(inner, wall, *span)
    elif section.code == "C":  # lips lie between the flanges too
        yield Cut(inner, wall, wall.low, wall.high + section.radius)
    else:
        yield Cut(inner, wall, -inf, inf)


def _between(wall: Wall, section: Section) -> tuple[float, float]:
    """The stretch across a wall that lies between the walls at its edges."""
    h, b, tf, tw = section.height, section.width, section.flange_thickness, section.web_thickness
    if wall.normal == "z" and section.code in ("I", "U", "C", "M"):
        return tf, h - tf
    if wall.normal == "z" and section.code == "L":
        return tf, h
    if section.code == "T" and wall.normal == "y":
        return tw, b
    if section.code == "M":
        return tw, b - tw
    return 0.0, 0.0


def _behind_hole(cut: Cut, section: Section) -> Iterator[Cut]:
    """Material that a drill removes from the root fillet behind the wall."""
    r, wall = section.radius, cut.wall
    if r <= 0 or section.code in ("M", "B"):
        return
    low, high = _between(wall, section)
    x0, q0, x1, q1 = cut.shape.bounds
    if high > low:  # the wall that fillets stand on: they lie at its edges
        if q0 < low + r or q1 > high - r:
            inner = cut.shape.intersection(rectangle(x0 - 1, low, x1 + 1, high))
            if pieces_of(inner):
                yield Cut(inner, wall, wall.low - r, wall.low)
                yield Cut(inner, wall, wall.high, wall.high + r)
        return
    others = [w for w in walls_of(section) if w.normal != wall.normal]
    if any(q0 < w.high + r and q1 > w.low - r for w in others):
        yield Cut(cut.shape, wall, wall.low - r, wall.low)
        yield Cut(cut.shape, wall, wall.high, wall.high + r)


def _hole(
    f: Hole | Slot, walls: dict[str, Wall], corners: dict[str, Sequence[Point] | None]
) -> Cut:
    wall = walls.get(f.face) or walls["v"]
    low, high = wall.low, wall.high
    if f.depth is not None:
        behind = f.face == "h" and wall.face == "v"
        from_high = wall.outer != behind
        if from_high:
            low = max(low, high - f.depth)
        else:
            high = min(high, low + f.depth)
    return Cut(polygon(outline_of(f), corners[wall.face]), wall, low, high)


def _bevel(
    contour: Contour, bevel: Bevel, wall: Wall, corners: Sequence[Point] | None
) -> Iterator[Cut]:
    """The wedge that a bevel takes along its edge, in layers."""
    from shapely import Point as Spot
    from shapely import Polygon

    (ax, ay), (bx, by) = contour.curves[bevel.curve].start, contour.curves[bevel.curve].end
    long = hypot(bx - ax, by - ay)
    nx, ny = -(by - ay) / long, (bx - ax) / long
    inside = polygon(contour.curves, corners).contains(
        Spot((ax + bx) / 2 + nx * BESIDE, (ay + by) / 2 + ny * BESIDE)
    )
    if inside != (contour.kind == "outer"):
        nx, ny = -nx, -ny
    deep = wall.thickness - bevel.land
    from_high = wall.outer == (bevel.angle > 0)
    for i in range(LAYERS):
        top, under = deep * i / LAYERS, deep * (i + 1) / LAYERS
        wide = tan(radians(abs(bevel.angle))) * (deep - (top + under) / 2)
        strip = Polygon(
            [(ax, ay), (bx, by), (bx + nx * wide, by + ny * wide), (ax + nx * wide, ay + ny * wide)]
        )
        if from_high:
            yield Cut(strip, wall, wall.high - under, wall.high - top)
        else:
            yield Cut(strip, wall, wall.low + top, wall.low + under)


def _abscissas(shape: Shape) -> list[float]:
    from shapely import get_coordinates

    found: list[float] = get_coordinates(shape)[:, 0].tolist()
    return found


def _lean(end: End, stock: Shape) -> list[float]:
    """Intersection of a leaning end with its stock."""
    from shapely import get_coordinates

    if end.a == 0.0 == end.b:
        return [end.c]
    z, y = get_coordinates(stock.simplify(1.0)).T
    xs = end.a * y + end.b * z + end.c
    return [*xs.tolist(), *np.linspace(xs.min(), xs.max(), LEAN_STEPS).tolist()]


def _behind(shape: Shape, end: End, x: float) -> Shape:
    """The part of a section at x behind an end."""
    from beamcam.readers.ifc.region import half_plane

    if end.a == 0.0 == end.b:
        return shape if end.side * (x - end.c) <= 1e-9 else rectangle(0, 0, 0, 0)
    z0, y0, z1, y1 = shape.bounds if not shape.is_empty else (0.0, 0.0, 0.0, 0.0)
    reach = [end.side * (end.x(y, z) - x) for y in (y0, y1) for z in (z0, z1)]
    if min(reach) >= 0:
        return shape
    if max(reach) <= 0:
        return rectangle(0, 0, 0, 0)
    # side (x - a y - b z - c) <= 0
    return shape.intersection(
        half_plane(end.side * end.b, end.side * end.a, end.side * (x - end.c))
    )


def _cuts_at(cuts: Sequence[Cut], xs: Numbers) -> list[list[Cut]]:
    """The cut-outs that each x goes through."""
    from shapely import bounds

    x0, _, x1, _ = bounds(np.array([cut.shape for cut in cuts], object)).reshape(-1, 4).T
    there = (x0 < xs[:, None]) & (xs[:, None] < x1)
    return [[cuts[k] for k in np.flatnonzero(row).tolist()] for row in there]


def _taken(cut: Cut, x: float) -> Iterator[Shape]:
    """Material that a cut removes from the section at x, which it goes through, as boxes (Z, Y)."""
    from shapely import LineString

    _, q0, _, q1 = cut.shape.bounds
    line = cut.shape.intersection(LineString([(x, q0 - 1.0), (x, q1 + 1.0)]))
    low, high = max(cut.low, -1e5), min(cut.high, 1e5)
    for piece in getattr(line, "geoms", (line,)):
        if piece.geom_type != "LineString" or piece.length < 1e-9:
            continue
        (_, qa), (_, qb) = piece.coords[0], piece.coords[-1]
        a, b = min(qa, qb), max(qa, qb)
        if cut.wall.normal == "z":  # q is Y, c is Z
            yield rectangle(low, a, high, b)
        else:
            yield rectangle(a, low, b, high)
