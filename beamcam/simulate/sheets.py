"""The trace of a cutting table that is told by G-code: the look-ahead over what was read back.

The times are those of `motion.sheet_times`, which `plan` tells too: traverses and contours run from
rest to rest, a contour passes its corners as fast as the machine's file allows.
"""

from collections.abc import Mapping, Sequence
from math import isnan

import numpy as np

from beamcam.controllers.events import HeadMove, Move, Pause, Switch, TableEvent
from beamcam.geometry.array_types import Counts
from beamcam.geometry.curves import Arc, Bezier, Curve, EllipseArc, Line
from beamcam.geometry.plane import Point
from beamcam.geometry.polylines import polylines
from beamcam.machine.machine import Machine
from beamcam.machine.path_limits import path_limits
from beamcam.model.program import ArcFeed, EllipseFeed, Feed, Movement, ParabolaFeed
from beamcam.motion.sheet_times import SECONDS_PER_MINUTE, Segment, segment_of, speeds_along
from beamcam.motion.speed_sections import SpeedSection
from beamcam.simulate.phases import Chords, add_phases
from beamcam.simulate.state import State
from beamcam.simulate.trace import UNIFORM, Trace, TraceBuilder, head_axes

#: Of the chords that stand for a curve in a trace.
CHORD_TOLERANCE = 0.02


def sheet_trace(events: Sequence[TableEvent], starts: Mapping[int, str], machine: Machine) -> Trace:
    """The head over time; `starts` says which process the word of a line starts."""
    head = _Head(machine)
    path: list[HeadMove] = []
    for event in events:
        if isinstance(event, Move) and not event.rapid:
            path.append(event)
        elif isinstance(event, Move | Pause | Switch):
            head.follow(path)
            path = []
            if isinstance(event, Move):
                head.follow([event])
            elif isinstance(event, Pause):
                head.builder.wait(event.seconds, event.line, head.state)
            else:
                head.state = State(process=starts.get(event.line, ""))
    head.follow(path)
    return head.builder.trace()


class _Head:
    """The head and its clock while a program runs."""

    def __init__(self, machine: Machine) -> None:
        if machine.torch is None:
            raise TypeError(f"{machine.name} has no torch")
        self.limits = path_limits(machine)
        self.rapid_mm_min = machine.torch.traverse_mm_min
        self.builder = TraceBuilder(head_axes(machine), (0.0, 0.0))
        self.state = State()

    def follow(self, legs: Sequence[HeadMove]) -> None:
        """Moves from rest to rest."""
        curves: list[Curve] = []
        segments: list[Segment] = []
        lines: list[int] = []
        for leg in legs:
            start = self._start(leg)
            feed = self.rapid_mm_min if leg.rapid or not leg.feed_mm_min else leg.feed_mm_min
            move = _movement(leg, start)
            segment = segment_of(start, move, feed / SECONDS_PER_MINUTE, self.limits)
            if segment is not None:
                curves.append(leg.curve or Line(start, leg.end))
                segments.append(segment)
                lines.append(leg.line)
        if segments:
            self._run(curves, segments, np.array(lines, dtype=np.int64))

    def _start(self, leg: HeadMove) -> Point:
        """Where a move begins; a program begins in the corner of the table."""
        if isnan(leg.start[0]) or isnan(leg.start[1]):
            x, y = self.builder.here.tolist()
            return x, y
        return leg.start

    def _run(self, curves: list[Curve], segments: list[Segment], lines: Counts) -> None:
        drawn = polylines(curves, CHORD_TOLERANCE)
        chords = np.diff(drawn.begins) - 1
        owner = np.repeat(np.arange(len(curves)), chords)
        inner = np.ones(len(drawn.points), dtype=bool)
        inner[drawn.begins[:-1]] = False
        ends = drawn.points[inner]
        begins = drawn.points[np.flatnonzero(inner) - 1]
        step = ends - begins
        lengths = np.hypot(step[:, 0], step[:, 1])
        # The chords of a curve share its length, so that it takes the time that it takes.
        whole = np.bincount(owner, lengths, len(curves))
        lengths = lengths * (np.array([s.length for s in segments]) / whole)[owner]
        firsts = np.concatenate(([0], np.cumsum(chords)))
        if self.limits is None:
            speeds = np.array([s.speed_mm_s for s in segments])[owner]
            self.builder.add(lengths / speeds, ends, UNIFORM, lines[owner], self.state)
            return
        moving, joints = speeds_along(segments, self.limits)
        finer = [
            SpeedSection(
                s.limit, s.length, int(firsts[s.first]), int(firsts[s.last]), s.acceleration,
                s.jerk,
            )
            for s in moving
        ]  # fmt: skip
        add_phases(self.builder, Chords(begins, ends, lengths, lines[owner]), finer, joints,
                   self.state)  # fmt: skip


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
