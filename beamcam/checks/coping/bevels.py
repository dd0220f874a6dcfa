"""Passes that make weld preparations, found among a program's strokes.

A bevel with the angle b takes of a wall t thick (t - land) tan(b) at the surface that the torch
looks at, and nothing from the land on; one of the far side land tan(b) there, and nothing above. A
stroke makes it that runs, at both surfaces of the wall, along its edge, half a kerf off what stays
there; any other stroke whose torch is tilted otherwise than a skew end asks for is none. Curves
that go on in one another and have one bevel are one edge, of a cut-out it may go on in itself.

A pass comes after the square cut along its edge, of the far side before it, and before the piece is
parted from its bar; an edge that the bar has by itself has no square cut, nor has one of the far
side that reaches the surface, which its pass makes alone.
"""

from collections.abc import Iterator, Mapping, Sequence
from itertools import pairwise
from math import atan2, ceil, cos, hypot, pi, radians, sin, tan
from typing import Any

from msgspec import Struct
from msgspec.structs import replace
from shapely import LineString, Polygon, make_valid
from shapely import Point as Place

from beamcam.checks.coping import rules
from beamcam.checks.coping.lying import other_side
from beamcam.checks.coping.section import CoperSection
from beamcam.checks.coping.skew import SkewEnd, own_bevels
from beamcam.checks.coping.strokes import TorchStroke
from beamcam.errors import Diagnostic, Source
from beamcam.geometry.curves import Curve, Line
from beamcam.geometry.plane import Point
from beamcam.machine.coper import Coper
from beamcam.model.part import Bevel, Contour, Part

Shape = Any  #: of shapely

AT_EDGE = 1.0  #: mm from an edge of its wall within which a drawn place means that edge
OFF_PASS = 0.1  #: mm that a pass may lie beside where its bevel has it
HAIR = 1e-3  #: mm that what is taken is larger, so that no hair of it stays
BESIDE = 0.1  #: mm that a square cut may lie beside the edge that it makes
STEP = 0.5  #: mm from place to place of a round edge
NO_CORNER = 0.015  #: sine between curves that go on in one another
CURVED_DEG = 20.0  #: that straight edges turn by at most where they stand for a curve
NO_LAND = 0.01  #: mm above a bevel of the far side that are none
SAME = 1e-6  #: degrees and mm that bevels of one edge may differ


class BevelledEdge(Struct, frozen=True):
    """Curves with one bevel, the steel on their left, as the torch sees them."""

    feature: int
    bevel: Bevel
    curves: tuple[Curve, ...]
    thickness: float
    drawn: tuple[Bevel, ...]  #: as the contour has them, from whichever side
    #: sharp turns of the contour at its start and its end, in radians; 0 for none that is blunt
    turns: tuple[float, float]
    is_ring: bool  #: whether it goes on in itself

    @property
    def is_whole(self) -> bool:
        """Whether it is of the far side and goes through all of the wall."""
        over = (self.thickness - self.bevel.land) * tan(radians(-self.bevel.angle))
        return self.bevel.angle < 0.0 and over <= NO_LAND

    def _lines(self, mm: float) -> list[list[Point]]:
        """The line so far inside of each of its curves."""
        lines: list[list[Point]] = []
        for curve in self.curves:
            count = 1 if isinstance(curve, Line) else ceil(curve.length / STEP)
            line = []
            for k in range(count + 1):
                (x, y), (dx, dy) = curve.point(k / count), curve.tangent(k / count)
                line.append((x - mm * dy, y + mm * dx))
            lines.append(line)
        return lines

    def inside(self, mm: float, longer: float = 0.0, wide: float = 0.0) -> list[Point]:
        """The line so far inside of it, longer at both ends, and at a blunt corner as far as a
        bevel so wide goes to the next edge; that of a ring ends where it begins.

        Lines beside straight edges go on to where they cross.
        """
        lines = self._lines(mm)
        for before, after in pairwise((*lines, *lines[: self.is_ring])):
            before[-1] = after[0] = _crossing(before[-2:], after[:2])
        line = [place for own in lines for place in own]
        if self.is_ring:
            return [*line, line[0]]
        (ax, ay), (bx, by) = self.curves[0].tangent(0.0), self.curves[-1].tangent(1.0)
        (xa, ya), (xb, yb) = line[0], line[-1]
        by_a, by_b = (longer + (wide / tan(turn) if turn else 0.0) for turn in self.turns)
        return [(xa - by_a * ax, ya - by_a * ay), *line, (xb + by_b * bx, yb + by_b * by)]

    def strip(self, depth: float) -> Shape:
        """What the bevel takes of its wall, so far below the face."""
        over_land = self.thickness - self.bevel.land - depth
        wide = max(0.0, over_land * tan(radians(self.bevel.angle)))
        if not wide:
            return Polygon()
        if self.is_ring:
            both = (make_valid(Polygon(self.inside(mm))) for mm in (0.0, wide))
            ring = next(both).symmetric_difference(next(both))
            return ring.buffer(HAIR, join_style="mitre")
        whole = make_valid(Polygon([*self.inside(0.0), *reversed(self.inside(wide, 0.0, wide))]))
        return whole.buffer(HAIR, join_style="mitre")


class BevelPass(Struct, frozen=True):
    """A bevelled edge of a part, and the stroke that makes it."""

    edge: BevelledEdge
    stroke: TorchStroke

    def beside(self, strokes: Sequence[TorchStroke], section: CoperSection) -> list[int]:
        """The lines of the square strokes along it, in their order, but where the bar has the edge;
        none where it has all of it."""
        middles = [Place(curve.point(share)) for curve in self.cut(section)
                   for share in (0.3, 0.5, 0.7)]  # fmt: skip
        return [] if not middles else [
            s.line for s in strokes
            if s.face == self.stroke.face and not s.is_tilted
            and all(abs(LineString(s.points).distance(place) - s.row.kerf / 2) <= BESIDE
                    for place in middles)
        ]  # fmt: skip

    def cut(self, section: CoperSection) -> list[Curve]:
        """Its curves that do not lie on an edge of the bar."""
        wide = section.high if self.stroke.face == "v" else section.wide
        return [
            curve for curve in self.edge.curves
            if not isinstance(curve, Line)
            or (curve.start[1], curve.end[1]) not in ((0.0, 0.0), (wide, wide))
        ]  # fmt: skip


def passes_of(
    part: Part, section: CoperSection, coper: Coper, strokes: Sequence[TorchStroke],
    ends: Sequence[SkewEnd],
) -> list[BevelPass]:  # fmt: skip
    """The bevelled edges that strokes make; not the bevels that tilted `ends` show."""
    passes: list[BevelPass] = []
    if section.lip:  # a pass would go on into a lip
        return passes
    for f, contour in enumerate(part.features):
        if not isinstance(contour, Contour) or contour.kind == "open":
            continue
        face = "v" if contour.face == "h" else contour.face
        contour = replace(contour, bevels=tuple(own_bevels(contour, ends, coper.min_bevel)))
        for edge in _edges(f, contour, section, coper) if face in section.faces else ():
            one = next(
                (s for s in strokes if s.face == face
                 and all(s is not other.stroke for other in passes)
                 and _makes(s, edge, coper.over)),
                None,
            )  # fmt: skip
            if one is not None:
                passes.append(BevelPass(edge, one))
    return passes


def _edges(f: int, contour: Contour, section: CoperSection, coper: Coper) -> Iterator[BevelledEdge]:
    """The bevelled edges of a contour."""
    face = "v" if contour.face == "h" else contour.face
    thick, wide = section.thickness(face), section.high if face == "v" else section.wide
    which = [k for k, curve in enumerate(contour.curves) if curve.length > SAME]
    curves: list[Curve] = []
    for curve in (contour.curves[k] for k in which):
        if isinstance(curve, Line):  # near an edge of its wall on that
            (xa, ya), (xb, yb) = curve.start, curve.end
            ya, yb = (0.0 if abs(y) <= AT_EDGE else wide if abs(y - wide) <= AT_EDGE else y
                      for y in (ya, yb))  # fmt: skip
            curve = Line((xa, ya), (xb, yb)) if hypot(xb - xa, yb - ya) > SAME else curve
        curves.append(curve)
    there = [[b for b in contour.bevels if b.curve == k and abs(b.angle) >= coper.min_bevel]
             for k in which]  # fmt: skip
    ring = Polygon([c.point(share) for c in curves for share in (0.0, 0.25, 0.5, 0.75)])
    if ring.exterior.is_ccw != (contour.kind == "outer"):
        curves, there = [c.reversed() for c in reversed(curves)], there[::-1]
    for side in (1.0, -1.0):
        own = [next((b for b in some if b.angle * side > 0.0), None) for some in there]
        chains: list[list[int]] = []
        for k, bevel in enumerate(own):
            if bevel is None:
                continue
            goes_on = chains and chains[-1][-1] == k - 1
            if goes_on and _is_one(own[k - 1], bevel, curves[k - 1 : k + 1]):
                chains[-1].append(k)
            else:
                chains.append([k])
        first, last = own[0], own[-1]
        if len(chains) > 1 and chains[0][0] == 0 and chains[-1][-1] == len(own) - 1 and _is_one(
            last, first, (curves[-1], curves[0])
        ):  # fmt: skip
            chains[0] = [*chains.pop(), *chains[0]]
        is_ring = len(chains) == 1 and len(chains[0]) == len(own) and _is_one(
            last, first, (curves[-1], curves[0])
        )  # fmt: skip
        for chain in chains:
            bevel = own[chain[0]]
            assert bevel is not None
            land = bevel.land or (thick if bevel.angle < 0.0 else 0.0)
            seen = Bevel(bevel.curve, bevel.angle, land)
            if contour.face == "h":  # seen through the web
                seen = other_side(bevel, section.web)
            drawn = tuple(b for k in chain if (b := own[k]) is not None)
            some = tuple(curves[k] for k in chain)
            after = curves[(chain[-1] + 1) % len(curves)]
            turns = _blunt(curves[chain[0] - 1], some[0]), _blunt(some[-1], after)
            yield BevelledEdge(f, seen, some, thick, drawn, turns, is_ring)


def _blunt(before: Curve, after: Curve) -> float:
    """How far the contour turns where a bevel goes on over a corner; 0 where it does not."""
    (ax, ay), (bx, by) = before.tangent(1.0), after.tangent(0.0)
    turn = atan2(ax * by - ay * bx, ax * bx + ay * by)
    return turn if pi / 4 - 1e-9 <= turn < pi / 2 else 0.0


def _is_one(a: Bevel | None, b: Bevel | None, curves: Sequence[Curve]) -> bool:
    """Whether a curve goes on from another without a corner, with the same bevel."""
    if a is None or b is None or max(abs(a.angle - b.angle), abs(a.land - b.land)) > SAME:
        return False
    (ax, ay), (bx, by) = curves[0].tangent(1.0), curves[1].tangent(0.0)
    by_lines = all(isinstance(curve, Line) for curve in curves)
    most = sin(radians(CURVED_DEG)) if by_lines else NO_CORNER
    return abs(ax * by - ay * bx) <= most and ax * bx + ay * by > 0.0


def _crossing(before: Sequence[Point], after: Sequence[Point]) -> Point:
    """Where two segments, gone on straight, cross; the end of the first where they are one."""
    ((ax, ay), (bx, by)), ((cx, cy), (dx, dy)) = before, after
    (ux, uy), (vx, vy) = (bx - ax, by - ay), (dx - cx, dy - cy)
    across = ux * vy - uy * vx
    if abs(across) <= NO_CORNER * hypot(ux, uy) * hypot(vx, vy):
        return bx, by
    share = ((cx - ax) * vy - (cy - ay) * vx) / across
    return ax + share * ux, ay + share * uy


def _makes(stroke: TorchStroke, edge: BevelledEdge, over: float) -> bool:
    """Whether a stroke is the pass of a bevel, `over` mm longer than its edge and half a kerf."""
    bevel, half = edge.bevel, stroke.row.kerf / 2
    if not stroke.is_tilted or len(stroke.points) < 3:
        return False
    slope = tan(radians(bevel.angle))
    wide = max((edge.thickness - bevel.land) * slope, -bevel.land * slope)
    for depth in (0.0, edge.thickness):
        at = (edge.thickness - bevel.land - depth) * tan(radians(bevel.angle))
        at -= half / cos(radians(bevel.angle))
        run = LineString(stroke.at(depth)[1:])
        least, most = (edge.inside(at, mm, wide) for mm in (half, half + over + OFF_PASS))
        if not (
            LineString(most).buffer(OFF_PASS, cap_style="flat").covers(run)
            and run.buffer(OFF_PASS, cap_style="square").covers(LineString(least))
        ):
            return False
    return True


def ends_of_passes(
    passes: Sequence[BevelPass], strokes: Sequence[TorchStroke], far: Mapping[int, bool],
    section: CoperSection,
) -> dict[int, bool]:  # fmt: skip
    """Whether passes are of the far end, by their lines, as the square cuts along them are; those
    through all of the wall and the cuts that end in their kerfs are of one end."""
    ends = dict(far)
    whole = [one.stroke for one in passes if one.edge.is_whole]
    square = [s for s in strokes if all(s is not one.stroke for one in passes)]
    for stroke in whole * len(whole):
        own = _ending_in(stroke, square)
        is_far = any(ends[line] for line in (stroke.line, *own))
        ends |= dict.fromkeys((stroke.line, *own), is_far)
    for one in passes:
        beside = [ends[line] for line in one.beside(strokes, section)]
        if not one.edge.is_whole:
            ends[one.stroke.line] = bool(beside) and beside[0]
    return ends


def _ending_in(stroke: TorchStroke, others: Sequence[TorchStroke]) -> list[int]:
    """The lines of the strokes on its wall that end in the kerf of a stroke."""
    way, reach = LineString(stroke.points), stroke.row.kerf / 2 / stroke.share
    return [s.line for s in others
            if s.face == stroke.face and way.distance(Place(s.points[-1])) <= reach]  # fmt: skip


def pass_faults(
    passes: Sequence[BevelPass], strokes: Sequence[TorchStroke], far: Mapping[int, bool],
    section: CoperSection, name: str,
) -> Iterator[Diagnostic]:  # fmt: skip
    """Passes before the square cut along their edge, or of a piece that is parted already.

    `far` says of each stroke by its line whether it is of the far end of a bar.
    """
    of_pass = {one.stroke.line for one in passes}
    square = [s for s in strokes if s.line not in of_pass]
    whole = [one.stroke for one in passes if one.edge.is_whole]
    parted = max((s.line for s in (*square, *whole) if far.get(s.line)), default=0)
    for one in passes:
        edge, line, along = one.edge, one.stroke.line, one.beside(square, section)
        x, y = one.stroke.points[0]
        expected = ""
        if edge.is_whole:
            if any(other < line for other in _ending_in(one.stroke, square)):
                expected = "before the square cuts beside it, whose kerfs its arc would cross"
            if along:
                whole_of = "no square cut along its edge, which goes through all of the wall"
                yield rules.PASSES.at(
                    Source(name, along[0]), face=one.stroke.face, expected=whole_of
                )
        elif edge.bevel.angle < 0.0:
            if not along or min(along) < line:
                expected = "before the square cut along its edge, through all of the wall"
        elif edge.strip(0.0).distance(Place(x, y)) > BESIDE:
            yield rules.AIR.at(Source(name, line), x=f"{x:.1f}", y=f"{y:.1f}", face=one.stroke.face)
        elif one.cut(section) and (not along or min(along) > line):
            expected = "after the square cut along its edge, which leaves the land"
        elif far.get(line) and line > parted:
            expected = "before the cut that parts the piece from its bar"
        if expected:
            yield rules.PASSES.at(Source(name, line), face=one.stroke.face, expected=expected)
