"""The ends of tubes, for the read-back alone: planes, and those of tubes that come cut.

Planes end a tube by themselves, whatever way they lean, or by the header of a round one. A torch
square to the surface cuts where the wall reaches farthest, at its outside or at its inside.

What is drawn on an end that is there is that end. A torch does not make it, so what is asked goes
on beyond it: from where its sides meet the end straight on, and along the tube from there.

    asked of a face   + air before the segments of it that lie on the end
    asked of all      = that on the surface, within the steel that comes
"""

from collections.abc import Callable, Collection, Iterator, Sequence
from itertools import pairwise
from math import atan, cos, degrees, hypot, pi, radians, sin, tan
from typing import Any

from msgspec import Struct
from shapely import LineString, Polygon, bounds, box, intersection, intersection_all, union_all
from shapely.affinity import translate

from beamcam.checks.coping.section import TubeSection
from beamcam.checks.coping.skew import DRAWN
from beamcam.checks.coping.stock import inside_of
from beamcam.geometry.plane import Point
from beamcam.model.part import Contour, EndPlane, Feature, Part

Shape = Any  #: of shapely
End = tuple[float, float, float]  #: x = first - second Y - third Z from the axis of the tube

PLACES = 240  #: of a plane across a corner, or a quarter of a round tube
SAME_DEG = 0.2  #: by which a plane and the header may differ and mean the same end
FAR = 1e5
SAME = 1e-6  #: mm
SQUARE_DEG = 0.2  #: of an end; less is noise
Xs = Callable[[float], tuple[float, ...]]  #: x of an end at a place across, on each surface

AIR = 60.0  #: mm beyond an end
PARALLEL = 0.02  #: mm along the tube by mm across it; what slopes more is a cut
SHORTEST = 3.0  #: mm across, of what lies on an end; less is where a curve comes to it


def planes_of(part: Part, left: Collection[int], section: TubeSection) -> Iterator[tuple[int, End]]:
    """The planes that end a part, with -1 or 1; `left` are features that are not made."""
    for index, feature in enumerate(part.features):
        if isinstance(feature, EndPlane) and feature.normal[0] and index not in left:
            (x, y, z), (a, b, c) = feature.point, feature.normal
            on_axis = x - (b * (section.half_y - y) + c * (section.half_z - z)) / a
            yield (1 if a > 0.0 else -1), (on_axis, b / a, c / a)


def is_stated(part: Part, side: int, web_deg: float, flange_deg: float) -> bool:
    """Whether a plane of the part is that of an end by its header."""
    for feature in part.features:
        if isinstance(feature, EndPlane) and feature.normal[0] * side > 0.0:
            a, b, c = feature.normal
            offs = degrees(atan(b / a)) - web_deg, degrees(atan(c / a)) - flange_deg
            if max(map(abs, offs)) <= SAME_DEG:
                return True
    return False


def surfaces_of(face: str, section: TubeSection) -> tuple[float, float]:
    """Where the outside and the inside of a wall lie, from the axis, along Y or along Z."""
    out = section.half_y if face in "ou" else section.half_z
    side = 1.0 if face in "vo" else -1.0
    return side * out, side * (out - section.wall)


def x_on(end: End, face: str, at: float, y: float, section: TubeSection) -> float:
    """x of a plane at a y of a face, on the surface that is `at` from the axis."""
    if face in "vh":
        return end[0] - end[1] * (y - section.half_y) - end[2] * at
    return end[0] - end[1] * at - end[2] * (y - section.half_z)


def round_corner(end: End, k: int, turns: Any, section: TubeSection, is_start: bool) -> Any:
    """x at which a plane is cut round a corner, so far into it as the normal has turned."""
    import numpy as np

    way = k * pi / 2 + turns  # of the normal, from -Y towards +Z
    y = section.flat_y * (1 if k in (1, 2) else -1)
    z = section.flat_z * (1 if k in (0, 1) else -1)
    xs = [
        end[0] - end[1] * (y - q * np.cos(way)) - end[2] * (z + q * np.sin(way))
        for q in (section.radius, section.radius - section.wall)
    ]
    return np.minimum(*xs) if is_start else np.maximum(*xs)


def kept(shape: Shape, side: int, end: End, section: TubeSection) -> Shape:
    """What stays of three turns of the surface behind a plane.

    Between two corners it is cut along a straight line.
    """
    import numpy as np

    turns = np.linspace(0.0, pi / 2, PLACES)
    xs = [round_corner(end, k, turns, section, side < 0) for k in range(4)]
    ss = [section.corner(k) + section.radius * turns for k in range(4)]
    x = np.tile(np.concatenate(xs), 5)
    s = np.concatenate([one + k * section.turn for k in range(-2, 3) for one in ss])
    # Of a round tube one corner ends where another begins.
    apart, away = np.diff(s, prepend=-np.inf) > SAME, -side * FAR
    x, s = x[apart], s[apart]
    behind = Polygon([(away, s[0]), *zip(x, s, strict=True), (away, s[-1])])
    return shape.intersection(behind.buffer(0))


def header_planes(part: Part, section: TubeSection) -> Iterator[tuple[int, End]]:
    """The skew ends of a round tube by its header: they touch x 0 or L at its outside."""
    cuts = part.cuts
    for side, x, web, flange in (
        (-1, 0.0, cuts.web_start, cuts.flange_start),
        (1, part.length, cuts.web_end, cuts.flange_end),
    ):
        rise, lean = (tan(radians(a)) if abs(a) > SQUARE_DEG else 0.0 for a in (web, flange))
        if rise or lean:
            yield side, (x - side * section.radius * hypot(rise, lean), rise, lean)


# --- tubes that come cut ------------------------------------------------------------------------


class TubeStock(Struct, frozen=True):
    """What a program begins with, on turns of the unrolled surface."""

    steel: Shape  #: with that where its holes are
    solid: Shape
    is_piece: bool
    apart: float = 0.0  #: mm along it that both surfaces of a wall end from one another, at most


def bar_of(trim: float, part: Part, turn: float) -> TubeStock:
    """The bar that a tube is cut from, of which once round is `turn` mm."""
    bar = box(-trim, -2 * turn, part.length + trim, 3 * turn)
    return TubeStock(bar, bar, False)


def piece_of(bare: Shape, worn: Shape, apart: float) -> TubeStock:
    """A piece whose ends are there, and its holes; an arc starts where all of its wall is, which at
    a skew end is so far from where the last of it is."""
    whole = [bare, translate(bare, apart, 0.0), translate(bare, -apart, 0.0)] if apart else [bare]
    return TubeStock(bare, worn.intersection(intersection_all(whole)), True, apart)


def is_end(feature: Feature) -> bool:
    """Whether it is an outline, or a plane that ends a part."""
    return isinstance(feature, EndPlane) or (
        isinstance(feature, Contour) and feature.kind == "outer"
    )


class FaceEnds(Struct, frozen=True):
    """The ends of a face that are there, or of a round tube all round."""

    start: Xs
    end: Xs
    length: float  #: of the part
    has_outline: bool = False

    @property
    def sides(self) -> tuple[tuple[int, Xs, float], ...]:
        """-1 and 1, where each end is, and an x in the air before it."""
        return (-1, self.start, -AIR), (1, self.end, self.length + AIR)

    def is_mouth(self, place: Point) -> bool:
        """Whether a side of an outline that comes to a place meets an end there."""
        x, y = place
        return any(min(side * at for at in xs(y)) - DRAWN <= side * x for side, xs, _ in self.sides)


class PieceAsked(Struct, frozen=True):
    """What a face is asked beyond."""

    steel: Shape  #: of the piece, on three turns
    faces: dict[str, FaceEnds]


def with_air(ring: Sequence[Point], ends: FaceEnds | None) -> Shape:
    """The inside of a ring, and the air before what of it lies on an end that is there."""
    shape = inside_of(ring)
    if ends is None:
        return shape
    count, more = len(ring), []
    for side, xs, air in ends.sides:
        # A side of a ring may lie on an end at either surface of the wall.
        on = [
            any(
                max(abs(xa - at_a), abs(xb - at_b)) <= DRAWN
                and abs((xb - at_b) - (xa - at_a)) <= PARALLEL * abs(yb - ya)
                for at_a, at_b in zip(xs(ya), xs(yb), strict=True)
            )
            for (xa, ya), (xb, yb) in pairwise((*ring, ring[0]))
        ]
        for k in range(count):
            if not on[k] or on[k - 1]:
                continue
            last = next(j for j in range(k, k + count) if not on[j % count])
            run = [ring[j % count] for j in range(k, last + 1)]
            if abs(run[-1][1] - run[0][1]) < SHORTEST:
                continue
            begin = _straight_on(ring[k - 1], run[0], side, xs)
            end = _straight_on(ring[(last + 1) % count], run[-1], side, xs)
            more.append(inside_of([*run, end, (air, end[1]), (air, begin[1]), begin]))
    return union_all([shape, *more]) if more else shape


def _straight_on(first: Point, last: Point, side: int, xs: Xs) -> Point:
    """Where a side that ends at `last` leaves the steel, as it goes straight on."""
    dx, dy = last[0] - first[0], last[1] - first[1]

    def before(place: Point) -> float:
        return max(side * x for x in xs(place[1])) - side * place[0]

    if before(last) <= SAME or side * dx <= PARALLEL * abs(dy):
        return last
    place, long = last, hypot(dx, dy)
    for _ in range(8):
        by = before(place) * long / abs(dx)
        place = place[0] + by * dx / long, place[1] + by * dy / long
    return place


def short_by(ring: Sequence[Point], ends: FaceEnds | None) -> float:
    """mm that a piece is too short for an outline; what a drawing may be off is nothing."""
    if ends is None:
        return 0.0
    off = max(
        side * x - max(side * at for at in xs(y)) for side, xs, _ in ends.sides for x, y in ring
    )
    return off if off > DRAWN else 0.0


def ends_of_shape(shape: Shape, low: float, high: float) -> tuple[Xs, Xs]:
    """Where a shape of one turn, or of a face, ends across it."""
    import numpy as np

    places = np.linspace(low, high, 721)
    lines = [LineString([(-1e5, at), (1e5, at)]) for at in places.tolist()]
    bounds_of = bounds(intersection(lines, shape))
    bounds_of = np.where(np.isnan(bounds_of), (-1e5, 0.0, 1e5, 0.0), bounds_of)

    def start(at: float) -> tuple[float, ...]:
        return (float(np.interp(at, places, bounds_of[:, 0])),)

    def end(at: float) -> tuple[float, ...]:
        return (float(np.interp(at, places, bounds_of[:, 2])),)

    return start, end


def round_ends(part: Part, bare: Shape, section: TubeSection) -> tuple[dict[str, FaceEnds], float]:
    """Where a round piece ends, all round, and how far apart both surfaces of its wall end."""
    radius, planes = section.radius, [*header_planes(part, section), *planes_of(part, (), section)]
    farthest, rows, apart = ends_of_shape(bare, 0.0, section.turn), [], 0.0
    for k, side in enumerate((-1, 1)):
        ends = [end for at, end in planes if at == side]
        apart = max(apart, *(section.wall * hypot(*end[1:]) for end in ends), 0.0)

        def xs(u: float, k: int = k, ends: Sequence[End] = tuple(ends)) -> tuple[float, ...]:
            y, z = -radius * cos(u / radius), radius * sin(u / radius)
            return (*farthest[k](u), *(x - by_y * y - by_z * z for x, by_y, by_z in ends))

        rows.append(xs)
    return {"v": FaceEnds(rows[0], rows[1], part.length)}, apart
