"""Step tables: the times at which each motor advances by one word of its sequence.

plan -> ways -> planned motion -> steps of each axis -> rows of words
"""

from collections.abc import Iterator
from functools import partial
from itertools import pairwise
from math import ceil, dist, floor, hypot
from typing import Any

import numpy as np
from msgspec import Struct
from numpy.typing import NDArray

from beamcam.geometry.array_types import Counts, Floats
from beamcam.machine.machine import Machine
from beamcam.machine.tables import Stepper
from beamcam.model.plan import SheetPlan, WorkTime
from beamcam.model.program import LASER_BIT, StepRows, StepTable, VelocityRow
from beamcam.motion.densify import DensifyRules, densify
from beamcam.motion.lookahead import LookAheadRules, PlannedPath, plan_speeds
from beamcam.motion.sheet_times import by_operation
from beamcam.motion.velocity_profile import AxisLimits

HOME = (0.0, 0.0)
SAME_POINT = 1e-9  #: mm; there is no way to a place that is no farther
SECONDS_PER_MINUTE = 60.0


class Way(Struct, frozen=True):
    """Points that follow one another and are passed at one speed."""

    points: Floats
    speed_mm_s: float
    laser: bool
    wait_s: float


def ways(plan: SheetPlan, machine: Machine) -> list[Way]:
    """Traverses and contours in order; the first begins and the last ends in the corner."""
    torch = machine.needed(machine.torch, "stepping motors")
    stepper = machine.needed(machine.stepper, "stepping motors")
    rules = DensifyRules(torch.tolerance / 2)
    ways: list[Way] = []
    here = HOME
    for op in plan.operations:
        speed = op.row.feed_mm_min / SECONDS_PER_MINUTE
        for one in op.passes:
            path = densify((*one.lead_in, *one.curves, *one.lead_out), rules)
            start = (float(path.points[0, 0]), float(path.points[0, 1]))
            if dist(start, here) > SAME_POINT:
                ways.append(Way(np.array([here, start]), stepper.traverse_mm_s, False, 0.0))
            ways.append(Way(path.points, speed, True, op.row.pierce_s))
            here = (float(path.points[-1, 0]), float(path.points[-1, 1]))
    if dist(here, HOME) > SAME_POINT:
        ways.append(Way(np.array([here, HOME]), stepper.traverse_mm_s, False, 0.0))
    return ways


def segments(job: list[Way], step: float, max_mm_s: float) -> Iterator[VelocityRow]:
    """A row for each segment; the steps of all rows add up to the way from corner to corner.

    `max_mm_s` is what an axis can do; a segment that asks for more is slower.
    """
    count = [0, 0]
    for way in job:
        for (x0, y0), (x1, y1) in pairwise(way.points.tolist()):
            dx, dy = x1 - x0, y1 - y0
            length = hypot(dx, dy)
            speed = min(way.speed_mm_s, max_mm_s * length / max(abs(dx), abs(dy)))
            vx, vy = speed * dx / length, speed * dy / length
            ends = [floor(x1 / step + 0.5), floor(y1 / step + 0.5)]
            yield VelocityRow(
                x1, y1, vx, vy, way.laser, ends[0] - count[0], ends[1] - count[1],
                abs(vx) / step, abs(vy) / step,
            )  # fmt: skip
            count = ends


# An axis stands on a grid of steps, always on the place nearest to where the path is; so it steps
# when the path passes the middle between two places:
#
#         place   2 |           o---       A path that turns back just behind a middle would ask for
#                   |       o---|    \     two steps in no time. Both are left out: the path passes
#         middle  - | - - -/- - - - - \    the middle by less than can be seen.
#         place   1 |  o---|           o
#
# The way is cut at every corner, at every change of the motion, and into windows; on a piece
# between two cuts the middles follow each other at one distance. Where the speed is steady so do
# the times. Arrays hold a window at a time, so that memory does not grow with the table.

WINDOW_STEPS = 1 << 16  #: length of path processed at once
MICROSECONDS = 1e6
NEWTON_ROUNDS = 6
HAIR = 1e-9  #: a change of the motion this near behind a corner is at the corner
#: The last bits of an event: what it adds to the place of X, modulo 4, and to that of Y.
MOVE_BITS = 2
MOVES = (1 << 2 * MOVE_BITS) - 1
TIME_BIT = 2 * MOVE_BITS  #: above them is its time in microseconds
FORWARD, BACK = 1, 3


def events(path: PlannedPath, stepper: Stepper) -> Iterator[tuple[Counts, Counts]]:
    """Steps of X and of Y, window by window, in order of time.

    An event is a number: its time, and its move in the last bits, see `MOVES` and `TIME_BIT`.
    """
    clock = _Clock(path, WINDOW_STEPS * stepper.step)
    min_us = int(MICROSECONDS / stepper.max_hz)
    axes = [_Axis(clock, path.points[:, k], stepper.step, min_us, k * MOVE_BITS) for k in (0, 1)]
    last = len(clock.windows) - 2
    for k in range(last + 1):
        pieces = slice(clock.windows[k], clock.windows[k + 1])
        until_us = None if k == last else clock.reached_us(pieces.stop) - 2 * min_us
        x, y = (axis.steps(pieces, until_us) for axis in axes)
        yield x, y


class _Clock:
    """The pieces of a path, and when each position is passed.

    Piece k goes from `marks[k]` to `marks[k + 1]`, within phase `phase[k]` of the motion; window k
    begins with piece `windows[k]`.
    """

    def __init__(self, path: PlannedPath, window: float) -> None:
        self.begins = np.concatenate(([0.0], np.cumsum(path.lengths)))
        total, segment = self.begins[-1], path.phase_segment
        inside = np.where(path.phase_position < HAIR, 0.0, path.phase_position)
        self.starts = np.minimum(self.begins[segment] + inside, self.begins[segment + 1])
        edges = np.linspace(0.0, total, max(1, int(np.ceil(total / window))) + 1)
        edges[-1] = total
        marks = np.sort(np.concatenate((self.begins, self.starts, edges)))
        self.marks: Floats = marks[np.append(True, marks[1:] > marks[:-1])]
        self.phase: Counts = np.searchsorted(self.starts, self.marks[:-1], side="right") - 1
        self.windows: list[int] = np.searchsorted(self.marks, edges).tolist()
        self.lengths = np.append(self.starts[1:], total) - self.starts
        self.start_us = path.phase_start_s * MICROSECONDS
        self.lasts_s = path.phase_duration_s
        # Where the speed is steady; elsewhere how it rises, braking looked at backwards.
        v, a = path.phase_velocity, path.phase_acceleration
        j, d = path.phase_jerk, path.phase_duration_s
        self.steady = (np.abs(a) * d <= 1e-9 * v) & (np.abs(j) * d * d <= 1e-9 * v)
        self.pace_us = MICROSECONDS / np.where(self.steady, v, 1.0)  #: for a mm
        end_v, end_a = v + d * (a + d * j / 2), a + d * j
        self.backwards = ~self.steady & (end_v < v)
        self.v = np.maximum(0.0, np.where(self.backwards, end_v, v))
        self.a = np.maximum(0.0, np.where(self.backwards, -end_a, a))
        self.j = j

    def reached_us(self, mark: int) -> int:
        """When a mark behind the first is reached."""
        way, phase = self.marks[mark : mark + 1], self.phase[mark - 1 : mark]
        at = self.steady_us if self.steady[phase[0]] else self.ramp_us
        return int(at(way, phase)[0])

    def steady_us(self, way: Floats, phase: Counts) -> Floats:
        """Times within phases of steady speed."""
        return np.asarray(self.start_us[phase] + (way - self.starts[phase]) * self.pace_us[phase])

    def ramp_us(self, way: Floats, phase: Counts) -> Floats:
        """Times within phases of changing speed, by Newton's method from the far side."""
        back = self.backwards[phase]
        length, lasts = self.lengths[phase], self.lasts_s[phase]
        s = np.clip(way - self.starts[phase], 0.0, length)
        s = np.where(back, length - s, s)
        v, a, j = self.v[phase], self.a[phase], self.j[phase]
        with np.errstate(divide="ignore", invalid="ignore"):
            # Velocity, acceleration or jerk alone would take longer than all of them.
            far = np.fmin(s / v, np.sqrt(2 * s / a))
            far = np.where(j > 0.0, np.fmin(far, np.cbrt(6 * s / j)), s * lasts / length)
        t = np.fmin(far, lasts)
        t = np.where(np.isfinite(t), t, lasts)
        for _ in range(NEWTON_ROUNDS):
            speed = v + t * (a + t * j / 2)
            gone = t * (v + t * (a / 2 + t * j / 6))
            safe = speed > 0.0
            t = t - np.where(safe, (gone - s) / np.where(safe, speed, 1.0), 0.0)
            t = np.clip(t, 0.0, lasts)
        return np.asarray(self.start_us[phase] + np.where(back, lasts - t, t) * MICROSECONDS)


class _Axis:
    """The steps of one axis."""

    def __init__(self, clock: _Clock, at: Floats, step: float, min_us: int, bit: int) -> None:
        self.clock, self.at = clock, np.ascontiguousarray(at)
        self.forward, self.back = FORWARD << bit, BACK << bit
        self.step, self.min_us = step, min_us
        self.held: Counts = np.zeros(0, dtype=np.int64)
        self.count = np.zeros(0)  #: 0, 1, 2 ...

    def steps(self, pieces: slice, until_us: int | None) -> Counts:
        """The steps of some pieces, and those that were held back before.

        Steps behind `until_us` are held back, as their counterparts may come in the next window.
        """
        steps, turns = self._passed(pieces)
        if len(self.held):
            turns = np.concatenate(([len(self.held) - 1], turns + len(self.held)))
            steps = np.concatenate((self.held, steps))
        steps = self._without_turns(steps, turns)
        kept = len(steps) if until_us is None else int(np.searchsorted(steps, until_us << TIME_BIT))
        self.held = steps[kept:]
        return steps[:kept]

    def _passed(self, pieces: slice) -> tuple[Counts, Counts]:
        """When middles between places are passed; and the last step before each way back."""
        clock, step = self.clock, self.step
        marks = clock.marks[pieces.start : pieces.stop + 1]
        x = np.interp(marks, clock.begins, self.at)
        places = np.floor(x / step + 0.5).astype(np.int64)
        moves = places[1:] - places[:-1]
        which = np.flatnonzero(moves)
        begins, ends = which, which + 1
        sign, counts = np.sign(moves[which]), np.abs(moves[which])
        # The k-th middle lies at (places + sign (k + 1/2)) step; k counts on over all pieces.
        pitch = step * (marks[ends] - marks[begins]) / np.abs(x[ends] - x[begins])
        first = marks[begins] + (places[begins] + 0.5 * sign - x[begins] / step) * sign * pitch
        before = np.cumsum(counts) - counts
        phase = clock.phase[pieces][which]
        pace = pitch * clock.pace_us[phase]
        begin = clock.steady_us(first, phase)
        times = np.repeat(pace, counts)
        if len(times) > len(self.count):
            self.count = np.arange(len(times), dtype=np.float64)
        times *= self.count[: len(times)]
        times += np.repeat(begin - before * pace + 0.5, counts)  # a half, to be rounded
        ramps = ~clock.steady[phase]
        if ramps.any():
            k = np.flatnonzero(np.repeat(ramps, counts))
            of = np.repeat(np.flatnonzero(ramps), counts[ramps])
            way = first[of] + (k - before[of]) * pitch[of]
            times[k] = clock.ramp_us(way, phase[of]) + 0.5
        steps = times.astype(np.int64)
        steps <<= TIME_BIT
        steps |= np.repeat(np.where(sign > 0, self.forward, self.back), counts)
        return steps, before[1:][sign[1:] != sign[:-1]] - 1

    def _without_turns(self, steps: Counts, turns: Counts) -> Counts:
        """Without pairs of steps forth and back that come too near to each other.

        `turns` are all places where the next step may be a step back.
        """
        while True:
            turns = turns[turns < len(steps) - 1]
            back = (steps[turns] ^ steps[turns + 1]) & MOVES != 0
            apart_us = (steps[turns + 1] >> TIME_BIT) - (steps[turns] >> TIME_BIT)
            pairs = turns[back & (apart_us < self.min_us)]
            if not len(pairs):
                return steps
            # Of pairs that share a step only the first goes in this round.
            chosen = pairs[np.append(True, np.diff(pairs) > 1)]
            kept = np.ones(len(steps), dtype=bool)
            kept[chosen] = kept[chosen + 1] = False
            steps = steps[kept]
            turns = np.flatnonzero((steps[1:] ^ steps[:-1]) & MOVES)


#: A step is timed to a microsecond, so that two may come nearer by one than they should.
TIMING_S = 1.1e-6
#: Where the places of Y are added up: a window has less than 2 ** 18 moves of at most 3.
Y_PLACE = 20
FEW = 64


def step_table(plan: SheetPlan, machine: Machine, job: str) -> StepTable:
    """The table that carries out a plan. Raises ValueError where the machine has no speed."""
    stepper = machine.needed(machine.stepper, "stepping motors")
    paths = ways(plan, machine)
    planned: list[PlannedPath] = []  # with the first run through the rows
    return StepTable(
        job, stepper.step, stepper.sequence, partial(step_rows, paths, stepper, planned),
        partial(segments, paths, stepper.step, max_speed(stepper)),
    )  # fmt: skip


def max_speed(stepper: Stepper) -> float:
    """Speed of an axis in mm/s at which no two steps come nearer than its frequency allows."""
    return stepper.step / (1.0 / stepper.max_hz + TIMING_S)


def plan_way(way: Way, stepper: Stepper) -> PlannedPath:
    """The motion along a path, from rest to rest."""
    axis = AxisLimits(max_speed(stepper), stepper.acceleration, stepper.jerk)
    return plan_speeds(way.points, way.speed_mm_s, LookAheadRules((axis, axis), stepper.corner))


def step_rows(
    job: list[Way], stepper: Stepper, planned: list[PlannedPath] | None = None
) -> Iterator[StepRows]:
    """The rows of a job: the first stands at time 0, with both axes at place 0 and the laser off.

    Between two ways is a rest that is longer than the least time between two steps. `planned`
    takes the motion along each way, for a second run.
    """
    paths = [] if planned is None else planned
    words = _Words(stepper)
    clock_us = 0
    rest_us = int(2 * MICROSECONDS / stepper.max_hz) + 1
    yield words.row(0, False)
    for k, way in enumerate(job):
        if way.laser:
            yield words.row(clock_us, True)
            clock_us += round(way.wait_s * MICROSECONDS)
        clock_us += rest_us
        if k == len(paths):
            paths.append(plan_way(way, stepper))
        path = paths[k]
        for x, y in events(path, stepper):
            yield words.rows(x, y, clock_us, way.laser)
        clock_us += int(np.ceil(path.duration_s * MICROSECONDS)) + rest_us
        if way.laser:
            yield words.row(clock_us, False)


class _Words:
    """The words that were sent last, and the rows that follow from steps."""

    def __init__(self, stepper: Stepper) -> None:
        self.x = self.y = 0  #: places, modulo 4
        forward = [int(word, 2) for word in stepper.sequence]
        back = [forward[0], *forward[:0:-1]]
        x = back if "X" in stepper.reversed_axes else forward
        y = back if "Y" in stepper.reversed_axes else forward
        places = np.arange(16)
        #: Bits of a pair of places: x + 4 y.
        self.table = (np.take(x, places & 3) | np.take(y, places >> 2) << 2).astype(np.uint8)
        self.plain = bool((self.table == places).all())  #: a place is its word
        self.table_on = self.table | np.uint8(1 << LASER_BIT)

    def row(self, time_us: int, laser: bool) -> StepRows:
        """A row without a step."""
        bits = self.table[self.x + 4 * self.y] | (laser << LASER_BIT)
        return StepRows(np.array([time_us]), np.array([bits], dtype=np.uint8))

    def rows(self, x: Counts, y: Counts, clock_us: int, laser: bool) -> StepRows:
        """Rows for the steps of both axes; steps of one microsecond share one.

        `x` and `y` are events as `events` gives them.
        """
        events = np.concatenate((x, y))
        events.sort(kind="stable")  # two sorted runs: they are merged
        bits = self._bits(events.astype(np.uint32), laser)
        events >>= TIME_BIT
        together = np.flatnonzero(events[1:] == events[:-1])
        if len(together):
            events, bits = _without(events, together), _without(bits, together)
        events += clock_us
        return StepRows(events, bits)

    def _bits(self, moves: NDArray[np.uint32], laser: bool) -> NDArray[np.uint8]:
        """The words behind each of some moves, which are the last bits of events."""
        if not len(moves):
            return np.zeros(0, dtype=np.uint8)
        # Both moves in one number, far from each other, so that one sum gives both places.
        moves &= np.uint32(MOVES)
        moves *= np.uint32(1 << (Y_PLACE - MOVE_BITS) | 1)
        moves &= np.uint32(3 << Y_PLACE | 3)
        moves[0] += np.uint32(self.x | self.y << Y_PLACE)
        places = np.cumsum(moves, dtype=np.uint32)
        low = places.astype(np.uint8)
        low &= 3
        places >>= np.uint32(Y_PLACE - MOVE_BITS)
        high = places.astype(np.uint8)
        high &= 12
        low |= high
        self.x, self.y = int(low[-1]) & 3, int(low[-1]) >> 2
        if self.plain:
            return low | np.uint8(laser << LASER_BIT)
        bits: NDArray[np.uint8] = (self.table_on if laser else self.table).take(low)
        return bits


def _without(values: NDArray[Any], which: Counts) -> NDArray[Any]:
    """`values` without those at `which`, copied by the runs between them, which is faster."""
    if len(which) > FEW:
        return np.delete(values, which)
    first, *more = np.split(values, which)
    return np.concatenate([first, *(run[1:] for run in more)])


def step_time(plan: SheetPlan, machine: Machine) -> WorkTime:
    """Run time of a step table: until its last step, and the standstill after it.

    Each way is planned by the look-ahead, from rest to rest, as for the rows themselves.
    """
    stepper = machine.needed(machine.stepper, "stepping motors")
    rest_us = int(2 * MICROSECONDS / stepper.max_hz) + 1
    passes_us = [0]
    for way in ways(plan, machine):
        waits = round(way.wait_s * MICROSECONDS) if way.laser else 0
        moves = ceil(plan_way(way, stepper).duration_s * MICROSECONDS)
        passes_us[-1] += waits + moves + 2 * rest_us
        if way.laser:
            passes_us.append(0)
    return by_operation(plan, (one / MICROSECONDS for one in passes_us))
