r"""Round tubes with slots, windows, saddles and copes: contours on the unrolled outside, face v.

   outside              The tube is a solid of fine facets, and less its cutters it leaves the
____     ____           steel of both surfaces. Their borders are unrolled: x along the tube, u
    \   /     wall      its arc from the lowest line towards v. The outside is what DSTV draws
_____\ /____            and a torch follows, square to the surface. How far the inside lies
   inside               beside it is told, and a cut that does not come out is refused.
"""

from collections.abc import Iterator, Sequence
from itertools import pairwise
from math import cos, pi, sin, sqrt
from typing import TYPE_CHECKING, Any

import numpy as np
import shapely
from msgspec import Struct
from msgspec.structs import replace
from shapely import Polygon
from shapely.geometry.polygon import orient

from beamcam.errors import BeamcamError, Source
from beamcam.geometry.array_types import Floats
from beamcam.model.part import Contour, Hole, Slot
from beamcam.readers.ifc import rules
from beamcam.readers.ifc.body import FAR
from beamcam.readers.ifc.cutters import Cutter, HalfSpace, Trim
from beamcam.readers.ifc.entities import Unreadable
from beamcam.readers.ifc.finish import Shaped, contour, hole_volume, sawn
from beamcam.readers.ifc.profiles import points_chain
from beamcam.readers.ifc.region import Shape, pieces_of
from beamcam.readers.ifc.section import Section
from beamcam.readers.ifc.solid_body import SAGITTA, cutter_solid, round_bar
from beamcam.readers.ifc.space import Frame, add, scale, sub
from beamcam.readers.ifc.stock import Stock
from beamcam.solid.kernel import facets, minus

if TYPE_CHECKING:
    from manifold3d import Manifold

CHORD = 8e-3  #: mm between a border of the solid and its contour
LEAST_OFF = 0.05  #: mm that the inside of a cut is off and say nothing
STEEPEST = 6.0  #: thicknesses of its wall that a cut goes on inside, at most: 80 degrees
NOISE = 0.02  #: mm; what is thinner is none of a wedge
TINY = 0.01  #: mm2 of a border round nothing
ALONG_SEAM = 0.02  #: slope of a side that may mean the seam
BESIDE_SEAM = 3.0  #: mm off it at which it may
ON_SEAM = 1e-6  #: mm
ON_PLANE = 0.01  #: mm that an end lies off its plane


class NearSeam(Exception):
    """Sides of an outline beside the seam, which all that take it put there: they mean it."""

    def __init__(self, at_rad: float) -> None:
        super().__init__()
        self.at_rad = at_rad  #: where the seam is away from all of them


class Surface(Struct, frozen=True):
    """Borders of the steel of one surface: rows of x and of the angle from the lowest line."""

    near: Floats  #: once round from the seam
    far: Floats
    windows: tuple[Floats, ...]

    def steel(self, radius: float, turns: Sequence[int] = (0,), ends: bool = True) -> Shape:
        """The steel in (x, u) on some turns, of another radius if its wall is to be compared."""
        scale, turn = (1.0, radius), 2 * pi * radius
        every = range(turns[0] - 1, turns[-1] + 2)
        near, far = (
            np.concatenate([loop[:-1] * scale + (0.0, k * turn) for k in every])
            for loop in (self.near, self.far)
        )
        whole: Shape = shapely.box(-FAR, turns[0] * turn, FAR, (turns[-1] + 1) * turn)
        if ends:
            whole = whole.intersection(Polygon([*near, *far[::-1]]).buffer(0))
        return whole.difference(self.open(radius, every))

    def open(self, radius: float, turns: Sequence[int]) -> Shape:
        """The windows on some turns."""
        scale, turn = (1.0, radius), 2 * pi * radius
        rows = (one * scale + (0.0, k * turn) for one in self.windows for k in turns)
        return shapely.union_all([Polygon(row).buffer(0) for row in rows])


def cut_tube(
    stock: Stock, ends: tuple[Trim, Trim], general: Sequence[Cutter],
    holes: Sequence[Hole | Slot], source: Source,
) -> Shaped:  # fmt: skip
    """The member that cutters beside its holes leave of a round tube. Raises Unreadable.

    An end without contours is that of its plane; where one has contours the outline draws both.
    """
    section = stock.section
    cutters = (*general, *(plane for end in ends for plane in end.planes))
    try:
        solid, outside, inside = _left(section, (stock.x0, stock.x1), cutters)
    except BeamcamError as reason:
        raise Unreadable(str(reason.diagnostics[0])) from reason
    plain = [_plane(end, loop, section) for end, loop in
             zip(ends, (outside.near, outside.far), strict=True)]  # fmt: skip
    drawn = None in plain
    off = _inside_off(outside, inside, section, drawn)
    square = [HalfSpace.at(side, float(pick(loop[:, 0]))) for side, pick, loop in
              ((-1, np.min, outside.near), (1, np.max, outside.far))]  # fmt: skip
    planes = [known or other for known, other in zip(plain, square, strict=True)]
    span = [side * end.reach if known else one.point[0] for side, end, known, one in
            zip((-1, 1), ends, plain, square, strict=True)]  # fmt: skip
    radius = section.height / 2
    contours = [
        contour("v", "inner", points_chain([(x, u) for x, u in ring.tolist()]), source)
        for ring in (one[::-1] * (1.0, radius) for one in outside.windows)
    ]
    if drawn:
        contours += [
            contour("v", "outer", points_chain([*orient(piece).exterior.coords][:-1]), source)
            for piece in pieces_of(replace(outside, windows=()).steel(radius))
        ]
        _look_at_seam(contours, radius)
    there = outside.steel(radius, (-1, 0, 1))
    holes = [h for h in holes if there.distance(shapely.Point(h.x, h.y)) < h.diameter / 2]
    n = facets(radius, SAGITTA)
    volume = float(solid.volume()) * (2 * pi / n) / sin(2 * pi / n) - hole_volume(section, holes)
    shaped = sawn(stock, (planes[0], planes[1]), (span[0], span[1]), [*contours, *holes], source,
                 volume)  # fmt: skip
    stays, takes = (f"{one:.2f}" for one in off)
    remark = rules.SQUARE_CUT.at(source, stays=stays, takes=takes)
    return replace(shaped, cutters=cutters, diagnostics=(remark,) if max(off) >= LEAST_OFF else ())


def _look_at_seam(contours: Sequence[Contour], radius: float) -> None:
    """Raise NearSeam where a side of an outline runs beside the seam, and not on it."""
    turn = 2 * pi * radius
    sides = [side for one in contours if one.kind == "outer" for side in one.curves]
    along = [
        side for side in sides
        if abs(side.end[1] - side.start[1]) < ALONG_SEAM * abs(side.end[0] - side.start[0])
    ]  # fmt: skip
    us = sorted({end[1] % turn for side in along for end in (side.start, side.end)
                 if ON_SEAM < end[1] < turn - ON_SEAM})  # fmt: skip
    if us and min(us[0], turn - us[-1]) < BESIDE_SEAM:
        gap, low = max((b - a, a) for a, b in pairwise([*us, us[0] + turn]))
        if gap < 2.1 * BESIDE_SEAM:
            raise Unreadable("cuts that leave no place for a seam", rules.ODD_CUT, final=True)
        raise NearSeam((low + gap / 2) / radius)


def turned(stock: Stock, at_rad: float) -> Stock:
    """The stock of a tube with its seam elsewhere: it has no side that would be its lowest."""
    c, s, f = cos(at_rad), sin(at_rad), stock.frame
    y, z = sub(scale(f.y, c), scale(f.z, s)), add(scale(f.y, s), scale(f.z, c))
    off = scale(sub(add(f.y, f.z), add(y, z)), stock.section.height / 2)
    return replace(stock, frame=Frame(add(f.o, off), f.x, y, z))


def _plane(end: Trim, loop: Floats, section: Section) -> HalfSpace | None:
    """The one plane that an end lies in."""
    if end.sole is None:
        return None
    radius, turned = section.height / 2, loop[:, 1]
    (a, b), c = end.sole.slopes, end.sole.x(0.0, 0.0)
    x = a * radius * (1 - np.cos(turned)) + b * radius * (1 + np.sin(turned)) + c
    return end.sole if np.abs(loop[:, 0] - x).max() < ON_PLANE else None


# --- borders --------------------------------------------------------------------------------------


def _left(
    section: Section, span: tuple[float, float], cutters: Sequence[Cutter]
) -> "tuple[Manifold, Surface, Surface]":
    """What cutters leave of a tube, and the steel of its outside and inside."""
    radius, n = section.height / 2, facets(section.height / 2, SAGITTA)
    radii = radius, radius - section.web_thickness
    bars = [
        round_bar(one, radius, n, span[0] - over, span[1] + over).as_original()
        for one, over in zip(radii, (1.0, 2.0), strict=True)
    ]
    solid = minus(bars[0] - bars[1], map(cutter_solid, cutters))
    mesh = solid.to_mesh64()
    ids = np.repeat(mesh.run_original_id, np.diff(mesh.run_index) // 3)
    places = mesh.vert_properties[:, :3]
    rows = np.column_stack((places[:, 0], np.arctan2(places[:, 2] - radius, radius - places[:, 1])))
    outside, inside = (
        _surface(rows, mesh.tri_verts[ids == bar.original_id()][:, ::way], one)
        for bar, way, one in zip(bars, (1, -1), radii, strict=True)
    )
    return solid, outside, inside


def _surface(rows: Floats, triangles: Any, radius: float) -> Surface:
    """The borders of the steel of a surface by the corners of its facets, steel on their left."""
    ends, windows, pieces = list[Floats](), list[Floats](), 0
    for corners in _loops(triangles):
        loop = rows[[*corners, corners[0]]].copy()
        loop[:, 1] = np.unwrap(loop[:, 1])
        if abs(loop[-1, 1] - loop[0, 1]) > pi:
            loop = _from_seam(loop if loop[-1, 1] > loop[0, 1] else loop[::-1])
            ends.append(_simple(loop, radius))
            continue
        x, u = (loop - loop[0]).T
        twice = float((x[:-1] * u[1:] - x[1:] * u[:-1]).sum()) * radius
        pieces += twice > 2 * TINY
        if twice < -2 * TINY:
            middle = (loop[:, 1].min() + loop[:, 1].max()) / 2
            loop = loop[:-1] - (0.0, 2 * pi * np.floor(middle / (2 * pi)))
            # from a place that no side runs through
            far = np.hypot(*((loop - loop.mean(axis=0)) * (1.0, radius)).T).argmax()
            loop = np.roll(loop, -int(far), axis=0)
            windows.append(_simple(np.concatenate((loop, loop[:1])), radius)[:-1])
    if not ends or pieces or len(ends) > 2:
        found = "pieces" if ends else "the tube open from end to end"
        raise Unreadable(f"cuts that leave {found}", rules.ODD_CUT, final=True)
    near, far_end = sorted(ends, key=lambda loop: float(loop[:, 0].mean()))
    return Surface(near, far_end, tuple(windows))


def _simple(line: Floats, radius: float) -> Floats:
    """A line on a surface with as few places as its chord allows, its ends where they are."""
    drawn = shapely.LineString(line * (1.0, radius)).simplify(CHORD)
    points: Floats = shapely.get_coordinates(drawn) / (1.0, radius)
    return points


def _loops(triangles: Any) -> Iterator[list[int]]:
    """The borders of triangles as rings of corners."""
    sides = np.concatenate([triangles[:, [k, (k + 1) % 3]] for k in range(3)]).tolist()
    there = {(a, b) for a, b in sides}
    following: dict[int, list[int]] = {}
    for a, b in sides:
        if (b, a) not in there:
            following.setdefault(a, []).append(b)
    while following:
        first = place = next(iter(following))
        ring: list[int] = []
        while place != first or not ring:
            ring.append(place)
            *rest, after = following.pop(place)
            if rest:
                following[place] = rest
            place = after
        yield ring


def _from_seam(loop: Floats) -> Floats:
    """A border that goes once round, from the seam on."""
    loop = loop[:-1].copy()
    first = int(np.abs(np.remainder(loop[:, 1] + pi, 2 * pi) - pi).argmin())
    loop = np.concatenate((loop[first:], loop[: first + 1] + np.array((0.0, 2 * pi))))
    loop[:, 1] -= 2 * pi * np.round(loop[0, 1] / (2 * pi))
    loop[[0, -1], 1] = 0.0, 2 * pi
    return loop


# --- outside and inside ---------------------------------------------------------------------------


def _inside_off(
    outside: Surface, inside: Surface, section: Section, ends: bool
) -> tuple[float, float]:
    """mm that stay inside of a wall cut square to its outside, and that go there, at most.

    Raises Unreadable for what does not go through the wall.
    """
    radius, wall = section.height / 2, section.web_thickness
    inner = radius - wall
    turn, longest = 2 * pi * inner, max(sqrt(radius**2 - inner**2), STEEPEST * wall)
    whats = "a cut into the wall from inside", "a cut that does not go through the wall"
    for these, other, what in ((outside, inside, whats[1]), (inside, outside, whats[0])):
        those = other.open(inner, (-1, 0, 1))
        for one in these.windows:
            window = Polygon(one * (1.0, inner)).buffer(0)
            met = [p for p in pieces_of(those) if p.intersects(window)]
            if len(met) != 1:
                found = "a cut-out that is one outside and several inside" if met else what
                raise Unreadable(found, rules.ODD_CUT, final=True)
    steel = [one.steel(inner, (-1, 0, 1), ends) for one in (outside, inside)]
    low, high = outside.near[:, 0].min(), outside.far[:, 0].max()
    strip = shapely.box(low, -turn, high, 2 * turn)
    gone = [strip.difference(one) for one in steel]
    once = shapely.box(low - FAR, 0.0, high + FAR, turn)
    shapely.prepare([*steel, *gone])
    off = []
    for k, what in enumerate(whats):
        wedge = steel[k].difference(steel[1 - k]).intersection(once)
        wedge = wedge.buffer(-NOISE / 2).buffer(NOISE / 2)
        places = shapely.points(shapely.get_coordinates(wedge))
        if len(places) and not shapely.distance(places, gone[k]).max() < longest:
            raise Unreadable(what, rules.ODD_CUT, final=True)
        away = steel[0] if k else gone[0]
        off.append(float(shapely.distance(places, away).max(initial=0.0)))
    return off[0], off[1]
