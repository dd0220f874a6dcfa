"""Step rates, measured over windows of time.

A motor stands up to half a step off its path, so that positions show speeds and accelerations only
over a while: the longer it is, the finer is what can be seen.
"""

from math import sqrt

import numpy as np

from beamcam.geometry.array_types import Counts, Floats
from beamcam.machine.tables import Stepper
from beamcam.verify.steps.speeds import Rest, StrokeTimes


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
        found = np.concatenate((self._last, places[rows]))
        self._last = found[-self._kept :]
        return found


def _once(ascending: Counts) -> Counts:
    found: Counts = ascending[np.append(True, ascending[1:] != ascending[:-1])]
    return found


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
        found = Rest(gap_us / 1e6, (int(place[0]), int(place[1])))
        return found if one is None else max(one, found)


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
        stayed_s = max(0, end_us - self._last_us) / 1e6 if self._moved_us is not None else 0.0
        rests = self._rests
        return StrokeTimes(self.waited_s, self.lasted_s, stayed_s, rests.stood, rests.longest)

    @property
    def waited_s(self) -> float:
        """Dwell of the head at the start of the stroke."""
        if self._begin_us is None or self._moved_us is None:
            return 0.0
        return (self._moved_us - self._begin_us) / 1e6

    @property
    def lasted_s(self) -> float:
        """Time for which the head was moving."""
        return (self._last_us - (self._moved_us or 0)) / 1e6


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
        found: list[tuple[float, Floats] | None] = []
        for axis, worst in enumerate(self._greatest.T):
            over = np.where(worst > most, worst / windows_s2, 0.0)
            k = int(np.argmax(over))
            place: Floats = self._places[k, axis] * np.float64(self.stepper.step)
            found.append((float(over[k]), place) if over[k] else None)
        return found
