"""A section held up to a line's spindles: where each of them puts a hole.

The author of a machine file measures it in a minute. A face that was taken for its mirror image
shows in how the axes count too: what one spindle calls up is up for all that the same letter of the
program moves, unless each counts by itself.

    coordinate   across the faces   grows                        strokes
    up           v, h               y towards o                  o downwards, u upwards
    front        o, u               y towards v (DSTV, page 8)   v backwards, h forwards
"""

from collections.abc import Iterator
from typing import Literal

from msgspec import Struct

from beamcam.errors import Diagnostic, Source, error
from beamcam.machine.machine import Machine
from beamcam.machine.stations import Axis, Spindle
from beamcam.model.cell_motion import formula_values
from beamcam.model.description import FACE_NAMES
from beamcam.model.part import Profile
from beamcam.model.section import measures_of

HAND = error("machine-hand",
    "found that {axis} grows {way} at the spindle {name} and {other_way} at {other}; expected one "
    "direction for one letter: is y of face {face} counted from its right edge?",
    "y of o and u counts from the edge away from v, y of v and h from the edge beside u. A face "
    "that is taken for its mirror image drills every hole off its middle on the wrong side. If "
    "each of these spindles counts its axis by itself and the sentences are right, nothing is "
    "wrong.")  # fmt: skip

FROM_EDGE, FROM_START = 30.0, 100.0  #: mm of the hole that is held up
#: A section of each kind that lines take, by their DSTV codes.
_EXAMPLES = {"I": "IPE300", "U": "UPN200", "L": "L100X10", "M": "RHS200X100X8"}
_EDGES = {
    "v": "the edge beside the bottom flange", "h": "the edge beside the bottom flange",
    "o": "the edge at the web's front", "u": "the edge at the web's front",
}  # fmt: skip
Coordinate = Literal["up", "front"]
_WAYS = {
    ("up", 1): "upwards", ("up", -1): "downwards",
    ("front", 1): "towards the front", ("front", -1): "towards the back",
}  # fmt: skip
#: Of each face the coordinate along its y, and that of its stroke with the way into the steel.
_ACROSS: dict[str, Coordinate] = {"v": "up", "h": "up", "o": "front", "u": "front"}
_INWARD: dict[str, tuple[Coordinate, int]] = {
    "v": ("front", -1), "h": ("front", 1), "o": ("up", -1), "u": ("up", 1),
}  # fmt: skip


class HeldUp(Struct, frozen=True):
    """A hole of the section at a spindle, in the program's axes."""

    spindle: Spindle
    profile: Profile
    y: float  #: of the hole on the face
    x: float  #: machine X for a hole `FROM_START` behind the front of the bar
    across: float
    enters: float  #: of the stroke's axis, where the point touches the face
    leaves: float  #: and where it is through the wall
    follows_depth: bool  #: or else the stroke has fixed ends, and these are they
    across_way: int  #: sign by which the axis across grows along y of the face
    stroke_way: int  #: sign by which the axis of the stroke grows into the steel

    @property
    def sentence(self) -> str:
        """Where the hole goes, to be measured at the machine."""
        s, size = self.spindle, self.profile.face_width(self.spindle.face)
        side = " from the front" if s.face == "v" else " from behind" if s.face == "h" else ""
        return (
            f"{s.name}, spindle {s.number}: a hole in the {FACE_NAMES[s.face]}{side} ({s.face}) "
            f"of {self.profile.name}, {FROM_EDGE:g} mm from {_EDGES[s.face]} (y {self.y:g} of "
            f"{size:g}) and {FROM_START:g} mm behind the front of the bar, is drilled at X "
            f"{self.x:g}, {s.across.axis} {_plain(self.across)}; the point {self._stroke}"
        )

    @property
    def _stroke(self) -> str:
        axis, enters, leaves = self.spindle.stroke.axis, _plain(self.enters), _plain(self.leaves)
        if self.follows_depth:
            return f"enters at {axis} {enters} and is through at {leaves}"
        return f"goes from {axis} {enters} to {leaves}"


def held_up(machine: Machine) -> tuple[HeldUp, ...]:
    """The hole at each spindle of a line; none for a machine without a drill."""
    if machine.drill is None:
        return ()
    taken = machine.layout.profiles if machine.layout else ()
    name = _EXAMPLES[next((code for code in taken if code in _EXAMPLES), "I")]
    measures = measures_of(name)
    if measures is None:
        raise KeyError(name)
    height, width, flange, web, radius = measures[1]
    profile = Profile(measures[0], name, height, width, flange, web, radius)
    held = []
    for spindle in machine.spindles:
        face, position, bottom = spindle.face, spindle.across.position, spindle.stroke.bottom
        y = FROM_EDGE if face in ("v", "h") else profile.face_width(face) - FROM_EDGE
        values = formula_values(profile, face, machine.drill) | {"y": y, "depth": 0.0, "tip": 0.0}
        enters, leaves = bottom(values), bottom(values | {"depth": values["thickness"]})
        follows_depth = leaves != enters
        if not follows_depth:
            enters = spindle.stroke.retract(values)
        held.append(HeldUp(
            spindle, profile, y, machine.drill.x + FROM_START, position(values), enters, leaves,
            follows_depth,
            1 if position(values | {"y": y + 1.0}) >= position(values) else -1,
            1 if leaves >= enters else -1,
        ))  # fmt: skip
    return tuple(held)


def hand_faults(held: tuple[HeldUp, ...], source: Source) -> Iterator[Diagnostic]:
    """An error for a spindle whose axis across grows another way than that letter does elsewhere.

    Strokes count where all of one letter agree: of two heads that face each other each may count
    into the steel.
    """
    first: dict[tuple[Axis, Coordinate], tuple[int, str]] = {}
    strokes: dict[tuple[Axis, Coordinate], dict[int, str]] = {}
    for one in held:
        coordinate, inward = _INWARD[one.spindle.face]
        key = one.spindle.stroke.axis, coordinate
        strokes.setdefault(key, {}).setdefault(one.stroke_way * inward, one.spindle.name)
    for key, ways in strokes.items():
        if len(ways) == 1:
            first[key] = next(iter(ways.items()))
    for one in held:
        axis, coordinate = one.spindle.across.axis, _ACROSS[one.spindle.face]
        own = one.across_way, one.spindle.name
        way, other = first.setdefault((axis, coordinate), own)
        if way != one.across_way:
            yield HAND.at(
                source, axis=axis, way=_WAYS[coordinate, one.across_way], name=one.spindle.name,
                other_way=_WAYS[coordinate, way], other=other, face=one.spindle.face,
            )  # fmt: skip


def _plain(value: float) -> str:
    return f"{round(value, 3) + 0.0:g}"
