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

from bisect import bisect_right
from math import acos, atan2, cos, degrees, floor, hypot, inf, pi, radians, sin
from operator import attrgetter

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


def surface_of(profile: Profile) -> tuple[Patch, ...]:
    """The patches of a section that a torch can look at; none of a section without such walls.

    A corner of a rectangular tube is as round as `profile.radius` says, which is the outer one. A
    T is taken as it lies under a torch, with its flange at Y 0 and its stem along Y, and so is a C,
    which lies on its lips.
    """
    h, b, r = profile.height, profile.width, profile.radius
    flange, web = profile.flange_thickness, profile.web_thickness or 0.0
    match profile.code:
        case "I" | "T":
            front, back = (b + web) / 2, (b - web) / 2
        case "U" | "L":
            front, back = web, 0.0
        case "C":
            front, back = b, b - web
        case "M":
            r = min(r, h / 2, b / 2)
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


def patch_of(patches: tuple[Patch, ...], face: Face) -> Patch | None:
    """The patch of a face; None if the section has none there."""
    return next((patch for patch in patches if patch.name == face), None)


class SurfacePatch(Struct, frozen=True):
    """A patch of a tube on the way round it."""

    patch: Patch
    begin: float  #: s at which it begins
    way: int  #: 1 where u rises with s, -1 where it falls
    turn_deg: float  #: of its normal at `begin`, from the lowest line towards v

    def u(self, s: float) -> float:
        """The u of the patch at s."""
        return (self.patch.low if self.way > 0 else self.patch.high) + self.way * (s - self.begin)

    def s(self, u: float) -> float:
        """The s of a place of the patch."""
        return self.begin + (u - self.patch.low if self.way > 0 else self.patch.high - u)


_BEGIN = attrgetter("begin")


class Around(Struct, frozen=True):
    """The outside of a closed tube on the way round it: s from the middle of its lowest line.

    s rises from u towards v, o and h, and goes on from turn to turn.
    """

    legs: tuple[SurfacePatch, ...]
    turn: float  #: the way once round
    axis: Pair  #: Y and Z of the middle of the section
    half_diagonal: float  #: of the circle that the section sweeps as it turns

    def pose(self, s: float) -> tuple[float, float, float]:
        """A at which a place is on top, and where it lies then: Y and Z from the axis."""
        first = self.legs[0].begin
        turns = floor((s - first) / self.turn)
        local = max(s - turns * self.turn, first)
        leg = self._leg(local)
        turned, radius = leg.turn_deg, leg.patch.radius
        if radius:  # its middle turns, and the place stands straight above that
            turned += degrees((local - leg.begin) / radius)
            y, z = leg.patch.origin
        else:
            _, y, z = leg.patch.point(0.0, leg.u(local))
        y, z, a_rad = y - self.axis[0], z - self.axis[1], radians(90.0 - turned)
        c, k = cos(a_rad), sin(a_rad)
        return 90.0 - turned - 360.0 * turns, c * y + k * z, c * z - k * y + radius

    def _leg(self, local: float) -> SurfacePatch:
        """The leg at an s of the first turn."""
        return self.legs[bisect_right(self.legs, local, key=_BEGIN) - 1]

    def on_face(self, face: Face) -> SurfacePatch:
        """The leg of a face. Raises StopIteration if there is none."""
        return next(leg for leg in self.legs if leg.patch.name == face)

    def face_at(self, s: float) -> Face:
        """The face at s; of a corner that before its middle, or behind it."""
        first = self.legs[0].begin
        local = (s - first) % self.turn + first
        leg = self._leg(local)
        before, _, behind = leg.patch.name.partition("-")
        half = leg.begin + leg.patch.radius * pi / 4
        return behind if behind and local > half else before

    def longest(self, s: float, chord_error: float) -> tuple[float, float]:
        """Where the leg at s ends, and the greatest step on it that turns and moves evenly.

        On a corner its middle goes round the axis, at `off` from it: the sagitta of a step of the
        angle t is off (1 - cos(t / 2)).
        """
        first = self.legs[0].begin
        turns = floor((s - first) / self.turn + 1e-12)
        local = max(s - turns * self.turn, first)
        k = bisect_right(self.legs, local + 1e-9, key=_BEGIN) - 1
        leg, after = self.legs[k], (*self.legs[1:], self.legs[0])[k]
        end = after.begin + self.turn * (turns + (k == len(self.legs) - 1))
        y, z = leg.patch.origin
        off = hypot(y - self.axis[0], z - self.axis[1]) if leg.patch.radius else 0.0
        if off < chord_error:
            return end, inf
        return end, leg.patch.radius * 2 * acos(1 - chord_error / off)


def around(profile: Profile) -> Around:
    """The way round a round tube or a rectangular one with round corners.

    Raises ValueError for any other section.
    """
    patches = surface_of(profile)
    if profile.code == "RO":
        half = profile.height / 2
        return Around((SurfacePatch(patches[0], 0.0, 1, 0.0),), 2 * pi * half, (half, half), half)
    if profile.code != "M" or len(patches) != 8:
        raise ValueError(
            f"expected a tube, found {profile.code} with corners of {profile.radius:g}"
        )
    s = patches[0].low - profile.width / 2
    legs = []
    for k, patch in enumerate(patches):
        legs.append(SurfacePatch(patch, s, -1 if patch.name in ("o", "h") else 1, 90.0 * (k // 2)))
        s += patch.high - patch.low
    half_y, half_z = profile.height / 2, profile.width / 2
    r = patches[1].radius
    return Around(
        tuple(legs), s - legs[0].begin, (half_y, half_z), hypot(half_y - r, half_z - r) + r
    )
