"""Machined features, and where they lie: from the program's Y and Z to face, position and depth.

The machine file gives both axes of a spindle as formulas: `across` in y of the face, `bottom` of
the stroke in the depth of the hole. Both are straight lines, so two values of each give them:

    across = across_0 + across_per_y * y          y = (across - across_0) / across_per_y
    bottom = surface + way * (depth + tip)        the tip's depth = way * (stroke - surface)

A face may lie at an angle to the stroke, such as the inside of a tapered flange: then its surface
is a straight line in y as well. Where the stroke does not follow the depth the face lies
`face_depth` behind 0, the outermost material on the spindle's side.
"""

from collections.abc import Sequence
from math import inf, nan, pi

from msgspec import Struct

from beamcam.geometry.curves import Curve
from beamcam.machine.machine import Machine
from beamcam.machine.stations import FORMULA_NAMES, Spindle
from beamcam.model.part import Face, Part, Profile

# --- walls ----------------------------------------------------------------------------------------

# Where the walls of a section lie, measured across it; the read-back's own table.
#
# Across the web z counts from the h side (0) to the v side (the section's width), as DSTV's section
# axes have it. What stands here is written from the drawings of the sections and not taken from
# `model`, so that a fault there cannot be on both sides of the comparison.
#
#     code    wall behind v, h            z from            to
#     I       web, in the middle          (width - t) / 2   (width + t) / 2
#     U, C    web, on the h side          0                 t
#     L       leg, on the h side          0                 t
#     T       flange, on the h side       0                 t
#     M       two walls, v has its own    width - t         width
#     B       the plate itself
#
# Behind o and u lie the flanges, outermost; of a T its stem, in the middle of its flange.


def wall_thickness(profile: Profile, face: Face) -> float:
    """Thickness of the wall behind a face, mm; 0 where it is not known."""
    if face in ("o", "u") and profile.code != "B":
        return profile.flange_thickness
    return profile.web_thickness or 0.0


def wall_between(profile: Profile, face: Face) -> tuple[float, float]:
    """Between which z of the section (y behind o and u) the wall behind a face lies, mm."""
    height, flange = profile.height, profile.flange_thickness
    width, web = profile.width, profile.web_thickness or 0.0
    if face in ("o", "u"):
        low = height - flange if face == "o" else 0.0
        low = (height - flange) / 2 if profile.code == "T" else low
        return low, low + flange
    low = (width - web) / 2 if profile.code == "I" else 0.0
    if profile.code == "M" and face == "v":
        low = width - web
    return low, low + web


def lip_length(part: Part) -> float:
    """How far the lips of a C reach over its web, from the outside of its flange; else 0.

    Where the part does not say it: the length of the sheet it is bent of is its area by its
    thickness, and the middle line of the section is as long. What is shorter than a fifth of the
    flange is no lip (EN 1993-1-3, 5.2): then the weight is not that of the section, and the longest
    that is made is taken.
    """
    profile, sheet = part.profile, part.profile.web_thickness
    if profile.code != "C" or not sheet:
        return 0.0
    if profile.lip is not None:
        return profile.lip
    middle_line = part.weight / 7.85e-3 / sheet  # 7.85 g/cm3, kg/m
    bend = profile.radius + sheet
    flat = profile.height - 2 * bend + 2 * (profile.width - 2 * bend)
    bends = 4 * pi / 2 * (profile.radius + sheet / 2)
    lip = bend + (middle_line - flat - bends) / 2
    if profile.width / 5 <= lip <= profile.height / 2:
        return lip
    return 3 * profile.width / 5


def in_stem(curves: Sequence[Curve], profile: Profile, face: Face) -> bool:
    """Whether a line on the flange of a T runs into its stem, which stands in the middle of it."""
    if profile.code != "T" or face != "v":
        return False
    middle, half = profile.height / 2, profile.flange_thickness / 2 - 1e-6
    ys = [y for curve in curves for y in curve.bbox[1::2]]
    return min(ys) < middle + half and max(ys) > middle - half


WEBBED = ("I", "U", "C", "L", "T")  #: sections whose web lies behind their flanges
_AXIS_INDEX = {"X": 0, "Y": 1, "Z": 2}


class Tip(Struct, frozen=True, gc=False):
    """Where the tip of a spindle's tool stands."""

    across: float  #: places of the two axes
    stroke: float
    y: float  #: on the face
    depth: float  #: in the material behind the face; negative before it
    beside: float  #: in the outermost material beside it; not above 0 where it moves freely


NOWHERE = Tip(nan, nan, nan, nan, nan)  #: before the first move


class Station(Struct, frozen=True):
    """A spindle over a section."""

    spindle: Spindle
    number: int  #: of the spindle
    face: str
    across: int  #: index of its axis in X, Y, Z
    stroke: int
    across_0: float
    across_per_y: float
    surface: float  #: stroke coordinate at which the tip touches the face at y 0
    surface_per_y: float  #: and how much farther for each mm of y
    face_depth: float  #: distance of the outermost material on that side from the face
    way: float  #: +1 if the stroke axis counts into the material, or -1

    surface_known: bool  #: whether the section is known far enough to say where the face lies
    retract_clearance: float  #: clearance that the machine keeps beside the bar
    approach_clearance: float  #: and before the face, where the feed begins
    clear_from: float  #: y between which only the face itself is in the way, flanges beyond
    clear_to: float
    limits: tuple[tuple[int, str, float, float], ...]  #: axis index, name, minimum and maximum

    def tip_depth(self, stroke: float, y: float) -> float:
        """Depth of the tip in the material behind the face; negative before it."""
        return self.way * (stroke - self.surface - self.surface_per_y * y)

    def tip(self, across: float, stroke: float) -> Tip:
        """The tip for places of both axes."""
        y = (across - self.across_0) / self.across_per_y
        depth = self.way * (stroke - self.surface - self.surface_per_y * y)  # as `tip_depth`
        return Tip(across, stroke, y, depth, depth + self.face_depth)


class Choice(Struct, frozen=True):
    """The selection of a spindle word: one station, or two that move as one."""

    number: int
    stations: tuple[Station, ...]


def choices_of(machine: Machine, profile: Profile | None, lip: float = 0.0) -> dict[int, Choice]:
    """The stations of each spindle number of the program, on a section as far as it is known.

    `lip` is the length of its lips.
    """
    stations: dict[str, Station] = {
        s.face: _station(s, machine, profile, lip) for s in machine.spindles
    }
    choices = {s.number: Choice(s.number, (stations[s.face],)) for s in machine.spindles}
    # Two spindles at once into the stem of a T would meet in it.
    for pair in machine.pairs if profile is None or profile.code != "T" else ():
        choices[pair.number] = Choice(pair.number, tuple(stations[f] for f in pair.faces))
    return choices


def stroke_values(machine: Machine, profile: Profile | None, face: Face) -> dict[str, float]:
    """The names that the machine's formulas may use, for a face of a section."""
    values = dict.fromkeys(FORMULA_NAMES, 0.0)
    values["clearance"] = machine.drill.clearance if machine.drill else 0.0
    if profile is not None:
        height, width, (low, high) = profile.height, profile.width, wall_between(profile, face)
        values |= {
            "height": height, "width": width, "flange_thickness": profile.flange_thickness,
            "web_thickness": profile.web_thickness or 0.0,
            "thickness": wall_thickness(profile, face),
        }  # fmt: skip
        if profile.code in WEBBED:  # how far the face lies behind the outermost steel on its side
            behind = {"v": width - high, "h": low, "o": height - high, "u": low}
            values["face_depth"] = behind[face]
    return values


def _station(spindle: Spindle, machine: Machine, profile: Profile | None, lip: float) -> Station:
    values, face = stroke_values(machine, profile, spindle.face), spindle.face
    across_0 = spindle.across.position(values)
    per_y = spindle.across.position({**values, "y": 1.0}) - across_0
    bottom, retract = spindle.stroke.bottom, spindle.stroke.retract(values)
    shallow, deeper = bottom(values), bottom({**values, "depth": 1.0})
    face_depth, surface_per_y = values["face_depth"], 0.0
    if deeper != shallow:
        way = 1.0 if deeper > shallow else -1.0
        surface = shallow
        surface_per_y = bottom({**values, "y": 1.0}) - shallow
    else:
        way = 1.0 if shallow >= retract else -1.0
        surface = way * face_depth
    clear_from, clear_to, surface_known = -inf, inf, False
    if profile is not None:
        if face_depth > 0 and profile.code in ("I", "U", "C", "L"):
            clear_from = max(profile.flange_thickness, lip)
            clear_to = inf if profile.code == "L" else profile.height - clear_from
        elif profile.code == "T" and face in ("o", "u"):
            clear_from = profile.web_thickness or 0.0
        # A face before a web lies where the section says only if that says the web's thickness.
        before_web = face in ("v", "h") and profile.code in WEBBED
        surface_known = profile.web_thickness is not None or not (profile.code == "T" or before_web)
    retract_clearance = -(way * (retract - surface) + face_depth)
    approach_clearance = retract_clearance + face_depth
    if spindle.stroke.approach is not None:
        approach_clearance = -way * (spindle.stroke.approach(values) - surface)
    limits = tuple(
        (_AXIS_INDEX[a.moves], a.name, *a.limits)
        for a in machine.axes
        if a.spindle == spindle.number and a.moves in _AXIS_INDEX
    )
    return Station(
        spindle, spindle.number, face, _AXIS_INDEX[spindle.across.axis],
        _AXIS_INDEX[spindle.stroke.axis], across_0, per_y, surface, surface_per_y, face_depth, way,
        surface_known, retract_clearance, approach_clearance, clear_from, clear_to, limits,
    )  # fmt: skip


def limits_of(machine: Machine, moves: str) -> tuple[str, float, float]:
    """Name, minimum and maximum of the axis that is not a spindle's and moves by `moves`.

    The angle of a saw is also within the saw's own limits.
    """
    name, least, greatest = moves, -inf, inf
    for axis in machine.axes:
        if axis.moves == moves and axis.spindle is None:
            name, (least, greatest) = axis.name, axis.limits
            break
    if moves == "angle" and machine.saw is not None:
        return name, max(least, machine.saw.min_angle), min(greatest, machine.saw.max_angle)
    return name, least, greatest


# --- machined features ----------------------------------------------------------------------------

# What a program made, in machine coordinates.


class Cut(Struct, frozen=True, gc=False):
    """One saw cut."""

    line: int
    x: float  #: machine X
    angle: float  #: degrees, in the machine's counting
    feed_mm_min: float
    tilt: float = 0.0  #: degrees, in the machine's counting


class Bore(Struct, frozen=True, gc=False):
    """One hole, as its spindle made it; a stroke of two spindles makes two."""

    line: int  #: of the deepest feed
    face: str
    x: float  #: machine X
    y: float  #: on the face
    diameter: float  #: of the tool
    tip_depth: float  #: of the tool's tip, from the surface of the face
    spindle: int  #: number that the program chose it by
    feed_mm_min: float
    stroke: float  #: where the stroke axis turned back
    kind: str = "drill"  #: of the tool
    turning: int = 0  #: the M word that started the spindle; 0 if it is stopped
    pitch: float = 0.0  #: that was chosen for a tap
    speed_rpm: float = 0.0  #: 0 where the program does not say
    begin: float = 0.0  #: where its feed began on the stroke axis


class MachinedPath(Struct, frozen=True, gc=False):
    """A path that a tool followed in the material."""

    line: int  #: of its first point
    face: str
    kind: str  #: of the tool
    points: tuple[tuple[float, float], ...]  #: machine X and y on the face
    diameter: float  #: of the tool
    min_depth: float  #: of the tool's tip, from the surface of the face
    max_depth: float
    spindle: int
    feed_mm_min: float


class StampedText(Struct, frozen=True, gc=False):
    """A text that a stamp or printer letters."""

    line: int
    face: str
    kind: str  #: of the unit
    text: str
    x: float  #: machine X
    y: float  #: on the face
    height: float
    angle: float  #: degrees


Thing = Cut | Bore | MachinedPath | StampedText


class MachinedFeatures(Struct, frozen=True):
    """All that a program makes, in its order."""

    section: tuple[tuple[str, float], ...]  #: what it says about the bar, by field name
    cuts: tuple[Cut, ...]
    bores: tuple[Bore, ...]
    paths: tuple[MachinedPath, ...]
    order: tuple[Thing, ...]  #: all of them, as they follow one another
    texts: tuple[StampedText, ...] = ()
