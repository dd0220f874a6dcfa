"""The interpreter of RS274/NGC, for the controllers that descend from it: LinuxCNC and grbl.

    G1 X10 Y5 F600 (comment)      words in any order, spaces mean nothing
    G3 X0 Y0 I-5 J0               I and J from the start of the arc (G91.1)

A block's words act in a fixed order: feed, speed, M words, dwell, settings, motion, end. Motion is
modal. Plain moves are carried out together, everything else block by block.
"""

from math import atan2, degrees, hypot, isnan

from beamcam.controllers.events import Leg, Switch, TableEvent
from beamcam.controllers.gcode import rules
from beamcam.controllers.gcode.controller import Controller
from beamcam.controllers.gcode.moves import Run
from beamcam.controllers.gcode.rs274_words import Block, Dialect, read_block
from beamcam.controllers.gcode.scan import Scan, scan
from beamcam.errors import Diagnostic, Source
from beamcam.geometry.curves import Arc
from beamcam.geometry.plane import Point

#: What the radii at both ends of an arc may always differ by, whatever the radius.
ARC_ALWAYS = 0.005


def run(text: str, name: str, dialect: Dialect) -> tuple[Run, list[Diagnostic]]:
    """What a program does, and what its controller would not do as it says."""
    found = scan(text, dialect.longest_line)
    reader = _Reader(name, dialect, found)
    for number, line in found.odd:
        reader.plain_until(number)
        reader.block(number, line, number in (1, found.lines))
    return reader.finish()


class _Reader(Controller):
    """The state of the controller between two blocks."""

    def __init__(self, name: str, dialect: Dialect, found: Scan) -> None:
        super().__init__(name, dialect.name, found.plain)
        self._scan = found
        self._known: dict[str, Block] = {}  # programs say the same thing over and over
        self._dialect = dialect
        self._seen: set[str] = set()
        self._ready = False

    def _is_simple(self) -> bool:
        return self._ready and super()._is_simple()

    def _move(self, line: int, motion: int, words: dict[str, float]) -> None:
        feed = words.pop("F", None)
        self._carry_out(line, Block(feed=feed, motion=motion, values=words))

    def block(self, line: int, text: str, outermost: bool) -> None:
        """Carries out one block."""
        if len(text) > self._dialect.longest_line:
            self._syntax(line, text, f"at most {self._dialect.longest_line} characters")
        block = self._known.get(text)
        if block is None:
            self._known[text] = block = read_block(text, self._dialect)
        if block.percent:
            if not self._dialect.percent:
                self._syntax(line, text, f"no %, {self._dialect.name} does not know it")
            elif not outermost:
                self._syntax(line, text, "% alone on the first and the last line only")
        elif not block.blank:
            self._carry_out(line, block)

    def _syntax(self, line: int, found: str, expected: str) -> None:
        self._wrong(line, found.strip(), expected, rules.SYNTAX)

    def _carry_out(self, line: int, block: Block) -> None:
        if block.faults and block.faults[0][0] is rules.SYNTAX:
            self._wrong(line, *block.faults[0][1:], rules.SYNTAX)
            return
        if self._ends:
            self._wrong(line, "a block behind the end", "M2 or M30 as the last one")
            return
        for rule, found, expected in block.faults:
            self._wrong(line, found, expected, rule)
        if block.feed is not None:
            self._feed = block.feed
        for event in block.events:
            self._track.event(_on_line(line, event))
        for code in block.settings:
            if code in ("G90", "G91"):
                self._absolute = code == "G90"
            self._seen.add(code)
        if block.motion is not None or block.values:
            self._travel(line, block.motion, dict(block.values))
        if block.ends:
            self._ends += 1
            self._track.event(Switch(line, block.ends[0], {}))

    def _travel(self, line: int, said: int | None, values: dict[str, float]) -> None:
        """The move of a block whose words are not all there, or count from the last place."""
        if said is not None or {"X", "Y"} & values.keys():
            motion = self._motion if said is None else said
            if motion < 0:
                self._wrong(line, "X or Y without a motion", "G0, G1, G2 or G3 before")
            elif "X" in values or "Y" in values:
                x0, y0 = self._place
                base = (0.0, 0.0) if self._absolute else (x0, y0)
                x = base[0] + values.pop("X") if "X" in values else x0
                y = base[1] + values.pop("Y") if "Y" in values else y0
                i = values.pop("I", None) if motion > 1 else None
                j = values.pop("J", None) if motion > 1 else None
                self._go(line, motion, (x, y), i, j)
            else:
                self._motion = motion
        if values:
            self._wrong(line, f"the letter {min(values)} in that block", "no such word there")

    def _go(self, line: int, motion: int, end: Point, i: float | None, j: float | None) -> None:
        start = self._place
        self._place, self._motion = end, motion
        if not self._ready:
            missing = [code for code in self._dialect.needed if code not in self._seen]
            if missing:
                source = Source(self._name, line)
                self.said.append(rules.SETTING.at(source, found=", ".join(missing)))
            self._ready = True
        if isnan(end[0]) or isnan(end[1]):
            self._wrong(line, "a move that says only one of X and Y", "both, the first time")
            return
        if motion < 2:
            if motion == 1 and isnan(start[0]):
                self._wrong(line, "a feed from nowhere", "a traverse before it")
                return
            self._track.leg(Leg(line, motion == 0, start, end, None, self._feed))
            return
        if isnan(start[0]) or (i is None and j is None):
            self._arc_fault(line, "without I and J, or from nowhere")
            return
        centre = (start[0] + (i or 0.0), start[1] + (j or 0.0))
        clockwise = motion == 2
        fault = self._dialect.arc_fault(start, end, centre, clockwise)
        if fault is not None:
            self._arc_fault(line, fault)
            return
        curve = arc(start, end, centre, clockwise)
        self._track.leg(Leg(line, False, start, end, curve, self._feed))

    def finish(self) -> tuple[Run, list[Diagnostic]]:
        """The whole program, and what it has not that a whole one has."""
        last, lines = self._scan.lines, self._scan.odd
        if self._dialect.percent:
            first = lines[0][0] == 1 and lines[0][1].strip() == "%"
            marks = [first, lines[-1][1].strip() == "%"]
            if marks[0] != marks[1]:
                expected = "% on both the first and the last line, or on none"
                self._syntax(last, lines[-1][1], expected)
        return self._ended(last, 1.0, ARC_ALWAYS, self._dialect.arc_fault)


def _on_line(line: int, event: TableEvent) -> TableEvent:
    """The same event, said on a line; `_replace` takes three times as long."""
    return type(event)(line, *event[1:])


def arc(start: Point, end: Point, centre: Point, clockwise: bool) -> Arc:
    """The arc that a controller makes of its numbers; from a point to itself it is a circle."""
    first = degrees(atan2(start[1] - centre[1], start[0] - centre[0]))
    sweep = 360.0
    if start != end:
        last = degrees(atan2(end[1] - centre[1], end[0] - centre[0]))
        sweep = ((first - last) if clockwise else (last - first)) % 360.0 or 360.0
    radius = hypot(start[0] - centre[0], start[1] - centre[1])
    return Arc(centre, radius, first, -sweep if clockwise else sweep)
