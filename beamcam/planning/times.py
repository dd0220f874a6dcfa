"""How long the work takes, from the speeds of the machine's file.

Each operation waits for the slower of the bar (X) and the spindle's place across, then for its
spindle and tool, then strokes: rapid to near the surface, feed to the bottom, rapid back. A cut
waits for the saw to turn, feeds through the section and goes back. Every move is run up and braked
by the axis that makes it, with its acceleration and, where the file gives it, its jerk.

Where the operator goes meanwhile is not in it.
"""

from collections.abc import Sequence
from math import cos, inf, radians

from msgspec import Struct

from beamcam.geometry.moves import move_seconds
from beamcam.machine.cutting import speed_and_feed
from beamcam.machine.machine import Machine, Times, Tool
from beamcam.model.part import Profile
from beamcam.model.plan import Operation, PathOp, Plan, SawOp, SpindleOp
from beamcam.model.stroke import Strokes
from beamcam.model.work_time import WorkTime
from beamcam.planning.magazine import tool_loads
from beamcam.planning.paths import straight_runs

SECONDS_PER_MINUTE = 60.0
UNKNOWN_MM_S2 = 1000.0  #: of an axis that the machine's file does not have


class AxisSpeed(Struct, frozen=True):
    """How fast an axis moves, mm/s, mm/s2 and mm/s3."""

    speed_mm_s: float
    acceleration_mm_s2: float
    jerk_mm_s3: float = inf

    def seconds(self, distance: float, greatest_mm_s: float = inf) -> float:
        """Time from rest to rest over a distance, at most at a speed."""
        speed = min(self.speed_mm_s, greatest_mm_s)
        return move_seconds(distance, speed, self.acceleration_mm_s2, self.jerk_mm_s3)

    def with_other(self, other: "AxisSpeed") -> "AxisSpeed":
        """What two axes can do together, whichever way the path runs."""
        return AxisSpeed(
            min(self.speed_mm_s, other.speed_mm_s),
            min(self.acceleration_mm_s2, other.acceleration_mm_s2),
            min(self.jerk_mm_s3, other.jerk_mm_s3),
        )


def work_time(plan: Plan, machine: Machine) -> WorkTime:
    """How long the work of a plan takes on its machine."""
    grades = tuple(piece.part.grade for piece in plan.pieces)
    return time_of(plan.operations, plan.profile, grades, machine)


def time_of(
    operations: Sequence[Operation], profile: Profile, grades: Sequence[str], machine: Machine
) -> WorkTime:
    """How long operations take; `grades` are the steels of the pieces."""
    clock = _Clock(profile, grades, machine)
    seconds = tuple(clock.seconds(op) for op in operations)
    reloads = sum(load.out is not None for load in tool_loads(operations, machine))
    return WorkTime(seconds, reloads * machine.times.reload_s)


class _Clock:
    """The machine as it stands while the operations go by."""

    def __init__(self, profile: Profile, grades: Sequence[str], machine: Machine) -> None:
        if machine.saw is None or machine.drill is None:
            raise TypeError(f"{machine.name} has no saw and drill")
        self._saw, self._drill = machine.saw, machine.drill
        self._times: Times = machine.times
        self._profile, self._grades = profile, grades
        self._strokes = Strokes(profile, machine)
        rapid = machine.drill.greatest_feed_mm_min / SECONDS_PER_MINUTE
        self._rapid = AxisSpeed(rapid, UNKNOWN_MM_S2)
        self._axes: dict[tuple[str, int | None], AxisSpeed] = {
            (a.moves, a.spindle): AxisSpeed(a.speed, a.acceleration, a.jerk or inf)
            for a in machine.axes
        }
        self._x = 0.0
        self._angle = machine.saw.square
        self._tilt = 0.0
        self._spindle: int | None = None
        self._tools: dict[str, Tool] = {}
        self._across: dict[str, float] = {}
        self._last_s = 0.0

    def _axis(self, moves: str, spindle: int | None = None) -> AxisSpeed:
        return self._axes.get((moves, spindle), self._rapid)

    def seconds(self, op: Operation) -> float:
        travel = self._axis("X").seconds(op.x - self._x)
        if isinstance(op, SawOp):
            seconds = self._saw_seconds(op, travel)
        else:
            other_spindle = op.spindle != self._spindle
            seconds = self._spindle_seconds(op, travel)
            if self._times.together and other_spindle and op.x == self._x:
                # It runs while the operation before it does, so only what is longer counts.
                seconds, self._last_s = max(0.0, seconds - self._last_s), max(seconds, self._last_s)
            else:
                self._last_s = seconds
        self._x = op.path[-1][0] if isinstance(op, PathOp) else op.x
        return seconds

    def _saw_seconds(self, op: SawOp, travel: float) -> float:
        turning = self._axis("angle").seconds(op.angle - self._angle)
        turning += self._axis("angle").seconds(op.tilt - self._tilt)
        self._angle, self._tilt, self._last_s = op.angle, op.tilt, 0.0
        stroke = self._profile.width / cos(radians(op.tilt)) + 2 * self._drill.clearance
        blade = self._axis("saw")
        down = blade.seconds(stroke, self._saw.feed_mm_min / SECONDS_PER_MINUTE)
        return max(travel, turning) + self._times.saw_s + down + blade.seconds(stroke)

    def _spindle_seconds(self, op: SpindleOp, travel: float) -> float:
        first = self._strokes.spindle(op)
        across, along = self._strokes.axes(op)
        stroke = self._strokes(op, op.y)
        aside = stroke.across - self._across.get(first.face, 0.0)
        waiting = max(travel, self._axis(across, first.number).seconds(aside))
        if any(self._tools.get(face, op.tool) != op.tool for face in op.faces):
            waiting += self._times.tool_change_s
        if self._spindle is not None and op.spindle != self._spindle:
            waiting += self._times.spindle_change_s
        self._spindle = op.spindle
        for face in op.faces:
            self._tools[face] = op.tool
            self._across[face] = stroke.across
        _, feed_mm_min = speed_and_feed(op.tool, self._drill, self._grades[op.features[0][0]])
        feed = feed_mm_min / SECONDS_PER_MINUTE
        stroking = self._axis(along, first.number)
        fed = stroking.seconds(stroke.bottom - stroke.near, feed)
        if op.tool.kind == "tap":
            fed *= 2
        if isinstance(op, PathOp):
            table = self._axis("X").with_other(self._axis(across, first.number))
            fed += sum(table.seconds(run, feed) for run in straight_runs(op.path))
            self._across[first.face] = self._strokes(op, op.path[-1][1]).across
        back = stroke.near if op.tool.kind == "tap" else stroke.bottom
        moves = stroking.seconds(stroke.near - stroke.start)
        moves += stroking.seconds(back - stroke.start)
        turning = 0.0 if op.tool.kind in ("punch", "scribe") else self._times.spindle_s
        return waiting + turning + moves + fed
