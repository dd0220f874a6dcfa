"""The walls of a section: their position behind a face, and whether they are possible.

   I              U, C           L              M              T
___o___         ___o____         |            ____o___      |
   |           |                 |           |        |     |___o____
v  |  h      h |  v              |  v      h |        | v   |   u      v, from z = width
___|___        |________         |____       |________|     |
   u               u               u              u         h
"""

from collections.abc import Sequence
from math import acos, ceil, cos, hypot, pi, radians, sin, sqrt

from msgspec import Struct

from beamcam.geometry.plane import unit_vector
from beamcam.model.part import MIRRORED_FACES, Face, Profile, SectionPoint

ARC_STEP_RAD = radians(1.0)

_WEB: dict[Face, Face] = {"v": "h", "h": "v"}
#: The other side of the plate behind a face, by section: a through hole is the same from there.
OTHER_SIDE: dict[str, dict[Face, Face]] = {
    **dict.fromkeys(("I", "U", "C", "B"), _WEB),
    **{code: {**_WEB, "o": "u", "u": "o"} for code in ("L", "T")},
}
#: Faces with nothing behind them: an angle has no upper flange.
NO_PLATE: dict[str, tuple[Face, ...]] = {"L": ("o",)}
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
    if code in ("M", "C") or (code in ("I", "U") and on_web):
        return first, last  # of a C's flange the last is its lip
    if code == "I" or (code == "T" and on_web):
        return (Wall((size - wall) / 2, (size + wall) / 2, radius),)
    return (first,) if code in ("U", "L", "T") else ()


def free_edges(profile: Profile, face: Face) -> tuple[bool, bool]:
    """Whether the wall behind a face ends at y 0, and at its greatest y, with no other on it."""
    walls = walls_beside(profile, face)
    size = profile.face_width(face)
    return all(w.least > 0.0 for w in walls), all(w.greatest < size for w in walls)


def corners(
    profile: Profile, outline: Sequence[SectionPoint] = ()
) -> tuple[tuple[float, float], ...]:
    """The outermost places (y, z) of a section that hold material; of arcs one each degree.

    Skew ends reach furthest at one of them. `outline` is that of a special section (PR), which
    counts as its box without one.
    """
    height, width, wall = profile.height, profile.width, profile.web_thickness or 0.0
    match profile.code:
        case "L":
            return (
                (0.0, 0.0), (height, 0.0), (0.0, width),
                (height, wall), (profile.flange_thickness, width),
            )  # fmt: skip
        case "T":
            low, high = ((height + way * profile.flange_thickness) / 2 for way in (-1, 1))
            return (
                (0.0, 0.0),
                (height, 0.0),
                (low, width),
                (high, width),
                (0.0, wall),
                (height, wall),
            )
        case "RO" | "RU":
            return _rounded(height, height, height / 2)
        case "B":
            width = wall
        case "M":
            return _rounded(height, width, profile.radius)
        case "C":  # its radius is that inside its bends
            return _rounded(height, width, profile.radius + wall if profile.radius else 0.0)
        case "SO" if outline:
            return tuple(ring_of([p for p in outline if p.side == "+"]))
    return (0.0, 0.0), (height, 0.0), (0.0, width), (height, width)


def _rounded(height: float, width: float, radius: float) -> tuple[tuple[float, float], ...]:
    """Places on a rectangle whose corners are round."""
    r = min(radius, height / 2, width / 2)
    if r <= 0.0:
        return (0.0, 0.0), (height, 0.0), (0.0, width), (height, width)
    steps = ceil(pi / 2 / ARC_STEP_RAD)
    turns = [unit_vector(90.0 * k / steps) for k in range(steps + 1)]
    return tuple(
        (y + up * (c - 1.0) * r, z + along * (s - 1.0) * r)
        for y, up in ((0.0, -1.0), (height, 1.0))
        for z, along in ((0.0, -1.0), (width, 1.0))
        for c, s in turns
    )


def ring_of(points: Sequence[SectionPoint]) -> list[tuple[float, float]]:
    """A ring of a special section, of its arcs a place each degree.

    The radius belongs to the edge that its point begins; above 0 it lies on the right of the edge.
    """
    out: list[tuple[float, float]] = []
    for a, b in zip(points, (*points[1:], points[0]), strict=True):
        out.append((a.y, a.z))
        chord, r = hypot(b.y - a.y, b.z - a.z), abs(a.radius)
        if not r or chord <= 0.0 or chord > 2 * r:
            continue
        turn = acos(max(-1.0, 1 - chord * chord / (2 * r * r)))
        sense = -1.0 if a.radius > 0 else 1.0
        off = sqrt(r * r - chord * chord / 4) * sense
        cy = (a.y + b.y) / 2 + off * (b.z - a.z) / chord
        cz = (a.z + b.z) / 2 - off * (b.y - a.y) / chord
        n = max(2, ceil(turn / ARC_STEP_RAD))
        for k in range(1, n):
            angle, u, v = sense * turn * k / n, a.y - cy, a.z - cz
            out.append((cy + u * cos(angle) + v * sin(angle), cz - u * sin(angle) + v * cos(angle)))
    return out


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


# --- faces ----------------------------------------------------------------------------------------

# How the faces lie on paper: from where each is seen, which way its y runs, what it is called.
#
#     h   y ^        seen through the web from the front: x to the right as on v, y up
#     o   y v        from above, y = 0 at the far edge, which is the upper one: o unfolds over v
#     v   y ^        from the front, y = 0 at the lower edge
#     u   y ^        from below, y = 0 at the lower edge, the far one again
#
# y of o and u counts from the h side (DSTV, pages 7 and 8), so that the edge of either flange that
# meets v has y = the flange's width. x runs to the right on all of them.


FACE_NAMES = {"h": "web", "o": "top flange", "v": "web", "u": "bottom flange"}
THROUGH = "h"  #: drawn through the steel, so that its x runs as on the others
#: From where a face is seen, and which edge of its view is y = 0.
SEEN = {
    "h": ("from behind, drawn through the web", "lower"),
    "o": ("from above", "upper"),
    "v": ("from the front", "lower"),
    "u": ("from below", "lower"),
}


def runs_down(face: Face) -> bool:
    """Whether y runs down the paper: numbers are mirrored seen from outside, and so is the view.

    h is mirrored too, and is drawn through the web instead.
    """
    return face in MIRRORED_FACES and face != THROUGH


def face_title(face: Face, code: str) -> str:
    """What a view shows, from where it is seen, and which of its edges is y = 0."""
    if face not in FACE_NAMES:
        return f"{face}   plane"
    name, (seen, edge) = FACE_NAMES[face], SEEN[face]
    if code == "T":
        name = "flange" if face in ("v", "h") else "stem"
    if code == "B":
        name = "front" if face == "v" else "back"
        seen = "seen from the front" if face == "v" else "drawn through the plate"
    return f"{face}   {name}, {seen}; y = 0 is the {edge} edge"
