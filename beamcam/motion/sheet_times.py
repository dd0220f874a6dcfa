"""Run time of a program on a cutting table, from the look-ahead over its moves.

    traverse            from rest to rest, as fast as the axes go
    tool on             its wait to pierce
    moves of a contour  from rest to rest, through corners as fast as `corner` allows

Lines, arcs, parabolas and ellipses are segments as they are, no chords: each has the feed that the
axes can follow and a junction to the next. Where the machine's file has no axes, all is passed at
full speed.
"""

from collections.abc import Iterator, Sequence
from math import cbrt, cos, dist, hypot, inf, radians, sqrt

from msgspec import Struct

from beamcam.geometry.curves import Line
from beamcam.geometry.moves import move_seconds, stretch_seconds
from beamcam.geometry.plane import Point
from beamcam.machine.machine import Machine
from beamcam.machine.path_limits import PathLimits, path_limits
from beamcam.model.plan import SheetPlan
from beamcam.model.program import (
    ArcFeed,
    EllipseFeed,
    Feed,
    Movement,
    Pace,
    ParabolaFeed,
    Program,
    ToolOff,
    ToolOn,
    Traverse,
)
from beamcam.model.work_time import WorkTime
from beamcam.motion.curves_of_moves import curve_of
from beamcam.motion.feed_limits import feasible_mm_s
from beamcam.motion.lookahead import joint_speeds
from beamcam.motion.speed_sections import SpeedSection, join_segments

SECONDS_PER_MINUTE = 60.0
HOME: Point = (0.0, 0.0)

#: A kink of less than this is passed as if it were none: what rounding leaves of a tangent.
SMOOTH_COS = cos(radians(1.0))


class Segment(Struct, frozen=True):
    """A move as the look-ahead sees it."""

    length: float
    speed_mm_s: float
    acceleration_mm_s2: float
    enters: Point  #: direction, of length 1
    leaves: Point


def program_time(plan: SheetPlan, program: Program, machine: Machine) -> WorkTime:
    """Run time of a plan's program by operation, each with the traverse to it."""
    passes = _passes(program, machine)
    operations = tuple(sum(next(passes) for _ in op.passes) for op in plan.operations)
    return WorkTime(operations, 0.0, sum(passes))


def _passes(program: Program, machine: Machine) -> Iterator[float]:
    """Seconds of each pass with the traverse before it, and of the return home."""
    limits = path_limits(machine)
    rapid = machine.needed(machine.torch, "torch").traverse_mm_min / SECONDS_PER_MINUTE
    here, seconds, feed = HOME, 0.0, 0.0
    segments: list[Segment] = []
    for command in program.commands:
        match command:
            case Traverse():
                seconds += _traverse_seconds(here, (command.x, command.y), rapid, limits)
                here = command.x, command.y
            case ToolOn():
                feed = command.feed_mm_min / SECONDS_PER_MINUTE
                seconds += command.pierce_s
            case Pace():
                feed = command.feed_mm_min / SECONDS_PER_MINUTE
            case Feed() | ArcFeed() | ParabolaFeed() | EllipseFeed():
                segment = segment_of(here, command, feed, limits)
                if segment is not None:
                    segments.append(segment)
                here = command.x, command.y
            case ToolOff():
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
    curve = curve_of(here, move)
    length = curve.length
    if length == 0.0:
        return None
    enters, leaves = curve.tangent(0.0), curve.tangent(1.0)
    if limits is None:
        return Segment(length, feed_mm_s, inf, enters, leaves)
    speed = min(feed_mm_s, feasible_mm_s(here, move, limits))
    straight = isinstance(curve, Line)
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
        [s.length for s in segments],
        [s.speed_mm_s for s in segments],
        junctions,
        [s.acceleration_mm_s2 for s in segments],
        [limits.jerk_mm_s3] * count,
    )
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
