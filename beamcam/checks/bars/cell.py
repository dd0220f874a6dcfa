"""Simulation of a saw and drilling cell: events in; machined features and faults out.

Where the section is known the steel is: before its face a tool comes in rapid and keeps the
machine's clearance, behind it it is fed. Of a program alone the section is what its own words say,
which leaves a web's place between the flanges open: there the steel begins somewhere on the way of
the feed. The state and the M words stand in `cell_state`; here are the moves.
"""

from collections.abc import Callable, Iterable
from math import inf, isnan, nan
from typing import Any

from msgspec.structs import replace

from beamcam.checks import rules
from beamcam.checks.bars.cell_state import AXES, CellState
from beamcam.checks.bars.stations import (
    NOWHERE,
    Bore,
    Cut,
    MachinedFeatures,
    MachinedPath,
    StampedText,
    Station,
    Tip,
)
from beamcam.checks.bars.tools import EPSILON
from beamcam.controllers.dialect import WORD
from beamcam.controllers.events import (
    Acceleration,
    BarEvent,
    Blending,
    Compensation,
    Lettering,
    Move,
    Pause,
    Place,
    Switch,
)

_OTHER_WAY = {3: 4, 4: 3}
LONGEST_PAUSE_S = 60.0  #: a longer one is a slip, of milliseconds for seconds
WHOLE_TURN = 0.6  #: rpm that a speed may be rounded by
ROUNDED_FEED = 0.1  #: mm/min that a feed may be


class Cell(CellState):
    """The cell while a program runs; `run` gives the result."""

    def run(self, events: Iterable[BarEvent]) -> MachinedFeatures:
        """The features that the events make."""
        for event in events:
            self.line = event.line
            _TAKES[type(event)](self, event)
        made: dict[type, list[Any]] = {Cut: [], Bore: [], MachinedPath: [], StampedText: []}
        for one in self.order:
            made[type(one)].append(one)
        cuts, bores, paths, texts = map(tuple, made.values())
        section = tuple(self.section.items())
        return MachinedFeatures(section, cuts, bores, paths, tuple(self.order), texts)

    def _compensate(self, event: Compensation) -> None:
        if event.side != "on":
            self.say(WORD, "compensation", "none, of strokes")

    def _pause(self, event: Pause) -> None:
        """A dwell: of a few seconds, and in the steel only where the machine's own cycle has it."""
        if not 0.0 <= event.seconds <= LONGEST_PAUSE_S:
            self.say(WORD, f"a dwell of {event.seconds:g} s", f"0 to {LONGEST_PAUSE_S:g} s")
        elif event.seconds and not self.limits.dwells and self.in_steel() is not None:
            expected = "the tool drawn back, no cycle of this machine dwells"
            self.say(WORD, "a dwell in the material", expected)

    def _accelerate(self, event: Acceleration) -> None:
        most = max((a.acceleration for a in self.machine.axes), default=inf)
        if not 0.0 < event.mm_s2 <= most:
            found = f"an acceleration of {event.mm_s2:g} mm/s2"
            self.say(WORD, found, f"one above 0, at most {most:g}")

    def _blend(self, event: Blending) -> None:
        """Corners that the controller may pass off the path, which is the end of any stroke."""
        most = self.machine.drill.path_tolerance if self.machine.drill else 0.0
        if event.distance > most:
            found = f"corners passed {event.distance:g} mm off"
            self.say(WORD, found, f"at most {most:g} mm, or none")

    def _move(self, move: Move[Place]) -> None:
        start, end = move.start, move.end
        if move.curve is not None:
            self.say(WORD, "an arc", "straight strokes, the cell has no mill")
            return
        x = end[0]
        moved = x != self.x and not isnan(x)
        if moved:
            self._move_bar(x, self._follows_path(move))
        self.feed_mm_min = move.feed_mm_min
        if not move.rapid and move.feed_mm_min <= 0 and self.dialect.feeds:
            self.say(rules.NO_FEED, "move")
        stations = self.stations
        if not stations:
            if end[1:] != start[1:]:
                self.say(rules.NO_SPINDLE, "a move of Y or Z")
            return
        first = stations[0]
        across, stroke = end[first.across], end[first.stroke]
        if isnan(stroke + across):
            # A tool that goes where steel may be before its place across is known.
            is_new = end[first.stroke] != start[first.stroke] and not isnan(stroke)
            if is_new and first.tip(first.across_0, stroke).beside > EPSILON:
                axis, other = AXES[first.stroke], AXES[first.across]
                found = f"{axis} at {stroke:g} with {other} unknown"
                self.say(WORD, found, f"{other} before, or {axis} free of the bar")
            return
        at = self.at
        before = at.get(first.number, NOWHERE)
        sideways = moved or across != before.across
        if not sideways and stroke == before.stroke:
            return
        for station in stations:
            at[station.number] = station.tip(across, stroke)
            for index, axis, least, greatest in station.limits:
                if not least <= end[index] <= greatest:
                    self.say_beyond(axis, end[index], least, greatest)
        # The controller starts from its last position, even if that was another spindle's.
        sideways = sideways or across != start[first.across]
        if sideways and self._move_aside(move, first, before, moved):
            return
        for station in stations:
            self._enter(move, station, before.stroke)

    def _move_aside(self, move: Move[Place], first: Station, before: Tip, moved: bool) -> bool:
        """A move along or across the bar; whether nothing is left to be checked."""
        tip = self.at[first.number]
        inside, was_inside = tip.beside, before.beside
        if inside > EPSILON or was_inside > EPSILON:
            if was_inside > EPSILON and self._follows_path(move):
                self._follow_path(move, first, tip)
                return True
            letter = "X" if moved else AXES[first.across]
            at = before.stroke if was_inside > inside else tip.stroke
            self.say_sideways(f"a move of {letter}", first, at)
            return True
        self.fed_from.clear()
        gap = first.retract_clearance
        least = gap - self.limits.step
        if move.rapid and (-inside < least or -was_inside < least):
            nearest = inside if isnan(was_inside) else max(inside, was_inside)
            self._say_too_close(first, -nearest, gap)
            return True
        return False

    def _say_too_close(self, station: Station, gap: float, least: float) -> None:
        found = f"{round(gap, 3) + 0.0:.3f}"
        self.say(rules.CLEARANCE, found, f"{least:g}", face=station.face)

    def _follows_path(self, move: Move[Place]) -> bool:
        """Whether the tool that is chosen may follow a path in the material, and does."""
        return self.cycle.along and not move.rapid and self.in_steel() is not None

    def _follow_path(self, move: Move[Place], station: Station, tip: Tip) -> None:
        """A tool fed on in the material; the point that it went in at is the path's first."""
        self._check_feed(move, station)
        point, depth = (move.end[0], tip.y), tip.depth
        last = self.order[-1] if self.order else None
        if type(last) is Bore and last.kind == self.cycle.kind:
            self.order[-1] = MachinedPath(
                last.line, last.face, last.kind, ((last.x, last.y), point), last.diameter,
                min(last.tip_depth, depth), max(last.tip_depth, depth), last.spindle,
                last.feed_mm_min,
            )  # fmt: skip
        elif type(last) is MachinedPath and self.peck is not None:
            self.order[-1] = replace(
                last,
                points=(*last.points, point),
                min_depth=min(last.min_depth, depth),
                max_depth=max(last.max_depth, depth),
                feed_mm_min=max(last.feed_mm_min, move.feed_mm_min),
            )
        self.peck = (self.x, tip.across)

    def _check_feed(self, move: Move[Place], station: Station) -> None:
        """Report what is missing for a feed into the material, and what is wrong with the feed."""
        cycle = self.cycle
        if cycle.turns and not self.turning:
            self.say(rules.SPINDLE_OFF, face=station.face)
        elif self.turning != cycle.turns:
            self.say(rules.TURN, self.turning, cycle.turns)
        if cycle.cools and not self.cooling:
            self.say(rules.COOLANT, "a feed into the material", "on")
        if not cycle.feeds:
            return
        if cycle.kind == "tap":
            self._check_tap_feed(move, "in", self.pitch * self.speed_rpm or move.feed_mm_min)
            self.tapped_mm_min = move.feed_mm_min
        permitted = self.permitted
        if permitted is None:
            return
        feed, most = move.feed_mm_min, permitted.most_feed
        if self.turning and self.speed_rpm:
            # Slower turns with the same feed load each cutting edge more.
            most = min(most, permitted.most_per_turn * self.speed_rpm + 0.1)
        if not permitted.min_feed <= feed <= most:
            self.say_feed(feed, self.tool, permitted.own_feed, most)

    def _move_bar(self, x: float, follows_path: bool) -> None:
        name, least, greatest = self.limits.stop
        if not least <= x <= greatest:
            self.say_beyond(name, x, least, greatest)
        if self.limits.never_back and x < self.furthest - EPSILON:
            self.say(rules.STOP_BACK, f"{x:g}", before=f"{self.furthest:g}")
        self.furthest = x if isnan(self.furthest) else max(x, self.furthest)
        self.x = x
        if follows_path:
            return
        if self.turning:
            self.say(rules.SPINDLE_ON, "a move of the bar")
        if self.cooling:
            self.say(rules.COOLANT, "a move of the bar", "off")
        self.peck = None

    def _enter(self, move: Move[Place], station: Station, before: float) -> None:
        """One station's stroke axis on its way into the bar, or out of it."""
        tip = self.at[station.number]
        inward = not station.way * (before - tip.stroke) >= 0  # from nowhere counts too
        if not inward:
            self.fed_since.pop(station.number, None)
            if self.cycle.kind == "tap":
                self._draw_tap(move, station, tip, before)
            return
        if move.rapid:
            self._approach(station, tip)
            return
        if isnan(before):
            return
        self.fed_to[station.number] = self.x, tip.across, tip.depth
        if station.surface_known:
            enters = tip.depth > EPSILON
        else:
            enters = tip.beside > EPSILON
            self.unseen.add(station.face)
        if enters:
            self.fed_from.setdefault(station.number, before)
            most = self.limits.max_pecks.get(self.diameter)
            if most is not None and self.cycle.kind == "drill":
                self._check_peck(station, tip, before, most)
            self._stroke(move, station, tip, before)

    def _check_peck(self, station: Station, tip: Tip, before: float, most: float) -> None:
        """A drill fed deeper at once than its chips allow; before the steel it cuts nothing."""
        drilled = self._drilled(station, tip)
        start = drilled or station.tip_depth(before, tip.y)
        if station.surface_known:
            start = max(start, 0.0)
        elif not drilled:
            most += station.approach_clearance
        fed = tip.depth - self.fed_since.setdefault(station.number, start)
        if fed > most + self.limits.step:
            self.say(rules.PECK, f"{fed:.3f}", f"{most:g}", what=self.tool)

    def _draw_tap(self, move: Move[Place], station: Station, tip: Tip, before: float) -> None:
        """Retract of a tap, which has to be screwed out as it was screwed in."""
        if station.tip_depth(before, tip.y) > max(tip.depth, 0.0) + EPSILON:
            back = _OTHER_WAY.get(self.cycle.turns, 0)
            if self.cycle.cools and not self.cooling:
                self.say(rules.COOLANT, "a tap drawn back", "on")
            if move.rapid or self.turning != back:
                self.say(rules.TURN, 0 if move.rapid else self.turning, back)
            else:
                out = self.pitch * self.speed_rpm or self.tapped_mm_min
                self._check_tap_feed(move, "out", out)

    def _check_tap_feed(self, move: Move[Place], way: str, feed: float) -> None:
        """A tap's feed, which is its pitch each turn; speeds are written as whole turns a minute.

        Where the program does not say the speed, the tap has to come out as it went in.
        """
        if abs(move.feed_mm_min - feed) > WHOLE_TURN * self.pitch + ROUNDED_FEED:
            found, expected = f"{move.feed_mm_min:.6g}", f"{feed:.6g}"
            self.say(rules.TAP, found, expected, pitch=f"{self.pitch:g}", way=way)

    def _approach(self, station: Station, tip: Tip) -> None:
        """A rapid towards the bar: to its clearance, or into what is drilled already."""
        depth, gap = tip.depth, station.approach_clearance
        if not station.surface_known:
            depth, gap = tip.beside, station.retract_clearance
            if depth > EPSILON:
                self.unseen.add(station.face)
                return
        elif not station.clear_from <= tip.y <= station.clear_to:  # through the flange's edge
            depth, gap = tip.beside, station.retract_clearance
        drilled = self._drilled(station, tip)
        if depth > drilled + EPSILON:
            axis, shown = AXES[station.stroke], f"{depth:.3f}"
            self.say(rules.RAPID, f"{tip.stroke:g}", axis=axis, depth=shown)
        elif not drilled and -depth < gap - self.limits.step:
            # Where it was fed as deep at the same place just before, it may go in rapid again.
            x, across, fed = self.fed_to.get(station.number, (nan, nan, nan))
            if (x, across) != (self.x, tip.across) or depth > fed:
                self._say_too_close(station, -depth, station.approach_clearance)

    def _drilled(self, station: Station, tip: Tip) -> float:
        """Current depth of the hole under the tool."""
        if self.peck != (self.x, tip.across):
            return 0.0
        return max(
            (b.tip_depth for b in self.order[-self.pecked :]
             if type(b) is Bore and b.face == station.face),
            default=0.0,
        )  # fmt: skip

    def _stroke(self, move: Move[Place], station: Station, tip: Tip, before: float) -> None:
        self._check_feed(move, station)
        self.idle = False
        if self.cycle.feeds and not move.own_feed and move.feed_mm_min > 0:
            self.say(rules.NO_FEED, "stroke of " + self.tool)
        self.check_described()
        bore = Bore(
            self.line, station.face, self.x, tip.y, self.diameter, tip.depth,
            self.spindle, move.feed_mm_min, tip.stroke, self.cycle.kind, self.turning, self.pitch,
            self.speed_rpm, before,
        )  # fmt: skip
        if self.peck == (self.x, tip.across):  # deeper in the same hole
            for index in range(len(self.order) - self.pecked, len(self.order)):
                old = self.order[index]
                if type(old) is Bore and old.face == station.face:
                    if tip.depth > old.tip_depth:
                        self.order[index] = bore
                    return
            self.pecked += 1
        else:
            self.peck = (self.x, tip.across)
            self.pecked = 1
        self.order.append(bore)


#: How the cell takes each kind of event.
_TAKES: dict[type, Callable[[Cell, Any], None]] = {
    Move: Cell._move, Switch: Cell.switch, Lettering: Cell.letter, Compensation: Cell._compensate,
    Blending: Cell._blend, Pause: Cell._pause, Acceleration: Cell._accelerate,
}  # fmt: skip
