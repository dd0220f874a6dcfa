"""The axes of a cell or a coper over time, from the program that was read back.

How long each move of a cell takes stands in `model.cell_motion`. Lengths are mm, angles degrees.
"""

import re
from collections.abc import Iterator, Mapping, Sequence
from math import dist, hypot, isfinite, isnan

from msgspec import Struct
from msgspec.structs import replace

from beamcam.controllers.dialect import Dialect, MWord
from beamcam.controllers.events import BarEvent, Lettering, Move, Pause, Place, Switch
from beamcam.errors import MachineError, Source
from beamcam.geometry.curves import Arc, Bezier, EllipseArc
from beamcam.machine.machine import Machine
from beamcam.machine.words import MISSING_KEY
from beamcam.model.cell_motion import CellMotion, Leg, Positions, Ramp
from beamcam.simulation.trace import UNIFORM, State, Trace, TraceAxis, TraceBuilder


class MotionSegment(Struct, frozen=True):
    """A span of time in which axes move or something is switched."""

    line: int
    begin_s: float
    duration_s: float
    start: Positions
    end: Positions
    ramp: Ramp  #: along the way from start to end
    state: State

    def at(self, time_s: float) -> Positions:
        """Axis positions at a time within the segment."""
        share = self.ramp.share(max(time_s - self.begin_s, 0.0))
        return tuple(a + share * (b - a) for a, b in zip(self.start, self.end, strict=True))


def motion_segments(
    events: Sequence[BarEvent], dialect: Dialect, section: Mapping[str, float], machine: Machine
) -> tuple[MotionSegment, ...]:
    """The segments of a program, one after another.

    `section` is what the program says about the bar, by field name. Raises MachineError without
    `[[axes]]`.
    """
    if not machine.axes:
        raise MachineError(MISSING_KEY.at(Source(machine.name), expected="axes"))
    return tuple(_Simulation(events, dialect, section, machine).run())


class _Simulation:
    """The clock and the switches while a program runs."""

    def __init__(
        self, events: Sequence[BarEvent], dialect: Dialect, section: Mapping[str, float],
        machine: Machine,
    ) -> None:  # fmt: skip
        self.events, self.dialect = events, dialect
        self.cell = CellMotion(machine, section.get("width", section.get("height", 0.0)))
        self.per_minute = 60.0 if machine.format.feed_unit == "mm/s" else 1.0
        self.manual_change_s, self.text_s = machine.times.manual_change_s, machine.times.text_s
        self.clock_s = 0.0
        self.state = State()

    def run(self) -> Iterator[MotionSegment]:
        for event in self.events:
            match event:
                case Move(curve=None):
                    deltas = (b - a for a, b in zip(event.start, event.end, strict=True))
                    yield self._move(event, hypot(*(d for d in deltas if not isnan(d))))
                case Move(curve=Arc() | Bezier() | EllipseArc() as curve):
                    yield self._move(event, curve.length)
                case Pause():
                    yield self._stand(event.line, event.seconds)
                case Lettering():
                    yield self._stand(event.line, self.text_s)
                case Switch():
                    yield from self._switch(event)

    def _move(self, event: Move[Place], way: float) -> MotionSegment:
        feed_mm_min = None if event.rapid else event.feed_mm_min
        to = {k: v for k, v in zip("XYZ", event.end, strict=True) if not isnan(v)}
        return self._segment(event.line, self.cell.move(to, way, feed_mm_min))

    def _stand(self, line: int, seconds: float) -> MotionSegment:
        here = self.cell.positions
        return self._segment(line, Leg(seconds, here, here))

    def _segment(self, line: int, leg: Leg) -> MotionSegment:
        done = MotionSegment(
            line, self.clock_s, leg.duration_s, leg.start, leg.end, leg.along, self.state
        )
        self.clock_s += leg.duration_s
        return done

    def _switch(self, event: Switch) -> Iterator[MotionSegment]:
        word = self.dialect.m_words.get(event.number, MWord("other", ()))
        role, takes_s = word.role, 0.0
        values = {field: event.words[at] for at, field in word.fields if at in event.words}
        if role == "choose":
            number = int(values.get("spindle", self.dialect.only_spindle or 0))
            kind = word.cycle.kind if word.cycle else "drill"
            diameter = values.get("diameter", 0.0)
            if "tool" in values:
                tool = int(values["tool"])
                kind, diameter = self.dialect.numbered.get(tool, (kind, diameter))
            takes_s = self.cell.choose(number, kind, diameter)
            self.state = replace(self.state, spindle=number, diameter=diameter)
        elif role == "on":
            takes_s = self.cell.switch(True)
            self.state = replace(self.state, turning=1 if event.number == 3 else -1)
        elif role == "off":
            takes_s = self.cell.switch(False)
            self.state = replace(self.state, turning=0)
        elif role == "change":
            takes_s = self.manual_change_s
        elif role in ("coolant-on", "coolant-off"):
            self.state = replace(self.state, coolant=role == "coolant-on")
        elif role == "saw":
            # No blade goes down at 0 or below; the read-back refuses that, a trace takes its own.
            feed = max(values.get("feed", 0.0), 0.0) * self.per_minute or None
            legs = self.cell.cut(values.get("angle", 0.0), values.get("tilt", 0.0), feed)
            for leg, sawing in legs:
                self.state = replace(self.state, sawing=sawing)
                yield self._segment(event.line, leg)
            return
        yield self._stand(event.line, takes_s)


def bar_trace(segments: Sequence[MotionSegment], machine: Machine) -> Trace:
    """The axes of a cell over time."""
    builder = TraceBuilder(cell_axes(machine), [axis.park for axis in machine.axes])
    for part in segments:
        if part.duration_s == 0.0 and part.start == part.end:
            continue
        if part.start == part.end or not part.ramp.duration_s:
            builder.add([part.duration_s], [part.end], UNIFORM, part.line, part.state)
            continue
        rows = list(ramp_intervals(part.ramp))
        ends = [part.at(part.begin_s + until_s) for _, until_s, _, _ in rows]
        ends[-1] = part.end
        builder.add(
            [until_s - from_s for from_s, until_s, _, _ in rows], ends,
            [slopes for _, _, *slopes in rows], part.line, part.state,
        )  # fmt: skip
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


# --- copers: a torch round a profile, or over a tube that turns -----------------------------------

# Each move takes what `post` says of it: in rapid as long as the axis that needs longest, at its
# feed or in its inverse time else. Neither says how axes get up to speed: LinuxCNC runs one move
# into the next.


LETTERS = "XYZA"
_M_WORD = re.compile(r"M(\d+)")


def coper_trace(events: Sequence[BarEvent], machine: Machine) -> Trace:
    """The axes over time, from the first place that the program names.

    Raises MachineError without `[[axes]]` of X, Y unless it is fixed, Z and A, and of B where the
    torch tilts.
    """
    axes = {axis.moves: axis for axis in machine.axes}
    coper = machine.needed(machine.coper, "coper")
    letters = LETTERS.replace("Y", "") if coper.y == "fixed" else LETTERS
    letters += "B" if coper.tilt else ""
    if not {*letters} <= axes.keys():
        raise MachineError(MISSING_KEY.at(Source(machine.name), expected="axes"))
    used = [axes[letter] for letter in letters]  # type: ignore[index]
    units = {"A": coper.a_unit, "B": "deg"}
    rows = tuple(
        TraceAxis(axis.name, units.get(letter, "mm"), axis.min, axis.max)
        for letter, axis in zip(letters, used, strict=True)
    )
    on, off = (
        {int(number) for line in lines for number in _M_WORD.findall(line)}
        for lines in (machine.words.cut_on, machine.words.cut_off)
    )
    moves = [event for event in events if isinstance(event, Move)]
    # The first place that the program names of each axis; 0 where it names none.
    here = tuple(
        next((end for move in moves if isfinite(end := _places(move)[letter])), 0.0)
        for letter in letters
    )
    builder, state = TraceBuilder(rows, here), State()
    for event in events:
        match event:
            case Move():
                to = tuple(
                    b if isfinite(b) else a
                    for a, b in zip(here, map(_places(event).__getitem__, letters), strict=True)
                )
                if event.minutes > 0.0:
                    seconds = 60.0 * event.minutes
                elif not event.rapid and event.feed_mm_min > 0.0:  # of a torch with Y: else by time
                    seconds = 60.0 * dist(here[:3], to[:3]) / event.feed_mm_min
                else:
                    ways = zip(here, to, used, strict=True)
                    seconds = max(abs(b - a) / axis.speed for a, b, axis in ways)
                if seconds > 0.0:  # the first one only says where everything is
                    builder.add([seconds], [to], UNIFORM, event.line, state)
                here = to
            case Pause():
                builder.wait(event.seconds, event.line, state)
            case Switch(number=number) if number in on:
                state = State(process="cut")
            case Switch(number=number) if number in off:
                state = State()
            case _:
                pass
    return builder.trace()


def _places(move: Move[Place]) -> dict[str, float]:
    return dict(zip("XYZAB", (*move.end, move.a_deg[1], move.b_deg[1]), strict=True))
