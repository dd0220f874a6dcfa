"""The steel that a program begins with: a bar with its trims, or a piece whose ends are there.

Of a piece the header says the ends, as DSTV has them: x(y, z) = c - y tan(web) - z tan(flange),
through the outermost corner of the section. A wall ends where either of its surfaces does, at the
farthest; a drawing may have the other one.
"""

from collections.abc import Iterator, Sequence
from math import ceil, cos, inf, pi, radians, sin
from typing import Any

from msgspec import Struct
from shapely import MultiPoint, Polygon, make_valid, union_all

from beamcam.checks.coping.section import CoperSection
from beamcam.checks.coping.skew import EndOnWall, end_of
from beamcam.geometry.curves import Arc, Curve, Line
from beamcam.geometry.plane import Point
from beamcam.machine.coper import Coper
from beamcam.model.part import Contour, Feature, Hole, Part, Slot

FINE = 0.02  #: mm between a curve and its chords, at most
STEPS = 256  #: of a curve that is no arc
EDGE_NOISE = 1.0  #: mm that a side of an outline may lie off the edge of its wall and mean it
SEAM_NOISE = 2.5  #: likewise of a tube's seam, which is a long side
EDGE_SLOPE = 0.02  #: of such a side, at most


def ring_of(curves: tuple[Curve, ...]) -> list[Point]:
    """Points along a closed chain of curves."""
    return [point for curve in curves for point in _places(curve)]


def inside_of(ring: Sequence[Point]) -> Any:
    """The inside of a ring, also of one that crosses itself."""
    whole = Polygon(ring)
    return whole if whole.is_valid else make_valid(whole)


def outline_ring(
    curves: tuple[Curve, ...], edges: Sequence[float], ends: Sequence[EndOnWall] = (),
    seam_from: float = inf,
) -> list[Point]:  # fmt: skip
    """Points along an outline, its sides near one of some edges on that edge.

    A side of a tube that is as long as `seam_from` may be its seam.

    Only ends of straight sides are moved, to an edge and then to one of the wall's `ends`; those of
    an arc that runs into an edge are steel that is asked for.
    """
    points: list[Point] = []
    for k, curve in enumerate(curves):
        first, *rest = _places(curve)
        sides = [one for one in (curves[k - 1], curve) if isinstance(one, Line)]
        x, y = first
        on = [edge for edge in edges if any(_is_edge(side, edge, seam_from) for side in sides)]
        first = (x, on[0] if on else y)
        for end in ends if sides else ():
            first = end.moved(first)
        points += [first, *rest]
    return points


def _is_edge(side: Line, edge: float, seam_from: float) -> bool:
    """Whether a side of an outline means an edge of its wall."""
    off, run = abs(side.start[1] - edge), side.end[0] - side.start[0]
    rise = side.end[1] - side.start[1]
    most = SEAM_NOISE if abs(run) >= seam_from else EDGE_NOISE
    return max(off, abs(side.end[1] - edge)) <= most and abs(rise) <= EDGE_SLOPE * abs(run)


def _places(curve: Curve) -> list[Point]:
    """Points along a curve, without its end."""
    if isinstance(curve, Line):
        return [curve.start]
    if isinstance(curve, Arc):
        more = round_ring(*curve.centre, curve.radius, curve.start_deg, curve.sweep_deg)
        return list(more)[:-1]
    return [curve.point(k / STEPS) for k in range(STEPS)]


def round_ring(
    x: float, y: float, radius: float, first: float = 0.0, sweep: float = 360.0
) -> Iterator[Point]:
    """Points of an arc; a chord of a step t lies r t^2 / 8 off it at most."""
    step = min(pi / 8, (8 * FINE / 2 / radius) ** 0.5) if radius else pi / 8
    count = max(2, ceil(abs(radians(sweep)) / step))
    for k in range(count + 1):
        turn = radians(first + sweep * k / count)
        yield x + radius * cos(turn), y + radius * sin(turn)


def taken(feature: Feature) -> Any:
    """What a hole, a slot or a contour takes of its wall."""
    if isinstance(feature, Hole):
        return Polygon(round_ring(feature.x, feature.y, feature.diameter / 2))
    if isinstance(feature, Slot):  # the hull of its round corners
        c, s, rounds = cos(radians(feature.angle)), sin(radians(feature.angle)), list[Point]()
        for k, (a, b) in enumerate(((0.5, 0.5), (-0.5, 0.5), (-0.5, -0.5), (0.5, -0.5))):
            x = feature.x + a * feature.length * c - b * feature.height * s
            y = feature.y + a * feature.length * s + b * feature.height * c
            rounds += round_ring(x, y, feature.diameter / 2, feature.angle + 90.0 * k, 90.0)
        return MultiPoint(rounds).convex_hull
    return inside_of(ring_of(feature.curves)) if isinstance(feature, Contour) else Polygon()


def is_through(feature: Feature) -> bool:
    """Whether what another machine has made goes through its wall, but for its ends."""
    if isinstance(feature, Hole | Slot):
        return feature.kind != "mark" and feature.depth is None
    return isinstance(feature, Contour) and feature.kind == "inner" and feature.process == "cut"


class WallStock(Struct, frozen=True):
    """The steel of each wall."""

    is_piece: bool
    ends: dict[str, tuple[EndOnWall, EndOnWall]]
    widths: dict[str, float]
    open: dict[str, Any] = {}  #: by wall, the holes of a piece that are there

    def wall(self, face: str) -> Any:
        """All steel of a wall, (x, y) of its face, with that where its holes are."""
        (start, end), wide = self.ends[face], self.widths[face]
        return Polygon(
            [(start.x(0.0), 0.0), (end.x(0.0), 0.0), (end.x(wide), wide), (start.x(wide), wide)]
        )


def stock_of(part: Part, section: CoperSection, coper: Coper) -> WallStock:
    """The bar that a part is cut from, or the piece that comes cut."""
    faces = section.faces
    widths = {face: section.high if face == "v" else section.wide for face in faces}
    if part.made is None:
        low, high = -coper.trim, part.length + coper.trim
        square = EndOnWall(-1, low, 0.0, 0.0), EndOnWall(1, high, 0.0, 0.0)
        return WallStock(False, dict.fromkeys(faces, square), widths)
    cuts = part.cuts
    both = (cuts.web_start, cuts.flange_start), (cuts.web_end, cuts.flange_end)
    start, end = (end_of(part, section, k, *angles) for k, angles in enumerate(both))
    made = [f for f in part.made if is_through(f)]
    return WallStock(
        True, {face: (start.on_wall(face, section), end.on_wall(face, section)) for face in faces},
        widths,
        {face: union_all([taken(f) for f in made
                          if getattr(f, "face", "").replace("h", "v") == face])
         for face in faces},
    )  # fmt: skip
