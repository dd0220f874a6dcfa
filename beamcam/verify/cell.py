"""A saw and drilling cell at work: events in, what they make out, and what would break.

    state        changed by                      asked when
    spindle      the choosing word               Y or Z move: whose axes are they?
    turning      M03, M04, M05                   a feed goes into material; the bar moves
    cooling      M07, M08, M09                   likewise, if the machine's cycles cool
    places       moves; each spindle its own     a move begins: is the tool still in the bar?

A spindle's axes stay where they are while another one works, so each keeps its places.
"""

from math import isnan, nan
from typing import NoReturn

from beamcam.errors import Diagnostic, Rule, Source
from beamcam.machine.machine import Machine
from beamcam.model.part import Profile
from beamcam.verify import rules
from beamcam.verify.events import Event, Move, Pause, Switch, Turn
from beamcam.verify.made import Bore, Cut, Made, Trail
from beamcam.verify.meaning import Cycle, Meaning, MWord
from beamcam.verify.stations import Choice, Station, limits_of

_EPSILON = 1e-6
_LETTERS = "XYZ"
_OTHER_WAY = {3: 4, 4: 3}
_NO_CYCLE = Cycle("drill", 0, False, False)


class Cell:
    """The state of the cell while a program runs; `run` gives what came of it."""

    def __init__(
        self, machine: Machine, meaning: Meaning, choices: dict[int, Choice],
        profile: Profile | None, name: str,
    ) -> None:  # fmt: skip
        self.machine = machine
        self.meaning = meaning
        self.choices = choices
        self.known = profile is not None  #: whether it is known where material is
        self.name = name
        self.said: list[Diagnostic] = []
        self.section: dict[str, float] = {}
        self.order: list[Cut | Bore | Trail] = []
        self.choice: Choice | None = None
        self.diameter = 0.0
        self.cycle = _NO_CYCLE  #: of the tool that is chosen
        self.pitch = 0.0
        self.turning = 0  #: the M word that started the spindle
        self.cooling = False
        self.x = self.furthest = self.feed_mm_min = nan
        self.at: dict[int, tuple[float, float]] = {}  #: across and stroke of each spindle
        self.peck: tuple[float, float] | None = None  #: X and across of the hole being drilled
        self.pecked = 0  #: how many bores the last stroke made
        self.ended = False
        self.stop_limits = limits_of(machine, "X")
        self.never_back = machine.layout is not None and machine.layout.order == "saw-drill"

    def say(self, rule: Rule, line: int, **values: object) -> None:
        self.said.append(rule.at(Source(self.name, line), **values))

    def run(self, events: list[Event], last_line: int) -> Made:
        """What the events make."""
        for event in events:
            if self.ended:
                self.say(rules.NO_END, event.line, found="a block behind M30")
                break
            if type(event) is Move:
                self._move(event)
            elif type(event) is Switch:
                self._switch(event)
            elif type(event) is Turn:
                self._turn(event)
            elif type(event) is not Pause:
                _unknown(event)
        if not self.ended:
            self.say(rules.NO_END, max(last_line, 1), found="the end of the program")
        order = tuple(self.order)
        return Made(
            tuple(self.section.items()),
            tuple(o for o in order if type(o) is Cut),
            tuple(o for o in order if type(o) is Bore),
            tuple(o for o in order if type(o) is Trail),
            order,
        )

    # Moves

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
                    self._beyond(move.line, axis, move.end[index], least, greatest)
        if not self.known:
            self._stroke_somewhere(move, choice, across, stroke, before, moved)
            return
        outer = first.way * (stroke - first.outermost)
        was_out = first.way * (before[1] - first.outermost)
        # The controller starts from its own last place, whichever spindle that was for.
        aside = moved or across != before[0] or across != move.start[first.across]
        if aside and (outer > _EPSILON or was_out > _EPSILON):
            if self._in_work(move) and was_out > _EPSILON:
                self._lead(move, first, across, stroke)
                return
            letter = "X" if moved else _LETTERS[first.across]
            self._sideways(
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
        _, stroke = self.at.get(first.number, (nan, nan))
        return first.tip_depth(stroke) > _EPSILON

    def _lead(self, move: Move, station: Station, across: float, stroke: float) -> None:
        """A tool led on in the material; the point that it went in at is the path's first."""
        self._ready(move, station)
        depth = station.tip_depth(stroke)
        point = (move.end[0], station.y(across))
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
            self._beyond(move.line, name, x, least, greatest)
        if self.never_back and x < self.furthest - _EPSILON:
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

    def _beyond(self, line: int, axis: str, at: float, least: float, greatest: float) -> None:
        self.say(
            rules.LIMIT, line, axis=axis, found=f"{at:g}", least=f"{least:g}",
            greatest=f"{greatest:g}",
        )  # fmt: skip

    def _sideways(self, line: int, what: str, station: Station, at: float) -> None:
        self.say(
            rules.SIDEWAYS, line, found=what, face=station.face,
            axis=_LETTERS[station.stroke], at=f"{at:g}",
        )  # fmt: skip

    def _enter(
        self, move: Move, station: Station, choice: Choice, across: float, stroke: float,
        before: float,
    ) -> None:  # fmt: skip
        """One station's stroke axis on its way into the bar, or out of it."""
        depth = station.tip_depth(stroke)
        if self.cycle.kind == "tap" and station.tip_depth(before) > max(depth, 0.0) + _EPSILON:
            back = _OTHER_WAY.get(self.cycle.turns, 0)
            if move.rapid or self.turning != back:  # it has to be screwed out as it was in
                found = 0 if move.rapid else self.turning
                self.say(rules.TURN, move.line, found=found, expected=back)
        if move.rapid:
            y = station.y(across)
            if not station.clear_from <= y <= station.clear_to:  # through the flange's edge
                depth = station.way * (stroke - station.outermost)
            deeper = depth > _EPSILON and not station.way * (before - stroke) > 0
            if deeper and depth > self._drilled(station, across) + _EPSILON:
                self.say(
                    rules.RAPID, move.line, axis=_LETTERS[station.stroke],
                    found=f"{stroke:g}", depth=f"{depth:.3f}",
                )  # fmt: skip
            return
        if depth <= _EPSILON or station.way * (stroke - before) <= 0:
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
        self._describe_first(move.line)
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
                depth = station.tip_depth(stroke)
                self._stroke(move, station, choice, across, stroke, depth)

    def _turn(self, turn: Turn) -> None:
        self.say(
            rules.WORD, turn.line, found="an arc",
            expected="straight strokes, the cell has no mill",
        )  # fmt: skip

    # Switches

    def _switch(self, switch: Switch) -> None:
        word = self.meaning.m_words.get(switch.number)
        if word is None:
            self.say(
                rules.WORD, switch.line, found=f"M{switch.number:02}",
                expected=f"a word of this machine: {self.meaning.shown()}",
            )  # fmt: skip
            return
        values = self._values(switch, word) if word.fields or switch.words else {}
        role = word.role
        if role == "on":
            self.turning = switch.number
            if self.choice is None:
                self.say(rules.NO_SPINDLE, switch.line, found="a spindle that starts")
        elif role == "off":
            self.turning = 0
        elif role == "coolant-on":
            self.cooling = True
        elif role == "coolant-off":
            self.cooling = False
        elif values is None:
            return
        elif role == "choose":
            self._choose(switch, values, word.cycle or _NO_CYCLE)
        elif role == "saw":
            self._saw(switch, values)
        elif role == "section":
            self.section.update(values)
        elif role == "other":
            self.pitch = values.get("pitch", self.pitch)
        elif role == "end":
            self._at_rest(switch.line, "the end of the program")
            self.ended = True

    def _values(self, switch: Switch, word: MWord) -> dict[str, float] | None:
        """The word's parameters by what they carry; None (and said) where one is missing."""
        shown = f"M{switch.number:02}"
        for letter in switch.words:
            if all(letter != known for known, _ in word.fields):
                self.say(
                    rules.WORD, switch.line, found=f"{letter} behind {shown}",
                    expected="no such parameter",
                )  # fmt: skip
        values: dict[str, float] = {}
        for letter, field in word.fields:
            if letter not in switch.words:
                self.say(
                    rules.WORD, switch.line, found=f"{shown} without {letter}",
                    expected=f"{letter} with the {field}",
                )  # fmt: skip
                return None
            value = switch.words[letter]
            said_before = self.section.get(field, nan)
            if said_before != value and not isnan(said_before):
                self.say(
                    rules.SECTION, switch.line, what=field, found=f"{value:g}",
                    expected=f"{said_before:g}, as before",
                )  # fmt: skip
            if values.setdefault(field, value) != value:
                self.say(
                    rules.WORD, switch.line, found=f"{letter}{value:g} behind {shown}",
                    expected=f"{values[field]:g}, the {field} a second time",
                )  # fmt: skip
        return values

    def _at_rest(self, line: int, what: str) -> None:
        """Say what is not at rest before a spindle is chosen, the saw cuts or the program ends."""
        if self.turning:
            self.say(rules.SPINDLE_ON, line, found=what)
        if self.cooling:
            self.say(rules.COOLANT, line, found=what, expected="off")
        if self.choice is not None and self.known:
            for station in self.choice.stations:
                _, stroke = self.at.get(station.number, (nan, nan))
                if station.way * (stroke - station.outermost) > _EPSILON:
                    self._sideways(line, what, station, stroke)

    def _choose(self, switch: Switch, values: dict[str, float], cycle: Cycle) -> None:
        self._at_rest(switch.line, "the choice of a spindle")
        number = values["spindle"]
        self.choice = self.choices.get(int(number)) if number == int(number) else None
        self.peck = None
        self.diameter = self.meaning.size(values.get("diameter", 0.0))
        self.cycle, self.pitch = cycle, values.get("pitch", 0.0)
        if self.choice is None:
            numbers = ", ".join(str(n) for n in self.choices)
            self.say(
                rules.WORD, switch.line, found=f"spindle {number:g}", expected=f"one of {numbers}"
            )

    def _saw(self, switch: Switch, values: dict[str, float]) -> None:
        self._at_rest(switch.line, "a cut")
        self._describe_first(switch.line)
        angle = values["angle"]
        saw = self.machine.saw
        name, least, greatest = limits_of(self.machine, "angle")
        if saw is not None:
            least, greatest = max(least, saw.least_angle), min(greatest, saw.greatest_angle)
            if self.meaning.saw_feeds and self.feed_mm_min > saw.feed_mm_min + 0.1:
                self.say(
                    rules.FEED_LIMIT, switch.line, found=f"{self.feed_mm_min:g}",
                    what="the saw", expected=f"{saw.feed_mm_min:g}",
                )  # fmt: skip
        if not least <= angle <= greatest:
            self._beyond(switch.line, name, angle, least, greatest)
        if isnan(self.x):
            self.say(rules.WORD, switch.line, found="a cut", expected="an X before")
            return
        tilt = values.get("tilt", 0.0)
        if saw is not None and not saw.least_tilt <= tilt <= saw.greatest_tilt:
            self._beyond(switch.line, "the blade's tilt", tilt, saw.least_tilt, saw.greatest_tilt)
        self.order.append(Cut(switch.line, self.x, angle, self.feed_mm_min, tilt))
        self.peck = None

    def _describe_first(self, line: int) -> None:
        """Say that the program works on a bar that it has not described."""
        missing = self.meaning.section_fields - self.section.keys()
        if missing:
            names = ", ".join(sorted(missing))
            self.say(rules.SECTION, line, what="no", found=names, expected=f"{names} before")
            self.section.update(dict.fromkeys(missing, nan))


def _unknown(event: object) -> NoReturn:
    raise AssertionError(f"no rule for {event!r}")
