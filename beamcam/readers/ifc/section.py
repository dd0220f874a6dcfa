"""Sections: what DSTV code a profile has, its measures, and how it lies.

A section is described in the coordinates of its profile by where DSTV's zero point lies and
which way Y (height) and Z (across) run:

    I         U          L          T          M, B
    Y         Y          Y          Y
    | ==      | ===      | |        | |        as drawn, the longer side is Y
    |  |      | |        | |        | |===
    | ==      | ===      | ====     | |
    +---Z     +---Z      +---Z      +---Z
"""

from collections.abc import Sequence
from math import pi
from statistics import fmean
from typing import Any, Literal

from msgspec import Struct
from msgspec.structs import replace
from shapely import box

from beamcam.caches import cached
from beamcam.geometry import plane
from beamcam.geometry.curves import Arc, Point, signed_area
from beamcam.geometry.plane import cross, distance, dot, normalized
from beamcam.model.part import Face, Profile, ProfileCode, SectionPoint
from beamcam.model.section import corners, section_area
from beamcam.readers.ifc.outline import (
    Chain,
    Corner,
    Round,
    box_around,
    corners_of,
    reflex,
    shape_of,
    with_arcs,
)
from beamcam.readers.ifc.space import Vec

Sizes = tuple[float, float, float, float, float]  #: height, width, flange, web, radius
SQUARE = 0.02  #: sine of the angle by which a side of a section may be off square; more is a slope


class Section(Struct, frozen=True, gc=False, cache_hash=True):
    """A classified section; lengths in mm, points and directions in the profile's plane."""

    code: ProfileCode
    height: float  #: along Y
    width: float  #: along Z, also of a plate, where it is the thickness
    flange_thickness: float
    web_thickness: float
    radius: float
    origin: Point  #: the zero point: Y = 0, Z = 0
    y: Point
    z: Point
    area: float  #: mm2
    outline: Chain = ()  #: of a special section
    lip: float | None = None  #: of a C, from the outside of its flange; None where it is not known

    @property
    def is_plain_flat(self) -> bool:
        """Whether it is a rectangle with sharp edges."""
        return self.code == "B" and not self.radius

    def profile(self, name: str) -> Profile:
        """The model's profile of that name."""
        h, b, tf, tw, r = self.sizes
        if self.code == "B":
            b = tf = 0.0
        return Profile(self.code, name, h, b, tf, tw, r, self.lip)

    @property
    def sizes(self) -> Sizes:
        return self.height, self.width, self.flange_thickness, self.web_thickness, self.radius

    @property
    def lips(self) -> float:
        """Area of a channel's lips in mm2; 0 of other sections."""
        return max(0.0, self.area - area_by_measures("C", *self.sizes)) if self.code == "C" else 0.0

    @property
    def points(self) -> tuple[SectionPoint, ...]:
        """The corners of a special section's outline, from its zero point (PR)."""
        points = []
        (ox, oy), (yx, yy), (zx, zy) = self.origin, self.y, self.z
        turned = yx * zy - yy * zx  # Y x Z as drawn; the arcs' sense is that of (Y, Z)
        for curve in self.outline:
            x, y = curve.start[0] - ox, curve.start[1] - oy
            radius = 0.0
            if isinstance(curve, Arc):
                radius = curve.radius if (curve.sweep_deg > 0) == (turned > 0) else -curve.radius
            points.append(SectionPoint("+", x * yx + y * yy, x * zx + y * zy, radius))
        return tuple(points)

    def turned(self) -> "Section":
        """The section turned back to front or upside down, if its form is the same then."""
        o, y, z, h, b = self.origin, self.y, self.z, self.height, self.width
        if self.code in ("I", "M", "B", "RO", "RU"):
            return replace(self, origin=(o[0] + z[0] * b, o[1] + z[1] * b), z=(-z[0], -z[1]))
        if self.code in ("U", "C", "T"):
            return replace(self, origin=(o[0] + y[0] * h, o[1] + y[1] * h), y=(-y[0], -y[1]))
        return self

    def scaled(self, by: float) -> "Section":
        """The section with all its measures so many times as large, where it lies."""
        h, b, tf, tw, r = (size * by for size in self.sizes)
        lip = self.lip and self.lip * by
        at, area = (self.origin, self.y, self.z), self.area * by * by
        return Section(self.code, h, b, tf, tw, r, *at, area, self.outline, lip)


class BareStock(Struct, frozen=True, eq=False):
    """The section that a body was cut from, as its faces show it."""

    shape: Any  #: in (Y, Z), with the facets of the body
    area: float  #: mm2, of the section that its facets stand for
    rough: Any = None  #: where facets that run slantwise lie somewhere between arcs and chords
    rise: float = 0.0  #: mm between its roundings and such facets


def plain_stock(section: Section) -> BareStock:
    """That of a flat bar or a plate."""
    h, t = section.height, section.width
    return BareStock(box(0.0, 0.0, h, t), h * t)


Names = tuple[tuple[str, str], ...]


class Form(Struct, frozen=True):
    """A kind of section by the names of where its surfaces lie, and its outline without fillets.

    Along Z those are 0, the greatest (b), both sides of a web (0 and w, W and b, or a and A in the
    middle); along Y 0, the greatest (h), the inner sides of flanges (t and T), both sides of a stem
    (s and S) and the ends of lips (g and G).
    """

    corners: Names  #: each by its names along Z and Y, counter-clockwise as drawn
    upright: tuple[int, int]  #: the corners between which Y runs
    webs: Names  #: the one behind v, then that behind h
    flanges: Names
    #: Where flanges are measured that slope, from root (0) to tip (1); None midway of the width.
    share: float | None
    reflex: tuple[bool, ...] = ()  #: whether each corner is an inner one

    def levels(
        self, h: float, b: float, tf: float, tw: float, lip: float = 0.0
    ) -> tuple[dict[str, float], dict[str, float]]:
        """Where the surfaces of a section of height, width, flange, web and lip lie, by Z and Y."""
        across = {"0": 0.0, "b": b, "w": tw, "W": b - tw, "a": (b - tw) / 2, "A": (b + tw) / 2}
        up = {"0": 0.0, "h": h, "t": tf, "T": h - tf, "s": (h - tf) / 2, "S": (h + tf) / 2}
        return across, up | {"g": lip, "G": h - lip}

    def drawn(self, *sizes: float) -> list[Point]:
        """(Z, Y) of the corners for height, width, flange, web and lip."""
        across, up = self.levels(*sizes)
        return [(across[z], up[y]) for z, y in self.corners]


def _form(
    corners: str, upright: tuple[int, int], webs: str, flanges: str, share: float | None = 0.0
) -> Form:
    def names(text: str) -> Names:
        return tuple((pair[0], pair[1]) for pair in text.split())

    form = Form(names(corners), upright, names(webs), names(flanges), share)
    return replace(form, reflex=reflex(form.drawn(9.0, 7.0, 1.0, 1.0, 2.0)))


FORMS: dict[ProfileCode, Form] = {
    "I": _form("00 b0 bt At AT bT bh 0h 0T aT at 0t", (3, 4), "aA", "Th 0t", 0.5),
    "U": _form("00 b0 bt wt wT bT bh 0h", (0, 7), "0w", "Th 0t", None),
    "C": _form("00 b0 bg Wg Wt wt wT WT WG bG bh 0h", (0, 11), "0w", "Th 0t"),
    "L": _form("00 b0 bt wt wh 0h", (0, 5), "0w", "0t"),
    "T": _form("00 w0 ws bs bS wS wh 0h", (0, 7), "0w", "sS", 1.0),
    "B": _form("00 b0 bh 0h", (0, 3), "0b", ""),
    "M": _form("00 b0 bh 0h", (0, 3), "Wb 0w", "Th 0t"),
}


def area_by_measures(
    code: ProfileCode, h: float, b: float, tf: float, tw: float, r: float
) -> float:
    """Area of a section in mm2 as models have it: toes of angles are sharp, lips not counted."""
    corner = (1 - pi / 4) * r * r
    if code == "B":
        return h * b - 4 * corner
    area = section_area(Profile("U" if code == "C" else code, "", h, b, tf, tw, r)) or 0.0
    return area + corner / 2 if code == "L" else area


def placed(
    code: ProfileCode, sizes: Sizes, centre: Point, y: Point, z: Point, area: float
) -> Section:
    """The section of height, width, flange, web and radius `sizes` centred on `centre`.

    It is turned so that Y x Z points out of the drawing, where its form allows it.
    """
    h, b, tf, tw, r = sizes
    origin = (centre[0] - y[0] * h / 2 - z[0] * b / 2, centre[1] - y[1] * h / 2 - z[1] * b / 2)
    turned = cross(y, z) <= 0
    if turned and code == "L" and abs(h - b) < 0.01:  # its legs are exchanged
        return Section(code, b, h, tf, tw, r, origin, z, y, area)
    section = Section(code, h, b, tf, tw, r, origin, y, z, area)
    return section.turned() if turned else section


def special(outer: Chain, area: float) -> Section:
    """The special section (SO) of an outline, as it is drawn, in its box."""
    x0, y0, x1, y1 = box_around(outer)
    sizes = (y1 - y0, x1 - x0, 0.0, 0.0)
    drawn = outer if signed_area(outer) > 0 else tuple(c.reversed() for c in reversed(outer))
    # Y x Z of (up, right) points into the drawing: Z runs to the left.
    return Section("SO", *sizes, 0.0, (x1, y0), (0.0, 1.0), (-1.0, 0.0), area, drawn)


# --- walls ----------------------------------------------------------------------------------------
# The walls of a section: flat plates of full outer size, as DSTV divides a section (page 13).


class Wall(Struct, frozen=True, gc=False):
    """A plate of a section; x along the member, q across it, c through its thickness."""

    face: Face
    normal: Literal["y", "z"]  #: the axis that c runs along; q runs along the other
    low: float  #: minimum c
    high: float  #: maximum c
    width: float  #: q from 0 to this
    outer: bool  #: whether the surface in question is at maximum c

    @property
    def thickness(self) -> float:
        return self.high - self.low

    @property
    def surface(self) -> float:
        """c of the surface that is looked at."""
        return self.high if self.outer else self.low

    def split(self, p: Vec) -> tuple[float, float]:
        """q and c of a point of the member."""
        return (p[2], p[1]) if self.normal == "y" else (p[1], p[2])

    def point(self, x: float, q: float, c: float) -> Vec:
        """The point of the member at x, q and c."""
        return (x, c, q) if self.normal == "y" else (x, q, c)

    @property
    def direction(self) -> Vec:
        """The unit vector along c."""
        return self.point(0.0, 0.0, 1.0)

    @property
    def across(self) -> Vec:
        """The unit vector along q."""
        return self.point(0.0, 1.0, 0.0)


@cached("ifc.walls")
def walls_of(section: Section) -> tuple[Wall, ...]:
    """The walls of a section; none of a round or special one."""
    form, h, b = FORMS.get(section.code), section.height, section.width
    if form is None:
        return ()
    z, y = form.levels(h, b, section.flange_thickness, section.web_thickness)
    return (
        *(Wall("v", "z", z[low], z[high], h, True) for low, high in form.webs[:1]),
        *(Wall("h", "z", z[low], z[high], h, False) for low, high in form.webs[1:]),
        *(Wall("o", "y", y[low], y[high], b, True) for low, high in form.flanges if low != "0"),
        *(Wall("u", "y", y[low], y[high], b, False) for low, high in form.flanges if low == "0"),
    )


@cached("ifc.corners")
def corner_points(section: Section) -> tuple[tuple[float, float], ...]:
    """(Y, Z) of the outermost points of a section, in which the end cuts reach furthest."""
    return corners(section.profile(""), section.points)


# --- recognition ----------------------------------------------------------------------------------
# Section of an outline, by its geometry alone: the form of FORMS whose corners it has.

ALIKE = 0.2  #: mm between what a form has alike: flanges, tips, a web and the middle
WALLS_ALIKE = 0.3  #: mm between the walls of a tube
SAME_SIDES = 0.01  #: mm between the sides of a square
MIDDLE = (("a", "A"), ("s", "S"))  #: walls that stand in the middle of a section
ROUND_ALIKE = 0.1  #: share between the roundings of a flat bar, which others are bevels of


def classify(outer: Chain, inner: Sequence[Chain] = ()) -> Section | None:
    """The section of an outline by its geometry alone; a special one (SO) if its form is unknown.

    None where it has more than one hollow, or a hollow that is not a wall's.
    """
    area = abs(signed_area(outer)) - sum(abs(signed_area(c)) for c in inner)
    if len(inner) > 1:
        return None
    curves = with_arcs(outer)
    shape = shape_of(curves)
    if isinstance(shape, Round):
        return _round(shape, inner, area)
    corners = corners_of(curves) or ()
    if inner:
        return _tube(corners, corners_of(with_arcs(inner[0])) or (), area)
    known = (_measured(code, corners, area) for code in FORMS if code != "M")
    return next((section for section in known if section is not None), None) or special(outer, area)


def _round(shape: Round, inner: Sequence[Chain], area: float) -> Section | None:
    d, lies = shape.diameter, (shape.centre, (0.0, 1.0), (1.0, 0.0), area)
    if not inner:
        return placed("RU", (d, d, 0.0, d, 0.0), *lies)
    bore = shape_of(inner[0])
    wall = (d - bore.diameter) / 2 if isinstance(bore, Round) else 0.0
    if bore is None or wall <= 0 or distance(bore.centre, shape.centre) > 0.1 * wall:
        return None
    return placed("RO", (d, d, wall, wall, 0.0), *lies)


def _tube(outer: Sequence[Corner], inner: Sequence[Corner], area: float) -> Section | None:
    outside, inside = (_measured("B", ring, area) for ring in (outer, inner))
    if outside is None or inside is None:
        return None
    sides = inside.height, inside.width
    if abs(cross(outside.y, inside.y)) > SQUARE:
        sides = inside.width, inside.height
    walls = (outside.height - sides[0]) / 2, (outside.width - sides[1]) / 2
    if min(walls) <= 0 or abs(walls[0] - walls[1]) > WALLS_ALIKE:
        return None
    radius = max(c.radius for c in outer)
    tf, tw = walls
    return replace(outside, code="M", flange_thickness=tf, web_thickness=tw, radius=radius)


def _measured(code: ProfileCode, corners: Sequence[Corner], area: float) -> Section | None:
    """The section whose corners are those of a form; None if they are not.

    Of the ways in which a form lies, the one with the greater side upright.
    """
    bends, reflex = tuple(corner.reflex for corner in corners), FORMS[code].reflex
    turns = [k for k in range(len(bends)) if bends[k:] + bends[:k] == reflex]
    ways = (_sized(code, (*corners[k:], *corners[:k]), area) for k in turns)
    known = [section for section in ways if section is not None]
    least = max((section.height for section in known), default=0.0) - SAME_SIDES
    tall = [section for section in known if section.height >= least]
    return max(tall, key=lambda section: (round(section.y[1], 9), section.y[0]), default=None)


def _sized(code: ProfileCode, corners: Sequence[Corner], area: float) -> Section | None:
    """The section of corners that follow one another as a form's; None if they contradict it."""
    form = FORMS[code]
    a, b = (corners[k].at for k in form.upright)
    y = normalized((b[0] - a[0], b[1] - a[1]))
    z = y[1], -y[0]
    points = [(dot(c.at, z), dot(c.at, y)) for c in corners]
    x0, y0, x1, y1 = plane.box_around(points)
    edges = {"0": x0, "b": x1}, {"0": y0, "h": y1}
    pairs = [*zip(form.corners, points, strict=True)]
    if any(abs(edges[k].get(at[k], p[k]) - p[k]) > ALIKE for at, p in pairs for k in (0, 1)):
        return None

    def level(axis: int, name: str, share: float) -> float:
        """Where a surface is, so much of the way from its roots to its tips."""
        if name in edges[axis]:
            return edges[axis][name]
        tips, roots = (
            [p[axis] for (at, p), c in zip(pairs, corners, strict=True)
             if at[axis] == name and c.reflex == inner] for inner in (False, True)
        )  # fmt: skip
        root = fmean(roots)
        return root + share * (fmean(tips) - root) if tips else root

    def thickness(axis: int, walls: Names, share: float) -> float:
        """That of the walls across an axis; 0 where they differ or lie off the middle."""
        pairs = [(level(axis, low, share), level(axis, high, share)) for low, high in walls]
        sizes = [high - low for low, high in pairs]
        off = sum(pairs[0]) - sum(edges[axis].values()) if walls[0] in MIDDLE else 0.0
        same = max(sizes) - min(sizes) <= ALIKE and abs(off) <= 2 * ALIKE
        return fmean(sizes) if same else 0.0

    height, width = y1 - y0, x1 - x0
    u, v = (x0 + x1) / 2, (y0 + y1) / 2
    centre = z[0] * u + y[0] * v, z[1] * u + y[1] * v
    radius = max(c.radius for c in corners if c.reflex or code == "B")
    if code == "B" and radius - min(c.radius for c in corners) > ROUND_ALIKE * radius:
        radius = 0.0
    web, share = thickness(0, form.webs, 0.0), form.share
    if share is None:  # half way from the back to the tips (DIN 1026)
        share = (width / 2 - web) / (width - web) if width > web else 0.5
    flange = thickness(1, form.flanges, share) if form.flanges else 0.0
    if web <= 0 or web > width or flange > height or (form.flanges and flange <= 0):
        return None
    if code == "L" and width > height:
        height, width, flange, web, y, z = width, height, web, flange, z, y
    section = placed(code, (height, width, flange, web, radius), centre, y, z, area)
    if code != "C":
        return section
    lips = [abs(p[1] - edges[1]["0" if at[1] == "g" else "h"]) for at, p in pairs if at[1] in "gG"]
    return replace(section, lip=fmean(lips) if max(lips) - min(lips) <= ALIKE else None)
