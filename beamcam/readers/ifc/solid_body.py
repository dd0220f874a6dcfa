"""A body as a solid of manifold3d; by its sections across where its faces close none.

Likewise round tubes as solids of fine facets, less their cutters, and their part beside them.
"""

from collections.abc import Iterator
from itertools import groupby
from math import copysign, pi
from typing import TYPE_CHECKING, Any

import numpy as np
import shapely
from msgspec.structs import replace

from beamcam.budget import check_member
from beamcam.model.part import Contour, EndPlane, Part
from beamcam.readers.ifc import rules
from beamcam.readers.ifc.body import FAR
from beamcam.readers.ifc.cutters import Combined, Cutter, HalfSpace, Prism
from beamcam.readers.ifc.entities import Unreadable
from beamcam.readers.ifc.finish import Shaped
from beamcam.readers.ifc.region import Circles, Shape, polygon_of
from beamcam.readers.ifc.shell import ALONG, Shell, section
from beamcam.readers.ifc.space import dot, size
from beamcam.solid.kernel import behind, facets, kernel, minus, prism
from beamcam.solid.part_solid import part_solid
from beamcam.solid.stock_solid import ALONG as SECTIONS
from beamcam.solid.stock_solid import Margins, end_planes
from beamcam.solid.wrapped import round_cutters

if TYPE_CHECKING:
    from manifold3d import Manifold

WELDED = 5  #: decimals of a mm to which corners of faces are one
NEAR_EVENTS = 0.05  #: mm between two x that are one
#: Takes (x, y, z) to (Y, Z, x), for sections across.
ACROSS = ((0.0, 1.0, 0.0, 0.0), (0.0, 0.0, 1.0, 0.0), (1.0, 0.0, 0.0, 0.0))
MOST_STATIONS = 160  #: that are looked at; the longest intervals come first


def solid_of(body: Shell) -> "Manifold | None":
    """A shell as a solid; None where its faces do not close one."""
    points, places = np.unique(body.points.round(WELDED) + 0.0, axis=0, return_inverse=True)
    corners = places.reshape(-1)[_triangles(body)]
    a, b, c = corners.T
    corners = corners[(a != b) & (b != c) & (c != a)]
    m = kernel()
    for triangles in (corners, corners[:, ::-1]):  # the faces may be turned inside out
        mesh = m.Mesh64(np.ascontiguousarray(points), np.ascontiguousarray(triangles, np.uint64))
        solid = m.Manifold(mesh)
        if solid.status() != m.Error.NoError or solid.is_empty():
            return None
        if solid.volume() >= 0.0:
            break
    return solid


def _triangles(body: Shell) -> Any:
    """The corners of triangles that the faces of a shell are made of, counter-clockwise."""
    corners = np.arange(len(body.points))
    if len(corners) == 3 * body.count:
        return corners.reshape(-1, 3)
    triangles = []
    rings = np.split(corners, np.flatnonzero(body.before > corners)[1:])
    for face, of_face in groupby(rings, key=lambda ring: int(body.face[ring[0]])):
        normal = body.area_normals[face]
        drop = int(np.abs(normal).argmax())
        u, v = ((1, 2), (2, 0), (0, 1))[drop]
        places: list[Any] = []
        drawn: list[Any] = []
        for ring in of_face:
            x, y = body.points[ring, u], body.points[ring, v] * np.sign(normal[drop])
            way = -1 if places and x @ np.roll(y, -1) > y @ np.roll(x, -1) else 1
            places.append(ring[::way])  # hollows run the other way
            drawn.append(np.column_stack((x, y))[::way])
        triangles.append(np.concatenate(places)[kernel().triangulate(drawn)])
    return np.concatenate(triangles)


def intervals(events: Any) -> list[tuple[float, float]]:
    """The intervals between some x, the longest if there are too many."""
    marks = np.unique(events.round(4))
    edges = np.array([m for i, m in enumerate(marks) if i == 0 or m - marks[i - 1] > NEAR_EVENTS])
    chosen = np.sort(np.argsort(-np.diff(edges), kind="stable")[:MOST_STATIONS])
    return [(float(edges[k]), float(edges[k + 1])) for k in chosen.tolist()]


def across(body: Shell, x: float) -> Shape:
    """The body's section at x, in (Y, Z)."""
    return section(body, (x, 0.0, 0.0), ALONG, (0.0, 1.0, 0.0), (0.0, 0.0, 1.0))


def section_area(body: Shell) -> float:
    """mm3 of a body by its sections, which crossings measure even where faces lie twice."""
    points = intervals(body.points[:, 0])
    return sum(float(across(body, (x0 + x1) / 2).area) * (x1 - x0) for x0, x1 in points)


def by_stations(body: Shell, drawn: "Manifold", slack: float) -> "Iterator[tuple[bool, Manifold]]":
    """The differences from a body whose faces close no solid, by sections across.

    They lie between all x at which body or part change their form.
    """
    lying = drawn.transform(ACROSS)
    ends = lying.to_mesh64().vert_properties[:, 2]
    for x0, x1 in intervals(np.concatenate((body.points[:, 0], ends))):
        check_member()
        theirs, ours = across(body, (x0 + x1) / 2), shapely.union_all([])
        for ring in lying.slice((x0 + x1) / 2).to_polygons():
            ours = ours.symmetric_difference(shapely.Polygon(ring).buffer(0))
        for more, shape in ((True, theirs.difference(ours)), (False, ours.difference(theirs))):
            wide = shape.buffer(-slack).buffer(slack)
            if not wide.is_empty:
                yield more, prism(wide, x0, x1, SECTIONS)


# --- tubes ----------------------------------------------------------------------------------------

SAGITTA = 1e-3  #: mm between the tube and its facets
COARSE = 1e-2  #: mm likewise, where a contour is no more than looked at
NEARLY = 0.02  #: mm between a cutter and its facets, where it has a larger margin
SKIN = 0.02  #: mm deep that the outside is looked at
SAME = 0.08  #: mm that it may lie beside its contours
LEAST_AREA = 1.0  #: mm2 of the outside that differ


def round_bar(radius: float, axis: float, facets: int, low: float, high: float) -> "Manifold":
    """A round bar of so many facets, whose corners lie on it.

    Between them a border is off by the sagitta / tan(a) at most, where the cut meets the surface at
    an angle a. What goes straight through a wall t does so at cos(a) = 1 - t/R at least: with
    SAGITTA 0.003 mm off for a wall of R / 20.
    """
    turns = 2 * pi * np.arange(facets) / facets
    ring = np.column_stack((axis - radius * np.cos(turns), axis + radius * np.sin(turns)))
    return prism(shapely.Polygon(ring), low, high, SECTIONS)


def cutter_solid(cutter: Cutter, margin: float = 0.0, chord: float = 0.0) -> "Manifold":
    """A cutter as a solid, larger by a margin; one by its faces is as large as it is.

    Its round sides are as near as the polygons of a region are, or less by a chord. Raises
    Unreadable where faces close none.
    """
    match cutter:
        case HalfSpace():
            world, normal = kernel().Manifold.cube((2 * FAR, 2 * FAR, 2 * FAR), True), cutter.normal
            return world.trim_by_plane(normal, dot(cutter.point, normal) - margin)
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
    radius, n = p.height / 2, facets(p.height / 2, COARSE)
    wall = p.web_thickness or p.flange_thickness
    outer, inner = (
        round_bar(radius - deep, radius, n, -over, part.length + over)
        for deep, over in ((0.0, 1.0), (SKIN, 2.0))
    )
    skin = outer - inner
    taken = [cutter_solid(one, chord=COARSE) for one in shaped.cutters]
    left = minus(skin.translate((shaped.x0, 0.0, 0.0)), taken).translate((-shaped.x0, 0.0, 0.0))
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
            x -= copysign(1.0, one.normal[0]) * margins.end
            skin = behind(skin, (x, y, z), one.normal)
    bodies = [body for one in part.contours for body in round_cutters(one, part, margins)]
    return minus(skin, bodies)
