"""Cuts that cross the root of a web on a slant, where a torch cuts web and flange at one x.

What stays of both reaches as far as either of them is drawn at the root: of the web as deep as the
passes through that root cut, of the flange as wide as web and fillets are.
"""

from collections.abc import Iterator, Mapping, Sequence
from math import atan, degrees

from msgspec import Struct

from beamcam.checks.coping.section import CoperSection, areas_of, pieces_of
from beamcam.checks.coping.skew import ON_PLANE, Shape, step_of
from beamcam.checks.coping.strokes import TorchStroke
from beamcam.checks.coping.wanted import RequiredWall, with_round_corners
from beamcam.geometry.plane import Point

STEEPEST_DEG = 30.0  #: of a cut through a root that is made square, to its normal
APART = 1.0  #: mm along the bar that web and flange may be drawn apart and are one cut
SQUARE = 0.1  #: mm along the bar that a square cut may slant
FAR = 1e5


class Crossing(Struct, frozen=True):
    """A straight edge of a wall through the whole of a root: x = at + more y."""

    at: float
    more: float
    xs: tuple[float, float]  #: at both sides of the root
    side: int  #: 1 where the scrap lies at greater x

    def over(self, band: tuple[float, float]) -> Iterator[float]:
        """x at both sides of a band."""
        return (self.at + self.more * y for y in band)


def crossings_of(
    shape: Shape, band: tuple[float, float], ends: Sequence[Point]
) -> Iterator[Crossing]:
    """The straight edges from side to side of a band of a wall, but for its ends.

    Of an end `ends` has x at y 0, and how much more at y 1.
    """
    from shapely import LineString, box, line_merge
    from shapely import Point as Place

    low, high = band
    edges = shape.boundary.intersection(box(-FAR, low, FAR, high))
    if edges.geom_type == "MultiLineString":
        edges = line_merge(edges)
    for edge in pieces_of(edges):
        if edge.geom_type != "LineString":
            continue
        (xa, ya), (xb, yb) = sorted((edge.coords[0], edge.coords[-1]), key=lambda p: p[1])
        if yb - ya < high - low - ON_PLANE or edge.hausdorff_distance(
            LineString([(xa, ya), (xb, yb)])
        ) > ON_PLANE / 2:  # fmt: skip
            continue
        more = (xb - xa) / (yb - ya)
        at = xa - more * ya
        x, y = (xa + xb) / 2, (ya + yb) / 2
        if any(abs(x - there - rise * y) <= ON_PLANE for there, rise in ends):
            continue
        if degrees(atan(abs(more))) <= STEEPEST_DEG:
            beyond = Place((xa + xb) / 2 + 2 * ON_PLANE, (ya + yb) / 2)
            yield Crossing(at, more, (xa, xb), -1 if shape.covers(beyond) else 1)


def with_square_roots(
    wanted: dict[tuple[str, float], RequiredWall], ends: Mapping[str, Sequence[Point]],
    section: CoperSection, strokes: Sequence[TorchStroke], widest: float,
) -> dict[str, float]:  # fmt: skip
    """Puts what stays where a root is crossed on a slant into `wanted`, on all surfaces that it
    has; gives the mm that are too much, by face. `widest` is the widest kerf."""
    off: dict[str, float] = {}
    drawn = {face: wanted[face, 0.0].drawn for face in section.faces}
    for face in section.faces[1:]:
        deep = _depth(face, section, strokes)
        if not deep:
            continue
        back, front = section.root(face)
        zs = back - ON_PLANE, front + ON_PLANE
        ys = (0.0, deep + ON_PLANE)
        inner = section.flange, deep
        if face == "o":
            ys = (section.high - deep - ON_PLANE, section.high)
            inner = section.high - deep, section.high - section.flange
        across = max(zs[0], 0.0) + 2 * ON_PLANE, min(zs[1], section.wide) - 2 * ON_PLANE
        inner = inner[0] + 2 * ON_PLANE, inner[1] - 2 * ON_PLANE
        for web in [*crossings_of(drawn["v"], inner, ends["v"])]:
            for flange in [*crossings_of(drawn[face], across, ends[face])]:
                if not _meet(web, flange):
                    continue
                x = web.side * max(web.side * at for at in (*web.over(ys), *flange.over(zs)))
                for one, edge, band, wide in (
                    ("v", web, ys, section.high), (face, flange, zs, section.wide)
                ):  # fmt: skip
                    low, high = max(band[0], 0.0), min(band[1], wide)
                    far = [abs(x - edge.at - edge.more * y) for y in (low, high)]
                    off[one] = max(off.get(one, 0.0), *far)
                    _add(wanted, one, edge, (low, high), x, widest)
    return off


def _meet(web: Crossing, flange: Crossing) -> bool:
    """Whether both are one cut, of which either crosses its root on a slant."""
    apart = max(min(web.xs) - max(flange.xs), min(flange.xs) - max(web.xs))
    slanted = max(abs(xa - xb) for xa, xb in (web.xs, flange.xs)) > SQUARE
    return slanted and web.side == flange.side and apart <= APART


def _add(
    wanted: dict[tuple[str, float], RequiredWall], face: str, edge: Crossing,
    band: tuple[float, float], x: float, widest: float,
) -> None:  # fmt: skip
    """Adds a step of a wall on all surfaces that it has."""
    step = step_of(edge.side, edge.at, edge.more, *band, x)
    corners: list[Point] = [(edge.at + edge.more * y, y) for y in band]
    for key, one in [*wanted.items()]:
        if key[0] == face:
            cut = one.cut.union(step)
            most = with_round_corners(one.most.union(cut), corners, widest / 2)
            wanted[key] = RequiredWall(areas_of(one.drawn.union(step)), cut, one.short, most)


def _depth(face: str, section: CoperSection, strokes: Sequence[TorchStroke]) -> float:
    """How deep the passes through a root cut, square to the flange; 0 without one."""
    back, front = section.root(face)
    deep = 0.0
    for stroke in strokes:
        ys = [y for _, y in stroke.points]
        if stroke.face == face and not stroke.b_deg and min(ys) <= back and max(ys) >= front:
            deep = max(deep, stroke.row.up_to)
    return deep
