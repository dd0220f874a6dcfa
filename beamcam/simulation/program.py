"""Any program on the model of its machine: interpreted as the read-back does, then timed.

text -> events (controllers) -> trace; what is wrong with the program by itself is reported
"""

from collections.abc import Iterable, Iterator, Mapping, Sequence
from math import hypot, inf, isfinite

import numpy as np
from msgspec import Struct

from beamcam.controllers.simotion.axes import circle_points
from beamcam.controllers.simotion.job import JobRead, TableOperation
from beamcam.controllers.step_table import Rows
from beamcam.errors import Diagnostic, Source, VerifyError, errors_in
from beamcam.geometry.array_types import Counts, Floats
from beamcam.machine.machine import Machine
from beamcam.machine.runtime import PROCESSES
from beamcam.machine.tables import Stepper
from beamcam.model.cell_motion import move_seconds, ramp
from beamcam.model.part import Part
from beamcam.model.program import ArcTravel, LiftTorch, SwitchTool, Travel, TriggerOp
from beamcam.motion.speeds import SpeedSection
from beamcam.motion.triggers import operation_seconds, place_behind
from beamcam.simulation import ENDLESS
from beamcam.simulation.cell_trace import ramp_intervals
from beamcam.simulation.trace import (
    UNIFORM,
    Chords,
    State,
    Trace,
    TraceBuilder,
    head_axes,
    phases_of,
)


class Simulated(Struct, frozen=True):
    """A program that ran on the model of its machine."""

    trace: Trace
    diagnostics: tuple[Diagnostic, ...]  #: what is wrong with it by itself
    section: Mapping[str, float] = {}  #: of the bar, as far as the program says it
    kerf_offset: float = 0.0  #: mm that the controller keeps off the path (G41, G42), at most


def simulate_program(
    data: str | bytes, machine: Machine, name: str = "program", style: str = "",
    parts: Sequence[Part] = (),
) -> Simulated:  # fmt: skip
    """The axes of a machine over time while it runs a program.

    `style` is the suffix of a step table; the machine's own where it is none of its forms.
    `parts` say what sheet is cut and what section is sawn, where the program does not.
    Raises VerifyError for a program that cannot be understood, MachineError for a cell or a coper
    without `[[axes]]`.
    """
    if machine.stepper is not None:
        return _steps(data, machine, name, style)
    text = data if isinstance(data, str) else data.decode("utf-8", "replace")
    if machine.stock == "beam":
        return _bar(text, machine, name, parts)
    if machine.stock == "profile":
        from beamcam.controllers import cell_events
        from beamcam.simulation.cell_trace import coper_trace

        events, diagnostics = cell_events(text, machine, name)
        if errors_in(diagnostics):
            raise VerifyError(diagnostics)
        return Simulated(coper_trace(events, machine), tuple(diagnostics))
    if machine.triggers is not None:
        return _triggers(text, machine, name)
    return _sheet(text, machine, name, parts)


def _bar(text: str, machine: Machine, name: str, parts: Sequence[Part]) -> Simulated:
    from beamcam.checks.bars import run
    from beamcam.simulation.cell_trace import bar_trace, motion_segments

    done = run(text, machine, parts[0].profile if parts else None, name)
    section = dict(done.made.section)
    seen = section or ({"width": parts[0].profile.width} if parts else {})
    segments = motion_segments(done.events, done.dialect, seen, machine)
    endless = next((one for one in segments if not isfinite(one.duration_s)), None)
    if endless is not None:
        raise VerifyError((*done.diagnostics, ENDLESS.at(Source(name, endless.line))))
    return Simulated(bar_trace(segments, machine), done.diagnostics, section)


def _sheet(text: str, machine: Machine, name: str, parts: Sequence[Part]) -> Simulated:
    from beamcam.checks.sheets.asked_sheet import rows_of
    from beamcam.checks.sheets.strokes import strokes_of
    from beamcam.controllers import table_run
    from beamcam.simulation.sheets import sheet_trace

    torch = machine.needed(machine.torch, "torch")
    done, diagnostics = table_run(text, machine, name)
    if errors_in(diagnostics):
        raise VerifyError(diagnostics)
    rows = rows_of(parts[0], torch) if parts else torch.rows
    strokes, _ = strokes_of(done, machine, torch, rows, name)
    starts = {stroke.line: (stroke.process, stroke.waits_s) for stroke in strokes.each}
    stops = {done.others[stroke.off][1].line for stroke in strokes.each if stroke.off >= 0}
    offset = max((stroke.radius for stroke in strokes.each if stroke.side), default=0.0)
    return Simulated(
        sheet_trace(done.events(), starts, stops, machine), tuple(diagnostics), kerf_offset=offset
    )


def _triggers(text: str, machine: Machine, name: str) -> Simulated:
    from beamcam.controllers.simotion.job import read_program
    from beamcam.controllers.simotion.rules import SPEED

    job, diagnostics = read_program(text, machine, name)
    if job is None:
        raise VerifyError(diagnostics)
    for op in job.operations:
        if (op.kind == 0 or op.kind >= ARC) and not op.speed > 0.0:  # it would never arrive
            wrong = SPEED.at(
                Source(name, op.line), found=f"{op.speed:g}", what="move", expected="above 0"
            )
            raise VerifyError((*diagnostics, wrong))
    return Simulated(trigger_trace(job, machine), tuple(diagnostics))


def _steps(data: str | bytes, machine: Machine, name: str, style: str) -> Simulated:
    from beamcam.checks.steps import FORMS, VELOCITIES
    from beamcam.checks.steps.velocities import table_rows
    from beamcam.controllers.step_table import Stream, binary_rows, header_rows, text_rows

    stepper = machine.needed(machine.stepper, "stepping motors")
    form = style if style in FORMS else machine.suffix
    stream = Stream((data.encode() if isinstance(data, str) else data,), name)
    builder = TraceBuilder(head_axes(machine), (0.0, 0.0))
    if form == VELOCITIES:
        for row in table_rows(stream, stepper.step):
            way, speed = hypot(*row.way), hypot(*row.velocity)
            if way > 0.0 and speed > 0.0:
                state = LASER if row.laser else State()
                builder.add([way / speed], [row.end], UNIFORM, row.line, state)
        return Simulated(builder.trace(), ())
    rows = {".steps": text_rows, ".bin": binary_rows, ".h": header_rows}[form]
    clock_s = 0.0
    for times, places, lines, laser in _strokes(rows(stream, stepper), stepper):
        knots = _thinned(times, places, SLACK_STEPS * stepper.step)
        seconds = np.diff(times[knots], prepend=clock_s)
        builder.add(seconds, places[knots], UNIFORM, lines[knots], LASER if laser else State())
        clock_s = float(times[-1])
    return Simulated(builder.trace(), ())


# --- table run by triggers: each operation from rest to rest --------------------------------------

# The next operation begins in the cycle behind the one that sees the arrival, as in
# `motion.triggers`, whose times these are.


#: Kinds of operations: along an arc, up and down; 0 is a line, odd ones start a tool, even stop it.
ARC, LIFT = 7, 8


def trigger_trace(job: JobRead, machine: Machine) -> Trace:
    """The head over time, from the corner of the work area on; homing is not in it."""
    triggers = machine.needed(machine.triggers, "trigger program")
    axes = head_axes(machine)
    here = (0.0, 0.0, triggers.home_over(job.thickness))
    over = np.array([0.0, 0.0, job.thickness])  # the axis of the height counts from under the sheet
    builder = TraceBuilder(axes, (here + over)[: len(axes)].tolist())
    state = State()
    for operation in job.operations:
        op = _operation(operation, job)
        whole_s = operation_seconds(op, here, triggers)
        if isinstance(op, SwitchTool):
            state = State(process=op.process if op.on else "")
            builder.wait(whole_s, operation.line, state)
            continue
        end = place_behind(op, here)
        points = [here, end]
        if isinstance(op, ArcTravel):
            arc = circle_points(here[:2], (op.middle_x, op.middle_y), end[:2])
            points = [(*point, end[2]) for point in arc] or points
        corners = (np.array(points) + over)[:, : len(axes)]
        way = _travel(builder, corners, op.speed_mm_s, triggers.acceleration, operation.line, state)
        moving_s = move_seconds(way, op.speed_mm_s, triggers.acceleration)
        builder.wait(max(0.0, whole_s - moving_s), operation.line, state)
        here = end
    return builder.trace()


def _operation(op: TableOperation, job: JobRead) -> TriggerOp:
    if op.kind == 0:
        return Travel(op.x, op.y, op.speed)
    if op.kind == LIFT:
        return LiftTorch(op.height, op.speed)
    if op.kind >= ARC:
        return ArcTravel(op.x, op.y, *(op.via or (op.x, op.y)), op.speed)
    process = PROCESSES[(op.kind - 1) // 2]
    on = op.kind % 2 == 1
    return SwitchTool(process, on, job.pierce_s[process] if on else 0.0)  # type: ignore[arg-type]


def _travel(
    builder: TraceBuilder, corners: Floats, speed_mm_s: float, acceleration: float, line: int,
    state: State,
) -> float:  # fmt: skip
    """Adds a move from rest to rest along corners; its length comes back."""
    lengths = np.sqrt(np.sum(np.diff(corners, axis=0) ** 2, axis=1))
    way = float(np.sum(lengths))
    if not way > 0.0:
        return 0.0
    if len(lengths) > 1:
        lines = np.full(len(lengths), line, dtype=np.int64)
        whole = SpeedSection(speed_mm_s, way, 0, len(lengths), acceleration, inf)
        chords = Chords(corners[:-1], corners[1:], lengths, lines)
        run = phases_of(chords, [whole], (0.0, 0.0))
        builder.add(run.seconds, run.ends, run.slopes, line, state)
        return way
    run_up = ramp(speed_mm_s / way, acceleration / way)
    for begin_s, end_s, *slopes in ramp_intervals(run_up):
        at = corners[0] + run_up.share(end_s) * (corners[1] - corners[0])
        builder.add([end_s - begin_s], [at], slopes, line, state)
    return way


# --- table for stepping motors: its rows carry their own times ------------------------------------

# .csv                velocities: each row at the velocity that its row says
# .steps .bin .h      steps one by one: sampled at equal times, then thinned out; the straight
#                     lines that are left pass within a step of every row


SAMPLE_S = 0.005
MICROSECONDS = 1e6
SLACK_STEPS = 1.0  #: of the thinned lines from the samples; less keeps the jitter of whole steps
LASER = State(process="cut")


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
            # The last row of each slot of time, and the last one of all.
            slot = np.floor(times[part] / SAMPLE_S)
            kept = part[np.flatnonzero(np.append(np.diff(slot) > 0.0, True))]
            at = places[kept] * stepper.step
            yield times[kept], at, rows.first + kept, bool(rows.laser[part[0]])


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
