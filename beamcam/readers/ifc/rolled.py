"""The rolled stock that a shell was cut from: the section that is constant along an axis."""

from typing import Any

import numpy as np
from msgspec import Struct
from msgspec.structs import replace

from beamcam.geometry.curves import Point
from beamcam.readers.ifc.classify import classify
from beamcam.readers.ifc.curves2d import Chain
from beamcam.readers.ifc.outline import sharpened
from beamcam.readers.ifc.region import (
    Circles,
    Segments,
    arcs_of,
    chain_of_ring,
    circles_in,
    pieces_of,
    points_of,
    polygon_of,
    region_within,
)
from beamcam.readers.ifc.section import BareStock, Section, placed, plain_stock
from beamcam.readers.ifc.shell import Shell, broadest_normal, coordinates, extent, segments, vec
from beamcam.readers.ifc.space import Frame, Vec, across, add, cross, dot, scale, unit

STATIONS = (0.5, 0.31, 0.69, 0.17, 0.83, 0.08, 0.92, 0.42, 0.58, 0.03, 0.97)
FLAT = 0.6  #: share of its box that a flat bar with bevelled edges fills
FLATTER = 1.5  #: times as wide as thick is a flat bar, at least
CONVEX = 1e-4  #: share of its area by which a section may be hollowed
WHOLE = 0.05  #: mm that a section may be less than its shell
SAME_AREA = 1.0005  #: times the area of a section that another has to have to be a fuller one
SAME = 1e-9  #: mm between the lines of one section at two stations, from rounding


class Rolled(Struct, frozen=True):
    """A stock that was found in a shell, and where."""

    section: Section
    frame: Frame
    x0: float
    x1: float
    outline: tuple[Point, ...]  #: (Y, Z) of the section's border
    stock: BareStock


def other_axes(shell: Shell, along: Vec) -> list[Vec]:
    """Square to the chief direction, for members shorter than their section is wide."""
    normal = broadest_normal(shell)
    if abs(dot(normal, along)) > 0.05:
        normal = across(along)
    return [unit(cross(along, normal)), normal]


def rolled_stock(shell: Shell, axis: Vec) -> Rolled | None:
    """The section of a shell along an axis; None if no station shows a rolled form."""
    from shapely import transform

    u = reference(shell, axis)
    v = cross(axis, u)
    low, high = extent(shell, axis)
    best: tuple[float, Section, Chain, Any, Any] | None = None
    special: tuple[float, Section, Chain, Any, Any] | None = None
    seen: list[Segments] = []
    areas: list[float] = []  #: of the special sections of the stations
    last = 0.0
    for share in STATIONS:
        at = low + share * (high - low)
        lines = segments(shell, scale(axis, at), axis, u, v)
        if any(_same(lines, other) for other in seen):
            areas.append(last)  # most of a member shows one section
            continue
        seen.append(lines)
        last = 0.0
        pieces = pieces_of(region_within(lines))
        if len(pieces) != 1:
            continue
        circles = circles_in(shell.cylinders, axis, u, v)
        outer, inner = arcs_of(pieces[0], circles)
        told = _told(outer, inner, pieces[0]) if outer else None
        if told is not None and told.code == "SO":
            box = (*extent(shell, u), *extent(shell, v))
            last = told.area
            areas.append(last)
            if special is None or told.area > special[0] * SAME_AREA:
                special = told.area, told, outer, pieces[0], pieces[0]
            told = _flat(pieces[0]) if _reaches(pieces[0], box) else None
        if told is None or (told.code == "B" and told.width > 200):
            continue
        if best is None or told.area > best[0] * SAME_AREA:
            exact = polygon_of(outer, inner, Circles()) if circles else pieces[0]
            best = (told.area, told, outer, exact, pieces[0])
    if best is None and special is not None:
        alike = sum(area * SAME_AREA >= special[0] for area in areas)
        best = special if alike > len(STATIONS) // 2 else None
    if best is None:
        return None
    found = best[1]
    o = add(scale(u, found.origin[0]), scale(v, found.origin[1]))
    y = add(scale(u, found.y[0]), scale(v, found.y[1]))
    z = add(scale(u, found.z[0]), scale(v, found.z[1]))
    x = cross(y, z)
    frame = Frame(o, x, y, z)
    x0, x1 = extent(shell, x)
    (ox, oy), sy, sz = found.origin, found.y, found.z
    border = tuple(
        ((p - ox) * sy[0] + (q - oy) * sy[1], (p - ox) * sz[0] + (q - oy) * sz[1])
        for p, q in points_of(best[2], Circles())
    )

    def turned(points: Any) -> Any:
        off = points - np.array(found.origin)
        return np.column_stack((off @ np.array(found.y), off @ np.array(found.z)))

    if found.is_plain_flat:  # its edges may be bevelled all along
        found = replace(found, area=found.height * found.width)
        return Rolled(found, frame, x0, x1, border, plain_stock(found))
    shown = BareStock(transform(best[4], turned), float(best[3].area))
    return Rolled(found, frame, x0, x1, border, shown)


def _same(lines: Segments, others: Segments) -> bool:
    """Whether two stations show one section, as most of a member do."""
    return lines.shape == others.shape and bool((np.abs(lines - others) < SAME).all())


def _told(outer: Chain, inner: tuple[Chain, ...], piece: Any) -> Section | None:
    """The section of an outline; of a mesh's rough roundings by the corners of `piece` alone.

    Some roundings of a mesh may lie on circles, and others not.
    """
    found = classify(outer, inner)
    if found is not None and found.code != "SO":
        return found
    drawn = tuple(
        sharpened(chain_of_ring(r, Circles())) for r in (piece.exterior, *piece.interiors)
    )
    again = classify(drawn[0], drawn[1:]) if drawn[0] else None
    return found if again is None else replace(again, area=float(piece.area))


def _reaches(piece: Any, extents: tuple[float, float, float, float]) -> bool:
    """Whether a section is as wide and high as the shell is."""
    x0, x1, y0, y1 = extents
    pairs = zip(piece.bounds, (x0, y0, x1, y1), strict=True)
    return all(abs(a - b) < WHOLE for a, b in pairs)


def _flat(piece: Any) -> Section | None:
    """The flat bar that a section has been before its long edges were bevelled; None if none."""
    x0, y0, x1, y1 = piece.bounds
    b, h = x1 - x0, y1 - y0
    if piece.interiors or float(piece.convex_hull.area - piece.area) > CONVEX * float(piece.area):
        return None
    if float(piece.area) < FLAT * b * h or max(b, h) < FLATTER * min(b, h):
        return None
    centre, up, right = ((x0 + x1) / 2, (y0 + y1) / 2), (0.0, 1.0), (1.0, 0.0)
    if b > h:
        b, h, up, right = h, b, right, up
    return placed("B", (h, b, 0.0, b, 0.0), centre, up, right, b * h)


def reference(shell: Shell, axis: Vec) -> Vec:
    """A direction square to the axis in which sections lie straight."""
    areas = shell.areas
    upright = np.flatnonzero(np.abs(coordinates(shell.area_normals, axis)) < 1e-3 * areas)
    if not len(upright):
        return across(axis)
    broadest = upright[areas[upright].argmax()]
    return unit(cross(axis, unit(vec(shell.area_normals[broadest]))))
