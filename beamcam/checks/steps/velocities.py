"""Velocity tables read back: one row a segment of motion, by itself and against the part.

A row says the same thing three times: where its segment ends, the velocity along it, and the steps
and frequency of each motor. All have to agree with one another and with the machine.
"""

import re
from collections.abc import Iterator
from math import hypot, inf, sqrt
from typing import NamedTuple

import numpy as np
import shapely

from beamcam.checks.steps import rules
from beamcam.checks.steps.outline import BELOW_GREATEST, SPEED_SLACK, Observed, OutlineCheck, Seen
from beamcam.controllers import step_table
from beamcam.controllers.step_table import Stream, shown
from beamcam.errors import Diagnostic, Rule, Source, add_few
from beamcam.machine.machine import Machine

COLUMNS = "x,y,velocity_x,velocity_y,laser,steps_x,steps_y,hz_x,hz_y"
#: Half of the last decimal of lengths and velocities, and of frequencies.
ROUND, ROUND_HZ = 0.5e-4, 0.5e-2
SPACING = 0.25  #: of the points of a segment that are compared
BLOCK = 4096  #: segments that are compared together
NOTHING_FAST, NOTHING_SLOW = Seen(0.0, 0), Seen(inf, 0)
_NUMBER = rb"(-?\d{1,9}(?:\.\d+)?)"
_ROW = re.compile(
    b",".join((*[_NUMBER] * 4, rb"([01])", *[rb"(-?\d{1,9})"] * 2, *[rb"(\d{1,9}(?:\.\d+)?)"] * 2))
)


class TableRow(NamedTuple):
    """A row, and where its segment begins."""

    line: int
    start: tuple[float, float]
    end: tuple[float, float]
    velocity: tuple[float, float]  #: mm/s
    laser: bool
    steps: tuple[int, int]
    hz: tuple[float, float]

    @property
    def way(self) -> tuple[float, float]:
        return self.end[0] - self.start[0], self.end[1] - self.start[1]


def table_rows(stream: Stream, step: float) -> Iterator[TableRow]:
    """The rows of a velocity table, from the corner on. Raises VerifyError."""
    stream.take_head("velocities", COLUMNS, step)
    here = (0.0, 0.0)
    while first := stream.take(1):
        stream.give_back(first)
        line = stream.take_line("a row and its end")
        row = _ROW.fullmatch(line)
        if row is None:
            raise stream.fault(repr(shown(line)), f"as {COLUMNS}", stream.line - 1)
        x, y, vx, vy, laser, nx, ny, fx, fy = row.groups()
        end = float(x), float(y)
        yield TableRow(
            stream.line - 1, here, end, (float(vx), float(vy)), laser == b"1",
            (int(nx), int(ny)), (float(fx), float(fy)),
        )  # fmt: skip
        here = end


class Velocities:
    """A velocity table that is followed row by row; its strokes go to an outline."""

    def __init__(self, machine: Machine, name: str, outline: OutlineCheck) -> None:
        self.stepper = machine.needed(machine.stepper, "stepping motors")
        self.torch = machine.needed(machine.torch, "torch")
        self.name = name
        self.outline = outline
        self.diagnostics: list[Diagnostic] = []
        self.steps = [0, 0]
        self.here = (0.0, 0.0)
        self.rows = 0
        self._segments: list[TableRow] = []  #: of a stroke, not drawn yet
        self._seen: tuple[Seen, Seen] | None = None  #: fastest and slowest of a stroke

    def say(self, rule: Rule, line: int | None, **values: object) -> None:
        """Note what is wrong, a few of each kind."""
        add_few(self.diagnostics, rule.at(Source(self.name, line), **values))

    def follow(self, row: TableRow) -> None:
        """Take a row."""
        self.rows += 1
        x, y = row.end
        if not (0.0 <= x <= self.torch.length and 0.0 <= y <= self.torch.width):
            expected = f"it between 0, 0 and {self.torch.length:g}, {self.torch.width:g}"
            self.say(rules.PLACE, row.line, x=f"{x:g}", y=f"{y:g}", expected=expected)
        self._count(row)
        self._direction(row)
        self._frequency(row)
        if row.laser:
            self._draw(row)
        else:
            self._end_stroke()
            speed, required = hypot(*row.velocity), self.stepper.traverse_mm_s
            too_slow = speed < required - SPEED_SLACK and not self._is_at_limit(row)
            if too_slow or speed > required + SPEED_SLACK:
                found, expected = f"{speed:g}", f"{required:g} mm/s"
                self.say(rules.SPEED, row.line, found=found, process="traverse", expected=expected)
        self.here = row.end

    def _count(self, row: TableRow) -> None:
        """Check that each motor is on the step nearest to the end."""
        for k, axis in enumerate("XY"):
            self.steps[k] += row.steps[k]
            steps = row.end[k] / self.stepper.step
            if abs(self.steps[k] - steps) > 0.5 + ROUND / self.stepper.step:
                found, expected = row.steps[k], f"{row.steps[k] + round(steps) - self.steps[k]}"
                labels = {"axis": axis, "place": f"X {row.end[0]:g}, Y {row.end[1]:g}"}
                self.say(rules.COUNT, row.line, found=found, expected=expected, **labels)
                self.steps[k] = round(steps)

    def _direction(self, row: TableRow) -> None:
        """The velocity leads along the segment; both are rounded."""
        (dx, dy), (vx, vy) = row.way, row.velocity
        length, speed = hypot(dx, dy), hypot(vx, vy)
        if length <= 2 * sqrt(2.0) * ROUND and speed > 0.0:
            return  # too short to have a direction
        slack = 2 * sqrt(2.0) * ROUND * (speed + length)
        if dx * vx + dy * vy <= 0.0 or abs(dx * vy - dy * vx) > slack:
            found = f"velocity {vx:g}, {vy:g} for a way of {dx:g}, {dy:g}"
            self.say(rules.VELOCITY, row.line, found=found, expected="it along the way")

    def _frequency(self, row: TableRow) -> None:
        """Check that frequencies match the velocity and do not exceed the maximum."""
        step, max_hz = self.stepper.step, self.stepper.max_hz
        for axis, v, hz in zip("XY", row.velocity, row.hz, strict=True):
            found = f"{hz:g} Hz of {axis}"
            if abs(hz - abs(v) / step) > ROUND / step + 2 * ROUND_HZ:
                expected = f"{abs(v) / step:g} Hz for {v:g} mm/s"
                self.say(rules.VELOCITY, row.line, found=found, expected=expected)
            if hz > max_hz + ROUND_HZ:
                expected = f"at most {max_hz:g} Hz"
                self.say(rules.VELOCITY, row.line, found=found, expected=expected)

    def _is_at_limit(self, row: TableRow) -> bool:
        """Whether a motor keeps the segment from being any faster."""
        return max(row.hz) >= (1.0 - BELOW_GREATEST) * self.stepper.max_hz

    # -- strokes ----------------------------------------------------------------------------

    def _draw(self, row: TableRow) -> None:
        if self._seen is None:
            self.outline.begin(row.line)
        fastest, slowest = self._seen or (NOTHING_FAST, NOTHING_SLOW)
        seen = Seen(hypot(*row.velocity), row.line)
        slowest = slowest if self._is_at_limit(row) else min(slowest, seen)
        self._seen = max(fastest, seen), slowest
        self._segments.append(row)
        if len(self._segments) >= BLOCK and not self.outline.counts_passes:
            self._draw_segments()

    def _draw_segments(self) -> None:
        if self._segments:
            corners = np.array([self._segments[0].start, *(row.end for row in self._segments)])
            line = shapely.segmentize(shapely.LineString(corners), SPACING)
            self.outline.draw(shapely.get_coordinates(line), corners)
            self._segments = []

    def _end_stroke(self) -> None:
        if self._seen is None:
            return
        seen = Observed(*self._seen)
        if self.outline.counts_passes:
            # A pass that begins where one ends has no row between them: of a contour that is
            # followed twice the rows are those of one round, twice.
            rows, begin = self._segments, self._segments[0].start
            ends, count = [(row.end, row.velocity) for row in rows], len(rows)
            once = next(
                k for k in range(1, count + 1) if k == count or (
                    count % k == 0 and rows[k - 1].end == begin and ends == ends[:k] * (count // k)
                )
            )  # fmt: skip
            self._segments = rows[:once]
            path = repr((begin, ends[:once])).encode()
            seen = seen._replace(path=path, passes=count // once)
        self._draw_segments()
        self.outline.end(seen)
        self._seen = None

    def finish(self) -> None:
        """Checks at the end of the table."""
        self._end_stroke()
        if not self.rows:
            self.say(step_table.ROW, None, found="no rows", expected="a row at least")
        if self.here != (0.0, 0.0):
            x, y = (f"{v:g}" for v in self.here)
            self.say(rules.PLACE, None, x=x, y=y, expected="it in the corner at the end")
