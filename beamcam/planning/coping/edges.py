"""Bevelled edges of a wall: the curves of a contour that one pass of a torch prepares for welding.

       n  inside        The bevel's surface lies (t - land - depth) tan(angle) inside of the edge,
   ____|____            wherever that is above zero for a bevel of the side that is looked at, and
  edge, steel           wherever below the surface for one of the far side. Along an arc it is a
  on its left           cone: the torch turns about both of its axes, always square to the edge.
                        Where straight edges turn by little, as those of a curve that is drawn by
                        lines, it is two planes: there the torch lies in both.

Beyond a blunt corner, up to 135 degrees, it goes straight on to the edge that comes next.
"""

from collections.abc import Iterator, Sequence
from itertools import pairwise
from math import acos, atan2, ceil, cos, degrees, dist, pi, radians, tan

from msgspec import Struct
from shapely import Polygon, make_valid

from beamcam.geometry.curves import Arc, Curve, Line, Point, signed_area
from beamcam.machine.coper import torch_angles, torch_way
from beamcam.model.part import Bevel, Contour
from beamcam.planning.coping.regions import CHORD, CORNER_DEG, OUTLINE_NOISE, Shape
from beamcam.planning.coping.walls import PlannedWall

TANGENT = 0.9999  #: cosine between curves that go on in one another, at least; 0.8 degrees
DRAWN_BY_LINES = cos(radians(CORNER_DEG))  #: the same between lines that stand for a curve
ALIKE = 1e-6  #: degrees and mm by which bevels of one pass differ
SAME_PLACE = 1e-6  #: mm
#: Radians that a contour turns at a corner where a bevel goes on, at least and at most.
BLUNT, SQUARE = pi / 4 - 1e-9, pi / 2 - 1e-9
WHOLE = 0.01  #: mm of a land above a bevel of the far side that are nothing
FITTED = CHORD / 2  #: mm by which arcs may lie off a curve that is none


class Ruling(Struct, frozen=True):
    """A place of an edge, and the way into the steel square to it."""

    place: Point
    #: of length 1; between two straight edges to where lines 1 mm inside of both meet
    inside: Point

    def at(self, mm: float) -> Point:
        """The place so far inside of the edge."""
        return self.place[0] + mm * self.inside[0], self.place[1] + mm * self.inside[1]

    def joined(self, other: "Ruling") -> "Ruling":
        """That where the edge of this one goes on in the edge of another one."""
        (ax, ay), (bx, by) = self.inside, other.inside
        share = 1.0 + ax * bx + ay * by
        return Ruling(self.place, ((ax + bx) / share, (ay + by) / share))


class BevelEdge(Struct, frozen=True):
    """Curves that go on in one another, with the same bevel; the steel is on their left."""

    curves: tuple[Line | Arc, ...]
    angle: float  #: degrees; below 0 of the far side
    land: float  #: from the far side to where the bevel begins or ends
    thickness: float
    count: int  #: bevels of the contour that it is made of
    is_ring: bool  #: whether it goes on in itself
    ways: tuple[Point, Point]  #: in which the curve before it ends and the one behind it begins

    @property
    def is_lower(self) -> bool:
        return self.angle < 0.0

    @property
    def is_whole(self) -> bool:
        """Whether it is of the far side and reaches the surface: one cut makes the edge."""
        return self.is_lower and -self.beside(0.0) <= WHOLE

    @property
    def slope(self) -> float:
        return tan(radians(self.angle))

    @property
    def turns(self) -> tuple[float, float]:
        """How far the contour turns at its start and its end, in radians, to the left above 0."""
        first, last = self.curves[0].tangent(0.0), self.curves[-1].tangent(1.0)
        return _turn(self.ways[0], first), _turn(last, self.ways[1])

    def beside(self, depth: float) -> float:
        """How far inside of the edge the bevel's surface lies, so far below the wall's."""
        return (self.thickness - self.land - depth) * self.slope

    def rulings(self, offs: Sequence[float], deep: float = 0.0) -> list[Ruling]:
        """Places along the edge, such that lines so far inside of it have chords within CHORD, and
        so has what a torch sweeps between them that is `deep` mm long."""
        rulings: list[Ruling] = []
        for curve in self.curves:
            count = 1
            if isinstance(curve, Arc):
                most = max(abs(_radius(curve, off)) for off in (0.0, *offs))
                step = degrees(2 * acos(1 - CHORD / most)) if most > CHORD else 90.0
                count = ceil(abs(curve.sweep_deg) / min(step, 15.0))
            for k in range(count + 1):
                dx, dy = curve.tangent(k / count)
                one = Ruling(curve.point(k / count), (-dy, dx))
                if rulings and dist(rulings[-1].place, one.place) <= SAME_PLACE:
                    rulings[-1] = rulings[-1].joined(one)
                else:
                    rulings.append(one)
        if self.is_ring:
            rulings[0] = rulings[-1] = rulings[-1].joined(rulings[0])
        steady = [rulings[0]]
        for one in rulings[1:]:
            steady += self._between(steady[-1], one, deep)
        return steady

    def _between(self, a: Ruling, b: Ruling, deep: float) -> list[Ruling]:
        """What follows on a ruling up to another one: as many more as keep the torch in the plane
        of a straight edge while A and B turn evenly."""
        (ax, ay), (bx, by) = ((one.inside[0] * self.slope, one.inside[1] * self.slope)
                              for one in (a, b))  # fmt: skip
        wide = dist(a.place, b.place)
        normal = (a.place[1] - b.place[1]) / wide, (b.place[0] - a.place[0]) / wide
        is_plane = all(abs(nx * normal[0] + ny * normal[1] - 1.0) < ALIKE
                       for nx, ny in (a.inside, b.inside))  # fmt: skip
        if not is_plane or a.inside == b.inside:
            return [b]
        turns = torch_angles("v", (ax, ay)), torch_angles("v", (bx, by))
        x, y, z = torch_way(*((p + q) / 2 for p, q in zip(*turns, strict=True)))
        off = (x / z - (ax + bx) / 2) * normal[0] + (y / z - (ay + by) / 2) * normal[1]
        if abs(off) * deep <= CHORD / 2:
            return [b]
        middle = Ruling(*(
            ((p[0] + q[0]) / 2, (p[1] + q[1]) / 2)
            for p, q in ((a.place, b.place), (a.inside, b.inside))
        ))  # fmt: skip
        return [*self._between(a, middle, deep), *self._between(middle, b, deep)]

    def fits(self, offs: Sequence[float], least: float) -> bool:
        """Whether all lines so far inside keep a least radius, and some length."""
        arcs = [curve for curve in self.curves if isinstance(curve, Arc)]
        if any(_radius(arc, off) < least for arc in arcs for off in offs):
            return False
        ends = self.rulings(())
        for a, b in pairwise(ends):
            dx, dy = b.place[0] - a.place[0], b.place[1] - a.place[1]
            for off in offs:
                (xa, ya), (xb, yb) = a.at(off), b.at(off)
                if (xb - xa) * dx + (yb - ya) * dy <= 0.0:
                    return False
        return True

    def strip(self, depth: float) -> Shape:
        """What the bevel takes of the wall, so far below its surface."""
        wide = max(0.0, self.beside(depth))
        if not wide:
            return Polygon()
        rulings = self.rulings((wide,))
        places = [one.place for one in rulings]
        inside = self.gone_on([one.at(wide) for one in rulings], wide)
        if self.is_ring:
            return make_valid(Polygon(places)).symmetric_difference(make_valid(Polygon(inside)))
        return make_valid(Polygon([*places, *reversed(inside)]))

    def gone_on(self, line: Sequence[Point], wide: float, more: float = 0.0) -> list[Point]:
        """A line along the edge, straight on at both ends as far as a bevel so wide, and more; that
        of a ring ends where it begins."""
        if self.is_ring:
            return [*line]
        (ax, ay), (bx, by) = self.curves[0].tangent(0.0), self.curves[-1].tangent(1.0)
        # Beyond a blunt corner the bevel goes on to the next edge.
        first, last = ((wide / tan(turn) if BLUNT <= turn < SQUARE else 0.0) + more
                       for turn in self.turns)  # fmt: skip
        (xa, ya), (xb, yb) = line[0], line[-1]
        start, end = (xa - first * ax, ya - first * ay), (xb + last * bx, yb + last * by)
        return [start, *line[1:-1], end] if len(line) == 2 else [start, *line, end]


class _Segment(Struct, frozen=True):
    """A line or an arc of a contour with its bevels, or one of some that stand for its curve."""

    curve: Line | Arc
    bevels: tuple[Bevel, ...]
    is_first: bool  #: of its curve


def bevel_edges(contour: Contour, wall: PlannedWall, least: float) -> Iterator[BevelEdge]:
    """The edges of a contour with bevels of `least` degrees, as lines and arcs."""
    drawn = _segments(contour, wall, least)
    for lower in (False, True):
        own = [next((b for b in one.bevels if (b.angle < 0.0) == lower), None) for one in drawn]
        joins = [_goes_on(k, drawn, own) for k in range(len(drawn))]  # with the one before
        is_ring = all(joins)
        begins = [0] if is_ring else [
            k for k, bevel in enumerate(own) if bevel is not None and not joins[k]
        ]  # fmt: skip
        for k in begins:
            chain = [k]
            while (after := (chain[-1] + 1) % len(drawn)) != k and joins[after]:
                chain.append(after)
            bevel = own[k]
            assert bevel is not None
            some = [drawn[j].curve for j in chain]
            count = sum(drawn[j].is_first for j in chain)
            before, behind = drawn[k - 1].curve, drawn[(chain[-1] + 1) % len(drawn)].curve
            if is_ring:  # from the middle of the longest of them on
                j = max(range(len(some)), key=lambda j: some[j].length)
                first, last = some[j].split(0.5)
                some = [last, *some[j + 1 :], *some[:j], first]
            yield BevelEdge(
                tuple(some), bevel.angle, bevel.land or (wall.thickness if lower else 0.0),
                wall.thickness, count, is_ring, (before.tangent(1.0), behind.tangent(0.0)),
            )  # fmt: skip


def _segments(contour: Contour, wall: PlannedWall, least: float) -> list[_Segment]:
    """Lines and arcs of a contour with the steel on their left, on their wall."""
    curves: list[Curve] = []
    there: list[tuple[Bevel, ...]] = []
    for k, curve in enumerate(contour.curves):
        if curve.length > SAME_PLACE:
            curves.append(curve)
            there.append(tuple(b for b in contour.bevels if b.curve == k and abs(b.angle) >= least))
    if (signed_area(tuple(curves)) > 0.0) != (contour.kind == "outer"):  # the steel on the left
        curves = [curve.reversed() for curve in reversed(curves)]
        there = there[::-1]
    segments: list[_Segment] = []
    for curve, bevels in zip(curves, there, strict=True):
        pieces: list[Line | Arc] = [curve] if isinstance(curve, Line | Arc) else []
        if not isinstance(curve, Line | Arc):
            from beamcam.geometry.arc_fitting import fit_chains

            (chain,) = fit_chains([[curve]], FITTED)
            pieces = [one for one in chain if one.length > SAME_PLACE]
        segments += [_Segment(_on_wall(one, wall), bevels, j == 0) for j, one in enumerate(pieces)]
    return segments


def _radius(arc: Arc, off: float) -> float:
    """The radius of a line so far inside of an arc."""
    return arc.radius - (off if arc.sweep_deg > 0.0 else -off)


def _turn(before: Point, after: Point) -> float:
    """How far a way turns, in radians, to the left above 0."""
    (ax, ay), (bx, by) = before, after
    return atan2(ax * by - ay * bx, ax * bx + ay * by)


def _goes_on(k: int, drawn: Sequence[_Segment], bevels: Sequence[Bevel | None]) -> bool:
    """Whether a curve has the bevel of the one before, and goes on from it without a corner."""
    a, b = bevels[k - 1], bevels[k]
    if a is None or b is None or abs(a.angle - b.angle) > ALIKE or abs(a.land - b.land) > ALIKE:
        return False
    before, after = drawn[k - 1].curve, drawn[k].curve
    (ax, ay), (bx, by) = before.tangent(1.0), after.tangent(0.0)
    are_lines = isinstance(before, Line) and isinstance(after, Line)
    return ax * bx + ay * by >= (DRAWN_BY_LINES if are_lines else TANGENT)


def _on_wall(curve: Line | Arc, wall: PlannedWall) -> Line | Arc:
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
    """The segments of a path that have a length."""
    return ((a, b) for a, b in pairwise(path) if dist(a, b) > SAME_PLACE)
