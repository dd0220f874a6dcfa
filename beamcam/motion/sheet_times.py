"""Run time of a program on a cutting table, from the look-ahead over its moves.

    traverse            from rest to rest, as fast as the axes go
    tool on             its waits to preheat and to pierce
    moves of a contour  from rest to rest, through corners as fast as `corner` allows

Lines, arcs, parabolas and ellipses are segments as they are, no chords: each has the feed that the
axes can follow and a junction to the next. Where the machine's file has no axes, all is passed at
full speed.
"""

from collections.abc import Callable, Iterable, Iterator, Sequence
from math import atan2, cos, degrees, hypot, inf, isfinite, radians, sin
from typing import cast, get_args

import numpy as np
from msgspec import Struct

from beamcam.controllers.events import Lift, Pause, TableEvent, Touch
from beamcam.geometry.array_types import Counts, Floats
from beamcam.geometry.arrays import rows, unit_vectors
from beamcam.geometry.curves import Bezier, EllipseArc
from beamcam.geometry.plane import Point
from beamcam.machine.machine import Machine, PathLimits, path_limits
from beamcam.model.cell_motion import move_seconds
from beamcam.model.plan import SheetPlan, WorkTime
from beamcam.model.program import (
    ArcFeed,
    EllipseFeed,
    Feed,
    Movement,
    ParabolaFeed,
    PassEnd,
    Program,
    SetFeed,
    ToolOff,
    ToolOn,
    Traverse,
)
from beamcam.motion.speeds import (
    SpeedSection,
    join_segments,
    joint_speeds,
    min_radius,
    straight_mm_s,
    stretch_seconds,
    turning_mm_s,
)

SECONDS_PER_MINUTE = 60.0
HOME: Point = (0.0, 0.0)

MOVEMENTS = frozenset(get_args(Movement))

#: A kink of less than this is passed as if it were none: what rounding leaves of a tangent.
SMOOTH_COS = cos(radians(1.0))


class Segments(Struct, frozen=True):
    """Moves as the look-ahead sees them: those of many moves that go somewhere, as arrays (n,)."""

    places: Counts  #: among the moves
    lengths: Floats
    speeds_mm_s: Floats
    accelerations_mm_s2: Floats
    enters: Floats  #: directions (n, 2), of length 1
    leaves: Floats


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
    here, feed = HOME, 0.0
    waits = [0.0]  # the last pass is the one that goes on
    starts: list[Point] = []
    moves: list[Movement] = []
    feeds: list[float] = []
    passes: list[int] = []
    traverses: list[tuple[Point, Point, int]] = []
    for command in program.commands:
        if type(command) in MOVEMENTS:
            move = cast(Movement, command)
            starts.append(here)
            moves.append(move)
            feeds.append(feed)
            passes.append(len(waits) - 1)
            here = move.x, move.y
            continue
        match command:
            case Traverse():
                end = command.x, command.y
                traverses.append((here, end, len(waits) - 1))
                here = end
            case ToolOn():
                feed = command.feed_mm_min / SECONDS_PER_MINUTE
                own = command.preheat_s + command.pierce_s
                waits[-1] += own if standing is None else standing(command)
            case SetFeed():
                feed = command.feed_mm_min / SECONDS_PER_MINUTE
            case ToolOff() | PassEnd():
                waits.append(0.0)
    traverses.append((here, HOME, len(waits) - 1))
    times = [_traverse_seconds(traverses, machine)]
    limits = path_limits(machine)
    if moves:  # a pass runs from rest to rest
        segments = segments_of(starts, moves, feeds, limits)
        owners = np.array(passes)[segments.places]
        if limits is None:
            times.append((owners, segments.lengths / segments.speeds_mm_s))
        else:
            moving, speeds = speeds_along(segments, owners, limits)
            times.append((owners[[s.first for s in moving]], section_seconds(moving, speeds)))
    seconds = np.array(waits)
    for owners, spent in times:
        seconds += np.bincount(owners, spent, len(waits))
    return by_operation(plan, iter(seconds.tolist()))


def by_operation(plan: SheetPlan, passes: Iterator[float]) -> WorkTime:
    """Run time of a plan by the seconds of its passes, and of what comes behind them."""
    operations = tuple(sum(next(passes) for _ in op.passes) for op in plan.operations)
    return WorkTime(operations, 0.0, sum(passes))


def _traverse_seconds(
    traverses: Sequence[tuple[Point, Point, int]], machine: Machine
) -> tuple[Counts, Floats]:
    """The pass of each traverse, and its seconds from rest to rest."""
    limits = path_limits(machine)
    rapid = machine.needed(machine.torch, "torch").traverse_mm_min / SECONDS_PER_MINUTE
    steps = rows([(b[0] - a[0], b[1] - a[1]) for a, b, _ in traverses], 2)
    ways = np.hypot(steps[:, 0], steps[:, 1])
    owners = np.array([owner for _, _, owner in traverses])
    if limits is None:
        return owners, ways / rapid
    speeds = np.minimum(rapid, straight_mm_s(steps, limits))
    times = [
        move_seconds(way, speed, limits.straight_mm_s2, limits.jerk_mm_s3)
        for way, speed in zip(ways.tolist(), speeds.tolist(), strict=True)
    ]
    return owners, np.array(times)


def segments_of(
    starts: Sequence[Point], moves: Sequence[Movement], feeds_mm_s: Sequence[float],
    limits: PathLimits | None,
) -> Segments:  # fmt: skip
    """Moves and the places that they start at, at their feeds or as fast as the axes follow."""
    steps = rows([(move.x, move.y) for move in moves], 2) - rows(starts, 2)
    lengths = np.hypot(steps[:, 0], steps[:, 1])
    enters = steps / np.where(lengths > 0.0, lengths, 1.0)[:, None]
    leaves = enters.copy()
    radii = np.full(len(moves), inf)
    arcs = [(k, move) for k, move in enumerate(moves) if type(move) is ArcFeed]
    at = np.array([k for k, _ in arcs], dtype=np.int64)
    centre = rows([(arc.i, arc.j) for _, arc in arcs], 2)
    turn = np.array([-1.0 if arc.clockwise else 1.0 for _, arc in arcs])
    radii[at] = np.hypot(centre[:, 0], centre[:, 1])
    angles = [np.degrees(np.arctan2(out[:, 1], out[:, 0])) for out in (-centre, steps[at] - centre)]
    sweeps = np.mod(turn * (angles[1] - angles[0]), 360.0)
    sweeps[~np.any(steps[at], axis=1)] = 360.0  # one that ends where it starts is a circle
    lengths[at] = radii[at] * np.radians(sweeps)
    enters[at], leaves[at] = (turn[:, None] * unit_vectors(angle + 90.0) for angle in angles)
    lines_and_arcs = Feed, ArcFeed
    for k in [k for k, move in enumerate(moves) if type(move) not in lines_and_arcs]:
        move = cast("ParabolaFeed | EllipseFeed", moves[k])
        curve = curve_of(starts[k], move)
        lengths[k], radii[k] = curve.length, min_radius(starts[k], move)
        enters[k], leaves[k] = curve.tangent(0.0), curve.tangent(1.0)
    speeds = np.array(feeds_mm_s, dtype=np.float64)
    accelerations = np.full(len(moves), inf)
    if limits is not None:
        straight = radii == inf
        turning = turning_mm_s(radii, limits)
        speeds = np.minimum(speeds, np.where(straight, straight_mm_s(steps, limits), turning))
        accelerations = np.where(straight, limits.straight_mm_s2, limits.along_mm_s2)
    at = np.flatnonzero(lengths > 0.0)
    return Segments(at, lengths[at], speeds[at], accelerations[at], enters[at], leaves[at])


def speeds_along(
    segments: Segments, passes: Counts, limits: PathLimits
) -> tuple[list[SpeedSection], list[float]]:
    """The sections of segments, and the speeds at their joints: rest between two passes."""
    if not len(passes):
        return [], [0.0]
    junctions = _junctions_mm_s(segments, limits)
    junctions[passes[1:] != passes[:-1]] = 0.0
    jerks = np.full(len(passes), limits.jerk_mm_s3)
    sections = join_segments(
        segments.lengths, segments.speeds_mm_s, np.concatenate(([0.0], junctions, [0.0])),
        segments.accelerations_mm_s2, jerks,
    )  # fmt: skip
    return joint_speeds(sections)


def section_seconds(moving: Sequence[SpeedSection], speeds: Sequence[float]) -> Floats:
    """How long sections take with the speeds at their joints, which are one more."""
    ways = rows([(s.length, s.limit, s.acceleration, s.jerk) for s in moving], 4).T
    ends = np.array(speeds)
    return stretch_seconds(ways[0], ends[:-1], ends[1:], *ways[1:])


def _junctions_mm_s(segments: Segments, limits: PathLimits) -> Floats:
    """Greatest speeds (n - 1,) from each segment into the next.

    Around a corner: that of a circle `corner` from it (grbl), and one at which the turn is made
    within half of both segments (Klipper): what limits a curve that was drawn in short lines.
    """
    lengths, speeds = segments.lengths, segments.speeds_mm_s
    least = np.minimum(speeds[:-1], speeds[1:])
    cosine = np.einsum("ij,ij->i", segments.leaves[:-1], segments.enters[1:])
    smooth = cosine >= SMOOTH_COS
    if limits.corner == 0.0:
        return np.where(smooth, least, 0.0)
    whole = hypot(limits.along_mm_s2, limits.across_mm_s2)
    half_sine = np.sqrt(np.maximum(0.0, 1.0 + cosine) / 2)
    half_cosine = np.sqrt((1.0 - np.where(smooth, 0.0, cosine)) / 2)
    corner = whole * limits.corner * half_sine * (1.0 + half_sine) / half_cosine**2
    short = np.minimum(lengths[:-1], lengths[1:])
    spread = 0.5 * short * half_sine / half_cosine * limits.across_mm_s2
    by_jerk = np.cbrt(limits.jerk_mm_s3 * (short / (2.0 * half_cosine)) ** 2)
    turned = np.minimum(np.sqrt(np.minimum(corner, spread)), by_jerk)
    return np.where(smooth, least, np.minimum(least, turned))


def curve_of(here: Point, move: ParabolaFeed | EllipseFeed) -> Bezier | EllipseArc:
    """The curve of a move that starts `here`; an ellipse that ends where it starts is whole."""
    end = move.x, move.y
    if isinstance(move, ParabolaFeed):
        vertex = here[0] + move.i, here[1] + move.j
        control = tuple(2 * v - (a + b) / 2 for v, a, b in zip(vertex, here, end, strict=True))
        return Bezier((here, (control[0], control[1]), end))
    centre = here[0] + move.i, here[1] + move.j
    c, s = cos(radians(move.angle)), sin(radians(move.angle))

    def eccentric(point: Point) -> Point:
        """The place in the circle that the ellipse is the image of."""
        x, y = point[0] - centre[0], point[1] - centre[1]
        return c * x + s * y, (c * y - s * x) / move.ratio

    (ax, ay), (bx, by) = eccentric(here), eccentric(end)
    first, last = degrees(atan2(ay, ax)), degrees(atan2(by, bx))
    major, sign = hypot(ax, ay), -1.0 if move.clockwise else 1.0
    sweep = sign * (360.0 if here == end else sign * (last - first) % 360.0)
    return EllipseArc(centre, (major * c, major * s), move.ratio, first, sweep)


class LiftTimes:
    """The height of a torch while its program runs, and how long its moves take.

    It begins at the clearance. At a height that nothing says, and at the top of its axis, it counts
    as there too.
    """

    def __init__(self, machine: Machine) -> None:
        torch = machine.needed(machine.torch, "torch")
        self.height = self._clearance = torch.clearance
        self._rapid_mm_min = torch.traverse_mm_min
        self._axis = next((axis for axis in machine.axes if axis.moves == "Z"), None)

    def seconds(self, event: Lift | Touch) -> float:
        """How long a move takes; the torch is where it ends."""
        height = event.height if isinstance(event, Touch) else event.end
        height = height if isfinite(height) else self._clearance
        is_fed = not (isinstance(event, Lift) and event.rapid) and event.feed_mm_min > 0.0
        speed = (event.feed_mm_min if is_fed else self._rapid_mm_min) / SECONDS_PER_MINUTE
        way, self.height = abs(height - self.height), height
        if self._axis is None:
            return way / speed
        jerk = inf if self._axis.jerk is None else self._axis.jerk
        return move_seconds(way, min(speed, self._axis.speed), self._axis.acceleration, jerk)


def standing_seconds(events: Iterable[TableEvent], machine: Machine) -> float:
    """How long the head stands for some events: moves of the torch in Z, and pauses."""
    times = LiftTimes(machine)
    return sum(
        event.seconds if isinstance(event, Pause) else times.seconds(event)
        for event in events
        if isinstance(event, Pause | Lift | Touch)
    )
