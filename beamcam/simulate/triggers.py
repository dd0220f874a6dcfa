"""The trace of a table run by triggers: each operation from rest to rest.

The next operation begins in the cycle behind the one that sees the arrival, as in
`motion.table_times`, whose times these are.
"""

from math import inf

import numpy as np

from beamcam.controllers.simotion.circles import circle_points
from beamcam.controllers.simotion.job import JobRead, Operation
from beamcam.geometry.plane import Point
from beamcam.geometry.ramps import move_seconds, ramp
from beamcam.machine.machine import Machine
from beamcam.machine.runtime import PROCESSES
from beamcam.model.triggers import ArcTravel, Switch, Travel, TriggerOp
from beamcam.motion.speed_sections import SpeedSection
from beamcam.motion.table_times import operation_seconds
from beamcam.simulate.bars import ramp_intervals
from beamcam.simulate.phases import Chords, phases_of
from beamcam.simulate.state import State
from beamcam.simulate.trace import Trace, TraceBuilder, head_axes

ARC = 7  #: kind of an operation along an arc; 0 is a line, odd kinds start a tool, even stop it


def trigger_trace(job: JobRead, machine: Machine) -> Trace:
    """The head over time, from the corner of the work area on; homing is not in it."""
    triggers = machine.needed(machine.triggers, "trigger program")
    builder = TraceBuilder(head_axes(machine), (0.0, 0.0))
    state = State()
    here: Point = (0.0, 0.0)
    for operation in job.operations:
        op = _operation(operation, job)
        whole_s = operation_seconds(op, here, triggers)
        if isinstance(op, Switch):
            state = State(process=op.process if op.on else "")
            builder.wait(whole_s, operation.line, state)
            continue
        way = _travel(builder, here, op, triggers.acceleration, operation.line, state)
        moving_s = move_seconds(way, op.speed_mm_s, triggers.acceleration)
        builder.wait(max(0.0, whole_s - moving_s), operation.line, state)
        here = op.x, op.y
    return builder.trace()


def _operation(op: Operation, job: JobRead) -> TriggerOp:
    """An operation as it was read, in the words of the model."""
    if op.kind == 0:
        return Travel(op.x, op.y, op.speed)
    if op.kind >= ARC:
        return ArcTravel(op.x, op.y, *(op.via or (op.x, op.y)), op.speed)
    process = PROCESSES[(op.kind - 1) // 2]
    on = op.kind % 2 == 1
    return Switch(process, on, job.pierce_s[process] if on else 0.0)  # type: ignore[arg-type]


def _travel(
    builder: TraceBuilder, here: Point, op: Travel | ArcTravel, acceleration: float, line: int,
    state: State,
) -> float:  # fmt: skip
    """Adds a move from rest to rest; its length comes back."""
    points: list[Point] = [here, (op.x, op.y)]
    if isinstance(op, ArcTravel):
        points = circle_points(here, (op.middle_x, op.middle_y), points[1]) or points
    corners = np.array(points)
    lengths = np.hypot(*np.diff(corners, axis=0).T)
    way = float(np.sum(lengths))
    if not way > 0.0:
        return 0.0
    if len(lengths) > 1:
        lines = np.full(len(lengths), line, dtype=np.int64)
        whole = SpeedSection(op.speed_mm_s, way, 0, len(lengths), acceleration, inf)
        chords = Chords(corners[:-1], corners[1:], lengths, lines)
        run = phases_of(chords, [whole], (0.0, 0.0))
        builder.add(run.seconds, run.ends, run.slopes, line, state)
        return way
    run_up = ramp(op.speed_mm_s / way, acceleration / way)
    for begin_s, end_s, *slopes in ramp_intervals(run_up):
        at = corners[0] + run_up.share(end_s) * (corners[1] - corners[0])
        builder.add([end_s - begin_s], [at], slopes, line, state)
    return way
