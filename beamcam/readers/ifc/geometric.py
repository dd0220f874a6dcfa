"""The geometric route: a shell of faces, from a Brep, a mesh or the kernel, read as a member.

1. The axis is the direction that most edge length runs along; a plate's is its longer side.
2. Sections across the axis are taken along it; the fullest that is a rolled form is the stock.
3. Each wall of the stock is cut through at two levels; what is there is the wall's outline, and
   its hollows are holes. A polygon whose vertices lie on a circle is that circle.
"""

from collections.abc import Iterator, Sequence
from typing import Any

import numpy as np
from msgspec.structs import replace
from shapely import LineString, MultiPolygon, Polygon, get_coordinates

from beamcam.errors import Diagnostic, Source, errors_in
from beamcam.model.part import Hole, Slot
from beamcam.readers.ifc import kernel, rules
from beamcam.readers.ifc.checks import section_diagnostics
from beamcam.readers.ifc.cutters import HalfSpace, planes_of, reaches
from beamcam.readers.ifc.entities import Entity, Model, Unreadable
from beamcam.readers.ifc.finish import Regions, Shaped, from_regions, opening, sawn
from beamcam.readers.ifc.outline import with_arcs
from beamcam.readers.ifc.profiles import Outline
from beamcam.readers.ifc.region import (
    FAR,
    Circles,
    Shape,
    chain_of_ring,
    chains_of,
    circles_in,
    cleaned,
    pieces_of,
    with_circles,
)
from beamcam.readers.ifc.same_solid import Fineness, differences
from beamcam.readers.ifc.section import (
    BareStock,
    Section,
    Wall,
    corner_points,
    plain_stock,
    walls_of,
)
from beamcam.readers.ifc.semantic import BETWEEN, cut, outer_level
from beamcam.readers.ifc.shell import (
    ALONG,
    Shell,
    broadest_normal,
    extent,
    kinked,
    longest_direction,
    section,
)
from beamcam.readers.ifc.solid_body import section_area
from beamcam.readers.ifc.space import Frame, across, cross, dot, scale, unit
from beamcam.readers.ifc.stock import Stock, plate_stock, reference, rolled_stock, round_axis

PRISMATIC = 0.01  #: share by which a plate's volume may differ from outline times thickness
SAME_HOLE = 2  #: decimals of a mm in which a hole lies alike at both levels
LEVEL_IN = 0.1  #: share of a wall's thickness: nearer to its surface edges may be round
STEEPEST = 4.0  #: mm along a level of a wall for each mm that facets lie off its round edge
STRAIGHT = 1e-3  #: mm that a corner of a region may lie off the line between its neighbours
EDGE = 0.3  #: mm within which a section point lies on a wall's long edge
EXPLAINED = 0.3  #: share of its volume by which a shell that differs more is no such member
SURELY_OTHER = 0.35  #: likewise by the volume that the regions of the walls give
BEYOND = 2.0  #: mm out of the box of its section at which steel is another part's, or bent
#: Of the kernel's solid.
MESH = Fineness(slack=0.13, facet_rad=kernel.ANGLE, chord=kernel.CHORD * 1e3)
FACES = Fineness(slack=0.04, facet_rad=0.6)  #: of a file


def read_kernel(model: Model, element: Entity, source: Source) -> Shaped:
    """The member of the kernel's solid. Raises Unreadable, also for errors in the kernel's log.

    The facets give the sections, the kernel's own surfaces the circles in them; where the kernel
    has others, they are fitted to the facets, and `fitted` of what comes back names them.
    """
    solid = kernel.built(model, element, {})
    if solid.error is not None:
        raise Unreadable(f"an error of the geometry kernel ({solid.error})")
    return replace(read_shell(solid.shell, source, solid.volume), fitted=solid.others)


def read_shell(shell: Shell, source: Source, volume: float | None = None) -> Shaped:
    """The member of a shell, checked against it. Raises Unreadable, which says what was found.

    `volume` is that of the solid in mm3 where the shell only stands for it.
    """
    shapes, faults = list[Shaped](), list[Unreadable]()
    for stock in _stocks(shell):
        try:
            shape = _member(shell, stock, source)
            shape = replace(shape, diagnostics=_unexplained(shape, shell, source, volume))
        except Unreadable as reason:
            faults.append(reason)
            continue
        if not shape.diagnostics:
            return shape
        shapes.append(shape)
    if shapes:  # the likeliest of those that are not denied
        return min(shapes, key=lambda one: bool(errors_in(one.diagnostics)))
    if (kink := kinked(shell)) is not None:
        raise Unreadable(f"a member kinked by {kink:.1f} degrees", rules.KINKED, final=True)
    if faults:
        raise faults[0]
    raise Unreadable(f"a shell of {shell.count} faces without a constant section", rules.SECTION)


def _stocks(shell: Shell) -> Iterator[Stock]:
    """What a shell may have been cut from, the likeliest first."""
    if (plate := _plate(shell)) is not None:
        yield plate
    along, normal = longest_direction(shell), broadest_normal(shell)
    if abs(dot(normal, along)) > 0.05:
        normal = across(along)
    # Others square to it are of members shorter than their section is wide.
    for axis in (along, unit(cross(along, normal)), normal, round_axis(shell, along)):
        stock = rolled_stock(shell, axis) if axis is not None else None
        if stock is None:
            continue
        section, length = stock.section, stock.x1 - stock.x0
        # A flat bar shorter than it is thick has its thickness along another side; a special
        # section wider than the bar is long is that of a bent one.
        least = {"B": section.width, "SO": max(section.height, section.width)}
        if length >= least.get(section.code, 0.0):
            yield stock


def _unexplained(
    shape: Shaped, shell: Shell, source: Source, volume: float | None
) -> tuple[Diagnostic, ...]:
    """What of a shell its member does not explain. Raises Unreadable where that is most of it."""
    body = shell.moved(shape.frame.inverse())
    theirs = volume or body.volume or section_area(body)
    if abs(theirs - shape.volume) > SURELY_OTHER * theirs:  # building the part again takes long
        raise _not_explained(theirs, shape.volume)
    if (beyond := _beyond(body, shape.section)) is not None:
        if kinked(shell) is not None:
            raise Unreadable("a kinked member", rules.SECTION)
        return (rules.UNEXPLAINED.at(source, found=beyond),)
    stock = shape.stock or plain_stock(shape.section)
    by = MESH if volume is not None else FACES
    apart = differences(shape, body, stock, by, volume)
    if abs(apart.volume - apart.expected) > EXPLAINED * theirs:
        raise _not_explained(theirs, apart.expected)
    return (*apart.diagnostics(source), *section_diagnostics(shape, stock, source))


def _beyond(body: Shell, section: Section) -> str | None:
    """What of a body, in the part's place, reaches out of its section's box; None if nothing."""
    x, y, z = body.points.T
    far = np.maximum.reduce((-y, -z, y - section.height, z - section.width))
    if not len(out := x[far > BEYOND]):
        return None
    place = f"at x {out.min():.1f} to {out.max():.1f}"
    return f"more steel, up to {far.max():.1f} mm beyond the section {place},"


def _not_explained(theirs: float, explained: float) -> Unreadable:
    what, by = f"a shell of {theirs / 1e3:.1f} cm3", f"{explained / 1e3:.1f} cm3"
    return Unreadable(f"{what} whose section and cuts explain {by}", rules.SECTION)


def _member(shell: Shell, stock: Stock, source: Source) -> Shaped:
    """What a shell shows of a stock, in the stock's own frame."""
    if stock.bare is None:  # a plate, which its outline says all of
        return cut(stock, (), source)
    local = shell.moved(stock.frame.inverse())
    walls, flat = walls_of(stock.section), stock.section.is_plain_flat
    if not walls:  # a round or a special section: two plane ends, nothing else
        start, end = [_flat_end(local, stock.section, side) for side in (-1, 1)]
        corners = corner_points(stock.section)
        span = -max(reaches(start, corners)), max(reaches(end, corners))
        return sawn(stock, (start, end), span, (), source)
    circles = Circles()
    regions: Regions = {}
    holes: list[Hole | Slot] = []
    for wall in walls:
        shares: tuple[float, ...] = (LEVEL_IN, 1 - LEVEL_IN)
        if flat:  # its edges may lean, also from both sides to its middle
            edge = outer_level(wall)
            shares = (edge, *BETWEEN, 1 - edge)
        cs = [wall.low + share * wall.thickness for share in shares]
        exact = local.circles(wall)
        drilled, raw = _drilled([local.raw_slice(wall, c) for c in cs], wall, exact, source)
        holes += drilled
        levels: list[tuple[float, Shape]] = []
        for c, shape in zip(cs, raw, strict=True):
            shape = cleaned(with_circles(shape, circles, exact))
            levels.append((c, shape if flat else _full_width(shape, wall, c, stock.bare)))
        regions[wall] = tuple(levels)
    # The levels lie inside the walls; only the shell itself knows how far the tips reach.
    span, planes = (stock.x0, stock.x1), planes_of(local)
    return from_regions(stock, regions, holes, circles, source, planes, span)


def _drilled(
    levels: Sequence[Shape], wall: Wall, exact: Circles, source: Source
) -> tuple[list[Hole | Slot], list[Shape]]:
    """The round and slotted hollows that both levels of a wall show; the levels without them.

    With their arcs in it a region takes twice as long to cut.
    """

    def place(ring: Any) -> tuple[float, ...]:
        return tuple(round(value, SAME_HOLE) for value in ring.bounds)

    pieces = [pieces_of(shape) for shape in levels]
    rings = [{place(r): r for piece in row for r in piece.interiors} for row in pieces]
    holes: dict[tuple[float, ...], Hole | Slot] = {}
    for at, ring in rings[0].items():
        chain = with_arcs(chain_of_ring(ring, exact)) if at in rings[-1] else ()
        made = opening(wall, chain, source) if chain else None
        if isinstance(made, (Hole, Slot)):
            holes[at] = made
    kept = [
        [Polygon(p.exterior, [r for r in p.interiors if place(r) not in holes]) for p in row]
        for row in pieces
    ]
    return [*holes.values()], [MultiPolygon(row) for row in kept]


def _full_width(shape: Shape, wall: Wall, c: float, stock: BareStock) -> Shape:
    """A wall's region with its long edges at its full width, which rounded corners take off.

    A level a little inside a tube's wall, or near the toe of an angle, is narrower than the wall.
    """
    lines = LineString([wall.point(0.0, q, c)[1:] for q in (-FAR, FAR)])
    crossed = [wall.split((0.0, *p))[0] for p in get_coordinates(stock.shape.intersection(lines))]
    if len(crossed) < 2:
        return shape
    low, high, near = min(crossed), max(crossed), EDGE + STEEPEST * stock.rise
    shapes: list[Any] = []
    for piece in pieces_of(shape):
        x, q = get_coordinates(piece.exterior.simplify(STRAIGHT))[:-1].T
        to = np.select([abs(q - low) < near, abs(q - high) < near], [0.0, wall.width], q)
        moved, done = x.copy(), to == q
        for way in (-1, 1):
            # It moves along the end or the cut that comes to the long edge there.
            run, rise = x - np.roll(x, way), q - np.roll(q, way)
            leads = ~done & (to != np.roll(to, way)) & (abs(rise) > EDGE)
            moved[leads] += (run / np.where(leads, rise, 1.0) * (to - q))[leads]
            done |= leads
        made = Polygon(np.column_stack((moved, to)), piece.interiors)
        shapes += pieces_of(made if made.is_valid else made.buffer(0))
    return MultiPolygon(shapes)


def _plate(shell: Shell) -> Stock | None:
    """The plate that a shell is, if it is one."""
    normal = broadest_normal(shell)
    low, high = extent(shell, normal)
    thickness = high - low
    u = reference(shell, normal)
    v = cross(normal, u)
    spans = [extent(shell, d) for d in (u, v)]
    if thickness <= 0 or thickness > min(b - a for a, b in spans) * 0.999:
        return None
    shape, *others = (
        section(shell, scale(normal, low + share * thickness), normal, u, v)
        for share in (0.5, LEVEL_IN, 1 - LEVEL_IN)
    )
    area, volume = float(shape.area), shell.volume
    if len(pieces_of(shape)) != 1:
        return None
    if volume is not None and abs(area * thickness - volume) > PRISMATIC * volume:
        return None
    off = (float(shape.symmetric_difference(other).area) for other in others)
    if any(one > PRISMATIC * area for one in off):
        return None
    outline = Outline(*chains_of(pieces_of(shape)[0], circles_in(shell.cylinders, normal, u, v)))
    lies = Frame(scale(normal, low), u, v, normal)
    return plate_stock(outline, lies, scale(normal, thickness))


def _flat_end(local: Shell, section: Section, side: int) -> HalfSpace:
    """The plane that most of an end's area lies in."""
    low, high = extent(local, ALONG)
    for plane in planes_of(local):
        if side * (plane.x(section.height / 2, section.width / 2) - (low + high) / 2) > 0:
            return plane.facing(side)
    raise Unreadable("a round section without plane ends", rules.SECTION)
