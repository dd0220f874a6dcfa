"""The section that a torch goes round, worked out from its figures for the read-back alone.

Its plates as boxes in (Y, Z), its root fillets, and the plane that each face is.
"""

from collections.abc import Sequence
from functools import cached_property
from itertools import pairwise
from math import cos, pi, sin
from typing import Any, Literal

from beamcam.model.part import Profile

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
    from shapely import LineString, Point

    return LineString(points) if len(set(points)) > 1 else Point(points[0])


def kerf_of(points: Sequence[tuple[float, float]], half_kerf: float) -> Any:
    """All that lies within half a kerf of a path.

    That of a connected path is one polygon. GEOS fails at it now and then where a path comes back
    to its start; then it is put together of its stretches.
    """
    from shapely import LineString, union_all

    whole = line_of(points).buffer(half_kerf, ARC)
    if whole.geom_type == "Polygon" and whole.is_valid:
        return whole
    ways = [LineString(way) for way in pairwise(points) if way[0] != way[1]]
    return union_all([way.buffer(half_kerf, ARC) for way in ways])


class Section:
    """An I, a U or an L."""

    def __init__(self, profile: Profile) -> None:
        self.code = profile.code
        self.high, self.wide = profile.height, profile.width
        self.flange, self.web = profile.flange_thickness, profile.web_thickness or 0.0
        self.radius = profile.radius
        self.back = (self.wide - self.web) / 2 if self.code == "I" else 0.0
        self.front = self.back + self.web

    @property
    def faces(self) -> tuple[str, ...]:
        """Those that a torch looks at."""
        return ("v", "u") if self.code == "L" else ("v", "o", "u")

    @property
    def web_ends(self) -> tuple[float, float]:
        """Y at which the web ends: a flange's inner surface, of an angle also a free edge."""
        return self.flange, self.high if self.code == "L" else self.high - self.flange

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
        found = [
            (0.0, self.back, self.high, self.front), (0.0, 0.0, self.flange, self.wide),
        ]  # fmt: skip
        if self.code != "L":
            found.append((self.high - self.flange, 0.0, self.high, self.wide))
        return found

    @cached_property
    def steel(self) -> Any:
        """The section as a shape of shapely."""
        from shapely import Polygon, box, union_all

        shapes = [box(*plate) for plate in self.plates()]
        corners: list[tuple[float, float, Literal[1, -1], Literal[1, -1]]] = [
            (self.flange, self.front, 1, 1)
        ]
        if self.code != "L":
            corners.append((self.high - self.flange, self.front, -1, 1))
        if self.code == "I":
            corners += [
                (self.flange, self.back, 1, -1), (self.high - self.flange, self.back, -1, -1)
            ]  # fmt: skip
        r = self.radius
        for y, z, up, out in corners if r > 0.0 else ():
            turns = [pi / 2 * k / FILLET_STEPS for k in range(FILLET_STEPS + 1)]
            arc = [(y + up * r * (1 - cos(t)), z + out * r * (1 - sin(t))) for t in turns]
            shapes.append(Polygon([(y, z), *arc]))
        return union_all(shapes)

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

    def root(self, face: str) -> tuple[float, float]:
        """The y of a flange below which the web and its fillets stand."""
        least = self.back - self.radius if self.code == "I" else 0.0
        return max(0.0, least), self.front + self.radius
