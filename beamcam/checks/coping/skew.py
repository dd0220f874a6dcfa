"""The skew ends of a bar, worked out from its header and outlines for the read-back alone.

An end is the plane x = c - y tan(web) - z tan(flange) through the outermost corner of the section,
which lies at x 0 or at the length. A torch that tilts makes it; else it is cut square to each wall
where the wall reaches farthest, and at one x all through a root.
"""

from collections.abc import Collection, Iterator, Mapping, Sequence
from math import atan, cos, degrees, hypot, inf, radians, sin, tan
from typing import Any

from msgspec import Struct
from shapely import LineString, Polygon, box, union_all

from beamcam.checks.coping import rules
from beamcam.checks.coping.section import CoperSection, areas_of
from beamcam.errors import Diagnostic
from beamcam.geometry.curves import Line
from beamcam.geometry.plane import Point
from beamcam.machine.coper import Coper
from beamcam.model.part import Bevel, Contour, EndPlane, Feature, Part

Shape = Any  #: of shapely

SQUARE_DEG = 0.2  #: of an end; a smaller angle is none
DRAWN = 1.0  #: mm that an outline may be off an end and mean it
AT_EDGE = 1.0  #: mm from the edges of its face within which a side of an outline ends on them
ON_PLANE = 0.05  #: mm between an edge and the end that it lies on
BARELY = 1.0  #: mm of an edge that are nothing
STEEP_DEG = 30.0  #: of an end, from which on a square step of its cut goes on until it meets it
FAR = 1e5
STATED = 0.1  #: mm that a plane may lie inside of the end that it states once more


class SkewEnd(Struct, frozen=True):
    """An end of a bar that is not square: x(y, z) = c - y by_y - z by_z."""

    side: int  #: -1 at the start
    c: float
    by_y: float
    by_z: float

    def x(self, y: float, z: float) -> float:
        return self.c - y * self.by_y - z * self.by_z

    def on(self, face: str, section: CoperSection, depth: float) -> tuple[float, float]:
        """x on a surface so far below that of a wall: at y 0, and how much more at y 1."""
        if face == "v":
            return self.x(0.0, section.front - depth), -self.by_y
        return self.x(section.high - depth if face == "o" else depth, 0.0), -self.by_z

    def on_wall(self, face: str, section: CoperSection, depth: float | None = None) -> "EndOnWall":
        """Where it meets a surface so far below that of a wall, or at its outermost."""
        depths = (0.0, section.thickness(face)) if depth is None else (depth,)
        surfaces = [self.on(face, section, deep) for deep in depths]
        at, more = max(surfaces, key=lambda one: self.side * one[0])
        apart = section.thickness(face) * tan(radians(self.leans(face)))
        return EndOnWall(self.side, at, more, apart)

    def farthest(self, ys: Sequence[float], zs: Sequence[float]) -> float:
        return self.side * max(self.side * self.x(y, z) for y in ys for z in zs)

    def leans(self, face: str) -> float:
        """By how many degrees it leans over a wall."""
        return abs(degrees(atan(self.by_z if face == "v" else self.by_y)))


def skew_ends(part: Part, section: CoperSection) -> tuple[SkewEnd | None, SkewEnd | None]:
    """The ends of a part as it lies that are not square."""
    skew_ends: list[SkewEnd | None] = []
    flanges = ("o", "u") if section.has_upper else ("u",)
    for k, (web, flange) in enumerate(
        ((part.cuts.web_start, part.cuts.flange_start), (part.cuts.web_end, part.cuts.flange_end))
    ):
        if abs(web) <= SQUARE_DEG:
            web = next((d for d in (_drawn(part, f, section.high, k) for f in "vh")
                        if d is not None), 0.0)  # fmt: skip
        if abs(flange) <= SQUARE_DEG:
            seen = [_drawn(part, f, section.wide, k) for f in flanges]
            known = [d for d in seen if d is not None]
            same = len(known) == len(flanges) and max(known) - min(known) <= SQUARE_DEG
            flange = known[0] if same else 0.0
        web, flange = (deg if abs(deg) > SQUARE_DEG else 0.0 for deg in (web, flange))
        skew_ends.append(end_of(part, section, k, web, flange) if web or flange else None)
    return skew_ends[0], skew_ends[1]


def end_of(part: Part, section: CoperSection, k: int, web: float, flange: float) -> SkewEnd:
    """The start or, for k 1, the end of a part by its angles in degrees."""
    by_y, by_z = tan(radians(web)), tan(radians(flange))
    corners = [y * by_y + z * by_z for y, z in section.outermost]
    c = part.length + min(corners) if k else max(corners)
    return SkewEnd(1 if k else -1, c, by_y, by_z)


def plane_faults(
    part: Part, section: CoperSection, ends: tuple[SkewEnd | None, SkewEnd | None],
    left: Collection[int],
) -> Iterator[Diagnostic]:  # fmt: skip
    """An error for each plane that takes steel of a part as it lies; `left` are not made.

    A part begins and ends by its outlines where each of its walls has one, else by its header.
    """
    outlines = [c for c in part.contours if c.kind == "outer" and c.process == "cut"]
    faces = {one.face.replace("h", "v") for one in outlines}
    xs = [x for one in outlines for curve in one.curves for x in curve.bbox[::2]]
    least, most = -inf, inf
    if faces.issuperset(("v", "o", "u") if section.has_upper else ("v", "u")):
        least, most = min(xs), max(xs)
    for k, plane in enumerate(part.features):
        if not isinstance(plane, EndPlane) or k in left:
            continue
        size = hypot(*plane.normal)
        a, b, c = (n / size for n in plane.normal)
        out = max(
            a * (min(max(x, least), most) - plane.point[0])
            + b * (y - plane.point[1]) + c * (z - plane.point[2])
            for y, z in section.outermost
            for square, end in zip((0.0, part.length), ends, strict=True)
            for x in (end.x(y, z) if end else square,)
        )  # fmt: skip
        if out > STATED:
            yield rules.PLANE.at(plane.source, found=f"{out:.3g}")


def _drawn(part: Part, face: str, wide: float, k: int) -> float | None:
    """The angle of the side of an outline that goes from edge to edge at an end."""
    lines = None
    for contour in part.contours:
        if contour.face != face or contour.kind != "outer" or contour.process != "cut":
            continue
        xs = [curve.start[0] for curve in contour.curves]
        for curve in contour.curves:
            if not isinstance(curve, Line):
                continue
            (x0, y0), (x1, y1) = curve.start, curve.end
            if y0 > y1:
                x0, y0, x1, y1 = x1, y1, x0, y0
            is_end = (x0 + x1) / 2 > sum(xs) / len(xs)
            if y0 <= AT_EDGE and y1 >= wide - AT_EDGE and is_end == bool(k):
                lines = degrees(atan((x0 - x1) / (y1 - y0)))
    return lines


class EndOnWall(Struct, frozen=True):
    """Where an end meets a surface of a wall: x = at + more y."""

    side: int
    at: float
    more: float
    apart: float  #: mm between where it meets the two surfaces of the wall

    def x(self, y: float) -> float:
        return self.at + self.more * y

    def moved(self, place: Point) -> Point:
        """A place of an outline; one that is drawn at the end lies on it."""
        x, y = place
        return (self.x(y), y) if abs(x - self.x(y)) <= DRAWN + self.apart else place

    def step(self, low: float, high: float, x: float) -> Shape:
        """What lies between it and an x beyond it, of a band from low to high."""
        a, b = ((self.x(y) - self.side * AT_EDGE, y) for y in (low, high))
        c, d = ((self.side * max(self.side * x, self.side * self.x(y)), y) for y in (low, high))
        return Polygon([a, c, d, b])

    @property
    def beyond(self) -> Shape:
        """What lies beyond it."""
        low, high = -FAR / 100, FAR / 100
        return Polygon([
            (self.x(low), low), (self.x(high), high),
            (self.side * FAR, high), (self.side * FAR, low),
        ])  # fmt: skip


def ends_on(
    ends: Sequence[SkewEnd | None], tilted: Sequence[bool], face: str, section: CoperSection,
    depth: float,
) -> list[EndOnWall]:  # fmt: skip
    """Where the skew ends meet a surface of a wall, those that are cut square the uppermost one."""
    return [
        end.on_wall(face, section, depth if is_tilted_to else 0.0)
        for end, is_tilted_to in zip(ends, tilted, strict=True) if end is not None
    ]  # fmt: skip


def _edge_on(
    end: SkewEnd, face: str, drawn: Shape, section: CoperSection, band: tuple[float, float]
) -> tuple[float, float]:
    """How much of a wall's edge lies on an end, within a band of it, and how much could; in mm."""
    own = end.on_wall(face, section, 0.0)
    line = LineString([(own.x(y), y) for y in band])
    edge = drawn.boundary.intersection(box(-FAR, band[0], FAR, band[1]))
    return edge.intersection(line.buffer(ON_PLANE)).length, line.length


def is_tilted(
    end: SkewEnd, drawn: Mapping[str, Shape], section: CoperSection, coper: Coper, near: float
) -> bool:
    """Whether a machine has to tilt its torch to an end: each wall that it leans over ends in it
    alone, within the torch's reach. `near` is how near it comes to a flange over the web."""
    for face, shape in drawn.items():
        lean, band = end.leans(face), (ON_PLANE, section.wide - ON_PLANE)
        if face == "v":
            low, high = section.web_ends
            band = low + near, high - (near if section.has_upper else ON_PLANE)
        there, all_of_it = _edge_on(end, face, shape, section, band)
        if there < BARELY or lean == 0.0:
            continue
        if lean > coper.tilt or there < all_of_it - BARELY:
            return False
        b = radians(lean)
        room = coper.torch_length * cos(b) - coper.head_width / 2 * sin(b) - coper.clearance
        if face == "v" and section.wide - section.front > room:
            return False
    return coper.tilt > 0.0


def as_square(
    end: SkewEnd, drawn: Mapping[str, Shape], section: CoperSection, coper: Coper,
    depths: Mapping[str, float],
) -> tuple[dict[str, Shape], dict[str, float], dict[str, list[Point]]]:  # fmt: skip
    """What stays of each wall whose end is cut square to it, how many mm that is too much, and the
    corners of its steps.

    `depths` are those to which the passes through the roots cut.
    """
    walls, off = dict(drawn), dict[str, float]()
    steps: dict[str, list[Point]] = {face: [] for face in drawn}
    for face, shape in drawn.items():
        band = section.extent(face)
        if _edge_on(end, face, shape, section, (band[0] + 2.0, band[1] - 2.0))[0] >= BARELY:
            thick = section.thickness(face)
            off[face] = thick * tan(radians(end.leans(face)))
            walls[face] = areas_of(shape.union(_up_to(end, face, shape, section)))
    for face in off if section.lip else ():
        if face != "v":
            band = 0.0, section.beside_lip(coper)
            more, at_lip = _as_long_as_lip(end, face, section, band)
            if at_lip:
                walls[face] = areas_of(walls[face].union(more))
                off[face] = max(off[face], at_lip[0])
                steps[face] += at_lip[1]
    for face in drawn:
        deep = depths.get(face, 0.0)
        if face == "v" or not deep or face not in off or "v" not in off:
            continue
        back, front = section.root(face)
        zs = back - ON_PLANE, front + ON_PLANE
        ys = (section.high - deep - ON_PLANE, section.high) if face == "o" else (
            0.0, deep + ON_PLANE)  # fmt: skip
        x = end.farthest(ys, (max(zs[0], 0.0), min(zs[1], section.wide)))
        for one, band, wide in ((face, zs, section.wide), ("v", ys, section.high)):
            line = end.on_wall(one, section)
            low, high = max(band[0], 0.0), min(band[1], wide)
            off[one] = max(off[one], *(abs(x - line.x(y)) for y in (low, high)))
            if abs(line.more) > tan(radians(STEEP_DEG)):
                meets = (x - line.at) / line.more
                if end.side * line.more < 0.0 and low > ON_PLANE:
                    low = max(0.0, min(low, meets))
                if end.side * line.more > 0.0 and high < wide - ON_PLANE:
                    high = min(wide, max(high, meets))
            steps[one] += [(line.x(y), y) for y in (low, high)]
            walls[one] = areas_of(walls[one].union(line.step(low, high, x)))
    return walls, off, steps


def _as_long_as_lip(
    end: SkewEnd, face: str, section: CoperSection, band: tuple[float, float]
) -> tuple[Shape, tuple[float, list[Point]] | None]:
    """What a flange keeps beyond an end that is cut square to it, where a pass takes its lip too
    and the lip reaches farther; by how many mm, and where that ends."""
    ys = (section.high - section.lip, section.high) if face == "o" else (0.0, section.lip)
    x = end.farthest(ys, (0.0, section.bend))
    line = end.on_wall(face, section)
    far = max(end.side * (x - line.x(z)) for z in band)
    if far <= ON_PLANE / 2:
        return Polygon(), None
    low, high = band
    meets = (x - line.at) / line.more if end.side * line.more > 0.0 else FAR
    if meets < high:
        high = meets
    elif abs(line.more) > tan(radians(STEEP_DEG)):
        high = min(section.wide, meets) if meets < FAR else high
    return line.step(low, high, x), (far, [(line.x(high), high)])


def _up_to(end: SkewEnd, face: str, shape: Shape, section: CoperSection) -> Shape:
    """What a wall has more of where it is cut square at the outermost of its end."""
    there, own = end.on_wall(face, section), end.on_wall(face, section, 0.0)
    ys = -1.0, (section.high if face == "v" else section.wide) + 1.0
    line = LineString([(own.x(y), y) for y in ys])
    edge = shape.boundary.intersection(line.buffer(ON_PLANE))
    areas = []
    for one in getattr(edge, "geoms", (edge,)):
        _, y0, _, y1 = one.bounds if not one.is_empty else (0.0, 0.0, 0.0, 0.0)
        if y1 - y0 > 2 * ON_PLANE:
            inside = end.side * -ON_PLANE
            areas.append(Polygon([
                (own.x(y0) + inside, y0), (there.x(y0), y0), (there.x(y1), y1),
                (own.x(y1) + inside, y1),
            ]))  # fmt: skip
    return union_all(areas)


def own_bevels(feature: Feature, ends: Sequence[SkewEnd | None], least: float) -> Iterator[Bevel]:
    """The bevels of a contour that no tilted end makes by itself."""
    for bevel in feature.bevels if isinstance(feature, Contour) else ():
        face = "v" if getattr(feature, "face", "") in "vh" else "u"
        leans = [end.leans(face) for end in ends if end is not None]
        if abs(bevel.angle) >= least and all(
            abs(abs(bevel.angle) - lean) > SQUARE_DEG for lean in leans
        ):
            yield bevel
