"""The section that a torch goes round, worked out from its figures for the read-back alone.

Its plates as boxes in (Y, Z), its root fillets, and the plane that each face is. A T lies on its
side: its flange stands at Y 0, seen from u, and its stem goes off it along Y, seen from v. A C lies
on its lips, a sheet that is bent four times, its web up.
"""

from collections.abc import Sequence
from functools import cached_property
from itertools import pairwise
from math import cos, hypot, inf, pi, sin
from typing import TYPE_CHECKING, Any, Literal

from beamcam.machine.coper import Coper
from beamcam.model.part import Profile

if TYPE_CHECKING:
    from beamcam.geometry.array_types import Floats

FILLET_STEPS = 48  #: chords of a fillet, 0.004 mm off one of 30 mm
ARC = 16  #: sides of a quarter of a kerf's end
Box = tuple[float, float, float, float]  #: least Y and Z, greatest Y and Z


def pieces_of(shape: Any) -> list[Any]:
    """The single shapes that one of shapely consists of."""
    return [one for one in getattr(shape, "geoms", (shape,)) if not one.is_empty]


def areas_of(shape: Any) -> Any:
    """A region without the lines and places that operations on regions may leave beside it."""
    from shapely import union_all

    if shape.geom_type in ("Polygon", "MultiPolygon"):
        return shape
    return union_all([one for one in pieces_of(shape) if one.area > 0.0])


def line_of(points: Sequence[tuple[float, float]]) -> Any:
    """A path as a line, or as a place where it has no length."""
    from shapely import Point, linestrings

    return linestrings(points) if len(set(points)) > 1 else Point(points[0])


def kerf_of(points: Sequence[tuple[float, float]], half_kerf: float) -> Any:
    """All that lies within half a kerf of a path.

    That of a connected path is one polygon. GEOS fails at it now and then where a path comes back
    to its start; then it is put together of its segments, and so is that of a path which repeats
    them many times.
    """
    from shapely import LineString, union_all

    if len(points) < 2 * len(set(points)):
        whole = line_of(points).buffer(half_kerf, ARC)
        if whole.geom_type == "Polygon" and whole.is_valid:
            return whole
    ways = [LineString(way) for way in dict.fromkeys(pairwise(points)) if way[0] != way[1]]
    if not ways:
        return line_of(points).buffer(half_kerf, ARC)
    return union_all([way.buffer(half_kerf, ARC) for way in ways])


def narrowed(shape: Any, share: float) -> Any:
    """A shape on a wall as a torch sees it that is tilted along x, or back again by 1 / share."""
    from shapely.affinity import scale

    return shape if share == 1.0 else scale(shape, share, 1.0, origin=(0.0, 0.0))


def jet_of(points: Sequence[tuple[float, float]], half_kerf: float, share: float) -> Any:
    """What a jet takes of a surface along a path, as wide as its kerf square to itself."""
    seen = [(x * share, y) for x, y in points]
    return narrowed(kerf_of(seen, half_kerf), 1.0 / share)


class CoperSection:
    """An I, a U or an L, a T on its side, or a C on its lips."""

    def __init__(self, profile: Profile) -> None:
        self.code = profile.code
        self.high, self.wide = profile.height, profile.width
        self.flange, self.web = profile.flange_thickness, profile.web_thickness or 0.0
        self.radius = profile.radius
        self.is_central = self.code in ("I", "T")  #: whether the web stands in their middle
        self.has_upper = self.code in ("I", "U", "C")  #: whether there is a flange at o
        self.back = (self.wide - self.web) / 2 if self.is_central else 0.0
        #: how long lips are, from the outside of their flange, and how wide with their bend
        self.lip = (profile.lip or 0.0) if self.code == "C" else 0.0
        self.bend = self.web + self.radius if self.lip else 0.0
        if self.code == "C":
            self.back = self.wide - self.web
        self.front = self.back + self.web

    @property
    def axis(self) -> tuple[float, float]:
        """Y and Z of the line about which a chuck turns it: the middle of its height and width."""
        return self.high / 2, self.wide / 2

    @property
    def reach(self) -> float:
        """How far from that line it reaches as it turns."""
        return hypot(self.high, self.wide) / 2

    @property
    def faces(self) -> tuple[str, ...]:
        """Those that a torch looks at."""
        return ("v", "o", "u") if self.has_upper else ("v", "u")

    @property
    def web_ends(self) -> tuple[float, float]:
        """Y at which the web ends: a flange's inner surface, of an L or T also a free edge."""
        return self.flange, self.high - self.flange if self.has_upper else self.high

    def extent(self, face: str) -> tuple[float, float]:
        """The least and the greatest y of a wall by itself."""
        return self.web_ends if face == "v" else (0.0, self.wide)

    def thickness(self, face: str) -> float:
        return self.web if face == "v" else self.flange

    def over(self, face: str, y: float, z: float) -> float:
        """How far a place lies outside of the plane of a face, in mm."""
        return {"v": z - self.front, "o": y - self.high, "u": -y}[face]

    def plates(self) -> list[Box]:
        """The boxes of web and flanges."""
        boxes = [(0.0, self.back, self.high, self.front), (0.0, 0.0, self.flange, self.wide)]
        if self.has_upper:
            boxes.append((self.high - self.flange, 0.0, self.high, self.wide))
        if self.lip:
            boxes += [
                (0.0, 0.0, self.lip, self.web),
                (self.high - self.lip, 0.0, self.high, self.web),
            ]
        return boxes

    @cached_property
    def outermost(self) -> list[tuple[float, float]]:
        """Places (Y, Z) at one of which a skew end comes to the end of its bar."""
        if self.code == "C":
            return [*self.steel.convex_hull.exterior.coords]
        return [(y, z) for y0, z0, y1, z1 in self.plates() for y in (y0, y1) for z in (z0, z1)]

    def near(self, coper: Coper, height: float) -> float:
        """How near to a flange the web is cut from over it, by a torch `height` above it."""
        if self.code == "C":
            return max(self.radius, *(row.kerf / 2 for row in coper.rows))
        return coper.reach_beside(self.radius, height)

    def beside_lip(self, coper: Coper) -> float:
        """The y of a flange up to which it is cut as its lip is, 1 mm beyond its bend."""
        return self.bend + 1.0 + max(row.kerf for row in coper.rows) / 2 if self.lip else 0.0

    @cached_property
    def steel(self) -> Any:
        """The section as a shape of shapely."""
        from shapely import Polygon, box, union_all

        if self.code == "C":
            return self._bent()
        shapes = [box(*plate) for plate in self.plates()]
        corners: list[tuple[float, float, Literal[1, -1], Literal[1, -1]]] = [
            (self.flange, self.front, 1, 1)
        ]
        if self.is_central:
            corners.append((self.flange, self.back, 1, -1))
        if self.has_upper:
            inner = self.high - self.flange
            corners += [(inner, y, -1, out) for _, y, _, out in corners]
        r = self.radius
        for y, z, up, out in corners if r > 0.0 else ():
            turns = [pi / 2 * k / FILLET_STEPS for k in range(FILLET_STEPS + 1)]
            arc = [(y + up * r * (1 - cos(t)), z + out * r * (1 - sin(t))) for t in turns]
            shapes.append(Polygon([(y, z), *arc]))
        return union_all(shapes)

    def _bent(self) -> Any:
        """A C by the middle line of its sheet, half of it to either side."""
        from shapely import LineString

        half, mean = self.web / 2, self.radius + self.web / 2
        high, wide = self.high - half, self.wide - half
        turns = [pi / 2 * k / FILLET_STEPS for k in range(FILLET_STEPS + 1)]
        places = [(self.lip, half), (half, half), (half, wide), (high, wide), (high, half),
                  (self.high - self.lip, half)]  # fmt: skip
        line = [places[0]]
        for (y0, z0), (y, z), (y1, z1) in zip(places, places[1:], places[2:], strict=False):
            a, b = hypot(y - y0, z - z0), hypot(y1 - y, z1 - z)
            (ay, az), (by, bz) = ((y - y0) / a, (z - z0) / a), ((y1 - y) / b, (z1 - z) / b)
            line += [
                (y + mean * (by * (1 - cos(t)) - ay * (1 - sin(t))),
                 z + mean * (bz * (1 - cos(t)) - az * (1 - sin(t))))
                for t in (turns if self.radius else [])
            ] or [(y, z)]  # fmt: skip
        line.append(places[-1])
        return LineString(line).buffer(half, cap_style="flat", join_style="mitre")

    def reach_along(self, ways: "Floats") -> "Floats":
        """How far the box of the section reaches along ways (Y, Z) of length 1, from Y 0, Z 0."""
        import numpy as np

        reach: Floats = np.maximum(ways * (self.high, self.wide), 0.0).sum(axis=1)
        return reach

    def steel_through(self, face: str, y: float) -> float:
        """How much steel a torch square to a face cuts at a place of it, up to the first gap.

        Over the web of a flange it is endless, as the web stands below.
        """
        from shapely import LineString

        far = 2 * (self.high + self.wide)
        if face == "v":
            line = LineString([(y, self.front + self.radius), (y, self.back - self.radius)])
        elif face == "o":
            line = LineString([(self.high, y), (-far, y)])
        else:
            line = LineString([(0.0, y), (far, y)])
        cut = line.intersection(self.steel)
        pieces = [one for one in pieces_of(cut) if one.length > 0.0]
        if not pieces:
            return 0.0
        begin = line.interpolate(0.0)
        return float(min(pieces, key=lambda one: one.distance(begin)).length)

    def root_reach(self, face: str) -> tuple[float, float]:
        """The y of a wall between those at which a torch over it meets a root fillet."""
        if face != "v":
            return -inf, inf
        low, high = self.web_ends
        return low + self.radius, high - self.radius if self.has_upper else inf

    def root(self, face: str) -> tuple[float, float]:
        """The y of a flange below which the web and its fillets stand."""
        if self.code == "C":
            return self.back - self.radius, self.front
        least = self.back - self.radius if self.is_central else 0.0
        return max(0.0, least), self.front + self.radius


class TubeSection:
    """A round tube, or a rectangular one: a rectangle with a circle round each of its corners.

    Y and Z count from its axis, s goes round its outside from the middle of the lowest line to v.
    """

    axis = 0.0, 0.0

    def __init__(self, profile: Profile, corner: float) -> None:
        """`corner` is the outer radius of a rectangular tube's corners."""
        self.half_y, self.half_z = profile.height / 2, profile.width / 2
        self.wall = max(profile.flange_thickness, profile.web_thickness or 0.0)
        if profile.code == "RO":
            self.radius = self.half_z = self.half_y
        else:
            self.radius = corner
        self.flat_y, self.flat_z = self.half_y - self.radius, self.half_z - self.radius
        self.turn = 2 * pi * self.radius + 4 * (self.flat_y + self.flat_z)
        self.reach = hypot(self.flat_y, self.flat_z) + self.radius  #: of what turns

    @cached_property
    def steel(self) -> Any:
        """The section as a shape of shapely, without its hollow."""
        from shapely import Point, box

        if not (self.flat_y or self.flat_z):
            return Point(0.0, 0.0).buffer(self.radius, FILLET_STEPS)
        inner = box(-self.flat_y, -self.flat_z, self.flat_y, self.flat_z)
        return inner.buffer(self.radius, FILLET_STEPS)

    def reach_along(self, ways: "Floats") -> "Floats":
        """How far the section reaches along ways (Y, Z) of length 1, from its axis."""
        import numpy as np

        return np.abs(ways) @ (self.flat_y, self.flat_z) + self.radius

    def place(self, y: "Floats", z: "Floats", a_deg: "Floats") -> "tuple[Floats, Floats, Floats]":
        """s below tips, how high they are over the surface, how far beside the normal they stand.

        A tip is at Y and Z of the machine while the tube has turned by A about its axis.
        """
        import numpy as np

        c, k = np.cos(np.radians(a_deg)), np.sin(np.radians(a_deg))
        y, z = c * y - k * z, k * y + c * z
        at_y = np.clip(y, -self.flat_y, self.flat_y)
        at_z = np.clip(z, -self.flat_z, self.flat_z)
        away = -k * (y - at_y) + c * (z - at_z)
        beside = c * (y - at_y) + k * (z - at_z)
        turned = 90.0 - a_deg
        face = np.rint(turned / 90.0)
        s = face * (self.flat_y + self.flat_z) + np.choose(
            face.astype(int) % 4, (at_z, at_y, -at_z, -at_y)
        )
        return s + self.radius * np.radians(turned), away - self.radius, beside

    def _begin(self, face: int) -> float:
        """The way along the flats to the middle of a face; u is 0, v 1, o 2, h 3, and so on."""
        return face * (self.flat_y + self.flat_z)

    def around(self, face: str, y: Any) -> Any:
        """s of a place on the flat of a face, or of places."""
        k = "uvoh".index(face)
        along = y - (self.half_y if face in "vh" else self.half_z)
        return self._begin(k) + self.radius * k * pi / 2 + (along if k < 2 else -along)

    def corner(self, k: int) -> float:
        """s at which the corner behind a face begins."""
        flat = self.flat_y if k % 2 else self.flat_z
        return self._begin(k) + flat + self.radius * k * pi / 2

    def face_at(self, s: float) -> str:
        """The face that a place is on, or is nearest to."""
        rest = (s + self.turn / 2) % self.turn - self.turn / 2
        if self.radius == self.half_y == self.half_z:
            return "v"
        middles: dict[str, float] = {
            face: self.around(face, self.half_y if face in "vh" else self.half_z) for face in "uvoh"
        }
        half = {"u": self.half_z, "v": self.half_y, "o": self.half_z, "h": self.half_y}

        def off(face: str) -> float:
            way: float = abs(rest - middles[face]) % self.turn
            return min(way, self.turn - way) - half[face]

        return min("uvoh", key=off)
