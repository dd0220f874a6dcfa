"""A slot: its ends drilled, where the machine does so and has the drill, and the rest milled.

A slot is its core, a line or a rectangle, widened by half its width; a hole is a core of one point.
Keyholes are meant, so that what meets is a warning and not refused.

Every pocket is a rectangle with round corners, of which a slot has no height and a
circle neither length nor height. A mill follows it inside by its own radius:

      ________________            corner radius of the path: (diameter - mill) / 2
    /  ____________   \\           blind pockets: further paths inside, `STEP` of a mill's
    | (____________)  |           diameter apart, until nothing is left to clear
    \\_________________/

The path begins at the end of the pocket that lies furthest along x, since that one is at the
machine last (and drilled before, where a slot's ends are drilled), and comes back to it.
"""

from collections.abc import Iterable, Iterator, Sequence
from itertools import islice
from math import acos, ceil, cos, dist, hypot, pi, sin

from beamcam.errors import Diagnostic, error
from beamcam.geometry.plane import Point, unit_vector
from beamcam.model.description import named
from beamcam.model.part import Face, Hole, Slot
from beamcam.planning import rules
from beamcam.planning.operations.finished_part import NEAR_EDGE, TOLERANCE
from beamcam.planning.operations.part_planner import (
    PartPlanner,
    WorkKind,
    refuse_face,
    refuse_place,
)
from beamcam.planning.operations.tools import Found, Said, Tooling, WorkingStep

REASONS = {
    "slot-end": "the ends of a slot are drilled before it is milled",
    "slot-mill": "the widest mill that is no wider than the slot",
}

MANY_PAIRS = error("plan-slot-crowd",
    "found the pair of holes and slots side by side that is one too many; expected at most "
    "{expected} on a part",
    "So many slots do not stand beside each other on a wall: they are a drawing that was written "
    "again and again. Nothing else is said of them.")  # fmt: skip
MOST_PAIRS = 100_000  #: that are compared, 3 s

STEP = 0.6  #: of a mill's diameter between the paths that clear a blind pocket
MIN_RADIUS = 1e-6

Shape = tuple[int, Hole | Slot]  #: index of the feature, on the face that it is made from


def _needs(slot: Slot, planner: PartPlanner) -> Diagnostic | None:
    """A mill that is no wider, and a spindle on its face."""
    size = f"{slot.length + slot.diameter:g} x {slot.height + slot.diameter:g}"
    expected = ""
    if slot.kind not in ("through", "blind"):
        expected = f"a slot without a {slot.kind}"
    elif not planner.library.slot_mill(slot.diameter, (slot.face,)):
        expected = "no slot, the machine has no mill"
        mills = planner.library.of_kind("mill", (slot.face,))
        if mills:
            expected = f"one at least {mills[0].diameter:g} wide, as the smallest mill"
    if expected:
        return rules.SLOT.at(slot.source, found=size, face=slot.face, expected=expected)
    return None if slot.face in planner.reached else refuse_face(slot, "slot hole", planner.reached)


def _refusals(slot: Slot, planner: PartPlanner) -> list[Diagnostic]:
    """Faults in the position of its middle or of its corner circles."""
    part, reach, places = planner.part, planner.reached[slot.face], slot.centres
    refusals = (refuse_place(slot, x, y, part, reach) for x, y in ((slot.x, slot.y), *places))
    off = next((d for d in refusals if d is not None), None)
    return planner.finished.judge(slot) if off is None else [off]


def _steps(slots: Sequence[tuple[int, Slot]], planner: PartPlanner) -> Iterator[Found]:
    """The ends drilled, where the machine does so and has the drill, and the slots milled."""
    library = planner.library
    for f, slot in slots:
        centres, faces = slot.centres, (slot.face,)
        number, mill = planner.number(faces), library.slot_mill(slot.diameter, faces)
        drills = library.drills((slot.diameter,), faces)
        if library.drill.slots == "drill-mill" and drills and len(centres) <= 2:
            drilled = Tooling(number, drills, faces, slot.depth, ("slot-end",))
            for x, y in centres:
                yield WorkingStep(x, y, drilled, (f,), slot.source)
        path = pocket_path(
            (slot.x, slot.y), (slot.length, slot.height), slot.angle, slot.diameter,
            mill[0].diameter, library.drill.path_tolerance, slot.depth is not None,
        )  # fmt: skip
        milled = Tooling(number, mill, faces, slot.depth, ("slot-mill",))
        yield WorkingStep(*path[0], milled, (f,), slot.source, path)
    drilled_holes = (each for each in planner.holes if each[1].kind != "mark")
    yield from _judge_neighbours([*slots, *drilled_holes], library.drill.min_edge_distance)


def _judge_neighbours(shapes: Sequence[Shape], steel: float) -> Iterator[Said]:
    """For each slot or hole that is too near an earlier one its index, and a warning.

    Where comparing them would take minutes there is one error instead.
    """
    ranked = sorted(shapes, key=lambda shape: shape[0])
    pairs = list(islice(_near([shape for _, shape in ranked], steel), MOST_PAIRS + 1))
    if len(pairs) > MOST_PAIRS:
        f, slot = ranked[max(pairs[-1])]
        yield f, MANY_PAIRS.at(slot.source, expected=MOST_PAIRS)
        return
    for i, k in sorted(pairs):
        one, (f, other) = ranked[i][1], ranked[k]
        left = core_distance(one, other) - (one.diameter + other.diameter) / 2
        if left < steel - TOLERANCE:
            yield f, NEAR_EDGE.at(
                other.source, what=named(other), x=f"{other.x:g}", y=f"{other.y:g}",
                face=other.face, apart=f"{max(left, 0.0):.3g}",
                where=f"{named(one)} of {one.source}", expected=f"{steel:g}",
            )  # fmt: skip


def _near(shapes: Sequence[Hole | Slot], steel: float) -> Iterator[tuple[int, int]]:
    """Pairs of a slot and another shape on its face whose circles come as near as `steel`."""
    reaches = [
        (hypot(s.length, s.height) if isinstance(s, Slot) else 0.0) / 2 + s.diameter / 2 + steel
        for s in shapes
    ]
    along = sorted(range(len(shapes)), key=lambda i: shapes[i].x - reaches[i])
    open_: dict[Face, list[int]] = {}
    for i in along:
        one = shapes[i]
        begin = one.x - reaches[i]
        still = [k for k in open_.get(one.face, ()) if shapes[k].x + reaches[k] >= begin]
        for k in still:
            other = shapes[k]
            apart = hypot(one.x - other.x, one.y - other.y)
            if apart <= reaches[i] + reaches[k] and (
                isinstance(one, Slot) or isinstance(other, Slot)
            ):
                yield min(i, k), max(i, k)
        open_[one.face] = [*still, i]


def core_distance(one: Hole | Slot, other: Hole | Slot) -> float:
    """Distance between the cores of two shapes; 0 where they cross."""
    mine, theirs = _corners(one), _corners(other)
    if any(_cross(a, b) for a in _edges(mine) for b in _edges(theirs)):
        return 0.0
    return min(
        *(_from_core(other, corner) for corner in mine),
        *(_from_core(one, corner) for corner in theirs),
    )


def _corners(shape: Hole | Slot) -> tuple[Point, ...]:
    """The corners of a core, in order around it."""
    corners = shape.centres
    return (*corners[:2], corners[3], corners[2]) if len(corners) == 4 else corners


def _edges(corners: tuple[Point, ...]) -> list[tuple[Point, Point]]:
    return [] if len(corners) < 2 else list(zip(corners, (*corners[1:], corners[0]), strict=True))


def _from_core(shape: Hole | Slot, at: Point) -> float:
    dx, dy = at[0] - shape.x, at[1] - shape.y
    if isinstance(shape, Hole):
        return hypot(dx, dy)
    c, s = unit_vector(shape.angle)
    u, v = abs(c * dx + s * dy), abs(c * dy - s * dx)
    return hypot(max(u - shape.length / 2, 0.0), max(v - shape.height / 2, 0.0))


def _cross(one: tuple[Point, Point], other: tuple[Point, Point]) -> bool:

    def side(a: Point, b: Point, p: Point) -> float:
        return (b[0] - a[0]) * (p[1] - a[1]) - (b[1] - a[1]) * (p[0] - a[0])

    (a, b), (c, d) = one, other
    return side(a, b, c) * side(a, b, d) < 0 and side(c, d, a) * side(c, d, b) < 0


def pocket_path(
    centre: Point, size: tuple[float, float], angle_deg: float, diameter: float, mill: float,
    tolerance: float, is_blind: bool,
) -> tuple[Point, ...]:  # fmt: skip
    """Points of the path that mills a pocket, first and last the same one.

    `size` is the distance of the corner circles' centres along and across `angle_deg`, `diameter`
    that of the corner circles. The chords lie within `tolerance` of the path.
    """
    radius = max(0.0, (diameter - mill) / 2)
    rings = [_ring(size, radius, 0.0, tolerance)]
    inset = STEP * mill
    while is_blind and inset < radius + max(size) / 2:
        rings.append(_ring(size, radius, inset, tolerance))
        inset += STEP * mill
    c, s = unit_vector(angle_deg)
    placed = [
        [(centre[0] + c * x - s * y, centre[1] + s * x + c * y) for x, y in ring] for ring in rings
    ]
    # The ends of a slot that were drilled are the places where a mill may go in.
    ends = [(k * size[0] / 2, m * size[1] / 2) for k in (-1, 1) for m in (-1, 1)]
    entry = max((centre[0] + c * x - s * y, centre[1] + s * x + c * y) for x, y in ends)
    points = [entry]
    for ring in placed:
        nearest = min(range(len(ring)), key=lambda i: (dist(ring[i], points[-1]), i))
        points += [*ring[nearest:], *ring[:nearest], ring[nearest]]
    points.append(entry)
    return tuple(without_repeats(points))


def _ring(size: tuple[float, float], radius: float, inset: float, tolerance: float) -> list[Point]:
    """Points of the rounded rectangle, `inset` inside of the outermost path, about 0, 0."""
    corner = radius - inset
    half_x, half_y = size[0] / 2, size[1] / 2
    if corner < 0:
        half_x, half_y = max(0.0, half_x + corner), max(0.0, half_y + corner)
        corner = 0.0
    points: list[Point] = []
    for quarter, (x, y) in enumerate(((1, 1), (-1, 1), (-1, -1), (1, -1))):
        count = arc_steps(corner, pi / 2, tolerance)
        for i in range(count + 1):
            t = pi / 2 * (quarter + i / count)
            points.append((x * half_x + corner * cos(t), y * half_y + corner * sin(t)))
    return list(without_repeats(points))


def arc_steps(radius: float, sweep_rad: float, tolerance: float) -> int:
    """How many chords keep a circle's stretch within `tolerance` of it.

    The chord of a step t lies radius * (1 - cos(t / 2)) from the arc (the sagitta).
    """
    if radius <= MIN_RADIUS:
        return 1
    step = 2 * acos(max(0.0, 1 - tolerance / radius)) if tolerance < radius else pi / 2
    return max(1, ceil(abs(sweep_rad) / min(step, pi / 2) - 1e-9))


def without_repeats(points: Iterable[Point]) -> Iterator[Point]:
    last: Point | None = None
    for point in points:
        if last is None or dist(point, last) > MIN_RADIUS:
            yield point
            last = point


SLOT = WorkKind("slot", _needs, _refusals, _steps, REASONS)
