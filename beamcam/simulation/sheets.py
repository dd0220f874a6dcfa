"""The trace of a cutting table that runs G-code: the look-ahead over what was read back.

The times are those of `motion.sheet_times`, which `plan` gives too: traverses and contours run from
rest to rest, a contour passes its corners as fast as the machine's file allows. A torch that the
program moves up and down is at a height besides, over the sheet; at one that nothing says, and at
the top of its axis, it counts as clear of the sheet by `torch.clearance`.
"""

from collections.abc import Collection, Mapping, Sequence
from math import isnan

import numpy as np
from msgspec import Struct

from beamcam.controllers.events import HeadMove, Lift, Move, Pause, Switch, TableEvent, Touch
from beamcam.geometry.array_types import Counts
from beamcam.geometry.curves import Arc, Bezier, Curve, EllipseArc, Line
from beamcam.geometry.plane import Point
from beamcam.geometry.polylines import polylines
from beamcam.machine.machine import Machine, path_limits
from beamcam.model.program import ArcFeed, EllipseFeed, Feed, Movement, ParabolaFeed
from beamcam.motion.sheet_times import (
    SECONDS_PER_MINUTE,
    LiftTimes,
    Segments,
    segments_of,
    speeds_along,
)
from beamcam.motion.speeds import SpeedSection
from beamcam.simulation.trace import (
    UNIFORM,
    Chords,
    Phases,
    State,
    Trace,
    TraceBuilder,
    head_axes,
    phases_of,
)

#: Of the chords that stand for a curve in a trace.
CHORD_TOLERANCE = 0.02


def sheet_trace(
    events: Sequence[TableEvent],
    starts: Mapping[int, tuple[str, float]],
    stops: Collection[int],
    machine: Machine,
) -> Trace:
    """The head over time.

    `starts` says which process the word of a line starts, and how long the controller then waits;
    `stops` are the lines of the words that stop one.
    """
    head = _HeadPath(machine)
    path: list[HeadMove] = []
    for event in events:
        if isinstance(event, Move) and not event.rapid:
            path.append(event)
        elif isinstance(event, Move | Pause | Switch | Lift | Touch):
            head.follow(path)
            path = []
            if isinstance(event, Move):
                head.follow([event])
            elif isinstance(event, Pause):
                head.steps.append(_Stand(event.seconds, event.line, head.state))
            elif isinstance(event, Lift | Touch):
                head.lift(event)
            elif event.line in starts:
                process, waits_s = starts[event.line]
                head.state = State(process=process)
                head.steps.append(_Stand(waits_s, event.line, head.state))
            elif event.line in stops:
                head.state = State()
    head.follow(path)
    return head.trace()


class _Stand(Struct, frozen=True):
    """The head where it is, the torch at rest or going up or down."""

    seconds: float
    line: int
    state: State
    height: float | None = None  #: where the torch ends, if it moves


class _Path(Struct, frozen=True):
    """The head moves from rest to rest."""

    first: int  #: of its moves
    last: int  #: behind the last of them
    state: State


class _HeadPath:
    """The way of the head, gathered first so that all of it is timed at once."""

    def __init__(self, machine: Machine) -> None:
        self.machine = machine
        self.limits = path_limits(machine)
        self.rapid_mm_min = machine.needed(machine.torch, "torch").traverse_mm_min
        self.state = State()
        self.here: Point = (0.0, 0.0)  #: a program begins in the corner of the table
        self.curves: list[Curve] = []
        self.starts: list[Point] = []
        self.moves: list[Movement] = []
        self.feeds_mm_s: list[float] = []
        self.lines: list[int] = []
        self.steps: list[_Stand | _Path] = []
        torch = machine.needed(machine.torch, "torch")
        self.lifts, self.clearance = torch.z == "program", torch.clearance
        self.lifting = LiftTimes(machine)

    def follow(self, legs: Sequence[HeadMove]) -> None:
        """Moves from rest to rest."""
        first = len(self.moves)
        for leg in legs:
            start = self.here if isnan(leg.start[0]) or isnan(leg.start[1]) else leg.start
            feed = self.rapid_mm_min if leg.rapid or not leg.feed_mm_min else leg.feed_mm_min
            self.curves.append(leg.curve or Line(start, leg.end))
            self.starts.append(start)
            self.moves.append(_movement(leg, start))
            self.feeds_mm_s.append(feed / SECONDS_PER_MINUTE)
            self.lines.append(leg.line)
            self.here = leg.end
        if len(self.moves) > first:
            self.steps.append(_Path(first, len(self.moves), self.state))

    def lift(self, event: Lift | Touch) -> None:
        """The torch up or down, or to the sheet; one axis from rest to rest."""
        seconds = self.lifting.seconds(event)
        self.steps.append(_Stand(seconds, event.line, self.state, self.lifting.height))

    def trace(self) -> Trace:
        """All of it."""
        height = (self.clearance,) if self.lifts else ()
        builder = TraceBuilder(head_axes(self.machine), (0.0, 0.0, *height))
        segments = segments_of(self.starts, self.moves, self.feeds_mm_s, self.limits)
        if not len(segments.places):
            return builder.trace()
        chords, firsts = self._chords(segments)
        if self.limits is None:  # each segment at its full speed
            seconds = chords.lengths / np.repeat(segments.speeds_mm_s, np.diff(firsts))
            count = len(seconds)
            run = Phases(np.arange(count), seconds, chords.ends, np.ones((count, 2)))
        else:
            # The look-ahead over the segments of all paths; each move has the number of its path.
            sizes = [step.last - step.first for step in self.steps if isinstance(step, _Path)]
            paths = np.repeat(np.arange(len(sizes)), sizes)[segments.places]
            moving, joints = speeds_along(segments, paths, self.limits)
            sections = [
                SpeedSection(s.limit, s.length, int(firsts[s.first]), int(firsts[s.last]),
                             s.acceleration, s.jerk) for s in moving
            ]  # fmt: skip
            run = phases_of(chords, sections, joints)
        # Where the phases of each move begin; one that goes nowhere has none.
        edges = np.searchsorted(run.chord, firsts)
        edges = edges[np.searchsorted(segments.places, np.arange(len(self.moves) + 1))]
        for step in self.steps:
            if isinstance(step, _Stand):
                if step.height is None:
                    builder.wait(step.seconds, step.line, step.state)
                else:
                    end = [*builder.here[:2].tolist(), step.height]
                    builder.add([step.seconds], [end], UNIFORM, step.line, step.state)
                continue
            own = slice(int(edges[step.first]), int(edges[step.last]))
            if own.start == own.stop:
                continue
            lines = chords.lines[run.chord[own]]
            ends = run.ends[own]
            if self.lifts:
                ends = np.column_stack((ends, np.full(len(ends), builder.here[2])))
            builder.add(run.seconds[own], ends, run.slopes[own], lines, step.state)
        return builder.trace()

    def _chords(self, segments: Segments) -> tuple[Chords, Counts]:
        """The chords of the curves of segments, and the number of the first one of each."""
        count = len(segments.places)
        drawn = polylines([self.curves[k] for k in segments.places.tolist()], CHORD_TOLERANCE)
        counts = np.diff(drawn.begins) - 1
        owner = np.repeat(np.arange(count), counts)
        inner = np.ones(len(drawn.points), dtype=bool)
        inner[drawn.begins[:-1]] = False
        ends = drawn.points[inner]
        begins = drawn.points[np.flatnonzero(inner) - 1]
        step = ends - begins
        lengths = np.hypot(step[:, 0], step[:, 1])
        # The chords of a curve share its length, so that it takes the time that it takes.
        lengths = lengths * (segments.lengths / np.bincount(owner, lengths, count))[owner]
        lines = np.array(self.lines, dtype=np.int64)[segments.places[owner]]
        return Chords(begins, ends, lengths, lines), np.concatenate(([0], np.cumsum(counts)))


def _movement(leg: HeadMove, start: Point) -> Movement:
    """A move as the model of the times takes it."""
    x, y = leg.end
    match leg.curve:
        case None:
            return Feed(x, y)
        case Arc() as arc:
            i, j = arc.centre[0] - start[0], arc.centre[1] - start[1]
            return ArcFeed(x, y, i, j, arc.sweep_deg < 0.0)
        case Bezier() as parabola:
            vertex = parabola.point(0.5)
            return ParabolaFeed(x, y, vertex[0] - start[0], vertex[1] - start[1])
        case EllipseArc() as e:
            angle = float(np.degrees(np.arctan2(e.axis[1], e.axis[0])))
            i, j = e.centre[0] - start[0], e.centre[1] - start[1]
            return EllipseFeed(x, y, i, j, angle, e.ratio, e.sweep_deg < 0.0)
