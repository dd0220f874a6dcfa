"""What a table's controller is told besides moves and tools: settings, outputs; arcs it takes.

Compensation is switched on where a stroke begins and off where it ends: a controller refuses it
twice, and a traverse beside the path starts the next stroke elsewhere. How far corners may be
passed, and how the head runs up and brakes, is said before the first stroke.
"""

from collections.abc import Iterator
from math import inf

import numpy as np

from beamcam.checks.sheets import rules
from beamcam.controllers.events import (
    Acceleration,
    Blending,
    Compensation,
    FeedShare,
    Material,
    Other,
    Output,
    Pause,
    Side,
    ToolOffset,
)
from beamcam.controllers.moves import Moves
from beamcam.errors import Diagnostic, Rule, Source
from beamcam.machine.machine import Machine, PathLimits, path_limits
from beamcam.machine.torch import Torch, TorchRow

SLACK = 1e-3  #: share of an acceleration
BLENDED_SLACK = 1e-6  #: mm

Setting = Compensation | Blending | Acceleration


class Watch:
    """Finds what is wrong with a program as it runs; moves are counted from the first."""

    def __init__(self, name: str, diagnostics: list[Diagnostic] | None = None) -> None:
        self.diagnostics = [] if diagnostics is None else diagnostics
        self._name = name

    def _wrong(self, rule: Rule, line: int, **values: object) -> None:
        self.diagnostics.append(rule.at(Source(self._name, line), **values))


class ControllerState(Watch):
    """The settings of a controller while its program runs."""

    def __init__(
        self, machine: Machine, torch: Torch, name: str, diagnostics: list[Diagnostic]
    ) -> None:
        super().__init__(name, diagnostics)
        self.side: Side = "on"
        self.radius = 0.0
        self.limits: PathLimits | None = None  #: where programs have to give accelerations
        if any("{acceleration}" in word for word in machine.words.modal):
            self.limits = path_limits(machine)
        self._kerf_by, self._corner = torch.kerf_by, torch.corner
        self._blends = machine.controller == "linuxcnc"
        #: Moves before it was first said how corners are passed, how the head brakes and runs up.
        self._blended: float = inf
        self._ramped: dict[bool, float] = {True: inf, False: inf}
        self._beside_since = -1  #: moves before compensation was switched on

    def take(self, event: Setting, before: int, is_on: bool, ended: int) -> None:
        """Looks at a setting with `before` moves before it; the last stroke ended at `ended`."""
        if isinstance(event, Blending):
            self._blended = min(self._blended, before)
            self._blend(event.line, event.distance)
        elif isinstance(event, Acceleration):
            self._ramped[event.braking] = min(self._ramped[event.braking], before)
            allowed = self.limits.along_mm_s2 if self.limits is not None else 0.0
            if abs(event.mm_s2 - allowed) > SLACK * allowed:
                expected = f"{allowed:g} mm/s2" if allowed else "none, the machine has no limit"
                found = f"{event.mm_s2:g} mm/s2 {'to brake' if event.braking else 'to run up'}"
                self._wrong(rules.RAMP, event.line, found=found, expected=expected)
        else:
            found = ""
            if is_on:
                found, expected = "compensation with the tool on", "it before"
            elif event.side != "on" and self._kerf_by != "machine":
                # The path keeps half a kerf off already, or none is asked for.
                found = f"compensation by {event.radius:g} mm to the {event.side}"
                expected = f"none, as torch.kerf_by is {self._kerf_by!r}"
            elif event.side != "on" and self.side != "on":
                found, expected = "compensation that is on already", "it off behind each stroke"
            elif event.side == "on" and self.side != "on" and before != ended:
                found, expected = "a traverse with compensation", "it off behind the stroke"
            self.side, self.radius, self._beside_since = event.side, event.radius, before
            if found:
                self._wrong(rules.TOOL, event.line, found=found, expected=expected)

    def starts(self, line: int, before: int) -> None:
        """A tool is started behind so many moves."""
        if self.side != "on" and before != self._beside_since:
            found, expected = "a traverse with compensation", "it on where the stroke begins"
            self._wrong(rules.TOOL, line, found=found, expected=expected)

    def ends(self, line: int) -> None:
        """The program ends."""
        if self.side != "on":
            found, expected = "the end with compensation", "it off behind the last stroke"
            self._wrong(rules.TOOL, line, found=found, expected=expected)

    def _blend(self, line: int, distance: float) -> None:
        """Whether the controller passes corners as the machine's file says."""
        if abs(distance - self._corner) > BLENDED_SLACK:
            on, off = ("G64 P", "G61") if self._blends else ("G52 D", "G50")
            word = f"{on}{self._corner:g}" if self._corner else off
            found = f"{distance:g} mm" if distance < inf else "any distance"
            expected = f"{word}, as torch.corner is {self._corner:g}"
            self._wrong(rules.CORNER, line, found=found, expected=expected)

    def unsaid(self, line: int, before: int) -> None:
        """What was not said before the first move with a tool on, which stands on a line."""
        if self._blends and self._blended > before:
            self._blend(line, inf)
        if self.limits is not None and max(self._ramped.values()) > before:
            expected = f"{self.limits.along_mm_s2:g} mm/s2 to run up and to brake"
            found = "no E word before the first move"
            self._wrong(rules.RAMP, line, found=found, expected=expected)


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


class Outputs(Watch):
    """The outputs while a program runs."""

    def __init__(self, machine: Machine, name: str) -> None:
        super().__init__(name)
        self._row: TorchRow | None = None  #: of the stroke that is made
        self._needs_material = bool(machine.words.material)
        self._state: dict[str, bool] = {}  #: of what was switched
        self._pending: str = ""  #: what the next move switches
        self._flame_s: float | None = None  #: for which the preheat is on here; None: it is off
        self._share = 1.0
        self._tool = 0
        self._material: dict[str, float] | None = None
        self._beside = False  #: compensation is on

    def _output(self, line: int, found: str, expected: str) -> None:
        self._wrong(rules.OUTPUT, line, found=found, expected=expected)

    def moves(self, *_: int) -> None:
        """The head was moved in X or Y."""
        self._pending = ""
        if self._flame_s is not None:
            self._flame_s = 0.0

    def stops(self, _: int) -> None:
        """A tool is stopped."""
        self._row = None

    def starts(self, line: int, row: TorchRow, tool: int) -> None:
        """A tool is started, whose places the row's words choose."""
        self._row = row
        if self._tool != tool:
            self._output(
                line, f"a start with places of {_tool(self._tool)}", f"those of {_tool(tool)}"
            )
        if not self._state.get("arc", True):
            self._output(line, "a start with the arc held out", "it on before")
        flame_s = self._flame_s
        if row.preheat_s:
            if flame_s is None or abs(flame_s - row.preheat_s) > SECONDS_SLACK:
                lit = (
                    "without the preheat" if flame_s is None else f"after {flame_s:g} s of preheat"
                )
                self._output(line, f"cutting oxygen {lit}", f"{row.preheat_s:g} s of it here")
        elif flame_s is not None:
            self._output(line, f"the preheat on to {row.process}", "it off, as the row has none")
        if not self._needs_material or row.process != "cut":
            return
        if self._material is None:
            found, expected = "a cut before a material is chosen", "the words of `material` before"
            self._wrong(rules.MATERIAL, line, found=found, expected=expected)
        for figure, value in (self._material or {}).items():
            own = float(getattr(row, figure, value))
            if abs(value - own) > FIGURE_SLACK:
                found = f"a cut with the material's {figure} {value:g}"
                expected = f"{own:g}, as the row says"
                self._wrong(rules.MATERIAL, line, found=found, expected=expected)

    def take(self, event: Other) -> None:
        """Anything but a move in X and Y."""
        if isinstance(event, Output):
            self._switch(event)
        elif isinstance(event, Pause):
            if self._flame_s is not None:
                self._flame_s += event.seconds
        elif isinstance(event, FeedShare):
            self._share = event.share
            if self._beside:
                found = "a share of the feed with compensation on"
                self._output(event.line, found, "compensation off")
        elif isinstance(event, Compensation):
            self._beside = event.side != "on"
        elif isinstance(event, ToolOffset):
            changed, self._tool = event.number != self._tool, event.number
            if changed and self._row is not None:
                found = f"places of {_tool(event.number)} with a tool on"
                self._output(event.line, found, "it off before")
        elif isinstance(event, Material):
            self._material = event.values

    def _switch(self, event: Output) -> None:
        name = event.name
        self._state[name] = event.on
        if event.with_move:
            self._pending = name
        elif self._pending == name:
            self._pending = ""
        if name in ("thc", "arc") and self._beside:
            what = "height control" if name == "thc" else "arc"
            found = f"the {what} switched with compensation on"
            self._output(event.line, found, "compensation off")
        if name == "preheat":
            self._flame_s = (self._flame_s or 0.0) if event.on else None
            if not event.on and self._row is not None and self._row.preheat_s:
                found = "the preheat off with the cutting oxygen on"
                self._output(event.line, found, "the cutting oxygen off before")

    def ends(self, line: int) -> None:
        """The program ends."""
        for name, state in self._state.items():
            if name == "arc" and not state:
                self._output(line, "the end with the arc held out", "it on")
            elif state and name not in ("thc", "arc"):
                self._output(line, f"the end with {name} on", "it off")
        if self._pending:
            found = f"{self._pending} switched with a move that does not come"
            self._output(line, found, "it switched at once")
        if self._share != 1.0:
            self._output(line, f"the end with {100.0 * self._share:g} % of the feed", "all of it")
        if self._tool:
            self._output(
                line, f"the end with places of {_tool(self._tool)}", f"those of {_tool(0)}"
            )


def _tool(number: int) -> str:
    return f"tool {number}" if number else "the torch"


# --- radii ----------------------------------------------------------------------------------------

# Arcs of a program that its controller does not take.


EPSILON = 1e-6
ROUNDED_STEPS = 4  #: of the program's numbers, by which three rounded places change a radius


def radius_faults(moves: Moves, machine: Machine, torch: Torch, name: str) -> Iterator[Diagnostic]:
    """Arcs below the least radius of the machine or above its greatest.

    The radius is that from the start to the centre. An arc of just the greatest comes out larger
    by what both ends and the centre are rounded to.
    """
    radius, slack = moves.arcs[:, 2], ROUNDED_STEPS * machine.format.resolution
    odd = (radius < torch.min_radius - EPSILON) | (radius > torch.max_radius + slack)
    for k in np.flatnonzero(moves.is_arc & odd).tolist():
        x, y = moves.end[k].tolist()
        yield rules.RADIUS.at(
            Source(name, int(moves.line[k])), found=f"{radius[k]:.6g}", x=f"{x:g}", y=f"{y:g}",
            least=f"{torch.min_radius:g}", greatest=f"{torch.max_radius:g}",
        )  # fmt: skip
