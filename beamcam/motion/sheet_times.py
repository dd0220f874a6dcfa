"""Run time of a program on a cutting table, from the look-ahead over its moves.

    traverse            from rest to rest, as fast as the axes go
    tool on             its waits to preheat and to pierce
    moves of a contour  from rest to rest, through corners as fast as `corner` allows

Lines, arcs, parabolas and ellipses are segments as they are, no chords: each has the feed that the
axes can follow and a junction to the next. Where the machine's file has no axes, all is passed at
full speed.
"""

from collections.abc import Callable, Iterator, Sequence
from math import asin, atan2, cbrt, ceil, cos, degrees, dist, hypot, inf, radians, sin, sqrt

from msgspec import Struct

from beamcam.geometry.curves import Arc, Bezier, EllipseArc, Line
from beamcam.geometry.plane import Point, cross
from beamcam.geometry.ramps import move_seconds, stretch_seconds
from beamcam.machine.machine import Machine, PathLimits, path_limits
from beamcam.machine.tables import Triggers
from beamcam.model.plan import SheetPlan, WorkTime
from beamcam.model.program import (
    ArcFeed,
    ArcTravel,
    EllipseFeed,
    Feed,
    LiftTorch,
    Movement,
    ParabolaFeed,
    PassEnd,
    Program,
    SetFeed,
    SwitchTool,
    ToolOff,
    ToolOn,
    Traverse,
    TriggerOp,
    TriggerTable,
)
from beamcam.motion.feed_limits import feasible_mm_s
from beamcam.motion.lookahead import SpeedSection, join_segments, joint_speeds
from beamcam.motion.step_events import MICROSECONDS
from beamcam.motion.steps import plan_way, ways

SECONDS_PER_MINUTE = 60.0
HOME: Point = (0.0, 0.0)

#: A kink of less than this is passed as if it were none: what rounding leaves of a tangent.
SMOOTH_COS = cos(radians(1.0))


class Segment(Struct, frozen=True, gc=False):
    """A move as the look-ahead sees it."""

    length: float
    speed_mm_s: float
    acceleration_mm_s2: float
    enters: Point  #: direction, of length 1
    leaves: Point


def program_time(
    plan: SheetPlan,
    program: Program,
    machine: Machine,
    standing: Callable[[ToolOn], float] | None = None,
) -> WorkTime:
    """Run time of a plan's program by operation, each with the traverse to it.

    `standing` says how long the head stands while a tool is started and stopped, where that is more
    than its waits to preheat and to pierce.
    """
    return by_operation(plan, _passes(program, machine, standing))


def by_operation(plan: SheetPlan, passes: Iterator[float]) -> WorkTime:
    """Run time of a plan by the seconds of its passes, and of what comes behind them."""
    operations = tuple(sum(next(passes) for _ in op.passes) for op in plan.operations)
    return WorkTime(operations, 0.0, sum(passes))


def _passes(
    program: Program, machine: Machine, standing: Callable[[ToolOn], float] | None = None
) -> Iterator[float]:
    """Seconds of each pass with the traverse before it, and of the return home."""
    limits = path_limits(machine)
    rapid = machine.needed(machine.torch, "torch").traverse_mm_min / SECONDS_PER_MINUTE
    here, seconds, feed = HOME, 0.0, 0.0
    segments: list[Segment] = []
    for command in program.commands:
        match command:
            case Feed() | ArcFeed() | ParabolaFeed() | EllipseFeed():
                segment = segment_of(here, command, feed, limits)
                if segment is not None:
                    segments.append(segment)
                here = command.x, command.y
            case Traverse():
                seconds += _traverse_seconds(here, (command.x, command.y), rapid, limits)
                here = command.x, command.y
            case ToolOn():
                feed = command.feed_mm_min / SECONDS_PER_MINUTE
                waits = command.preheat_s + command.pierce_s
                seconds += waits if standing is None else standing(command)
            case SetFeed():
                feed = command.feed_mm_min / SECONDS_PER_MINUTE
            case ToolOff() | PassEnd():
                yield seconds + seconds_along(segments, limits)
                seconds, segments = 0.0, []
    yield seconds + _traverse_seconds(here, HOME, rapid, limits)


def _traverse_seconds(start: Point, end: Point, rapid: float, limits: PathLimits | None) -> float:
    if limits is None:
        return dist(start, end) / rapid
    speed = min(rapid, feasible_mm_s(start, Feed(*end), limits))
    return move_seconds(dist(start, end), speed, limits.straight_mm_s2, limits.jerk_mm_s3)


def segment_of(
    here: Point, move: Movement, feed_mm_s: float, limits: PathLimits | None
) -> Segment | None:
    """A move that starts `here`; None if it goes nowhere."""
    straight = type(move) is Feed
    if straight:
        x, y = move.x - here[0], move.y - here[1]
        length = hypot(x, y)
        enters = leaves = (x / length, y / length) if length else (1.0, 0.0)
    else:
        curve = curve_of(here, move)
        length, enters, leaves = curve.length, curve.tangent(0.0), curve.tangent(1.0)
    if length == 0.0:
        return None
    if limits is None:
        return Segment(length, feed_mm_s, inf, enters, leaves)
    speed = min(feed_mm_s, feasible_mm_s(here, move, limits))
    along = limits.straight_mm_s2 if straight else limits.along_mm_s2
    return Segment(length, speed, along, enters, leaves)


def seconds_along(segments: Sequence[Segment], limits: PathLimits | None) -> float:
    """Time from rest to rest along segments that follow one another."""
    if not segments:
        return 0.0
    if limits is None:
        return sum(s.length / s.speed_mm_s for s in segments)
    moving, speeds = speeds_along(segments, limits)
    return sum(
        stretch_seconds(s.length, first, last, s.limit, s.acceleration, s.jerk)
        for s, first, last in zip(moving, speeds, speeds[1:], strict=False)
    )


def speeds_along(
    segments: Sequence[Segment], limits: PathLimits
) -> tuple[list[SpeedSection], list[float]]:
    """The stretches of segments that follow one another, and the speeds at their joints."""
    count = len(segments)
    junctions = [0.0, *(_junction_mm_s(segments, k, limits) for k in range(1, count)), 0.0]
    stretches = join_segments(
        [s.length for s in segments], [s.speed_mm_s for s in segments], junctions,
        [s.acceleration_mm_s2 for s in segments], [limits.jerk_mm_s3] * count,
    )  # fmt: skip
    return joint_speeds(stretches)


def _junction_mm_s(segments: Sequence[Segment], index: int, limits: PathLimits) -> float:
    """Greatest speed from the segment before `index` into that one.

    Around a corner: that of a circle `corner` from it (grbl), and one at which the turn is made
    within half of both segments (Klipper): what limits a curve that was drawn in short lines.
    """
    before, after = segments[index - 1], segments[index]
    least = min(before.speed_mm_s, after.speed_mm_s)
    (ax, ay), (bx, by) = before.leaves, after.enters
    cosine = ax * bx + ay * by
    if cosine >= SMOOTH_COS:
        return least
    if limits.corner == 0.0:
        return 0.0
    whole = hypot(limits.along_mm_s2, limits.across_mm_s2)
    half_sine = sqrt(max(0.0, 1.0 + cosine) / 2)
    half_cosine = sqrt((1.0 - cosine) / 2)
    corner = whole * limits.corner * half_sine * (1.0 + half_sine) / half_cosine**2
    short = min(before.length, after.length)
    spread = 0.5 * short * half_sine / half_cosine * limits.across_mm_s2
    by_jerk = cbrt(limits.jerk_mm_s3 * (short / (2.0 * half_cosine)) ** 2)
    return min(least, sqrt(min(corner, spread)), by_jerk)


def curve_of(here: Point, move: Movement) -> Line | Arc | Bezier | EllipseArc:
    """The curve of a move that starts `here`; an arc that ends where it starts is a circle."""
    end = move.x, move.y
    match move:
        case Feed():
            return Line(here, end)
        case ArcFeed(i=i, j=j, clockwise=clockwise):
            centre = here[0] + i, here[1] + j
            first = degrees(atan2(-j, -i))
            last = degrees(atan2(end[1] - centre[1], end[0] - centre[0]))
            return Arc(centre, hypot(i, j), first, _sweep_deg(here, end, first, last, clockwise))
        case ParabolaFeed(i=i, j=j):
            vertex = here[0] + i, here[1] + j
            control = tuple(2 * v - (a + b) / 2 for v, a, b in zip(vertex, here, end, strict=True))
            return Bezier((here, (control[0], control[1]), end))
        case EllipseFeed():
            return _ellipse(here, end, move)


def _ellipse(here: Point, end: Point, move: EllipseFeed) -> EllipseArc:
    centre = here[0] + move.i, here[1] + move.j
    c, s = cos(radians(move.angle)), sin(radians(move.angle))

    def eccentric(point: Point) -> tuple[float, float]:
        """The place in the circle that the ellipse is the image of."""
        x, y = point[0] - centre[0], point[1] - centre[1]
        return c * x + s * y, (c * y - s * x) / move.ratio

    (ax, ay), (bx, by) = eccentric(here), eccentric(end)
    first, last = degrees(atan2(ay, ax)), degrees(atan2(by, bx))
    major = hypot(ax, ay)
    sweep = _sweep_deg(here, end, first, last, move.clockwise)
    return EllipseArc(centre, (major * c, major * s), move.ratio, first, sweep)


def _sweep_deg(start: Point, end: Point, first: float, last: float, clockwise: bool) -> float:
    if start == end:
        return -360.0 if clockwise else 360.0
    if clockwise:
        return -((first - last) % 360.0)
    return (last - first) % 360.0


# --- table times ----------------------------------------------------------------------------------

# Run times of tables without G-code: chains of triggers, and step tables.


HeadPlace = tuple[float, float, float]  #: X, Y, and the height over the sheet

CYCLE_SLACK = 1e-9


def trigger_time(plan: SheetPlan, table: TriggerTable, machine: Machine) -> WorkTime:
    """Run time of a chain of triggers, from the corner of the work area and back to it.

    Each operation runs from rest to rest; the next begins in the cycle behind the one that sees
    its arrival. Homing is not included, as its start position is unknown.
    """
    return by_operation(
        plan, _table_passes(table, machine.needed(machine.triggers, "trigger program"))
    )


def _table_passes(table: TriggerTable, triggers: Triggers) -> Iterator[float]:
    """Seconds of each pass with the traverse to it, and of the return home."""
    here, seconds = (0.0, 0.0, triggers.home_over(table.thickness)), 0.0
    for op in table.operations:
        seconds += operation_seconds(op, here, triggers)
        here = place_behind(op, here)
        if isinstance(op, SwitchTool) and not op.on:
            yield seconds
            seconds = 0.0
    yield seconds


def length_through(start: Point, middle: Point, end: Point) -> float:
    """Length of the arc through three points, neither half of it above half a circle."""
    a, b, c = dist(start, middle), dist(middle, end), dist(start, end)
    to_middle = middle[0] - start[0], middle[1] - start[1]
    twice_area = abs(cross(to_middle, (end[0] - start[0], end[1] - start[1])))
    if twice_area <= 1e-12 * c * c:
        return a + b
    radius = a * b * c / (2 * twice_area)
    return 2 * radius * sum(asin(min(1.0, chord / (2 * radius))) for chord in (a, b))


def place_behind(op: TriggerOp, here: HeadPlace) -> HeadPlace:
    """Where an operation that starts `here` ends."""
    if isinstance(op, LiftTorch):
        return *here[:2], op.height
    return here if isinstance(op, SwitchTool) else (op.x, op.y, here[2])


def operation_seconds(op: TriggerOp, here: HeadPlace, triggers: Triggers) -> float:
    """Seconds from an operation that starts `here` to the start of the next one."""
    cycles = ceil(_seconds(op, here, triggers) / triggers.cycle_s - CYCLE_SLACK) + 1
    return cycles * triggers.cycle_s


def _seconds(op: TriggerOp, here: HeadPlace, triggers: Triggers) -> float:
    if isinstance(op, SwitchTool):
        return op.wait_s
    way = dist(here, place_behind(op, here))
    if isinstance(op, ArcTravel):
        way = length_through(here[:2], (op.middle_x, op.middle_y), (op.x, op.y))
    return move_seconds(way, op.speed_mm_s, triggers.acceleration)


def step_time(plan: SheetPlan, machine: Machine) -> WorkTime:
    """Run time of a step table: until its last step, and the standstill after it.

    Each way is planned by the look-ahead, from rest to rest, as for the rows themselves.
    """
    return by_operation(plan, _way_passes(plan, machine))


def _way_passes(plan: SheetPlan, machine: Machine) -> Iterator[float]:
    """Seconds of each pass with the way to it, and of the return home."""
    stepper = machine.needed(machine.stepper, "stepping motors")
    rest_us = int(2 * MICROSECONDS / stepper.max_hz) + 1
    microseconds = 0
    for way in ways(plan, machine):
        waits = round(way.wait_s * MICROSECONDS) if way.laser else 0
        moves = ceil(plan_way(way, stepper).duration_s * MICROSECONDS)
        microseconds += waits + moves + 2 * rest_us
        if way.laser:
            yield microseconds / MICROSECONDS
            microseconds = 0
    yield microseconds / MICROSECONDS
