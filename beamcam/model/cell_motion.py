"""Motion of a saw and drilling line: its strokes, and times by one model of axes and switches.

Each move is a stretch along which all its axes start and stop together:

    share of the way     _____           1  its speed v, acceleration a and jerk j, per second, are
                     ___/                   the least that its axes, and a feed its F, allow:
                ____/                       v = min(v_i / |d_i|), a = min(a_i / |d_i|) and so on,
               /    t ->                    with a jerk only where an axis has one

Spindles and the saw take the times of the machine file. Each spindle keeps the tool that it had,
so that choosing it again costs no change. Lengths are mm, angles degrees.
"""

from collections.abc import Iterator, Mapping
from math import cbrt, cos, inf, radians, sqrt
from typing import cast

from msgspec import Struct

from beamcam.machine.machine import Machine, drill_of
from beamcam.machine.stations import Axis, Drill, Spindle, Tool, ToolKind, speed_and_feed
from beamcam.model.part import Face, Profile
from beamcam.model.plan import SpindleOp

YZ = tuple[float, float]  #: Y and Z of the machine


class StrokePlaces(Struct, frozen=True):
    """One stroke in machine coordinates, along the axis that drives the spindle in."""

    across: float  #: place of the axis across the bar
    retract: float  #: free of the section
    approach: float  #: where the rapid approach ends
    bottom: float


class StrokeGeometry:
    """The strokes of a machine's spindles on one section."""

    def __init__(self, profile: Profile, machine: Machine) -> None:
        self._drill = drill = drill_of(machine)
        self.spindles: dict[Face, Spindle] = {s.face: s for s in machine.spindles}
        self._values = {face: formula_values(profile, face, drill) for face in self.spindles}

    def axes(self, op: SpindleOp) -> tuple[Axis, Axis]:
        """The axis across the bar and the one that strokes."""
        spindle = self.spindles[op.faces[0]]
        return spindle.across.axis, spindle.stroke.axis

    def __call__(self, op: SpindleOp, y: float) -> StrokePlaces:
        """The stroke of an operation at `y` on its face.

        The depth of a drill counts to its full diameter, and the tip goes beyond; the depth of
        other tools is that of their point. Through goes beyond the far side by the breakthrough.
        """
        face = op.faces[0]
        across, stroke = self.spindles[face].across, self.spindles[face].stroke
        values = dict(self._values[face])
        values["y"] = y
        through = values["thickness"] + self._drill.breakthrough
        values["depth"] = through if op.depth is None else op.depth
        values["tip"] = op.tool.tip if op.tool.kind == "drill" else 0.0
        retract = stroke.retract(values)
        return StrokePlaces(
            across.position(values),
            retract,
            retract if stroke.approach is None else stroke.approach(values),
            stroke.bottom(values),
        )

    def places(self, op: SpindleOp, y: float) -> tuple[YZ, YZ, YZ]:
        """Y and Z of an operation's stroke: retracted, approached and at the bottom."""
        stroke, (across, along) = self(op, y), self.axes(op)
        y, retract, approach, bottom = stroke.across, stroke.retract, stroke.approach, stroke.bottom
        if (across, along) == ("Y", "Z"):
            return (y, retract), (y, approach), (y, bottom)
        return (retract, y), (approach, y), (bottom, y)


def formula_values(profile: Profile, face: Face, drill: Drill) -> dict[str, float]:
    """The names that a machine's formulas may use, as far as the section gives them."""
    return {
        "height": profile.height, "width": profile.width,
        "flange_thickness": profile.flange_thickness,
        "web_thickness": profile.web_thickness or 0.0, "thickness": profile.thickness(face),
        "face_depth": profile.face_depth(face), "clearance": drill.clearance,
    }  # fmt: skip


# --- ramps ----------------------------------------------------------------------------------------

# Fastest motion over a distance of 1 from rest to rest, within limits of its derivatives.
#
# speed        ______________          the acceleration grows by the jerk, stays, and falls back;
#           .'                '.       the same to brake, mirrored. Without a limit of the jerk
#         /                    \      that is a trapezoid, and a triangle where the way is short.
#  _____.'                      '.__
#  jerk steady jerk   cruise   jerk ...


class Ramp(Struct, frozen=True):
    """Times in s; speed and acceleration in shares of the way per second, and per second squared.

    All of it is 0 for a way that takes no time.
    """

    jerk_s: float  #: in which the acceleration grows, and in which it falls back
    steady_s: float  #: at maximum acceleration
    cruise_s: float  #: at maximum speed
    speed: float
    acceleration: float

    @property
    def rise_s(self) -> float:
        """From rest to maximum speed."""
        return 2 * self.jerk_s + self.steady_s

    @property
    def duration_s(self) -> float:
        """From rest to rest."""
        return 2 * self.rise_s + self.cruise_s

    def share(self, t: float) -> float:
        """Share of the distance covered `t` seconds after the start."""
        if t >= self.duration_s:
            return 1.0
        left = self.duration_s - t
        if t < self.rise_s:
            return self._risen(t)
        if left < self.rise_s:
            return 1.0 - self._risen(left)
        return self.speed * (t - self.rise_s / 2)

    def _risen(self, t: float) -> float:
        """The way in the first `t` seconds, none of them at the greatest speed."""
        if t < self.jerk_s:
            return self.acceleration * t**3 / (6 * self.jerk_s)
        left = self.rise_s - t
        if left < self.jerk_s:
            # The rise is as symmetrical as its speed: half of the greatest in the middle.
            lost = self.acceleration * left**3 / (6 * self.jerk_s)
            return self.speed * (self.rise_s / 2 - left) + lost
        steady = t - self.jerk_s
        grown = self.acceleration * self.jerk_s / 2  # the speed when the jerk is over
        return grown * (self.jerk_s / 3 + steady) + self.acceleration * steady * steady / 2


STANDING = Ramp(0.0, 0.0, 0.0, 0.0, 0.0)


def ramp(speed: float, acceleration: float, jerk: float = inf) -> Ramp:
    """The fastest from rest to rest within limits above 0; the speed may be infinite."""
    jerk_s = acceleration / jerk
    steady_s = speed / acceleration - jerk_s
    if steady_s < 0.0:  # the speed is reached before the acceleration is
        jerk_s, steady_s = sqrt(speed / jerk), 0.0
    if speed * (2 * jerk_s + steady_s) > 1.0:  # the distance ends before the speed is reached
        # acceleration (jerk_s + steady_s) (2 jerk_s + steady_s) = 1
        jerk_s = acceleration / jerk
        steady_s = (sqrt(jerk_s * jerk_s + 4 / acceleration) - 3 * jerk_s) / 2
        if steady_s < 0.0:
            jerk_s, steady_s = cbrt(1 / (2 * jerk)), 0.0
    greatest = acceleration if steady_s > 0.0 else jerk * jerk_s
    reached = greatest * (jerk_s + steady_s)
    rise_s = 2 * jerk_s + steady_s
    return Ramp(jerk_s, steady_s, max(1 / reached - rise_s, 0.0), reached, greatest)


# Times of moves along a line, of a table as of a line, under limits of velocity, acceleration and
# jerk.
#
#       v |    ______          A ramp changes the velocity by `change`, from and to acceleration 0.
#         |   /      \         It takes change / a + a / j, or 2 sqrt(change / j) where it is too
#         |  /        \        small to reach a; its way is the mean velocity times the time.
#         |_/__________\__ t   An infinite jerk makes trapezoids of it.
#
# All in closed form and plain numbers, so that a thousand holes cost no numpy. Units are the
# caller's: mm, mm/s, mm/s2, mm/s3, or degrees.


def ramp_seconds(change: float, acceleration: float, jerk: float = inf) -> float:
    """Least time in which the velocity changes by `change`, from and to acceleration 0."""
    if change <= 0.0:
        return 0.0
    if jerk == inf:
        return change / acceleration
    if change * jerk >= acceleration * acceleration:
        return change / acceleration + acceleration / jerk
    return 2.0 * sqrt(change / jerk)


def move_seconds(distance: float, velocity: float, acceleration: float, jerk: float = inf) -> float:
    """Minimum time from rest to rest over `distance`, which may be negative."""
    way = abs(distance)
    return ramp(velocity / way, acceleration / way, jerk / way).duration_s if way else 0.0


Positions = tuple[float, ...]  #: in the order of the machine's axes
SECONDS_PER_MINUTE = 60.0


class Leg(Struct, frozen=True):
    """The motion of the axes in a time interval."""

    duration_s: float
    start: Positions
    end: Positions
    along: Ramp = STANDING  #: displacement from start to end


class CellMotion:
    """The axes, spindles and saw of a machine while work goes by."""

    def __init__(self, machine: Machine, section: float) -> None:
        """`section` is how deep the saw cuts when it is not tilted: the width of the section."""
        self.machine, self._section = machine, section
        self.positions: Positions = tuple(axis.park for axis in machine.axes)
        self.spindle = 0  #: what the program calls it; 0 before one is chosen
        self._chosen: tuple[int, ...] = ()
        self._tool: tuple[ToolKind, float] = ("drill", 0.0)
        self._held: dict[int, tuple[ToolKind, float]] = {}
        self._turning = False
        self._tilt = 0.0
        self._index: dict[tuple[int | None, str], int] = {
            (a.spindle, a.moves): i for i, a in enumerate(machine.axes)
        }
        numbers: dict[str, int] = {s.face: s.number for s in machine.spindles}
        self._spindles: dict[int, tuple[int, ...]] = {n: (n,) for n in numbers.values()}
        for pair in machine.pairs:
            self._spindles[pair.number] = tuple(numbers[face] for face in pair.faces)
        self._strokes = {s.number: s.stroke.axis for s in machine.spindles}

    def move(self, to: Mapping[str, float], way: float, feed_mm_min: float | None) -> Leg:
        """A move of the axes that the letters of `to` move now: X its own, Y and Z those of the
        chosen spindles. A feed of None is rapid.

        `way` is the length that the feed counts along. Without a feed above 0 a stroke into
        the steel runs at that of the tool's data for any steel, and other moves as fast as they
        can.
        """
        end = list(self.positions)
        for letter, value in to.items():
            own = (None, letter) in self._index
            for number in (None,) if own else self._chosen:
                if (number, letter) in self._index:
                    end[self._index[number, letter]] = value
        if feed_mm_min is not None and not 0.0 < feed_mm_min < inf:
            feed_mm_min = self._own_feed(end)
        slow = feed_mm_min is not None and way > 0.0
        return self._travel(end, feed_mm_min / SECONDS_PER_MINUTE / way if slow else inf)  # type: ignore[operator]

    def _own_feed(self, end: list[float]) -> float | None:
        """Feed of a stroke that the program gives none; None where it is not a stroke."""
        drill = self.machine.drill
        if drill is None or not self._turning or not self._chosen:
            return None
        index = self._index.get((self._chosen[0], self._strokes[self._chosen[0]]))
        if index is None or end[index] <= self.positions[index]:
            return None
        kind, diameter = self._tool
        return speed_and_feed(Tool(kind, diameter), drill, "")[1]

    def choose(self, number: int, kind: str, diameter: float) -> float:
        """Seconds to choose a spindle, or a pair of them, and its tool."""
        times = self.machine.times
        tool = cast("ToolKind", kind), round(diameter, 3)
        seconds = times.spindle_change_s if number != self.spindle else 0.0
        self.spindle, self._tool = number, tool
        self._chosen = self._spindles.get(number, ())
        if any(self._held.get(spindle) != tool for spindle in self._chosen):
            seconds += times.tool_change_s
        self._held.update(dict.fromkeys(self._chosen, tool))
        return seconds

    def switch(self, turning: bool) -> float:
        """Seconds to start or stop the spindle."""
        self._turning = turning
        return self.machine.times.spindle_s / 2

    def cut(
        self, angle: float, tilt: float, feed_mm_min: float | None
    ) -> Iterator[tuple[Leg, bool]]:
        """The legs of a cut, each with whether the saw is in work: turn, start, down and up."""
        saw, drill = self.machine.saw, self.machine.drill
        turn, stroke = self._index.get((None, "angle")), self._index.get((None, "saw"))
        turned = list(self.positions)
        if turn is not None:
            turned[turn] = angle
            yield self._travel(turned), False
            axis = self.machine.axes[turn]
            off = abs(tilt - self._tilt)
            if off:
                tilting = ramp(axis.speed / off, axis.acceleration / off, (axis.jerk or inf) / off)
                yield self._stand(tilting.duration_s), False
            self._tilt = tilt
        yield self._stand(self.machine.times.saw_s), True
        if stroke is None or saw is None:
            return
        depth = self._section / cos(radians(tilt)) + 2 * (drill.clearance if drill else 0.0)
        up, down = self.positions, list(self.positions)
        down[stroke] = depth
        feed = feed_mm_min if feed_mm_min and 0.0 < feed_mm_min < inf else saw.feed_mm_min
        yield self._travel(down, feed / SECONDS_PER_MINUTE / depth), True
        yield self._travel(list(up)), False

    def _stand(self, seconds: float) -> Leg:
        return Leg(seconds, self.positions, self.positions)

    def _travel(self, end: list[float], speed: float = inf) -> Leg:
        acceleration, jerk = inf, inf
        for axis, a, b in zip(self.machine.axes, self.positions, end, strict=True):
            if a != b:
                speed = min(speed, axis.speed / abs(b - a))
                acceleration = min(acceleration, axis.acceleration / abs(b - a))
                if axis.jerk is not None:
                    jerk = min(jerk, axis.jerk / abs(b - a))
        along = STANDING if acceleration == inf else ramp(speed, acceleration, jerk)
        leg = Leg(along.duration_s, self.positions, tuple(end), along)
        self.positions = leg.end
        return leg
