"""A spindle over a section: from the program's Y and Z to a place and a depth in a wall.

    across = a + b y                 of the tool's axis, by the machine's formula
    stroke = surface + way depth     of the tool's point; depth counts from the wall's surface

Both are straight lines, so that two values of each formula give them. Where a stroke does not
follow the depth, its axis counts from the outermost steel on the spindle's side.
"""

from math import nan

from msgspec import Struct

from beamcam.machine.drill import Spindle
from beamcam.machine.formula import FORMULA_NAMES
from beamcam.machine.machine import Machine
from beamcam.model.part import Profile
from beamcam.solid.section import Wall, walls

AXES = {"X": 0, "Y": 1, "Z": 2}


class Tip(Struct, frozen=True):
    """Where the point of a tool is: bar x and y on the face, and its depth in the wall."""

    x: float
    y: float
    depth: float


class Reach(Struct, frozen=True):
    """One spindle over one section."""

    number: int
    face: str
    wall: Wall
    front: float  #: how far the outermost steel on its side stands before the wall
    across: int  #: index of its axes in X, Y, Z
    stroke: int
    across_at: float
    across_per_y: float
    surface: float
    surface_per_y: float
    way: float

    def tip(self, bar_x: float, place: tuple[float, float, float]) -> Tip:
        """The point of its tool for a place of the program's axes."""
        y = (place[self.across] - self.across_at) / self.across_per_y
        depth = self.way * (place[self.stroke] - self.surface - self.surface_per_y * y)
        return Tip(bar_x, y, depth)


def reaches(machine: Machine, profile: Profile) -> dict[int, tuple[Reach, ...]]:
    """The spindles that each number of the program chooses, where the section has their wall."""
    sides = walls(profile)
    found: dict[str, Reach] = {
        s.face: _reach(s, machine, profile, sides[s.face])
        for s in machine.spindles
        if s.face in sides
    }
    chosen: dict[int, tuple[Reach, ...]] = {
        s.number: (found[s.face],) for s in machine.spindles if s.face in found
    }
    for pair in machine.pairs:
        if all(face in found for face in pair.faces):
            chosen[pair.number] = tuple(found[face] for face in pair.faces)
    return chosen


def _reach(spindle: Spindle, machine: Machine, profile: Profile, wall: Wall) -> Reach:
    size = profile.height if wall.normal == "y" else profile.width
    if profile.code == "B":
        size = wall.thickness
    front = size - wall.surface if wall.inward < 0 else wall.surface
    values = dict.fromkeys(FORMULA_NAMES, 0.0) | {
        "height": profile.height, "width": profile.width,
        "flange_thickness": profile.flange_thickness, "web_thickness": profile.web_thickness or 0.0,
        "thickness": wall.thickness, "face_depth": front,
        "clearance": machine.drill.clearance if machine.drill else nan,
    }  # fmt: skip
    position, bottom = spindle.across.position, spindle.stroke.bottom
    at, per_y = position(values), position(values | {"y": 1.0}) - position(values)
    surface, deeper = bottom(values), bottom(values | {"depth": 1.0})
    slope = bottom(values | {"y": 1.0}) - surface
    way = 1.0 if deeper >= surface else -1.0
    if deeper == surface:  # it strokes a fixed way
        way = 1.0 if surface >= spindle.stroke.start(values) else -1.0
        surface, slope = way * front, 0.0
    return Reach(
        spindle.number, spindle.face, wall, front, AXES[spindle.across.axis],
        AXES[spindle.stroke.axis], at, per_y, surface, slope, way,
    )  # fmt: skip
