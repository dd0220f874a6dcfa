r"""Step times of each motor along a planned path.

An axis stands on a grid of steps, always on the place nearest to where the path is; so it steps
when the path passes the middle between two places:

        place   2 |           o---       A path that turns back just behind a middle would ask for
                  |       o---|    \     two steps in no time. Both are left out: the path passes
        middle  - | - - -/- - - - - \    the middle by less than can be seen.
        place   1 |  o---|           o

The way is cut at every corner, at every change of the motion, and into windows; on a piece between
two cuts the middles follow each other at one distance. Where the speed is steady so do the times.
All is done by arrays over windows of the way, so that memory does not grow with the table.
"""

from collections.abc import Iterator

import numpy as np

from beamcam.geometry.array_types import Counts, Floats
from beamcam.machine.tables import Stepper
from beamcam.motion.lookahead import PlannedPath

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
        v, a, j, d = (
            path.phase_velocity, path.phase_acceleration, path.phase_jerk, path.phase_duration_s,
        )  # fmt: skip
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
        times: Floats = self.start_us[phase] + (way - self.starts[phase]) * self.pace_us[phase]
        return times

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
        times: Floats = self.start_us[phase] + np.where(back, lasts - t, t) * MICROSECONDS
        return times


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
