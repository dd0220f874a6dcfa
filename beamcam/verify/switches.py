"""What a saw and drilling cell stands like, and what its M words do to it.

    state        changed by                      asked when
    spindle      the choosing word               Y or Z move: whose axes are they?
    turning      M03, M04, M05                   a feed goes into material; the bar moves
    cooling      M07, M08, M09                   likewise, if the machine's cycles cool
    places       moves; each spindle its own     a move begins: is the tool still in the bar?

A spindle's axes stay where they are while another one works, so each keeps its places.
"""

from math import isnan, nan

from beamcam.errors import Diagnostic, Rule, Source
from beamcam.machine.machine import Machine
from beamcam.model.part import Profile
from beamcam.verify import rules
from beamcam.verify.events import Switch
from beamcam.verify.made import Bore, Cut, Trail
from beamcam.verify.meaning import Cycle, Meaning, MWord
from beamcam.verify.stations import Choice, Station, limits_of

EPSILON = 1e-6
AXES = "XYZ"
_NO_CYCLE = Cycle("drill", 0, False, False)


class Switches:
    """The state of the cell while a program runs, and its M words."""

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

    def switch(self, switch: Switch) -> None:
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
        elif role == "change":
            self.at_rest(switch.line, "a change of tool by hand")
        elif role == "section":
            self.section.update(values)
        elif role == "other":
            self.pitch = values.get("pitch", self.pitch)
        elif role == "end":
            self.at_rest(switch.line, "the end of the program")
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

    def _choose(self, switch: Switch, values: dict[str, float], cycle: Cycle) -> None:
        self.at_rest(switch.line, "the choice of a spindle")
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
        self.at_rest(switch.line, "a cut")
        self.describe_first(switch.line)
        angle = values["angle"]
        if "feed" in values:
            per_minute = 60.0 if self.machine.format.feed_unit == "mm/s" else 1.0
            self.feed_mm_min = values["feed"] * per_minute
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
            self.beyond(switch.line, name, angle, least, greatest)
        if isnan(self.x):
            self.say(rules.WORD, switch.line, found="a cut", expected="an X before")
            return
        tilt = values.get("tilt", 0.0)
        if saw is not None and not saw.least_tilt <= tilt <= saw.greatest_tilt:
            self.beyond(switch.line, "the blade's tilt", tilt, saw.least_tilt, saw.greatest_tilt)
        self.order.append(Cut(switch.line, self.x, angle, self.feed_mm_min, tilt))
        self.peck = None

    def at_rest(self, line: int, what: str) -> None:
        """Say what is not at rest before a spindle is chosen, the saw cuts or the program ends."""
        if self.turning:
            self.say(rules.SPINDLE_ON, line, found=what)
        if self.cooling:
            self.say(rules.COOLANT, line, found=what, expected="off")
        if self.choice is not None and self.known:
            for station in self.choice.stations:
                if self.is_in(station):
                    self.sideways(line, what, station, self.at[station.number][1])

    @property
    def is_at_rest(self) -> bool:
        """Whether nothing turns or flows and every tool is drawn back, with more to come."""
        tools = (s for choice in self.choices.values() for s in choice.stations)
        return not (self.turning or self.cooling or self.ended) and not any(
            self.is_in(station) for station in tools
        )

    def is_in(self, station: Station) -> bool:
        """Whether a station's tool is where material may be beside it."""
        across, stroke = self.at.get(station.number, (nan, nan))
        return station.depth_beside(stroke, station.y(across)) > EPSILON

    def describe_first(self, line: int) -> None:
        """Say that the program works on a bar that it has not described."""
        missing = self.meaning.section_fields - self.section.keys()
        if missing:
            names = ", ".join(sorted(missing))
            self.say(rules.SECTION, line, what="no", found=names, expected=f"{names} before")
            self.section.update(dict.fromkeys(missing, nan))

    def beyond(self, line: int, axis: str, at: float, least: float, greatest: float) -> None:
        self.say(
            rules.LIMIT, line, axis=axis, found=f"{at:g}", least=f"{least:g}",
            greatest=f"{greatest:g}",
        )  # fmt: skip

    def sideways(self, line: int, what: str, station: Station, at: float) -> None:
        self.say(
            rules.SIDEWAYS, line, found=what, face=station.face,
            axis=AXES[station.stroke], at=f"{at:g}",
        )  # fmt: skip
