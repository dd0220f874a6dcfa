"""Sections: where walls lie behind a face and whether they are possible, areas, the catalogue.

   I              U, C           L              M              T
___o___         ___o____         |            ____o___      |
   |           |                 |           |        |     |___o____
v  |  h      h |  v              |  v      h |        | v   |   u      v, from z = width
___|___        |________         |____       |________|     |
   u               u               u              u         h
"""

import re
from collections.abc import Sequence
from math import acos, ceil, cos, hypot, pi, radians, sin, sqrt
from operator import itemgetter
from pathlib import Path

from msgspec import Struct, json

from beamcam.caches import cached
from beamcam.geometry.curves import signed_area
from beamcam.geometry.plane import join_boxes, unit_vector
from beamcam.model.part import Contour, Face, Part, Profile, ProfileCode, SectionPoint
from beamcam.model.rounds import is_unrolled

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


@cached("sections.walls")
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
                (0.0, 0.0), (height, 0.0), (low, width), (high, width), (0.0, wall),
                (height, wall),
            )  # fmt: skip
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
    if profile.lip is not None and profile.code == "C":
        bend = web + profile.radius
        if not bend <= profile.lip < height / 2 or 2 * bend > width:
            return f"lips of {profile.lip:g} mm with bends of {bend:g} mm, {height:g} mm high"
    return None


# --- areas and weights ----------------------------------------------------------------------------

# Areas of sections and weights of parts, as part lists give them: before holes and copes.
#
# The areas are those of EN 10365 (I and U), EN 10056-1 (angles, whose toes have half the root's
# radius), EN 10210-2 and EN 10219-2 (hollow sections).

STEEL_KG_MM3 = 7850e-9
#: Of a square with side r, what a fillet of radius r fills.
_FILLET = 1 - pi / 4
SAME = 0.1  #: mm between contours on two faces of a plate that are one, in their boxes


def weight_of(part: Part) -> float | None:
    """Kilograms of one part: its section over its whole length; of a plate its outline's area.

    A section that is not known by its figures weighs what the header says a metre; None where that
    says nothing.
    """
    if part.profile.code == "B":
        thickness = part.profile.web_thickness
        if thickness is None:
            return None
        # The inside of a pipe is less long round it than its surface, which is drawn.
        less = pi * thickness / part.profile.height if is_unrolled(part.profile) else 0.0
        return plate_area(part) * thickness * (1 - less) * STEEL_KG_MM3
    area = section_area(part.profile, part.section)
    if area is not None:
        return area * part.length * STEEL_KG_MM3
    return part.weight * part.length / 1000 if part.weight > 0 else None


def plate_area(part: Part) -> float:
    """mm2 inside the outline of a plate less its cut-outs; without contours length x width.

    A contour that is drawn on both faces counts once.
    """
    closed = single_contours(part)
    if not any(c.kind == "outer" for c in closed):
        return part.length * part.profile.height
    return sum(abs(signed_area(c.curves)) * (1 if c.kind == "outer" else -1) for c in closed)


def single_contours(part: Part) -> list[Contour]:
    """The closed cut contours of a plate, of those that two faces have alike the first."""
    contours: list[tuple[Contour, tuple[float, ...]]] = []
    for contour in part.contours:
        if not contour.closed or contour.process != "cut":
            continue
        box = join_boxes([curve.bbox for curve in contour.curves]) or ()
        measures = (sqrt(abs(signed_area(contour.curves))), *box)
        # DSTV NC: x and y of h count from the same edges as those of v.
        twins = (
            other.face != contour.face
            and other.kind == contour.kind
            and all(abs(a - b) <= SAME for a, b in zip(known, measures, strict=True))
            for other, known in contours
        )
        if not any(twins):
            contours.append((contour, measures))
    return [contour for contour, _ in contours]


def section_area(profile: Profile, outline: tuple[SectionPoint, ...] = ()) -> float | None:
    """mm2 of a section by its figures; None for a C without its lips, an SO without its outline.

    Of an SO whose edges are round it is not known either.
    """
    h, b, r = profile.height, profile.width, profile.radius
    flange, web = profile.flange_thickness, profile.web_thickness or 0.0
    match profile.code:
        case "I":
            return 2 * b * flange + (h - 2 * flange) * web + 4 * _FILLET * r * r
        case "U":
            return 2 * b * flange + (h - 2 * flange) * web + 2 * _FILLET * r * r
        case "C" if profile.lip is not None:  # one sheet: round outside too where it is inside
            outer = r + web if r else 0.0
            plates = 2 * b * flange + (h - 2 * flange) * web + 2 * (profile.lip - flange) * web
            return plates + 4 * _FILLET * (r * r - outer * outer)
        case "T":
            return b * flange + (h - flange) * web + 2 * _FILLET * r * r
        case "L":
            return web * h + flange * (b - web) + _FILLET * r * r / 2
        case "M":
            inner = max(0.0, r - flange)
            full = h * b - (h - 2 * flange) * (b - 2 * web)
            return full - 4 * _FILLET * (r * r - inner * inner)
        case "RO":
            wall = flange or web
            return pi * (h - wall) * wall if wall else None
        case "RU":
            return pi * h * h / 4
        case "SO" if len(outline) > 2 and not any(point.radius for point in outline):
            total = 0.0
            for side, sign in (("+", 1), ("-", -1)):
                ring = [(p.y, p.z) for p in outline if p.side == side]
                pairs = zip(ring, ring[1:] + ring[:1], strict=True)
                total += sign * abs(sum(y0 * z1 - y1 * z0 for (y0, z0), (y1, z1) in pairs)) / 2
            return total
    return None


#: Shares of the flange's width that a lip is long (EN 1993-1-3, 5.2): the least, the greatest.
LIP_SHARES = (0.2, 0.6)


def lip_of(part: Part) -> float:
    """How far the lips of a C reach over its trough, mm from the outside of its flange; else 0.

    No header says it, though a name may. Else the weight per metre does, as the section is bent of
    one sheet; where that gives no lip of at least 0.2 of the flange's width, the longest is taken,
    0.6 of it.
    """
    profile = part.profile
    wall = profile.web_thickness
    if profile.code != "C" or not wall:
        return 0.0
    if profile.lip is not None:
        return profile.lip
    girth = part.weight / 1000 / STEEL_KG_MM3 / wall
    corners = 4 * _FILLET * (2 * profile.radius + wall)  # steel that round bends have less
    lip = (girth + corners - profile.height - 2 * profile.width + 4 * wall) / 2
    least, greatest = (share * profile.width for share in LIP_SHARES)
    return lip if least <= lip <= profile.height / 2 else greatest


# --- catalogue ------------------------------------------------------------------------------------

# Rolled sections by name and by their measures.
#
# The measures are facts of the standards: I and H of EN 10365 (IPE, HE A, B, M), channels of
# EN 10365 (UPN of DIN 1026-1, UPE of DIN 1026-2), angles of EN 10056-1, hollow sections of
# EN 10210-2 and EN 10219-2.


TOLERANCE = 0.3  #: mm that a section may differ from the standard's measures in any of them

Sizes = tuple[float, float, float, float, float]  #: height, width, flange, web, radius


@cached("sections.table")
def sections() -> dict[str, tuple[ProfileCode, Sizes]]:
    """Code and measures of every section, by its name in capitals without blanks."""
    table = json.decode(Path(__file__).with_name("sections.json").read_bytes())
    return {
        plain_name(name): (group["code"], (h, b, tf, tw, r))
        for group in table["groups"]
        for name, (h, b, tf, tw, r) in group["sections"].items()
    }


def plain_name(name: str) -> str:
    """A section's name in one spelling: HE 200 B, HEB-200 and heb200 are HEB200."""
    text = name.upper().replace(",", ".").replace("*", "X").replace("×", "X")
    text = re.sub(r"[\s_-]", "", text)
    swapped = re.fullmatch(r"HE(\d+)([ABM])", text)
    return f"HE{swapped[2]}{swapped[1]}" if swapped else text


def measures_of(name: str) -> tuple[ProfileCode, Sizes] | None:
    """Code and measures of a section by its name; None if the catalogue has none of that name."""
    return sections().get(plain_name(name))


@cached("sections.name")
def name_of(profile: Profile) -> str | None:
    """The catalogue's name of a section with these measures, the nearest within the tolerance."""
    near = [
        (off, sizes[0], name)
        for name, (code, sizes) in sections().items()
        if code == profile.code and (off := difference(profile, sizes)) <= TOLERANCE
    ]
    return min(near, key=itemgetter(0, 1))[2] if near else None


def difference(profile: Profile, sizes: Sizes) -> float:
    """The largest difference in mm of a profile from height, width and thicknesses of a section.

    The radius does not count: exporters leave fillets out.
    """
    h, b, tf, tw, _ = sizes
    return max(
        abs(profile.height - h),
        abs(profile.width - b),
        abs(profile.flange_thickness - tf),
        abs((profile.web_thickness or 0.0) - tw),
    )
