"""A body as a solid of manifold3d; by its sections across where its faces close none."""

from collections.abc import Iterator
from itertools import groupby
from typing import TYPE_CHECKING, Any

import numpy as np
import shapely

from beamcam.budget import check_member
from beamcam.readers.ifc.region import Shape
from beamcam.readers.ifc.shell import ALONG, Points, Shell, section
from beamcam.solid.kernel import kernel, prism
from beamcam.solid.stock_solid import ALONG as SECTIONS

if TYPE_CHECKING:
    from manifold3d import Manifold

WELDED = 5  #: decimals of a mm to which corners of faces are one
NEAR_EVENTS = 0.05  #: mm between two x that are one
#: Takes (x, y, z) to (Y, Z, x), for sections across.
ACROSS = ((0.0, 1.0, 0.0, 0.0), (0.0, 0.0, 1.0, 0.0), (1.0, 0.0, 0.0, 0.0))
MOST_STATIONS = 160  #: that are looked at; the longest stretches come first


def solid_of(body: Shell) -> "Manifold | None":
    """A shell as a solid; None where its faces do not close one."""
    points, places = np.unique(body.points.round(WELDED) + 0.0, axis=0, return_inverse=True)
    corners = places.reshape(-1)[_triangles(body)]
    a, b, c = corners.T
    corners = corners[(a != b) & (b != c) & (c != a)]
    found = _manifold(points, corners)
    if found is not None and found.volume() < 0.0:  # turned inside out
        found = _manifold(points, corners[:, ::-1])
    return found


def _manifold(points: Points, corners: Any) -> "Manifold | None":
    m = kernel()
    triangles = np.ascontiguousarray(corners.astype(np.uint64))
    found = m.Manifold(m.Mesh64(np.ascontiguousarray(points), triangles))
    return None if found.status() != m.Error.NoError or found.is_empty() else found


def _triangles(body: Shell) -> Any:
    """The corners of triangles that the faces of a shell are made of, counter-clockwise."""
    corners = np.arange(len(body.points))
    if len(corners) == 3 * body.count:
        return corners.reshape(-1, 3)
    found = []
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
        found.append(np.concatenate(places)[kernel().triangulate(drawn)])
    return np.concatenate(found)


def stretches(events: Any) -> list[tuple[float, float]]:
    """The stretches between some x, the longest if there are too many."""
    marks = np.unique(events.round(4))
    edges = np.array([m for i, m in enumerate(marks) if i == 0 or m - marks[i - 1] > NEAR_EVENTS])
    chosen = np.sort(np.argsort(-np.diff(edges), kind="stable")[:MOST_STATIONS])
    return [(float(edges[k]), float(edges[k + 1])) for k in chosen.tolist()]


def across(body: Shell, x: float) -> Shape:
    """The body's section at x, in (Y, Z)."""
    return section(body, (x, 0.0, 0.0), ALONG, (0.0, 1.0, 0.0), (0.0, 0.0, 1.0))


def section_area(body: Shell) -> float:
    """mm3 of a body by its sections, which crossings measure even where faces lie twice."""
    points = stretches(body.points[:, 0])
    return sum(float(across(body, (x0 + x1) / 2).area) * (x1 - x0) for x0, x1 in points)


def by_stations(body: Shell, drawn: "Manifold", slack: float) -> "Iterator[tuple[bool, Manifold]]":
    """The differences from a body whose faces close no solid, by sections across.

    They lie between all x at which body or part change their form.
    """
    lying = drawn.transform(ACROSS)
    ends = lying.to_mesh64().vert_properties[:, 2]
    for x0, x1 in stretches(np.concatenate((body.points[:, 0], ends))):
        check_member()
        theirs, ours = across(body, (x0 + x1) / 2), _section(lying, (x0 + x1) / 2)
        for more, shape in ((True, theirs.difference(ours)), (False, ours.difference(theirs))):
            wide = shape.buffer(-slack).buffer(slack)
            if not wide.is_empty:
                yield more, prism(wide, x0, x1, SECTIONS)


def _section(solid: "Manifold", x: float) -> Shape:
    shape = shapely.union_all([])
    for ring in solid.slice(x).to_polygons():
        shape = shape.symmetric_difference(shapely.Polygon(ring).buffer(0))
    return shape
