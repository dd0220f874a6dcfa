"""Marks that are lines and texts: a scribe follows them; a stamp or printer gets a text.

A text is lettered where it is clear of holes, edges and ends. One without room, or out of reach, is
left for manual work.
"""

from collections import defaultdict
from collections.abc import Iterator, Sequence
from math import dist
from typing import TYPE_CHECKING

from msgspec.structs import replace

from beamcam.errors import Diagnostic, warning
from beamcam.geometry.curves import Curve, Line, Point
from beamcam.machine.stations import FLAT_DEG, Tool
from beamcam.model.part import Contour, Face, Hole, Slot, TextMark
from beamcam.model.plan import StampedLetters
from beamcam.model.section import NO_PLATE, OTHER_SIDE, walls_beside
from beamcam.planning.axis_limits import within_axes
from beamcam.planning.left_out import FACE
from beamcam.planning.operations.finished_part import TOLERANCE, wall_end
from beamcam.planning.operations.part_planner import IN_THE_WAY, PartPlanner, WorkKind
from beamcam.planning.operations.slot import MIN_RADIUS, without_repeats
from beamcam.planning.operations.tools import Found, Settled, Tooling, WorkingStep
from beamcam.planning.rules import MARK, no_unit

if TYPE_CHECKING:
    from beamcam.planning.lettering_room import Room


def line_points(curves: Sequence[Curve], tolerance: float) -> tuple[Point, ...]:
    """Points of a chain of curves, whose chords lie within `tolerance` of it."""
    points = [curves[0].start]
    for curve in curves:
        if not isinstance(curve, Line):
            points += _halved(curve, 0.0, 1.0, tolerance, 12)
        points.append(curve.end)
    return tuple(without_repeats(points))


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


def can_scribe(face: Face, planner: PartPlanner) -> bool:
    """Whether a spindle comes to the face and takes a scribe."""
    return face in planner.reached and bool(planner.library.of_kind("scribe", (face,)))


def _length(line: Contour) -> str:
    return f"{sum(curve.length for curve in line.curves):g} mm of line"


def _scribing(face: Face, planner: PartPlanner, reason: str) -> Tooling:
    faces, library = (face,), planner.library
    scribes = library.of_kind("scribe", faces)[:1]
    return Tooling(planner.number(faces), scribes, faces, library.drill.mark_depth, (reason,))


def _line_needs(line: Contour, planner: PartPlanner) -> Diagnostic | None:
    if can_scribe(line.face, planner):
        return None
    return MARK.at(line.source, found=_length(line), face=line.face, why=no_unit("scribe"))


def _line_refusals(line: Contour, planner: PartPlanner) -> Iterator[Diagnostic]:
    """That a flange, a lip or the stem of a T stands in the way of the scribe."""
    reach = planner.reached[line.face]
    ys = [y for curve in line.curves for y in curve.bbox[1::2]]
    least, greatest, wall = reach.least, reach.greatest, reach.wall
    if planner.part.profile.code == "T" and line.face == "v":
        (stem,) = walls_beside(planner.part.profile, "v")
        least, greatest, wall = reach.least, stem.least, "stem"
        if max(ys) > stem.greatest:
            least, greatest = stem.greatest, reach.greatest
    out = next((y for y in (min(ys), max(ys)) if not least <= y <= greatest), None)
    if out is not None:
        yield IN_THE_WAY.at(
            line.source, what=f"{_length(line)} to mark", y=f"{out:g}", face=line.face,
            least=f"{max(least, 0.0):g}", greatest=f"{min(greatest, reach.width):g}", wall=wall,
        )  # fmt: skip


def _line_steps(lines: Sequence[tuple[int, Contour]], planner: PartPlanner) -> Iterator[Found]:
    """Each line scribed, from that end of it that comes first along the bar."""
    for f, line in lines:
        path = line_points(line.curves, planner.library.drill.path_tolerance)
        if path[-1][0] < path[0][0]:
            path = path[::-1]
        tooling = _scribing(line.face, planner, "scribe-line")
        yield WorkingStep(*path[0], tooling, (f,), line.source, path)
        width = planner.part.profile.face_width(line.face)
        left, place = min(
            planner.finished.steel(line.face, path),
            (min(min(y, width - y) for _, y in path), f"the edge of face {line.face}"),
        )
        if left < -TOLERANCE:
            yield f, LINE_BEYOND.at(line.source, face=line.face, out=f"{-left:.3g}", where=place)


LINE = WorkKind(
    "mark", _line_needs, _line_refusals, _line_steps,
    {"scribe-line": "a line that is marked and not cut"},
)  # fmt: skip


def _text_steps(texts: Sequence[tuple[int, TextMark]], planner: PartPlanner) -> Iterator[Found]:
    from beamcam.planning.lettering import place_text, remarks

    by_face: dict[Face, list[tuple[int, TextMark]]] = defaultdict(list)
    for f, text in texts:
        by_face[text.face].append((f, text))
    marks, missing = planner.machine.marks, NO_PLATE.get(planner.part.profile.code, ())
    for face, group in by_face.items():
        has_unit = face in marks.faces and face not in missing
        letters = has_unit if marks.is_told else can_scribe(face, planner)
        room = _room(face, planner) if letters else None
        for f, text in group:
            lettered = FACE if room is None else place_text(text, marks, room)
            if isinstance(lettered, str):
                yield Settled(f, "listed", lettered)
                continue
            if isinstance(lettered, Diagnostic):
                yield f, lettered
                break
            yield from ((f, diagnostic) for diagnostic in remarks(text, lettered, marks))
            if marks.unit == "stamp" or marks.unit == "printer":
                unit = Tool(marks.unit, lettered.height, FLAT_DEG)
                how = Tooling(marks.faces[face], (unit,), (face,), None, ("tell",))
                stamped = StampedLetters(lettered.text, lettered.height, lettered.angle)
                yield WorkingStep(lettered.x, lettered.y, how, (f,), text.source, text=stamped)
                continue
            how = _scribing(face, planner, "letter")
            for stroke in lettered.strokes:
                yield WorkingStep(*stroke[0], how, (f,), text.source, stroke)


def _room(face: Face, planner: PartPlanner) -> "Room | None":
    """Room for a text on a face, within the axes' travel; None where there is none."""
    from beamcam.planning.lettering_room import Room

    # The y of a face between edges, fillets and what is in the tool's way.
    profile = planner.part.profile
    low, high = 0.0, profile.face_width(face)
    if face in planner.reached:
        low, high = max(low, planner.reached[face].least), min(high, planner.reached[face].greatest)
    if profile.code == "M":  # closed: its walls stand behind the face, beyond round corners
        low, high = low + profile.radius, high - profile.radius
    elif profile.face_depth(face):
        for wall in walls_beside(profile, face):
            if wall.least <= low:
                low = max(low, wall.greatest + wall.radius)
            if wall.greatest >= high:
                high = min(high, wall.least - wall.radius)
    if not planner.machine.marks.is_told:
        bounds = within_axes(_scribing(face, planner, "letter"), (low, high), planner.travel)
        if bounds is None:
            return None
        low, high = bounds
    start, end = (wall_end(each, face, profile) for each in planner.ends)
    outline = [
        (start.greatest - low * start.slope, low),
        (end.least - low * end.slope, low),
        (end.least - high * end.slope, high),
        (start.greatest - high * start.slope, high),
    ]
    xs = [x for x, _ in outline]
    room = Room((min(xs), low, max(xs), high))
    room.bound(outline)
    # Take the stem of a T, and holes and slots, from the steel.
    if profile.code == "T" and face == "v":
        (x0, _, x1, _), (stem,) = room.box, walls_beside(profile, face)
        low, high = stem.least - stem.radius, stem.greatest + stem.radius
        room.remove([(x0, low), (x1, low), (x1, high), (x0, high)])
    behind = OTHER_SIDE.get(profile.code, {}).get(face)
    for feature in planner.part.features:
        if isinstance(feature, (Hole, Slot)) and feature.face in (face, behind):
            for centre in feature.centres:
                room.drill(centre, feature.diameter / 2)
            if isinstance(feature, Slot):  # the box around it, along its angle
                size = feature.diameter
                box = replace(feature, length=feature.length + size, height=feature.height + size)
                a, b, c, d = box.centres
                room.remove([a, b, d, c])
    return room


# What the machine cannot letter is left for manual work.
TEXT_REASONS = {
    "letter": "a text lettered by strokes",
    "tell": "a text that the machine's stamp or printer can letter",
}
TEXT = WorkKind("text", lambda *_: None, steps=_text_steps, reasons=TEXT_REASONS)
