"""State of a saw and drilling cell, and the effect of its M words.

    state        changed by                      asked when
    spindle      the choosing word               Y or Z move: whose axes are they?
    turning      M03, M04, M05                   a feed goes into material; the bar moves
    cooling      M07, M08, M09                   likewise, if the machine's cycles cool
    places       moves; each spindle its own     a move begins: is the tool still in the bar?

A spindle's axes stay where they are while another one works, so each keeps its places.
"""

from collections.abc import Callable
from math import isnan, nan

from beamcam.checks import rules
from beamcam.checks.bars.magazine import Changed, Chosen, wrong_changes
from beamcam.checks.bars.stations import (
    NOWHERE,
    Choice,
    Cut,
    StampedText,
    Station,
    Thing,
    Tip,
    limits_of,
    tilts_of,
)
from beamcam.checks.bars.tools import EPSILON, LEAST, CuttingData, limits_of_cell
from beamcam.controllers.dialect import WORD, Cycle, Dialect, MWord, Role
from beamcam.controllers.events import Lettering, Switch
from beamcam.errors import Diagnostic, Rule, Source
from beamcam.machine.machine import Machine

AXES = "XYZ"
Values = dict[str, float]  #: parameters of a word by what they carry
_NOTHING: Values = {}
_NO_CYCLE = Cycle("drill", 0, False, False, False)


class CellState:
    """The state of the cell while a program runs, and its M words."""

    def __init__(
        self, machine: Machine, dialect: Dialect, choices: dict[int, Choice], data: CuttingData,
        name: str,
    ) -> None:  # fmt: skip
        self.machine, self.dialect, self.choices, self.name = machine, dialect, choices, name
        self.data, self.limits = data, limits_of_cell(machine)
        self.diagnostics: list[Diagnostic] = []
        self.section: dict[str, float] = {}
        self.unsaid = dialect.section_fields  #: what the program has not said of its bar yet
        self.order: list[Thing] = []
        self.tools: list[Chosen | Changed] = []
        self.held: dict[tuple[int, float], tuple[str, float]] = {}  #: by spindle and station
        self.choice: Choice | None = None
        self.diameter = 0.0
        self.cycle = _NO_CYCLE  #: of the tool that is chosen
        self.pitch = 0.0
        self.tapped_mm_min = 0.0  #: feed of the tap into the steel
        self.turning = 0  #: the M word that started the spindle
        self.speed_rpm = 0.0  #: that it was started with; 0 where the program does not say
        self.idle = False  #: whether the spindle turns and has not been fed
        self.cooling = False
        self.x = self.furthest = self.feed_mm_min = nan
        self.at: dict[int, Tip] = {}  #: of each spindle
        self.fed_since: dict[int, float] = {}  #: depth at which each fed on since it was back
        self.fed_to: dict[int, tuple[float, float, float]] = {}  #: X, across, depth of each, last
        self.fed_from: dict[int, float] = {}  #: stroke at which a tool's feed into the bar began
        self.unseen: set[str] = set()  #: faces that were worked on without knowing where they lie
        self.peck: tuple[float, float] | None = None  #: X and across of the hole being drilled
        self.pecked = 0  #: how many bores the last stroke made

    def say(self, rule: Rule, line: int, **values: object) -> None:
        self.diagnostics.append(rule.at(Source(self.name, line), **values))

    def switch(self, switch: Switch) -> None:
        word = self.dialect.m_words.get(switch.number)
        if word is None:
            self.say(
                WORD, switch.line, found=f"M{switch.number:02}",
                expected=f"a word of this machine: {self.dialect.shown()}",
            )  # fmt: skip
            return
        values = self._values(switch, word) if word.fields or switch.words else _NOTHING
        if values is not None:
            _DOES[word.role](self, switch, values)
        elif word.role == "on":
            self.turning = switch.number

    def _values(self, switch: Switch, word: MWord) -> dict[str, float] | None:
        """The word's parameters by what they carry; None (and said) where one is missing."""
        found = switch.words
        values: dict[str, float] = {}
        for letter, field in word.fields:
            value = found.get(letter)
            if value is None:
                shown = f"M{switch.number:02}"
                self.say(
                    WORD, switch.line, found=f"{shown} without {letter}",
                    expected=f"{letter} with the {field}",
                )  # fmt: skip
                return None
            before = self.section.get(field, value)
            if before != value and not isnan(before):
                self.say(
                    rules.SECTION, switch.line, what=field, found=f"{value:g}",
                    expected=f"{before:g}, as before",
                )  # fmt: skip
            if values.setdefault(field, value) != value:
                self.say(
                    WORD, switch.line, found=f"{letter}{value:g} behind M{switch.number:02}",
                    expected=f"{values[field]:g}, the {field} a second time",
                )  # fmt: skip
        if len(found) > len(word.fields):
            known = {letter for letter, _ in word.fields}
            for letter in found.keys() - known:
                self.say(
                    WORD, switch.line, found=f"{letter} behind M{switch.number:02}",
                    expected="no such parameter",
                )  # fmt: skip
        return values

    def _cool(self, switch: Switch, values: Values) -> None:
        self.cooling = self.dialect.m_words[switch.number].role == "coolant-on"

    def _describe(self, switch: Switch, values: Values) -> None:
        self.section.update(values)
        self.unsaid -= values.keys()

    def _set_pitch(self, switch: Switch, values: Values) -> None:
        self.pitch = values.get("pitch", self.pitch)

    def _end(self, switch: Switch, values: Values) -> None:
        self.at_rest(switch.line, "the end of the program")
        self._check_magazines()

    def _start(self, switch: Switch, values: Values) -> None:
        """A spindle that starts, or reverses."""
        if self.choice is None:
            self.say(rules.NO_SPINDLE, switch.line, found="a spindle that starts")
        elif (
            self.turning
            and self.turning != switch.number
            and self.cycle.kind != "tap"
            and self.in_steel()
        ):
            self.say(rules.TURN, switch.line, found=switch.number, expected=self.cycle.turns)
        if not self.turning:
            self.idle = self.choice is not None
        self.turning = switch.number
        self.speed_rpm = speed = values.get("speed", 0.0)
        drill = self.machine.drill
        if "speed" not in values or drill is None:
            return
        run = self.data.run(self.cycle.kind, self.diameter, self.pitch)
        most = drill.max_speed_rpm + 0.6 if run is None else run.most_speed
        if not drill.min_speed_rpm - 0.6 <= speed <= most:
            self.say(
                rules.SPEED, switch.line, found=f"{speed:g}", what=self.tool,
                least=f"{drill.min_speed_rpm:g}", greatest=f"{most:.0f}",
            )  # fmt: skip

    @property
    def tool(self) -> str:
        """The tool that is chosen, for messages."""
        return f"a {self.cycle.kind} {self.diameter:g}"

    def _stop(self, switch: Switch, values: Values) -> None:
        line = switch.line
        station = self.in_steel() if self.turning else None
        if station is not None:
            self.say(
                rules.SPINDLE_STOPPED, line, face=station.face, axis=AXES[station.stroke],
                at=f"{self.at[station.number].stroke:g}",
            )  # fmt: skip
        if self.turning and self.idle:
            self.say(rules.SPINDLE_IDLE, line, what=self.tool)
        self.turning, self.idle = 0, False

    def _choose(self, switch: Switch, values: Values) -> None:
        self.at_rest(switch.line, "the choice of a spindle")
        number = values.get("spindle", self.dialect.only_spindle)
        if number is None:
            number = nan
        self.choice = self.choices.get(int(number)) if number == number // 1 else None
        self.peck = None
        self.diameter = self.dialect.size(values.get("diameter", 0.0))
        self.cycle = self.dialect.m_words[switch.number].cycle or _NO_CYCLE
        self.pitch = values.get("pitch", 0.0)
        if "tool" in values:
            self._take_numbered(switch.line, values)
        if self.choice is None:
            numbers = ", ".join(str(n) for n in self.choices)
            self.say(WORD, switch.line, found=f"spindle {number:g}", expected=f"one of {numbers}")
            return
        self.tools.append(Chosen(switch.line, self.choice.number, (self.cycle.kind, self.diameter)))
        sizes = self.limits.tools.get(self.cycle.kind, ())
        if "diameter" in values and self.limits.tools and self.diameter not in sizes:
            near = min(sizes, key=lambda d: abs(d - self.diameter), default=None)
            expected = (
                "and it has none of that kind" if near is None else f"the nearest is {near:g}"
            )
            self.say(rules.NO_TOOL, switch.line, found=self.tool, expected=expected)
        if "station" in values:
            self._take_station(switch.line, self.choice.stations[0].number, values["station"])

    def _take_station(self, line: int, spindle: int, station: float) -> None:
        """The station that the tool is said to stand in: one of the spindle's, no other tool's."""
        count = next((s.stations for s in self.machine.spindles if s.number == spindle), 1)
        kind, size = self.held.setdefault((spindle, station), (self.cycle.kind, self.diameter))
        expected = f"the {kind} {size:g} that stands there"
        if station not in range(1, count + 1):
            expected = f"a station from 1 to {count}"
        elif (kind, size) == (self.cycle.kind, self.diameter):
            return
        self.say(WORD, line, found=f"{self.tool} in station {station:g}", expected=expected)

    def _take_numbered(self, line: int, values: Values) -> None:
        """The tool that a number means, which has to be of the size that is said beside it."""
        tool = self.dialect.numbered.get(int(values["tool"]))
        if tool is None:
            known = ", ".join(map(str, sorted(self.dialect.numbered)))
            self.say(WORD, line, found=f"tool {values['tool']:g}", expected=f"one of {known}")
            return
        kind, size = tool
        if "diameter" in values and self.diameter != size:
            expected = f"{size:g}, the size of tool {values['tool']:g}"
            self.say(WORD, line, found=f"diameter {self.diameter:g}", expected=expected)
        self.diameter, self.cycle = size, self.dialect.cycles.get(kind, _NO_CYCLE)

    def _change(self, switch: Switch, values: Values) -> None:
        self.at_rest(switch.line, "a manual tool change")
        spindle, diameter = values.get("spindle"), values.get("diameter")
        size = None if diameter is None else self.dialect.size(diameter)
        known = [s.number for s in self.machine.spindles]
        if spindle is not None and spindle not in known:
            expected = f"one of {', '.join(map(str, known))}"
            self.say(WORD, switch.line, found=f"a stop for spindle {spindle:g}", expected=expected)
            return
        station = values.get("station")
        self.held = {
            (number, at): tool for (number, at), tool in self.held.items()
            if spindle not in (None, number) or station not in (None, at)
        }  # fmt: skip
        self.tools.append(Changed(switch.line, None if spindle is None else int(spindle), size))

    def _check_magazines(self) -> None:
        """Say which tools are chosen though no station can hold them by then, and idle stops."""
        if not self.dialect.changes:
            return
        spindles = self.machine.spindles
        chosen = [one.tool for one in self.tools if isinstance(one, Chosen)]
        has_stops = len(chosen) < len(self.tools)
        if not has_stops and len(set(chosen)) <= min((s.stations for s in spindles), default=0):
            return
        for spindle in spindles:
            for one in wrong_changes(self._of_spindle(spindle.number), spindle.stations):
                if isinstance(one, Chosen):
                    kind, diameter = one.tool
                    found = f"a {kind} {diameter:g} chosen"
                    stations = f"one of the {spindle.stations} stations"
                    expected = f"a stop before that puts it into {stations}"
                else:
                    found = f"a stop for a tool of {one.diameter or 0.0:g}"
                    expected = "a stroke behind it with such a tool that was not there before"
                self.say(
                    rules.TOOL_CHANGE, one.line, found=found, spindle=spindle.number,
                    expected=expected,
                )  # fmt: skip

    def _of_spindle(self, number: int) -> list[Chosen | Changed]:
        """The tool selections of a spindle, alone or paired, and its stops."""
        chosen = {
            choice.number
            for choice in self.choices.values()
            if any(station.number == number for station in choice.stations)
        }
        return [
            one
            for one in self.tools
            if (one.spindle in chosen if isinstance(one, Chosen) else one.spindle in (number, None))
        ]

    def _saw(self, switch: Switch, values: Values) -> None:
        self.at_rest(switch.line, "a cut")
        self.describe_first(switch.line)
        angle = values["angle"]
        saw = self.machine.saw
        name, least, greatest = limits_of(self.machine, "angle")
        if saw is not None and "feed" in values:
            feed, own = values["feed"] * self.limits.per_minute, saw.feed_mm_min
            if not LEAST * own <= feed <= own + 0.1:
                self.say_feed(switch.line, feed, "the saw", own, own + 0.1)
        if not least <= angle <= greatest:
            self.beyond(switch.line, name, angle, least, greatest)
        if isnan(self.x):
            self.say(WORD, switch.line, found="a cut", expected="an X before")
            return
        tilt = values.get("tilt", 0.0)
        least, greatest = tilts_of(saw, angle) if saw is not None else (tilt, tilt)
        if not least <= tilt <= greatest:
            name = f"the tilt of the blade, turned to {angle:g},"
            self.beyond(switch.line, name, tilt, least, greatest)
        feed = values["feed"] * self.limits.per_minute if "feed" in values else self.feed_mm_min
        self.order.append(Cut(switch.line, self.x, angle, feed, tilt))
        self.peck = None

    def letter(self, event: Lettering) -> None:
        """A text sent to the unit at the bar's position; values not sent are the unit's own."""
        self.at_rest(event.line, "a text")
        self.describe_first(event.line)
        marks = self.machine.marks
        if isnan(self.x):
            self.say(WORD, event.line, found="a text", expected="an X before")
            return
        numbers = {number: face for face, number in marks.faces.items()}
        called = event.values.get("face", next(iter(numbers)))
        face = numbers.get(int(called)) if called == called // 1 else None
        if face is None:
            expected = "one of " + ", ".join(map(str, sorted(numbers)))
            self.say(WORD, event.line, found=f"face {called:g}", expected=expected)
            return
        height = event.values.get("height", marks.heights[0] if marks.heights else nan)
        angle = event.values.get("angle", marks.angles[0])
        self.order.append(
            StampedText(
                event.line, face, event.kind, event.text, self.x, event.values["y"], height, angle
            )
        )
        self.peck = None

    def say_feed(self, line: int, feed: float, what: str, own: float, most: float) -> None:
        """Report a feed beyond its limits; `own` is that of the cutting data; all in mm/min."""
        if feed > most:
            self.say(rules.FEED_LIMIT, line, found=f"{feed:g}", what=what, expected=f"{most:.4g}")
        elif feed > 0:
            self.say(rules.FEED, line, found=f"{feed:g}", what=what, expected=f"{own:.4g}")
        else:
            self.say(rules.NO_FEED, line, found=f"feed for {what}")

    def at_rest(self, line: int, what: str) -> None:
        """Report what still runs before a spindle is selected, the saw cuts or the program ends."""
        if self.turning:
            self.say(rules.SPINDLE_ON, line, found=what)
        if self.cooling:
            self.say(rules.COOLANT, line, found=what, expected="off")
        if self.choice is not None:
            for station in self.choice.stations:
                if self.is_in(station):
                    self.sideways(line, what, station, self.at[station.number].stroke)

    def is_in(self, station: Station) -> bool:
        """Whether a station's tool is where material may be beside it."""
        return self.at.get(station.number, NOWHERE).beside > EPSILON

    def in_steel(self) -> Station | None:
        """The first station of the choice whose tool is in the material behind its face."""
        for station in self.choice.stations if self.choice is not None else ():
            tip = self.at.get(station.number, NOWHERE)
            depth = tip.depth
            if not station.surface_known:
                depth = station.way * (tip.stroke - self.fed_from.get(station.number, nan))
            if depth > EPSILON:
                return station
        return None

    def describe_first(self, line: int) -> None:
        """Say that the program works on a bar that it has not described."""
        if self.unsaid:
            names = ", ".join(sorted(self.unsaid))
            self.say(rules.SECTION, line, what="no", found=names, expected=f"{names} before")
            self.section.update(dict.fromkeys(self.unsaid, nan))
            self.unsaid = frozenset()

    def beyond(self, line: int, axis: str, at: float, least: float, greatest: float) -> None:
        self.say(
            rules.LIMIT, line, axis=axis, found=f"{at:g}", least=f"{least:g}",
            greatest=f"{greatest:g}",
        )  # fmt: skip

    def sideways(self, line: int, what: str, station: Station, at: float) -> None:
        axis = AXES[station.stroke]
        self.say(rules.SIDEWAYS, line, found=what, face=station.face, axis=axis, at=f"{at:g}")


_DOES: dict[Role, Callable[[CellState, Switch, Values], None]] = {
    "on": CellState._start, "off": CellState._stop, "coolant-on": CellState._cool,
    "coolant-off": CellState._cool, "choose": CellState._choose, "change": CellState._change,
    "saw": CellState._saw, "section": CellState._describe, "other": CellState._set_pitch,
    "end": CellState._end,
}  # fmt: skip
