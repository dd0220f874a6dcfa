"""A saw and drilling cell at work: events in, what they make out, and what would break.

The state and the M words stand in `switches`; here are the moves.
"""

from collections.abc import Iterable
from math import isnan, nan
from typing import NoReturn

from beamcam.verify import rules
from beamcam.verify.events import Event, Move, Pause, Switch, Turn
from beamcam.verify.made import Bore, Made, Trail, made_in_order
from beamcam.verify.stations import Choice, Station
from beamcam.verify.switches import AXES, EPSILON, Switches

_OTHER_WAY = {3: 4, 4: 3}


class Cell(Switches):
    """The cell while a program runs; `run` gives what came of it."""

    def run(self, events: Iterable[Event], last_line: int) -> Made:
        """What the events make."""
        self.play(events)
        if not self.ended:
            self.say(rules.NO_END, max(last_line, 1), found="the end of the program")
        return made_in_order(tuple(self.section.items()), self.order)

    def play(self, events: Iterable[Event]) -> None:
        """Go through events, up to the program's end at most."""
        for event in events:
            if self.ended:
                self.say(rules.NO_END, event.line, found="a block behind M30")
                return
            if type(event) is Move:
                self._move(event)
            elif type(event) is Switch:
                self.switch(event)
            elif type(event) is Turn:
                self._turn(event)
            elif type(event) is not Pause:
                _unknown(event)

    def _move(self, move: Move) -> None:
        x = move.end[0]
        moved = x != self.x and not isnan(x)
        if moved:
            self._move_bar(x, move, self.cycle.along and self._in_work(move))
        self.feed_mm_min = move.feed_mm_min
        if not move.rapid and self.meaning.feeds and move.feed_mm_min <= 0:
            self.say(rules.NO_FEED, move.line, found="feed")
        choice = self.choice
        if choice is None:
            if move.end[1:] != move.start[1:]:
                self.say(rules.NO_SPINDLE, move.line, found="a move of Y or Z")
            return
        first = choice.stations[0]
        across, stroke = move.end[first.across], move.end[first.stroke]
        if isnan(stroke) or isnan(across):
            return
        before = self.at.get(first.number, (nan, nan))
        if not moved and before == (across, stroke):
            return
        for station in choice.stations:
            self.at[station.number] = (across, stroke)
            for index, axis, least, greatest in station.limits:
                if not least <= move.end[index] <= greatest:
                    self.beyond(move.line, axis, move.end[index], least, greatest)
        if not self.known:
            self._stroke_somewhere(move, choice, across, stroke, before, moved)
            return
        outer = first.depth_beside(stroke, first.y(across))
        was_out = first.depth_beside(before[1], first.y(before[0]))
        # The controller starts from its own last place, whichever spindle that was for.
        aside = moved or across != before[0] or across != move.start[first.across]
        if aside and (outer > EPSILON or was_out > EPSILON):
            if self._in_work(move) and was_out > EPSILON:
                self._lead(move, first, across, stroke)
                return
            letter = "X" if moved else AXES[first.across]
            self.sideways(
                move.line, f"a move of {letter}", first, before[1] if was_out > outer else stroke
            )
            return
        for station in choice.stations:
            self._enter(move, station, choice, across, stroke, before[1])

    def _in_work(self, move: Move) -> bool:
        """Whether the tool that is chosen may be led along a path, and is."""
        if not self.cycle.along or move.rapid or self.choice is None:
            return False
        first = self.choice.stations[0]
        across, stroke = self.at.get(first.number, (nan, nan))
        return first.tip_depth(stroke, first.y(across)) > EPSILON

    def _lead(self, move: Move, station: Station, across: float, stroke: float) -> None:
        """A tool led on in the material; the point that it went in at is the path's first."""
        self._ready(move, station)
        point = (move.end[0], station.y(across))
        depth = station.tip_depth(stroke, point[1])
        last = self.order[-1] if self.order else None
        if type(last) is Bore and last.kind == self.cycle.kind:
            self.order[-1] = Trail(
                last.line,
                last.face,
                last.kind,
                ((last.x, last.y), point),
                last.diameter,
                min(last.tip_depth, depth),
                max(last.tip_depth, depth),
                last.spindle,
                last.feed_mm_min,
            )
        elif type(last) is Trail and self.peck is not None:
            self.order[-1] = last._replace(
                points=(*last.points, point),
                least_depth=min(last.least_depth, depth),
                greatest_depth=max(last.greatest_depth, depth),
                feed_mm_min=max(last.feed_mm_min, move.feed_mm_min),
            )
        self.peck = (self.x, across)

    def _ready(self, move: Move, station: Station) -> None:
        """Say what is missing for a feed into the material."""
        if self.cycle.turns and not self.turning:
            self.say(rules.SPINDLE_OFF, move.line, face=station.face)
        elif self.turning != self.cycle.turns and self.known:
            self.say(rules.TURN, move.line, found=self.turning, expected=self.cycle.turns)
        if self.cycle.cools and not self.cooling:
            self.say(rules.COOLANT, move.line, found="a feed into the material", expected="on")

    def _move_bar(self, x: float, move: Move, in_work: bool) -> None:
        name, least, greatest = self.stop_limits
        if not least <= x <= greatest:
            self.beyond(move.line, name, x, least, greatest)
        if self.never_back and x < self.furthest - EPSILON:
            self.say(rules.STOP_BACK, move.line, found=f"{x:g}", before=f"{self.furthest:g}")
        self.furthest = x if isnan(self.furthest) else max(x, self.furthest)
        self.x = x
        if in_work:
            return
        if self.turning:
            self.say(rules.SPINDLE_ON, move.line, found="a move of the bar")
        if self.cooling:
            self.say(rules.COOLANT, move.line, found="a move of the bar", expected="off")
        self.peck = None

    def _enter(
        self, move: Move, station: Station, choice: Choice, across: float, stroke: float,
        before: float,
    ) -> None:  # fmt: skip
        """One station's stroke axis on its way into the bar, or out of it."""
        y = station.y(across)
        depth, was = station.tip_depth(stroke, y), station.tip_depth(before, y)
        if self.cycle.kind == "tap" and was > max(depth, 0.0) + EPSILON:
            back = _OTHER_WAY.get(self.cycle.turns, 0)
            if move.rapid or self.turning != back:  # it has to be screwed out as it was in
                found = 0 if move.rapid else self.turning
                self.say(rules.TURN, move.line, found=found, expected=back)
        if move.rapid:
            if not station.clear_from <= y <= station.clear_to:  # through the flange's edge
                depth = station.depth_beside(stroke, y)
            deeper = depth > EPSILON and not station.way * (before - stroke) > 0
            if deeper and depth > self._drilled(station, across) + EPSILON:
                self.say(
                    rules.RAPID, move.line, axis=AXES[station.stroke],
                    found=f"{stroke:g}", depth=f"{depth:.3f}",
                )  # fmt: skip
            return
        if depth <= EPSILON or station.way * (stroke - before) <= 0:
            return
        self._stroke(move, station, choice, across, stroke, depth)

    def _drilled(self, station: Station, across: float) -> float:
        """How deep the hole under the tool is already."""
        if self.peck != (self.x, across):
            return 0.0
        return max(
            (b.tip_depth for b in self.order[-self.pecked :]
             if type(b) is Bore and b.face == station.face),
            default=0.0,
        )  # fmt: skip

    def _stroke(
        self, move: Move, station: Station, choice: Choice, across: float, stroke: float,
        depth: float,
    ) -> None:  # fmt: skip
        self._ready(move, station)
        self.describe_first(move.line)
        bore = Bore(
            move.line, station.face, self.x, station.y(across), self.diameter, depth,
            choice.number, move.feed_mm_min, stroke, self.cycle.kind, self.turning, self.pitch,
        )  # fmt: skip
        if self.peck == (self.x, across):  # deeper in the same hole
            for index in range(len(self.order) - self.pecked, len(self.order)):
                old = self.order[index]
                if type(old) is Bore and old.face == station.face:
                    if depth > old.tip_depth:
                        self.order[index] = bore
                    return
            self.pecked += 1
        else:
            self.peck = (self.x, across)
            self.pecked = 1
        self.order.append(bore)

    def _stroke_somewhere(
        self, move: Move, choice: Choice, across: float, stroke: float,
        before: tuple[float, float], moved: bool,
    ) -> None:  # fmt: skip
        """A feed along the stroke alone, on a section that is not known: it makes a hole."""
        if move.rapid or moved or across != before[0]:
            return
        for station in choice.stations:
            if station.way * (stroke - before[1]) > 0:
                depth = station.tip_depth(stroke, station.y(across))
                self._stroke(move, station, choice, across, stroke, depth)

    def _turn(self, turn: Turn) -> None:
        self.say(
            rules.WORD, turn.line, found="an arc",
            expected="straight strokes, the cell has no mill",
        )  # fmt: skip


def _unknown(event: object) -> NoReturn:
    raise AssertionError(f"no rule for {event!r}")
