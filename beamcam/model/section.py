"""The walls of a section: their position behind a face, and whether they are possible.

   I              U, C           L              M              T
___o___         ___o____         |            ____o___
   |           |                 |           |        |      _________  v, from z = width
v  |  h      h |  v              |  v      h |        | v        |
___|___        |________         |____       |________|          |
   u               u               u              u
"""

from math import sqrt

from msgspec import Struct

from beamcam.model.part import Face, Profile

_WEB: dict[Face, Face] = {"v": "h", "h": "v"}
#: The other side of the plate behind a face, by section: a through hole is the same from there.
OTHER_SIDE: dict[str, dict[Face, Face]] = {
    **dict.fromkeys(("I", "U", "C", "T", "B"), _WEB),
    "L": {**_WEB, "o": "u", "u": "o"},
}
#: Faces with nothing behind them, or nothing at a known depth: an angle has no upper flange, and a
#: T's stem stands somewhere amid its flange.
NO_PLATE: dict[str, tuple[Face, ...]] = {"L": ("o",), "T": ("o", "u")}
WALLED = ("I", "U", "L", "M", "C", "T")  #: codes of sections that are made of walls


class Wall(Struct, frozen=True):
    """Another wall that stands on the one behind a face, by its y on that face."""

    least: float
    greatest: float
    radius: float  #: of the root fillet on each of its free sides

    def apart(self, low: float, high: float) -> float:
        """Distance of the fillet from what reaches from one y to another; below 0 if into it."""
        if low < self.least:
            return self.least - self.radius - high
        return low - (self.greatest + self.radius)

    def fillet_height(self, into: float) -> float:
        """How high the fillet stands at a depth into it, counted from where it begins."""
        reached = min(max(into, 0.0), self.radius)
        return self.radius - sqrt(self.radius * self.radius - reached * reached)


def walls_beside(profile: Profile, face: Face) -> tuple[Wall, ...]:
    """The walls that stand on the wall behind a face, along rising y; none of other sections."""
    code, radius = profile.code, profile.radius
    height, width = profile.height, profile.width
    flange, web = profile.flange_thickness, profile.web_thickness or 0.0
    on_web = face in ("v", "h")
    size, wall = (height, flange) if on_web else (width, web)
    if code == "M":
        radius = max(0.0, radius - wall)  # a tube's radius is the outer one
    first, last = Wall(0.0, wall, radius), Wall(size - wall, size, radius)
    if code == "M" or (code in ("I", "U", "C") and on_web):
        return first, last
    if code == "I" or (code == "T" and on_web):
        return (Wall((size - wall) / 2, (size + wall) / 2, radius),)
    return (first,) if code in ("U", "C", "L") else ()


def free_edges(profile: Profile, face: Face) -> tuple[bool, bool]:
    """Whether the wall behind a face ends at y 0, and at its greatest y, with no other on it."""
    walls = walls_beside(profile, face)
    size = profile.face_width(face)
    return all(w.least > 0.0 for w in walls), all(w.greatest < size for w in walls)


def corners(profile: Profile) -> tuple[tuple[float, float], ...]:
    """The outermost places (y, z) of a section that hold material."""
    height, width = profile.height, profile.width
    if profile.code == "L":
        return (0.0, 0.0), (height, 0.0), (0.0, width)
    if profile.code == "T":
        return (0.0, 0.0), (height, 0.0), (height / 2, width)
    return (0.0, 0.0), (height, 0.0), (0.0, width), (height, width)


def section_fault(profile: Profile) -> str | None:
    """What is impossible in a section's dimensions, in words; None if nothing is."""
    if profile.code not in WALLED:
        return None
    height, width = profile.height, profile.width
    flange, web = profile.flange_thickness, profile.web_thickness or 0.0
    figures = {
        "height": height, "flange width": width, "flange thickness": flange, "web thickness": web,
    }  # fmt: skip
    for name, value in figures.items():
        if not value > 0.0:
            return f"a {name} of {value:g} mm"
    flanges = 2 * flange if profile.code in ("I", "U", "C", "M") else flange
    webs = 2 * web if profile.code == "M" else web
    if flanges >= height:
        return f"flanges of {flange:g} mm in a height of {height:g} mm"
    if webs >= width:
        return f"a web of {web:g} mm in a flange width of {width:g} mm"
    return None
