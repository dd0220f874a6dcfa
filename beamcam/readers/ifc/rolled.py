"""The rolled stock that a shell was cut from: the section that is constant along an axis."""

from math import asin, ceil, cos
from typing import Any

import numpy as np
from msgspec.structs import replace
from shapely import Polygon, transform, union_all

from beamcam.geometry.curves import Arc
from beamcam.readers.ifc.classify import classify
from beamcam.readers.ifc.curves2d import Chain, points_chain
from beamcam.readers.ifc.cutters import MIN_LEAN
from beamcam.readers.ifc.outline import sharpened, with_arcs
from beamcam.readers.ifc.region import (
    Circles,
    Segments,
    chain_of_ring,
    chains_of,
    circles_in,
    pieces_of,
    polygon_of,
    region_within,
)
from beamcam.readers.ifc.section import BareStock, Section, plain_stock
from beamcam.readers.ifc.shell import (
    Places,
    Shell,
    broadest_normal,
    coordinates,
    extent,
    heaviest,
    segments,
    vec,
)
from beamcam.readers.ifc.space import Frame, Vec, across, add, cross, dot, scale, sub, unit
from beamcam.readers.ifc.stock import Stock

STATIONS = (0.5, 0.31, 0.69, 0.17, 0.83, 0.08, 0.92, 0.42, 0.58, 0.03, 0.97)
FLAT = 0.6  #: share of its box that a flat bar with bevelled edges fills
FLATTER = 1.5  #: times as wide as thick is a flat bar, at least
CONVEX = 1e-4  #: share of its area by which a section may be hollowed
WHOLE = 0.05  #: mm that a section may be less than its shell
SAME_AREA = 1.0005  #: times the area of a section that another has to have to be a fuller one
SAME_SIZE = 3  #: decimals of mm2 in which sections are alike where facets run along the member
WHOLE_END = 0.95  #: share of the largest section that an end shows, at least
SLANTED = 1.5  #: times the angle of an end's chord that a facet may span which runs slantwise
ON_ARC = 0.01  #: mm between a rounding and the corners on it
NEARLY_PLANE = 1 - 1e-8  #: cosine between the facets of one plane
SAME = 1e-9  #: mm between the lines of one section at two stations, from rounding


Best = tuple[Section, BareStock]  #: a section, its shape in the axes of the stations


def other_axes(shell: Shell, along: Vec) -> list[Vec]:
    """Square to the chief direction, for members shorter than their section is wide."""
    normal = broadest_normal(shell)
    if abs(dot(normal, along)) > 0.05:
        normal = across(along)
    return [unit(cross(along, normal)), normal]


def rolled_stock(shell: Shell, axis: Vec) -> Stock | None:
    """The stock of a shell along an axis; None if no station shows a rolled form."""
    u = reference(shell, axis)
    v = cross(axis, u)
    low, high = extent(shell, axis)
    best: Best | None = None
    special: Best | None = None
    seen: list[Segments] = []
    areas: list[float] = []  #: of each station's section if it is a special one, else 0
    sizes: list[float] = []
    for share in STATIONS:
        at = low + share * (high - low)
        lines = segments(shell, scale(axis, at), axis, u, v)
        if any(lines.shape == o.shape and (np.abs(lines - o) < SAME).all() for o in seen):
            areas.append(areas[-1])  # most of a member shows one section
            continue
        seen.append(lines)
        areas.append(0.0)
        pieces = pieces_of(region_within(lines))
        sizes += [float(piece.area) for piece in pieces]
        if len(pieces) != 1:
            continue
        circles = circles_in(shell.cylinders, axis, u, v)
        outer, inner = chains_of(pieces[0], circles)
        section = _told(outer, inner, pieces[0]) if outer else None
        if section is not None and section.code == "SO":
            (x0, x1), (y0, y1) = extent(shell, u), extent(shell, v)
            off = np.abs(np.subtract(pieces[0].bounds, (x0, y0, x1, y1)))
            areas[-1] = section.area
            if special is None or section.area > special[0].area * SAME_AREA:
                special = section, BareStock(pieces[0], sizes[-1])
            # A bar with bevelled edges is as wide and high as its shell is.
            section = _flat(pieces[0]) if off.max() < WHOLE else None
        if section is None or (section.code == "B" and section.width > 200):
            continue
        if best is None or section.area > best[0].area * SAME_AREA:
            exact = polygon_of(outer, inner, Circles()) if circles.known else pieces[0]
            best = section, BareStock(pieces[0], float(exact.area))
    slanted = len({round(size, SAME_SIZE) for size in sizes}) > len(STATIONS) // 2
    if slanted and not shell.cylinders:
        ends = (_end_section(shell, axis, side, u, v, max(sizes)) for side in (-1, 1))
        best = next((one for one in ends if one is not None), best)
    if best is None and special is not None:
        alike = sum(area * SAME_AREA >= special[0].area for area in areas)
        best = special if alike > len(STATIONS) // 2 else None
    return None if best is None else _placed(shell, *best, u, v)


def _placed(shell: Shell, section: Section, bare: BareStock, u: Vec, v: Vec) -> Stock:
    """The stock of a section that stations along a shell show, in axes u and v."""
    o, y, z = (add(scale(u, p), scale(v, q)) for p, q in (section.origin, section.y, section.z))
    frame = Frame(o, cross(y, z), y, z)

    def turned(points: Any) -> Any:
        off = points - np.array(section.origin)
        return np.column_stack((off @ np.array(section.y), off @ np.array(section.z)))

    if section.is_plain_flat:  # its edges may be bevelled all along
        section = replace(section, area=section.height * section.width)
        bare = plain_stock(section)
    else:
        rough = None if bare.rough is None else transform(bare.rough, turned)
        bare = replace(bare, shape=transform(bare.shape, turned), rough=rough)
    return Stock(section, frame, *extent(shell, frame.x), bare=bare)


def _told(outer: Chain, inner: tuple[Chain, ...], piece: Any) -> Section | None:
    """The section of an outline; of a mesh's rough roundings by the corners of `piece` alone.

    Some roundings of a mesh may lie on circles, and others not.
    """
    section = classify(outer, inner)
    if section is not None and section.code != "SO":
        return section
    drawn = tuple(
        sharpened(chain_of_ring(r, Circles())) for r in (piece.exterior, *piece.interiors)
    )
    again = classify(drawn[0], drawn[1:]) if drawn[0] else None
    return section if again is None else replace(again, area=float(piece.area))


def _end_section(shell: Shell, axis: Vec, side: int, u: Vec, v: Vec, widest: float) -> Best | None:
    """The section of a mesh whose facets run slantwise from a mitred end to the other one.

    No two of its stations are alike, and no corner of theirs lies on a rounding. Those of an end
    do, if it is one plane; along the axis the end is the section.
    """
    end = np.isin(shell.face, end_faces(shell, axis, side))
    flat = np.column_stack((coordinates(shell.points, u), coordinates(shell.points, v)))
    before = flat[shell.before]
    pieces = pieces_of(region_within(np.stack((before[end], flat[end]), axis=1)))
    if len(pieces) != 1 or pieces[0].area < WHOLE_END * widest:
        return None
    rings = (pieces[0].exterior, *pieces[0].interiors)
    drawn = [chain_of_ring(ring, Circles()) for ring in rings]
    whole = map(with_arcs, drawn)
    outer, *inner = (w if len(w) == 1 else sharpened(c) for w, c in zip(whole, drawn, strict=True))
    section = classify(outer, inner) if outer else None
    if section is None or section.code == "SO":
        return None
    most, bands = 0.0, []
    chords = np.array([(c.start, c.end) for chain in drawn for c in chain])
    for arc in (c for chain in (outer, *inner) for c in chain if isinstance(c, Arc)):
        off = np.abs(np.hypot(*(chords - arc.centre).transpose(2, 0, 1)) - arc.radius).max(axis=1)
        longest = np.hypot(*(chords[:, 1] - chords[:, 0])[off < ON_ARC].T).max(initial=0.0)
        half = SLANTED * asin(min(1.0, longest / (2 * arc.radius)))
        rise = min(arc.radius, arc.radius * (1.0 - cos(half)) + ON_ARC)
        most = max(most, rise)
        count = ceil(abs(arc.sweep_deg))
        points = np.array([arc.point(k / count) for k in range(count + 1)]) - arc.centre
        outside, inside = (
            points * by + arc.centre for by in (1 + ON_ARC / arc.radius, 1 - rise / arc.radius)
        )
        bands += [Polygon([*outside[k : k + 2], *inside[k : k + 2][::-1]]) for k in range(count)]
    shape = polygon_of(outer, tuple(inner), Circles())
    section = replace(section, area=float(shape.area))
    return section, BareStock(shape, section.area, union_all(bands), most)


def round_axis(shell: Shell, along: Vec) -> Vec | None:
    """The line from the middle of one end of a mesh to that of the other; None without plane ends.

    Of a round bar or tube that is mitred twice no edge shows the axis: facets run slantwise.
    """
    if len(shell.points) != 3 * shell.count:
        return None
    middles = shell.points.reshape(-1, 3, 3).mean(axis=1)
    ends = [end_faces(shell, along, side) for side in (-1, 1)]
    if not all(map(len, ends)):
        return None
    start, end = (vec(np.average(middles[e], axis=0, weights=shell.areas[e])) for e in ends)
    return unit(sub(end, start))


def end_faces(shell: Shell, axis: Vec, side: int) -> Places:
    """The faces that lie in the plane which most of an end's area lies in."""
    low, high = extent(shell, axis)
    areas, faces = shell.areas, shell.face
    middles = np.bincount(faces, coordinates(shell.points, axis)) / np.bincount(faces)
    there = (middles - (low + high) / 2) * side > 0
    there &= np.abs(coordinates(shell.area_normals, axis)) >= MIN_LEAN * areas
    found = np.flatnonzero(there)
    ways = shell.area_normals[found] * (1 / areas[found])[:, None]
    way = heaviest(ways, areas[found], NEARLY_PLANE, len(found))
    return found if way is None else found[np.abs(coordinates(ways, way)) > NEARLY_PLANE]


def _flat(piece: Any) -> Section | None:
    """The flat bar that a section has been before its long edges were bevelled; None if none."""
    x0, y0, x1, y1 = piece.bounds
    b, h = x1 - x0, y1 - y0
    if piece.interiors or float(piece.convex_hull.area - piece.area) > CONVEX * float(piece.area):
        return None
    if float(piece.area) < FLAT * b * h or max(b, h) < FLATTER * min(b, h):
        return None
    return classify(points_chain([(x0, y0), (x1, y0), (x1, y1), (x0, y1)]))


def reference(shell: Shell, axis: Vec) -> Vec:
    """A direction square to the axis in which sections lie straight."""
    areas = shell.areas
    upright = np.flatnonzero(np.abs(coordinates(shell.area_normals, axis)) < 1e-3 * areas)
    if not len(upright):
        return across(axis)
    broadest = upright[areas[upright].argmax()]
    return unit(cross(axis, unit(vec(shell.area_normals[broadest]))))
