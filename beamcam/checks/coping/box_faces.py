"""The faces of a rectangular tube as they are drawn, for the read-back alone.

A face counts within its outlines, v and h also within that of the other one; without one it goes
from 0 to the length of the part, and of a piece that comes cut into the air before its ends.
"""

from collections.abc import Sequence
from math import isnan
from typing import Any

from msgspec import Struct
from shapely import Polygon, bounds, box, intersection, linestrings, union_all

from beamcam.checks.coping.section import TubeSection
from beamcam.checks.coping.stock import outline_ring, ring_of, taken
from beamcam.checks.coping.tube_ends import AIR, FAR, PieceAsked, short_by, with_air
from beamcam.geometry.plane import Point
from beamcam.model.part import Contour, Part

Shape = Any  #: of shapely

DEEP = 5.0  #: mm that the floor of a slot lies inside of the end that it begins at, at least
APART = 1.0  #: mm that a drawing may be off and mean it


class BoxWall(Struct, frozen=True):
    face: str
    wide: float
    steel: Shape
    is_drawn: bool

    def ends(self) -> tuple[list[Point], list[Point]]:
        """x and y of places along both ends, but a slot's floor; FAR where there is no steel."""
        ys = [self.wide * k / 20 for k in range(1, 20)]
        across = linestrings([((-FAR, y), (FAR, y)) for y in ys])
        start, _, end, _ = bounds(intersection(across, self.steel)).T.tolist()
        ends: tuple[list[Point], list[Point]] = [], []
        for side, xs, places in zip((-1, 1), (start, end), ends, strict=True):
            first, last = xs[0], xs[-1]
            for y, x in zip(ys, xs, strict=True):
                chord = first + (last - first) * (y - ys[0]) / (ys[-1] - ys[0])
                if isnan(x) or side * (x - chord) >= -DEEP:
                    places.append((FAR if isnan(x) else x, y))
        return ends


def outlines_of(face: str, features: Sequence[Any]) -> list[Contour]:
    """The outlines of a face; v and h have those of the other one if they have none."""
    outer = [f for f in features if isinstance(f, Contour) and f.kind == "outer"]
    own = [f for f in outer if f.face == face]
    return own or [f for f in outer if face in "vh" and f.face in "vh"]


def outlined(
    part: Part, face: str, features: Sequence[Any], section: TubeSection,
    piece: PieceAsked | None = None,
) -> BoxWall:  # fmt: skip
    """A face within its outline; of a piece that comes cut with the air before its ends."""
    wide = part.profile.height if face in "vh" else part.profile.width
    rings = _rings_of(part, face, features, section, piece)
    there = piece.faces[face] if piece else None
    if not rings:
        air = AIR if piece else 0.0
        return BoxWall(face, wide, box(-air, 0.0, part.length + air, wide), False)
    areas = [with_air(ring, there) for ring in rings]
    steel = union_all(areas) if len(areas) > 1 else areas[0]
    return BoxWall(face, wide, steel.intersection(box(-FAR, 0.0, FAR, wide)), True)


def _rings_of(
    part: Part, face: str, features: Sequence[Any], section: TubeSection, piece: PieceAsked | None
) -> list[list[Point]]:
    """The outlines of a face; that of the other web is not asked of one whose own is there."""
    wide = part.profile.height if face in "vh" else part.profile.width
    return [
        _gone_on(outline_ring(f.curves, (0.0, wide)), wide, section.radius)
        for f in outlines_of(face, features)
        if f.face == face or piece is None or not piece.faces[face].has_outline
    ]


def short_face(
    part: Part, features: Sequence[Any], section: TubeSection, piece: PieceAsked | None
) -> tuple[str, float]:
    """The face on which an outline goes on farthest beyond a piece that comes cut, and how far."""
    rings = [
        (short_by(ring, piece.faces[face]), face)
        for face in (piece.faces if piece else ()) if piece
        for ring in _rings_of(part, face, features, section, piece)
    ]  # fmt: skip
    far, face = max(rings, default=(0.0, ""))
    return face, far


def _gone_on(ring: list[Point], wide: float, radius: float) -> list[Point]:
    """A ring that goes straight on to the edges where all of it ends at the tangents."""
    ys = [y for _, y in ring]
    sides = [(0.0, radius)] if abs(min(ys) - radius) <= APART else []
    sides += [(wide, wide - radius)] if abs(max(ys) - wide + radius) <= APART else []
    longer: list[Point] = []
    for k, (x, y) in enumerate(ring):
        before, after = ring[k - 1], ring[(k + 1) % len(ring)]
        for edge, tangent in sides:
            off = [abs(one - tangent) <= APART for one in (before[1], y, after[1])]
            if off[1] and off[0] != off[2]:
                xb, yb = before if off[2] else after
                x, y = x + (edge - y) * (xb - x) / (yb - y), edge
                break
        longer.append((x, y))
    return longer


def void_of(feature: Any, piece: PieceAsked | None = None) -> Shape:
    """What a feature takes of its face; nothing where it is an outline."""
    if not isinstance(feature, Contour):
        return taken(feature)
    if feature.kind == "inner":
        return with_air(ring_of(feature.curves), piece.faces[feature.face] if piece else None)
    return Polygon()
