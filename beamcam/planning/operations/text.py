"""A text on a face, where it is clear of holes, edges and ends.

A scribe is led along its strokes; a stamp or printer is told it. One without room, or out of reach,
is left for manual work.
"""

from collections import defaultdict
from collections.abc import Iterator, Sequence
from typing import TYPE_CHECKING

from beamcam.errors import Diagnostic
from beamcam.machine.stations import FLAT_DEG, Tool
from beamcam.model.part import Face, Hole, Slot, TextMark
from beamcam.model.plan import StampedLetters
from beamcam.model.section import NO_PLATE, OTHER_SIDE
from beamcam.planning.axis_limits import within_axes
from beamcam.planning.left_out import FACE
from beamcam.planning.operations.ends import wall_end
from beamcam.planning.operations.part_planner import PartPlanner, WorkKind
from beamcam.planning.operations.paths import can_scribe
from beamcam.planning.operations.slot import slot_ends
from beamcam.planning.operations.tools import Found, Settled, Tooling, WorkingStep

if TYPE_CHECKING:
    from beamcam.planning.lettering import Lettered
    from beamcam.planning.lettering_room import Room

REASONS = {
    "letter": "a text lettered by strokes",
    "tell": "a text that the machine's stamp or printer can letter",
}


def _is_text(feature: object) -> bool:
    return isinstance(feature, TextMark)


def _needs(text: TextMark, planner: PartPlanner) -> None:
    """Nothing: what the machine cannot letter is left for manual work."""


def _steps(texts: Sequence[tuple[int, TextMark]], planner: PartPlanner) -> Iterator[Found]:
    if not texts:
        return
    from beamcam.planning.lettering import place_text, remarks

    by_face: dict[Face, list[tuple[int, TextMark]]] = defaultdict(list)
    for f, text in texts:
        by_face[text.face].append((f, text))
    for face, group in by_face.items():
        room = _room(face, planner) if _comes_to(face, planner) else None
        for f, text in group:
            lettered = FACE if room is None else place_text(text, planner.machine.marks, room)
            if isinstance(lettered, str):
                yield Settled(f, "listed", lettered)
                continue
            if isinstance(lettered, Diagnostic):
                yield f, lettered
                break
            yield from (
                (f, diagnostic) for diagnostic in remarks(text, lettered, planner.machine.marks)
            )
            yield from _steps_of(f, text, lettered, planner)


def _comes_to(face: Face, planner: PartPlanner) -> bool:
    """Whether what letters comes to a face."""
    if not planner.machine.marks.is_told:
        return can_scribe(face, planner)
    missing = NO_PLATE.get(planner.part.profile.code, ())
    return face in planner.machine.marks.faces and face not in missing


def _steps_of(
    f: int, text: TextMark, lettered: "Lettered", planner: PartPlanner
) -> Iterator[WorkingStep]:
    marks = planner.machine.marks
    if marks.unit == "stamp" or marks.unit == "printer":
        unit = Tool(marks.unit, lettered.height, FLAT_DEG)
        how = Tooling(marks.faces[text.face], (unit,), (text.face,), None, ("tell",))
        stamped = StampedLetters(lettered.text, lettered.height, lettered.angle)
        yield WorkingStep(lettered.x, lettered.y, how, (f,), text.source, text=stamped)
        return
    how = _tooling(text.face, planner)
    for stroke in lettered.strokes:
        yield WorkingStep(*stroke[0], how, (f,), text.source, stroke)


def _tooling(face: Face, planner: PartPlanner) -> Tooling:
    faces = (face,)
    scribes = planner.library.of_kind("scribe", faces)[:1]
    return Tooling(
        planner.number(faces), scribes, faces, planner.library.drill.mark_depth, ("letter",)
    )


def _room(face: Face, planner: PartPlanner) -> "Room | None":
    """Room for a text on a face, within the axes' travel; None where there is none."""
    from beamcam.planning.lettering_room import Room

    low, high = _between_walls(face, planner)
    if not planner.machine.marks.is_told:
        bounds = within_axes(_tooling(face, planner), (low, high), planner.travel)
        if bounds is None:
            return None
        low, high = bounds
    start, end = (wall_end(each, face, planner.part.profile) for each in planner.ends)
    outline = [
        (start.greatest - low * start.slope, low),
        (end.least - low * end.slope, low),
        (end.least - high * end.slope, high),
        (start.greatest - high * start.slope, high),
    ]
    xs = [x for x, _ in outline]
    room = Room((min(xs), low, max(xs), high))
    room.bound(outline)
    _remove_obstacles(room, face, planner)
    return room


def _between_walls(face: Face, planner: PartPlanner) -> tuple[float, float]:
    """The y of a face between edges, fillets and what is in the tool's way."""
    across = planner.finished.across(face)
    low, high = 0.0, across.width
    if face in planner.reached:
        low, high = max(low, planner.reached[face].least), min(high, planner.reached[face].greatest)
    profile = planner.part.profile
    if profile.code == "M":  # closed: its walls stand behind the face, beyond round corners
        low, high = low + profile.radius, high - profile.radius
    elif profile.face_depth(face):
        for wall in across.walls:
            if wall.least <= low:
                low = max(low, wall.greatest + wall.radius)
            if wall.greatest >= high:
                high = min(high, wall.least - wall.radius)
    return low, high


def _remove_obstacles(room: "Room", face: Face, planner: PartPlanner) -> None:
    """Take the stem of a T, and holes and slots, from the steel of a face."""
    code = planner.part.profile.code
    if code == "T" and face == "v":
        for wall in planner.finished.across(face).walls:
            room.remove(
                box_corners(room.box[0], wall.least - wall.radius, room.box[2],
                            wall.greatest + wall.radius)
            )  # fmt: skip
    behind = OTHER_SIDE.get(code, {}).get(face)
    for feature in planner.part.features:
        if isinstance(feature, (Hole, Slot)) and feature.face in (face, behind):
            centres = slot_ends(feature) if isinstance(feature, Slot) else ((feature.x, feature.y),)
            for centre in centres:
                room.drill(centre, feature.diameter / 2)
            if isinstance(feature, Slot):
                room.remove(_around(feature))


def box_corners(x0: float, y0: float, x1: float, y1: float) -> list[tuple[float, float]]:
    """The corners of a box along the axes."""
    return [(x0, y0), (x1, y0), (x1, y1), (x0, y1)]


def _around(slot: Slot) -> list[tuple[float, float]]:
    """The corners of the box around a slot, along its angle."""
    half_x, half_y = (slot.length + slot.diameter) / 2, (slot.height + slot.diameter) / 2
    box = Slot(slot.face, slot.x, slot.y, 0.0, 2 * half_x, 2 * half_y, slot.angle, slot.source)
    a, b, c, d = slot_ends(box)
    return [a, b, d, c]


TEXT = WorkKind("text", _is_text, _needs, steps=_steps, reasons=REASONS)
