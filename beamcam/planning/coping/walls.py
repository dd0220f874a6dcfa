"""The walls of a section as a torch from outside and over the web comes to them.

___o___      The torch looks at o, v and u. Over the web (v) it keeps `near` off the flanges:
   |   <- near    its width and the root fillet. What is left of a cut, the root, is made from
   |  v           outside of the flange, which is then cut as deep as flange and root together.
___|___
   u

A T lies on its side, as an I that has no upper flange: u looks at its flange, v at its stem.
"""

from collections.abc import Sequence
from math import inf, radians, sqrt, tan
from typing import Any

from msgspec import Struct
from msgspec.structs import replace

from beamcam.geometry.curves import Point
from beamcam.machine.coper import Coper
from beamcam.model.part import Face, Feature, Part, Profile
from beamcam.model.section import corners
from beamcam.planning.turning import TURNS, turned

#: Of a T about its length, so that its flange, in the file flat on the h side, stands at Y 0.
ON_ITS_SIDE = next(t for t in TURNS if (t.swap, t.reverse_y, t.reverse_z) == (True, True, False))
OPEN = ("L", "T")  #: sections without an upper flange, as they lie
WEB_AMID = ("I", "T")  #: sections whose web stands in the middle of their flanges
ON_END = 1e-6  #: mm; a cut that begins on a skew end lies there but for rounding
EDGE = 0.05  #: mm; what lies so near to an edge of a wall is that edge


class Root(Struct, frozen=True):
    """Where another wall stands on a wall, with its fillets."""

    face: Face  #: of the other wall
    low: float  #: least y that a cut keeps off, or of a flange that with the fillet
    high: float
    inner: float = 0.0  #: on a web the y of the flange's inner surface


class EndLine(Struct, frozen=True):
    """Where a wall of a piece ends that comes cut: x = at + slope y, at its outermost."""

    at: float
    slope: float
    play: float = 0.0  #: how much farther in it may be drawn, through the thickness of the wall

    def x(self, y: float) -> float:
        return self.at + self.slope * y


class Wall(Struct, frozen=True):
    """The wall that a face looks at."""

    face: Face
    width: float  #: of the face
    thickness: float
    low: float  #: least y that the torch comes to; -inf at a free edge
    high: float  #: greatest y; inf at a free edge
    roots: tuple[Root, ...]  #: along rising y
    root_depth: float = 0.0  #: of a cut from outside through a root, with what it is cut deeper
    fillets: float = 0.0  #: how much thicker the wall is at `low` and `high` by its fillets
    #: Of a piece that comes cut, its start and its end; None of a bar.
    ends: tuple[EndLine, EndLine] | None = None
    open: Any = None  #: of shapely; the holes of a piece that are there already, or None

    def holds(self, place: Point) -> bool:
        """Whether there is steel of the bar or piece at a place, and the torch comes to it."""
        x, y = place
        if not max(self.low, 0.0) <= y <= min(self.high, self.width):
            return False
        if self.ends is None:
            return True
        return self.ends[0].x(y) - ON_END <= x <= self.ends[1].x(y) + ON_END

    def crossed(self, path: Sequence[Point], most: float) -> Point | None:
        """A place where a path goes through a hole that is there, for more than `most` mm."""
        from shapely import LineString

        if self.open is None:
            return None
        over = self.open.intersection(LineString(path))
        return (over.centroid.x, over.centroid.y) if over.length > most else None


def laid(part: Part) -> Part:
    """A part as it lies under the torch: a T on its side, all it has on the faces u and v."""
    if part.profile.code != "T":
        return part
    lying = turned(part, ON_ITS_SIDE)
    there = turned(replace(part, features=part.made or ()), ON_ITS_SIDE).features
    made = None if part.made is None else tuple(map(_seen, there))
    return replace(lying, features=tuple(map(_seen, lying.features)), made=made)


def _seen(feature: Feature) -> Feature:
    """A feature of a plate of a T, on the side of it that the torch looks at."""
    seen = {"o": "u", "h": "v"}.get(getattr(feature, "face", ""))
    return feature if seen is None else replace(feature, face=seen)


def walls_of(profile: Profile, coper: Coper, cut_height: float) -> dict[Face, Wall]:
    """The walls of a section as it lies, by the face that the torch looks at."""
    height, width, radius = profile.height, profile.width, profile.radius
    flange, web = profile.flange_thickness, profile.web_thickness or 0.0
    near = coper.reach_beside(radius, cut_height)
    low, high = flange + near, (inf if profile.code in OPEN else height - flange - near)
    roots = [Root("u", 0.0, flange + near, flange)]
    if profile.code not in OPEN:
        roots.append(Root("o", height - flange - near, height, height - flange))
    rise = radius - sqrt(radius**2 - (radius - near) ** 2) if near < radius else 0.0
    sides = 2 if profile.code in WEB_AMID else 1
    walls = {"v": Wall("v", height, web, low, high, tuple(roots), 0.0, sides * rise)}
    middle = (width - web) / 2 if profile.code in WEB_AMID else 0.0
    back = middle - radius if profile.code in WEB_AMID else 0.0
    root = (Root("v", back, middle + web + radius),)
    depth = flange + near + coper.root_over
    for face in ("u",) if profile.code in OPEN else ("o", "u"):
        walls[face] = Wall(face, width, flange, -inf, inf, root, depth)
    return walls


def ends_on(face: Face, part: Part) -> tuple[EndLine, EndLine]:
    """Where a wall of a piece ends by the header's cuts: x = c - y tan(web) - z tan(flange).

    Either plane goes through the outermost corner of the section, at x 0 or at the length.
    """
    profile, cuts, found = part.profile, part.cuts, []
    web = profile.web_thickness or 0.0
    back = (profile.width - web) / 2 if profile.code in WEB_AMID else 0.0
    edge = profile.height - profile.flange_thickness if face == "o" else 0.0
    outermost = corners(profile, part.section)
    if profile.code == "T":
        flange, front = profile.flange_thickness, back + web
        ends = (0.0, 0.0), (0.0, profile.width), (flange, 0.0), (flange, profile.width)
        outermost = (*ends, (profile.height, back), (profile.height, front))
    for side, web_deg, flange_deg in (
        (-1.0, cuts.web_start, cuts.flange_start), (1.0, cuts.web_end, cuts.flange_end)
    ):  # fmt: skip
        by_y, by_z = tan(radians(web_deg)), tan(radians(flange_deg))
        leans = [side * (y * by_y + z * by_z) for y, z in outermost]
        far = (0.0 if side < 0.0 else part.length) + side * min(leans)
        slope, across = (by_y, by_z) if face == "v" else (by_z, by_y)
        near = back if face == "v" else edge
        thick = web if face == "v" else profile.flange_thickness
        surfaces = [far - across * (near + k * thick) for k in (0.0, 1.0)]
        at = min(surfaces) if side < 0.0 else max(surfaces)
        found.append(EndLine(at, -slope, abs(across) * thick))
    return found[0], found[1]
