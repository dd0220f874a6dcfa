"""Heights of a torch whose program moves it up and down, and the control of its height by voltage.

traverse       clear of the sheet
touch, zero    before the first height that counts on them, and before each start if so asked
start          at the pierce height of the row, the height control off
down           at a feed to the cut height, before the first move along the contour
cut            at the cut height, the height control on; off in small holes and near corners
               where the file says so
stop           the height control off first, then the tool, then up
end            clear, and Z counts as it did before
"""

from collections.abc import Iterator
from math import inf, isnan, nan

import numpy as np

from beamcam.checks.sheets import rules
from beamcam.checks.sheets.strokes import HeadStroke, Strokes
from beamcam.controllers.events import (
    Compensation,
    FeedShare,
    Lift,
    Material,
    Other,
    Output,
    Pause,
    ToolOffset,
    Touch,
    Zero,
)
from beamcam.controllers.moves import Moves, TableRun
from beamcam.errors import Diagnostic, Rule, Source
from beamcam.machine.machine import Machine
from beamcam.machine.torch import Torch, TorchRow

SLACK = 0.001  #: mm, and half of what the program's numbers step by
SECONDS_PER_MINUTE = 60.0
SLOWER = 0.99  #: share of the row's feed below which a move is one in a small hole or at a corner


def switching_faults(
    run: TableRun, strokes: Strokes, machine: Machine, torch: Torch, name: str
) -> list[Diagnostic]:
    """What is wrong with where the torch stands, what holds it there, and with its outputs."""
    watches = _Watch(run.moves, machine, torch, name), _Outputs(machine, name)
    starts = {stroke.on: stroke for stroke in strokes.each}
    stops = {stroke.off for stroke in strokes.each}
    for watch in watches:
        done, line = 0, 1
        for place, (before, event) in enumerate(run.others):
            if before > done:
                watch.diagnostics += watch.moves(done, before)
            done, line = before, event.line
            if place in starts:
                watch.diagnostics += watch.starts(line, starts[place])
            elif place in stops:
                watch.diagnostics += watch.stops(line)
            watch.diagnostics += watch.take(event)
        if len(run.moves) > done:
            watch.diagnostics += watch.moves(done, len(run.moves))
        watch.diagnostics += watch.ends(line)
    return [one for watch in watches for one in watch.diagnostics]


class _Watch:
    """The torch over the sheet while its program runs."""

    def __init__(self, moves: Moves, machine: Machine, torch: Torch, name: str) -> None:
        self.diagnostics: list[Diagnostic] = []
        self._rapid, self._lines = moves.rapid.tolist(), moves.line
        self._feeds = np.where(moves.rapid, inf, moves.feed_mm_min)
        self._torch, self._name = torch, name
        self._follows = torch.z == "program"
        speeds = [axis.speed for axis in machine.axes if axis.moves == "Z"]
        self._fastest = min(speeds, default=inf) * SECONDS_PER_MINUTE
        self._slack = SLACK + machine.format.resolution / 2
        self._height = nan
        self._touched = torch.touch == "none"  #: since the torch was traversed, or ever
        self._zeroed = True  #: since it touched
        self._shifted = False  #: G92 holds
        self._stroke: HeadStroke | None = None
        self._moved = False  #: since the tool was started
        self._by_program = torch.thc == "program"
        self._thc = not self._by_program

    def _fault(self, rule: Rule, line: int, found: str, expected: str) -> Diagnostic:
        return rule.at(Source(self._name, line), found=found, expected=expected)

    def _off(self, height: float) -> bool:
        """Whether the torch stands elsewhere, or where nothing says."""
        return not abs(self._height - height) <= self._slack

    def moves(self, first: int, last: int) -> Iterator[Diagnostic]:
        """What is wrong with the moves in X and Y of one height."""
        rapids = self._rapid[first:last]
        if True in rapids:
            self._touched = self._touched and self._torch.touch != "each"
            clear = self._height >= self._torch.clearance - self._slack
            if self._follows and not clear:
                line = int(self._lines[first + rapids.index(True)])
                expected = f"{self._torch.clearance:g} mm or more"
                found = f"a traverse {_shown(self._height)}"
                yield self._fault(rules.HEIGHT, line, found, f"{expected} (torch.clearance)")
        if self._stroke is None or False not in rapids:
            return
        line = int(self._lines[first + rapids.index(False)])
        height = self._stroke.row.cut_height
        if self._follows and height and self._off(height):
            found, process = f"a feed {_shown(self._height)}", self._stroke.process
            yield self._fault(rules.HEIGHT, line, found, f"{height:g} mm to {process}")
        if self._stroke.process == "cut":
            is_wrong = not self._thc
            if not self._torch.thc_slow:
                feeds = self._feeds[first:last]
                slow = feeds < SLOWER * self._stroke.row.feed_mm_min
                is_wrong = bool((slow == self._thc)[np.isfinite(feeds)].any())
            if is_wrong:
                found = f"a cut with the height control {'on' if self._thc else 'off'}"
                expected = "it off in small holes and near corners" if self._thc else "it on"
                yield self._fault(rules.THC, line, found, expected)
        self._moved = True

    def starts(self, line: int, stroke: HeadStroke) -> Iterator[Diagnostic]:
        """What is wrong as a tool is started."""
        self._stroke, self._moved = stroke, False
        height = stroke.row.pierce_height or stroke.row.cut_height
        if self._follows and height and not self._touched:
            when = "since it was traversed" if self._torch.touch == "each" else "before"
            expected = f"the sheet touched {when} (torch.touch)"
            yield self._fault(rules.HEIGHT, line, "a start without a touch", expected)
        elif self._follows and height and self._off(height):
            found, process = f"the tool started {_shown(self._height)}", stroke.process
            yield self._fault(rules.HEIGHT, line, found, f"{height:g} mm to {process}")
        if self._by_program and self._thc:
            found = "a start with the height control on"
            yield self._fault(rules.THC, line, found, "it off until the torch is at its height")

    def stops(self, line: int) -> Iterator[Diagnostic]:
        """What is wrong as a tool is stopped."""
        self._stroke = None
        if self._by_program and self._thc:
            found = "the tool stopped with the height control on"
            yield self._fault(rules.THC, line, found, "that off before")

    def take(self, event: Other) -> Iterator[Diagnostic]:
        """Anything but a move in X and Y."""
        if isinstance(event, Output) and event.name == "thc":
            yield from self._switch(event)
        elif isinstance(event, Zero):
            self._shifted, self._zeroed = event.shifted, True
        elif isinstance(event, Touch):
            self._height, self._touched, self._zeroed = event.height, True, False
            if self._stroke is not None:
                yield self._fault(rules.HEIGHT, event.line, "a touch with the tool on", "it off")
            yield from self._feed(event, "a touch")
        elif isinstance(event, Lift):
            yield from self._lift(event)

    def _switch(self, event: Output) -> Iterator[Diagnostic]:
        row = None if self._stroke is None else self._stroke.row
        high = self._follows and row is not None and bool(row.cut_height)
        if event.on and self._by_program and (row is None or (high and self._off(row.cut_height))):
            found = (
                f"the height control on {_shown(self._height)}"
                if row
                else ("the height control on with the tool off")
            )
            yield self._fault(rules.THC, event.line, found, "it on in a cut, at its height")
        self._thc = event.on

    def _lift(self, event: Lift) -> Iterator[Diagnostic]:
        """What is wrong with a move up or down."""
        self._height = event.end
        if not event.rapid:
            yield from self._feed(event, "a move in Z")
        found = f"a move in Z to where the torch is {_shown(event.end)}"
        expected = ""
        if not self._zeroed:
            found, expected = "a height that counts from before the touch", "G92 behind the touch"
        elif isnan(event.end):
            expected = "a Z that counts from the sheet, or the machine's top (torch.top)"
        elif event.end < -self._slack:
            expected = "0 or more, as only a touch goes farther"
        elif self._stroke is not None:
            row = self._stroke.row
            least, most = sorted((row.cut_height, row.pierce_height or row.cut_height))
            if self._moved:
                found, expected = "a move in Z in mid contour", "the tool off before"
            elif event.rapid:
                found, expected = "a traverse in Z with the tool on", "a feed"
            elif not least - self._slack <= event.end <= most + self._slack:
                expected = f"{least:g} to {most:g} mm with the tool on"
        if expected:
            yield self._fault(rules.HEIGHT, event.line, found, expected)

    def _feed(self, event: Lift | Touch, what: str) -> Iterator[Diagnostic]:
        """Whether Z is fed, and no faster than its axis goes; a macro's feed is its own."""
        feed = event.feed_mm_min
        if feed <= 0.0 or feed > self._fastest:
            expected = f"up to {self._fastest:g} mm/min" if self._fastest < inf else "F before"
            yield self._fault(rules.HEIGHT, event.line, f"{what} at a feed of {feed:g}", expected)

    def ends(self, line: int) -> Iterator[Diagnostic]:
        """What is wrong when the program ends."""
        if self._follows and not self._height >= self._torch.clearance - self._slack:
            found = f"the end with the torch {_shown(self._height)}"
            yield self._fault(rules.HEIGHT, line, found, f"{self._torch.clearance:g} mm or more")
        if self._shifted:
            expected = "G92.1 before, or every next program counts Z from there"
            yield self._fault(rules.HEIGHT, line, "the end while G92 holds", expected)
        if self._thc == self._by_program:
            state = "on" if self._thc else "off"
            found, expected = f"the end with the height control {state}", "it as it was before"
            yield self._fault(rules.THC, line, found, expected)


def _shown(height: float) -> str:
    if isnan(height):
        return "at a height that nothing says"
    return "at the top of the axis" if height == inf else f"{height:g} mm over the sheet"


# --- outputs --------------------------------------------------------------------------------------

# What a table's program switches besides its tool: in its order, and nothing left behind.
#
# preheat            on at the place for the seconds of the row before the cutting oxygen, and as
#                    long as that
# tool beside        places are those of the tool that the row's words choose, of none at the end
# material           the controller has the data of the row that cuts
# outputs            off at the end
# share of the feed  all of it at the end
# arc                out only where a cut is closed already, on again before the next start


SECONDS_SLACK = 1e-6
FIGURE_SLACK = 0.00051  #: of a figure of a row, which programs write to three decimals


class _Outputs:
    """The outputs while a program runs."""

    def __init__(self, machine: Machine, name: str) -> None:
        self.diagnostics: list[Diagnostic] = []
        self.stroke: HeadStroke | None = None
        self._name = name
        self._needs_material = bool(machine.words.material)
        self._state: dict[str, bool] = {}  #: of what was switched
        self._pending: str = ""  #: what the next move switches
        self._flame_s: float | None = None  #: for which the preheat is on here; None: it is off
        self._share = 1.0
        self._tool = 0
        self._material: dict[str, float] | None = None
        self._beside = False  #: compensation is on

    def _fault(self, rule: Rule, line: int, found: str, expected: str) -> Diagnostic:
        return rule.at(Source(self._name, line), found=found, expected=expected)

    def moves(self, *_: int) -> Iterator[Diagnostic]:
        """The head was moved in X or Y."""
        self._pending = ""
        if self._flame_s is not None:
            self._flame_s = 0.0
        yield from ()

    def stops(self, _: int) -> Iterator[Diagnostic]:
        """A tool is stopped."""
        self.stroke = None
        yield from ()

    def starts(self, line: int, stroke: HeadStroke) -> Iterator[Diagnostic]:
        """What is wrong as a tool is started."""
        self.stroke = stroke
        row = stroke.row
        if self._tool != stroke.tool:
            found = f"a start with places of {_tool(self._tool)}"
            yield self._fault(rules.OUTPUT, line, found, f"those of {_tool(stroke.tool)}")
        if not self._state.get("arc", True):
            yield self._fault(rules.OUTPUT, line, "a start with the arc held out", "it on before")
        if row.preheat_s:
            flame_s = self._flame_s
            if flame_s is None or abs(flame_s - row.preheat_s) > SECONDS_SLACK:
                found = "cutting oxygen " + (
                    "without the preheat"
                    if flame_s is None
                    else (f"after {flame_s:g} s of preheat")
                )
                yield self._fault(rules.OUTPUT, line, found, f"{row.preheat_s:g} s of it here")
        elif self._flame_s is not None:
            found = f"the preheat on to {stroke.process}"
            yield self._fault(rules.OUTPUT, line, found, "it off, as the row has none")
        if self._needs_material and row.process == "cut":
            yield from self._material_faults(line, row)

    def _material_faults(self, line: int, row: TorchRow) -> Iterator[Diagnostic]:
        """Whether the controller has the data of the row."""
        if self._material is None:
            found, expected = "a cut before a material is chosen", "the words of `material` before"
            yield self._fault(rules.MATERIAL, line, found, expected)
            return
        for figure, value in self._material.items():
            asked = float(getattr(row, figure, value))
            if abs(value - asked) > FIGURE_SLACK:
                found = f"a cut with the material's {figure} {value:g}"
                yield self._fault(rules.MATERIAL, line, found, f"{asked:g}, as the row says")

    def take(self, event: Other) -> Iterator[Diagnostic]:
        """Anything but a move in X and Y."""
        if isinstance(event, Output):
            yield from self._switch(event)
        elif isinstance(event, Pause):
            if self._flame_s is not None:
                self._flame_s += event.seconds
        elif isinstance(event, FeedShare):
            self._share = event.share
            if self._beside:
                found = "a share of the feed with compensation on"
                yield self._fault(rules.OUTPUT, event.line, found, "compensation off")
        elif isinstance(event, Compensation):
            self._beside = event.side != "on"
        elif isinstance(event, ToolOffset):
            changed, self._tool = event.number != self._tool, event.number
            if changed and self.stroke is not None:
                found = f"places of {_tool(event.number)} with a tool on"
                yield self._fault(rules.OUTPUT, event.line, found, "it off before")
        elif isinstance(event, Material):
            self._material = event.values

    def _switch(self, event: Output) -> Iterator[Diagnostic]:
        name = event.name
        self._state[name] = event.on
        if event.with_move:
            self._pending = name
        elif self._pending == name:
            self._pending = ""
        if name in ("thc", "arc") and self._beside:
            what = "height control" if name == "thc" else "arc"
            found = f"the {what} switched with compensation on"
            yield self._fault(rules.OUTPUT, event.line, found, "compensation off")
        if name == "preheat":
            lit = 0.0 if self._flame_s is None else self._flame_s
            self._flame_s = lit if event.on else None
            if not event.on and self.stroke is not None and self.stroke.row.preheat_s:
                found = "the preheat off with the cutting oxygen on"
                yield self._fault(rules.OUTPUT, event.line, found, "the cutting oxygen off before")

    def ends(self, line: int) -> Iterator[Diagnostic]:
        """What is wrong when the program ends."""
        for name, state in self._state.items():
            if name == "arc" and not state:
                yield self._fault(rules.OUTPUT, line, "the end with the arc held out", "it on")
            elif state and name not in ("thc", "arc"):
                yield self._fault(rules.OUTPUT, line, f"the end with {name} on", "it off")
        if self._pending:
            found = f"{self._pending} switched with a move that does not come"
            yield self._fault(rules.OUTPUT, line, found, "it switched at once")
        if self._share != 1.0:
            found = f"the end with {100.0 * self._share:g} % of the feed"
            yield self._fault(rules.OUTPUT, line, found, "all of it")
        if self._tool:
            found = f"the end with places of {_tool(self._tool)}"
            yield self._fault(rules.OUTPUT, line, found, f"those of {_tool(0)}")


def _tool(number: int) -> str:
    return f"tool {number}" if number else "the torch"
