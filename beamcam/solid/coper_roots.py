"""The steel that a torch square to the bar leaves at the ends and the roots of a profile.

ends      a skew end that no torch was tilted to has what its walls and roots have beyond it
ledges    a web with a hole at a flange keeps a ledge along that
steps     a cut that crosses a root on a slant, or whose corner is round there, is square
"""

from collections.abc import Iterator, Sequence
from math import hypot, radians, tan
from typing import TYPE_CHECKING

from msgspec import Struct
from shapely import LineString, box, union_all

from beamcam.geometry.curves import Curve, Line
from beamcam.machine.coper import Coper
from beamcam.model.part import Part, Profile
from beamcam.solid.coper_solid import Burn
from beamcam.solid.kernel import FREE, Interval, behind, kernel, prism, walls
from beamcam.solid.kernel import outline as section_of
from beamcam.solid.stock_solid import ALONG as ALONG_BAR
from beamcam.solid.stock_solid import Shape, end_planes, is_cut

if TYPE_CHECKING:
    from manifold3d import Manifold

FAR = 1e4  #: mm beyond any section
STEEP = tan(radians(29.0))  #: of an end, along which a step goes on until it meets it
STEP_KERFS = 0.9  #: beside the corner of a step of 60 degrees, in which the jet is round
ON_PLANE = 0.05  #: mm off an end that lie on it
LIP_LAP = 1.0  #: mm beside a kerf's half and a bend that a flange is cut as its lip is
APART = 1.0  #: mm along the bar that web and flange are drawn apart at one cut
SQUARE = 0.05  #: mm along the bar that a square cut may slant
POINTS = 64  #: of a curve


class _End(Struct, frozen=True):
    """A skew end: side X = at - by_y Y - by_z Z."""

    side: float
    at: float
    by_y: float
    by_z: float

    def reach(self, ys: Interval, zs: Interval) -> float:
        """How far it reaches, side X, within a box of the section."""
        return self.at - min(self.by_y * y for y in ys) - min(self.by_z * z for z in zs)

    def within(
        self, shape: Shape, reach: float, by_y: float = 0.0, by_z: float = 0.0
    ) -> "Manifold":
        """What of a section lies behind side X = reach - by_y Y - by_z Z."""
        _, _, high, wide = shape.bounds if not shape.is_empty else (0.0,) * 4
        far = abs(self.by_y) * high + abs(self.by_z) * wide + FREE
        low, most = sorted((self.side * (self.at - 3 * far), self.side * (self.at + 3 * far)))
        bar = prism(shape, low, most, ALONG_BAR)
        return behind(bar, (self.side * reach, 0.0, 0.0), (self.side, by_y, by_z))


def square_ends(
    part: Part, coper: Coper, burns: Sequence[Burn], slack: float
) -> "Iterator[Manifold]":
    """What may stay beyond each skew end of a bar to which no torch was tilted.

    Each wall goes on square to itself to where it reaches farthest, at one of its surfaces. At a
    root web and flange go on to where either of them does, as deep as a pass goes and as wide as
    web and fillets are; so does a flange at its lip, beside the bend too, where cuts of both lap.
    """
    profile = part.profile
    if part.made is not None or coper.unrolls(profile.code):
        return
    # The round jet leaves a little more in the corner of a step.
    step = STEP_KERFS * max((burn.row.kerf for burn in burns), default=0.0) + slack
    section = section_of(part)
    for (x, _, _), (side, by_y, by_z) in end_planes(part, drawn=True):
        near = [burn for burn in burns if side * (burn.path[-1][0] - part.length / 2) > 0.0]
        if not (by_y or by_z) or any(burn.b_deg for burn in near):
            continue
        end = _End(side, side * x, by_y, by_z)
        inside = end.within(section, end.at - 2 * slack, by_y, by_z)
        m = kernel()
        beyond = [*_walls_beyond(end, profile, section, slack)]
        for ys, zs, deep in _at_one_x(profile, coper, near):
            beyond.append(_stepped(end, section, ys, zs, end.reach(*deep) + slack, step))
        yield m.Manifold.batch_boolean(beyond, m.OpType.Add) - inside


def _walls_beyond(
    end: _End, profile: Profile, section: Shape, slack: float
) -> "Iterator[Manifold]":
    """Each wall as far as it reaches at either of its surfaces, with the fillets beside a web."""
    for face, wall in walls(profile).items():
        if face in ("v", "o", "u"):
            slab, flat = (wall.surface, wall.surface + wall.inward * wall.thickness), (0.0, 0.0)
            fillet = profile.radius if (wall.normal == "y") == (profile.code == "T") else 0.0
            low, high = min(slab) - fillet - FREE / 100, max(slab) + fillet + FREE / 100
            across, by_y, by_z = box(low, -FREE, high, profile.width + FREE), 0.0, end.by_z
            if wall.normal == "z":
                across, by_y, by_z = box(-FREE, low, profile.height + FREE, high), end.by_y, 0.0
            reach = end.reach(slab, flat) if wall.normal == "y" else end.reach(flat, slab)
            reach += slack * hypot(1.0, by_y, by_z)
            yield end.within(section.intersection(across), reach, by_y, by_z)


def _at_one_x(
    profile: Profile, coper: Coper, burns: Sequence[Burn]
) -> Iterator[tuple[Interval, Interval, tuple[Interval, Interval]]]:
    """Bands of Y and of Z that are cut at one x, each with the box that says at which."""
    high, wide, r = profile.height, profile.width, profile.radius
    web, lip = profile.web_thickness or 0.0, profile.lip or 0.0
    is_tee = profile.code == "T"
    across = high if is_tee else wide  # of a T the flange lies along Y, its root along Z
    first = (across - (profile.flange_thickness if is_tee else web)) / 2
    first = first if profile.code in ("I", "T") else 0.0
    last = first + (profile.flange_thickness if is_tee else web)
    beside = max(first - r, 0.0), min(last + r, across)
    deep = 0.0
    for burn in burns:
        zs = [q if burn.a_deg > 0.0 else -q for _, q in burn.path]
        zs = zs if profile.code in ("I", "U", "L") else [across - z for z in zs]
        if abs(burn.a_deg) > 45.0 and min(zs) < (first + last) / 2 < max(zs):
            deep = max(deep, burn.row.up_to)
    deep += ON_PLANE
    if is_tee:
        yield beside, (0.0, deep), (beside, (0.0, deep))
        return
    for ys in [(0.0, deep), (high - deep, high)][: 1 if profile.code == "L" else 2]:
        yield ys, beside, (ys, beside)
    if lip:
        bend = web + r
        band = wide - bend - LIP_LAP - max(row.kerf for row in coper.rows) / 2, wide
        for ys in ((0.0, lip), (high - lip, high)):
            yield ys, band, (ys, (wide - bend, wide))


def _stepped(
    end: _End, section: Shape, ys: Interval, zs: Interval, reach: float, step: float
) -> "Manifold":
    """The walls through a box of the section up to one x, and beyond it while a steep end lies
    before that."""
    (y0, y1), (z0, z1) = (
        (-FAR if by > STEEP else low - step, FAR if by < -STEEP else high + step)
        for (low, high), by in ((ys, end.by_y), (zs, end.by_z))
    )
    cross = union_all([box(ys[0], z0, ys[1], z1), box(y0, zs[0], y1, zs[1])])
    return end.within(section.intersection(cross), reach)


def ledges_of(
    drawn: "Manifold", part: Part, burns: Sequence[Burn], slack: float
) -> "Iterator[Manifold]":
    """What may stay of a web along each flange where the part, without bevels, has a hole in it.

    Over the web no torch comes to the flange; it is as high as a pass through the root is deep.
    """
    m = kernel()
    profile, flange = part.profile, part.profile.flange_thickness
    if profile.code not in ("I", "U", "L", "T", "C") or not burns:
        return
    rows = [burn.row for burn in burns if burn.a_deg]
    ends = [*end_planes(part, drawn=True)]
    # The round jet leaves a little more in the corner between the hole and what stays.
    deep = max((row.up_to for row in rows), default=0.0) + 2 * slack
    deep += max(burn.row.kerf for burn in burns)
    high, wide = profile.height, profile.width
    strips = [(0.0, flange, deep)]
    if profile.code in ("I", "U", "C"):
        strips.append((high - flange, high - deep, high - flange))
    for low, first, last in strips:
        first, last = sorted((first, last))
        boxes = []
        for a, b in ((low, low + flange), (first, last)):
            size, at = (b - a, 2 * wide), (a, -wide / 2)
            if profile.code == "T":
                size, at = (2 * high, b - a), (-high / 2, a)
            cube = m.Manifold.cube((2 * part.length, *size))
            boxes.append(cube.translate((-part.length / 2, *at)))
        stays = (drawn ^ boxes[0]).bounding_box()
        # At a skew end the web may go on farther than its flange.
        more = deep * max(abs(normal[1]) for _, normal in ends)
        strip = prism(section_of(part), stays[0] - more, stays[3] + more, ALONG_BAR) ^ boxes[1]
        for place, normal in ends if more else ():
            strip = behind(strip, place, normal)
        ledge = strip - drawn
        if ledge.volume() > 1.0:
            yield ledge


def steps_of(
    part: Part, rounds: Sequence[tuple[str, Shape]], burns: Sequence[Burn], slack: float
) -> "Iterator[Manifold]":
    """What may stay at a root that an outline crosses otherwise than square to the bar.

    It lies within the outline's own stretch of the bar, or that of a corner's round, as deep as a
    pass through the root cuts, and of the flange as wide as web and fillets are. `rounds` are what
    corners keep, by the faces of their walls.
    """
    m = kernel()
    profile, is_tee = part.profile, part.profile.code == "T"
    web = profile.web_thickness or 0.0
    deep = max((burn.row.up_to for burn in burns if burn.a_deg), default=0.0)
    if profile.code not in ("I", "U", "L", "T", "C") or not deep:
        return
    near = max(burn.row.kerf for burn in burns) + slack
    high, wide = (profile.width, profile.height) if is_tee else (profile.height, profile.width)
    middle = (wide - web) / 2 if profile.code in ("I", "T") else 0.0
    across = middle - profile.radius - near, middle + web + profile.radius + near
    for face in "u" if profile.code in ("L", "T") else "uo":
        low = face == "u"
        root = (0.0, deep + near) if low else (high - deep - near, high)
        webs, own = ("ou", "hv") if is_tee else ("vh", face)
        inner = (0.0, deep + SQUARE) if low else (high - deep - SQUARE, high)
        edges = [(c.face, edge) for c in part.contours if is_cut(c) for edge in c.curves]
        for of_face, edge in (*edges, *rounds):
            band = inner if of_face in webs else across if of_face in own else None
            xs = _stretch(edge, band) if band else None
            if xs is None or xs[1] - xs[0] <= SQUARE:
                continue
            first, last = xs[0] - APART - slack, xs[1] + APART + slack
            (y0, y1), (z0, z1) = (across, root) if is_tee else (root, across)
            cube = m.Manifold.cube((last - first, y1 - y0, z1 - z0)).translate((first, y0, z0))
            yield prism(section_of(part), first, last, ALONG_BAR) ^ cube


def _stretch(edge: Curve | Shape, band: tuple[float, float]) -> tuple[float, float] | None:
    """The least and the greatest x of what of a band lies on an edge or in a round; None if nothing
    does, or if a straight edge ends in the band."""
    if isinstance(edge, Line):
        (xa, ya), (xb, yb) = sorted((edge.start, edge.end), key=lambda place: place[1])
        low, high = max(band[0], ya), min(band[1], yb)
        if high - low < (band[1] - band[0]) / 2:
            return None
        first, last = (xa + (xb - xa) * (y - ya) / (yb - ya) for y in (low, high))
        return min(first, last), max(first, last)
    if isinstance(edge, Curve):
        edge = LineString([edge.point(k / POINTS) for k in range(POINTS + 1)])
    there = edge.intersection(box(-1e6, band[0], 1e6, band[1]))
    first, _, last, _ = there.bounds
    return None if there.is_empty else (first, last)
