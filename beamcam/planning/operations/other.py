"""Features that no line makes: bends, planes in space, cambers.

The saw makes the end plane that the angles and the length of the part give: it is one of its cuts.
"""

from collections.abc import Iterator, Sequence

from beamcam.errors import Diagnostic
from beamcam.model.part import Bend, Camber, EndPlane
from beamcam.model.section import corners
from beamcam.planning import rules
from beamcam.planning.operations.part_planner import Kind, Numbered, PartPlanner
from beamcam.planning.operations.working_step import Found, Settled

NAMES = {Bend: "a bend", EndPlane: "an end plane", Camber: "a camber"}
SAME_PLANE = 0.1  #: mm between a plane and the end that it states once more, at any corner


def _needs(feature: Bend | EndPlane | Camber, planner: PartPlanner) -> Diagnostic | None:
    if isinstance(feature, EndPlane) and _is_sawn(feature, planner):
        return None
    return rules.OTHER.at(feature.source, found=NAMES[type(feature)])


def _is_sawn(plane: EndPlane, planner: PartPlanner) -> bool:
    """Whether a plane is that of the start or the end of the part."""
    start, end = planner.ends
    places = corners(planner.part.profile, planner.part.section)
    one = end if plane.normal[0] > 0 else start
    return all(abs(plane.x(y, z) - one.x(y, z)) <= SAME_PLANE for y, z in places)


def _steps(planes: Sequence[Numbered], _: PartPlanner) -> Iterator[Found]:
    """None: the cuts at the ends make them."""
    return (Settled(f, "made", "saw") for f, _ in planes)


OTHER = Kind("other", lambda feature: type(feature) in NAMES, _needs, steps=_steps)
