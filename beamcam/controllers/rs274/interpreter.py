"""The interpreter of RS274/NGC, for the controllers that descend from it: LinuxCNC, grbl, Mach3.

    G1 X10 Y5 F600 (comment)      words in any order, spaces mean nothing
    G3 X0 Y0 I-5 J0               I and J from the start of the arc (G91.1)
    M101 P13 Q14                  an M word of the machine's own, with what it carries

A block's words act in a fixed order: feed, speed, M words, dwell, settings, motion, end. Motion is
modal. Source: LinuxCNC documentation, "G-Code Overview".
"""

import re
from collections.abc import Sequence
from math import nan

from msgspec.structs import replace

from beamcam.controllers.dialect import Dialect
from beamcam.controllers.events import Curve, FeedShare, Material, Other, Switch
from beamcam.controllers.interpreter import Interpreter, Words, arc_of
from beamcam.controllers.rs274.blocks import ENDS, Block, Grammar, Variant, read_block
from beamcam.controllers.rs274.head import HeadWords
from beamcam.geometry.plane import Point
from beamcam.model.cycles import END, OWN_LETTERS

_NUMBERED = re.compile(r"\s*N[0-9]+\s*")
_CENTRE = frozenset("IJ")  #: of an arc
_LAST_TRAVEL = 3  #: G3; beyond it are canned cycles
_TOOL_CHANGE = 6
_STOPS = (0, 1)  #: M words for a program stop at a manual tool change


class Rs274(HeadWords, Interpreter):
    """The state of the controller between two blocks."""

    longest_line: int
    fed_traverse = True
    arc_slack = 0.005  #: whatever the radius

    def __init__(self, variant: Variant, dialect: Dialect, name: str) -> None:
        super().__init__(dialect, name)
        self.controller, self.longest_line = variant.name, variant.longest_line
        self.arc_fault = variant.arc_fault
        self._variant = variant
        self._known: dict[str, Block] = {}  # programs say the same thing over and over
        switches = {
            **variant.switches,
            **{
                number: frozenset(letter for letter, _ in word.fields) & variant.own_letters
                for number, word in dialect.m_words.items()
                if number in variant.own_switches or number in _STOPS
            },
        }
        if self._flat:
            switches = {**variant.idle_switches, **switches}
        self._grammar = Grammar(variant, switches, dialect)
        self._axes = frozenset(dialect.axes)
        self._tells = dialect.text_word is not None  #: whether lines may tell texts
        self._percents: list[int] = []  #: lines
        self._reported: set[str] = set()  #: words without a meaning, each reported once
        self._speed: float | None = None  #: S of a table's tool, apart from what starts it
        self._running = 0  #: M word that has started it
        self._lit: Switch | None = None  #: what it works with, in laser mode

    def begin(self, lines: int) -> None:
        """The beginning of a text of so many lines, behind what the controller runs by itself."""
        super().begin(lines)
        if self._dialect.startup:
            self.lines((self._dialect.startup,), 0)

    def _is_simple(self) -> bool:
        return self._ready and super()._is_simple()

    def knows(self, code: str) -> bool:
        variant = self._variant
        known = code in self._dialect.codes or code in variant.g_words
        if self._flat:
            known = known or code in variant.idle or code in variant.offsets
        lifts = self._heights is not None
        return known or (lifts and (code in variant.probes or code in ("G10", "G92")))

    def vocabulary(self) -> dict[str, frozenset[str]]:
        variant, axes = self._variant, frozenset(self._dialect.axes)
        words = {code: frozenset[str]() for code in variant.g_words}
        words |= {"G0": axes, "G1": axes, "G2": axes | set("IJ"), "G3": axes | set("IJ")}
        words |= {"G4": frozenset("P"), "F": frozenset()}
        words |= dict.fromkeys(variant.sides, frozenset("D"))
        if variant.blends:
            words["G64"] = frozenset("PQ")
        if variant.cycles:
            for number, letters in OWN_LETTERS.items():
                words[f"G{number}"] = axes | set("R" + letters)
        words |= {f"M{number}": letters for number, letters in variant.switches.items()}
        words |= {f"M{number}": frozenset[str]() for number in ENDS}
        for word, carried in self._words_of_the_file().items():
            words[word] = words.get(word, frozenset()) | carried
        if self._heights is not None:
            words |= {
                **dict.fromkeys((*variant.probes, "G92"), frozenset("Z")),
                "G10": frozenset("LPZ"),
                "G0": words["G0"] | {"Z"},
                "G1": words["G1"] | {"Z"},
            }
        if self._dialect.stock == "profile":
            words["G93"] = frozenset()
        if self._flat:
            words |= variant.idle | {f"M{n}": known for n, known in variant.idle_switches.items()}
            words |= dict.fromkeys((*variant.offsets, "S", "T"), frozenset())
        return words

    def lines(self, texts: Sequence[str], first: int = 1) -> None:
        for line, text in enumerate(texts, first):
            self._line(line, text)

    def _line(self, line: int, text: str) -> None:
        if len(text) > self.longest_line:
            self._syntax(line, text, f"at most {self.longest_line} characters")
        if self._flat:
            text = self._without_names(line, text)
        block = self._known.get(text)
        if block is None:
            if self._tells and self._is_text(line, _NUMBERED.sub("", text)):
                return
            self._known[text] = block = read_block(text, self._grammar)
        if block.percent:
            self._percents.append(line)
            if not self._variant.percent:
                self._syntax(line, text, f"no %, {self.controller} does not know it")
            elif line not in (1, self._last):
                self._syntax(line, text, "% alone on the first and the last line only")
        elif block.syntax:
            self._syntax(line, text, block.syntax)
        elif not block.blank and not self.is_over(line):
            self._block(line, block)

    def _syntax(self, line: int, found: str, expected: str) -> None:
        self._say(line, self._rules.syntax, found=found.strip(), expected=expected)

    def _block(self, line: int, block: Block) -> None:
        for found, expected in block.faults:
            self._wrong(line, found, expected)
        if block.feed is not None:
            self._feed = block.feed
        for found, expected in block.unknown:
            if found not in self._reported:
                self._reported.add(found)
                self._wrong(line, found, expected)
        if self._flat:
            self._switch_tool(line, block)
            for action, value in block.actions:
                self._act(line, action, value)
        else:
            for event in block.events:
                self._event(on_line(line, event))
        for code in block.settings:
            if code in ("G90", "G91"):
                self._absolute = code == "G90"
            elif code in ("G93", "G94"):
                self._inverse = code == "G93"
            elif code in ("G98", "G99"):
                self._back_to_near = code == "G99"
            elif self._flat and code in self._variant.offsets:
                if self._offset not in (None, code):
                    expected = f"{self._offset} as before; where {code} lies is not known"
                    self._wrong(line, code, expected)
                self._offset = code
            self._seen.add(code)
        if block.probe or (self._heights is not None and "Z" in block.values):
            self._move_z(line, block, self._heights)
        elif block.motion is not None or block.values:
            self._travel(line, block)
        if block.end is not None:
            self._over = True
            self._event(Switch(line, block.end, {}))

    def _switch_tool(self, line: int, block: Block) -> None:
        """Carries out the M words of a table's block, with the S that holds."""
        if block.speed is not None:
            self._speed = block.speed
        laser = self._dialect.laser_mode
        for event in block.events:
            switched = event
            if isinstance(event, Switch) and event.number in (3, 4, 5) and "$" not in event.words:
                self._running = 0 if event.number == 5 else event.number
                self._speed = event.words.get("S", self._speed)
                if self._running and self._speed is not None:
                    switched = replace(event, words={**event.words, "S": self._speed})
                if laser:
                    continue
            if isinstance(switched, Switch) and switched.number == _TOOL_CHANGE:
                self._tools[0] = switched.words.get("T", self._tools[1])
            elif isinstance(switched, FeedShare):
                self._share = switched.share
            elif isinstance(switched, Material):
                number = switched.values.get("number", 0.0)
                self._material_feed = self._dialect.materials.get(number, nan)
            self._event(on_line(line, switched))
        if laser and not self._running:
            self._light(line, None)
        elif self._running and block.speed is not None and not laser and not block.events:
            self._event(Switch(line, self._running, {"S": block.speed}))

    def _light(self, line: int, switch: Switch | None) -> None:
        """In laser mode, the tool on with a power, or dark."""
        if (switch and switch.said) == (self._lit and self._lit.said):
            return
        if self._lit is not None:
            self._event(Switch(line, 5, {}))
        if switch is not None:
            self._event(switch)
        self._lit = switch

    def _carry_out(self, line: int, motion: int, words: Words) -> None:
        self._block(line, Block(feed=words.pop("F", None), motion=motion, values=words))

    def _travel(self, line: int, block: Block) -> None:
        values = block.values
        motion = self._motion if block.motion is None else block.motion
        if motion > _LAST_TRAVEL:
            self._cycle_block(line, motion, values, block.feed is not None)
            return
        if block.motion is not None:
            self._cycle = None
        unexpected = values.keys() - self._axes
        moves = len(unexpected) < len(values)
        if moves and motion > 1:
            unexpected -= _CENTRE
        if moves and motion < 0:
            letters = " or ".join(sorted(values.keys() - unexpected))
            self._wrong(line, f"{letters} without a motion", "G0, G1, G2 or G3 before")
        elif moves:
            if self._dialect.laser_mode:
                power = self._speed or 0.0
                works = self._running and motion > 0 and power > 0.0
                self._light(line, Switch(line, self._running, {"S": power}) if works else None)
            self._motion = motion
            self._check_settings(line)
            words = {k: values[k] for k in values.keys() - unexpected} if unexpected else values
            self._go(line, motion, words, block.feed is not None)
        elif block.motion is not None:
            self._motion = motion
        if unexpected:
            expected = "no such word there"
            self._wrong(line, f"the letter {min(unexpected)} in that block", expected)

    def _cycle_block(self, line: int, motion: int, values: Words, own_feed: bool) -> None:
        """A block of a canned cycle, or its end."""
        self._motion = motion
        unexpected = values.keys() - set("XYZR" + OWN_LETTERS.get(motion, ""))
        if motion == END:
            self._cycle = None
            self._motion, unexpected = -1, set(values)
        elif not unexpected:
            self._check_settings(line)
            if self._seen.isdisjoint(("G98", "G99")):  # versions differ in what holds without
                self._say(line, self._rules.setting, found="G98 or G99")
                self._seen.add("G98")
            holding = {**(self._cycle or {}), **values}
            if holding.get("R", 0.0) < holding.get("Z", 0.0):
                self._wrong(line, "R below Z", "R above Z, or the controller stops")
                return
            self._drill(line, motion, dict(values), own_feed)
        if unexpected:
            self._wrong(line, f"the letter {min(unexpected)} in that block", "no such word there")

    def curve(self, motion: int, start: Point, end: Point, words: Words) -> Curve | str:
        if "I" not in words and "J" not in words:
            return "without I and J"
        centre = (start[0] + words.get("I", 0.0), start[1] + words.get("J", 0.0))
        clockwise = motion == 2
        fault = self.arc_fault(start, end, centre, clockwise)
        return fault or arc_of(start, end, centre, clockwise)

    def finish(self) -> None:
        super().finish()
        last = self._last
        if self._variant.percent and (1 in self._percents) != (last in self._percents):
            self._syntax(last, "%", "% on both the first and the last line, or on none")


def on_line(line: int, event: Other) -> Other:
    """The same event, said on a line."""
    return replace(event, line=line)
