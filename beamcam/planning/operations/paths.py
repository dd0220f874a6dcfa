"""Paths of mills and scribes on a face, as points so close that the chords keep a tolerance.

Every pocket of a line is a rectangle with round corners, of which a slot has no height and a
circle neither length nor height. A mill follows it inside by its own radius:

      ________________            corner radius of the path: (diameter - mill) / 2
    /  ____________   \\           blind pockets: further paths inside, `STEP` of a mill's
    | (____________)  |           diameter apart, until nothing is left to clear
    \\_________________/

The path begins at the end of the pocket that lies furthest along x, since that one is at the
machine last (and drilled before, where a slot's ends are drilled), and comes back to it.
"""

from collections.abc import Iterable, Iterator, Sequence
from math import acos, ceil, cos, dist, pi, sin

from beamcam.errors import Diagnostic, warning
from beamcam.geometry.curves import Curve, Line, Point
from beamcam.geometry.plane import unit_vector
from beamcam.model.part import Contour, Face
from beamcam.planning.operations.finished_part import TOLERANCE
from beamcam.planning.operations.part_planner import IN_THE_WAY, PartPlanner, WorkKind
from beamcam.planning.operations.tools import Found, Tooling, WorkingStep
from beamcam.planning.rules import MARK, no_unit

STEP = 0.6  #: of a mill's diameter between the paths that clear a blind pocket
MIN_RADIUS = 1e-6


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
    return tuple(_without_repeats(points))


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
    return list(_without_repeats(points))


def arc_steps(radius: float, sweep_rad: float, tolerance: float) -> int:
    """How many chords keep a circle's stretch within `tolerance` of it.

    The chord of a step t lies radius * (1 - cos(t / 2)) from the arc (the sagitta).
    """
    if radius <= MIN_RADIUS:
        return 1
    step = 2 * acos(max(0.0, 1 - tolerance / radius)) if tolerance < radius else pi / 2
    return max(1, ceil(abs(sweep_rad) / min(step, pi / 2) - 1e-9))


def _without_repeats(points: Iterable[Point]) -> Iterator[Point]:
    last: Point | None = None
    for point in points:
        if last is None or dist(point, last) > MIN_RADIUS:
            yield point
            last = point


def line_points(curves: Sequence[Curve], tolerance: float) -> tuple[Point, ...]:
    """Points of a chain of curves, whose chords lie within `tolerance` of it."""
    points = [curves[0].start]
    for curve in curves:
        if not isinstance(curve, Line):
            points += _halved(curve, 0.0, 1.0, tolerance, 12)
        points.append(curve.end)
    return tuple(_without_repeats(points))


def _halved(curve: Curve, low: float, high: float, tolerance: float, depth: int) -> list[Point]:
    """Points strictly between two parameters, by halves until two tests of the sagitta hold.

    Between places where x or y turns nothing is tested, so a first cut is always made.
    """
    middle = (low + high) / 2
    a, b = curve.point(low), curve.point(high)
    tests = (curve.point(low + (high - low) * share) for share in (0.25, 0.5, 0.75))
    is_flat = all(_off_chord(point, a, b) <= tolerance / 2 for point in tests)
    if depth == 0 or (is_flat and high - low <= 0.25):
        return []
    return [
        *_halved(curve, low, middle, tolerance, depth - 1),
        curve.point(middle),
        *_halved(curve, middle, high, tolerance, depth - 1),
    ]


def _off_chord(point: Point, a: Point, b: Point) -> float:
    length = dist(a, b)
    if length <= MIN_RADIUS:
        return dist(point, a)
    return abs((b[0] - a[0]) * (point[1] - a[1]) - (b[1] - a[1]) * (point[0] - a[0])) / length


LINE_BEYOND = warning("plan-line-beyond",
    "found a line to mark on face {face} that goes {out} mm beyond {where}; expected it on the "
    "finished part",
    "What is scribed beyond the part is scribed on waste, or in the air.")  # fmt: skip
REASONS = {"scribe-line": "a line that is marked and not cut"}


def can_scribe(face: Face, planner: PartPlanner) -> bool:
    """Whether a spindle comes to the face and takes a scribe."""
    return face in planner.reached and bool(planner.library.of_kind("scribe", (face,)))


def _length(line: Contour) -> str:
    return f"{sum(curve.length for curve in line.curves):g} mm of line"


def _mark_needs(line: Contour, planner: PartPlanner) -> Diagnostic | None:
    if can_scribe(line.face, planner):
        return None
    return MARK.at(line.source, found=_length(line), face=line.face, why=no_unit("scribe"))


def _mark_refusals(line: Contour, planner: PartPlanner) -> Iterator[Diagnostic]:
    """That a flange, a lip or the stem of a T stands in the way of the scribe."""
    reach = planner.reached[line.face]
    ys = [y for curve in line.curves for y in curve.bbox[1::2]]
    least, greatest, wall = reach.least, reach.greatest, reach.wall
    if planner.part.profile.code == "T" and line.face == "v":
        (stem,) = planner.finished.across("v").walls
        least, greatest, wall = reach.least, stem.least, "stem"
        if max(ys) > stem.greatest:
            least, greatest = stem.greatest, reach.greatest
    out = next((y for y in (min(ys), max(ys)) if not least <= y <= greatest), None)
    if out is not None:
        yield IN_THE_WAY.at(
            line.source, what=f"{_length(line)} to mark", y=f"{out:g}", face=line.face,
            least=f"{max(least, 0.0):g}", greatest=f"{min(greatest, reach.width):g}", wall=wall,
        )  # fmt: skip


def _mark_steps(lines: Sequence[tuple[int, Contour]], planner: PartPlanner) -> Iterator[Found]:
    """Each line scribed, from that end of it that comes first along the bar."""
    drill = planner.library.drill
    for f, line in lines:
        path = line_points(line.curves, drill.path_tolerance)
        if path[-1][0] < path[0][0]:
            path = path[::-1]
        faces = (line.face,)
        scribes = planner.library.of_kind("scribe", faces)[:1]
        number = planner.number(faces)
        tooling = Tooling(number, scribes, faces, drill.mark_depth, ("scribe-line",))
        yield WorkingStep(*path[0], tooling, (f,), line.source, path)
        across = planner.finished.across(line.face)
        left, place = min(
            planner.finished.steel(line.face, path),
            (min(min(y, across.width - y) for _, y in path), across.edge),
        )
        if left < -TOLERANCE:
            yield f, LINE_BEYOND.at(line.source, face=line.face, out=f"{-left:.3g}", where=place)


LINE = WorkKind(
    "mark", lambda feature: isinstance(feature, Contour) and feature.process != "cut", _mark_needs,
    _mark_refusals, _mark_steps, REASONS,
)  # fmt: skip
