"""The surface of a profile, unrolled: patches (x, u) that a torch goes round.

        Y          o             patches of a tube, by rising angle from its lowest line:
        |     ___________                u, u-v, v, v-o, o, o-h, h, h-u
        |    /           \\      I, U, L: one patch a face, its u that of the face (DSTV's y)
      h |   |             | v   round:   one patch v, u the arc from the lowest line towards v
        |    \\___________/
        0          u         Z   v is seen from +Z, o from +Y (DSTV, 7th edition, page 7)

A patch maps (x, u) to a point of the section's axes (x, Y, Z), to its outward normal, and says how
thick the wall is there. A torch that turns about x looks along the normal at
`a_deg = atan2(-Y, Z)` of it: -90 on o, 0 on v, 90 on u.
"""

from math import acos, atan2, cos, degrees, pi, sin

from msgspec import Struct

from beamcam.model.part import Face, Profile

Pair = tuple[float, float]  #: Y and Z of the section


class Patch(Struct, frozen=True):
    """A stretch of a surface, flat or round about a line along x."""

    name: str  #: the face, or the two faces that a corner lies between
    low: float  #: least u
    high: float  #: greatest u
    thickness: float
    origin: Pair  #: where u is 0; of a round one its middle
    along: Pair = (0.0, 0.0)  #: way of rising u, of a flat one
    outward: Pair = (0.0, 0.0)  #: its normal
    radius: float = 0.0  #: 0 is flat
    first_rad: float = 0.0  #: of a round one the angle at u 0, from the lowest line towards v

    def point(self, x: float, u: float) -> tuple[float, float, float]:
        """The place (x, Y, Z) of a place on the surface."""
        if self.radius:
            ny, nz = self.normal(u)
            return x, self.origin[0] + self.radius * ny, self.origin[1] + self.radius * nz
        (y, z), (dy, dz) = self.origin, self.along
        return x, y + u * dy, z + u * dz

    def normal(self, u: float) -> Pair:
        """Y and Z of the outward normal, of length 1."""
        if not self.radius:
            return self.outward
        turn = self.first_rad + u / self.radius
        return -cos(turn), sin(turn)

    def a_deg(self, u: float) -> float:
        """The angle about x, in degrees, at which a torch looks along the normal."""
        y, z = self.normal(u)
        return degrees(atan2(-y, z)) + 0.0

    def u_of(self, y: float, z: float) -> float:
        """The u of a place (Y, Z) on the patch, or of that on it which is nearest across it.

        Round a whole tube u is that from 0 to the circumference.
        """
        if not self.radius:
            (oy, oz), (dy, dz) = self.origin, self.along
            return (y - oy) * dy + (z - oz) * dz
        turn = atan2(z - self.origin[1], self.origin[0] - y) - self.first_rad
        return (turn % (2 * pi)) * self.radius

    def longest_u(self, chord_error: float) -> float:
        """The greatest step of u whose chord lies within `chord_error` of the surface.

        Sagitta r (1 - cos(step / 2r)), never above 45 degrees; of a flat patch all of it.
        Raises ValueError if chord_error is not positive.
        """
        if not chord_error > 0.0:
            raise ValueError(f"chord_error must be above 0, found {chord_error:g}")
        if not self.radius:
            return self.high - self.low
        step = 2 * acos(max(cos(pi / 8), 1 - chord_error / self.radius))
        return self.radius * step


def surface_of(profile: Profile) -> tuple[Patch, ...]:
    """The patches of a section that a torch can look at; none of a section without such walls.

    A corner of a rectangular tube is as round as `profile.radius` says, which is the outer one. A
    T is taken as it lies under a torch, with its flange at Y 0 and its stem along Y.
    """
    h, b, r = profile.height, profile.width, profile.radius
    flange, web = profile.flange_thickness, profile.web_thickness or 0.0
    match profile.code:
        case "I" | "T":
            front, back = (b + web) / 2, (b - web) / 2
        case "U" | "C" | "L":
            front, back = web, 0.0
        case "M":
            return _tube(h, b, min(r, h / 2, b / 2), flange, web)
        case "RO" | "RU":
            wall = (flange or web) if profile.code == "RO" else h / 2
            return (Patch("v", 0.0, pi * h, wall, (h / 2, h / 2), radius=h / 2),)
        case _:
            return ()
    faces: list[Patch] = [
        Patch("v", 0.0, h, web, (0.0, front), (1.0, 0.0), (0.0, 1.0)),
        Patch("h", 0.0, h, web, (0.0, back), (1.0, 0.0), (0.0, -1.0)),
        Patch("u", 0.0, b, flange, (0.0, 0.0), (0.0, 1.0), (-1.0, 0.0)),
    ]
    if profile.code not in ("L", "T"):
        faces.append(Patch("o", 0.0, b, flange, (h, 0.0), (0.0, 1.0), (1.0, 0.0)))
    return tuple(faces)


def _tube(h: float, b: float, r: float, flange: float, web: float) -> tuple[Patch, ...]:
    """The four walls of a rectangular tube, and its round corners where it has them."""
    walls = (
        Patch("u", r, b - r, flange, (0.0, 0.0), (0.0, 1.0), (-1.0, 0.0)),
        Patch("v", r, h - r, web, (0.0, b), (1.0, 0.0), (0.0, 1.0)),
        Patch("o", r, b - r, flange, (h, 0.0), (0.0, 1.0), (1.0, 0.0)),
        Patch("h", r, h - r, web, (0.0, 0.0), (1.0, 0.0), (0.0, -1.0)),
    )
    if not r:
        return walls
    arc, wall = r * pi / 2, min(flange, web)
    middles = {"u-v": (r, b - r), "v-o": (h - r, b - r), "o-h": (h - r, r), "h-u": (r, r)}
    corners = tuple(
        Patch(name, 0.0, arc, wall, middle, radius=r, first_rad=k * pi / 2)
        for k, (name, middle) in enumerate(middles.items())
    )
    return tuple(patch for pair in zip(walls, corners, strict=True) for patch in pair)


def patch_of(patches: tuple[Patch, ...], face: Face) -> Patch | None:
    """The patch of a face; None if the section has none there."""
    return next((patch for patch in patches if patch.name == face), None)
