"""Path of the beam under the controller's own kerf compensation.

The rules are those of LinuxCNC's interpreter, the strictest of the controllers with such words:

    entry       the first move is straight and longer than the radius; it ends beside its end
    convex      an arc round the corner joins the two moves beside the path
    concave     the move before is cut short where both cross; if it would have to run backwards,
                or an arc farther than it is long, the tool cannot get there without gouging
    inside      an arc with the tool inside has to be larger than the tool

Moves that turn by less than `STRAIGHT_RAD` are joined as they are. The last move ends beside its
end.

Source: LinuxCNC documentation, "Cutter Compensation"; its interp_convert.cc and interp_queue.cc.
"""

from collections.abc import Sequence
from math import atan2, cos, degrees, dist, pi, sin

from msgspec import Struct
from msgspec.structs import replace

from beamcam.checks.sheets import rules
from beamcam.checks.sheets.strokes import HeadStroke, Strokes
from beamcam.controllers.events import HeadMove, Move, Side
from beamcam.controllers.moves import moves_of
from beamcam.errors import Diagnostic, Source
from beamcam.geometry.curves import Arc, Line
from beamcam.geometry.offset import intersections
from beamcam.geometry.plane import Point

STRAIGHT_RAD = 0.05
LONGER_RAD = 0.001  #: by which an arc may grow
TINY = 1e-9
GOUGES = "a concave corner that cannot be reached without gouging"


class CompensationError(Exception):
    """The controller would stop at a line, and why."""

    def __init__(self, line: int, found: str) -> None:
        super().__init__(found)
        self.line, self.found = line, found


class _Move(Struct):
    """A line, or an arc with its centre and its turn: 1 counter-clockwise, -1 clockwise."""

    line: int
    end: Point
    centre: Point | None = None
    turn: int = 0
    along: Point = (0.0, 0.0)  #: of a line as it was programmed
    sweep: float = 0.0  #: of an arc as it was programmed, rad; 0 for one round a corner

    @property
    def whole(self) -> Line | Arc:
        """A line along all of it, or its circle."""
        if self.centre is not None:
            return Arc(self.centre, dist(self.centre, self.end), 0.0, 360.0)
        (x, y), (dx, dy) = self.end, self.along
        return Line((x - dx, y - dy), self.end)


def compensated(legs: Sequence[HeadMove], side: Side, radius: float) -> list[HeadMove]:
    """The moves of the beam for those of one stroke.

    Raises CompensationError where the controller would stop.
    """
    path = _OffsetPath(side, radius, legs[0].start)
    for leg in legs:
        path.go(leg)
    return path.legs(legs[0].feed_mm_min)


class _OffsetPath:
    """The path of the beam beside the programmed one.

    Its last move waits, since the next may cut it short.
    """

    def __init__(self, side: Side, radius: float, start: Point) -> None:
        self._left = 1 if side == "left" else -1
        self._radius = radius
        self._first = start
        self._done: list[_Move] = []
        self._waiting: _Move | None = None
        self._programmed = start
        self._here = start  #: beside the programmed place
        self._from: Point | None = None  #: where the waiting move begins, behind the entry

    def go(self, leg: HeadMove) -> None:
        """One more programmed move."""
        if leg.end == self._programmed and leg.curve is None:
            return
        if leg.curve is not None and not isinstance(leg.curve, Arc):
            raise CompensationError(leg.line, "compensation along a curve that is no arc")
        (x0, y0), entry = self._programmed, self._waiting is None
        if leg.curve is None:
            along = (leg.end[0] - x0, leg.end[1] - y0)
            normal = atan2(along[1], along[0]) + self._left * pi / 2
            move = _Move(leg.line, _polar(leg.end, self._radius, normal), along=along)
            if entry and (length := dist(leg.start, leg.end)) <= self._radius:
                found = f"an entry of {length:.4f} mm, the radius or less"
                raise CompensationError(leg.line, found)
        elif entry:
            raise CompensationError(leg.line, "compensation that begins along a curve")
        else:
            centre, turn = leg.curve.centre, 1 if leg.curve.sweep_deg > 0.0 else -1
            move = self._arc(leg, centre, turn)
            ahead = atan2(y0 - centre[1], x0 - centre[0]) + turn * pi / 2
            normal = ahead + self._left * pi / 2
        if entry:
            self._waiting = move
        else:
            self._corner(leg, move, normal)
        self._here, self._programmed = move.end, leg.end

    def _inside(self, turn: int) -> bool:
        return self._left * turn > 0

    def _arc(self, leg: HeadMove, centre: Point, turn: int) -> _Move:
        """The arc beside a programmed one."""
        size = dist(centre, leg.end)
        if self._inside(turn) and size <= self._radius:
            found = f"an arc of radius {size:.4f} with the tool inside, no larger than its radius"
            raise CompensationError(leg.line, found)
        out = atan2(leg.end[1] - centre[1], leg.end[0] - centre[0])
        away = -self._radius if self._inside(turn) else self._radius
        sweep = _sweep(self._programmed, leg.end, centre, turn)
        return _Move(leg.line, _polar(leg.end, away, out), centre, turn, sweep=sweep)

    def _corner(self, leg: HeadMove, move: _Move, normal: float) -> None:
        """Joins the waiting move to the next, to whose path that of the tool is `normal`."""
        x0, y0 = self._programmed
        before = self._waiting
        assert before is not None
        to_here = atan2(self._here[1] - y0, self._here[0] - x0)
        # Above 0 where the next move turns away from the tool: -90 to 270 degrees.
        beta = (self._left * (to_here - normal) + pi / 2) % (2 * pi) - pi / 2

        # It may run back on an arc with the tool outside, or from one on a line.
        outside, was_outside = (
            one.centre is not None and not self._inside(one.turn) for one in (move, before)
        )
        concave = beta < -STRAIGHT_RAD or beta > pi + STRAIGHT_RAD
        concave = concave or (abs(beta - pi) < STRAIGHT_RAD and outside)
        concave = concave or (beta > pi - STRAIGHT_RAD and move.centre is None and was_outside)
        if concave:
            self._shorten(before, self._meeting(leg, before, move))
        elif beta > STRAIGHT_RAD and move.centre is None:
            self._shorten(before, before.end)
        self._done.append(before)
        if not concave and beta > STRAIGHT_RAD:
            middle = _polar(self._programmed, self._radius, normal)
            self._done.append(_Move(leg.line, middle, self._programmed, -self._left))
        self._from, self._waiting = self._done[-1].end, move

    def _meeting(self, leg: HeadMove, before: _Move, move: _Move) -> Point:
        """Where two moves beside a concave corner cross, nearest to that."""
        if before.centre and move.centre and dist(before.centre, move.centre) < TINY:
            raise CompensationError(leg.line, "two arcs about one centre in a corner")
        points = intersections(before.whole, move.whole)
        if not points:
            lines = before.centre is None and move.centre is None
            raise CompensationError(leg.line, "a corner of zero degrees" if lines else GOUGES)
        return min(points, key=lambda point: dist(point, self._here))

    def _shorten(self, before: _Move, end: Point) -> None:
        """Lets the waiting move end elsewhere; one that cannot is refused."""
        gouges = False
        if self._from is not None and before.centre is None:
            x, y = end[0] - self._from[0], end[1] - self._from[1]
            gouges = before.along[0] * x + before.along[1] * y < 0.0
        elif self._from is not None and before.centre is not None and before.sweep:
            sweep = _sweep(self._from, end, before.centre, before.turn)
            gouges = abs(sweep) > abs(before.sweep) + LONGER_RAD
        if gouges:
            raise CompensationError(before.line, GOUGES)
        before.end = end

    def legs(self, feed: float) -> list[HeadMove]:
        """All moves of the beam."""
        if self._waiting is not None:
            self._shorten(self._waiting, self._waiting.end)
            self._done.append(self._waiting)
        here = self._first
        legs = []
        for move in self._done:
            curve = None
            if move.centre is not None:
                sweep = _sweep(here, move.end, move.centre, move.turn)
                start = atan2(here[1] - move.centre[1], here[0] - move.centre[0])
                size = dist(here, move.centre)
                curve = Arc(move.centre, size, degrees(start), degrees(sweep))
            if curve is not None or here != move.end:
                legs.append(Move(move.line, False, here, move.end, feed, False, curve))
            here = move.end
        return legs


def _polar(at: Point, away: float, angle: float) -> Point:
    return at[0] + away * cos(angle), at[1] + away * sin(angle)


def _sweep(start: Point, end: Point, centre: Point, turn: int) -> float:
    """The angle from a start to an end about a centre; a whole circle where they are the same."""
    first = atan2(start[1] - centre[1], start[0] - centre[0])
    last = atan2(end[1] - centre[1], end[0] - centre[0])
    angle = (turn * (last - first)) % (2 * pi)
    if angle < TINY or dist(start, end) < TINY:
        angle = 2 * pi
    return turn * angle


def beam_of(strokes: Strokes, name: str) -> tuple[Strokes, list[Diagnostic]]:
    """The strokes as the beam runs them, and where the controller would stop.

    Those that it would not carry out are left as they are programmed.
    """
    legs = list(strokes.moves.each())
    diagnostics: list[Diagnostic] = []
    each: list[HeadStroke] = []
    moved: list[HeadMove] = []
    for stroke in strokes.each:
        own = legs[stroke.first : stroke.last]
        if stroke.side != "on" and stroke.radius > 0.0:
            try:
                own = compensated(own, stroke.side, stroke.radius)
            except CompensationError as error:
                source = Source(name, error.line)
                diagnostics.append(rules.COMPENSATION.at(source, found=error.found))
        each.append(replace(stroke, first=len(moved), last=len(moved) + len(own)))
        moved += own
    return Strokes(each, moves_of(moved)), diagnostics
