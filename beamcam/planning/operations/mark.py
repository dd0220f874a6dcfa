"""A line to mark on a face: a scribe is led along it. Centre points are holes of kind `mark`."""

from collections.abc import Iterator, Sequence

from beamcam.errors import Diagnostic, warning
from beamcam.model.part import Contour, Face
from beamcam.planning.operations.finished_part import TOLERANCE
from beamcam.planning.operations.part_planner import IN_THE_WAY, Kind, PartPlanner
from beamcam.planning.operations.paths import line_points
from beamcam.planning.operations.tools import Tooling
from beamcam.planning.operations.working_step import Found, WorkingStep
from beamcam.planning.rules import MARK, no_unit

LINE_BEYOND = warning("plan-line-beyond",
    "found a line to mark on face {face} that goes {out} mm beyond {where}; expected it on the "
    "finished part",
    "What is scribed beyond the part is scribed on waste, or in the air.")  # fmt: skip
RULES = (LINE_BEYOND,)
REASONS = {"scribe-line": "a line that is marked and not cut"}


def can_scribe(face: Face, planner: PartPlanner) -> bool:
    """Whether a spindle comes to the face and takes a scribe."""
    return face in planner.reached and bool(planner.library.of_kind("scribe", (face,)))


def _length(line: Contour) -> str:
    return f"{sum(curve.length for curve in line.curves):g} mm of line"


def _needs(line: Contour, planner: PartPlanner) -> Diagnostic | None:
    if can_scribe(line.face, planner):
        return None
    return MARK.at(line.source, found=_length(line), face=line.face, why=no_unit("scribe"))


def _refusals(line: Contour, planner: PartPlanner) -> Iterator[Diagnostic]:
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


def _steps(lines: Sequence[tuple[int, Contour]], planner: PartPlanner) -> Iterator[Found]:
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


LINE = Kind(
    "mark",
    lambda feature: isinstance(feature, Contour) and feature.process != "cut",
    _needs,
    _refusals,
    _steps,
    REASONS,
)
