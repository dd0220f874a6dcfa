"""A cutting table with a trigger program: axes, switches, buttons, tools and the clock.

Axes count places from their low limit switches, which are actuated there; the work area begins
where the machine's back-off ends, and the high switches lie `overrun` behind it. The low
switch of Z, where there is one, lies `overrun` below what the sheet lies on.
"""

from collections.abc import Sequence
from typing import Any

from beamcam.controllers.simotion import rules
from beamcam.controllers.simotion.axes import Axis, PathObject, circle_points
from beamcam.controllers.simotion.interpreter import ProjectInterpreter
from beamcam.controllers.simotion.motion_blocks import motion_blocks, start
from beamcam.controllers.simotion.syntax import Unit
from beamcam.errors import Diagnostic, Rule, Source, add_few
from beamcam.machine.machine import Machine
from beamcam.machine.runtime import INPUTS, PROCESSES, STOP_BRAKES, is_address

Place = tuple[float, float]

SAMPLES = 4  #: of the path in each cycle
BEGIN = (6.0, 4.5, 20.0)  #: axis positions before homing
REFUSED = 1


class CuttingTable:
    """Runs a program cycle by cycle."""

    def __init__(self, units: Sequence[Unit], machine: Machine, name: str) -> None:
        triggers = machine.needed(machine.triggers, "trigger program")
        torch = machine.needed(machine.torch, "trigger program")
        self.machine, self.triggers, self.torch, self.name = machine, triggers, torch, name
        self.clock_s = 0.0
        brake = STOP_BRAKES * triggers.acceleration
        self.axes = tuple(
            Axis(axis, place, brake) for axis, place in zip(triggers.all_axes, BEGIN, strict=False)
        )
        self.path = PathObject(*self.axes[:2]) if triggers.path_objects else None
        self.objects: dict[str, Any] = {axis.name.upper(): axis for axis in self.axes}
        if self.path is not None:
            self.objects[triggers.path_object.upper()] = self.path
        self.ends = tuple(
            triggers.back_off + s + triggers.overrun for s in (torch.length, torch.width)
        )
        if (z := triggers.z) is not None:
            self.ends = (*self.ends, triggers.overrun + z.home_height + z.back_off)
        self.closed: set[int] = set()  #: limit switches that are held actuated
        self.loose: set[int] = set()  #: limit switches that are held released
        self.broken: set[int] = set()  #: inputs with a broken wire
        self.start = self.acknowledge = self.stop = False  #: buttons
        self.diagnostics: list[Diagnostic] = []
        self.points: dict[str, list[Place]] = {}  #: of each tool, while it was on
        self.heights: dict[str, list[float]] = {}  #: of Z at these points, where there is one
        self.natives = motion_blocks(self)
        places = (*triggers.inputs, *self._outputs, triggers.fault_lamp)
        outside = [place for place in places if place and not is_address(place)]
        self.interpreter = ProjectInterpreter(units, self, name, outside)
        self._read = [
            (self._variable(place, name), place in triggers.normally_closed)
            for name, place in zip(INPUTS, triggers.inputs, strict=False)
        ]
        self._tools = {
            process: self._variable(place, f"{process}On")
            for process, place in zip(PROCESSES, self._outputs, strict=True)
        }
        if self.interpreter.has("CutStart"):
            self.interpreter.run("CutStart")

    @property
    def _outputs(self) -> tuple[str, ...]:
        return tuple(self.triggers.outputs.get(process, "") for process in PROCESSES)

    # -- what the program reaches -----------------------------------------------------------

    def system(self, base: Any, name: str) -> Any:
        """A system variable; a group of them is its axis with the name of the group."""
        if isinstance(base, Axis):
            if name == "CONTROL":
                return "ACTIVE" if base.enabled else "INACTIVE"
            if name == "ERROR":
                return "YES" if base.error else "NO"
            return base, name
        axis, group = base
        if name == "COMMANDPOSITION":
            return axis.position
        if name == "VELOCITY":
            return axis.velocity
        assert group == "BASICMOTION" or name == "ACTUALPOSITION"
        return axis.actual

    def command(self, name: str, values: dict[str, Any], line: int) -> int:
        """Carry out a command; 0 if it was accepted."""
        if name in self.natives:
            return 0 if start(self, name, values) else REFUSED
        if values["NEXTCOMMAND"] != "IMMEDIATELY":
            self._command(line, f"nextCommand {values['NEXTCOMMAND']}", "IMMEDIATELY in a cycle")
        if name == "_STOPPATH":
            values["PATHOBJECT"].stop()
            return 0
        moved: tuple[Axis, ...] = (values["AXIS"],) if "AXIS" in values else self.axes
        if name == "_ENABLEAXIS":
            return moved[0].enable()
        if name == "_RESETAXISERROR":
            return moved[0].reset()
        fit = all(axis.enabled and not axis.error for axis in moved)
        if not fit or not self._dynamics(values, line):
            return REFUSED
        if name.startswith("_MOVEPATH"):
            return self._path(name, values, line)
        if name == "_HOMING":
            return self._homing(moved[0], values, line)
        if name == "_STOP":
            moved[0].stop()
        elif name == "_MOVE":
            sign = -1.0 if values["DIRECTION"] == "NEGATIVE" else 1.0
            moved[0].run(sign * values["VELOCITY"], self.triggers.acceleration)
        elif name == "_POS":
            if values["POSITIONINGMODE"] != "ABSOLUTE" or values["MERGEMODE"] != "IMMEDIATELY":
                mode = f"{values['POSITIONINGMODE']} with {values['MERGEMODE']}"
                self._command(line, mode, "ABSOLUTE with IMMEDIATELY")
            limits = (values[key] for key in ("VELOCITY", "POSITIVEACCEL", "NEGATIVEACCEL"))
            moved[0].go(values["POSITION"], *limits)
        return 0

    def _command(self, line: int, found: str, expected: str) -> None:
        self.say(rules.COMMAND, line, found=found, expected=expected)

    def say(self, rule: Rule, line: int | None, **values: object) -> None:
        """Add a message, unless there are many of the kind already."""
        add_few(self.diagnostics, rule.at(Source(self.name, line), **values))

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

    def _homing(self, axis: Axis, values: dict[str, Any], line: int) -> int:
        if values["HOMINGMODE"] != "DIRECT_HOMING" or values["HOMEPOSITIONTYPE"] != "DIRECT":
            self._command(line, f"{values['HOMINGMODE']}", "DIRECT_HOMING to a DIRECT position")
            return REFUSED
        if abs(axis.velocity) > 1e-6:
            self._command(line, f"homing of {axis.name} while it moves", "it at rest")
        axis.home(values["HOMEPOSITION"])
        return 0

    def _path(self, name: str, values: dict[str, Any], line: int) -> int:
        assert self.path is not None  # names that are not declared were reported before
        here = (self.axes[0].position, self.axes[1].position)
        points = [here, (values["X"], values["Y"])]
        if values["PATHPLANE"] != "X_Y" or values["PATHMODE"] != "ABSOLUTE":
            self._command(line, "another plane or mode", "X_Y and ABSOLUTE")
        if name == "_MOVEPATHCIRCULAR":
            if values["IJKMODE"] != "ABSOLUTE":
                self._command(line, "a relative middle", "ijkMode ABSOLUTE")
            if values["CIRCULARTYPE"] != "OVER_POSITION_TO_ENDPOSITION":
                self._command(line, str(values["CIRCULARTYPE"]), "OVER_POSITION_TO_ENDPOSITION")
            points = circle_points(here, (values["I"], values["J"]), points[1])
            if not points:
                return REFUSED
        self.path.go(points, values["VELOCITY"], values["POSITIVEACCEL"], values["NEGATIVEACCEL"])
        return 0

    # -- time -------------------------------------------------------------------------------

    def cycle(self) -> None:
        """One scan of the program, and what the axes do until the next. Raises VerifyError."""
        x, y, *z = self.axes
        low_and_high = [
            at for place, end in zip(self.head(), self.ends, strict=True)
            for at in (place <= 0.0, place >= end)
        ]  # fmt: skip
        limits = [
            (at or k in self.closed) and k not in self.loose for k, at in enumerate(low_and_high)
        ]
        actuated = (*limits[:4], self.start, self.acknowledge, self.stop, *limits[4:])
        for k, ((name, closed), value) in enumerate(zip(self._read, actuated, strict=True)):
            self.interpreter.globals[name] = value != closed and k not in self.broken
        self.interpreter.run("CutPart")
        self.observe()
        step = self.triggers.cycle_s / SAMPLES
        for _ in range(SAMPLES):
            if self.path is not None:
                self.path.advance(step)
            for axis in self.axes:
                axis.advance(step)
            here = (x.position, y.position)
            for process in PROCESSES:
                if self.tool(process):
                    self.points.setdefault(process, []).append(here)
                    self.heights.setdefault(process, []).extend(axis.position for axis in z)
        self.clock_s += self.triggers.cycle_s

    def observe(self) -> None:
        """Called behind every scan, before the axes move."""

    def _variable(self, place: str, otherwise: str) -> str:
        """The variable of an input or output, by its address or by its name."""
        if not place:
            return otherwise.upper()
        return self.interpreter.addresses[place.upper()] if is_address(place) else place.upper()

    def head(self) -> tuple[float, ...]:
        """Where the switches see the axes."""
        return tuple(axis.place for axis in self.axes)

    def tool(self, process: str) -> bool:
        """Whether the output of a process is on."""
        return bool(self.interpreter.globals[self._tools[process]])

    @property
    def tool_on(self) -> bool:
        return any(map(self.tool, PROCESSES))

    @property
    def still(self) -> bool:
        """Whether no axis moves."""
        return all(axis.still for axis in self.axes) and (self.path is None or self.path.still)

    def value(self, name: str) -> Any:
        """The value of a global variable."""
        return self.interpreter.globals[name.upper()]
