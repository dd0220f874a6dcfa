"""A cutting table with a trigger program: axes, switches, torch, and the clock.

Axes count places from their low limit switches, which close there; the work area begins where
the machine's back-off ends, and the high switches lie `overrun` behind it.
"""

from collections.abc import Sequence
from math import atan2, cos, hypot, pi, sin
from typing import Any

from beamcam.errors import Diagnostic, Rule, Source
from beamcam.machine.machine import Machine, TorchProcess
from beamcam.verify.st import rules
from beamcam.verify.st.axes import Axis, Path
from beamcam.verify.st.interpreter import Interpreter
from beamcam.verify.st.syntax import Unit

Place = tuple[float, float]

SAMPLES = 4  #: of the path in each cycle
STALL_S = 3.0  #: all standing so long and nothing comes
BEGIN: Place = (60.0, 45.0)  #: where the axes stand before homing
CIRCLE_STEPS = 256  #: chords of a circle that a path object runs
BRAKE = 2.0  #: a stop brakes so many times as hard as work does
REFUSED = 1
SHOWN = 5


class Stroke:
    """What the head does between one start of its tool and the end."""

    def __init__(self, process: TorchProcess, begin_s: float, line: int) -> None:
        self.process: TorchProcess = process
        self.begin_s = begin_s
        self.first_move_s: float | None = None
        self.line = line
        self.points: list[Place] = []
        self.greatest_mm_s = 0.0


class Cell:
    """Runs a program cycle by cycle."""

    def __init__(self, units: Sequence[Unit], machine: Machine, name: str) -> None:
        triggers, torch = machine.triggers, machine.torch
        if triggers is None or torch is None:
            raise TypeError(f"{machine.name} has no trigger program")
        self.machine, self.triggers, self.torch, self.name = machine, triggers, torch, name
        self.clock_s = 0.0
        brake = BRAKE * triggers.acceleration
        self.axes = tuple(
            Axis(axis, place, brake) for axis, place in zip(triggers.axes, BEGIN, strict=True)
        )
        self.path = Path(*self.axes) if triggers.path_objects else None
        self.ends = tuple(
            triggers.back_off + s + triggers.overrun for s in (torch.length, torch.width)
        )
        self.closed: set[int] = set()  #: limit switches that are held closed
        self.said: list[Diagnostic] = []
        self.strokes: list[Stroke] = []
        self.commands = 0
        self.interpreter = Interpreter(units, self, name)
        self._on: dict[str, Stroke] = {}
        self._still_s = 0.0
        self._line: tuple[Place, Place] | None = None
        self._off_line = 0.0
        self._wires()

    # -- what the program reaches -----------------------------------------------------------

    def find(self, name: str) -> Any:
        for axis in self.axes:
            if axis.name.upper() == name.upper():
                return axis
        if self.path is not None and name.upper() == self.triggers.path_object.upper():
            return self.path
        return None

    def system(self, base: Any, name: str) -> Any:
        if isinstance(base, Axis):
            if name == "CONTROL":
                return "ACTIVE" if base.enabled else "INACTIVE"
            if name == "POSITION":
                return base.position
            if name == "VELOCITY":
                return base.velocity
        return base

    def command(self, name: str, values: dict[str, Any], line: int) -> int:
        self.commands += 1
        if name.startswith("_MOVEPATH"):
            return self._path(name, values, line)
        if name == "_STOPPATH":
            values["PATHOBJECT"].stop()
            return 0
        axis: Axis = values["AXIS"]
        if values["NEXTCOMMAND"] != "IMMEDIATELY":
            self._command(line, f"nextCommand {values['NEXTCOMMAND']}", "IMMEDIATELY in a cycle")
        if name == "_ENABLEAXIS":
            axis.enabled = True
            return 0
        if not axis.enabled:
            self._command(line, f"{axis.name} commanded before it is enabled", "_enableAxis")
            return REFUSED
        if name == "_STOP":
            axis.stop()
        elif name == "_HOMING":
            return self._homing(axis, values, line)
        elif name == "_MOVE":
            return self._move(axis, values, line)
        elif name == "_POS":
            return self._pos(axis, values, line)
        return 0

    def _command(self, line: int, found: str, expected: str) -> None:
        self.say(rules.COMMAND, line, found=found, expected=expected)

    def say(self, rule: Rule, line: int | None, **values: object) -> None:
        """Add a message, unless there are many of the kind already."""
        if sum(d.code == rule.code for d in self.said) < SHOWN:
            self.said.append(rule.at(Source(self.name, line), **values))

    def _dynamics(self, values: dict[str, Any], line: int) -> bool:
        """Whether velocity and accelerations are above 0, as commands want them."""
        for key in ("VELOCITY", "POSITIVEACCEL", "NEGATIVEACCEL"):
            if key in values and not values[key] > 0.0:
                self._command(line, f"{key.lower()} {values[key]:g}", "more than 0")
                return False
            kind = values.get(key + "TYPE", "DIRECT")
            if kind != "DIRECT":
                self._command(line, f"{key.lower()}Type {kind}", "DIRECT")
        if values.get("VELOCITYPROFILE", "TRAPEZOIDAL") != "TRAPEZOIDAL":
            self._command(line, "a smooth profile", "TRAPEZOIDAL, so that axes arrive together")
        return True

    def _move(self, axis: Axis, values: dict[str, Any], line: int) -> int:
        if not self._dynamics(values, line):
            return REFUSED
        sign = -1.0 if values["DIRECTION"] == "NEGATIVE" else 1.0
        axis.run(sign * values["VELOCITY"], self.triggers.acceleration)
        return 0

    def _homing(self, axis: Axis, values: dict[str, Any], line: int) -> int:
        if values["HOMINGMODE"] != "DIRECT_HOMING" or values["HOMEPOSITIONTYPE"] != "DIRECT":
            self._command(line, f"{values['HOMINGMODE']}", "DIRECT_HOMING to a DIRECT position")
            return REFUSED
        if abs(axis.velocity) > 1e-6:
            self.say(rules.HOME, line, found=f"{axis.name} moving", expected="it at rest")
        axis.home(values["HOMEPOSITION"])
        if axis.homed == 2:
            off = axis.place - axis.position - self.triggers.back_off
            # A stop runs on behind the switch by v^2 / 2a, and the next scan sees it late.
            slack = self.triggers.homing_mm_s * self.triggers.cycle_s * 2
            slack += self.triggers.homing_mm_s**2 / (2 * axis.brake)
            if not -slack <= off <= 0.1:
                found = f"zero of {axis.name} {axis.origin:.3f} mm from its switch"
                self.say(rules.HOME, line, found=found, expected=f"{self.triggers.back_off:g} mm")
        return 0

    @property
    def working(self) -> bool:
        """Whether both axes know where they are."""
        return all(axis.homed >= 2 for axis in self.axes)

    def _pos(self, axis: Axis, values: dict[str, Any], line: int) -> int:
        if not self._dynamics(values, line):
            return REFUSED
        position = values["POSITION"]
        if values["POSITIONINGMODE"] == "RELATIVE":
            position += axis.position
        if values["MERGEMODE"] != "IMMEDIATELY":
            self._command(line, f"mergeMode {values['MERGEMODE']}", "IMMEDIATELY")
        if self.working:
            self._triggered(axis, position, line)
            index = self.axes.index(axis)
            length = (self.torch.length, self.torch.width)[index]
            slack = self.torch.tolerance
            if not -slack <= position <= length + slack:
                self._command(line, f"{axis.name} to {position:g}", f"0 to {length:g}")
        axis.go(position, values["VELOCITY"], values["POSITIVEACCEL"], values["NEGATIVEACCEL"])
        if self.working:
            start = tuple(a.position for a in self.axes)
            ends = tuple(a.position if a.target is None else a.target for a in self.axes)
            self._line = ((start[0], start[1]), (ends[0], ends[1]))
        return 0

    def _triggered(self, axis: Axis, position: float, line: int) -> None:
        """Complain about an operation that starts twice, or before the last one has ended."""
        near = self.triggers.in_position + 1e-9
        if axis.target is not None and position == axis.target:
            found = f"{axis.name} sent to {position:g} again"
            self.say(rules.TRIGGER, line, found=found, expected="each operation once")
        for one in self.axes:
            if one.target is None:
                continue
            if one is not axis and self._sent.get(one.name) == self.clock_s:
                continue  # the other half of this operation
            left = abs(one.position - one.target)
            if left > near:
                found = f"an operation while {one.name} has {left:.3f} mm to go"
                self.say(rules.TRIGGER, line, found=found, expected="it behind the last one's end")
        self._sent[axis.name] = self.clock_s

    def _path(self, name: str, values: dict[str, Any], line: int) -> int:
        if not self._dynamics(values, line) or self.path is None:
            return REFUSED
        here = (self.axes[0].position, self.axes[1].position)
        end = (values["X"], values["Y"])
        if values["PATHPLANE"] != "X_Y" or values["PATHMODE"] != "ABSOLUTE":
            self._command(line, "another plane or mode", "X_Y and ABSOLUTE")
        if not self.path.still:
            found = "an operation while the path object moves"
            self.say(rules.TRIGGER, line, found=found, expected="it behind the last one's end")
        points = [here, end]
        if name == "_MOVEPATHCIRCULAR":
            middle = (values["I"], values["J"])
            if values["IJKMODE"] != "ABSOLUTE":
                self._command(line, "a relative middle", "ijkMode ABSOLUTE")
            if values["CIRCULARTYPE"] != "OVER_POSITION_TO_ENDPOSITION":
                self._command(line, str(values["CIRCULARTYPE"]), "OVER_POSITION_TO_ENDPOSITION")
            points = circle_points(here, middle, end)
            if not points:
                self._command(line, "a circle through points in a line (alarm 50002)", "an arc")
                return REFUSED
        self.path.add(points, values["VELOCITY"], values["POSITIVEACCEL"], values["NEGATIVEACCEL"])
        return 0

    # -- time -------------------------------------------------------------------------------

    def _wires(self) -> None:
        """Which variables the inputs and outputs of the machine are."""
        self._sent: dict[str, float] = {}
        known = self.interpreter.addresses
        self._inputs: list[str] = []
        for address in (*self.triggers.limits, self.triggers.start):
            if address.upper() not in known:
                self.say(
                    rules.HOME, None, found=f"nothing at {address}", expected="a variable AT it"
                )
            self._inputs.append(known.get(address.upper(), ""))
        self._outputs: dict[TorchProcess, str] = {}
        for process, address in self.triggers.outputs.items():
            if address.upper() not in known:
                self.say(
                    rules.TOOL, None, found=f"nothing at {address}", expected="a variable AT it"
                )
            else:
                self._outputs[process] = known[address.upper()]  # type: ignore[index]

    def cycle(self) -> None:
        """One scan of the program, and what the axes do until the next. Raises Fault."""
        values = self.interpreter.globals
        x, y = self.axes
        switches = [
            x.place <= 0.0,
            x.place >= self.ends[0],
            y.place <= 0.0,
            y.place >= self.ends[1],
        ]
        for k, key in enumerate(self._inputs):
            if key:
                values[key] = k in self.closed or (switches[k] if k < 4 else True)
        before = self.commands
        self.interpreter.scan()
        self._tools(values)
        step = self.triggers.cycle_s / SAMPLES
        for _ in range(SAMPLES):
            if self.path is not None:
                self.path.advance(step)
            for axis in self.axes:
                axis.advance(step)
            self._sample()
        self.clock_s += self.triggers.cycle_s
        moving = any(not axis.still for axis in self.axes)
        moving = moving or (self.path is not None and not self.path.still)
        if moving or self.commands != before:
            self._still_s = 0.0
        else:
            self._still_s += self.triggers.cycle_s

    @property
    def stalled(self) -> bool:
        """Whether nothing has moved for longer than any pierce takes."""
        waits = max((row.pierce_s for row in self.torch.rows), default=0.0)
        return self._still_s > STALL_S + 2 * waits

    def _tools(self, values: dict[str, Any]) -> None:
        for process, key in self._outputs.items():
            on = bool(values[key])
            if on and process not in self._on:
                if not self.working:
                    self.say(rules.TOOL, None, found=f"{process} on before homing", expected="off")
                if self._on:
                    self.say(rules.TOOL, None, found="two tools on", expected="one")
                self._on[process] = Stroke(process, self.clock_s, 0)
                self.strokes.append(self._on[process])
            elif not on and process in self._on:
                del self._on[process]

    @property
    def tool_on(self) -> bool:
        return bool(self._on)

    def _sample(self) -> None:
        x, y = self.axes
        here = (x.position, y.position)
        speed = hypot(x.velocity, y.velocity)
        for stroke in self._on.values():
            if not stroke.points or here != stroke.points[-1]:
                if stroke.points and stroke.first_move_s is None:
                    stroke.first_move_s = self.clock_s
                stroke.points.append(here)
            stroke.greatest_mm_s = max(stroke.greatest_mm_s, speed)
        if self._line is not None and self.path is None:
            self._off_line = max(self._off_line, _off_line(here, *self._line))

    @property
    def off_line(self) -> float:
        """The farthest that the axes were off the lines of their operations."""
        return self._off_line


def _off_line(point: Place, start: Place, end: Place) -> float:
    """Distance of a point from a stretch."""
    dx, dy = end[0] - start[0], end[1] - start[1]
    length2 = dx * dx + dy * dy
    px, py = point[0] - start[0], point[1] - start[1]
    if length2 == 0.0:
        return hypot(px, py)
    t = min(1.0, max(0.0, (px * dx + py * dy) / length2))
    return hypot(px - t * dx, py - t * dy)


def circle_points(start: Place, middle: Place, end: Place) -> list[Place]:
    """Points of the arc from start over middle to end; nothing if they lie in a line.

    The centre is where the perpendicular bisectors of both chords meet.
    """
    ax, ay = middle[0] - start[0], middle[1] - start[1]
    bx, by = end[0] - start[0], end[1] - start[1]
    det = 2 * (ax * by - ay * bx)
    if abs(det) < 1e-9:
        return []
    a2, b2 = ax * ax + ay * ay, bx * bx + by * by
    cx, cy = (by * a2 - ay * b2) / det, (ax * b2 - bx * a2) / det
    radius = hypot(cx, cy)
    centre = (start[0] + cx, start[1] + cy)
    first = atan2(-cy, -cx)
    last = atan2(end[1] - centre[1], end[0] - centre[0])
    sweep = (last - first) % (2 * pi) if det > 0 else -((first - last) % (2 * pi))
    count = max(2, round(CIRCLE_STEPS * abs(sweep) / pi))
    inner = [
        (centre[0] + radius * cos(first + sweep * k / count),
         centre[1] + radius * sin(first + sweep * k / count))
        for k in range(1, count)
    ]  # fmt: skip
    return [start, *inner, end]
