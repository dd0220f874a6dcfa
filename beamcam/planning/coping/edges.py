"""Bevelled edges of a wall: the curves of a contour that one pass of a torch prepares for welding.

       n  inside        The bevel's surface lies (t - land - depth) tan(angle) inside of the edge,
   ____|____            wherever that is above zero for a bevel of the side that is looked at, and
  edge, steel           wherever below the surface for one of the far side. Along an arc it is a
  on its left           cone: the torch turns about both of its axes, always square to the edge.

Beyond a blunt corner, up to 135 degrees, it goes straight on to the edge that comes next.
"""

from collections.abc import Iterator, Sequence
from itertools import pairwise
from math import acos, ceil, degrees, dist, radians, tan

from msgspec import Struct

from beamcam.geometry.curves import Arc, Curve, Line, Point, signed_area
from beamcam.model.part import Bevel, Contour
from beamcam.planning.coping.regions import CHORD, OUTLINE_NOISE, Shape
from beamcam.planning.coping.walls import PlannedWall

TANGENT = 0.9999  #: cosine between curves that go on in one another, at least; 0.8 degrees
ALIKE = 1e-6  #: degrees and mm by which bevels of one pass differ
SAME_PLACE = 1e-6  #: mm


class Ruling(Struct, frozen=True):
    """A place of an edge, and the way into the steel square to it."""

    place: Point
    inside: Point  #: of length 1

    def at(self, mm: float) -> Point:
        """The place so far inside of the edge."""
        return self.place[0] + mm * self.inside[0], self.place[1] + mm * self.inside[1]


class BevelEdge(Struct, frozen=True):
    """Curves that go on in one another, with the same bevel; the steel is on their left."""

    curves: tuple[Line | Arc, ...]
    angle: float  #: degrees; below 0 of the far side
    land: float  #: from the far side to where the bevel begins or ends
    thickness: float
    count: int  #: bevels of the contour that it is made of
    #: at its start and its end how far the bevel goes on beyond, in mm by mm that it reaches inside
    beyond: tuple[float, float] = (0.0, 0.0)

    @property
    def is_lower(self) -> bool:
        return self.angle < 0.0

    @property
    def slope(self) -> float:
        return tan(radians(self.angle))

    def beside(self, depth: float) -> float:
        """How far inside of the edge the bevel's surface lies, so far below the wall's."""
        return (self.thickness - self.land - depth) * self.slope

    def rulings(self, offs: Sequence[float]) -> list[Ruling]:
        """Places along the edge, such that lines so far inside of it have chords within CHORD."""
        found: list[Ruling] = []
        for curve in self.curves:
            count = 1
            if isinstance(curve, Arc):
                way = 1.0 if curve.sweep_deg > 0.0 else -1.0
                most = max(abs(curve.radius - way * off) for off in (0.0, *offs))
                step = degrees(2 * acos(1 - CHORD / most)) if most > CHORD else 90.0
                count = ceil(abs(curve.sweep_deg) / min(step, 15.0))
            for k in range(count + 1):
                dx, dy = curve.tangent(k / count)
                one = Ruling(curve.point(k / count), (-dy, dx))
                if not found or dist(found[-1].place, one.place) > SAME_PLACE:
                    found.append(one)
        return found

    def fits(self, offs: Sequence[float], least: float) -> bool:
        """Whether arcs round the steel keep so much radius at all lines so far inside."""
        return all(
            curve.sweep_deg < 0.0 or curve.radius - max(offs) >= least
            for curve in self.curves if isinstance(curve, Arc)
        )  # fmt: skip

    def strip(self, depth: float) -> Shape:
        """What the bevel takes of the wall, so far below its surface."""
        from shapely import Polygon, make_valid

        wide = max(0.0, self.beside(depth))
        if not wide:
            return Polygon()
        rulings = self.rulings((wide,))
        inside = self.gone_on([one.at(wide) for one in rulings], wide)
        return make_valid(Polygon([*(one.place for one in rulings), *reversed(inside)]))

    def gone_on(self, line: Sequence[Point], wide: float, more: float = 0.0) -> list[Point]:
        """A line along the edge, straight on at both ends as far as a bevel so wide, and more."""
        (ax, ay), (bx, by) = self.curves[0].tangent(0.0), self.curves[-1].tangent(1.0)
        first, last = (by_mm * wide + more for by_mm in self.beyond)
        (xa, ya), (xb, yb) = line[0], line[-1]
        start, end = (xa - first * ax, ya - first * ay), (xb + last * bx, yb + last * by)
        return [start, *line[1:-1], end] if len(line) == 2 else [start, *line, end]


def bevel_edges(contour: Contour, wall: PlannedWall, least: float) -> Iterator[BevelEdge]:
    """The bevelled edges of a contour that are straight or round, bevels below `least` left out.

    A curve of another kind has no edge.
    """
    curves: list[Curve] = []
    there: list[list[Bevel]] = []
    for k, curve in enumerate(contour.curves):
        if curve.length > SAME_PLACE:
            curves.append(curve)
            there.append([b for b in contour.bevels if b.curve == k and abs(b.angle) >= least])
    if (signed_area(tuple(curves)) > 0.0) != (contour.kind == "outer"):  # the steel on the left
        curves = [curve.reversed() for curve in reversed(curves)]
        there = there[::-1]
    drawn = [_on_wall(curve, wall) for curve in curves]
    for lower in (False, True):
        own = [next((b for b in some if (b.angle < 0.0) == lower), None) for some in there]
        joins = [_goes_on(k, drawn, own) for k in range(len(drawn))]  # with the one before
        begins = [k for k, bevel in enumerate(own) if bevel is not None and not joins[k]]
        if all(joins):
            begins = [0]
        for k in begins:
            chain = [k]
            while (after := (chain[-1] + 1) % len(drawn)) != k and joins[after]:
                chain.append(after)
            bevel = own[k]
            some = [c for c in (drawn[j] for j in chain) if isinstance(c, Line | Arc)]
            if bevel is None or len(some) < len(chain):
                continue
            land = bevel.land or (wall.thickness if lower else 0.0)
            beyond = (0.0, 0.0)
            if not all(joins):
                after = (chain[-1] + 1) % len(drawn)
                beyond = _beyond(drawn[k - 1], some[0]), _beyond(some[-1], drawn[after])
            yield BevelEdge(tuple(some), bevel.angle, land, wall.thickness, len(chain), beyond)


def _beyond(before: Curve, after: Curve) -> float:
    """How far a bevel goes on at a blunt corner of steel, in mm by mm that it reaches inside."""
    (ax, ay), (bx, by) = before.tangent(1.0), after.tangent(0.0)
    turn, same_way = ax * by - ay * bx, ax * bx + ay * by
    return same_way / turn if 0.0 < same_way <= turn else 0.0


def _goes_on(k: int, curves: Sequence[Curve], bevels: Sequence[Bevel | None]) -> bool:
    """Whether a curve has the bevel of the one before, and goes on from it without a corner."""
    a, b = bevels[k - 1], bevels[k]
    if a is None or b is None or abs(a.angle - b.angle) > ALIKE or abs(a.land - b.land) > ALIKE:
        return False
    (ax, ay), (bx, by) = curves[k - 1].tangent(1.0), curves[k].tangent(0.0)
    return ax * bx + ay * by >= TANGENT


def _on_wall(curve: Curve, wall: PlannedWall) -> Curve:
    """A curve of an outline; the ends of a straight one near an edge of its wall on that edge."""
    if not isinstance(curve, Line):
        return curve
    ends = []
    for x, y in (curve.start, curve.end):
        for side in (0.0, wall.width):
            if abs(y - side) <= OUTLINE_NOISE:
                y = side
        ends.append((x, y))
    return Line(ends[0], ends[1]) if dist(*ends) > SAME_PLACE else curve


def is_rolled(curve: Curve, wall: PlannedWall) -> bool:
    """Whether a curve lies on an edge that the bar has."""
    ys = {curve.start[1], curve.end[1]}
    return isinstance(curve, Line) and ys in ({0.0}, {wall.width})


def ways_of(path: Sequence[Point]) -> Iterator[tuple[Point, Point]]:
    """The stretches of a path that have a length."""
    return ((a, b) for a, b in pairwise(path) if dist(a, b) > SAME_PLACE)
