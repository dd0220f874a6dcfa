"""Simulated axes: they go to a place with a trapezoid of velocity, from whatever they do now."""

from collections.abc import Callable, Sequence
from itertools import pairwise
from math import atan2, cos, dist, hypot, inf, pi, sin, sqrt
from typing import Any

from msgspec import Struct

from beamcam.controllers.simotion.syntax import ProgramBlock, Variable

Phase = tuple[float, float]  #: seconds and acceleration


def phases_to(way: float, velocity: float, greatest: float, up: float, down: float) -> list[Phase]:
    """The phases that make `way` and end at rest, from a velocity, as fast as limits allow.

    An axis that is too fast to stop in time, or moves away, brakes and comes back.
    """
    points: list[Phase] = []
    stop = velocity * abs(velocity) / (2 * down)
    side = 1.0 if way - stop >= 0.0 else -1.0
    left, speed = way * side, velocity * side
    if speed < 0.0:
        points.append((-speed / down, down * side))
        left, speed = left + speed * speed / (2 * down), 0.0
    if speed > greatest:
        points.append(((speed - greatest) / down, -down * side))
        left, speed = left - (speed * speed - greatest * greatest) / (2 * down), greatest
    peak = sqrt(max(0.0, (2 * up * down * left + down * speed * speed) / (up + down)))
    peak = max(min(peak, greatest), speed)
    if peak <= 0.0:
        return points
    rise = (peak * peak - speed * speed) / (2 * up)
    fall = peak * peak / (2 * down)
    points.append(((peak - speed) / up, up * side))
    points.append((max(0.0, left - rise - fall) / peak, 0.0))
    points.append((peak / down, -down * side))
    return points


class Axis:
    """An axis with its drive: `place` counts from its low limit switch, `position` from zero."""

    def __init__(self, name: str, place: float, stop: float) -> None:
        self.name = name
        self.place, self.velocity = place, 0.0
        self.origin = 0.0
        self.enabled = False
        self.error = False
        self.lag = 0.0  #: by which the axis is off its set position
        self.reads: Callable[[float], float] = float  #: what its encoder reads where it is
        self.brake = stop  #: mm/s2 of a stop
        self.commanded_by: Any = None  #: the function block that commanded it last
        self.held_by: Any = None  #: the function block that stopped it and holds it
        self._phases: list[Phase] = []
        self._end: float | None = None  #: place at which it stops

    @property
    def position(self) -> float:
        return self.place - self.origin

    @property
    def actual(self) -> float:
        """The position that the encoder reads."""
        return self.reads(self.position + self.lag)

    @property
    def still(self) -> bool:
        return not self._phases

    def enable(self) -> int:
        """0 if the drive is on then."""
        self.enabled = not self.error
        return 0 if self.enabled else 1

    def reset(self) -> int:
        """An error is acknowledged."""
        self.error = False
        return 0

    def go(self, position: float, velocity: float, up: float, down: float) -> None:
        """To a position."""
        self._end = position + self.origin
        self._phases = phases_to(position - self.position, self.velocity, velocity, up, down)

    def run(self, velocity: float, acceleration: float) -> None:
        """On and on."""
        change = velocity - self.velocity
        ramp = abs(change) / acceleration, acceleration if change > 0 else -acceleration
        self._end, self._phases = None, [ramp, (inf, 0.0)]

    def stop(self) -> None:
        """Stop as fast as the axis can."""
        speed = self.velocity
        ramp = abs(speed) / self.brake, -self.brake if speed > 0 else self.brake
        self._end, self._phases = None, [ramp]

    def home(self, position: float) -> None:
        """Call the place where the axis stands so."""
        self.origin = self.place - position

    def put(self, position: float, velocity: float) -> None:
        """Set the axis position from a path object."""
        self.place, self.velocity = position + self.origin, velocity
        self._end, self._phases = None, []

    def advance(self, seconds: float) -> None:
        """Move for a while."""
        while seconds > 0.0 and self._phases:
            lasts, acceleration = self._phases[0]
            t = min(seconds, lasts)
            self.place += t * (self.velocity + acceleration * t / 2)
            self.velocity += acceleration * t
            seconds -= t
            if lasts - t > 1e-12:
                self._phases[0] = (lasts - t, acceleration)
                return
            del self._phases[0]
        if not self._phases:
            self.velocity = 0.0
            if self._end is not None:
                self.place, self._end = self._end, None


class PathObject:
    """A path object: the lines and arcs that it leads both axes along."""

    def __init__(self, x: Axis, y: Axis) -> None:
        self.x, self.y = x, y
        self._points: list[tuple[float, float]] = []
        self._drive = Axis("path", 0.0, 1.0)

    @property
    def still(self) -> bool:
        return self._drive.still

    def go(self, points: list[tuple[float, float]], speed: float, up: float, down: float) -> None:
        """Along points, from rest to rest."""
        self._points, self._drive = points, Axis("path", 0.0, down)
        self._drive.go(sum(dist(a, b) for a, b in pairwise(points)), speed, up, down)

    def stop(self) -> None:
        if not self.still:
            self._drive.stop()

    def advance(self, seconds: float) -> None:
        if self.still:
            return
        self._drive.advance(seconds)
        way, (x, y), dx, dy = self._drive.position, self._points[-1], 0.0, 0.0
        for a, b in pairwise(self._points):
            length = dist(a, b)
            if length == 0.0:
                continue
            dx, dy = (b[0] - a[0]) / length, (b[1] - a[1]) / length
            if way <= length:
                x, y = a[0] + way * dx, a[1] + way * dy
                break
            way -= length
        self.x.put(x, dx * self._drive.velocity)
        self.y.put(y, dy * self._drive.velocity)


# --- SIMOTION's library: types, commands with their parameters, enumerators, function blocks ------

# A command has to name what is `needed` here: what it leaves out would be a default of the project.
# What the simulated axes do not know, such as blending, is no parameter here either.
#
# Sources. `_pos` with its parameters up to `positiveAccel`, and `basicMotion.position`, the actual
# position: a program that ran on a D425 with firmware 4.0. `positioningState`: a third party.
# `_movePathLinear`, `_movePathCircular`, `_stopPath`, `_stop`, `pathPlane`, `pathMode`, `x`, `y`,
# `z`, `circularType` and its values, `ijkMode`, `i`, `j`, `k`, `mergeMode` and its values,
# `nextCommand`, `velocityProfile`, `velocity`, `positiveAccel`, `negativeAccel`, `pathObjectType`:
# manual TO Path Interpolation 11/2010, chapters 2.5, 2.8 and 5.1. TON, ABS, SQRT: IEC 61131-3.
# `UNCONFIRMED` in machine/tables.py lists what no source shows; a machine's file can say that the
# project's package calls it otherwise.


Type = str  #: a plain type, "axis", "path", "enum:A|B" or the name of a function block

INTEGERS = {
    "SINT": (-(2**7), 2**7 - 1), "USINT": (0, 2**8 - 1), "INT": (-(2**15), 2**15 - 1),
    "UINT": (0, 2**16 - 1), "DINT": (-(2**31), 2**31 - 1), "UDINT": (0, 2**32 - 1),
}  # fmt: skip
NUMBERS = (*INTEGERS, "REAL", "LREAL")
AXIS, PATH_OBJECT = "posAxis", "pathObjectType"
PLAIN_TYPES = (*NUMBERS, "BOOL", "TIME")
TYPES = (*PLAIN_TYPES, AXIS, PATH_OBJECT)

FUNCTIONS = ("ABS", "SQRT")
LOGIC = ("AND", "OR", "XOR")
GIVES_BOOL = (*LOGIC, "=", "<>", "<", ">", "<=", ">=")
ANSWER = "DINT"  #: type of what a command gives back

_WHEN = "enum:IMMEDIATELY|WHEN_BUFFER_READY|WHEN_COMMAND_DONE|WHEN_MOTION_DONE"
_MERGE = "enum:IMMEDIATELY|NEXT_MOTION|SEQUENTIAL|SUPERIMPOSED_MOTION_MERGE"
_DIRECT = "enum:DIRECT|USER_DEFAULT|CURRENT"
_PROFILE = "enum:TRAPEZOIDAL|SMOOTH"
_STOP = "enum:STOP_AND_ABORT|STOP_WITHOUT_ABORT"


class Command(Struct, frozen=True):
    """A system function."""

    parameters: dict[str, Type]
    some: tuple[str, ...] = ()  #: those that a call has to name, if not all

    @property
    def needed(self) -> tuple[str, ...]:
        """The parameters that a call has to name."""
        return self.some or tuple(self.parameters)


_DYNAMICS = {
    "velocityType": _DIRECT, "velocity": "LREAL",
    "positiveAccelType": _DIRECT, "positiveAccel": "LREAL",
    "negativeAccelType": _DIRECT, "negativeAccel": "LREAL",
    "velocityProfile": _PROFILE, "mergeMode": _MERGE, "nextCommand": _WHEN,
}  # fmt: skip
_PLANE = {
    "pathObject": PATH_OBJECT, "pathPlane": "enum:X_Y|Y_Z|Z_X|X_Y_Z",
    "pathMode": "enum:ABSOLUTE|RELATIVE", "x": "LREAL", "y": "LREAL", "z": "LREAL",
}  # fmt: skip

COMMANDS = {
    "_pos": Command({
        "axis": AXIS, "direction": "enum:POSITIVE|NEGATIVE|BY_VALUE|SHORTEST_WAY",
        "positioningMode": "enum:ABSOLUTE|RELATIVE", "position": "LREAL", **_DYNAMICS,
    }),
    "_move": Command(
        {"axis": AXIS, "direction": "enum:POSITIVE|NEGATIVE|BY_VALUE", **_DYNAMICS},
        ("axis", "direction", "velocityType", "velocity", "nextCommand"),
    ),
    "_stop": Command({"axis": AXIS, "stopMode": _STOP, "nextCommand": _WHEN}),
    "_stopPath": Command({"pathObject": PATH_OBJECT, "stopMode": _STOP, "nextCommand": _WHEN}),
    "_enableAxis": Command({"axis": AXIS, "nextCommand": _WHEN}),
    "_resetAxisError": Command(
        {"axis": AXIS, "errorResetMode": "enum:ALL_ERRORS", "nextCommand": _WHEN}
    ),
    "_homing": Command({
        "axis": AXIS, "homingMode": "enum:DIRECT_HOMING|ACTIVE_HOMING|PASSIVE_HOMING",
        "homePositionType": _DIRECT, "homePosition": "LREAL", "nextCommand": _WHEN,
    }),
    "_movePathLinear": Command(
        {**_PLANE, **_DYNAMICS}, ("pathObject", "pathPlane", "pathMode", "x", "y", *_DYNAMICS)
    ),
    "_movePathCircular": Command(
        {
            **_PLANE,
            "circularType": "enum:OVER_POSITION_TO_ENDPOSITION|WITH_RADIUS_AND_ENDPOSITION",
            "ijkMode": "enum:ABSOLUTE|RELATIVE", "i": "LREAL", "j": "LREAL", "k": "LREAL",
            **_DYNAMICS,
        },
        ("pathObject", "pathPlane", "circularType", "pathMode", "x", "y", "ijkMode", "i", "j",
         *_DYNAMICS),
    ),
}  # fmt: skip

#: Standard function blocks, as if they were declared.
BLOCKS = {
    "TON": ProgramBlock(0, "FUNCTION_BLOCK", "TON", (
        Variable(0, "IN", "input", "BOOL"), Variable(0, "PT", "input", "TIME"),
        Variable(0, "Q", "output", "BOOL"), Variable(0, "ET", "output", "TIME"),
    ), ()),
}  # fmt: skip

#: System variables: of an axis, and of what they hold.
COMPONENTS = {
    AXIS: {
        "control": "enum:ACTIVE|INACTIVE", "error": "enum:YES|NO",
        "basicMotion": "basicMotion", "positioningState": "positioningState",
    },
    "basicMotion": {"position": "LREAL", "velocity": "LREAL"},
    "positioningState": {"commandPosition": "LREAL", "actualPosition": "LREAL"},
}  # fmt: skip


#: The types that a value of each may be assigned to besides its own, without a conversion.
_WIDER = {
    "USINT": ("INT", "UINT", "DINT", "UDINT"), "SINT": ("INT", "DINT"), "INT": ("DINT",),
    "UINT": ("DINT", "UDINT"), "REAL": ("LREAL",), "integer": tuple(INTEGERS),
    "real": ("REAL", "LREAL"),
}  # fmt: skip


def choices(type_: Type) -> Sequence[str]:
    """The enumerators of an enumeration; none of any other type."""
    return type_[5:].split("|") if type_.startswith("enum:") else ()


ENUMERATORS = frozenset({"ACTIVE", "INACTIVE", "YES", "NO"}).union(
    *(choices(type_) for command in COMMANDS.values() for type_ in command.parameters.values())
)


def fits(type_: Type, expected: Type) -> bool:
    """Whether a value of one type is assignable to another, without a conversion."""
    if type_ == expected or expected in _WIDER.get(type_, ()):
        return True
    return bool(choices(type_)) and set(choices(type_)) <= set(choices(expected))


def shown(type_: Type) -> str:
    """A type as a message says it."""
    plain = " or ".join(choices(type_)) or type_
    return {"integer": "a whole number", "real": "a number with a point"}.get(plain, plain)


# --- arcs of path objects, by a place that they go over -------------------------------------------

Place = tuple[float, float]

CIRCLE_STEPS = 256  #: chords of half a circle


def circle_points(start: Place, middle: Place, end: Place) -> list[Place]:
    """Points of the arc from start over middle to end; nothing if they lie in a line.

    The centre is where the perpendicular bisectors of both chords meet.
    """
    ax, ay = middle[0] - start[0], middle[1] - start[1]
    bx, by = end[0] - start[0], end[1] - start[1]
    det = 2 * (ax * by - ay * bx)
    if abs(det) < 1e-9:
        return []
    a2, b2 = ax * ax + ay * ay, bx * bx + by * by
    cx, cy = (by * a2 - ay * b2) / det, (ax * b2 - bx * a2) / det
    radius = hypot(cx, cy)
    centre = (start[0] + cx, start[1] + cy)
    first = atan2(-cy, -cx)
    last = atan2(end[1] - centre[1], end[0] - centre[0])
    sweep = (last - first) % (2 * pi) if det > 0 else -((first - last) % (2 * pi))
    count = max(2, round(CIRCLE_STEPS * abs(sweep) / pi))
    inner = [
        (centre[0] + radius * cos(first + sweep * k / count),
         centre[1] + radius * sin(first + sweep * k / count))
        for k in range(1, count)
    ]  # fmt: skip
    return [start, *inner, end]
