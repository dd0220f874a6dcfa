"""The geometric route: a shell of faces, from a Brep, a mesh or the kernel, read as a member.

1. The axis is the direction that most edge length runs along; a plate's is its longer side.
2. Sections across the axis are taken along it; the fullest that is a rolled form is the stock.
3. Each wall of the stock is cut through at two levels; what is there is the wall's outline, and
   its hollows are holes. A polygon whose vertices lie on a circle is that circle.
"""

from collections.abc import Sequence
from typing import Any

import numpy as np
from msgspec.structs import replace

from beamcam.errors import Source
from beamcam.geometry.curves import Point
from beamcam.model.part import Contour, Hole, Slot
from beamcam.readers.ifc.cutters import Cutter
from beamcam.readers.ifc.ends import LEAST_LEAN, End
from beamcam.readers.ifc.entities import Entity, Model, Unreadable
from beamcam.readers.ifc.exact import Circle, circles_in
from beamcam.readers.ifc.features import opening, shifted
from beamcam.readers.ifc.finish import Regions, Shaped, cuts_of, end_planes, from_regions, reach
from beamcam.readers.ifc.kernel import build_both
from beamcam.readers.ifc.plates import box_of, into
from beamcam.readers.ifc.region import (
    Circles,
    Shape,
    cleaned,
    pieces_of,
)
from beamcam.readers.ifc.rolled import Rolled, other_axes, reference, rolled_stock
from beamcam.readers.ifc.section import Section
from beamcam.readers.ifc.semantic import LEVEL_IN, cut, in_place
from beamcam.readers.ifc.shell import (
    Shell,
    broadest_normal,
    extent,
    longest_direction,
    section,
    vec,
)
from beamcam.readers.ifc.slices import arcs_of, ring_arcs, with_circles
from beamcam.readers.ifc.space import Frame, add, cross, dot, scale
from beamcam.readers.ifc.stock import Stock
from beamcam.readers.ifc.walls import Wall, walls_of

PRISMATIC = 0.01  #: share by which a plate's volume may differ from outline times thickness
ALIKE = 6  #: decimals of a mm, from which on two rings of a hole are one
SAME_HOLE = 0.02  #: mm between a hole at one level and at the other
EDGE = 0.3  #: mm within which a section point lies on a wall's long edge
EXPLAINED = 0.03  #: share by which the volume may differ from what the walls explain


def read_kernel(model: Model, element: Entity, source: Source) -> Shaped:
    """The member of the kernel's solid. Raises Unreadable, also for errors in the kernel's log.

    The facets give the sections, the kernel's own surfaces the circles in them; where the kernel
    has others, they are fitted to the facets, and `fitted` of what comes back names them.
    """
    built, exact = build_both(model, element)
    errors = [line for line in (*built.log, *exact.log) if "[error]" in line.lower()]
    if errors:
        raise Unreadable(f"an error of the geometry kernel ({errors[0][:160]})")
    shell = replace(built.shell, cylinders=exact.cylinders)
    return replace(read_shell(shell, (), source), fitted=exact.others)


def read_shell(shell: Shell, cutters: Sequence[Cutter], source: Source) -> Shaped:
    """The member of a shell. Raises Unreadable, which says what was found."""
    found = _plate(shell, cutters, source)
    if found is not None:
        return found
    along = longest_direction(shell)
    tried = []
    for axis in (along, *other_axes(shell, along)):
        stock = rolled_stock(shell, axis)
        if stock is None:
            tried.append(axis)
            continue
        return in_place(_member(shell, cutters, stock, source), stock.frame)
    raise Unreadable(f"a shell of {shell.count} faces without a constant section")


def _member(shell: Shell, cutters: Sequence[Cutter], stock: Rolled, source: Source) -> Shaped:
    inverse = stock.frame.inverse()
    local = shell.moved(inverse)
    taken = [c.moved(inverse) for c in cutters]
    walls = walls_of(stock.section)
    if not walls:
        if taken:
            raise Unreadable("cuts in a faceted round section")
        return _round(local, stock, source)
    circles = Circles()
    regions: Regions = {}
    holes: list[Hole | Slot] = []
    for wall in walls:
        cs = [wall.low + share * wall.thickness for share in (LEVEL_IN, 1 - LEVEL_IN)]
        raw = [local.raw_slice(wall, c) for c in cs]
        if not taken:
            drilled, raw = _drilled(raw, wall, local.circles(wall), source)
            holes += drilled
        levels: list[tuple[float, Shape]] = []
        for c, shape in zip(cs, raw, strict=True):
            shape = with_circles(shape, circles, local.circles(wall))
            for one in taken:
                shape = shape.difference(one.slice(wall, c, circles))
            levels.append((c, _full_width(cleaned(shape), wall, c, stock.outline)))
        regions[wall] = (levels[0], levels[1])
    found = from_regions(stock.section, regions, holes, circles, source, stock.x1 - stock.x0)
    if not taken:
        # The levels lie inside the walls; only the shell itself knows how far the tips reach.
        found = _reached(found, stock, regions)
        _explained(found, local)
    return found


def _drilled(
    levels: Sequence[Shape], wall: Wall, exact: Sequence[Circle], source: Source
) -> tuple[list[Hole | Slot], list[Shape]]:
    """The round and slotted hollows that both levels of a wall show; the levels without them."""
    from shapely import MultiPolygon, Polygon, get_coordinates

    told: dict[bytes, Contour | Hole | Slot | None] = {}  # most are alike at both levels
    seen: list[list[tuple[Hole | Slot, tuple[float, ...]]]] = []
    for shape in levels:
        rows = []
        for piece in pieces_of(shape):
            for ring in piece.interiors:
                key = (get_coordinates(ring).round(ALIKE) + 0.0).tobytes()
                if key not in told:
                    chain = ring_arcs(ring, exact)
                    told[key] = opening(wall, chain, source) if chain else None
                made = told[key]
                if isinstance(made, (Hole, Slot)):
                    rows.append((made, ring.bounds))
        seen.append(rows)
    holes: list[Hole | Slot] = []
    filled: set[tuple[float, ...]] = set()
    for low, ring in seen[0]:
        for high, other in seen[1]:
            apart = max(abs(low.x - high.x), abs(low.y - high.y), abs(low.diameter - high.diameter))
            if type(low) is type(high) and apart < SAME_HOLE:
                holes.append(low)
                filled |= {ring, other}
                break
    kept = []
    for shape in levels:
        pieces = [
            Polygon(p.exterior, [r for r in p.interiors if r.bounds not in filled])
            for p in pieces_of(shape)
        ]
        kept.append(MultiPolygon(pieces))
    return holes, kept


def _full_width(shape: Shape, wall: Wall, c: float, outline: tuple[Point, ...]) -> Shape:
    """A wall's region with its long edges at its full width, which rounded corners take off.

    A level a little inside a tube's wall, or near the toe of an angle, is narrower than the wall.
    """
    from shapely import transform

    at = 0 if wall.normal == "y" else 1
    crossed = []
    for i, p in enumerate(outline):
        a, b = (outline[i - 1], p)
        if (a[at] > c) != (b[at] > c):
            share = (c - a[at]) / (b[at] - a[at])
            crossed.append(a[1 - at] + share * (b[1 - at] - a[1 - at]))
    if len(crossed) < 2:
        return shape
    low, high = min(crossed), max(crossed)

    def widened(points: Any) -> Any:
        points = points.copy()
        q = points[:, 1]
        q[abs(q - low) < EDGE] = 0.0
        q[abs(q - high) < EDGE] = wall.width
        return points

    return transform(shape, widened)


def _reached(found: Shaped, stock: Rolled, regions: Regions) -> Shaped:
    """The member with the length of its shell, its features moved as much."""
    bounds = [p.bounds for pair in regions.values() for _, s in pair for p in pieces_of(s)]
    x0 = min(b[0] for b in bounds)
    shift = x0 - stock.x0
    if abs(shift) < 1e-6:
        return replace(found, length=stock.x1 - stock.x0, x0=stock.x0)
    features = tuple(
        shifted(f, shift) if isinstance(f, (Hole, Slot, Contour)) else f for f in found.features
    )
    return replace(found, length=stock.x1 - stock.x0, features=features, x0=stock.x0)


def _explained(found: Shaped, shell: Shell) -> None:
    """Raise Unreadable if the walls are not all that the shell is."""
    volume = shell.volume
    if not volume:
        return
    off = abs(volume - found.volume) / volume
    if off > EXPLAINED:
        raise Unreadable(
            f"a shell of {volume / 1e3:.1f} cm3 whose section and cuts explain "
            f"{found.volume / 1e3:.1f} cm3"
        )


def _plate(shell: Shell, cutters: Sequence[Cutter], source: Source) -> Shaped | None:
    """The plate that a shell is; None if it is none."""
    normal = broadest_normal(shell)
    low, high = extent(shell, normal)
    thickness = high - low
    u = reference(shell, normal)
    v = cross(normal, u)
    spans = [extent(shell, d) for d in (u, v)]
    if thickness <= 0 or thickness > min(b - a for a, b in spans) * 0.999:
        return None
    shape = section(shell, scale(normal, low + 0.5 * thickness), normal, u, v)
    area = float(shape.area)
    volume = shell.volume
    if len(pieces_of(shape)) != 1:
        return None
    if volume is not None and abs(area * thickness - volume) > PRISMATIC * volume:
        return None
    for share in (LEVEL_IN, 1 - LEVEL_IN):
        other = section(shell, scale(normal, low + share * thickness), normal, u, v)
        if float(shape.symmetric_difference(other).area) > PRISMATIC * area:
            return None
    outer, inner = arcs_of(pieces_of(shape)[0], circles_in(shell.cylinders, normal, u, v))
    box = box_of(outer)
    x = add(scale(u, box.x[0]), scale(v, box.x[1]))
    y = add(scale(u, box.y[0]), scale(v, box.y[1]))
    z = cross(x, y)
    base = low if dot(z, normal) > 0 else -high
    o = add(add(scale(u, box.origin[0]), scale(v, box.origin[1])), scale(z, base))
    width = box.width
    made = Section(
        "B", width, thickness, 0.0, thickness, 0.0, (0.0, 0.0), (0.0, 1.0), (1.0, 0.0),
        True, True, width * thickness,
    )  # fmt: skip
    frame = Frame(o, x, y, z)
    hollows = tuple(into(h, box) for h in inner)
    stock = Stock(made, frame, 0.0, box.length, box.outline, hollows)
    inverse = frame.inverse()
    return in_place(cut(stock, [c.moved(inverse) for c in cutters], source), frame)


def _round(local: Shell, stock: Rolled, source: Source) -> Shaped:
    """A round bar or pipe by its shell: two plane ends, nothing else."""
    ends = [_flat_end(local, side) for side in (-1, 1)]
    start, end = ends
    x0, x1 = reach(stock.section, start, end)
    middle = stock.section.height / 2
    length = end.x(middle, middle) - start.x(middle, middle)
    found = Shaped(
        stock.section,
        x1 - x0,
        cuts_of(start, end),
        end_planes(start, end, x0, source),
        stock.section.area * length,
        x1 - x0,
        (),
        x0,
    )
    _explained(found, local)
    return found


def _flat_end(local: Shell, side: int) -> End:
    """The plane that most of an end's area lies in."""
    low, high = extent(local, (1.0, 0.0, 0.0))
    areas, rings = local.areas, local.rings
    faces = rings.face_of_corner
    middles = np.bincount(faces, local.points[:, 0]) / np.bincount(faces)
    there = (middles - (low + high) / 2) * side > 0
    there &= np.abs(local.area_normals[:, 0]) >= LEAST_LEAN * areas
    if not there.any():
        raise Unreadable("a round section without plane ends")
    broadest = int(np.where(there, areas, 0.0).argmax())
    p, n = vec(local.firsts[broadest]), vec(local.area_normals[broadest])
    a, b = -n[1] / n[0], -n[2] / n[0]
    return End(side, a, b, p[0] - a * p[1] - b * p[2])
