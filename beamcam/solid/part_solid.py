"""The solid of a part: its section, its end planes, and what its features take.

A hole goes through the wall of its face, and through a root fillet in its way, but not through
other walls; a cope of a web takes the fillets on it. Bends and camber are not there, as files give
the straight, flat part; nor are marks, texts and threads beyond their core.
"""

from collections.abc import Callable, Iterator
from itertools import pairwise
from math import atan2, copysign, cos, degrees, hypot, radians, sin, tan
from typing import TYPE_CHECKING, Any

from msgspec import Struct
from msgspec.structs import replace

from beamcam.geometry.curves import Curve, Line
from beamcam.geometry.polylines import polylines
from beamcam.model.part import Bevel, Contour, EndPlane, Feature, Hole, Part, Slot
from beamcam.solid.kernel import (
    CHORD,
    FLAT_DEG,
    FREE,
    Frame,
    Wall,
    behind,
    circle,
    corners,
    drill_profile,
    minus,
    moved,
    no_solid,
    outline,
    prism,
    turned,
    walls,
)

if TYPE_CHECKING:
    from manifold3d import Manifold

Shape = Any  #: of shapely
OUTLINE_NOISE = 1.0  #: mm between a header's figures and an outline; real files differ by 0.7
AGREE_DEG = 0.2  #: between the outlines of both flanges
LEAST_ANGLE = 0.02  #: degrees; nearer to square is noise of a file
#: Pitch of ISO metric coarse threads by their diameter (ISO 261).
COARSE_PITCH = {
    1.6: 0.35, 2.0: 0.4, 2.5: 0.45, 3.0: 0.5, 4.0: 0.7, 5.0: 0.8, 6.0: 1.0, 7.0: 1.0, 8.0: 1.25,
    10.0: 1.5, 12.0: 1.75, 14.0: 2.0, 16.0: 2.0, 18.0: 2.5, 20.0: 2.5, 22.0: 2.5, 24.0: 3.0,
    27.0: 3.0, 30.0: 3.5, 33.0: 3.5, 36.0: 4.0, 39.0: 4.0, 42.0: 4.5, 45.0: 4.5, 48.0: 5.0,
    52.0: 5.0, 56.0: 5.5, 60.0: 5.5, 64.0: 6.0,
}  # fmt: skip
MINOR = 1.0825  #: pitches between the diameters of a nut's thread (ISO 724)


class Margins(Struct, frozen=True):
    """How much larger each void is than drawn; what is below 0 makes it smaller."""

    radius: Callable[[float], float] = lambda diameter: 0.0  #: of a hole, by its diameter
    depth: float = 0.0  #: of what is not through
    end: float = 0.0  #: off each end, along the part
    outline: float = 0.0  #: into the steel along contours
    point_deg: float = FLAT_DEG  #: blind holes end in such a point, beyond their depth
    minor: float = MINOR  #: pitches that a thread's core is smaller than its diameter
    run_out: float = 0.0  #: of a blind thread's core below the thread
    sink: float = 0.0  #: of a countersink's depth
    square_below: float = LEAST_ANGLE  #: degrees; ends nearer to square are square
    skin: float = 0.0  #: off all surfaces of the stock
    section: Shape | None = None  #: the stock's, in (Y, Z), where a file shows more than measures


AS_DRAWN = Margins()
Void = tuple[Feature, "Manifold"]


def part_solid(part: Part, margins: Margins = AS_DRAWN) -> "Manifold":
    """The solid of a part in DSTV's section axes, in mm: see the room's first lines.

    Raises BeamcamError (`solid-none`) where figures of the section are missing or a feature lies
    where no wall is, and (`solid-kernel`) without manifold3d.
    """
    alone = {replace(f, source=part.source): f for f in part.features}  # what is there twice once
    part = replace(part, features=tuple(alone.values()))
    return minus(stock_solid(part, margins), [body for _, body in voids(part, margins)])


def stock_solid(part: Part, margins: Margins = AS_DRAWN) -> "Manifold":
    """The part before its features, between its two end planes; a plate within its outline."""
    if part.profile.code == "B":
        body = _plate(part, margins)
        if body is not None:
            return body
    over = part.profile.height + part.profile.width + FREE
    section = margins.section if margins.section is not None else outline(part)
    if margins.skin:
        section = section.buffer(-margins.skin, join_style="mitre")
    body = prism(section, -over, part.length + over, ALONG)
    for point, normal in end_planes(part, margins):
        body = behind(body, point, normal)
    return body


#: Takes (Y, Z, depth) of a section to (x, y, z).
ALONG: Frame = ((0.0, 0.0, 1.0, 0.0), (1.0, 0.0, 0.0, 0.0), (0.0, 1.0, 0.0, 0.0))


def end_planes(
    part: Part, margins: Margins = AS_DRAWN, drawn: bool = False
) -> Iterator[tuple[Any, Any]]:
    """A point and the outward normal of each end, with `drawn` as its outlines have it too.

    x = c - y tan(web) - z tan(flange), by DSTV's formula for both ends; the plane touches x = 0 or
    x = length at the outermost corner of the section.
    """
    cuts = part.cuts
    for side, web, flange in (
        (-1, cuts.web_start, cuts.flange_start), (1, cuts.web_end, cuts.flange_end)
    ):  # fmt: skip
        if drawn:
            web = web if abs(web) >= LEAST_ANGLE else _drawn(part, "v", side)[0]
            flange = flange if abs(flange) >= LEAST_ANGLE else _drawn(part, "ou", side)[0]
        web = web if abs(web) >= margins.square_below else 0.0
        flange = flange if abs(flange) >= margins.square_below else 0.0
        rise, lean = -tan(radians(web)), -tan(radians(flange))
        reach = [rise * y + lean * z for y, z in corners(part)] if web or flange else [0.0]
        x = part.length - max(reach) if side > 0 else -min(reach)
        yield (x - side * margins.end, 0.0, 0.0), (side, -side * rise, -side * lean)


def _drawn(part: Part, faces: str, side: int) -> tuple[float, Contour | None]:
    """The angle of an end that the outlines of some faces draw as one straight line from edge to
    edge, and one of them; of two flanges where both agree. A plate's ends are in its outline."""
    outer = [
        c for c in part.contours if c.face in faces and c.kind == "outer" and c.process == "cut"
    ]  # fmt: skip
    found = [_line_across(c, part, side) for c in outer]
    two_flanges = part.profile.code in ("I", "U", "C", "M")
    there = not two_flanges or {c.face for c in outer} == set(faces)
    if part.profile.code == "B" or not found or not there or max(found) - min(found) > AGREE_DEG:
        return 0.0, None
    return found[0], outer[0] if found[0] else None


def _line_across(contour: Contour, part: Part, side: int) -> float:
    """The angle in degrees of the straight line that ends an outline on one side; 0 without one."""
    ys = [y for c in contour.curves for _, y in (c.start, c.end)]
    low, high = min(ys), max(ys)
    for c in contour.curves:
        (xa, ya), (xb, yb) = sorted((c.start, c.end), key=lambda p: p[1])
        across = isinstance(c, Line) and ya - low < 0.5 and high - yb < 0.5
        if across and abs(xb - xa) > 0.5 and (xa + xb > part.length) == (side > 0):
            return degrees(atan2(xa - xb, yb - ya))
    return 0.0


def _drawn_ends(part: Part, margins: Margins) -> Iterator[Void]:
    """What skew ends take that only outlines have, each by one of its outlines."""
    by_header, drawn = end_planes(part, margins), end_planes(part, margins, True)
    for side, header, (point, normal) in zip((-1, 1), by_header, drawn, strict=True):
        if header != (point, normal):
            contour = _drawn(part, "v", side)[1] or _drawn(part, "ou", side)[1]
            body = stock_solid(part, replace(margins, end=-FREE))  # to the air behind a square end
            if contour is not None:
                yield contour, body - behind(body, point, normal)


def voids(part: Part, margins: Margins = AS_DRAWN) -> Iterator[Void]:
    """What each feature takes, in their order."""
    sides = walls(part.profile)
    yield from _drawn_ends(part, margins)
    pilots = {(h.face, h.x, h.y): h.diameter for h in part.holes if h.kind == "through"}
    for feature in part.features:
        if isinstance(feature, EndPlane):
            body = stock_solid(part, replace(margins, end=-FREE))
            (x, y, z), normal = feature.point, feature.normal
            yield (
                feature,
                body - behind(body, (x - copysign(1.0, normal[0]) * margins.end, y, z), normal),
            )
        elif isinstance(feature, Hole | Slot | Contour):
            if isinstance(feature, Hole) and feature.kind == "mark":
                continue
            if isinstance(feature, Contour) and not _is_cut(feature):
                continue
            if isinstance(feature, Hole) and part.profile.code in ("RO", "RU"):
                yield feature, _radial(feature, part, margins)
                continue
            face = _face(feature, part)
            if face not in sides:
                raise no_solid(part, f"a {type(feature).__name__.lower()} on face {feature.face}")
            wall = sides[face]
            if isinstance(feature, Contour):
                bodies = _contour(feature, wall, part, margins)
            elif isinstance(feature, Slot):
                bodies = _slot(feature, wall, margins)
            else:
                pilot = pilots.get((feature.face, feature.x, feature.y), 0.0)
                bodies = _hole(feature, wall, part, margins, pilot)
            yield from ((feature, body) for body in bodies)


def _is_cut(contour: Contour) -> bool:
    return contour.closed and contour.process == "cut" and contour.kind != "open"


def _face(feature: Hole | Slot | Contour, part: Part) -> str:
    """The face whose wall a feature lies in; a plate's contours count from the front."""
    if part.profile.code == "B" and isinstance(feature, Contour):
        return "v"
    return feature.face


def shape_of(curves: tuple[Curve, ...]) -> Shape:
    """The inside of a closed chain of curves, chords within CHORD of it."""
    from shapely import Polygon

    found = polylines(curves, CHORD)
    ring = [
        tuple(point)
        for k in range(len(curves))
        for point in found.points[found.begins[k] : found.begins[k + 1] - 1].tolist()
    ]
    ring.append(curves[-1].end)
    return Polygon(ring).buffer(0) if len(ring) > 2 else Polygon()


def _has_outline(part: Part) -> bool:
    return any(c.kind == "outer" and _is_cut(c) and c.face in ("v", "h") for c in part.contours)


def plate_shape(part: Part, outline_margin: float = 0.0) -> Shape | None:
    """A plate in (x, y) within its outline, less its inner contours; None without an outline.

    The largest contours count first, so that what lies within a cut-out is steel again.
    """
    from shapely import Polygon

    if not _has_outline(part):
        return None
    cut = [c for c in part.contours if _is_cut(c) and c.face in ("v", "h")]
    shapes = sorted(((shape_of(c.curves), c.kind) for c in cut), key=lambda s: -s[0].area)
    whole: Shape = Polygon()
    for shape, kind in shapes:
        whole = whole.union(shape) if kind == "outer" else whole.difference(shape)
    if outline_margin:
        whole = whole.buffer(-outline_margin, join_style="mitre")
    return whole


def _plate(part: Part, margins: Margins) -> "Manifold | None":
    shape = plate_shape(part, margins.outline)
    if shape is None:
        return None
    outline(part)  # for its thickness
    wall = walls(part.profile)["v"]
    body = prism(shape, margins.skin, wall.thickness - margins.skin, wall.frame)
    cut = part.cuts
    if max(abs(cut.flange_start), abs(cut.flange_end)) < 0.2:
        return body
    for point, normal in end_planes(part, margins):
        body = behind(body, point, normal)
    return body


def _contour(contour: Contour, wall: Wall, part: Part, margins: Margins) -> Iterator["Manifold"]:
    """What a contour takes of its wall: outside an outer one, inside an inner one; its bevels."""
    from shapely import box

    yield from _bevels(contour, wall, part, margins)
    if part.profile.code == "B" and _has_outline(part):
        return
    shape = shape_of(contour.curves)
    if contour.kind == "outer":
        outlines = [
            c for c in part.contours
            if c.kind == "outer" and _is_cut(c) and c.face == contour.face
        ]  # fmt: skip
        if contour is not outlines[0]:
            return  # all of a face take the same
        shape = box(-FREE, -FREE, part.length + FREE, wall.width + FREE)
        for one in outlines:
            shape = shape.difference(shape_of(one.curves))
        if part.profile.code != "B" and _is_of_ends(shape, wall, part):
            return
    if margins.outline:
        shape = shape.buffer(margins.outline, join_style="mitre")
    if part.profile.code in ("M", "B") or (wall.normal == "y") == (part.profile.code == "T"):
        yield from _through(shape, wall)  # the wall that the others stand on, with their fillets
    else:
        yield prism(shape, 0.0, wall.thickness, wall.frame)


def _is_of_ends(gone: Shape, wall: Wall, part: Part) -> bool:
    """Whether what an outline leaves out is what the end planes cut off anyway.

    A skew plane leaves the end of a wall skew through its thickness, and an outline shows either
    surface; exporters round outlines by up to OUTLINE_NOISE.
    """
    from shapely import Polygon

    ends: list[list[tuple[float, float]]] = []  # of the start and the end, (x, q) at both edges
    for (x, _, _), (side, along_y, along_z) in end_planes(part, drawn=True):
        chain = []
        for q in (0.0, wall.width):
            xs = []
            for depth in (0.0, wall.thickness):
                at = wall.surface + wall.inward * depth
                y, z = (at, q) if wall.normal == "y" else (q, at)
                xs.append(x - side * (along_y * y + along_z * z))
            chain.append(((min(xs) if side > 0 else max(xs)), q))
        ends.append(chain)
    (a, b), (c, d) = ends
    inner = Polygon([a, c, d, b]).buffer(-OUTLINE_NOISE)
    return bool(gone.intersection(inner).buffer(-CHORD).is_empty)


def _beside(shape: Shape, wall: Wall) -> Shape:
    """A shape on a wall where no other wall stands on it."""
    from shapely import box

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


def _through(shape: Shape, wall: Wall) -> Iterator["Manifold"]:
    """A cutter through a wall, and through what fillets stand on it."""
    beside = _beside(shape, wall)
    if not beside.equals(shape):
        yield prism(shape, 0.0, wall.thickness, wall.frame)
    yield prism(beside, -wall.before - FREE, wall.thickness + wall.behind + FREE, wall.frame)


def _blind(shape: Shape, wall: Wall, depth: float) -> Iterator["Manifold"]:
    """A cutter into a wall, through the fillet before it."""
    yield prism(shape, 0.0, depth, wall.frame)
    yield prism(_beside(shape, wall), -wall.before - FREE, min(depth, FREE) / 2, wall.frame)


def _hole(
    hole: Hole, wall: Wall, part: Part, margins: Margins, pilot: float
) -> Iterator["Manifold"]:
    from shapely import Polygon

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
        yield from _through(shape, wall)
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
    from shapely import box

    x, y = hole.x, hole.y
    square = box(x - radius - 1, y - radius - 1, x + radius + 1, y + radius + 1)
    return prism(square, -FREE, wall.thickness, wall.frame)


def _sink(hole: Hole, wall: Wall, margins: Margins, pilot: float) -> Iterator["Manifold"]:
    """A counterbore is flat at its depth; a cone is as wide as its diameter at the surface.

    A cone that goes deeper than it would alone has a cylinder above it and meets the hole that it
    sinks at its depth.
    """
    from shapely import Polygon

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


def _slot(slot: Slot, wall: Wall, margins: Margins) -> Iterator["Manifold"]:
    shape = slot_shape(slot, margins.radius(slot.diameter))
    if slot.depth is None:
        yield from _through(shape, wall)
    else:
        yield from _blind(shape, wall, slot.depth + margins.depth)


def slot_shape(slot: Slot, larger: float = 0.0) -> Shape:
    """A slot or a rectangle with round corners, in (x, q) of its face."""
    from shapely import MultiPoint

    radius = slot.diameter / 2 + larger
    return MultiPoint([p for at in slot_corners(slot) for p in circle(*at, radius)]).convex_hull


def slot_corners(slot: Slot) -> list[tuple[float, float]]:
    """The centres of the circles at its corners."""
    c, s = cos(radians(slot.angle)), sin(radians(slot.angle))
    return [
        (slot.x + a * c - b * s, slot.y + a * s + b * c)
        for a in (-slot.length / 2, slot.length / 2)
        for b in (-slot.height / 2, slot.height / 2)
    ]


def _radial(hole: Hole, part: Part, margins: Margins) -> "Manifold":
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
    from shapely import Point, Polygon

    body = prism(Polygon(), 0.0, 0.0, wall.frame)
    if not bevel.curve < len(contour.curves):
        return body
    deep = wall.thickness - bevel.land
    wide = deep * tan(radians(min(abs(bevel.angle), 89.0)))
    if deep <= 0.0 or wide <= 0.0:
        return body
    near = bevel.angle > 0
    chain = polylines((contour.curves[bevel.curve],), CHORD).points.tolist()
    for (ax, aq), (bx, bq) in pairwise(chain):
        long = hypot(bx - ax, bq - aq)
        if long <= 0.0:
            continue
        ex, eq = (bx - ax) / long, (bq - aq) / long
        nx, nq = -eq, ex
        if not inside.contains(Point((ax + bx) / 2 + nx * 0.01, (aq + bq) / 2 + nq * 0.01)):
            nx, nq = -nx, -nq
        # (across the edge, depth, along) to (x, q, depth)
        to_face = wall.frame
        rows = []
        for a, b, c, d in to_face:
            across, along = a * nx + b * nq, a * ex + b * eq
            rows.append((across, c, along, d + a * ax + b * aq))
        grown = wide * FREE / deep
        top, foot = (-FREE, deep) if near else (wall.thickness + FREE, wall.thickness - deep)
        wedge = Polygon([(-FREE, top), (wide + grown + margin, top), (margin, foot), (-FREE, foot)])
        body += prism(wedge, 0.0, long, (rows[0], rows[1], rows[2]))
    return body
