"""What each feature of a part takes of the wall of its face.

A hole goes through the wall of its face, and through a root fillet in its way, but not through
other walls; what is cut of a web takes the fillets on it, and so does what is cut of a flange
along the web.
"""

from collections.abc import Iterator
from itertools import pairwise
from math import atan2, cos, hypot, radians, sin, tan
from typing import TYPE_CHECKING

from shapely import LineString, MultiPoint, Polygon, box, make_valid, union_all
from shapely import Point as Place

from beamcam.geometry.curves import Line, Point, signed_area
from beamcam.geometry.polylines import polylines
from beamcam.model.part import Bevel, Contour, Feature, Hole, Part, Slot
from beamcam.solid.kernel import (
    CHORD,
    FLAT_DEG,
    FREE,
    Frame,
    Wall,
    behind,
    circle,
    drill_profile,
    moved,
    prism,
    turned,
)
from beamcam.solid.stock_solid import (
    Margins,
    Shape,
    end_planes,
    has_outline,
    is_cut,
    shape_of,
    stock_solid,
)

if TYPE_CHECKING:
    from manifold3d import Manifold

FAR = 1e5  #: mm
SMOOTH = 0.015  #: sine between curves that go on in one another
FACET_DEG = 20.0  #: that straight edges turn by at most where they stand for a curve
OUTLINE_NOISE = 1.0  #: mm between a header's figures and an outline; real files differ by 0.7
#: Pitch of ISO metric coarse threads by their diameter (ISO 261).
COARSE_PITCH = {
    1.6: 0.35, 2.0: 0.4, 2.5: 0.45, 3.0: 0.5, 4.0: 0.7, 5.0: 0.8, 6.0: 1.0, 7.0: 1.0, 8.0: 1.25,
    10.0: 1.5, 12.0: 1.75, 14.0: 2.0, 16.0: 2.0, 18.0: 2.5, 20.0: 2.5, 22.0: 2.5, 24.0: 3.0,
    27.0: 3.0, 30.0: 3.5, 33.0: 3.5, 36.0: 4.0, 39.0: 4.0, 42.0: 4.5, 45.0: 4.5, 48.0: 5.0,
    52.0: 5.0, 56.0: 5.5, 60.0: 5.5, 64.0: 6.0,
}  # fmt: skip


def slot_shape(slot: Slot, larger: float = 0.0) -> Shape:
    """A slot or a rectangle with round corners, in (x, q) of its face."""
    radius = slot.diameter / 2 + larger
    return MultiPoint([p for at in slot_corners(slot) for p in circle(*at, radius)]).convex_hull


def slot_corners(slot: Slot) -> list[Point]:
    """The centres of the circles at its corners."""
    c, s = cos(radians(slot.angle)), sin(radians(slot.angle))
    return [
        (slot.x + a * c - b * s, slot.y + a * s + b * c)
        for a in (-slot.length / 2, slot.length / 2)
        for b in (-slot.height / 2, slot.height / 2)
    ]


def taken(feature: Feature) -> Shape:
    """What a hole, a slot or a cut-out takes of its face, in (x, q); nothing of any other."""
    if isinstance(feature, Hole) and feature.kind != "mark":
        return Polygon(circle(feature.x, feature.y, feature.diameter / 2))
    if isinstance(feature, Slot):
        return slot_shape(feature)
    if isinstance(feature, Contour) and feature.kind == "inner" and is_cut(feature):
        return shape_of(feature.curves)
    return Polygon()


def contour_cutters(
    contour: Contour, wall: Wall, part: Part, margins: Margins
) -> Iterator["Manifold"]:
    """What a contour takes of its wall: outside an outer one, inside an inner one; its bevels."""
    yield from _bevels(contour, wall, part, margins)
    if part.profile.code == "B" and has_outline(part):
        return
    shape = shape_of(contour.curves)
    if contour.kind == "outer":
        outlines = [
            c for c in part.contours if c.kind == "outer" and is_cut(c) and c.face == contour.face
        ]
        if contour is not outlines[0]:
            return  # all of a face take the same
        shape = box(-FREE, -FREE, part.length + FREE, wall.width + FREE)
        for one in outlines:
            shape = shape.difference(shape_of(one.curves))
        if part.profile.code != "B":
            shape = _beside_ends(shape, wall, part, margins.noise)
    if margins.outline:
        shape = shape.buffer(margins.outline, join_style="mitre")
    if part.profile.code in ("M", "B") or (wall.normal == "y") == (part.profile.code == "T"):
        yield from through_wall(shape, wall)  # that the others stand on, with their fillets
    else:
        yield prism(shape, 0.0, wall.thickness, wall.frame)
        if part.profile.code != "C":
            yield from through_wall(_along_web(shape, wall), wall)
        elif part.profile.lip is not None:  # all of the lip that stands there
            bend = wall.width - (part.profile.web_thickness or 0.0) - part.profile.radius
            over = shape.intersection(box(-FAR, bend, FAR, FAR))
            yield prism(over, 0.0, part.profile.lip + FREE, wall.frame)


def _along_web(shape: Shape, wall: Wall) -> Shape:
    """What a contour of a flange takes beside its web alone; across the web, what goes of that and
    of its fillets is for the web's contour to say."""
    for low, high in wall.others:
        middle = (low + high) / 2
        over = shape.intersection(LineString([(-FAR, middle), (FAR, middle)]))
        for one in getattr(over, "geoms", [over]):
            if one.length > CHORD:
                shape = shape.difference(box(one.bounds[0], -FAR, one.bounds[2], FAR))
    return shape


def _beside_ends(gone: Shape, wall: Wall, part: Part, noise: float) -> Shape:
    """What an outline leaves out, without what the end planes cut off anyway.

    A skew plane leaves the end of a wall skew through its thickness, and an outline shows either
    surface; exporters round outlines by up to `noise`. A cut that comes to such an end goes
    on as it is drawn and along x there, and the rest of the end is the plane's.
    """
    gone = make_valid(gone)
    ends: list[list[Point]] = []  # of the start and the end, (x, q) at both edges
    skew: list[bool] = []
    leans: list[bool] = []  # through the thickness of the wall
    for (x, _, _), (side, along_y, along_z) in end_planes(part, drawn=True):
        chain = []
        leans.append(False)
        for q in (-FREE, wall.width + FREE):
            xs = []
            for depth in (-wall.before, wall.thickness + wall.behind):
                at = wall.surface + wall.inward * depth
                y, z = (at, q) if wall.normal == "y" else (q, at)
                xs.append(x - side * (along_y * y + along_z * z))
            leans[-1] = leans[-1] or abs(xs[0] - xs[1]) > CHORD
            chain.append(((min(xs) if side > 0 else max(xs)), q))
        ends.append(chain)
        skew.append(bool(along_y or along_z))
    (a, b), (c, d) = ends
    # Planes that are skew enough cross within the wall.
    inner = box(-FAR, 0.0, FAR, wall.width).intersection(make_valid(Polygon([a, c, d, b])))
    if gone.intersection(inner.buffer(-noise)).buffer(-CHORD).is_empty:
        return Polygon()
    for (low, high), way, is_skew, is_leaning in zip(ends, (1.0, -1.0), skew, leans, strict=True):
        if is_skew:
            line = [(x + way * OUTLINE_NOISE, q) for x, q in (low, high)]
            beyond = make_valid(Polygon([*line, (-way * FAR, high[1]), (-way * FAR, low[1])]))
            reached = gone.intersection(LineString([(x + way * CHORD, q) for x, q in line]))
            cuts = [
                make_valid(Polygon([(xa, qa), (xb, qb), (-way * FAR, qb), (-way * FAR, qa)]))
                for one in getattr(reached, "geoms", [reached])
                if one.geom_type == "LineString" and not one.is_empty
                for (xa, qa), (xb, qb) in [(one.coords[0], one.coords[-1])]
            ]
            near = [
                box(-FAR, min(qa, qb) - 2 * OUTLINE_NOISE, FAR, max(qa, qb) + 2 * OUTLINE_NOISE)
                for _, qa, _, qb in (cut.bounds for cut in cuts if not is_leaning)
            ]
            cuts += [gone.intersection(beyond).intersection(one) for one in near]
            gone = union_all([gone.difference(beyond), *cuts])
    return gone


def _beside(shape: Shape, wall: Wall) -> Shape:
    """A shape on a wall where no other wall stands on it."""
    if shape.is_empty:
        return shape
    x0, q0, x1, q1 = shape.bounds
    for low, high in wall.others:
        # Beyond an outermost wall there is air.
        low = q0 - FREE if low <= 0.0 else low
        high = q1 + FREE if high >= wall.width else high
        if low < high:
            shape = shape.difference(box(x0 - FREE, low, x1 + FREE, high))
    return shape


def through_wall(shape: Shape, wall: Wall) -> Iterator["Manifold"]:
    """A cutter through a wall, and through what fillets stand on it."""
    beside = _beside(shape, wall)
    if not beside.equals(shape):
        yield prism(shape, 0.0, wall.thickness, wall.frame)
    yield prism(beside, -wall.before - FREE, wall.thickness + wall.behind + FREE, wall.frame)


def _blind(shape: Shape, wall: Wall, depth: float) -> Iterator["Manifold"]:
    """A cutter into a wall, through the fillet before it."""
    yield prism(shape, 0.0, depth, wall.frame)
    yield prism(_beside(shape, wall), -wall.before - FREE, min(depth, FREE) / 2, wall.frame)


def hole_cutters(
    hole: Hole, wall: Wall, part: Part, margins: Margins, pilot: float
) -> Iterator["Manifold"]:
    diameter = hole.diameter
    if hole.kind in ("thread", "left-thread"):
        diameter -= margins.minor * COARSE_PITCH.get(diameter, diameter / 8)
    radius = diameter / 2 + margins.radius(hole.diameter)
    if radius <= 0.0:
        return
    if hole.kind == "countersink":
        yield from _sink(hole, wall, margins, pilot)
        return
    shape = Polygon(circle(hole.x, hole.y, radius))
    if hole.depth is None:
        yield from through_wall(shape, wall)
        return
    depth = hole.depth + margins.depth
    if hole.kind != "through" and hole.kind != "blind":
        depth = min(max(depth, wall.thickness), depth + margins.run_out)
    yield from _blind(shape, wall, depth)
    if margins.point_deg < FLAT_DEG:
        profile = drill_profile(radius, depth / 2, depth, margins.point_deg)
        body = turned(profile, moved(wall.frame, hole.x, hole.y))
        yield body ^ _within(wall, hole, radius)


def _within(wall: Wall, hole: Hole, radius: float) -> "Manifold":
    """The wall round a hole, beyond which a point does not go."""
    x, y = hole.x, hole.y
    square = box(x - radius - 1, y - radius - 1, x + radius + 1, y + radius + 1)
    return prism(square, -FREE, wall.thickness, wall.frame)


def _sink(hole: Hole, wall: Wall, margins: Margins, pilot: float) -> Iterator["Manifold"]:
    """A counterbore is flat at its depth; a cone is as wide as its diameter at the surface.

    A cone that goes deeper than it would alone has a cylinder above it and meets the hole that it
    sinks at its depth.
    """
    radius = hole.diameter / 2 + margins.radius(hole.diameter)
    depth = (hole.depth or 0.0) + margins.depth + margins.sink
    if hole.angle is None or hole.angle >= FLAT_DEG:
        yield from _blind(Polygon(circle(hole.x, hole.y, radius)), wall, depth)
        return
    slope = tan(radians(hole.angle) / 2)
    alone = (hole.diameter - pilot) / 2 / slope
    shoulder = max(0.0, (hole.depth or 0.0) - alone) if pilot else 0.0
    shoulder = shoulder if shoulder > 0.2 else 0.0  # countersunk to a diameter, rounded to a depth
    # Deeper by a margin, a cone is as much wider at the surface, within its cylinder.
    point = shoulder + margins.sink + radius / slope
    profile = [(radius, -FREE), (radius, shoulder + margins.sink), (0.0, point)]
    if shoulder + margins.sink < 0.0:
        mouth = radius + (shoulder + margins.sink + FREE) * slope
        profile = [(mouth, -FREE), (0.0, point)]
    yield turned(profile, moved(wall.frame, hole.x, hole.y)) ^ _within(wall, hole, radius)


def slot_cutters(slot: Slot, wall: Wall, margins: Margins) -> Iterator["Manifold"]:
    shape = slot_shape(slot, margins.radius(slot.diameter))
    if slot.depth is None:
        yield from through_wall(shape, wall)
    else:
        yield from _blind(shape, wall, slot.depth + margins.depth)


def radial_cutter(hole: Hole, part: Part, margins: Margins) -> "Manifold":
    """A hole square to a round section: its y is the arc from the lowest line, towards v."""
    radius = part.profile.height / 2
    angle = hole.y / radius
    out = (-cos(angle), sin(angle))  # of the axis to the surface, in (Y, Z)
    # u along x, v along the arc, depth inwards from the surface
    frame: Frame = (
        (1.0, 0.0, 0.0, hole.x),
        (0.0, sin(angle), -out[0], radius + radius * out[0]),
        (0.0, cos(angle), -out[1], radius + radius * out[1]),
    )
    depth = 2 * radius + FREE if part.profile.code == "RU" else radius
    if hole.depth is not None:
        depth = hole.depth + margins.depth
    wide = hole.diameter / 2 + margins.radius(hole.diameter)
    return turned([(wide, -FREE), (wide, depth)], frame)


def _bevels(contour: Contour, wall: Wall, part: Part, margins: Margins) -> Iterator["Manifold"]:
    """The wedges of its bevels; of a bar not those that only show its skew end."""
    if not contour.bevels:
        return
    short = None
    if part.profile.code != "B":
        short = stock_solid(part, Margins(section=margins.section))
        for point, normal in end_planes(part, Margins(end=OUTLINE_NOISE / 2), True):
            short = behind(short, point, normal)
    inside = shape_of(contour.curves)
    for bevel in contour.bevels:
        wedge = _bevel(contour, inside, bevel, wall, margins.outline)
        if short is None or (wedge ^ short).volume() > OUTLINE_NOISE:
            yield wedge


def _bevel(contour: Contour, inside: Shape, bevel: Bevel, wall: Wall, margin: float) -> "Manifold":
    """What a bevel takes: a wedge along its edge, from a surface to its land."""
    body = prism(Polygon(), 0.0, 0.0, wall.frame)
    if not bevel.curve < len(contour.curves):
        return body
    # Its land counts from the far side, whichever of them it takes.
    deep = wall.thickness - bevel.land
    if bevel.angle < 0.0:
        deep = bevel.land or wall.thickness
    wide = deep * tan(radians(min(abs(bevel.angle), 89.0)))
    if deep <= 0.0 or wide <= 0.0:
        return body
    near = bevel.angle > 0
    chain = polylines((contour.curves[bevel.curve],), CHORD).points.tolist()
    chain = [a for a, b in pairwise(chain) if a != b] + chain[-1:]
    if len(chain) < 2:
        return body
    (ax, aq), (bx, bq) = chain[:2]
    off = 0.01 / hypot(bx - ax, bq - aq)
    beside = Place((ax + bx) / 2 + (aq - bq) * off, (aq + bq) / 2 + (bx - ax) * off)
    # The steel is outside of a cut-out.
    side = 1.0 if inside.contains(beside) == (contour.kind == "outer") else -1.0
    hollow = []  # how far wedges beside one another inside of the chain go on, to meet
    for (ax, aq), (bx, bq), (cx, cq) in zip(chain, chain[1:], chain[2:], strict=False):
        turn = atan2((bx - ax) * (cq - bq) - (bq - aq) * (cx - bx),
                     (bx - ax) * (cx - bx) + (bq - aq) * (cq - bq))  # fmt: skip
        hollow.append(tan(max(0.0, -turn * side) / 2))
    hollow = hollow or [0.0]
    first, last = _beyond(contour, bevel, (hollow[0], hollow[-1]))
    by = [first, *hollow, last] if len(chain) > 2 else [first, last]
    for k, ((ax, aq), (bx, bq)) in enumerate(pairwise(chain)):
        long = hypot(bx - ax, bq - aq)
        ex, eq = (bx - ax) / long, (bq - aq) / long
        low, high = -wide * by[k], long + wide * by[k + 1]
        nx, nq = -eq * side, ex * side
        rows = [  # (across the edge, depth, along) to (x, q, depth)
            (a * nx + b * nq, c, a * ex + b * eq, d + a * ax + b * aq) for a, b, c, d in wall.frame
        ]
        grown = wide * FREE / deep
        top, foot = (-FREE, deep) if near else (wall.thickness + FREE, wall.thickness - deep)
        wedge = Polygon([(-FREE, top), (wide + grown + margin, top), (margin, foot), (-FREE, foot)])
        body += prism(wedge, low, high, (rows[0], rows[1], rows[2]))
    return body


def _beyond(contour: Contour, bevel: Bevel, hollow: tuple[float, float]) -> Iterator[float]:
    """At the start and the end of a curve how far its bevel goes straight on, by mm that it reaches
    inside: beyond a blunt corner of up to 135 degrees to the next edge, and to the bevel of an edge
    that goes on from it, as far as `hollow` says, or turned by little, as a hollow curve by lines
    is."""
    curves = tuple(c for c in contour.curves if c.length > 0.0)
    which = [k for k, c in enumerate(contour.curves) if c.length > 0.0]
    k = sum(j < bevel.curve for j in which)
    outwards = (signed_area(curves) > 0.0) == (contour.kind == "outer")
    alike = {b.curve for b in contour.bevels if (b.angle, b.land) == (bevel.angle, bevel.land)}
    for a, b, joint in ((k - 1, k, hollow[0]), (k, (k + 1) % len(curves), hollow[1])):
        before, after = curves[a], curves[b]
        (ax, ay), (bx, by) = before.tangent(1.0), after.tangent(0.0)
        turn, same_way = (ax * by - ay * bx) * (1 if outwards else -1), ax * bx + ay * by
        if 0.0 < same_way <= turn:
            yield same_way / turn
        elif same_way < 0.0 or not {which[a], which[b]} <= alike:
            yield 0.0
        elif abs(turn) < SMOOTH:
            yield joint
        else:
            are_facets = isinstance(before, Line) and isinstance(after, Line)
            is_hollow = are_facets and -sin(radians(FACET_DEG)) <= turn < 0.0
            yield tan(atan2(-turn, same_way) / 2) if is_hollow else 0.0
