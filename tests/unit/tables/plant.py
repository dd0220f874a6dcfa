"""A cutting table whose parts fail: encoders jitter, drives drop out, switches stick.

What is wrong begins in a cycle of the script and is looked at in every cycle.
"""

from collections.abc import Callable, Mapping
from functools import cache
from io import BytesIO
from itertools import product
from math import exp
from pickle import Pickler, Unpickler
from typing import Any

import pytest
from msgspec.structs import replace

from beamcam.controllers.simotion.axes import Axis
from beamcam.controllers.simotion.cutting_table import CuttingTable
from beamcam.controllers.simotion.syntax import Unit
from beamcam.controllers.simotion.trial import check, parsed, project_objects
from beamcam.emitters import simotion
from beamcam.machine.machine import Machine
from beamcam.machine.tables import HeightAxis
from beamcam.model.program import ArcTravel, LiftTorch, SwitchTool, Travel, TriggerOp, TriggerTable

from .shop import plain_machine, table_machine

WAITS, HOMING, WORK, DONE, FAULT = range(5)
STOPPED_S = 0.5  #: a stop takes at most this
STYLES = ("chain", "table")
#: What moves the axes: commands of SIMOTION to each, its path objects, or blocks of PLCopen.
KINDS = ("axes", "paths", "blocks")
LIFTED = ("axes z", "paths z", "blocks z")  #: the same, with a third axis that lifts the torch
MOVES, STOPS = ("_POS", "MC_MOVEABSOLUTE"), ("_STOP", "MC_STOP")  #: commands of an axis

WAYS = tuple(product(STYLES, (*KINDS, *LIFTED)))

each_kind = pytest.mark.parametrize("kind", ["axes", "blocks"])
each_lifted = pytest.mark.parametrize("kind", LIFTED)
each_way = pytest.mark.parametrize(("style", "kind"), WAYS)

#: Of the small table that lifts its torch, and of its job: mm, mm/s.
HOME_HEIGHT, CLEARANCE, PIERCE, CUT, THICKNESS, LIFT_SPEED = 20.0, 8.0, 4.0, 1.5, 2.0, 15.0

Deed = Callable[["Plant"], None]


@cache
def small_machine(kind: str = "axes") -> Machine:
    """A small table that homes soon."""
    changes: dict[str, Any] = {
        "back_off": 5.0, "overrun": 5.0, "max_homing_s": 15.0, "max_late_s": 0.5,
    }  # fmt: skip
    if kind in LIFTED:
        limits = ("%IX1.0", "%IX1.1") if kind == "blocks z" else ("%I1.0", "%I1.1")
        z = HeightAxis("AxisZ", limits, HOME_HEIGHT, CLEARANCE, LIFT_SPEED, back_off=3.0)
        closed = plain_machine() if kind == "blocks z" else table_machine()
        assert closed.triggers is not None
        changes |= {"z": z, "normally_closed": (*closed.triggers.normally_closed, *limits)}
    if kind.startswith("blocks"):
        machine = plain_machine(**changes)
    else:
        machine = table_machine(path_objects=kind.startswith("paths"), **changes)
    assert machine.torch is not None
    return replace(machine, torch=replace(machine.torch, length=40.0, width=40.0))


def small_job(kind: str = "axes") -> TriggerTable:
    """A triangle to cut, or with path objects one with a round corner, and a line to mark."""
    round_ = ArcTravel(9, 8, 8, 3.5, 8.0) if kind.startswith("paths") else Travel(9, 8, 8.0)
    work: tuple[TriggerOp, ...] = (
        Travel(2, 2, 20.0), LiftTorch(PIERCE, LIFT_SPEED), SwitchTool("cut", True, 0.2),
        LiftTorch(CUT, LIFT_SPEED), Travel(6, 2, 8.0), round_, Travel(2, 2, 8.0),
        SwitchTool("cut", False),
        LiftTorch(CLEARANCE, LIFT_SPEED), Travel(10, 4, 20.0), LiftTorch(CUT, LIFT_SPEED),
        SwitchTool("mark", True, 0.1), Travel(10, 9, 20.0), SwitchTool("mark", False),
        LiftTorch(CLEARANCE, LIFT_SPEED), Travel(0, 0, 20.0),
    )  # fmt: skip
    if kind not in LIFTED:
        return TriggerTable("small", tuple(op for op in work if not isinstance(op, LiftTorch)))
    down, up = LiftTorch(CLEARANCE, LIFT_SPEED), LiftTorch(HOME_HEIGHT - THICKNESS, LIFT_SPEED)
    return TriggerTable("small", (down, *work, up), thickness=THICKNESS)


@cache
def loaded(style: str = "chain", kind: str = "axes") -> tuple[Unit, ...]:
    """The units of the small job."""
    machine = small_machine(kind)
    return units_of(simotion.emit(small_job(kind), machine, style), machine)


def plant(style: str = "chain", kind: str = "axes", **more: Any) -> "Plant":
    """A small table with the small job."""
    return Plant(loaded(style, kind), small_machine(kind), **more)


def cutting(one: "Plant") -> "Plant":
    """The same plant, homed and cutting its first line."""
    one.press_start()
    while not one.tool_on or one.still:
        one.cycle()
    return one


def units_of(text: str, machine: Machine) -> tuple[Unit, ...]:
    """The units of a program, which nothing is wrong with."""
    units, said = parsed(text, machine, "a.st")
    said = said or check(units, project_objects(machine), "a.st")
    assert said == []
    return tuple(units)


class Plant(CuttingTable):
    """A table that does what the script says, by the number of the cycle."""

    def __init__(
        self,
        units: tuple[Unit, ...],
        machine: Machine,
        script: Mapping[int, Deed] | None = None,
        jitter: Callable[[], int] = lambda: 0,
    ) -> None:
        super().__init__(units, machine, "a.st")
        self.script, self.jitter = dict(script or {}), jitter
        self.count = 0
        self.frozen: dict[str, float] = {}  #: axes whose encoder tells one place for good
        self.astray: dict[str, float] = {}  #: axes whose encoder is out by so much
        self.creeps: dict[str, float] = {}  #: axes that drift from their set positions, mm/s
        self.trails_s = 0.0  #: time constant of the position controllers
        self.trail = [0.0] * len(self.axes)  #: mm behind the set positions
        self.speeds = [0.0] * len(self.axes)  #: of the set positions, since the last cycle
        self.may_trail = [0.0] * len(self.axes)  #: mm, by the lag and the speeds up to now
        self.commanded = 0  #: cycle of the last command to move
        self._places = [axis.place for axis in self.axes]
        self.homed_anew = False
        self.met: set[int] = set()  #: axes that ran against their switches in this homing
        self.sheet = (THICKNESS, PIERCE, CUT)  #: and the heights of the torch over it
        self.late = False  #: whether an axis takes up a command a cycle later
        self.taken: list[tuple[str, dict[str, Any], int]] = []
        self.states = [WAITS]
        self.pressed = self.acknowledged = False
        self._start_before = self._acknowledge_before = True

    def cycle(self) -> None:
        assert self.machine.triggers is not None
        deed = self.script.get(self.count)
        if deed is not None:
            deed(self)
        for k, (axis, pitch) in enumerate(zip(self.axes, self.triggers.counts(), strict=True)):
            self._follow(k, axis)
            at = axis.position - self.trail[k]
            told = (round(at / pitch) + self.jitter()) * pitch
            axis.lag = self.frozen.get(axis.name, told) - axis.position
            axis.lag += self.astray.get(axis.name, 0.0)
        if self.path is not None and any(not a.enabled or a.error for a in self.axes):
            self.path.stop()
        taken, self.taken = self.taken, []
        for name, values, line in taken:
            super().command(name, values, line)
        super().cycle()
        self.count += 1

    def _follow(self, index: int, axis: Axis) -> None:
        """Let an axis trail as a proportional controller of its position does, or creep away."""
        speed = (axis.place - self._places[index]) / self.triggers.cycle_s
        self._places[index] = axis.place
        lag_s = self.triggers.following_lag_s
        cycle_s = self.triggers.cycle_s
        left = (self.may_trail[index] + abs(speed) * cycle_s) * lag_s / (lag_s + cycle_s)
        self.speeds[index], self.may_trail[index] = abs(speed), max(left, abs(speed) * lag_s)
        if self.trails_s:
            stays = exp(-self.triggers.cycle_s / self.trails_s)
            trail = self.trail[index] * stays + speed * self.trails_s * (1 - stays)
            self.trail[index] = trail
        if axis.name in self.creeps:
            by = self.creeps[axis.name] * self.triggers.cycle_s
            self.astray[axis.name] = self.astray.get(axis.name, 0.0) + by

    def head(self) -> tuple[float, ...]:
        return tuple(axis.place - trail for axis, trail in zip(self.axes, self.trail, strict=True))

    def _state(self) -> dict[str, Any]:
        """What changes from cycle to cycle, besides the script."""
        fixed = ("machine", "triggers", "torch", "interpreter", "axes", "path", "objects", "script",
                 "jitter", "natives")  # fmt: skip
        return {key: value for key, value in self.__dict__.items() if key not in fixed}

    def keep(self) -> bytes:
        """A copy of everything at this moment; the points that were drawn are dropped."""
        self.points, self.heights = {}, {}
        programs = {key: one.values for key, one in self.interpreter._programs.items()}
        parts = [one.__dict__ for one in (*self.axes, *filter(None, [self.path]))]
        stream, kept = BytesIO(), self._kept()

        class Copier(Pickler):
            def persistent_id(self, one: object) -> int | None:
                return id(one) if id(one) in kept else None

        Copier(stream, -1).dump((self._state(), self.interpreter.globals, programs, parts))
        return stream.getvalue()

    def go_back(self, moment: bytes) -> None:
        """To the moment of a copy."""
        kept = self._kept()

        class Reader(Unpickler):
            def persistent_load(self, pid: int) -> object:
                return kept[pid]

        own, globals_, programs, parts = Reader(BytesIO(moment)).load()
        self.__dict__.update(own)
        self.interpreter.globals.update(globals_)
        for key, values in programs.items():
            self.interpreter._programs[key].values.update(values)
        for one, values in zip((*self.axes, *filter(None, [self.path])), parts, strict=True):
            one.__dict__.clear()
            one.__dict__.update(values)

    def _kept(self) -> dict[int, object]:
        """What a copy refers to and does not hold."""
        kept = (self, self.interpreter, *self.axes, *filter(None, [self.path]))
        return {id(one): one for one in kept}

    def command(self, name: str, values: dict[str, Any], line: int) -> int:
        if name in MOVES or name.startswith("_MOVEPATH"):
            self.commanded = self.count
        if self.late and name in MOVES:
            self.taken.append((name, values, line))
            return 0
        return super().command(name, values, line)

    def observe(self) -> None:
        """What holds in every cycle, whatever fails."""
        self.pressed = self.start and not self._start_before
        self.acknowledged = self.acknowledged or (
            self.acknowledge and not self._acknowledge_before and self.states[-1] == FAULT
        )
        self._start_before, self._acknowledge_before = self.start, self.acknowledge
        state = self.value("workState")
        if state != self.states[-1]:
            self.states.append(state)
            assert state != WORK or self.value("operation") == 0, "work in mid cut"
            everyone = set(range(len(self.axes)))
            assert state != WORK or self.met == everyone, "work without meeting the switches"
            assert state != HOMING or self.pressed, "homing without a press of start"
            assert (self.states[-2] != FAULT) or self.acknowledged, "a fault not acknowledged"
            self.acknowledged = False
        if state == HOMING:
            self.homed_anew = True
            self.met |= {k for k, axis in enumerate(self.axes) if self.at_switch(k, axis)}
        else:
            self.met = set()
        assert state == WORK or not self.tool_on, "a tool on out of work"
        assert state != WORK or self.homed_anew, "work without homing"
        if state in (DONE, FAULT, WAITS):
            self.homed_anew = False
        assert self.value("workFault") == (state == FAULT) == self.value("faultLamp")
        assert (self.value("faultNumber") != 0) == (state == FAULT)
        assert [self.tool(p) for p in ("cut", "mark", "engrave")].count(True) <= 1
        if self.triggers.z is not None:
            self._observe_heights(state)

    def at_switch(self, index: int, axis: Axis) -> bool:
        """Whether an axis is at the switch that its homing looks for: Z at its high one."""
        return axis.place >= self.ends[2] if index == 2 else axis.place <= 0.0

    def _observe_heights(self, state: int) -> None:
        """X and Y move at clearance, or with the tool on at its height; Z is homed before."""
        z, goes, own = self.axes[2], max(self.speeds[:2]) > 0.0, self.triggers.z
        assert own is not None
        thickness, pierce, cut = self.sheet
        over, near = z.position - thickness, self.triggers.in_position
        if state == HOMING and goes:
            assert 2 in self.met, "X and Y move before Z is homed"
            assert z.still
            assert abs(z.position - own.home_height) <= near
        if state == WORK and self.states[-2:] == [HOMING, WORK]:
            if self.tool_on:
                assert cut - 1e-6 <= over <= pierce + 1e-6, "the tool on at no height of its own"
                assert not goes or abs(over - cut) <= near, "a cut too high"
            elif goes:
                assert abs(over - own.clearance) <= near, "a way below clearance"

    def places(self) -> list[tuple[float, float]]:
        """Where the torch was on, to a hundredth."""
        return [(round(x, 2), round(y, 2)) for x, y in self.points["cut"]]

    # -- what an operator does ------------------------------------------------------------------

    def run_until(self, state: int, most_s: float = 60.0) -> None:
        """Go on until a state; it has to come in time."""
        self.run_while(lambda: self.value("workState") != state, most_s)

    def run_while(self, goes_on: Callable[[], bool], most_s: float = 60.0) -> None:
        """Go on as long as something holds; it has to end in time."""
        end = self.clock_s + most_s
        while goes_on():
            assert self.clock_s < end, f"state {self.value('workState')} for good"
            self.cycle()

    def wait(self, seconds: float) -> None:
        end = self.clock_s + seconds
        while self.clock_s < end:
            self.cycle()

    def press_start(self) -> None:
        self.start = False
        self.cycle()
        self.start = True
        self.cycle()

    def press_acknowledge(self) -> None:
        self.acknowledge = False
        self.cycle()
        self.acknowledge = True
        self.cycle()
