"""Motion of a saw and drilling line: times by one model of axes and switches, drilling cycles.

Each move is a stretch along which all its axes start and stop together:

    share of the way     _____           1  its speed v, acceleration a and jerk j, per second, are
                     ___/                   the least that its axes, and a feed its F, allow:
                ____/                       v = min(v_i / |d_i|), a = min(a_i / |d_i|) and so on,
               /    t ->                    with a jerk only where an axis has one

Spindles and the saw take the times of the machine file. Each spindle keeps the tool that it had,
so that choosing it again costs no change. Lengths are mm, angles degrees.
"""

from collections.abc import Iterator, Mapping
from math import cos, inf, radians
from typing import NamedTuple, cast

from msgspec import Struct

from beamcam.geometry.ramps import STANDING, Ramp, ramp
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
        """Y and Z of an operation's stroke: free of the section, near, and at the bottom."""
        stroke, axes = self(op, y), self.axes(op)
        return (
            _yz(axes, stroke.across, stroke.retract),
            _yz(axes, stroke.across, stroke.approach),
            _yz(axes, stroke.across, stroke.bottom),
        )


def _yz(axes: tuple[Axis, Axis], across: float, along: float) -> YZ:
    at = {axes[0]: across, axes[1]: along}
    return at["Y"], at["Z"]


def formula_values(profile: Profile, face: Face, drill: Drill) -> dict[str, float]:
    """The names that a machine's formulas may use, as far as the section gives them."""
    return {
        "height": profile.height, "width": profile.width,
        "flange_thickness": profile.flange_thickness,
        "web_thickness": profile.web_thickness or 0.0, "thickness": profile.thickness(face),
        "face_depth": profile.face_depth(face), "clearance": drill.clearance,
    }  # fmt: skip


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
        """A move of the axes that the letters of `to` move now; None is rapid.

        `way` is the length that the feed counts along. Without a feed above 0 a stroke into
        the steel runs at that of the tool's data for any steel, and other moves as fast as they
        can.
        """
        end = list(self.positions)
        for letter, value in to.items():
            for index in self._axes(letter):
                end[index] = value
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

    def _axes(self, letter: str) -> Iterator[int]:
        """The axes that a letter moves now: X its own, Y and Z those of the chosen spindles."""
        if (None, letter) in self._index:
            yield self._index[None, letter]
            return
        for number in self._chosen:
            if (number, letter) in self._index:
                yield self._index[number, letter]

    def _stand(self, seconds: float) -> Leg:
        return Leg(seconds, self.positions, self.positions)

    def _travel(self, end: list[float], speed: float = inf) -> Leg:
        """The leg from here to `end`, at most at `speed` shares of the way per second."""
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


# --- canned cycles of drilling --------------------------------------------------------------------

# One block that is carried out as several moves.
#
#     G81 X Y Z R F      to X Y in rapid, to R in rapid, to Z at the feed, back in rapid
#     G82 ... P          likewise, with a dwell of P seconds at Z
#     G83 ... Q          Q deeper at a time, each time out to R and back in rapid, to clear chips
#     G73 ... Q          Q deeper at a time, each time a little back, to break them
#     G80                the end of the cycle
#
# A tool that stood between R and Z before a run of cycles goes to R first, of each of them; one
# that was drawn back to an R further in goes to the next place and to R at once. It is drawn back
# to where it stood before the cycle, or to R where that lies further out or the controller is told
# so (G99). Source: LinuxCNC documentation, "Canned Cycles", and what its interpreter does; DIN
# 66025.

DRILL, DRILL_AND_DWELL, PECK, BREAK_CHIPS, END = 81, 82, 83, 73, 80
DRILLING = (DRILL, DRILL_AND_DWELL, PECK, BREAK_CHIPS)
PECKING = (PECK, BREAK_CHIPS)
#: What each of them takes besides X, Y, Z, R and F.
OWN_LETTERS = {DRILL: "", DRILL_AND_DWELL: "P", PECK: "Q", BREAK_CHIPS: "Q"}
BACK = 0.254  #: mm between the tool and what is drilled, before it feeds on; 0.01 in
MAX_PECKS = 1000  #: of one hole; more is a slip of the decimal point

Place = tuple[float, float, float]


class CycleMove(NamedTuple):
    """One move of a cycle."""

    rapid: bool
    end: Place


def cycle_moves(
    at: Place, place: tuple[float, float], bottom: float, near: float, clear: float,
    before: float, cycle: int = DRILL, peck: float = 0.0,
) -> Iterator[CycleMove]:  # fmt: skip
    """Moves of a cycle from the tool's position; `near` is R, `clear` the retract position.

    `before` is where the tool stood before the first of a run of cycles; nan where nobody knows.
    """
    x, y = place
    inward = 1.0 if bottom > near else -1.0
    z = at[2]
    if not inward * (before - near) <= 0.0:
        if z != near:
            yield CycleMove(True, (at[0], at[1], near))
        at, z = (at[0], at[1], near), near
    elif inward * (z - near) > 0.0:
        z = near
    if (x, y, z) != at:
        yield CycleMove(True, (x, y, z))
    if z != near:
        yield CycleMove(True, (x, y, near))
    if cycle in PECKING:
        depth = near + inward * peck
        while inward * (bottom - depth) > 0.0:
            yield CycleMove(False, (x, y, depth))
            if cycle == PECK:
                yield CycleMove(True, (x, y, near))
            yield CycleMove(True, (x, y, depth - inward * BACK))
            depth += inward * peck
    yield CycleMove(False, (x, y, bottom))
    yield CycleMove(True, (x, y, clear))


def clear_place(before: float, near: float, bottom: float, to_near: bool) -> float:
    """The retract position of a cycle; `before` is the position before it."""
    if to_near or before != before:
        return near
    inward = 1.0 if bottom > near else -1.0
    return before if inward * (near - before) >= 0.0 else near


def peck_fault(peck: float | None, near: float, bottom: float) -> str | None:
    """What the depth fed at a time should be, where it cannot be what it is."""
    least = abs(bottom - near) / MAX_PECKS
    if peck is None or peck <= 0.0:
        return "Q above 0, the depth that is fed at a time"
    return f"Q of at least {least:.4g}, {MAX_PECKS} feeds at most" if peck < least else None
