r"""Shapes on the unrolled outside of a tube, as solids that go into its wall, and the way back.

   _____              u is the way round from the middle of the lowest line towards v, x runs along
 /       \     v      the axis; depth counts inwards from the surface, square to it. A tube is a
|    +    |           rectangle with a round of one radius about it, of a round tube no more than
 \ _____ /            the axis.
     u = 0

A rectangular tube as a torch leaves it that stands square to its surface.

farthest   what is drawn, seen square to the surface: of an end that is skew through a wall the
           place where the wall reaches farthest
corners    lines that lean on a face go on over the round of its corner; both faces beside it
           have them, and at x = a + b - edge they meet
"""

from collections.abc import Iterator, Sequence
from functools import partial
from itertools import pairwise
from math import acos, asin, ceil, copysign, cos, floor, pi, radians, sin
from typing import TYPE_CHECKING, Any

import numpy as np
from msgspec.structs import replace
from shapely import LineString, Polygon, box, clip_by_rect, transform, union_all
from shapely.affinity import translate

from beamcam.geometry.array_types import Floats
from beamcam.geometry.curves import Curve, Line
from beamcam.model.part import Contour, EndPlane, Face, Feature, Part, Slot
from beamcam.solid.cutters import OUTLINE_NOISE, slot_shape, taken
from beamcam.solid.kernel import CHORD, FREE, extruded, kernel, minus, no_solid
from beamcam.solid.stock_solid import Margins, Shape, end_planes, is_cut, shape_of, stock_solid

if TYPE_CHECKING:
    from manifold3d import Manifold

STRIP_RAD = radians(6.0)
SEAM_NOISE = 2.5  #: mm that the long sides of an outline may lie off the seam
LAP = 1e-3  #: mm by which strips of one shape lie over each other, so that none comes apart


class Skin:
    """The outside of a tube, by its section's height and width and the radius of its corners."""

    def __init__(self, height: float, width: float, radius: float) -> None:
        self.radius = radius
        self.half_y, self.half_z = height / 2, width / 2
        y, z = self._inner = max(0.0, height / 2 - radius), max(0.0, width / 2 - radius)
        arc = radius * pi / 2
        #: where faces and corners begin, from the middle of the lowest line on, and where all ends
        self.borders = np.cumsum([0.0, z, arc, 2 * y, arc, 2 * z, arc, 2 * y, arc, z])
        self.turn = float(self.borders[-1])
        self._turned = np.array([0, 0, 1, 1, 2, 2, 3, 3, 4, 4]) * pi / 2
        self._y = np.array([-y, -y, -y, y, y, y, y, -y, -y, -y])
        self._z = np.array([0.0, z, z, z, z, -z, -z, -z, -z, 0.0])

    def bent(self, points: Any) -> Floats:
        """Rows of (x, u, outwards) in the section's axes (x, Y, Z)."""
        x, u, out = points.T
        u = np.mod(u, self.turn)
        turned, from_inner = np.interp(u, self.borders, self._turned), self.radius + out
        y = np.interp(u, self.borders, self._y) - from_inner * np.cos(turned)
        z = np.interp(u, self.borders, self._z) + from_inner * np.sin(turned)
        return np.column_stack((x, y + self.half_y, z + self.half_z))

    def unbent(self, points: Any, first: float, last: float) -> Floats:
        """Rows of (x, Y, Z) as (x, u, outwards) of a strip from one u to another."""
        x, y, z = points.T
        middle = (first + last) / 2 % self.turn
        at_y = np.interp(middle, self.borders, self._y)
        at_z = np.interp(middle, self.borders, self._z)
        turned = float(np.interp(middle, self.borders, self._turned))
        y, z = y - self.half_y - at_y, z - self.half_z - at_z
        # along the surface and out of it, by the normal in the middle of the strip
        along, away = y * sin(turned) + z * cos(turned), z * sin(turned) - y * cos(turned)
        if self.is_flat(first, last):
            return np.column_stack((x, (first + last) / 2 + along, away - self.radius))
        u = (first + last) / 2 + self.radius * np.arctan2(along, away)
        return np.column_stack((x, u, np.hypot(along, away) - self.radius))

    def is_flat(self, first: float, last: float) -> bool:
        middle = (first + last) / 2 % self.turn
        k = int(np.searchsorted(self.borders, middle)) - 1
        return bool(self._turned[k] == self._turned[k + 1])

    def place(self, y: float, z: float, a_deg: float) -> tuple[float, float, float]:
        """u below a tip at Y and Z from the axis while the tube has turned by A, its height over
        the surface, and how far it stands beside the normal there."""
        c, s = cos(radians(a_deg)), sin(radians(a_deg))
        y, z = c * y - s * z, s * y + c * z
        at_y, at_z = (min(max(v, -most), most) for v, most in zip((y, z), self._inner, strict=True))
        away, beside = (z - at_z) * c - (y - at_y) * s, (z - at_z) * s + (y - at_y) * c
        quarter = round((90.0 - a_deg) / 90.0)
        flats = quarter * sum(self._inner) + (at_z, at_y, -at_z, -at_y)[quarter % 4]
        return flats + self.radius * radians(90.0 - a_deg), away - self.radius, beside

    def seen(self, face: Face, q: float, deep: float = 0.0) -> tuple[float, int, bool]:
        """u of a place seen square to a face, so deep in the round of a corner; 1 where u rises
        with q and -1 where it falls; whether it lies on such a round."""
        k = "uvoh".index(face)
        half, way = (self.half_y if k % 2 else self.half_z), (1 if k < 2 else -1)
        flat, off = half - self.radius, q - half
        middle = k * (sum(self._inner) + self.radius * pi / 2)
        beyond, on = abs(off) - flat, abs(off)
        if beyond > 0.0:
            on = flat + self.radius * asin(min(beyond / (self.radius - deep or beyond), 1.0))
        return middle + way * copysign(on, off), way, beyond > LAP

    def strips(self, low: float, high: float, most_rad: float) -> Iterator[tuple[float, float]]:
        """Stretches of u, on corners so short that they turn by an angle at most."""
        turns = range(floor(low / self.turn), ceil(high / self.turn) + 1)
        inner = [
            at for k in turns for at in (self.borders[:-1] + k * self.turn).tolist()
            if low + LAP < at < high - LAP
        ]  # fmt: skip
        for first, last in pairwise([low, *inner, high]):
            if last - first < LAP:
                continue
            flat = self.is_flat(first, last)
            count = 1 if flat else ceil((last - first) / (self.radius * most_rad) - 1e-9)
            for k in range(count):
                yield tuple(first + (last - first) * (k + one) / count for one in (0, 1))


def skin_of(part: Part) -> tuple[Skin, float]:
    """The outside of a round or rectangular tube, and its wall.

    Raises BeamcamError where it is none, or is a rectangular one whose corners have no radius.
    """
    profile = part.profile
    wall = max(profile.flange_thickness, profile.web_thickness or 0.0)
    high, wide, radius = profile.height, profile.width, profile.radius
    if profile.code == "RO":
        wide, radius = high, high / 2
    if profile.code not in ("RO", "M") or not 0.0 < wall <= min(high, wide) / 2 or radius <= 0.0:
        raise no_solid(part, f"a surface to go round of {profile.name}")
    return Skin(high, wide, min(radius, high / 2, wide / 2)), wall


def wrapped(shape: Shape, skin: Skin, low: float, high: float) -> "Manifold":
    """A shape in (x, u) of the surface as a solid from one depth to another.

    It is made of strips along x, whose sides lie where they should; between them an edge is off by
    their angle's third power, 0.003 mm at 136 mm. They begin in the air in front of the surface, so
    that their chords do not come below it. At a corner they go no deeper than its middle.
    """
    m, radius = kernel(), skin.radius
    if shape.is_empty:
        return m.Manifold()
    x0, u0, x1, u1 = shape.bounds
    air = acos(min(1.0, (radius + FREE / 2) / max(radius - low, radius + FREE / 2)))
    strips = []
    for first, last in skin.strips(u0, u1, min(STRIP_RAD, 2 * max(air, STRIP_RAD / 10))):
        strip = clip_by_rect(shape, x0 - 1.0, first - LAP, x1 + 1.0, last + LAP)
        deep = high if skin.is_flat(first, last) else min(high, 0.999 * radius)
        strips.append(extruded(strip, -deep, -low).warp_batch(skin.bent))
    return m.Manifold.batch_boolean(strips, m.OpType.Add)


def unrolled(body: "Manifold", skin: Skin, deep: float) -> Shape:
    """A wall `deep` at most as it is seen square to the surface, in (x, u) of one turn."""
    low, high = body.bounding_box()[0] - FREE, body.bounding_box()[3] + FREE
    seen = []
    for first, last in skin.strips(0.0, skin.turn, STRIP_RAD):
        region = wrapped(box(low, first, high, last), skin, -FREE, deep)
        flat = (body ^ region).warp_batch(partial(skin.unbent, first=first, last=last))
        for one in flat.project().decompose():
            outer, *holes = (ring for ring in one.to_polygons() if len(ring) > 2)
            seen.append(Polygon(outer, holes).buffer(0))
    return union_all(seen)


def outline_gone(part: Part, margin: float = 0.0) -> Shape:
    """What outlines of a tube leave out of its surface, in (x, u) of one turn; or nothing."""
    turn = skin_of(part)[0].turn
    outlines = [one for one in part.contours if one.kind == "outer" and is_cut(one)]
    gone = box(-FREE, 0.0, part.length + FREE, turn) if outlines else Polygon()
    for one in outlines:
        on_seam = partial(_on_seam, one.curves, turn, part.length / 2)
        steel = transform(shape_of(one.curves), on_seam)
        gone = gone.difference(steel.buffer(0))
    if margin and outlines:
        gone = all_round(gone, turn).buffer(margin, join_style="mitre")
        gone = gone.intersection(box(-FREE, 0.0, part.length + FREE, turn))
    return gone


def _on_seam(curves: Sequence[Curve], turn: float, long: float, points: Any) -> Any:
    """Corners of an outline, the ends of its sides along the seam on it."""
    points = points.copy()
    for side in curves:
        if isinstance(side, Line):
            for seam in (0.0, turn):
                ends = np.array([side.start, side.end])
                rise, run = np.ptp(ends[:, 1]), np.ptp(ends[:, 0])
                most = SEAM_NOISE if run >= long else OUTLINE_NOISE
                if abs(ends[:, 1] - seam).max() <= most and rise <= 0.02 * run:
                    for end in ends:
                        points[np.hypot(*(points - end).T) < CHORD, 1] = seam
    return points


def all_round(shape: Shape, turn: float) -> Shape:
    """A shape of one turn on that turn, the one before it and the one behind it."""
    return union_all([translate(shape, 0.0, k * turn) for k in (-1, 0, 1)])


def round_cutters(feature: Slot | Contour, part: Part, margins: Margins) -> Iterator["Manifold"]:
    """What a slot or a contour takes of a tube, square to its surface; bevels are not there."""
    if feature.face != "v":
        raise no_solid(part, f"a {type(feature).__name__.lower()} on face {feature.face}")
    skin, wall = skin_of(part)
    depth = wall + FREE
    if isinstance(feature, Slot):
        shape = slot_shape(feature, margins.radius(feature.diameter))
        depth = depth if feature.depth is None else feature.depth + margins.depth
    elif feature.kind == "outer":
        if feature is not next(c for c in part.contours if c.kind == "outer" and is_cut(c)):
            return  # all of them take the same
        shape = outline_gone(part, margins.outline)
    else:
        shape = shape_of(feature.curves).buffer(margins.outline, join_style="mitre")
    yield wrapped(shape, skin, -FREE, depth)


FAR = 1e4  #: mm beyond a part
LEVELS = 33  #: places across a corner
#: The faces beside each corner on the way round, and whether it is at the greatest y of each.
CORNERS: tuple[tuple[Face, bool, Face, bool], ...] = (
    ("u", True, "v", False), ("v", True, "o", True), ("o", False, "h", True),
    ("h", False, "u", False),
)  # fmt: skip


def square_to_surface(
    least: "Manifold", most: "Manifold", part: Part, smallest: Margins
) -> "tuple[Manifold, Manifold]":
    """The least and the most steel of a part whose walls are cut square to their surface."""
    skin, wall = skin_of(part)
    shape = unrolled(most, skin, wall + FREE)
    slack = -smallest.end
    gone = []
    leaning = _leaning(part, skin) if part.profile.code == "M" else ()
    for first, last, steel, middle in leaning:
        band = box(middle[0], first, middle[1], last)
        grown = steel.buffer(slack, join_style="mitre").intersection(band)
        shape = shape.difference(band).union(grown)
        gone.append(band.difference(steel.buffer(-slack, join_style="mitre")))
    endless = replace(smallest, end=-FAR)
    most = wrapped(shape, skin, -FREE, wall + FREE) ^ stock_solid(part, endless)
    return minus(least, [wrapped(one, skin, -FREE, wall + FREE) for one in gone]), most


def skew_ends(part: Part) -> int:
    """How many ends are skew through a wall, by the header, drawn or planes of their own."""
    drawn = part.profile.code == "M"  # the outline of a round one is that of its surface
    own = (f.normal for f in part.features if isinstance(f, EndPlane))
    normals = (*own, *(normal for _, normal in end_planes(part, drawn=drawn)))
    return len({n[0] > 0.0 for n in normals if n[1] or n[2]})


def _leaning(part: Part, skin: Skin) -> Iterator[tuple[float, float, Shape, tuple[float, float]]]:
    """Corners with lines that lean on a face beside them: u from and to, the steel in (x, u) with a
    margin of u, and from which x to which it counts, as planes of ends are no lines of faces."""
    r = skin.radius
    steel = {
        face: drawn_steel([f for f in part.features if getattr(f, "face", "") == face],
                          part.length, part.profile.face_width(face))
        for face in ("u", "v", "o", "h")
    }  # fmt: skip
    turns = np.linspace(0.0, pi / 2, LEVELS)
    planes = [*end_planes(part, drawn=True)]
    for k, (a, a_high, b, b_high) in enumerate(CORNERS):
        of_a = _lines(steel[a], part.profile.face_width(a), a_high, r * (1 - np.sin(turns)))
        of_b = _lines(steel[b], part.profile.face_width(b), b_high, r * (1 - np.cos(turns)))
        if of_a is None or of_b is None or of_a.shape != of_b.shape:
            continue
        # Where a cope has taken an end off, its line is no plane's.
        edge = part.profile.height * ("o" in (a, b)), part.profile.width * ("v" in (a, b))
        is_plane = [
            bool(n[1] or n[2]) and min(abs(of_a[-1][j] - x), abs(of_b[0][j] - x)) <= OUTLINE_NOISE
            for j, ((at, _, _), n) in zip((0, -1), planes, strict=True)
            for x in (at - (n[1] * edge[0] + n[2] * edge[1]) / n[0],)
        ]
        inner = slice(1 if is_plane[0] else 0, -1 if is_plane[1] else None)
        bent = 0.0
        for lines in (of_a[:, inner], of_b[:, inner]):
            jumps = (np.abs(np.diff(lines, axis=0)) > OUTLINE_NOISE).any(axis=0)
            bent = max(bent, float(np.ptp(lines[:, ~jumps], axis=0).max(initial=0.0)))
        if bent < CHORD:
            continue
        share = (turns / (pi / 2))[:, None]
        lines = of_a + of_b - ((1 - share) * of_b[0] + share * of_a[-1])
        low, high = -FAR, FAR
        if is_plane[0]:
            low, lines[:, 0] = float(lines[:, inner].min()) - OUTLINE_NOISE, -FAR
        if is_plane[1]:
            high, lines[:, -1] = float(lines[:, inner].max()) + OUTLINE_NOISE, FAR
        first, last = skin.borders[1 + 2 * k], skin.borders[2 + 2 * k]
        us = first + r * turns
        us[0], us[-1] = first - FREE, last + FREE
        shapes = [
            Polygon([*zip(lines[:, j], us, strict=True),
                     *zip(lines[::-1, j + 1], us[::-1], strict=True)]).buffer(0)
            for j in range(0, lines.shape[1], 2)
        ]  # fmt: skip
        yield float(first), float(last), union_all(shapes), (low, high)


def edges_on_rounds(part: Part, slack: float) -> "Iterator[Manifold]":
    """What may stay of a rectangular tube at lines of its contours that go along it in the round of
    a corner: they are cut square to the surface where the wall reaches farthest."""
    if part.profile.code != "M":
        return
    skin, wall = skin_of(part)
    for contour in part.contours:
        for side in contour.curves if is_cut(contour) else ():
            (x0, y0), (x1, y1) = side.start, side.end
            edges = min(abs(y0 - edge) for edge in (0.0, part.profile.face_width(contour.face)))
            if not isinstance(side, Line) or abs(y1 - y0) > CHORD or edges < OUTLINE_NOISE:
                continue
            seen = [skin.seen(contour.face, y0, deep) for deep in (0.0, wall)]
            if seen[0][2]:
                low, high = sorted(u for u, _, _ in seen)
                area = box(min(x0, x1), low, max(x0, x1), high).buffer(slack)
                yield wrapped(area, skin, -FREE, wall + FREE)


def drawn_steel(features: Sequence[Feature], length: float, wide: float) -> Shape:
    """What features leave of a wall, in (x, q) of its face."""
    outer = [f for f in features if isinstance(f, Contour) and f.kind == "outer" and is_cut(f)]
    steel: Shape = box(0.0, 0.0, length, wide)
    if outer:
        strip = box(-FAR, 0.0, FAR, wide)
        steel = union_all([shape_of(f.curves) for f in outer]).intersection(strip)
    return steel.difference(union_all([taken(f) for f in features]))


def _lines(steel: Shape, wide: float, at_high: bool, offs: Floats) -> Floats | None:
    """x of the lines of a face at places off its edge, along the part; None where one ends."""
    rows = []
    for off in np.clip(offs, CHORD / 2, wide - CHORD / 2):
        y = wide - off if at_high else off
        cut = steel.intersection(LineString([(-2 * FAR, y), (2 * FAR, y)]))
        pieces = [one for one in getattr(cut, "geoms", [cut]) if one.length > 0.0]
        rows.append(sorted(x for one in pieces for x in (one.bounds[0], one.bounds[2])))
    return np.array(rows) if rows[0] and len({len(row) for row in rows}) == 1 else None
