"""The axes of a cell over time, from the program that was read back and the machine's speeds.

Each move is a stretch along which all its axes start and stop together:

    share of the way     _____           1  its speed v, acceleration a and jerk j, per second, are
                     ___/                   the least that its axes, and a feed its F, allow:
                ____/                       v = min(v_i / |d_i|), a = min(a_i / |d_i|) and so on,
               /    t ->                    with a jerk only where an axis has one

Spindles and the saw take the times of the machine file. Lengths are mm, angles degrees.
"""

from collections.abc import Iterator, Sequence
from math import cos, hypot, inf, isnan, radians

from msgspec import Struct
from msgspec.structs import replace

from beamcam.controllers.events import Move, Pause, Switch, Turn
from beamcam.errors import MachineError, Source
from beamcam.machine import rules as machine_rules
from beamcam.machine.machine import Machine
from beamcam.verify import Run
from beamcam.verify.bars.stations import Choice
from beamcam.verify.ramps import STANDING, Ramp, ramp

Positions = tuple[float, ...]


class State(Struct, frozen=True):
    """What is switched on."""

    spindle: int = 0  #: number that the program chose, 0 before
    diameter: float = 0.0
    turning: int = 0  #: 1 clockwise, -1 counter-clockwise, 0 standing
    coolant: bool = False
    sawing: bool = False


class Row(Struct, frozen=True):
    """The cell at one moment."""

    time_s: float
    line: int  #: of the program; 0 before it begins
    positions: Positions  #: in the order of the machine's axes
    state: State


class Stretch(Struct, frozen=True):
    """A stretch of time in which axes move or something is switched."""

    line: int
    begin_s: float
    duration_s: float
    start: Positions
    end: Positions
    ramp: Ramp  #: along the way from start to end
    state: State

    def at(self, time_s: float) -> Positions:
        """Where the axes stand at a time within the stretch."""
        share = self.ramp.share(max(time_s - self.begin_s, 0.0))
        return tuple(a + share * (b - a) for a, b in zip(self.start, self.end, strict=True))


def stretches(run: Run, machine: Machine) -> tuple[Stretch, ...]:
    """The stretches of a program, one after another. Raises MachineError without `[[axes]]`."""
    if not machine.axes:
        raise MachineError(machine_rules.MISSING_KEY.at(Source(machine.name), expected="axes"))
    return tuple(_Simulation(run, machine).run())


def rows(course: Sequence[Stretch], every_s: float | None = None) -> Iterator[Row]:
    """A row for the beginning and the end of every stretch, or one every `every_s` seconds.

    Sampled, the last row stands at the first multiple of `every_s` at which all is over.
    """
    if not course:
        return
    first = course[0]
    if every_s is None:
        yield Row(first.begin_s, 0, first.start, State())
        for part in course:
            yield Row(part.begin_s + part.duration_s, part.line, part.end, part.state)
        return
    if every_s <= 0:
        raise ValueError("every_s has to be more than 0")
    count = 0
    for part in course:
        end = part.begin_s + part.duration_s
        while count * every_s < end:
            time_s = count * every_s
            yield Row(time_s, part.line, part.at(time_s), part.state)
            count += 1
    last = course[-1]
    yield Row(count * every_s, last.line, last.end, last.state)


def trace(course: Sequence[Stretch], machine: Machine, every_s: float | None = None) -> str:
    """The rows as CSV: time, the axes in the order of the controller's registers, tool states."""
    head = ["time_s", *(a.name for a in machine.axes), "spindle", "diameter", "turning",
            "coolant", "sawing", "line"]  # fmt: skip
    lines = [",".join(head)]
    lines += [",".join(_cells(row)) for row in rows(course, every_s)]
    return "\n".join(lines) + "\n"


def _cells(row: Row) -> Iterator[str]:
    yield f"{row.time_s:.4f}"
    for position in row.positions:
        yield f"{position + 0.0:.3f}".replace("-0.000", "0.000")
    state = row.state
    yield str(state.spindle)
    yield f"{state.diameter:g}"
    yield str(state.turning)
    yield str(int(state.coolant))
    yield str(int(state.sawing))
    yield str(row.line)


class _Simulation:
    """The clock, the axes and the switches while a program runs."""

    def __init__(self, run: Run, machine: Machine) -> None:
        self.events, self.choices, self.dialect = run.events, run.choices, run.dialect
        self.machine = machine
        self.clock_s = 0.0
        self.positions: Positions = tuple(a.park for a in machine.axes)
        self.state = State()
        self.choice: Choice | None = None
        self.index: dict[tuple[int | None, str], int] = {
            (a.spindle, a.moves): i for i, a in enumerate(machine.axes)
        }
        self.height = dict(run.made.section).get("height", 0.0)

    def run(self) -> Iterator[Stretch]:
        for event in self.events:
            match event:
                case Move():
                    yield self._move(event, hypot(*self._deltas(event)))
                case Turn():
                    radius = hypot(
                        event.start[0] - event.centre[0], event.start[1] - event.centre[1]
                    )
                    yield self._move(event, radius * abs(radians(event.sweep_deg)))
                case Pause():
                    yield self._stretch(event.line, self.positions, event.seconds)
                case Switch():
                    yield from self._switch(event)

    @staticmethod
    def _deltas(event: Move) -> list[float]:
        return [b - a for a, b in zip(event.start, event.end, strict=True) if not isnan(b - a)]

    def _move(self, event: Move | Turn, way: float) -> Stretch:
        end = list(self.positions)
        for letter, value in zip("XYZ", event.end, strict=True):
            if isnan(value):
                continue
            for index in self._axes(letter):
                end[index] = value
        rapid = type(event) is Move and event.rapid
        feed_mm_s = event.feed_mm_min / 60
        cap = inf if rapid or way == 0 or feed_mm_s <= 0 else feed_mm_s / way
        return self._travel(event.line, tuple(end), cap)

    def _axes(self, letter: str) -> Iterator[int]:
        """The axes that a letter moves now: X its own, Y and Z those of the chosen spindles."""
        if (None, letter) in self.index:
            yield self.index[None, letter]
        elif self.choice is not None:
            for station in self.choice.stations:
                if (station.number, letter) in self.index:
                    yield self.index[station.number, letter]

    def _travel(self, line: int, end: Positions, cap: float = inf) -> Stretch:
        """A stretch from here to `end`, at most at `cap` shares of the way per second."""
        speed, acceleration, jerk = cap, inf, inf
        for axis, a, b in zip(self.machine.axes, self.positions, end, strict=True):
            if a != b:
                speed = min(speed, axis.speed / abs(b - a))
                acceleration = min(acceleration, axis.acceleration / abs(b - a))
                if axis.jerk is not None:
                    jerk = min(jerk, axis.jerk / abs(b - a))
        along = STANDING if acceleration == inf else ramp(speed, acceleration, jerk)
        return self._stretch(line, end, along.duration_s, along)

    def _stretch(
        self, line: int, end: Positions, takes_s: float, along: Ramp = STANDING
    ) -> Stretch:
        done = Stretch(line, self.clock_s, takes_s, self.positions, end, along, self.state)
        self.clock_s += takes_s
        self.positions = end
        return done

    def _switch(self, event: Switch) -> Iterator[Stretch]:
        word = self.dialect.m_words.get(event.number)
        role = word.role if word else "other"
        times = self.machine.times
        takes_s = 0.0
        if word is not None and role == "choose":
            said = {field: event.words[at] for at, field in word.fields if at in event.words}
            number, diameter = int(said.get("spindle", 0)), said.get("diameter", 0.0)
            if number != self.state.spindle:
                takes_s += times.spindle_change_s
            if diameter != self.state.diameter:
                takes_s += times.tool_change_s
            self.choice = self.choices.get(number)
            self.state = replace(self.state, spindle=number, diameter=diameter)
        elif role == "on":
            takes_s = times.spindle_s / 2
            self.state = replace(self.state, turning=1 if event.number == 3 else -1)
        elif role == "off":
            takes_s = times.spindle_s / 2
            self.state = replace(self.state, turning=0)
        elif role == "change":
            takes_s = times.reload_s
        elif role in ("coolant-on", "coolant-off"):
            self.state = replace(self.state, coolant=role == "coolant-on")
        elif word is not None and role == "saw":
            said = {field: event.words[at] for at, field in word.fields if at in event.words}
            yield from self._saw(event.line, said.get("angle", 0.0))
            return
        yield self._stretch(event.line, self.positions, takes_s)

    def _saw(self, line: int, angle: float) -> Iterator[Stretch]:
        """Turn the saw, cut down through the section at the saw's feed, and back up."""
        saw = self.machine.saw
        turn, down = self.index.get((None, "angle")), self.index.get((None, "saw"))
        turned = list(self.positions)
        if turn is not None:
            turned[turn] = angle
        yield self._travel(line, tuple(turned))
        self.state = replace(self.state, sawing=True)
        yield self._stretch(line, self.positions, self.machine.times.saw_s)
        if down is not None and saw is not None:
            square_off = radians(angle - saw.square)
            depth = self.height / cos(square_off)
            through = list(self.positions)
            through[down] = depth
            cap = inf if depth == 0 else saw.feed_mm_min / 60 / depth
            park = self.positions
            yield self._travel(line, tuple(through), cap)
            self.state = replace(self.state, sawing=False)
            yield self._travel(line, park)
        else:
            self.state = replace(self.state, sawing=False)
