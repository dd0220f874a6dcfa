"""Section of an outline, by its geometry alone: the form of FORMS whose corners it has."""

from collections.abc import Sequence
from statistics import fmean

from msgspec.structs import replace

from beamcam.geometry.curves import signed_area
from beamcam.geometry.plane import box_around, cross, distance, dot, normalized
from beamcam.model.part import ProfileCode
from beamcam.readers.ifc.curves2d import Chain
from beamcam.readers.ifc.outline import Corner, Round, corners_of, shape_of, with_arcs
from beamcam.readers.ifc.section import FORMS, SQUARE, Names, Section, placed, special

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
    d = shape.diameter
    if not inner:
        return placed("RU", (d, d, 0.0, d, 0.0), shape.centre, (0.0, 1.0), (1.0, 0.0), area)
    bore = shape_of(inner[0])
    if not isinstance(bore, Round):
        return None
    wall = (d - bore.diameter) / 2
    if distance(bore.centre, shape.centre) > 0.1 * wall or wall <= 0:
        return None
    return placed("RO", (d, d, wall, wall, 0.0), shape.centre, (0.0, 1.0), (1.0, 0.0), area)


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
    return replace(
        outside, code="M", flange_thickness=walls[0], web_thickness=walls[1], radius=radius
    )


def _measured(code: ProfileCode, corners: Sequence[Corner], area: float) -> Section | None:
    """The section whose corners are those of a form; None if they are not.

    Of the ways in which a form lies, the one with the greater side upright.
    """
    bends, reflex = tuple(corner.reflex for corner in corners), FORMS[code].reflex
    turns = [k for k in range(len(bends)) if bends[k:] + bends[:k] == reflex]
    ways = [_sized(code, (*corners[k:], *corners[:k]), area) for k in turns]
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
    x0, y0, x1, y1 = box_around(points)
    edges = {"0": x0, "b": x1}, {"0": y0, "h": y1}
    pairs = [*zip(form.corners, points, strict=True)]
    if any(abs(edges[k].get(at[k], p[k]) - p[k]) > ALIKE for at, p in pairs for k in (0, 1)):
        return None

    def level(axis: int, name: str, share: float) -> float:
        """Where a surface is, so much of the way from its roots to its tips."""
        if name in edges[axis]:
            return edges[axis][name]
        there = [
            (p[axis], c.reflex)
            for (at, p), c in zip(pairs, corners, strict=True)
            if at[axis] == name
        ]
        root, tips = fmean(p for p, inner in there if inner), [p for p, inner in there if not inner]
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
