"""The trace of a table for stepping motors: from its rows, which carry their own times.

.csv                velocities: each stretch at the velocity that its row says
.steps .bin .h      steps one by one: sampled at equal times, then thinned out; the straight
                    lines that are left pass within a step of every row
"""

from collections.abc import Iterable, Iterator
from math import hypot

import numpy as np

from beamcam.controllers.step_table.rows import Rows
from beamcam.geometry.array_types import Counts, Floats
from beamcam.machine.machine import Machine
from beamcam.machine.tables import Stepper
from beamcam.simulate.state import State
from beamcam.simulate.trace import UNIFORM, Trace, TraceBuilder, head_axes
from beamcam.verify.steps.velocities import TableRow

SAMPLE_S = 0.005
MICROSECONDS = 1e6
SLACK_STEPS = 1.0  #: of the thinned lines from the samples; less keeps the jitter of whole steps
LASER = State(process="cut")


def velocity_trace(rows: Iterable[TableRow], machine: Machine) -> Trace:
    """The head over time, stretch by stretch of a velocity table."""
    builder = TraceBuilder(head_axes(machine), (0.0, 0.0))
    for row in rows:
        way, speed = hypot(*row.way), hypot(*row.velocity)
        if way > 0.0 and speed > 0.0:
            state = LASER if row.laser else State()
            builder.add([way / speed], [row.end], UNIFORM, row.line, state)
    return builder.trace()


def step_trace(blocks: Iterable[Rows], machine: Machine) -> Trace:
    """The head over time, from the rows of a step table."""
    stepper = machine.needed(machine.stepper, "stepping motors")
    builder = TraceBuilder(head_axes(machine), (0.0, 0.0))
    clock_s = 0.0
    for times, places, lines, laser in _strokes(blocks, stepper):
        state = LASER if laser else State()
        knots = _thinned(times, places, SLACK_STEPS * stepper.step)
        seconds = np.diff(times[knots], prepend=clock_s)
        builder.add(seconds, places[knots], UNIFORM, lines[knots], state)
        clock_s = float(times[-1])
    return builder.trace()


def _strokes(
    blocks: Iterable[Rows], stepper: Stepper
) -> Iterator[tuple[Floats, Floats, Counts, bool]]:
    """Samples while the laser is on or off: times, places and rows; never none."""
    turned = np.array([-1 if axis in stepper.reversed_axes else 1 for axis in "XY"])
    phase = np.empty(4, dtype=np.int64)
    phase[[int(word, 2) for word in stepper.sequence]] = np.arange(4)
    here = np.zeros(2, dtype=np.int64)
    words = np.full(2, int(stepper.sequence[0], 2), dtype=np.int64)
    for rows in blocks:
        both = np.column_stack((rows.x, rows.y))
        turn = np.diff(phase[both], axis=0, prepend=phase[words][None]) & 3
        places = here + np.cumsum(np.where(turn == 3, -1, turn) * turned, axis=0)
        here, words = places[-1], both[-1]
        times = rows.time_us / MICROSECONDS
        for part in np.split(np.arange(len(times)), np.flatnonzero(np.diff(rows.laser)) + 1):
            kept = part[_sampled(times[part])]
            at = places[kept] * stepper.step
            yield times[kept], at, rows.first + kept, bool(rows.laser[part[0]])


def _sampled(times: Floats) -> Counts:
    """The last row of each slot of time, and the last one of all."""
    slot = np.floor(times / SAMPLE_S)
    return np.flatnonzero(np.append(np.diff(slot) > 0.0, True))


def _thinned(times: Floats, places: Floats, slack: float) -> Counts:
    """Which samples to keep, so that straight lines between them pass within `slack` of all.

    A line goes on from the last kept sample as long as there is a velocity that meets all samples
    within the slack (a swinging door); the sample before it closes is kept.
    """
    kept: list[int] = []
    t0, (x0, y0) = float(times[0]), places[0].tolist()
    low, high = [-np.inf, -np.inf], [np.inf, np.inf]
    for k, (t, (x, y)) in enumerate(zip(times.tolist(), places.tolist(), strict=True)):
        dt = t - t0
        if dt <= 0.0:
            continue
        ways = (x - x0, y - y0)
        if not all(low[i] - 1e-12 <= ways[i] / dt <= high[i] + 1e-12 for i in (0, 1)):
            kept.append(k - 1)
            t0, (x0, y0) = float(times[k - 1]), places[k - 1].tolist()
            low, high = [-np.inf, -np.inf], [np.inf, np.inf]
            dt = t - t0
            ways = (x - x0, y - y0)
        for i in (0, 1):
            low[i] = max(low[i], (ways[i] - slack) / dt)
            high[i] = min(high[i], (ways[i] + slack) / dt)
    kept.append(len(times) - 1)
    return np.array(kept, dtype=np.int64)
