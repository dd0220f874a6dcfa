"""What a table's program switches besides its tool: in its order, and nothing left behind.

preheat            on at the place for the seconds of the row before the cutting oxygen, and as
                   long as that
tool beside        places are those of the tool that the row's words choose, of none at the end
material           the controller has the data of the row that cuts
outputs            off at the end
share of the feed  all of it at the end
arc                out only where a cut is closed already, on again before the next start
"""

from collections.abc import Iterator

from beamcam.controllers.events import (
    Compensation,
    FeedShare,
    Material,
    Other,
    Output,
    Pause,
    ToolOffset,
)
from beamcam.controllers.moves import TableRun
from beamcam.errors import Diagnostic, Rule, Source
from beamcam.machine.machine import Machine
from beamcam.machine.torch import TorchRow
from beamcam.verify.sheets import rules
from beamcam.verify.sheets.strokes import HeadStroke, Strokes

SECONDS_SLACK = 1e-6
FIGURE_SLACK = 0.00051  #: of a figure of a row, which programs write to three decimals


def output_faults(run: TableRun, strokes: Strokes, machine: Machine, name: str) -> list[Diagnostic]:
    """What is wrong with the outputs of a program."""
    watch = _Watch(machine, name)
    starts = {stroke.on: stroke for stroke in strokes.each}
    stops = {stroke.off for stroke in strokes.each}
    done, line = 0, 1
    for place, (before, event) in enumerate(run.others):
        if before > done:
            watch.moved()
        done, line = before, event.line
        if place in starts:
            watch.said += watch.starts(event.line, starts[place])
        elif place in stops:
            watch.stroke = None
        watch.said += watch.take(event)
    if len(run.moves) > done:
        watch.moved()
    watch.said += watch.ends(line)
    return watch.said


class _Watch:
    """The outputs while a program runs."""

    def __init__(self, machine: Machine, name: str) -> None:
        self.said: list[Diagnostic] = []
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

    def moved(self) -> None:
        """The head was moved in X or Y."""
        self._pending = ""
        if self._flame_s is not None:
            self._flame_s = 0.0

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
