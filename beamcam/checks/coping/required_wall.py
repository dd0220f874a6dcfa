"""What has to stay of each wall of a part, worked out for the read-back alone."""

from collections.abc import Collection, Sequence
from itertools import pairwise
from math import atan2, degrees, dist, hypot, inf, pi
from typing import Any

from msgspec import Struct
from shapely import (
    GEOSException,
    MultiPoint,
    Polygon,
    box,
    distance,
    get_coordinates,
    line_merge,
    points,
    union_all,
)
from shapely import Point as Place
from shapely.affinity import translate
from shapely.ops import substring

from beamcam.checks.coping.chart import CoperJob
from beamcam.checks.coping.section import CoperSection, areas_of, pieces_of
from beamcam.checks.coping.skew import DRAWN, EndOnWall
from beamcam.checks.coping.stock import FINE, WallStock, inside_of, outline_ring, taken
from beamcam.checks.job import is_manual_work
from beamcam.geometry.curves import Curve
from beamcam.geometry.plane import Point
from beamcam.machine.coper import Coper
from beamcam.machine.machine import Machine
from beamcam.model.part import Contour, EndPlane, Hole, Part, Slot

Shape = Any  #: of shapely

CORNER_DEG = 20.0  #: a contour that turns by more has a corner
FAR = 1e4  #: mm beyond any end
NO_CRACK = 1e-9  #: mm by which what stays at a corner may stand off a side that slants
OVERLAP = 1e-6  #: mm that it goes into the steel of a tube, so as not to stand off
#: Radii from a corner of 60 degrees to where a disc is SLIM off its sides, which it touches at 1.73
SHARPEST = 1.65
SLIM = 0.02  #: radii; so little may lie along a side that is nearly straight
TOUCH = 0.005  #: radii; what is left of twice that thickness is more than where a disc touches
FACING_DEG = 125.0  #: by which sides turn that face each other; those of one at 60 degrees by 120
LOOK = 0.2  #: mm round a corner in which steel and air are weighed


class RequiredWall(Struct, frozen=True):
    """What has to stay of a wall, without and with its corners rounded."""

    drawn: Shape
    cut: Shape
    short: float = 0.0  #: mm that a piece is too short for it
    #: what steps of an end that is cut square keep besides, as the jet is round
    steps: Shape = None

    @property
    def most(self) -> Shape:
        """What may stay at most."""
        return self.cut if self.steps is None else self.steps

    def grown(self, more: Shape, corners: list[Point], widest: float) -> "RequiredWall":
        """With steel that ends in such corners, which a jet of the widest kerf leaves round."""
        most, half = self.most.union(more), widest / 2
        most = _joined(most, _at_corners(left_at(most, corners, half), corners, half))
        drawn = areas_of(self.drawn.union(more))
        return RequiredWall(drawn, self.cut.union(more), self.short, most)


def required_on(
    job: CoperJob, face: str, section: CoperSection, left: Collection[int], stock: WallStock,
    ends: Sequence[EndOnWall] = (),
) -> RequiredWall:  # fmt: skip
    """What has to stay of a wall; `left` are features that are not made, `ends` skew ends."""
    part, wide = job.part, section.high if face == "v" else section.wide
    features = [
        f
        for k, f in enumerate(part.features)
        if k not in left and getattr(f, "face", "").replace("h", "v") == face
    ]
    outlines = [f for f in features if isinstance(f, Contour) and f.kind == "outer"]
    whole, short = stock.wall(face), 0.0
    # A plane through a round edge of the section ends a wall beyond that edge.
    sides = {end.side for end in ends}
    first, last = (-FAR if -1 in sides else 0.0), (FAR if 1 in sides else part.length)
    drawn: Shape = whole if stock.is_piece else box(first, 0.0, last, wide)
    if outlines:
        known = ends or (stock.ends[face] if stock.is_piece else ())
        rings = (outline_ring(one.curves, (0.0, wide), known) for one in outlines)
        drawn = union_all([inside_of(ring) for ring in rings])
        drawn = drawn.intersection(box(-1e6, 0.0, 1e6, wide))
        if stock.is_piece:
            over = drawn.difference(whole)
            short = max((whole.distance(p) for p in map(Place, get_coordinates(over))), default=0.0)
            drawn = drawn.intersection(whole)
        drawn = areas_of(drawn)
    for end in ends:
        over = drawn.intersection(end.beyond) if outlines else Polygon()
        inside = drawn.difference(end.beyond)
        far = max((inside.distance(p) for p in map(Place, get_coordinates(over))), default=0.0)
        short = max(short, far - end.apart)
        drawn = areas_of(inside)
    corners = [p for one in outlines for p in corners_of(one.curves, drawn)]
    bored = list[Shape]()  #: which have no corners, and take those that lie in them
    for feature in features:
        if isinstance(feature, Contour) and feature.kind == "outer":
            continue
        gone = taken(feature)
        drawn = drawn.difference(gone)
        if isinstance(feature, Contour):
            corners += corners_of(feature.curves, drawn)
        else:
            bored.append(gone)
    drawn, holes = areas_of(drawn), union_all(bored)
    # What is at a root is cut with it, or stays there.
    near = section.root_reach(face)
    corners = [
        (x, y) for x, y in corners
        if near[0] <= y <= near[1] and not holes.dwithin(Place(x, y), FINE)
    ]  # fmt: skip
    cut = with_corners_cut(drawn, corners, job.coper.corner_radius)
    if corners and bored:
        cut = areas_of(cut.difference(holes))
    return RequiredWall(drawn, cut, short if short > DRAWN else 0.0)


def with_corners_cut(drawn: Shape, corners: list[Point], radius: float, turn: float = 0.0) -> Shape:
    """A region whose corners are as round as a machine cuts them: by its radius, or where a disc of
    that does not come to both sides of one, by the largest that does.

    That of a tube goes on for a turn behind its own and before it; `corners` are those of one turn.
    """
    turns = (-turn, 0.0, turn) if turn else (0.0,)
    beside = 2 * radius if turn else inf  # of its own turn; so far what a disc leaves reaches
    there = [(x, y + by) for x, y in corners for by in turns if -beside <= y + by <= turn + beside]
    if not (left := left_at(drawn, there, radius)):
        return drawn
    if cramped := set(_cramped(drawn, left, there, radius)):
        there = [one for one in there if one not in cramped]
        left = left_at(drawn, there, radius)
    added, seen = _at_corners(left, there, radius), set[tuple[int, int]]()
    for x, y in sorted(cramped, key=lambda one: abs(one[1] - turn / 2)):
        place = round(x / FINE), round((y % turn if turn else y) / FINE)
        if place not in seen:
            seen.add(place)
            far = 5 * radius
            near = areas_of(drawn.intersection(box(x - far, y - far, x + far, y + far)))
            least, room = (
                0.0,
                radius,
            )  # between sides that lean a disc comes to lie much farther off
            while room - least > FINE / 10:
                middle = (least + room) / 2
                if _cramped(near, left_at(near, [(x, y)], middle), [(x, y)], middle):
                    room = middle
                else:
                    least = middle
            room = least if least > FINE else radius
            added += _at_corners(left_at(near, [(x, y)], room), [(x, y)], room)
    if not turn:
        return _joined(drawn, added)
    # On a grid GEOS does not join what is there again a turn farther.
    grown = [one.buffer(OVERLAP, join_style="mitre") for one in added]
    return areas_of(union_all([drawn, *(translate(one, 0.0, by) for one in grown for by in turns)]))


def _cramped(
    drawn: Shape, left: Sequence[Shape], corners: list[Point], radius: float
) -> list[Point]:
    """The corners at which what a disc leaves reaches farther than a corner of 60 degrees has it,
    or lies between two sides that face each other."""
    cramped, slim, places = list[Point](), SLIM * radius / 2, points(corners)
    border = drawn.boundary
    for piece in left:
        for core in pieces_of(piece.buffer(-slim).buffer(slim)):  # thin necks join some
            near = distance(core, places) <= 4 * slim
            mine = [corner for corner, is_near in zip(corners, near, strict=True) if is_near]
            if mine:
                round_it = points(get_coordinates(core.segmentize(radius / 4)))
                far = distance(MultiPoint(mine), round_it).max()
                if far > SHARPEST * radius or _turns_beside(core.buffer(slim), border) > FACING_DEG:
                    cramped += mine
    return cramped


def _turns_beside(piece: Shape, border: Shape) -> float:
    """Degrees that a border turns at most beside a piece, from where that begins on."""
    beside, most = border.intersection(piece.buffer(FINE)), 0.0
    for line in pieces_of(line_merge(beside) if beside.geom_type == "MultiLineString" else beside):
        # Without its ends, where it goes on round the corners on which the disc rests.
        inner = substring(line, 5 * FINE, line.length - 5 * FINE).simplify(FINE)
        xy = get_coordinates(inner).tolist()
        ways = [atan2(d - b, c - a) for (a, b), (c, d) in pairwise(xy) if dist((a, b), (c, d))]
        turn = sum((after - before + pi) % (2 * pi) - pi for before, after in pairwise(ways))
        most = max(most, degrees(abs(turn)))
    return most


def left_at(drawn: Shape, corners: list[Point], radius: float) -> list[Shape]:
    """What a disc of a radius, rolled through the air, leaves at corners."""
    if drawn.is_empty or not corners:
        return []
    places = MultiPoint(corners)
    # A disc that comes nearest to a corner lies within its diameter of it, and all that it leaves.
    air = places.buffer(4 * radius, cap_style="square").difference(drawn)
    left = air.difference(air.buffer(-radius, 24).buffer(radius, 24))
    return [
        piece
        for piece in pieces_of(left.intersection(places.buffer(2 * radius)))
        if piece.area > FINE * FINE and piece.distance(places) <= FINE
    ]


def _at_corners(left: Sequence[Shape], corners: list[Point], radius: float) -> list[Shape]:
    """What of the pieces that a disc leaves is at corners.

    In a slot that narrows to its mouth the disc touches both sides and leaves steel beyond it too,
    joined where it touches to that at the floor.
    """
    kept, thin, places = list[Shape](), TOUCH * radius, MultiPoint(corners)
    for piece in left:
        cores = pieces_of(piece.buffer(-thin).buffer(thin))
        beyond = [one.buffer(2 * thin) for one in cores if one.distance(places) > 4 * thin]
        is_split = len(beyond) < len(cores)
        kept.append(areas_of(piece.difference(union_all(beyond))) if is_split else piece)
    return kept


def _joined(drawn: Shape, added: Sequence[Shape]) -> Shape:
    """A region and what is added to it, without cracks between them."""
    if not added:
        return drawn
    try:
        return areas_of(union_all([drawn, *added], grid_size=NO_CRACK))
    except GEOSException:  # on a grid GEOS joins not all that it joins without one
        return areas_of(union_all([drawn, *added]))


def corners_of(curves: tuple[Curve, ...], steel: Shape) -> list[Point]:
    """Where a closed chain turns by more than CORNER_DEG with more steel than air round it."""
    long = [curve for curve in curves if curve.length > FINE]
    points: list[Point] = []
    for k, after in enumerate(long):
        (ax, ay), (bx, by) = long[k - 1].tangent(1.0), after.tangent(0.0)
        cross, dot = ax * by - ay * bx, ax * bx + ay * by
        if dot > 0.0 and degrees(abs(cross) / hypot(ax, ay) / hypot(bx, by)) <= CORNER_DEG:
            continue
        x, y = after.start
        around = box(x - LOOK, y - LOOK, x + LOOK, y + LOOK)
        if around.intersection(steel).area > around.area / 2:
            points.append(after.start)
    return points


def may_be_left(part: Part, machine: Machine, coper: Coper, skips: Collection[str]) -> set[int]:
    """Features that the torch cannot make and that are allowed to be missing."""
    kinds = {
        k: _kind(feature, part, coper) for k, feature in enumerate(part.features)
        if not is_manual_work(feature, machine)
    }  # fmt: skip
    return {k for k, kind in kinds.items() if kind and kind in skips}


def _kind(feature: object, part: Part, coper: Coper) -> str:
    """The kind of work by whose name a feature may be left out; "" if the torch makes it."""
    if isinstance(feature, Hole) and feature.kind == "mark":
        return "mark"
    if isinstance(feature, Contour):
        if feature.process != "cut":
            return "mark"
        if feature.face not in "vouh":
            return "face"
        return "other" if feature.kind == "open" or not feature.closed else ""
    if isinstance(feature, EndPlane) and coper.unrolls(part.profile.code) and feature.normal[0]:
        return ""
    if not isinstance(feature, Hole | Slot):
        return "other"
    faces = {"L": "vhu", "T": "vu", "RO": "v"}.get(part.profile.code, "vhou")
    if feature.face not in faces:
        return "face"
    wall = part.profile.web_thickness or part.profile.flange_thickness
    if feature.face in "ou":
        wall = part.profile.flange_thickness
    least = max(coper.min_hole, coper.min_hole_share * wall)
    if feature.kind == "through" and feature.depth is None and feature.diameter >= least:
        return ""
    return "slot" if isinstance(feature, Slot) else "tool"
