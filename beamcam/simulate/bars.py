"""The trace of a bar's program: each stretch of the cell cut where its jerk changes."""

from collections.abc import Iterator, Sequence

from beamcam.geometry.ramps import Ramp
from beamcam.machine.machine import Machine
from beamcam.simulate.course import CourseSection
from beamcam.simulate.trace import UNIFORM, Trace, TraceAxis, TraceBuilder


def bar_trace(course: Sequence[CourseSection], machine: Machine) -> Trace:
    """The axes of a cell over time."""
    builder = TraceBuilder(cell_axes(machine), [axis.park for axis in machine.axes])
    for part in course:
        if part.duration_s == 0.0 and part.start == part.end:
            continue
        if part.start == part.end or not part.ramp.duration_s:
            builder.add([part.duration_s], [part.end], UNIFORM, part.line, part.state)
            continue
        rows = list(ramp_intervals(part.ramp))
        ends = [part.at(part.begin_s + until_s) for _, until_s, _, _ in rows]
        ends[-1] = part.end
        builder.add(
            [until_s - from_s for from_s, until_s, _, _ in rows],
            ends,
            [slopes for _, _, *slopes in rows],
            part.line,
            part.state,
        )
    return builder.trace()


def cell_axes(machine: Machine) -> tuple[TraceAxis, ...]:
    """The axes of a cell, in the order of the controller's registers."""
    return tuple(
        TraceAxis(a.name, "deg" if a.moves == "angle" else "mm", a.min, a.max) for a in machine.axes
    )


def ramp_intervals(ramp: Ramp) -> Iterator[tuple[float, float, float, float]]:
    """Begin, end and slopes of each phase of constant jerk that takes time."""
    jerk_s, steady_s = ramp.jerk_s, ramp.steady_s
    gained = ramp.acceleration * jerk_s / 2
    rise = [(jerk_s, gained), (steady_s, gained + ramp.acceleration * steady_s),
            (jerk_s, ramp.speed)]  # fmt: skip
    speeds = [0.0, *(speed for _, speed in rise)]
    lasts = [seconds for seconds, _ in rise]
    begin, before = 0.0, 0.0
    for seconds, speed in zip(
        (*lasts, ramp.cruise_s, *reversed(lasts)), (*speeds[1:], ramp.speed, *speeds[2::-1]),
        strict=True,
    ):  # fmt: skip
        if seconds > 0.0:
            way = ramp.share(begin + seconds) - ramp.share(begin)
            scale = seconds / way if way > 0.0 else 0.0
            yield begin, begin + seconds, before * scale, speed * scale
            begin += seconds
        before = speed
