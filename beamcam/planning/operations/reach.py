"""Reach of a machine's spindles on the faces of a section."""

from collections.abc import Mapping
from math import inf

from msgspec import Struct
from msgspec.structs import replace

from beamcam.caches import PerObjectAndKey
from beamcam.errors import Diagnostic, error
from beamcam.machine.machine import Machine
from beamcam.model.part import Face, Hole, Part, Profile, Slot
from beamcam.model.section import NO_PLATE
from beamcam.model.weight import lip_of
from beamcam.planning.rules import NO_SPINDLE

OFF_FACE = error("plan-off-face",
    "found a hole at x {x}, y {y} on face {face}; expected it within {length} x {width} mm",
    "A hole beyond its face is a mistake of the exporter; the drill would meet no "
    "steel.")  # fmt: skip
IN_THE_WAY = error("plan-reach",
    "found {what} at y {y} on face {face}; expected y from {least} to {greatest}, the {wall} is in "
    "the tool's way",
    "A tool that comes to the web between the flanges needs room beside them, and beside the lips "
    "of a C, which are as long as its weight per metre says, or 0.6 of the "
    "flange.")  # fmt: skip

RULES = (OFF_FACE, IN_THE_WAY)


class Reach(Struct, frozen=True):
    """Reach of a spindle on a face of a section."""

    spindle: int  #: number
    width: float  #: of the face
    least: float  #: y between which nothing is in the tool's way
    greatest: float
    wall: str = "flange"  #: that is in its way beyond


Reached = Mapping[Face, Reach]


def _clear_between(profile: Profile, face: Face) -> tuple[float, float]:
    """Range of y in which a tool reaches a face; unbounded where no flange is beside it."""
    if profile.code == "T" and face in ("o", "u"):  # its stem, over the flange
        return profile.web_thickness or 0.0, inf
    if face != "v" or profile.code not in ("I", "U", "C", "L"):
        return -inf, inf
    flange = profile.flange_thickness
    return flange, (inf if profile.code == "L" else profile.height - flange)


def _reached(machine: Machine, profile: Profile) -> Reached:
    out = NO_PLATE.get(profile.code, ())
    return {
        s.face: Reach(s.number, profile.face_width(s.face), *_clear_between(profile, s.face))
        for s in machine.spindles
        if s.face not in out
    }


#: The faces of a section that the machine's spindles reach.
reached_by: PerObjectAndKey[Machine, Profile, Reached] = PerObjectAndKey(
    "planning.machines", "planning.reaches", _reached
)


def reached_on(machine: Machine, part: Part) -> Reached:
    """The faces of a part that the machine's spindles reach: between the lips of a C too."""
    reached, lip = reached_by(machine, part.profile), lip_of(part)
    if "v" not in reached or not lip or lip <= reached["v"].least:
        return reached
    inside = replace(reached["v"], least=lip, greatest=part.profile.height - lip, wall="lip")
    return {**reached, "v": inside}


def refuse_face(shape: Hole | Slot, what: str, reached: Reached) -> Diagnostic:
    """That no spindle comes to the face of a hole or slot."""
    expected = f"one of {', '.join(reached)}" if reached else "none, as the machine has no spindle"
    return NO_SPINDLE.at(shape.source, kind=what, found=shape.face, expected=expected)


def refuse_place(
    shape: Hole | Slot, x: float, y: float, part: Part, reach: Reach
) -> Diagnostic | None:
    """Why a tool does not come to a circle of a hole or slot, about x and y; None if it does."""
    if not (0 <= x <= part.length and 0 <= y <= reach.width):
        return OFF_FACE.at(
            shape.source, x=f"{x:g}", y=f"{y:g}", face=shape.face, length=f"{part.length:g}",
            width=f"{reach.width:g}",
        )  # fmt: skip
    radius = shape.diameter / 2
    if not reach.least <= y - radius or not y + radius <= reach.greatest:
        return IN_THE_WAY.at(
            shape.source, what=f"a hole of diameter {shape.diameter:g}", y=f"{y:g}",
            face=shape.face, least=f"{reach.least + radius:g}",
            greatest=f"{min(reach.greatest, reach.width) - radius:g}", wall=reach.wall,
        )  # fmt: skip
    return None
