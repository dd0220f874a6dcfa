"""The motors followed from the first row of a step table to its last."""

from collections.abc import Iterable
from hashlib import blake2b
from itertools import pairwise

import numpy as np

from beamcam.controllers.step_table import rules as row_rules
from beamcam.controllers.step_table.rows import Rows
from beamcam.errors import Diagnostic, Source, add_few
from beamcam.geometry.array_types import Counts, Floats
from beamcam.machine.machine import Machine
from beamcam.machine.tables import Stepper
from beamcam.verify.steps import rules
from beamcam.verify.steps.outline import OutlineCheck
from beamcam.verify.steps.speeds import Observed, Seen
from beamcam.verify.steps.step_rates import StepRates, Swerve


class _Motor:
    """One motor: its position, and the time of its last step."""

    def __init__(self, name: str, stepper: Stepper) -> None:
        forward = [int(word, 2) for word in stepper.sequence]
        self.name, self.sequence = name, " ".join(stepper.sequence)
        self.phase = np.zeros(4, dtype=np.int64)
        self.phase[forward] = np.arange(4)
        self.sign = -1 if name in stepper.reversed_axes else 1
        self.place = 0
        self.last_word = forward[0]
        self.last_us = -(10**12)
        self.min_us = int(1e6 / stepper.max_hz)

    def follow(self, rows: Rows, words: Counts, name: str) -> tuple[Counts, list[Diagnostic]]:
        """The places behind each row, and what is wrong with the steps."""
        said = []
        turn = np.diff(self.phase[words], prepend=self.phase[self.last_word]) & 3
        if (turn == 2).any():
            k = int(np.argmax(turn == 2))
            before = int(words[k - 1]) if k else self.last_word
            said.append(
                rules.WORD.at(
                    Source(name, rows.first + k), found=f"{int(words[k]):02b}", axis=self.name,
                    before=f"{before:02b}", sequence=self.sequence,
                )
            )  # fmt: skip
        moves = np.where(turn == 3, -1, turn) * self.sign
        places: Counts = self.place + np.cumsum(moves)
        steps = np.flatnonzero(turn)
        if len(steps):
            apart = np.diff(rows.time_us[steps], prepend=self.last_us)
            if int(apart.min()) < self.min_us:
                k = int(np.argmin(apart))
                said.append(
                    rules.FREQUENCY.at(
                        Source(name, rows.first + int(steps[k])), axis=self.name,
                        found=int(apart[k]), expected=self.min_us,
                    )
                )  # fmt: skip
            self.last_us = int(rows.time_us[steps[-1]])
        self.last_word, self.place = int(words[-1]), int(places[-1])
        return places, said


class Followed:
    """A step table that is followed block by block; its strokes go to an outline."""

    def __init__(self, machine: Machine, name: str, outline: OutlineCheck) -> None:
        self.stepper = machine.needed(machine.stepper, "stepping motors")
        self.torch = machine.needed(machine.torch, "torch")
        self.name = name
        self.outline = outline
        self.motors = (_Motor("X", self.stepper), _Motor("Y", self.stepper))
        self.said: list[Diagnostic] = []
        self.swerve = Swerve(self.stepper)
        self.pace: StepRates | None = None  #: of the stroke that is being made
        self.line = 0  #: where it begins
        self.path = blake2b()  #: of its places
        self.laser = 0
        self.clock_us = 0
        self.here: Counts = np.zeros(2, dtype=np.int64)
        self.begun = False

    def say(self, found: Iterable[Diagnostic]) -> None:
        """Note what is wrong, a few of each kind."""
        for one in found:
            add_few(self.said, one)

    def follow(self, rows: Rows) -> None:
        """Take some rows."""
        source = Source(self.name, rows.first)
        if not self.begun and (rows.laser[0] or rows.time_us[0]):
            found = f"the laser {'on' if rows.laser[0] else 'off'} at {rows.time_us[0]} us"
            expected = "the first row at 0 us with the laser off"
            self.say([rules.LASER.at(source, found=found, expected=expected)])
        self.begun = True
        back = np.flatnonzero(np.diff(rows.time_us, prepend=self.clock_us) < 0)
        if len(back):
            source = Source(self.name, rows.first + int(back[0]))
            found = "a time before the last one"
            self.say([rules.TIME.at(source, found=found, expected="a later one")])
        places = []
        for motor, words in zip(self.motors, (rows.x, rows.y), strict=True):
            at, said = motor.follow(rows, words, self.name)
            places.append(at)
            self.say(said)
        at_xy = np.stack(places, axis=1)
        self._strokes(rows, at_xy)
        self._area(rows, at_xy)
        self.swerve.follow(rows.time_us, at_xy)
        self.clock_us, self.here = int(rows.time_us[-1]), at_xy[-1]

    def _strokes(self, rows: Rows, places: Counts) -> None:
        """Cut the rows where the laser is switched, and show the outline where it is on."""
        changes = np.flatnonzero(np.diff(rows.laser, prepend=self.laser))
        start = np.concatenate((self.here[None], places[:-1]))
        moved = np.flatnonzero((places[changes] != start[changes]).any(axis=1))
        if len(moved):
            source = Source(self.name, rows.first + int(changes[moved[0]]))
            found = "a step in the row that switches the laser"
            self.say([rules.LASER.at(source, found=found, expected="the head at rest")])
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

    def _area(self, rows: Rows, places: Counts) -> None:
        limits = np.array([self.torch.length, self.torch.width]) / self.stepper.step + 1
        outside = ((places < -1) | (places > limits)).any(axis=1)
        if outside.any():
            k = int(np.argmax(outside))
            expected = f"it between 0, 0 and {self.torch.length:g}, {self.torch.width:g}"
            self._say_place(places[k], expected, rows.first + k)

    def _say_place(self, place: Counts, expected: str, line: int | None = None) -> None:
        x, y = (f"{v * self.stepper.step:.2f}" for v in place.tolist())
        self.say([rules.PLACE.at(Source(self.name, line), x=x, y=y, expected=expected)])

    def finish(self) -> None:
        """Checks at the end of the table."""
        end = Source(self.name)
        if not self.begun:
            self.say([row_rules.ROW.at(end, found="no rows", expected="a row at least")])
        if self.laser:
            self._end_stroke(self.clock_us)
            self.say([rules.LASER.at(end, found="the laser on at the end", expected="it off")])
        if self.here.any():
            self._say_place(self.here, "it in the corner at the end")
        self.swerve.finish(self.clock_us, self.here)
        greatest = self.stepper.acceleration
        for axis, over in zip("XY", self.swerve.beyond(), strict=True):
            if over is not None:
                mm_s2, place = over
                x, y = place.tolist()
                said = rules.ACCELERATION.at(
                    end, axis=axis, found=f"{mm_s2:.0f}", x=f"{x:.2f}", y=f"{y:.2f}",
                    expected=f"{greatest:g} mm/s2{self.outline.nearest(place)}",
                )  # fmt: skip
                self.say([said])
