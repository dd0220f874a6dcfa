"""Round tubes as solids of fine facets, less their cutters, and their part beside them."""

from collections.abc import Iterator, Sequence
from math import acos, atan2, ceil, degrees, pi
from typing import TYPE_CHECKING

import numpy as np
from msgspec.structs import replace
from shapely import Polygon

from beamcam.model.part import Contour, EndPlane, Part
from beamcam.readers.ifc import rules
from beamcam.readers.ifc.cutters import Combined, Cutter, HalfSpace, Prism
from beamcam.readers.ifc.entities import Unreadable
from beamcam.readers.ifc.finish import Shaped
from beamcam.readers.ifc.region import Circles, polygon_of
from beamcam.readers.ifc.solid_body import solid_of
from beamcam.readers.ifc.space import size
from beamcam.solid.kernel import behind, kernel, minus, prism
from beamcam.solid.part_solid import part_solid
from beamcam.solid.stock_solid import ALONG, Margins, end_planes
from beamcam.solid.wrapped import round_cutters

if TYPE_CHECKING:
    from manifold3d import Manifold

SAGITTA = 1e-3  #: mm between the tube and its facets
COARSE = 1e-2  #: mm likewise, where a contour is no more than looked at
NEARLY = 0.02  #: mm between a cutter and its facets, where it has a larger margin
FAR = 1e6  #: mm beyond any member
SKIN = 0.02  #: mm deep that the outside is looked at
SAME = 0.08  #: mm that it may lie beside its contours
LEAST_AREA = 1.0  #: mm2 of the outside that differ


def facets_of(radius: float, sagitta: float = SAGITTA) -> int:
    """Facets round a tube.

    Their corners lie on it; between them a border is off by sagitta / tan(a) at most, where the cut
    meets the surface at an angle a. What goes straight through a wall t does so at cos(a) = 1 - t/R
    at least: 0.003 mm off for a wall of R / 20.
    """
    return 4 * ceil(pi / acos(1 - sagitta / radius) / 4)


def round_bar(radius: float, axis: float, facets: int, low: float, high: float) -> "Manifold":
    turns = 2 * pi * np.arange(facets) / facets
    ring = np.column_stack((axis - radius * np.cos(turns), axis + radius * np.sin(turns)))
    return prism(Polygon(ring), low, high, ALONG)


def cutter_solid(cutter: Cutter, margin: float = 0.0, chord: float = 0.0) -> "Manifold":
    """A cutter as a solid, larger by a margin; one by its faces is as large as it is.

    Its round sides are as near as the polygons of a region are, or less by a chord. Raises
    Unreadable where faces close none.
    """
    match cutter:
        case HalfSpace():
            (x, y, z), (a, b, c) = cutter.point, cutter.normal
            world = kernel().Manifold.cube((2 * FAR, 2 * FAR, 2 * FAR), True)
            return world.trim_by_plane((a, b, c), a * x + b * y + c * z - margin)
        case Prism():
            f = cutter.frame
            wide = size(f.x)
            shape = polygon_of(cutter.outline.outer, cutter.outline.inner, Circles())
            shape = shape.simplify(chord / wide)
            if margin:
                shape = shape.buffer(margin / wide, join_style="mitre")
            rows = zip(f.x, f.y, f.z, f.o, strict=True)
            by = margin / size(f.z)
            return prism(shape, -by, 1.0 + by, tuple(rows))  # type: ignore[arg-type]
        case Combined():
            first = cutter_solid(cutter.first, margin, chord)
            for one in cutter.others:
                other = cutter_solid(one, -margin if cutter.less else margin, chord)
                first = first - other if cutter.less else first ^ other
            return first
    solid = solid_of(cutter)
    if solid is None:
        raise Unreadable("a cut by faces that close no solid", rules.ODD_CUT, final=True)
    return solid


def less(body: "Manifold", cutters: Sequence[Cutter], axis: float, chord: float) -> "Manifold":
    """A tube less its cutters.

    The kernel looks for facets that meet by their boxes, which are small only of facets that run
    along a plane of two axes. So round cutters are taken off as they lie across.
    """
    for one in cutters:
        turn = 0.0
        if isinstance(one, Prism):
            turn = degrees(atan2(one.frame.z[2], one.frame.z[1]))
        to, back = (0.0, -axis, -axis), (0.0, axis, axis)
        body, taken = (
            solid.translate(to).rotate((-turn, 0.0, 0.0))
            for solid in (body, cutter_solid(one, chord=chord))
        )
        body = (body - taken).rotate((turn, 0.0, 0.0)).translate(back)
    return body


# --- the part beside the body ---------------------------------------------------------------------


def solid_less(part: Part, shaped: Shaped, margins: Margins) -> "Manifold":
    """The solid of a tube whose contours are cut as its cutters lie."""
    kept = tuple(f for f in part.features if not isinstance(f, Contour))
    solids = [cutter_solid(one, margins.outline, NEARLY) for one in shaped.cutters]
    place = -shaped.x0, 0.0, 0.0
    return minus(part_solid(replace(part, features=kept), margins),
                 [one.translate(place) for one in solids])  # fmt: skip


def beside_contours(part: Part, shaped: Shaped) -> "Iterator[tuple[bool, Manifold, float]]":
    """What of the outside lies beside the part's contours: whether it is more steel than these
    leave, a piece of the skin, and the mm3 of wall below it."""
    p = part.profile
    radius, n = p.height / 2, facets_of(p.height / 2, COARSE)
    wall = p.web_thickness or p.flange_thickness
    outer, inner = (
        round_bar(radius - deep, radius, n, -over, part.length + over)
        for deep, over in ((0.0, 1.0), (SKIN, 2.0))
    )
    skin = outer - inner
    left = less(skin.translate((shaped.x0, 0.0, 0.0)), shaped.cutters, radius, COARSE)
    left = left.translate((-shaped.x0, 0.0, 0.0))
    least, most = (_skin_of(part, skin, Margins(end=by, outline=by)) for by in (SAME, -SAME))
    for more, rest in ((True, left - most), (False, least - left)):
        for one in rest.decompose():
            area = float(one.volume()) / SKIN
            if area > LEAST_AREA:
                yield more, one, area * wall


def _skin_of(part: Part, skin: "Manifold", margins: Margins) -> "Manifold":
    """What a part's ends and contours leave of its skin."""
    for point, normal in end_planes(part, margins):
        skin = behind(skin, point, normal)
    for one in part.features:
        if isinstance(one, EndPlane):
            x, y, z = one.point
            side = 1.0 if one.normal[0] > 0.0 else -1.0
            skin = behind(skin, (x - side * margins.end, y, z), one.normal)
    bodies = [body for one in part.contours for body in round_cutters(one, part, margins)]
    return minus(skin, bodies)
