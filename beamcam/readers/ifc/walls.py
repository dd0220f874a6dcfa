"""The walls of a section: flat plates of full outer size, as DSTV divides a section (page 13)."""

from typing import Literal

from msgspec import Struct

from beamcam.caches import cached
from beamcam.model.part import Face
from beamcam.model.section import corners
from beamcam.readers.ifc.section import Section
from beamcam.readers.ifc.space import Vec


class Wall(Struct, frozen=True, gc=False):
    """A plate of a section; x along the member, q across it, c through its thickness."""

    face: Face
    normal: Literal["y", "z"]  #: the axis that c runs along; q runs along the other
    low: float  #: minimum c
    high: float  #: maximum c
    width: float  #: q from 0 to this
    outer: bool  #: whether the surface in question is at maximum c

    @property
    def thickness(self) -> float:
        return self.high - self.low

    @property
    def surface(self) -> float:
        """c of the surface that is looked at."""
        return self.high if self.outer else self.low

    def split(self, p: Vec) -> tuple[float, float]:
        """q and c of a point of the member."""
        return (p[2], p[1]) if self.normal == "y" else (p[1], p[2])

    def point(self, x: float, q: float, c: float) -> Vec:
        """The point of the member at x, q and c."""
        return (x, c, q) if self.normal == "y" else (x, q, c)

    @property
    def direction(self) -> Vec:
        """The unit vector along c."""
        return (0.0, 1.0, 0.0) if self.normal == "y" else (0.0, 0.0, 1.0)

    @property
    def across(self) -> Vec:
        """The unit vector along q."""
        return (0.0, 0.0, 1.0) if self.normal == "y" else (0.0, 1.0, 0.0)


@cached("ifc.walls")
def walls_of(section: Section) -> tuple[Wall, ...]:
    """The walls of a section; none of a round or special one."""
    h, b, tf, tw = section.height, section.width, section.flange_thickness, section.web_thickness
    top = Wall("o", "y", h - tf, h, b, True)
    bottom = Wall("u", "y", 0.0, tf, b, False)
    match section.code:
        case "I":
            return (Wall("v", "z", (b - tw) / 2, (b + tw) / 2, h, True), top, bottom)
        case "U" | "C":
            return (Wall("v", "z", 0.0, tw, h, True), top, bottom)
        case "L":
            return (Wall("v", "z", 0.0, tw, h, True), bottom)
        case "T":
            stem = Wall("o", "y", (h - tf) / 2, (h + tf) / 2, b, True)
            return (Wall("v", "z", 0.0, tw, h, True), stem)
        case "M":
            front, back = Wall("v", "z", b - tw, b, h, True), Wall("h", "z", 0.0, tw, h, False)
            return (front, back, top, bottom)
        case "B":
            return (Wall("v", "z", 0.0, b, h, True),)
    return ()


@cached("ifc.corners")
def corner_points(section: Section) -> tuple[tuple[float, float], ...]:
    """(Y, Z) of the outermost points of a section, in which the end cuts reach furthest."""
    found = list(corners(section.profile(""), section.points))
    for wall in () if section.code in ("M", "C") else walls_of(section):
        for q in (0.0, wall.width):
            for c in (wall.low, wall.high):
                found.append((c, q) if wall.normal == "y" else (q, c))
    return tuple(dict.fromkeys(found))
