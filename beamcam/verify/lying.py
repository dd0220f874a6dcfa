"""Whether a part that lies on the bar is the part that was given, turned and not mirrored.

Every place of a part is put into its section axes (DSTV 7th edition, page 7: X along the part, Y
up the web from the u side, Z across from the h side), turned about its middle by each of the
eight rotations that keep it along the bar, and compared with the part that lies there. Written
apart from the planner, which does the turning.
"""

from collections import Counter
from collections.abc import Iterator
from itertools import product
from math import cos, hypot, radians, sin, tan

from beamcam.model.part import Bend, Camber, Contour, EndPlane, Hole, Part, Slot, TextMark, Vector

Rotation = tuple[Vector, Vector, Vector]
Place = tuple[object, ...]  #: what it is, and its rounded coordinates and directions

DIGITS = 5  #: of a coordinate in mm; turning adds rounding of some 1e-12


def rotations() -> Iterator[Rotation]:
    """The eight rotations that map the bar's axis to itself: signed exchanges of Y and Z."""
    for swap, y, z in product((False, True), (1.0, -1.0), (1.0, -1.0)):
        x = y * z * (-1.0 if swap else 1.0)  # so that the determinant is +1
        if swap:
            yield (x, 0.0, 0.0), (0.0, 0.0, y), (0.0, z, 0.0)
        else:
            yield (x, 0.0, 0.0), (0.0, y, 0.0), (0.0, 0.0, z)


ROTATIONS = tuple(rotations())


def is_turned(given: Part, lying: Part) -> bool:
    """Whether one of the eight rotations turns `given` into `lying`."""
    if (given.length, given.profile.code) != (lying.length, lying.profile.code):
        return False
    expected = _places(lying, ROTATIONS[0], lying)
    return any(_places(given, rotation, lying) == expected for rotation in ROTATIONS)


def _places(part: Part, rotation: Rotation, lying: Part) -> Counter[Place]:
    """All places of a part after a rotation, about the middle of the part as it lies."""
    profile = part.profile
    middle = (part.length / 2, profile.height / 2, profile.width / 2)
    after = (lying.length / 2, lying.profile.height / 2, lying.profile.width / 2)

    def way(v: Vector) -> Vector:
        return _round(tuple(sum(r * c for r, c in zip(row, v, strict=True)) for row in rotation))

    def place(p: Vector) -> Vector:
        moved = way((p[0] - middle[0], p[1] - middle[1], p[2] - middle[2]))
        return _round((moved[0] + after[0], moved[1] + after[1], moved[2] + after[2]))

    found: list[Place] = []
    for side, web, flange in (
        (-1.0, part.cuts.web_start, part.cuts.flange_start),
        (1.0, part.cuts.web_end, part.cuts.flange_end),
    ):
        normal = (side, side * tan(radians(web)), side * tan(radians(flange)))
        size = hypot(*normal)
        found.append(("end", way((normal[0] / size, normal[1] / size, normal[2] / size))))
    for feature in part.features:
        match feature:
            case Hole(face=face, x=x, y=y):
                hole = (feature.kind, feature.diameter, feature.depth, feature.angle)
                found.append((hole, place(_point(face, x, y, part)), way(_normal(face))))
            case Slot(face=face, x=x, y=y):
                slot = (feature.diameter, feature.length, feature.height, feature.depth)
                turn = radians(feature.angle)
                along = way(_along(face, cos(turn), sin(turn)))
                ends = frozenset((along, _round((-along[0], -along[1], -along[2]))))
                found.append((slot, place(_point(face, x, y, part)), way(_normal(face)), ends))
            case Contour(face=face):
                points = Counter(place(_point(face, *c.point(0.5), part)) for c in feature.curves)
                kind = (feature.kind, feature.process)
                found.append((kind, frozenset(points.items()), way(_normal(face))))
            case TextMark(face=face, x=x, y=y):
                found.append((feature.text, place(_point(face, x, y, part)), way(_normal(face))))
            case EndPlane(point=point, normal=normal):
                found.append(("plane", place(point), way(normal)))
            case Camber(face=face, x=x, y=y):
                found.append(("camber", place(_point(face, x, y, part))))
            case Bend(start=start, end=end):
                ends = frozenset(place(_point("v", *p, part)) for p in (start, end))
                found.append(("bend", abs(feature.angle), ends))
    return Counter(found)


def _point(face: str, x: float, y: float, part: Part) -> Vector:
    """A place of a face in section axes; planes of their own turn with the part as they are."""
    height, width = part.profile.height, part.profile.width
    match face:
        case "o":
            return x, height, y
        case "u":
            return x, 0.0, y
        case "h":
            return x, y, 0.0
    return x, y, width


def _along(face: str, dx: float, dy: float) -> Vector:
    return (dx, 0.0, dy) if face in ("o", "u") else (dx, dy, 0.0)


def _normal(face: str) -> Vector:
    normals = {"o": (0.0, 1.0, 0.0), "u": (0.0, -1.0, 0.0), "h": (0.0, 0.0, -1.0)}
    return normals.get(face, (0.0, 0.0, 1.0))


def _round(v: tuple[float, ...]) -> Vector:
    x, y, z = (round(c, DIGITS) + 0.0 for c in v)
    return x, y, z
