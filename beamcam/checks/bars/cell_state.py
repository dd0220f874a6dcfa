"""State of a saw and drilling cell, and the effect of its M words.

    state        changed by                      checked when
    spindle      the choosing word               Y or Z move: whose axes are they?
    turning      M03, M04, M05                   a feed goes into material; the bar moves
    cooling      M07, M08, M09                   likewise, if the machine's cycles cool
    places       moves; each spindle its own     a move begins: is the tool still in the bar?

A spindle's axes stay where they are while another one works, so each keeps its places.
"""

from collections.abc import Callable
from math import isnan, nan

from beamcam.checks import rules
from beamcam.checks.bars.magazine import Changed, Chosen, change_faults
from beamcam.checks.bars.stations import (
    NOWHERE,
    Choice,
    Cut,
    StampedText,
    Station,
    Thing,
    Tip,
)
from beamcam.checks.bars.tools import EPSILON, LEAST, CuttingData, CuttingRange, limits_of_cell
from beamcam.controllers.dialect import WORD, Cycle, Dialect, MWord, Role
from beamcam.controllers.events import Lettering, Switch
from beamcam.errors import Diagnostic, Rule, Source
from beamcam.machine.machine import Machine

AXES = "XYZ"
SQUARE_DEG = 0.05  #: off the square cut, as numbers of one decimal are rounded
Values = dict[str, float]  #: parameters of a word by what they carry
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
        self.undescribed = dialect.section_fields  #: what the program has yet to say of its bar
        self.order: list[Thing] = []
        self.tools: list[Chosen | Changed] = []
        self.held: dict[tuple[int, float], tuple[str, float]] = {}  #: by spindle and station
        self.spindle = 0  #: the number of the choice
        self.stations: tuple[Station, ...] = ()  #: of the choice; none where none is made
        self.diameter = 0.0
        self.cycle = _NO_CYCLE  #: of the tool that is chosen
        self.pitch = 0.0
        self.permitted: CuttingRange | None = None  #: by the cutting data, of the tool
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
        self.line = 0  #: that is executed

    def say(self, rule: Rule, *found_expected: object, **values: object) -> None:
        """Add a message about the line that is executed."""
        shown = dict(zip(("found", "expected"), found_expected, strict=False))
        self.diagnostics.append(rule.at(Source(self.name, self.line), **shown, **values))

    def switch(self, switch: Switch) -> None:
        word = self.dialect.m_words.get(switch.number)
        if word is None:
            expected = f"a word of this machine: {self.dialect.shown()}"
            self.say(WORD, f"M{switch.number:02}", expected)
            return
        values = self._values(switch, word) if word.fields or switch.words else {}
        if values is not None:
            _DOES[word.role](self, switch, values)
        elif word.role == "on":
            self.turning = switch.number

    def _values(self, switch: Switch, word: MWord) -> Values | None:
        """The word's parameters by what they carry; None, and a message, where one is missing."""
        values: Values = {}
        words, section = switch.words, self.section
        for letter, field in word.fields:
            value = words.get(letter)
            if value is None:
                found = f"M{switch.number:02} without {letter}"
                self.say(WORD, found, f"{letter} with the {field}")
                return None
            before = section.get(field, value)
            if before != value and not isnan(before):
                self.say(rules.SECTION, f"{value:g}", f"{before:g}, as before", what=field)
            if values.setdefault(field, value) != value:
                expected = f"{values[field]:g}, the {field} a second time"
                self.say(WORD, f"{letter}{value:g} behind M{switch.number:02}", expected)
        if len(words) > len(word.fields):
            for letter in words.keys() - {letter for letter, _ in word.fields}:
                self.say(WORD, f"{letter} behind M{switch.number:02}", "no such parameter")
        return values

    def _cool(self, switch: Switch, values: Values) -> None:
        self.cooling = True

    def _stop_cooling(self, switch: Switch, values: Values) -> None:
        self.cooling = False

    def _describe(self, switch: Switch, values: Values) -> None:
        self.section.update(values)
        self.undescribed -= values.keys()

    def _set_pitch(self, switch: Switch, values: Values) -> None:
        if "pitch" in values:
            self.pitch = values["pitch"]
            self.permitted = self.data.run(self.cycle.kind, self.diameter, self.pitch)

    def _start(self, switch: Switch, values: Values) -> None:
        """A spindle that starts, or reverses."""
        if not self.stations:
            self.say(rules.NO_SPINDLE, "a spindle that starts")
        elif (
            self.turning not in (0, switch.number) and self.cycle.kind != "tap" and self.in_steel()
        ):
            self.say(rules.TURN, switch.number, self.cycle.turns)
        if not self.turning:
            self.idle = bool(self.stations)
        self.turning = switch.number
        self.speed_rpm = speed = values.get("speed", 0.0)
        drill = self.machine.drill
        if "speed" not in values or drill is None:
            return
        most = drill.max_speed_rpm + 0.6 if self.permitted is None else self.permitted.most_speed
        if not drill.min_speed_rpm - 0.6 <= speed <= most:
            limits = {"least": f"{drill.min_speed_rpm:g}", "greatest": f"{most:.0f}"}
            self.say(rules.SPEED, f"{speed:g}", what=self.tool, **limits)

    @property
    def tool(self) -> str:
        """The tool that is chosen, for messages."""
        return f"a {self.cycle.kind} {self.diameter:g}"

    def _stop(self, switch: Switch, values: Values) -> None:
        if self.turning and (station := self.in_steel()) is not None:
            axis, at = AXES[station.stroke], f"{self.at[station.number].stroke:g}"
            self.say(rules.SPINDLE_STOPPED, face=station.face, axis=axis, at=at)
        if self.turning and self.idle:
            self.say(rules.SPINDLE_IDLE, what=self.tool)
        self.turning, self.idle = 0, False

    def _choose(self, switch: Switch, values: Values) -> None:
        self.check_rest("the choice of a spindle")
        number = values.get("spindle", self.dialect.only_spindle)
        if number is None:
            number = nan
        choice = self.choices.get(int(number)) if number == number // 1 else None
        self.stations = () if choice is None else choice.stations
        self.peck = None
        self.diameter = self.dialect.size(values.get("diameter", 0.0))
        self.cycle = self.dialect.m_words[switch.number].cycle or _NO_CYCLE
        self.pitch = values.get("pitch", 0.0)
        if "tool" in values:
            self._choose_numbered(values)
        self.permitted = self.data.run(self.cycle.kind, self.diameter, self.pitch)
        if choice is None:
            numbers = ", ".join(str(n) for n in self.choices)
            self.say(WORD, f"spindle {number:g}", f"one of {numbers}")
            return
        self.spindle = choice.number
        tool = self.cycle.kind, self.diameter
        self.tools.append(Chosen(self.line, choice.number, tool))
        sizes = self.limits.tools.get(self.cycle.kind, ())
        if "diameter" in values and self.limits.tools and self.diameter not in sizes:
            expected = "and it has none of that kind"
            if sizes:
                expected = f"the nearest is {min(sizes, key=lambda d: abs(d - self.diameter)):g}"
            self.say(rules.NO_TOOL, self.tool, expected)
        if "station" in values:  # one of the spindle's, with no other tool in it
            station, spindle = values["station"], choice.stations[0].number
            count = next((s.stations for s in self.machine.spindles if s.number == spindle), 1)
            kind, size = self.held.setdefault((spindle, station), tool)
            expected = f"the {kind} {size:g} that stands there"
            if station not in range(1, count + 1):
                expected = f"a station from 1 to {count}"
            elif (kind, size) == tool:
                return
            self.say(WORD, f"{self.tool} in station {station:g}", expected)

    def _choose_numbered(self, values: Values) -> None:
        """The tool that a number means, which has to be of the size that stands beside it."""
        shown, tool = f"tool {values['tool']:g}", self.dialect.numbered.get(int(values["tool"]))
        if tool is None:
            known = ", ".join(map(str, sorted(self.dialect.numbered)))
            self.say(WORD, shown, f"one of {known}")
            return
        kind, size = tool
        if "diameter" in values and self.diameter != size:
            self.say(WORD, f"diameter {self.diameter:g}", f"{size:g}, the size of {shown}")
        self.diameter, self.cycle = size, self.dialect.cycles.get(kind, _NO_CYCLE)

    def _change(self, switch: Switch, values: Values) -> None:
        self.check_rest("a manual tool change")
        spindle, diameter = values.get("spindle"), values.get("diameter")
        known = [s.number for s in self.machine.spindles]
        if spindle is not None and spindle not in known:
            expected = f"one of {', '.join(map(str, known))}"
            self.say(WORD, f"a stop for spindle {spindle:g}", expected)
            return
        station = values.get("station")
        self.held = {
            (number, at): tool for (number, at), tool in self.held.items()
            if spindle not in (None, number) or station not in (None, at)
        }  # fmt: skip
        size = None if diameter is None else self.dialect.size(diameter)
        self.tools.append(Changed(self.line, None if spindle is None else int(spindle), size))

    def _end(self, switch: Switch, values: Values) -> None:
        self.check_rest("the end of the program")
        if self.dialect.changes:
            self.diagnostics += change_faults(self.tools, self.machine, self.name)

    def _saw(self, switch: Switch, values: Values) -> None:
        self.check_rest("a cut")
        self.check_described()
        angle, tilt, saw = values["angle"], values.get("tilt", 0.0), self.machine.saw
        feed = values["feed"] * self.limits.per_minute if "feed" in values else self.feed_mm_min
        if saw is not None and "feed" in values:
            own = saw.feed_mm_min
            if not LEAST * own <= feed <= own + 0.1:
                self.say_feed(feed, "the saw", own, own + 0.1)
        name, least, greatest = self.limits.angle
        if not least <= angle <= greatest:
            self.say_beyond(name, angle, least, greatest)
        if isnan(self.x):
            self.say(WORD, "a cut", "an X before")
            return
        least = greatest = 0.0 if saw is not None else tilt
        if saw is not None and (saw.compound or abs(angle - saw.zero_angle) < SQUARE_DEG):
            least, greatest = saw.min_tilt, saw.max_tilt
        if not least <= tilt <= greatest:
            name = f"the tilt of the blade, turned to {angle:g},"
            self.say_beyond(name, tilt, least, greatest)
        self.order.append(Cut(self.line, self.x, angle, feed, tilt))
        self.peck = None

    def letter(self, event: Lettering) -> None:
        """A text sent to the unit at the bar's position; values not sent are the unit's own."""
        self.check_rest("a text")
        self.check_described()
        marks, values = self.machine.marks, event.values
        if isnan(self.x):
            self.say(WORD, "a text", "an X before")
            return
        numbers = {number: face for face, number in marks.faces.items()}
        called = values.get("face", next(iter(numbers)))
        face = numbers.get(int(called)) if called == called // 1 else None
        if face is None:
            self.say(WORD, f"face {called:g}", "one of " + ", ".join(map(str, sorted(numbers))))
            return
        height = values.get("height", marks.heights[0] if marks.heights else nan)
        angle = values.get("angle", marks.angles[0])
        self.order.append(
            StampedText(self.line, face, event.kind, event.text, self.x, values["y"], height, angle)
        )
        self.peck = None

    def say_feed(self, feed: float, what: str, own: float, most: float) -> None:
        """Report a feed beyond its limits; `own` is that of the cutting data; all in mm/min."""
        if feed > most:
            self.say(rules.FEED_LIMIT, f"{feed:g}", f"{most:.4g}", what=what)
        elif feed > 0:
            self.say(rules.FEED, f"{feed:g}", f"{own:.4g}", what=what)
        else:
            self.say(rules.NO_FEED, f"feed for {what}")

    def check_rest(self, what: str) -> None:
        """Report what still runs before a spindle is selected, the saw cuts or the program ends."""
        if self.turning:
            self.say(rules.SPINDLE_ON, what)
        if self.cooling:
            self.say(rules.COOLANT, what, "off")
        for station in self.stations:
            tip = self.at.get(station.number, NOWHERE)
            if tip.beside > EPSILON:  # where material may be beside it
                self.say_sideways(what, station, tip.stroke)

    def in_steel(self) -> Station | None:
        """The first station of the choice whose tool is in the material behind its face."""
        for station in self.stations:
            tip = self.at.get(station.number, NOWHERE)
            depth = tip.depth
            if not station.surface_known:
                depth = station.way * (tip.stroke - self.fed_from.get(station.number, nan))
            if depth > EPSILON:
                return station
        return None

    def check_described(self) -> None:
        """Report that the program works on a bar that it has not described."""
        if self.undescribed:
            names = ", ".join(sorted(self.undescribed))
            self.say(rules.SECTION, names, f"{names} before", what="no")
            self.section.update(dict.fromkeys(self.undescribed, nan))
            self.undescribed = frozenset()

    def say_beyond(self, axis: str, at: float, least: float, greatest: float) -> None:
        limits = {"least": f"{least:g}", "greatest": f"{greatest:g}"}
        self.say(rules.LIMIT, f"{at:g}", axis=axis, **limits)

    def say_sideways(self, what: str, station: Station, at: float) -> None:
        axis = AXES[station.stroke]
        self.say(rules.SIDEWAYS, what, face=station.face, axis=axis, at=f"{at:g}")


_DOES: dict[Role, Callable[[CellState, Switch, Values], None]] = {
    "on": CellState._start, "off": CellState._stop, "coolant-on": CellState._cool,
    "coolant-off": CellState._stop_cooling, "choose": CellState._choose,
    "change": CellState._change, "saw": CellState._saw, "section": CellState._describe,
    "other": CellState._set_pitch, "end": CellState._end,
}  # fmt: skip
