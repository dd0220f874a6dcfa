"""Function blocks of PLCopen Motion Control, part 1, with simulated axes behind them.

What Execute starts goes on when Execute falls; another command of the axis aborts it. Done, Error
and CommandAborted stay as long as Execute, or are shown for one call. An axis whose drive
drops out while MC_Power is called with Enable is in the state ErrorStop.
"""

from abc import abstractmethod
from collections.abc import Callable
from functools import partial
from typing import Any

from beamcam.controllers.simotion import rules
from beamcam.controllers.simotion.axes import Axis
from beamcam.controllers.simotion.interpreter import Native, Values, World

COMMANDED_POSITION = 1  #: number of that parameter


def motion_blocks(table: World) -> dict[str, Callable[[], Native]]:
    """The blocks of a table, by their names in capitals."""
    kinds: tuple[type[_Block], ...] = (
        _Power, _Move, _Halt, _SetPosition, _Stop, _Reset, _Status, _Position, _Parameter,
    )  # fmt: skip
    return {kind.name: partial(kind, table) for kind in kinds}


def start(table: World, name: str, values: Values) -> bool:
    """Start what a block asks of its axis; False if the axis refuses it."""
    axis: Axis = values["AXIS"]
    if name == _Reset.name:
        return axis.reset() == 0
    if axis.error or not axis.enabled or (axis.held_by is not None and name != _Stop.name):
        return False
    if name in (_Stop.name, _Halt.name):
        axis.stop()
    elif name == _SetPosition.name:
        if not axis.still:
            found = f"{name} of {axis.name} while it moves"
            table.say(rules.COMMAND, None, found=found, expected="it at rest")
        axis.home(values["POSITION"])
    else:
        limits = [values[key] for key in ("VELOCITY", "ACCELERATION", "DECELERATION")]
        if min(limits) <= 0.0:
            found = f"{name} with {min(limits):g}"
            table.say(rules.COMMAND, None, found=found, expected="more than 0")
            return False
        axis.go(values["POSITION"], *limits)
    return True


class _Block(Native):
    name = ""
    outputs: tuple[str, ...] = ("ERROR",)

    def __init__(self, table: World) -> None:
        self.table = table
        self.values: Values = dict.fromkeys(self.outputs, False)
        self.inputs: Values = {"ENABLE": False, "EXECUTE": False}

    @property
    def axis(self) -> Axis:
        axis: Axis = self.inputs["AXIS"]
        return axis

    def run(self, inputs: Values) -> None:
        self.inputs.update(inputs)
        self.call()

    @abstractmethod
    def call(self) -> None:
        """What a call does."""


class _Power(_Block):
    name = "MC_POWER"
    outputs = ("STATUS", "ERROR")
    was_on = False

    def call(self) -> None:
        axis, enable = self.axis, self.inputs["ENABLE"]
        if not enable:
            axis.enabled = False
        elif self.was_on and not axis.enabled:
            axis.error = True
        elif not axis.enabled and not axis.error:
            axis.enable()
        self.was_on = axis.enabled
        self.values["STATUS"] = axis.enabled and not axis.error


class _Command(_Block):
    """A block that is started by the edge of Execute."""

    outputs = ("DONE", "BUSY", "COMMANDABORTED", "ERROR")
    before = False

    def call(self) -> None:
        axis, execute = self.axis, self.inputs["EXECUTE"]
        rises = execute and not self.before
        if rises or not execute:
            self.values.update(DONE=False, COMMANDABORTED=False, ERROR=False)
        self.before = execute
        if rises:
            refused = self.table.command(self.name, dict(self.inputs), 0)
            self.values.update(BUSY=not refused, ERROR=bool(refused))
            if not refused:
                axis.commanded_by = self
        elif self.values["BUSY"]:
            self._follow(axis)

    def _follow(self, axis: Axis) -> None:
        if axis.commanded_by is not self:
            self.values.update(BUSY=False, COMMANDABORTED=True)
        elif axis.error or not axis.enabled:
            self.values.update(BUSY=False, ERROR=True)
        elif self.arrived(axis):
            self.values.update(BUSY=False, DONE=True)

    def arrived(self, axis: Axis) -> bool:
        """Whether the axis has done it."""
        return axis.still


class _Move(_Command):
    name = "MC_MOVEABSOLUTE"

    def call(self) -> None:
        self.inputs = {"VELOCITY": 0.0, "ACCELERATION": 0.0, "DECELERATION": 0.0} | self.inputs
        super().call()

    def arrived(self, axis: Axis) -> bool:
        return axis.still and abs(axis.position - self.inputs["POSITION"]) < 1e-9


class _Halt(_Command):
    name = "MC_HALT"


class _SetPosition(_Command):
    name = "MC_SETPOSITION"

    def arrived(self, axis: Axis) -> bool:
        return True


class _Stop(_Command):
    name = "MC_STOP"

    def call(self) -> None:
        super().call()
        axis = self.axis
        if not self.inputs["EXECUTE"] and axis.held_by is self:
            axis.held_by = None
        elif self.values["BUSY"] or self.values["DONE"]:
            axis.held_by = self


class _Reset(_Command):
    name = "MC_RESET"

    def _follow(self, axis: Axis) -> None:
        self.values.update(BUSY=axis.error, DONE=not axis.error)


class _Status(_Block):
    name = "MC_READSTATUS"
    outputs = (
        "VALID", "BUSY", "ERROR", "ERRORSTOP", "DISABLED", "STOPPING", "HOMING", "STANDSTILL",
        "DISCRETEMOTION",
    )  # fmt: skip

    def call(self) -> None:
        axis, command = self.axis, self.axis.commanded_by
        busy = command is not None and command.values["BUSY"]
        state = "STANDSTILL"
        if axis.error:
            state = "ERRORSTOP"
        elif not axis.enabled:
            state = "DISABLED"
        elif axis.held_by is not None:
            state = "STOPPING"
        elif busy or not axis.still:
            state = "DISCRETEMOTION"
        self.values = dict.fromkeys(self.outputs, False)
        self.values.update({"VALID": self.inputs["ENABLE"], state: True})


class _Position(_Block):
    name = "MC_READACTUALPOSITION"
    outputs = ("VALID", "BUSY", "ERROR")

    def __init__(self, table: World) -> None:
        super().__init__(table)
        self.values[self.value] = 0.0

    value = "POSITION"

    def call(self) -> None:
        self.values.update({"VALID": self.inputs["ENABLE"], self.value: self.read(self.axis)})

    def read(self, axis: Axis) -> Any:
        return axis.actual


class _Parameter(_Position):
    name = "MC_READPARAMETER"
    value = "VALUE"

    def read(self, axis: Axis) -> Any:
        known = self.inputs["PARAMETERNUMBER"] == COMMANDED_POSITION
        self.values["ERROR"] = not known
        return axis.position if known else 0.0
