"""Stock of a member and its placement: a section between two ends, or a plate.

Of a swept profile its definition says it; of a shell it is the section that is constant along an
axis.
"""

from math import asin, atan2, ceil, cos, hypot
from typing import Any

import numpy as np
from msgspec import Struct
from msgspec.structs import replace
from shapely import Polygon, transform, union_all

from beamcam.geometry.array_types import Counts, Floats
from beamcam.geometry.curves import Arc, Line, Point
from beamcam.geometry.plane import Box
from beamcam.readers.ifc.body import Swept
from beamcam.readers.ifc.cutters import MIN_LEAN
from beamcam.readers.ifc.entities import Entity, Model, Unreadable
from beamcam.readers.ifc.outline import Chain, box_around, sharpened, with_arcs
from beamcam.readers.ifc.profiles import Outline, moved, outline_of, points_chain, section_of
from beamcam.readers.ifc.region import (
    Circles,
    chain_of_ring,
    chains_of,
    circles_in,
    pieces_of,
    polygon_of,
    region_within,
)
from beamcam.readers.ifc.section import BareStock, Section, classify, plain_stock
from beamcam.readers.ifc.shell import Shell, coordinates, extent, heaviest, segments, vec
from beamcam.readers.ifc.space import Frame, Vec, across, add, cross, dot, scale, size, sub, unit

_FLAT = frozenset(("IfcRectangleProfileDef", "IfcCircleProfileDef", "IfcTrapeziumProfileDef"))
THIN = 0.3  #: of the lesser side, below which an outline of a rolled form is a plate all the same
TIGHTER = 0.98  #: of the area of the box as drawn, for another box to be taken


class Stock(Struct, frozen=True, gc=False):
    """Stock of a member in its own frame: a section between two x."""

    section: Section
    frame: Frame  #: the member's coordinates in the element's
    x0: float
    x1: float
    outline: Chain = ()  #: of a plate, in (x, y); none of a full rectangle
    hollows: tuple[Chain, ...] = ()
    bare: BareStock | None = None  #: the section, where the faces of a shell show it


def stock_of(model: Model, element: Entity, base: Swept) -> Stock:
    """The stock and the frame of the member that a swept profile is."""
    depth = size(base.along)
    plane = unit(cross(base.frame.x, base.frame.y))
    if depth <= 0 or abs(abs(dot(plane, base.along)) - depth) > 1e-6 * depth:
        raise Unreadable("a profile that is extruded at a slant")
    factor = size(base.frame.x)
    if abs(size(base.frame.y) - factor) > 1e-6 * factor:
        raise Unreadable("a profile that is stretched unevenly")
    if (plate := _plate_of(model, element, base, depth / factor)) is not None:
        return plate
    section = section_of(model, base.profile)
    frame = _frame(section, base.frame)
    if dot(frame.x, base.along) < 0:
        section = section.turned()
        frame = _frame(section, base.frame)
    if abs(factor - 1.0) >= 1e-12:
        section = section.scaled(factor)
    reach_x = dot(frame.x, base.along)
    return Stock(section, frame, min(0.0, reach_x), max(0.0, reach_x))


def _frame(section: Section, at: Frame) -> Frame:
    """The member's axes: Y and Z as the section lies, X square to both."""
    o = at.point((*section.origin, 0.0))
    y = unit(at.vector((*section.y, 0.0)))
    z = unit(at.vector((*section.z, 0.0)))
    return Frame(o, cross(y, z), y, z)


def _plate_of(model: Model, element: Entity, base: Swept, depth: float) -> Stock | None:
    """The plate that a profile pushed by `depth` is; None if it is a bar of that section."""
    kinds = base.profile.type.kinds
    if "IfcParameterizedProfileDef" in kinds and kinds.isdisjoint(_FLAT):
        return None  # a rolled form
    try:
        outline = outline_of(model, base.profile)
    except Unreadable:
        return None
    if 2 * depth > sum(c.length for c in outline.outer):
        return None  # a closed curve is at least twice as long as what it spans: a bar
    x0, y0, x1, y1 = box_around(outline.outer)
    if depth > hypot(x1 - x0, y1 - y0):
        return None  # longer than any side: a bar
    plate = plate_stock(outline, base.frame, base.along)
    section = classify(outline.outer, outline.inner)
    if section is None:
        return plate
    by = 1 / size(base.frame.x)
    length, width = plate.x1 * by, plate.section.height * by
    if base.profile.is_a("IfcCircleHollowProfileDef"):
        is_bar = depth >= base.profile.WallThickness * model.mm
    elif section.code in ("M", "RO"):
        is_bar = True
    elif section.code == "B" or (section.code == "SO" and element.is_a("IfcPlate")):
        is_bar = depth >= min(length, width) * (1 - 1e-9)
    else:
        is_bar = depth > THIN * min(length, width)
    if is_bar:
        return None
    sides = section.code == "B" and len(plate.outline) == 4
    full = sides and abs(section.area - length * width) < 0.01
    return replace(plate, outline=()) if full else plate


def plate_stock(outline: Outline, at: Frame, along: Vec) -> Stock:
    """The stock of an outline in the plane of `at` that is pushed through its thickness off it.

    It lies in its minimum bounding box, x along its longer side; as drawn if that is as small.
    """
    curves = with_arcs(outline.outer)

    def spread(way: Point) -> Box:
        """The box along a direction and square to it."""
        c, s = way
        return box_around(tuple(k.transformed(((c, s, 0.0), (-s, c, 0.0))) for k in curves))

    def size_of(way: Point) -> float:
        x0, y0, x1, y1 = spread(way)
        return (x1 - x0) * (y1 - y0)

    ways = {0.0: (1.0, 0.0)}
    for curve in curves:
        if isinstance(curve, Line) and curve.length > 1.0:
            x, y = curve.tangent(0.0)
            while x <= 0.0 or y < 0.0:  # sides that are square to one another have one box
                x, y = y, -x
            ways.setdefault(round(atan2(y, x), 6), (x, y))
    best = min(ways.values(), key=size_of)
    if size_of(best) >= TIGHTER * size_of(ways[0.0]):
        best = ways[0.0]
    x0, y0, x1, y1 = spread(best)
    if y1 - y0 > x1 - x0:
        best = -best[1], best[0]
        x0, y0, x1, y1 = spread(best)
    c, s = best
    drawn = Frame((x0 * c - y0 * s, x0 * s + y0 * c, 0.0), (c, s, 0.0), (-s, c, 0.0))
    lies, thickness, by = at.times(drawn), size(along), size(at.x)
    o, right, up = lies.o, unit(lies.x), unit(lies.y)
    z = cross(right, up)
    if dot(z, along) < 0:
        o = add(o, along)
    width = (y1 - y0) * by
    sizes, area = (width, thickness, 0.0, thickness, 0.0), width * thickness
    section = Section("B", *sizes, (0.0, 0.0), (0.0, 1.0), (1.0, 0.0), area)
    scaled = Frame(x=(by, 0.0, 0.0), y=(0.0, by, 0.0))
    outer, *inner = (
        moved(moved(chain, drawn.inverse()), scaled) for chain in (curves, *outline.inner)
    )
    frame = Frame(o, right, up, z)
    return Stock(section, frame, 0.0, (x1 - x0) * by, outer, tuple(inner))


# --- of shells ------------------------------------------------------------------------------------

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


def rolled_stock(shell: Shell, axis: Vec) -> Stock | None:
    """The stock of a shell along an axis; None if no station shows a rolled form."""
    u = reference(shell, axis)
    v = cross(axis, u)
    low, high = extent(shell, axis)
    best: Best | None = None
    special: Best | None = None
    seen: list[Floats] = []
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
        section = _own_section(outer, inner, pieces[0]) if outer else None
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


def _own_section(outer: Chain, inner: tuple[Chain, ...], piece: Any) -> Section | None:
    """The section of an outline; of a mesh's rough roundings by the corners of `piece` alone.

    Some roundings of a mesh may lie on circles, and others not.
    """
    section = classify(outer, inner)
    if section is not None and section.code != "SO":
        return section
    rings = piece.exterior, *piece.interiors
    drawn = [sharpened(chain_of_ring(ring, Circles())) for ring in rings]
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
    rings = pieces[0].exterior, *pieces[0].interiors
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


def end_faces(shell: Shell, axis: Vec, side: int) -> Counts:
    """The faces that lie in the plane which most of an end's area lies in."""
    low, high = extent(shell, axis)
    areas, faces = shell.areas, shell.face
    middles = np.bincount(faces, coordinates(shell.points, axis)) / np.bincount(faces)
    there = (middles - (low + high) / 2) * side > 0
    there &= np.abs(coordinates(shell.area_normals, axis)) >= MIN_LEAN * areas
    faces = np.flatnonzero(there)
    ways = shell.area_normals[faces] * (1 / areas[faces])[:, None]
    way = heaviest(ways, areas[faces], NEARLY_PLANE, len(faces))
    return faces if way is None else faces[np.abs(coordinates(ways, way)) > NEARLY_PLANE]


def _flat(piece: Any) -> Section | None:
    """The flat bar that a section has been before its long edges were bevelled; None if none."""
    x0, y0, x1, y1 = piece.bounds
    b, h, area = x1 - x0, y1 - y0, float(piece.area)
    hollow = piece.interiors or float(piece.convex_hull.area) - area > CONVEX * area
    if hollow or area < FLAT * b * h or max(b, h) < FLATTER * min(b, h):
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
