"""The steel that a torch square to the bar leaves at the ends and the roots of a profile.

ends      a skew end that no torch was tilted to has what its walls and roots have beyond it
ledges    a web with a hole at a flange keeps a ledge along that
steps     a cut that crosses a root on a slant, or whose corner is round there, is square
"""

from collections.abc import Iterator, Sequence
from typing import TYPE_CHECKING

from beamcam.geometry.curves import Curve, Line
from beamcam.machine.coper import Coper
from beamcam.model.part import Part
from beamcam.solid.coper_solid import Burn
from beamcam.solid.kernel import FREE, behind, kernel, prism
from beamcam.solid.kernel import outline as section_of
from beamcam.solid.stock_solid import ALONG as ALONG_BAR
from beamcam.solid.stock_solid import Shape, end_planes, is_cut

if TYPE_CHECKING:
    from manifold3d import Manifold

LIP_LAP = 1.0  #: mm beside a kerf's half and a bend that a flange is cut as its lip is
APART = 1.0  #: mm along the bar that web and flange are drawn apart at one cut
SQUARE = 0.05  #: mm along the bar that a square cut may slant
POINTS = 64  #: of a curve


def square_ends(
    part: Part, coper: Coper, burns: Sequence[Burn], slack: float
) -> "Iterator[Manifold]":
    """What may stay beyond each skew end of a bar to which no torch was tilted.

    Square to a wall t thick it is t times the tangent of the angle at most; through a root a pass
    goes square as deep as its row, and as wide as web and fillets are. A flange with a lip is as
    long as that beside its bend, where the cuts of both lap, by whatever rows.
    """
    profile = part.profile
    if part.made is not None or coper.unrolls(profile.code):
        return
    deepest = max((burn.row.up_to for burn in burns), default=0.0) + slack
    # The round jet leaves a little more in the corner of a step.
    half_kerf = max((burn.row.kerf for burn in burns), default=0.0) / 2
    wide = (profile.web_thickness or 0.0) + 2 * profile.radius
    if profile.lip:
        bend = (profile.web_thickness or 0.0) + profile.radius
        wide = max(wide, bend + LIP_LAP + max(row.kerf for row in coper.rows) / 2)
    wide += half_kerf + slack
    over = profile.height + profile.width + FREE
    bar = prism(section_of(part), -over, part.length + over, ALONG_BAR)
    for (x, y, z), (side, by_y, by_z) in end_planes(part, drawn=True):
        near = [burn for burn in burns if side * (burn.path[-1][0] - part.length / 2) > 0.0]
        if not (by_y or by_z) or any(burn.b_deg for burn in near):
            continue
        # A T lies on its side: its flange is seen along its z.
        across, along = (abs(by_z), abs(by_y)) if profile.code == "T" else (abs(by_y), abs(by_z))
        most = across * deepest + along * wide
        grown = behind(bar, (x + side * (most + slack), y, z), (side, by_y, by_z))
        yield grown - behind(bar, (x - side * 2 * slack, y, z), (side, by_y, by_z))


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
        slabs = [(low, low + flange), (first, last)]
        boxes = [
            m.Manifold.cube((2 * part.length, b - a, 2 * wide)).translate(
                (-part.length / 2, a, -wide / 2)
            )
            if profile.code != "T"
            else m.Manifold.cube((2 * part.length, 2 * high, b - a)).translate(
                (-part.length / 2, -high / 2, a)
            )
            for a, b in slabs
        ]
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
    from shapely import LineString, box

    if isinstance(edge, Line):
        return _crossing(edge, band)
    if isinstance(edge, Curve):
        edge = LineString([edge.point(k / POINTS) for k in range(POINTS + 1)])
    there = edge.intersection(box(-1e6, band[0], 1e6, band[1]))
    first, _, last, _ = there.bounds
    return None if there.is_empty else (first, last)


def _crossing(line: Line, band: tuple[float, float]) -> tuple[float, float] | None:
    """The least and the greatest x of a line on a band that it crosses; None if it does not."""
    (xa, ya), (xb, yb) = sorted((line.start, line.end), key=lambda place: place[1])
    low, high = max(band[0], ya), min(band[1], yb)
    if high - low < (band[1] - band[0]) / 2:
        return None
    first, last = (xa + (xb - xa) * (y - ya) / (yb - ya) for y in (low, high))
    return min(first, last), max(first, last)
