r"""Step events: when each motor has to turn by one word of its sequence.

An axis stands on a grid of steps, always on the place nearest to where the path is; so it steps
when the path passes the middle between two places:

        place   2 |           o---       A path that turns back just behind a middle would ask for
                  |       o---|    \     two steps in no time. Both are left out: the path passes
        middle  - | - - -/- - - - - \    the middle by less than can be seen.
        place   1 |  o---|           o

The middles are known along the way, and the look-ahead knows when each place of the way is passed.
All is done by arrays over windows of the way, so that memory does not grow with the table.
"""

from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

from beamcam.machine.machine import Machine
from beamcam.machine.tables import Stepper
from beamcam.model.plan import SheetPlan
from beamcam.model.steps import LASER_BIT, StepRows, StepTable
from beamcam.motion.lookahead import LookAheadRules, plan_speeds
from beamcam.motion.planned import PlannedPath
from beamcam.motion.profile import Limits
from beamcam.motion.velocity_table import Way, stretches, ways

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]

WINDOW_STEPS = 1 << 17  #: of the way that is worked on at once
MICROSECONDS = 1e6
#: A step is timed to a microsecond, so that two may come nearer by one than they should.
TIMING_S = 1.1e-6
NEWTON_ROUNDS = 6


def step_table(plan: SheetPlan, machine: Machine, job: str) -> StepTable:
    """The table that carries out a plan. Raises ValueError where the machine has no speed."""
    stepper = machine.stepper
    if stepper is None:
        raise TypeError(f"{machine.name} has no stepping motors")
    found = ways(plan, machine)
    return StepTable(
        job,
        stepper.step,
        stepper.sequence,
        lambda: step_rows(found, stepper),
        lambda: stretches(found, stepper.step, greatest_speed(stepper)),
    )


def greatest_speed(stepper: Stepper) -> float:
    """Speed of an axis in mm/s at which no two steps come nearer than its frequency allows."""
    return stepper.step / (1.0 / stepper.greatest_hz + TIMING_S)


def plan_way(way: Way, stepper: Stepper) -> PlannedPath:
    """The motion along a way, from rest to rest."""
    axis = Limits(greatest_speed(stepper), stepper.acceleration, stepper.jerk)
    return plan_speeds(way.points, way.speed_mm_s, LookAheadRules((axis, axis), stepper.corner))


def step_rows(job: list[Way], stepper: Stepper) -> Iterator[StepRows]:
    """The rows of a job: the first stands at time 0, with both axes at place 0 and the laser off.

    Between two ways is a rest that is longer than the least time between two steps.
    """
    words = _Words(stepper)
    clock_us = 0
    rest_us = int(2 * MICROSECONDS / stepper.greatest_hz) + 1
    yield words.row(0, False)
    for way in job:
        if way.laser:
            yield words.row(clock_us, True)
            clock_us += round(way.wait_s * MICROSECONDS)
        clock_us += rest_us
        path = plan_way(way, stepper)
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

    def rows(self, x: Ints, y: Ints, clock_us: int, laser: bool) -> StepRows:
        """Rows for the steps of both axes; steps of one microsecond share one.

        An event is 4 times its time in microseconds, and 1 more forwards; of Y another 2 more.
        """
        events = np.concatenate((x, y + 2))
        events.sort(kind="stable")  # two sorted runs: they are merged
        code = events.astype(np.uint8)
        code &= 3
        events >>= 2
        # Both places in one number: X in the low half, far from its ends, and Y in the high half.
        moves = _MOVES.take(code)
        if not len(moves):
            return StepRows(events, code)
        moves[0] += _MIDDLE + self.x + (self.y << _HALF)
        places = np.cumsum(moves, dtype=np.int64).astype(np.uint64)
        low = places.astype(np.uint8)
        low &= 3
        places >>= np.uint64(_HALF - 2)
        high = places.astype(np.uint8)
        high &= 12
        low |= high
        self.x, self.y = int(low[-1]) & 3, int(low[-1]) >> 2
        if self.plain:
            bits = low | np.uint8(laser << LASER_BIT)
        else:
            bits = (self.table_on if laser else self.table).take(low)
        together = events[1:] == events[:-1]
        if together.any():
            kept = np.append(~together, True)
            events, bits = events[kept], bits[kept]
        events += clock_us
        return StepRows(events, bits)


_HALF = 32
_MIDDLE = 1 << (_HALF - 1)
_MOVES = np.array([-1, 1, -1 << _HALF, 1 << _HALF], dtype=np.int64)


def events(path: PlannedPath, stepper: Stepper) -> Iterator[tuple[Ints, Ints]]:
    """Steps of X and of Y, window by window: 4 times the time in microseconds, 1 more forwards."""
    step = stepper.step
    begins = np.concatenate(([0.0], np.cumsum(path.lengths)))
    clock = _Clock(path, begins)
    total = float(begins[-1])
    least_us = int(MICROSECONDS / stepper.greatest_hz)
    axes = [_Axis(path, begins, k, step, least_us) for k in (0, 1)]
    count = max(1, int(np.ceil(total / (WINDOW_STEPS * step))))
    edges = np.linspace(0.0, total, count + 1)
    edges[-1] = total
    for a, b in zip(edges[:-1].tolist(), edges[1:].tolist(), strict=True):
        last = b == total
        until = (clock.at(np.array([b]))[0] * MICROSECONDS).astype(np.int64) - 2 * least_us
        x, y = (axis.window(a, b, clock, None if last else int(until)) for axis in axes)
        yield x, y


class _Clock:
    """When each place of the way is passed."""

    def __init__(self, path: PlannedPath, begins: Floats) -> None:
        self.path = path
        self.starts = begins[path.phase_segment] + path.phase_position
        self.lengths = np.append(self.starts[1:], begins[-1]) - self.starts
        v, a, j, d = (
            path.phase_velocity, path.phase_acceleration, path.phase_jerk, path.phase_duration_s,
        )  # fmt: skip
        self.steady = (np.abs(a) * d <= 1e-9 * v) & (np.abs(j) * d * d <= 1e-9 * v)
        with np.errstate(divide="ignore"):
            self.pace = np.where(self.steady, 1.0 / np.where(self.steady, v, 1.0), 0.0)
        # A phase that brakes is looked at backwards, where it is one that speeds up.
        end_v, end_a = v + d * (a + d * j / 2), a + d * j
        self.backwards = ~self.steady & (end_v < v)
        self.v = np.maximum(0.0, np.where(self.backwards, end_v, v))
        self.a = np.maximum(0.0, np.where(self.backwards, -end_a, a))
        self.j = j

    def at(self, way: Floats) -> Floats:
        """Times in seconds of ascending places of the way."""
        path = self.path
        if not len(way):
            return way
        low, high = np.searchsorted(self.starts, (way[0], way[-1]), side="right").tolist()
        low = max(low - 1, 0)
        bounds = np.searchsorted(way, self.starts[low:high])
        bounds[0] = 0
        counts = np.diff(np.append(bounds, len(way)))
        busy = np.flatnonzero(counts)
        counts = counts[busy]
        busy += low
        steady = self.steady[busy]
        # Steady phases at once: time is a straight line over the way.
        first = path.phase_start_s[busy] - self.starts[busy] * self.pace[busy]
        times = np.repeat(self.pace[busy], counts)
        times *= way
        times += np.repeat(first, counts)
        if not steady.all():
            ramp = np.flatnonzero(np.repeat(~steady, counts))
            phase = np.repeat(busy[~steady], counts[~steady])
            times[ramp] = self._ramps(way[ramp], phase)
        return times

    def _ramps(self, way: Floats, phase: Ints) -> Floats:
        """Times within phases of changing speed, by Newton's method from the far side."""
        path = self.path
        back = self.backwards[phase]
        length, lasts = self.lengths[phase], path.phase_duration_s[phase]
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
        begin = path.phase_start_s[phase]
        found: Floats = np.where(back, begin + lasts - t, begin + t)
        return found


class _Axis:
    """The steps of one axis."""

    def __init__(
        self, path: PlannedPath, begins: Floats, index: int, step: float, least_us: int
    ) -> None:
        self.at = path.points[:, index]
        self.begins, self.step, self.least_us = begins, step, least_us
        self.place = int(np.floor(self.at[0] / step + 0.5))
        self.held: Ints = np.zeros(0, dtype=np.int64)

    def window(self, a: float, b: float, clock: _Clock, until_us: int | None) -> Ints:
        """The steps of the way from `a` to `b`, and those that were held back before.

        Steps behind `until_us` are held back, as their counterparts may come in the next window.
        """
        way, forward = self._steps(a, b)
        times = clock.at(way)
        times *= MICROSECONDS
        times += 0.5
        found = times.astype(np.int64)
        found <<= 2
        found |= forward
        if len(self.held):
            found = np.concatenate((self.held, found))
        found = self._without_turns(found)
        if until_us is None:
            self.held = found[:0]
            return found
        kept = int(np.searchsorted(found, until_us << 2))
        self.held = found[kept:]
        return found[:kept]

    def _steps(self, a: float, b: float) -> tuple[Floats, Ints]:
        """Where along the way the middles between places are passed, and whether forwards."""
        first = int(np.searchsorted(self.begins, a, side="right"))
        last = int(np.searchsorted(self.begins, b, side="left"))
        marks = np.concatenate(([a], self.begins[first:last], [b]))
        ends = np.interp([a, b], self.begins[first - 1 : last + 1], self.at[first - 1 : last + 1])
        x = np.concatenate((ends[:1], self.at[first:last], ends[1:]))
        places = np.floor(x / self.step + 0.5).astype(np.int64)
        places[0] = self.place
        self.place = int(places[-1])
        moves = np.diff(places)
        counts = np.abs(moves)
        which = np.flatnonzero(counts)
        if not len(which):
            return np.zeros(0), np.zeros(0, dtype=np.int64)
        counts = counts[which]
        sign = np.sign(moves[which])
        span, length = x[which + 1] - x[which], marks[which + 1] - marks[which]
        pitch = self.step * length / np.abs(span)
        # The k-th middle lies (places + sign (k + 1/2)) step; k counts on over all stretches.
        begin = marks[which] + (places[which] + 0.5 * sign - x[which] / self.step) * sign * pitch
        before = np.cumsum(counts) - counts
        way = np.repeat(pitch, counts)
        way *= np.arange(len(way), dtype=np.float64)
        way += np.repeat(begin - before * pitch, counts)
        return way, np.repeat((sign > 0).astype(np.int64), counts)

    def _without_turns(self, found: Ints) -> Ints:
        """Without pairs of steps forth and back that come too near to each other."""
        while len(found) > 1:
            forward = (found.astype(np.uint8) & 1).view(np.bool_)
            turns = np.flatnonzero(forward[1:] != forward[:-1])
            pairs = turns[(found[turns + 1] >> 2) - (found[turns] >> 2) < self.least_us]
            if not len(pairs):
                return found
            # Of pairs that share a step only the first goes in this round.
            apart = np.append(True, np.diff(pairs) > 1)
            chosen = pairs[apart]
            kept = np.ones(len(found), dtype=bool)
            kept[chosen] = kept[chosen + 1] = False
            found = found[kept]
        return found
