"""Step tables: the times at which each motor advances by one word of its sequence.

plan -> ways -> planned motion -> steps of each axis (step_events) -> rows of words
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
from beamcam.motion.step_events import MICROSECONDS, MOVE_BITS, MOVES, TIME_BIT, events
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

        `x` and `y` are events as `step_events` gives them.
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
