"""What a spindle does at a place of a part, and the jobs that slots and scribed lines need."""

from collections.abc import Iterator

from msgspec import Struct

from beamcam.errors import Source
from beamcam.geometry.plane import Point, unit_vector
from beamcam.model.part import Contour, Face, Slot
from beamcam.planning.paths import line_points, pocket_path
from beamcam.planning.tools import Rack, Tools


class Tooling(Struct, frozen=True):
    """What a spindle does at a place, wherever that is; most places of a part share it."""

    spindle: int
    tools: Tools  #: any of which may do it
    faces: tuple[Face, ...]
    depth: float | None
    diameter: float  #: of the hole; 0 where the tool does not follow from it
    reasons: tuple[str, ...]


class Job(Struct, frozen=True):
    """One operation of a spindle, at its place on the part."""

    x: float
    y: float
    tooling: Tooling
    features: tuple[int, ...]  #: those of the part that it makes
    source: Source
    path: tuple[Point, ...] = ()  #: x on the part and y on the face; () for a stroke


def slot_ends(slot: Slot) -> tuple[Point, ...]:
    """Centres of the corner circles of a slot: two, or four of a rectangle."""
    c, s = unit_vector(slot.angle)
    halves = dict.fromkeys(
        (k * slot.length / 2, m * slot.height / 2) for k in (-1, 1) for m in (-1, 1)
    )
    return tuple((slot.x + c * a - s * b, slot.y + s * a + c * b) for a, b in halves)


def slot_jobs(f: int, slot: Slot, face: Face, spindle: int, rack: Rack) -> Iterator[Job]:
    """The ends drilled, where the machine does so and has the drill, and the slot milled."""
    ends = slot_ends(slot)
    faces = (face,)
    drills = rack.drills((slot.diameter,), faces)
    mill = rack.slot_mill(slot.diameter, faces)
    if rack.drill.slots == "drill-mill" and drills and len(ends) <= 2:
        drilled = Tooling(spindle, drills, faces, slot.depth, 0.0, ("slot-end",))
        for x, y in ends:
            yield Job(x, y, drilled, (f,), slot.source)
    path = pocket_path(
        (slot.x, slot.y), (slot.length, slot.height), slot.angle, slot.diameter,
        mill[0].diameter, rack.drill.path_tolerance, slot.depth is not None,
    )  # fmt: skip
    x, y = path[0]
    milled = Tooling(spindle, mill, faces, slot.depth, 0.0, ("slot-mill",))
    yield Job(x, y, milled, (f,), slot.source, path)


def scribe_job(f: int, line: Contour, spindle: int, rack: Rack) -> Job:
    """A line scribed, from that end of it that comes first along the bar."""
    path = line_points(line.curves, rack.drill.path_tolerance)
    if path[-1][0] < path[0][0]:
        path = path[::-1]
    scribe = rack.of_kind("scribe", (line.face,))[:1]
    x, y = path[0]
    depth = rack.drill.mark_depth
    tooling = Tooling(spindle, scribe, (line.face,), depth, 0.0, ("scribe-line",))
    return Job(x, y, tooling, (f,), line.source, path)
