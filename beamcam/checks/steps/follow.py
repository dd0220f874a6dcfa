"""The motors followed from the first row of a step table to its last."""

from collections.abc import Callable
from hashlib import blake2b
from itertools import pairwise
from math import sqrt

import numpy as np

from beamcam.checks.steps import rules
from beamcam.checks.steps.outline import Observed, OutlineCheck, Rest, Seen, StrokeTimes
from beamcam.controllers import step_table
from beamcam.controllers.step_table import Rows
from beamcam.errors import Diagnostic, Rule, Source, add_few
from beamcam.geometry.array_types import Counts, Floats
from beamcam.machine.machine import Machine
from beamcam.machine.tables import Stepper

# --- step rates -----------------------------------------------------------------------------------

# Step rates, measured over windows of time.
#
# A motor stands up to half a step off its path, so that positions show speeds and accelerations
# only over a while: the longer it is, the finer is what can be seen.


class _Samples:
    """Places at multiples of a window, from rows that come block by block.

    In a long wait all samples would be the same; the first three of them say as much as all.
    """

    def __init__(self, window_us: int, first_us: int, kept: int) -> None:
        self.window_us, self._first_us, self._kept = window_us, first_us, kept
        self._next = 0  #: the next multiple
        self._times: Counts = np.zeros(0, dtype=np.int64)  #: of the row before
        self._places: Counts = np.zeros((0, 2), dtype=np.int64)
        self._last: Counts = np.zeros((0, 2), dtype=np.int64)

    def take(self, time_us: Counts, places: Counts) -> Counts:
        """The samples (n, 2) up to the last of some rows, behind the last ones of those before."""
        times = np.concatenate((self._times, time_us)) - self._first_us
        places = np.concatenate((self._places, places))
        behind = _once(-(-times // self.window_us))
        index = _once(np.sort(np.concatenate((behind, behind + 1, behind + 2))))
        index = index[(index >= self._next) & (index <= int(times[-1]) // self.window_us)]
        if len(index):
            self._next = int(index[-1]) + 1
        self._times, self._places = time_us[-1:], places[-1:]
        rows = np.searchsorted(times, index * self.window_us, side="right") - 1
        samples = np.concatenate((self._last, places[rows]))
        self._last = samples[-self._kept :]
        return samples


def _once(ascending: Counts) -> Counts:
    kept: Counts = ascending[np.append(True, ascending[1:] != ascending[:-1])]
    return kept


class _Rests:
    """The longest times between two steps of a stroke: anywhere, and at a steady speed.

    A head that brakes and turns takes its time for a step. Where it is as fast over `HALF` steps
    as over those before them, on both sides, it takes no more than the way of a step to the next.
    """

    HALF = 48
    STEADY = 0.2  #: share by which the speeds may differ
    LONGER = 1.5  #: times the way of a step, at that speed

    def __init__(self, step: float) -> None:
        self.stood: Rest | None = None
        self.longest: Rest | None = None
        self._way = sqrt(2.0) * step
        self._step = step
        self._times: Counts = np.zeros(0, dtype=np.int64)
        self._places: Counts = np.zeros((0, 2), dtype=np.int64)

    def follow(self, time_us: Counts, places: Counts) -> None:
        """Take the rows of some steps."""
        times = np.concatenate((self._times, time_us))
        places = np.concatenate((self._places, places))
        gaps = np.diff(times)
        known = max(len(self._times) - 1, 0)  # of these the gaps behind are known
        if len(gaps) > known:
            k = known + int(np.argmax(gaps[known:]))
            self.longest = self._longer(self.longest, int(gaps[k]), places[k])
        half = self.HALF
        if len(gaps) > 4 * half:
            chords = np.hypot(*(places[half:] - places[:-half]).T) * self._step
            speeds = chords / np.maximum(times[half:] - times[:-half], 1) * 1e6
            # Steps k - 2 half, k - half, k, and k + 1, k + 1 + half, k + 1 + 2 half.
            at = np.arange(2 * half, len(gaps) - 2 * half)
            around = np.stack([speeds[at + n] for n in (-2 * half, -half, 1, 1 + half)])
            slow, fast = around.min(axis=0), around.max(axis=0)
            long = gaps[at] * 1e-6 * slow > self.LONGER * self._way
            rests = at[long & (slow >= (1.0 - self.STEADY) * fast)]
            for k in rests[np.argsort(-gaps[rests], kind="stable")].tolist():
                around = np.append(gaps[k - 2 * half : k], gaps[k + 1 : k + 1 + 2 * half])
                if gaps[k] > self.LONGER * around.max():  # else it goes from corner to corner
                    self.stood = self._longer(self.stood, int(gaps[k]), places[k])
                    break
        kept = 4 * half + 1
        self._times, self._places = times[-kept:], places[-kept:]

    @staticmethod
    def _longer(one: Rest | None, gap_us: int, place: Counts) -> Rest:
        rest = Rest(gap_us / 1e6, (int(place[0]), int(place[1])))
        return rest if one is None else max(one, rest)


class StepRates:
    """The wait at the start of a stroke, how long it takes, and the greatest speed in it.

    The chord of a window is never longer than the way in it. Each of its ends is half a step off
    at most along each axis, which is taken off.
    """

    WINDOWS_US = (20_000, 500_000)

    def __init__(self, step: float) -> None:
        self.step = step
        self.max_mm_s = 0.0
        self._begin_us: int | None = None
        self._moved_us: int | None = None  #: the first step
        self._last_us = 0  #: and the last
        self._here: Counts = np.zeros(2, dtype=np.int64)
        self._samples: list[_Samples] = []
        self._rests = _Rests(step)

    def follow(self, time_us: Counts, places: Counts) -> None:
        """Take some rows of the stroke."""
        if self._begin_us is None:
            self._begin_us, self._here = int(time_us[0]), places[0]
            self._samples = [_Samples(w, self._begin_us, 1) for w in self.WINDOWS_US]
        moved = (places != np.concatenate((self._here[None], places[:-1]))).any(axis=1)
        if moved.any():
            self._last_us = int(time_us[np.flatnonzero(moved)[-1]])
            if self._moved_us is None:
                self._moved_us = int(time_us[np.argmax(moved)])
            self._rests.follow(time_us[moved], places[moved])
        self._here = places[-1]
        for samples in self._samples:
            at = samples.take(time_us, places)
            if len(at) > 1:
                chords = np.hypot(*np.diff(at, axis=0).T) * self.step
                sure = float(chords.max()) - sqrt(2.0) * self.step
                self.max_mm_s = max(self.max_mm_s, sure / (samples.window_us / 1e6))

    def times(self, end_us: int) -> StrokeTimes:
        """The times of a stroke whose tool is switched off then."""
        rests, waited_s, stayed_s = self._rests, 0.0, 0.0
        if self._begin_us is not None and self._moved_us is not None:
            waited_s = (self._moved_us - self._begin_us) / 1e6
            stayed_s = max(0, end_us - self._last_us) / 1e6
        lasted_s = (self._last_us - (self._moved_us or 0)) / 1e6
        return StrokeTimes(waited_s, lasted_s, stayed_s, rests.stood, rests.longest)


class Swerve:
    """The maximum accelerations of both axes: second differences of positions.

    A motor stands half a step off its path, and the path up to `corner` off one that keeps the
    acceleration, so that each of the three places may be off by both.
    """

    WINDOWS_US = (5_000, 20_000)

    def __init__(self, stepper: Stepper) -> None:
        self.stepper = stepper
        self._samples = [_Samples(window_us, 0, 2) for window_us in self.WINDOWS_US]
        self._greatest: Floats = np.zeros((len(self._samples), 2))
        self._places: Counts = np.zeros((len(self._samples), 2, 2), dtype=np.int64)  #: of these

    def follow(self, time_us: Counts, places: Counts) -> None:
        """Take some rows."""
        for k, samples in enumerate(self._samples):
            at = samples.take(time_us, places)
            if len(at) > 2:
                second = np.abs(np.diff(at, n=2, axis=0)) * self.stepper.step
                for axis, row in enumerate(np.argmax(second, axis=0)):
                    if second[row, axis] > self._greatest[k, axis]:
                        self._greatest[k, axis] = second[row, axis]
                        self._places[k, axis] = at[row + 1]

    def finish(self, clock_us: int, place: Counts) -> None:
        """The head has stopped."""
        self.follow(np.array([clock_us + 3 * max(self.WINDOWS_US)]), place[None])

    def beyond(self) -> list[tuple[float, Floats] | None]:
        """The acceleration of X and of Y in mm/s2 and its place, where the axis cannot do it."""
        windows_s2 = (np.array(self.WINDOWS_US) / 1e6) ** 2
        slack = 4 * (self.stepper.step / 2 + self.stepper.corner)
        most = self.stepper.acceleration * windows_s2 + slack
        swerves: list[tuple[float, Floats] | None] = []
        for axis, worst in enumerate(self._greatest.T):
            over = np.where(worst > most, worst / windows_s2, 0.0)
            k = int(np.argmax(over))
            place: Floats = self._places[k, axis] * np.float64(self.stepper.step)
            swerves.append((float(over[k]), place) if over[k] else None)
        return swerves


class _Motor:
    """One motor: its position, and the time of its last step."""

    def __init__(self, name: str, stepper: Stepper, say: Callable[..., None]) -> None:
        forward = [int(word, 2) for word in stepper.sequence]
        self.name, self.sequence, self.say = name, " ".join(stepper.sequence), say
        self.phase = np.zeros(4, dtype=np.int64)
        self.phase[forward] = np.arange(4)
        self.sign = -1 if name in stepper.reversed_axes else 1
        self.place = 0
        self.last_word = forward[0]
        self.last_us = -(10**12)
        self.min_us = int(1e6 / stepper.max_hz)

    def follow(self, rows: Rows, words: Counts) -> Counts:
        """The places behind each row; what is wrong with the steps is reported."""
        turn = np.diff(self.phase[words], prepend=self.phase[self.last_word]) & 3
        if (turn == 2).any():
            k = int(np.argmax(turn == 2))
            before, row = int(words[k - 1]) if k else self.last_word, rows.first + k
            labels = {"axis": self.name, "before": f"{before:02b}", "sequence": self.sequence}
            self.say(rules.WORD, row, found=f"{int(words[k]):02b}", **labels)
        moves = np.where(turn == 3, -1, turn) * self.sign
        places: Counts = self.place + np.cumsum(moves)
        steps = np.flatnonzero(turn)
        if len(steps):
            apart = np.diff(rows.time_us[steps], prepend=self.last_us)
            k = int(np.argmin(apart))
            if apart[k] < self.min_us:
                found, row = int(apart[k]), rows.first + int(steps[k])
                self.say(rules.FREQUENCY, row, axis=self.name, found=found, expected=self.min_us)
            self.last_us = int(rows.time_us[steps[-1]])
        self.last_word, self.place = int(words[-1]), int(places[-1])
        return places


class Followed:
    """A step table that is followed block by block; its strokes go to an outline."""

    def __init__(self, machine: Machine, name: str, outline: OutlineCheck) -> None:
        self.stepper = machine.needed(machine.stepper, "stepping motors")
        self.torch = machine.needed(machine.torch, "torch")
        self.name = name
        self.outline = outline
        self.motors = [_Motor(axis, self.stepper, self.say) for axis in "XY"]
        self.diagnostics: list[Diagnostic] = []
        self.swerve = Swerve(self.stepper)
        self.pace: StepRates | None = None  #: of the stroke that is being made
        self.line = 0  #: where it begins
        self.path = blake2b()  #: of its places
        self.laser = 0
        self.clock_us = 0
        self.here: Counts = np.zeros(2, dtype=np.int64)
        self.begun = False

    def say(self, rule: Rule, row: int | None, **values: object) -> None:
        """Add a message, a few of each kind."""
        add_few(self.diagnostics, rule.at(Source(self.name, row), **values))

    def follow(self, rows: Rows) -> None:
        """Take some rows."""
        if not self.begun and (rows.laser[0] or rows.time_us[0]):
            found = f"the laser {'on' if rows.laser[0] else 'off'} at {rows.time_us[0]} us"
            expected = "the first row at 0 us with the laser off"
            self.say(rules.LASER, rows.first, found=found, expected=expected)
        self.begun = True
        back = np.flatnonzero(np.diff(rows.time_us, prepend=self.clock_us) < 0)
        if len(back):
            row = rows.first + int(back[0])
            self.say(rules.TIME, row, found="a time before the last one", expected="a later one")
        x, y = self.motors
        places = np.stack((x.follow(rows, rows.x), y.follow(rows, rows.y)), axis=1)
        self._strokes(rows, places)
        limits = np.array([self.torch.length, self.torch.width]) / self.stepper.step + 1
        outside = ((places < -1) | (places > limits)).any(axis=1)
        if outside.any():
            k = int(np.argmax(outside))
            expected = f"it between 0, 0 and {self.torch.length:g}, {self.torch.width:g}"
            self._say_place(places[k], expected, rows.first + k)
        self.swerve.follow(rows.time_us, places)
        self.clock_us, self.here = int(rows.time_us[-1]), places[-1]

    def _strokes(self, rows: Rows, places: Counts) -> None:
        """Cut the rows where the laser is switched, and show the outline where it is on."""
        changes = np.flatnonzero(np.diff(rows.laser, prepend=self.laser))
        start = np.concatenate((self.here[None], places[:-1]))
        moved = np.flatnonzero((places[changes] != start[changes]).any(axis=1))
        if len(moved):
            found, row = "a step in the row that switches the laser", int(changes[moved[0]])
            self.say(rules.LASER, rows.first + row, found=found, expected="the head at rest")
        switched = set(changes.tolist())
        for a, b in pairwise((0, *changes.tolist(), len(rows.laser))):
            if a in switched and not rows.laser[a]:
                self._end_stroke(int(rows.time_us[a]))
            if b > a and rows.laser[a]:
                if a in switched or self.pace is None:
                    self.outline.begin(rows.first + a)
                    self.pace, self.line = StepRates(self.stepper.step), rows.first + a
                    self.path = blake2b(start[a].tobytes())
                self.pace.follow(rows.time_us[a:b], places[a:b])
                if self.outline.counts_passes:
                    moves = (places[a:b] != start[a:b]).any(axis=1)
                    self.path.update(places[a:b][moves].tobytes())
                points: Floats = places[a:b] * np.float64(self.stepper.step)
                self.outline.draw(points)
        self.laser = int(rows.laser[-1])

    def _end_stroke(self, end_us: int) -> None:
        if self.pace is not None:
            fastest = Seen(self.pace.max_mm_s, self.line)
            path = self.path.digest() if self.outline.counts_passes else b""
            self.outline.end(Observed(fastest, times=self.pace.times(end_us), path=path))
        self.pace = None

    def _say_place(self, place: Counts, expected: str, line: int | None = None) -> None:
        x, y = (f"{v * self.stepper.step:.2f}" for v in place.tolist())
        self.say(rules.PLACE, line, x=x, y=y, expected=expected)

    def finish(self) -> None:
        """Checks at the end of the table."""
        if not self.begun:
            self.say(step_table.ROW, None, found="no rows", expected="a row at least")
        if self.laser:
            self._end_stroke(self.clock_us)
            self.say(rules.LASER, None, found="the laser on at the end", expected="it off")
        if self.here.any():
            self._say_place(self.here, "it in the corner at the end")
        self.swerve.finish(self.clock_us, self.here)
        greatest = self.stepper.acceleration
        for axis, over in zip("XY", self.swerve.beyond(), strict=True):
            if over is not None:
                mm_s2, place = over
                x, y = (f"{v:.2f}" for v in place.tolist())
                expected = f"{greatest:g} mm/s2{self.outline.nearest(place)}"
                self.say(
                    rules.ACCELERATION, None, axis=axis, found=f"{mm_s2:.0f}", x=x, y=y,
                    expected=expected,
                )  # fmt: skip
