"""The walls of a section as a torch from outside and over the web comes to them.

___o___      The torch looks at o, v and u. Over the web (v) it keeps `near` off the flanges:
   |   <- near    its width and the root fillet. What is left of a cut, the root, is made from
   |  v           outside of the flange, which is then cut as deep as flange and root together.
___|___
   u

A T lies on its side, as an I that has no upper flange: u looks at its flange, v at its stem. A C
lies on its lips, its web up, which the torch sees from outside:

     __v__      A cut of a flange goes through the root with a row that is as deep as flange and
    |     |     bend, and through the lip, which the torch meets at its edge, with one that is as
    |     |     deep as the lip is long. Both begin over the flange between them and end beyond
    '-   -'     its edges, which are round.
"""

from math import inf, sqrt
from typing import Any

from msgspec import Struct
from msgspec.structs import replace

from beamcam.geometry.curves import Point
from beamcam.machine.coper import Coper
from beamcam.model.part import Contour, Face, Feature, Part, Profile
from beamcam.planning.turning import TURNS, turned

#: Of a T about its length, so that its flange, in the file flat on the h side, stands at Y 0.
ON_ITS_SIDE = next(t for t in TURNS if (t.swap, t.reverse_y, t.reverse_z) == (True, True, False))
#: Of a C about its length, so that its web is up.
ON_ITS_LIPS = next(t for t in TURNS if (t.swap, t.reverse_y, t.reverse_z) == (False, True, True))
OPEN = ("L", "T")  #: sections without an upper flange, as they lie
WEB_AMID = ("I", "T")  #: sections whose web stands in the middle of their flanges
ON_END = 1e-6  #: mm; a cut that begins on a skew end lies there but for rounding
LAP = 1.0  #: mm that cuts of a flange and of its lip overlap
EDGE = 0.05  #: mm; what lies so near to an edge of a wall is that edge


class Root(Struct, frozen=True):
    """Where another wall stands on a wall, with its fillets."""

    face: Face  #: of the other wall
    low: float  #: least y that a cut keeps off, or of a flange that with the fillet
    high: float
    inner: float = 0.0  #: on a web the y of the flange's inner surface
    stands: Point | None = None  #: on a flange the y between which the web itself does; not of a C
    radius: float = 0.0  #: on a flange that of the fillets

    @property
    def thick(self) -> float:
        """Of a web, how thick the flange is."""
        return self.inner - self.low if self.low == 0.0 else self.high - self.inner

    def y(self, depth: float) -> float:
        """Of a web, its y so far below the outside of the flange."""
        return depth if self.low == 0.0 else self.high - depth

    def band(self, near: float, far: float) -> tuple[float, float]:
        """Of a web, its y from one depth to another."""
        return min(self.y(near), self.y(far)), max(self.y(near), self.y(far))

    def inside(self, depth: float) -> tuple[float, float]:
        """The y of a web from the flange's inner surface to where a pass that is so deep ends."""
        return self.band(self.thick + EDGE, max(self.high - self.low, depth - EDGE))


class EndLine(Struct, frozen=True):
    """Where a wall ends: x = at + slope y."""

    at: float
    slope: float
    play: float = 0.0  #: how much farther in it may be drawn, through the thickness of the wall
    b_deg: float = 0.0  #: tilt of the torch that cuts it

    def x(self, y: float) -> float:
        return self.at + self.slope * y

    def is_beside(self, place: Point, far: float) -> bool:
        """Whether a place lies within so many mm of it."""
        return abs(place[0] - self.x(place[1])) <= far * sqrt(1.0 + self.slope**2)


class PlannedWall(Struct, frozen=True):
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
    #: Of a bar the skew ones that it is cut to, at its start and its end.
    skew: tuple[EndLine | None, EndLine | None] = (None, None)
    open: Any = None  #: of shapely; the holes of a piece that are there already, or None
    lip: float = 0.0  #: y from 0 in which a flange is cut with its lip, or not at all
    lip_depth: float = 0.0  #: of a cut from outside through a lip, with what it is cut deeper

    def holds(self, place: Point) -> bool:
        """Whether there is steel of the bar or piece at a place, and the torch comes to it."""
        x, y = place
        if not max(self.low, 0.0) <= y <= min(self.high, self.width):
            return False
        if self.ends is None:
            return True
        return self.ends[0].x(y) - ON_END <= x <= self.ends[1].x(y) + ON_END

    def is_free(self, place: Point) -> bool:
        """Whether a place lies on an edge of it that a torch comes over."""
        return (self.low == -inf and place[1] <= 0.0) or (
            self.high == inf and place[1] >= self.width
        )


def web_back(profile: Profile) -> float:
    """The z of the web's back as a section lies."""
    behind = profile.width - (profile.web_thickness or 0.0)
    if profile.code in WEB_AMID:
        return behind / 2
    return behind if profile.code == "C" else 0.0


def laid(part: Part) -> Part:
    """A part as it lies under the torch: a T on its side, all it has on the faces u and v, a C on
    its lips."""
    turn = {"T": ON_ITS_SIDE, "C": ON_ITS_LIPS}.get(part.profile.code)
    if turn is None:
        return part
    lying = turned(part, turn)
    there = turned(replace(part, features=part.made or ()), turn).features
    if part.profile.code == "C":
        return replace(lying, made=None if part.made is None else there)
    made = None if part.made is None else tuple(_seen(one, part.profile) for one in there)
    features = tuple(_seen(one, part.profile) for one in lying.features)
    return replace(lying, features=features, made=made)


def _seen(feature: Feature, tee: Profile) -> Feature:
    """A feature of a plate of a T, on the side of it that the torch looks at."""
    seen: Face | None = {"o": "u", "h": "v"}.get(getattr(feature, "face", ""))
    if seen is None:
        return feature
    if isinstance(feature, Contour):
        thick = tee.flange_thickness if seen == "u" else tee.web_thickness or 0.0
        return from_behind(feature, seen, thick)
    return replace(feature, face=seen)


def from_behind(contour: Contour, face: Face, thickness: float) -> Contour:
    """The contour of a wall that is drawn on its other side, its bevels as they are seen from here:
    their lands count from the far side."""
    ends = [b.land or (thickness if b.angle < 0.0 else 0.0) for b in contour.bevels]
    bevels = tuple(
        replace(b, angle=-b.angle, land=thickness - end)
        for b, end in zip(contour.bevels, ends, strict=True)
    )
    return replace(contour, face=face, bevels=bevels)


def walls_of(profile: Profile, coper: Coper, cut_height: float) -> dict[Face, PlannedWall]:
    """The walls of a section as it lies, by the face that the torch looks at."""
    height, width, radius = profile.height, profile.width, profile.radius
    flange, web = profile.flange_thickness, profile.web_thickness or 0.0
    near = coper.reach_beside(radius, cut_height)
    if profile.code == "C":  # over the bend a jet would go on along the flange
        near = max(radius, max(row.kerf for row in coper.rows) / 2)
    low, high = flange + near, (inf if profile.code in OPEN else height - flange - near)
    roots = [Root("u", 0.0, flange + near, flange)]
    if profile.code not in OPEN:
        roots.append(Root("o", height - flange - near, height, height - flange))
    rise = radius - sqrt(radius**2 - (radius - near) ** 2) if near < radius else 0.0
    sides = 2 if profile.code in WEB_AMID else 1
    walls = {"v": PlannedWall("v", height, web, low, high, tuple(roots), 0.0, sides * rise)}
    back = web_back(profile)
    ends = back - radius if back else 0.0, back + web + radius
    stands = None if profile.code == "C" else (back, back + web)
    last = min(ends[1], width) if profile.code == "C" else ends[1]
    root = (Root("v", ends[0], last, stands=stands, radius=radius),)
    depth = flange + near + coper.root_over
    for face in ("u",) if profile.code in OPEN else ("o", "u"):
        walls[face] = PlannedWall(face, width, flange, -inf, inf, root, depth)
        if profile.code == "C" and profile.lip:
            bend = web + radius
            beside = LAP + max(row.kerf for row in coper.rows) / 2
            walls[face] = replace(
                walls[face], low=bend, lip=bend + beside, lip_depth=profile.lip + coper.root_over
            )
    return walls


def over_lip(flange: PlannedWall) -> PlannedWall:
    """What of a flange is cut with its lip."""
    return replace(
        flange, low=-inf, high=flange.low + LAP, roots=(), root_depth=0.0,
        thickness=flange.lip_depth,
    )  # fmt: skip
