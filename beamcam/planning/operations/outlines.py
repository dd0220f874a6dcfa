"""Outlines, which the saw cuts make or nothing, and what no line makes: bends, planes, cambers.

The saw makes the end plane that the angles and the length of the part give: it is one of its cuts.
"""

from collections.abc import Iterator, Sequence

from beamcam.errors import Diagnostic, error
from beamcam.geometry.curves import Line
from beamcam.geometry.plane import Point, join_boxes
from beamcam.machine.machine import saw_of
from beamcam.model.part import Bend, Camber, Contour, EndPlane, Part
from beamcam.model.section import corners
from beamcam.planning import rules
from beamcam.planning.operations.finished_part import CONTOUR_TOLERANCE, Ends, wall_end
from beamcam.planning.operations.part_planner import Numbered, PartPlanner, WorkKind
from beamcam.planning.operations.tools import Found, Settled
from beamcam.planning.rules import BEVEL, BEVEL_NOISE
from beamcam.planning.within import NOTHING_TAKEN, takes_nothing

COPE = error("plan-cope",
    "found a contour on face {face} that leaves the straight stock at x {x}, y {y}; expected "
    "straight edges and saw cuts",
    "A saw cannot make a cope or a notch. `--allow-skips cope` leaves it to another "
    "machine.")  # fmt: skip
CUTOUT = error("plan-cutout",
    "found a cut-out of {found} mm on face {face}; expected none, the machine has no torch",
    "A drill cannot make a cut-out. `--allow-skips cutout` leaves it to another "
    "machine.")  # fmt: skip
BEVEL_TOLERANCE_DEG = 0.2  #: between a bevel and the end cut that leaves it


def _cut_out(contour: Contour, _: PartPlanner) -> Diagnostic | None:
    """A torch, unless the contour is the outer one."""
    if contour.kind == "outer":
        return None
    x0, y0, x1, y1 = join_boxes([curve.bbox for curve in contour.curves]) or (0.0,) * 4
    return CUTOUT.at(contour.source, found=f"{x1 - x0:g} x {y1 - y0:g}", face=contour.face)


def _unsawn(contour: Contour, planner: PartPlanner) -> Iterator[Diagnostic]:
    corner = leaves_stock(contour, planner.part, planner.ends)
    if corner is not None:
        x, y = corner
        yield COPE.at(contour.source, face=contour.face, x=f"{x:g}", y=f"{y:g}")
    least = saw_of(planner.machine).min_mitre
    noise = [abs(bevel.angle) for bevel in contour.bevels if abs(bevel.angle) < least]
    if noise:
        yield BEVEL_NOISE.at(
            contour.source, count=len(noise), found=f"{max(noise):g}", expected=f"{least:g}"
        )
    # A web's mitre leaves a bevel on the flanges, and a flange's on the web.
    on_web = contour.face in ("v", "h")
    cuts = [abs(end.flange_deg if on_web else end.web_deg) for end in planner.ends]
    for bevel in contour.bevels:
        own = abs(bevel.angle)
        if own >= least and not any(cut and abs(own - cut) <= BEVEL_TOLERANCE_DEG for cut in cuts):
            yield BEVEL.at(contour.source, found=f"{bevel.angle:g}", face=contour.face)


def _sawn(features: Sequence[Numbered], _: PartPlanner) -> Iterator[Found]:
    """None: the cuts at the ends make them all."""
    return (Settled(f, "made", "saw") for f, _ in features)


def leaves_stock(contour: Contour, part: Part, ends: Ends) -> Point | None:
    """Where an outer contour is not what the stock and the end cuts alone give; None if it is.

    Each vertex has to lie on a long edge or on an end, and so has the middle of each curve; each
    corner has to be a vertex.
    """
    width = part.profile.face_width(contour.face)
    first, last = (wall_end(end, contour.face, part.profile) for end in ends)
    vertices: list[Point] = []
    for curve in contour.curves:
        vertices += (curve.start,) if isinstance(curve, Line) else (curve.start, curve.point(0.5))
    if not contour.closed:
        vertices.append(contour.curves[-1].end)
    middles = [curve.point(0.5) for curve in contour.curves]
    for x, y in (*vertices, *middles):
        (start, inside), (outside, end) = first.reach(y), last.reach(y)
        on_edge = min(abs(y), abs(y - width)) <= CONTOUR_TOLERANCE
        if not start <= x <= end or not (on_edge or x <= inside or x >= outside):
            return x, y
    for y in (0.0, width):
        for least, greatest in (first.reach(y), last.reach(y)):
            if not any(
                abs(vy - y) <= CONTOUR_TOLERANCE and least <= vx <= greatest for vx, vy in vertices
            ):
                return (least + greatest) / 2, y
    return None


CONTOUR = WorkKind("contour", _cut_out, _unsawn, _sawn)


NAMES = {Bend: "a bend", EndPlane: "an end plane", Camber: "a camber"}
SAME_PLANE = 0.1  #: mm between a plane and the end that it states once more, at any corner


def _beyond_saw(feature: Bend | EndPlane | Camber, planner: PartPlanner) -> Diagnostic | None:
    """What no saw makes; a plane that takes nothing is no work, that of an end is its cut."""
    if isinstance(feature, EndPlane):
        end = planner.ends[feature.normal[0] > 0]
        places = corners(planner.part.profile, planner.part.section)
        if all(abs(feature.x(y, z) - end.x(y, z)) <= SAME_PLANE for y, z in places):
            return None
        if takes_nothing(feature, _outermost(planner)):
            return None
    return rules.OTHER.at(feature.source, found=NAMES[type(feature)])


def _idle(feature: Bend | EndPlane | Camber, planner: PartPlanner) -> Iterator[Diagnostic]:
    """A note on a plane that takes nothing."""
    if isinstance(feature, EndPlane) and takes_nothing(feature, _outermost(planner)):
        yield NOTHING_TAKEN.at(feature.source)


def _outermost(planner: PartPlanner) -> Iterator[tuple[float, float, float]]:
    for y, z in corners(planner.part.profile, planner.part.section):
        yield from ((end.x(y, z), y, z) for end in planner.ends)


OTHER = WorkKind("other", _beyond_saw, _idle, steps=_sawn)
