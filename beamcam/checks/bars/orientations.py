"""A part in the machine's axes, in each possible orientation on the rollers.

Section axes are DSTV's (7th edition, page 7): X along the part, Y up the web from the u side, Z
across from the h side. Eight rotations keep the bar along X: the signed exchanges of Y and Z, X
reversed where the exchange alone would mirror the part. Every place is put into these axes,
rotated about the middle of the section's box, and read off the face that it comes to lie on.
"""

from collections.abc import Iterator
from itertools import product
from math import atan2, cos, degrees, radians, sin, tan

from msgspec.structs import replace

from beamcam.geometry.curves import Matrix, Point
from beamcam.geometry.plane import mapped
from beamcam.model.part import (
    Contour,
    EndCuts,
    EndPlane,
    Face,
    Feature,
    Hole,
    Part,
    Profile,
    Slot,
    TextMark,
    Vector,
)

Rotation = tuple[Vector, Vector, Vector]  #: rows of the matrix

AS_IT_IS: Rotation = ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0))

#: Normals of the faces that look out of a part, in section axes.
NORMALS: dict[Face, Vector] = {
    "v": (0.0, 0.0, 1.0), "h": (0.0, 0.0, -1.0), "o": (0.0, 1.0, 0.0), "u": (0.0, -1.0, 0.0),
}  # fmt: skip
_FACES = {normal: face for face, normal in NORMALS.items()}


#: The eight rotations that map the bar's axis to itself; X is such that the determinant is +1.
ROTATIONS: tuple[Rotation, ...] = tuple(
    ((-y * z, 0.0, 0.0), (0.0, 0.0, y), (0.0, z, 0.0)) if swap
    else ((y * z, 0.0, 0.0), (0.0, y, 0.0), (0.0, 0.0, z))
    for swap, y, z in product((False, True), (1.0, -1.0), (1.0, -1.0))
)  # fmt: skip


def orientations(part: Part) -> Iterator[Part]:
    """The part as given, and in every other orientation that its section allows."""
    yield part
    for rotation in ROTATIONS:
        if rotation != AS_IT_IS and _lies_alike(part.profile, rotation):
            yield rotated(part, rotation)


def _lies_alike(profile: Profile, rotation: Rotation) -> bool:
    """Whether a section rests on the rollers as its kind does, after a rotation.

    A U or C lies on its web, its trough up, a T on its flange, an angle on its two legs.
    """
    _, (_, y, _), (_, _, z) = rotation
    swapped = y == 0.0
    match profile.code:
        case "M":
            return True
        case "I" | "B":
            return not swapped
        case "U" | "C" | "T" | "RO" | "RU":
            return z == 1.0
        case "L":
            return swapped and rotation[1][2] == rotation[2][1] == 1.0
    return False


def rotated(part: Part, rotation: Rotation) -> Part:
    """The part after a rotation; bends and cambers, which no bar's program makes, as they are."""
    profile = part.profile
    if rotation[1][1] == 0.0:  # height and width change places
        web, flange = profile.web_thickness, profile.flange_thickness
        profile = replace(
            profile, height=profile.width, width=profile.height,
            flange_thickness=flange if web is None else web,
            web_thickness=None if web is None else flange,
        )  # fmt: skip
    features = tuple(_feature(f, part, rotation) for f in part.features)
    return replace(part, profile=profile, cuts=_cuts(part.cuts, rotation), features=features)


def _cuts(cuts: EndCuts, rotation: Rotation) -> EndCuts:
    """The angles of the end planes, whose normals are (1, tan web, tan flange)."""
    ends: dict[bool, tuple[float, float]] = {}
    for at_start, web, flange in (
        (True, cuts.web_start, cuts.flange_start),
        (False, cuts.web_end, cuts.flange_end),
    ):
        x, y, z = _apply(rotation, (1.0, tan(radians(web)), tan(radians(flange))))
        # A leading end that looks back afterwards is the trailing one.
        ends[at_start ^ (x < 0)] = (degrees(atan2(y / x, 1.0)), degrees(atan2(z / x, 1.0)))
    (web_start, flange_start), (web_end, flange_end) = ends[True], ends[False]
    return EndCuts(web_start + 0.0, web_end + 0.0, flange_start + 0.0, flange_end + 0.0)


def _feature(feature: Feature, part: Part, rotation: Rotation) -> Feature:
    if isinstance(feature, EndPlane):
        normal = _apply(rotation, feature.normal)
        return replace(feature, point=_point(feature.point, part, rotation), normal=normal)
    if not isinstance(feature, Hole | Slot | Contour | TextMark) or feature.face not in NORMALS:
        return feature
    face, matrix = _map(feature.face, part, rotation)
    if isinstance(feature, Contour):
        curves = tuple(c.transformed(matrix) for c in feature.curves)
        return replace(feature, face=face, curves=curves)
    x, y = mapped(matrix, (feature.x, feature.y))
    if isinstance(feature, Hole):
        return replace(feature, face=face, x=x, y=y)
    turn = radians(feature.angle)
    (a, b, _), (d, e, _) = matrix
    along = a * cos(turn) + b * sin(turn), d * cos(turn) + e * sin(turn)
    return replace(feature, face=face, x=x, y=y, angle=degrees(atan2(along[1], along[0])))


def _map(face: Face, part: Part, rotation: Rotation) -> tuple[Face, Matrix]:
    """The face after the rotation, and the map of the coordinates to that face."""
    after = _FACES[_apply(rotation, NORMALS[face])]

    def place(x: float, y: float) -> Point:
        at = (x, y, 0.0) if face in ("v", "h") else (x, 0.0, y)
        px, py, pz = _point(at, part, rotation)
        return px, py if after in ("v", "h") else pz

    (x0, y0), (x1, y1), (x2, y2) = place(0.0, 0.0), place(1.0, 0.0), place(0.0, 1.0)
    return after, ((round(x1 - x0), round(x2 - x0), x0), (round(y1 - y0), round(y2 - y0), y0))


def _point(at: Vector, part: Part, rotation: Rotation) -> Vector:
    """Where a place of the part is after the rotation about the middle of its box."""
    profile = part.profile
    middle = (part.length / 2, profile.height / 2, profile.width / 2)
    (mx, my, mz), (dx, dy, dz) = middle, (abs(c) for c in _apply(rotation, middle))
    x, y, z = _apply(rotation, (at[0] - mx, at[1] - my, at[2] - mz))
    return x + dx, y + dy, z + dz


def _apply(rotation: Rotation, v: Vector) -> Vector:
    x, y, z = (r[0] * v[0] + r[1] * v[1] + r[2] * v[2] + 0.0 for r in rotation)
    return x, y, z
