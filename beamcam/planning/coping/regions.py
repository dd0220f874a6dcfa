"""What stays of each wall: a region in (x, y) of its face, its corners as round as they are cut.

Regions are polygons; their chords lie within CHORD of the curves of the part.
"""

from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import suppress
from math import atan2, degrees, inf
from typing import Any

from msgspec import Struct
from msgspec.structs import replace
from shapely import (
    GEOSException,
    MultiPoint,
    Polygon,
    box,
    distance,
    get_coordinates,
    make_valid,
    points,
    segmentize,
    union_all,
)
from shapely import Point as Place
from shapely.geometry.polygon import orient

from beamcam.errors import Diagnostic, Source
from beamcam.geometry.curves import Curve, Line, Point, signed_area
from beamcam.geometry.polylines import polylines
from beamcam.machine.coper import Coper
from beamcam.model.part import Contour, Face, Feature, Hole, Part, Slot
from beamcam.planning.contours.outline import curves_of
from beamcam.planning.coping import rules
from beamcam.planning.coping.chart import Chart
from beamcam.planning.coping.walls import EndLine, PlannedWall

Shape = Any  #: of shapely
Cut = Hole | Slot | Contour

CHORD = 0.01  #: mm between a curve and its chords
GRID = 1e-9  #: mm on which regions are joined
SLIVER = 2 * CHORD  #: mm; what is thinner is nothing, as what GEOS leaves beside a straight side
ROUND = 32  #: sides of a quarter of a rounded corner
OUTLINE_NOISE = 1.0  #: mm between a header's width and an outline; real files differ by 0.7
SEAM_NOISE = 2.5  #: mm that the seam of a tube may be drawn off; about a kerf
ALONG = 0.02  #: slope of a side that is an edge of its wall, at most
MOST_ROUNDED = 1.65  #: radii that the rounding of a corner reaches along its sides, but for THIN
THIN = 0.02  #: radii; so thin it ends along a side, and may go on along one that is nearly straight
MOST_TURN_DEG = 125.0  #: of the sides of what is rounded in one; at 60 degrees it is 120
STEP = 0.005  #: mm between radii that are tried; where sides lean a disc lies 20 times that off
AROUND = 4.0  #: radii that the rounding of a corner looks at, more than twice what it reaches
CORNER_DEG = 20.0  #: a smaller turn belongs to a curve that is drawn by lines
BEYOND = 1e4  #: mm, farther than any bar is wide


class WallRegion(Struct, frozen=True):
    """What stays of a wall."""

    wall: PlannedWall
    shape: Shape
    rounded: Mapping[Point, float]  #: sharp corners, with the radius that each was cut with


def region_of(
    wall: PlannedWall, part: Part, features: Sequence[int], coper: Coper
) -> tuple[WallRegion, list[Diagnostic]]:
    """The region of a wall by those of a part's features that lie on it, and what is wrong."""
    own = [f for f in map(part.features.__getitem__, features) if isinstance(f, Cut)]
    outer = [c for c in own if isinstance(c, Contour) and c.kind == "outer"]
    inner = [c for c in own if not (isinstance(c, Contour) and c.kind == "outer")]
    diagnostics: list[Diagnostic] = []
    whole = _between(wall, (EndLine(0.0, 0.0), EndLine(part.length, 0.0)))
    strip = _between(wall, (EndLine(-BEYOND, 0.0), EndLine(part.length + BEYOND, 0.0)))
    if outer:
        drawn = union_all([outline_on(wall, c.curves) for c in outer])
        diagnostics += _beyond(drawn, strip, wall, outer[0])
        whole = drawn.intersection(strip)
    shape, round_ones = whole, list[Shape]()
    for feature in inner:
        gone = taken(feature)
        if not isinstance(feature, Contour):
            round_ones.append(gone)
        if not gone.intersects(whole):
            what = "a cut-out" if isinstance(feature, Contour) else "a hole"
            diagnostics.append(rules.OFF.at(feature.source, what=f"{what} on face {wall.face}"))
        shape = shape.difference(gone)
    if shape.is_empty:
        return WallRegion(wall, shape, {}), diagnostics
    reliefs = union_all(round_ones)
    corners = [  # what is at a root is cut with it, or stays there; a hole may be its relief
        (x, y)
        for c in (*outer, *inner) if isinstance(c, Contour)
        for x, y in sharp_corners(c)
        if not reliefs.dwithin(Place(x, y), CHORD) and not (
            wall.face == "v" and any(abs(y - root.y(0.0)) < root.thick + part.profile.radius
                                     for root in wall.roots))
    ]  # fmt: skip
    region, more = rounded(WallRegion(wall, shape, {}), corners, part, coper)
    diagnostics += more
    # What rounds a corner may lie in a hole beside it.
    if region.rounded and round_ones and region.shape.intersection(reliefs).area > CHORD * CHORD:
        region = replace(region, shape=region.shape.difference(reliefs))
    return region, diagnostics


def _between(wall: PlannedWall, square: tuple[EndLine, EndLine]) -> Shape:
    """A wall between the ends of its piece, or between skew ones and, where it has none, others."""
    start, end = wall.ends or (s or other for s, other in zip(wall.skew, square, strict=True))
    return Polygon(
        [(start.x(0.0), 0.0), (end.x(0.0), 0.0), (end.x(wall.width), wall.width),
         (start.x(wall.width), wall.width)]
    )  # fmt: skip


def _beyond(
    drawn: Shape, piece: Shape, wall: PlannedWall, outline: Contour
) -> Iterator[Diagnostic]:
    """An error where an outline goes on beyond the ends of a piece that comes cut, or skew ones."""
    if wall.ends is None and wall.skew == (None, None):
        return
    within = drawn.intersection(box(-BEYOND, 0.0, BEYOND, wall.width))
    over = within.difference(piece.buffer(OUTLINE_NOISE))
    if not over.is_empty:
        far = distance(piece, points(get_coordinates(over))).max()
        rule = rules.BEYOND if wall.ends is None else rules.SHORT
        yield rule.at(outline.source, face=wall.face, found=f"{far:.3g}")


def rounded(
    region: WallRegion, corners: Sequence[Point], part: Part, coper: Coper
) -> tuple[WallRegion, list[Diagnostic]]:
    """A region whose re-entrant corners at the given places have the machine's radius, or the
    largest for which there is room.

    What a ball of that radius does not reach from the scrap is added at each of them. A radius is a
    kerf at least, so that the torch turns with half a kerf about its path.
    """
    diagnostics: list[Diagnostic] = []
    if not corners:
        return region, diagnostics
    wall, shape, radius = region.wall, region.shape, coper.corner_radius
    row = Chart(part, coper).row(wall.thickness)
    least = min(radius, row.kerf) if row else radius
    added, found, tight = _filled(shape, corners, radius)
    for x, y in dict.fromkeys(tight):
        far = AROUND * radius
        near = shape.intersection(box(x - far, y - far, x + far, y + far))
        low, high = 0, round(radius / STEP)  # the largest radius that has room, in steps
        while high - low > 1:
            middle = (low + high) // 2
            has_room = not _filled(near, [(x, y)], middle * STEP)[2]
            low, high = (middle, high) if has_room else (low, middle)
        room = low * STEP if low * STEP > SLIVER else 0.0
        if room < least:
            what, expected = "sharper than 60 degrees", "one less sharp, or a drawn radius"
            if room:
                what = f"with room for a radius of {room:.2f} mm"
                expected = f"{least:g} mm at least, as a slot {2 * least:g} mm wide has it"
            diagnostics.append(
                rules.NARROW.at(
                    part.source, what=f"a re-entrant corner {what}", face=wall.face, x=f"{x:g}",
                    y=f"{y:g}", expected=expected,
                )
            )  # fmt: skip
            continue
        more, there, _ = _filled(near, [(x, y)], room)
        added += more
        found |= there
    whole = union_all([shape, *added]) if added else shape
    with suppress(GEOSException):  # on a grid GEOS joins not all that it joins without one
        # Beside a side that slants what is added may stand off by a crack of 1e-13 mm.
        closed = union_all([shape, *added], grid_size=GRID) if added else shape
        if whole.length > closed.length + SLIVER:
            whole = closed
    return WallRegion(wall, whole, found), diagnostics


def _filled(
    shape: Shape, corners: Sequence[Point], radius: float
) -> tuple[list[Shape], dict[Point, float], list[Point]]:
    """What a ball leaves at corners, those that have it, and those where it has no room.

    Along the sides of a corner it ends at radius / tan(angle / 2), which at 60 degrees is 1.73
    times the radius, and 0.2 less where it is thicker than THIN. What reaches farther belongs to a
    sharper corner or to a notch that is too narrow, and so does what has sides that face each
    other.
    """
    import numpy as np

    places = MultiPoint(corners)
    closed = shape.buffer(radius, ROUND).buffer(-radius, ROUND)
    filled = [one for one in polygons_of(closed.difference(shape)) if one.distance(places) <= CHORD]
    each = np.array(places.geoms)
    added, found, tight = [], dict[Point, float](), list[Point]()
    turned = (orient(polygon) for polygon in polygons_of(shape))  # the steel on the left
    rings = [
        np.array(ring.coords)[:-1] for one in turned for ring in (one.exterior, *one.interiors)
    ]
    border = closed.boundary
    tip = (2 * THIN) ** 0.5 * radius  # from where a disc touches a side to where it is THIN off it
    for piece, core in _pieces(filled, THIN * radius / 2, tip):
        mine = each[distance(piece, each) <= CHORD].tolist()
        if not mine:
            continue
        places_round = points(get_coordinates(segmentize(core.exterior, radius / 4)))
        deep = float(distance(MultiPoint(mine), places_round).max())
        if deep <= 2 * CHORD:
            continue
        if deep > MOST_ROUNDED * radius or _turn_in(piece, rings, border) > MOST_TURN_DEG:
            tight += [(one.x, one.y) for one in mine]
            continue
        added.append(piece)
        found |= {(one.x, one.y): radius for one in mine}
    return added, found, tight


def _pieces(joined: Sequence[Shape], half: float, tip: float) -> Iterator[tuple[Shape, Shape]]:
    """Pieces, also those that slivers join, each with what of it is thicker than twice `half`;
    beyond that they go on for `tip`."""
    for piece in joined:
        cores = [*polygons_of(piece.buffer(-half).buffer(half))] or [piece]
        for core in cores:
            others = [one.buffer(tip) for one in cores if one is not core]
            own = union_all([piece.difference(union_all(others)), core]) if others else piece
            yield next((one for one in polygons_of(own) if one.intersects(core)), own), core


def _turn_in(piece: Shape, rings: Sequence[Any], border: Shape) -> float:
    """Degrees that the border of a region turns along what is added to it, into the steel above
    0; 180 where two sides face each other. `rings` are those of the region, `border` is that which
    it has with its corners rounded."""
    import numpy as np

    total, bounds = 0.0, np.reshape(piece.bounds, (2, 2))
    for xy in rings:
        near = (xy >= bounds[0] - CHORD) & (xy <= bounds[1] + CHORD)
        beside = np.flatnonzero(near.all(axis=1))
        each = points(xy[beside])
        inside = (distance(piece, each) <= CHORD) & (distance(border, each) > SLIVER)
        at = beside[inside]
        before, way = xy[at] - xy[at - 1], xy[(at + 1) % len(xy)] - xy[at]
        cross = before[:, 0] * way[:, 1] - before[:, 1] * way[:, 0]
        total -= float(np.degrees(np.arctan2(cross, (before * way).sum(axis=1))).sum())
    return total


def rounded_notes(region: WallRegion, source: Source) -> Iterator[Diagnostic]:
    """How many corners of a region are rounded, by their radius."""
    for radius in sorted({*region.rounded.values()}, reverse=True):
        count = sum(one == radius for one in region.rounded.values())
        yield rules.ROUNDED.at(source, count=count, face=region.wall.face, radius=f"{radius:.4g}")


def polygons_of(shape: Shape, least: float = CHORD * CHORD) -> list[Shape]:
    """The polygons of a shape with more than the least area."""
    many = getattr(shape, "geoms", (shape,))
    return [one for one in many if one.geom_type == "Polygon" and one.area > least]


def outline_on(wall: PlannedWall, curves: Sequence[Curve], seam_from: float = inf) -> Shape:
    """The inside of an outline whose sides near an edge of its wall, or an end, lie on that.

    Of a tube a side that is so long is its seam, which writers close worse than they draw edges.
    Places of an arc stay where they are: one that runs into an edge is not flattened by it.
    """

    def moved(place: Point, sides: Sequence[Line]) -> Point:
        x, y = place
        for edge in (0.0, wall.width):
            if any(off_edge(side, edge, seam_from) is not None for side in sides):
                y = edge
        for end in wall.ends or wall.skew:
            if sides and end is not None and abs(x - end.x(y)) <= OUTLINE_NOISE + end.play:
                x = end.x(y)
        return x, y

    return shape_of(curves, moved)


def off_edge(side: Line, edge: float, seam_from: float = inf) -> float | None:
    """How far a side is off an edge of its wall that it means; None where it means none."""
    (x0, y0), (x1, y1) = side.start, side.end
    off, run = max(abs(y0 - edge), abs(y1 - edge)), abs(x1 - x0)
    most = SEAM_NOISE if run >= seam_from else OUTLINE_NOISE
    return off if off <= most and abs(y1 - y0) <= ALONG * run else None


def shape_of(
    curves: Sequence[Curve], moved: Callable[[Point, Sequence[Line]], Point] | None = None
) -> Shape:
    """The inside of a closed chain of curves.

    `moved` says where the ends of a curve lie, by the straight ones that meet there.
    """
    drawn = polylines(curves, CHORD)
    ring: list[Point] = []
    for k, curve in enumerate(curves):
        places = drawn.points[drawn.begins[k] : drawn.begins[k + 1] - 1].tolist()
        if moved is not None and places:
            sides = [one for one in (curves[k - 1], curve) if isinstance(one, Line)]
            places[0] = moved((places[0][0], places[0][1]), sides)
        ring += [(x, y) for x, y in places]
    whole = Polygon(ring) if len(ring) > 2 else Polygon()
    return whole if whole.is_valid else make_valid(whole)


def taken(feature: Cut) -> Shape:
    """What a hole, a slot or a cut-out takes of its wall."""
    return shape_of(feature.curves if isinstance(feature, Contour) else curves_of(feature, 0.0))


def sharp_corners(contour: Contour) -> Iterator[Point]:
    """The places at which a contour turns into the steel by more than CORNER_DEG.

    Steel lies inside of an outer contour and outside of an inner one.
    """
    curves = [curve for curve in contour.curves if curve.length > CHORD]
    round_way = signed_area(contour.curves) > 0.0
    into = -1.0 if round_way == (contour.kind == "outer") else 1.0
    for before, after in zip(curves, (*curves[1:], *curves[:1]), strict=True):
        (ax, ay), (bx, by) = before.tangent(1.0), after.tangent(0.0)
        turn = degrees(atan2(ax * by - ay * bx, ax * bx + ay * by))
        if into * turn > CORNER_DEG:
            yield after.start


def features_on(part: Part, made: Sequence[int]) -> dict[Face, list[int]]:
    """Features by the wall that they lie on; those behind the web lie on it in the same place."""
    found: dict[Face, list[int]] = {}
    for f in made:
        face = getattr(part.features[f], "face", "")
        found.setdefault("v" if face == "h" else face, []).append(f)
    return found


def open_on(face: Face, part: Part) -> Shape:
    """The holes, slots and cut-outs of a wall that another machine has made."""
    own = [f for f in part.made or () if getattr(f, "face", "").replace("h", "v") == face]
    return union_all([taken(f) for f in own if isinstance(f, Cut) and is_through(f)])


def is_through(feature: Feature) -> bool:
    """Whether what another machine has made goes through its wall, but for its ends."""
    if isinstance(feature, Hole | Slot):
        return feature.kind != "mark" and feature.depth is None
    return isinstance(feature, Contour) and feature.kind == "inner" and feature.process == "cut"
