"""A contour to cut: saw cuts make the outer one of straight stock, and nothing any other."""

from collections.abc import Iterator, Sequence

from beamcam.errors import Diagnostic, error
from beamcam.model.part import Contour, Face
from beamcam.planning.operations.ends import Ends, leaves_stock
from beamcam.planning.operations.part_planner import Kind, PartPlanner
from beamcam.planning.operations.working_step import Found, Settled
from beamcam.planning.rules import BEVEL, BEVEL_NOISE

COPE = error("plan-cope",
    "found a contour on face {face} that leaves the straight stock at x {x}, y {y}; expected "
    "straight edges and saw cuts",
    "A saw cannot make a cope or a notch. `--allow-skips cope` leaves it to another "
    "machine.")  # fmt: skip
CUTOUT = error("plan-cutout",
    "found a cut-out of {found} mm on face {face}; expected none, the machine has no torch",
    "A drill cannot make a cut-out. `--allow-skips cutout` leaves it to another "
    "machine.")  # fmt: skip
RULES = (COPE, CUTOUT)
BEVEL_TOLERANCE_DEG = 0.2  #: between a bevel and the end cut that leaves it


def _needs(contour: Contour, _: PartPlanner) -> Diagnostic | None:
    """A torch, unless the contour is the outer one."""
    if contour.kind == "outer":
        return None
    boxes = [curve.bbox for curve in contour.curves]
    size = (
        f"{max(b[2] for b in boxes) - min(b[0] for b in boxes):g} x "
        f"{max(b[3] for b in boxes) - min(b[1] for b in boxes):g}"
    )
    return CUTOUT.at(contour.source, found=size, face=contour.face)


def _refusals(contour: Contour, planner: PartPlanner) -> Iterator[Diagnostic]:
    """Parts of the contour that the saw cuts do not produce."""
    corner = leaves_stock(contour, planner.part, planner.ends)
    if corner is not None:
        x, y = corner
        yield COPE.at(contour.source, face=contour.face, x=f"{x:g}", y=f"{y:g}")
    least = planner.line.saw.min_mitre
    noise = [abs(bevel.angle) for bevel in contour.bevels if abs(bevel.angle) < least]
    if noise:
        yield BEVEL_NOISE.at(
            contour.source, count=len(noise), found=f"{max(noise):g}", expected=f"{least:g}"
        )
    for bevel in contour.bevels:
        if abs(bevel.angle) >= least and not _is_sawn(bevel.angle, contour.face, planner.ends):
            yield BEVEL.at(contour.source, found=f"{bevel.angle:g}", face=contour.face)


def _is_sawn(bevel_deg: float, face: Face, ends: Ends) -> bool:
    """Whether an end cut leaves this bevel: a web's mitre on the flanges, a flange's on the web."""
    on_web = face in ("v", "h")
    leaves = (end.flange_deg if on_web else end.web_deg for end in ends)
    return any(
        angle and abs(abs(bevel_deg) - abs(angle)) <= BEVEL_TOLERANCE_DEG for angle in leaves
    )


def _steps(contours: Sequence[tuple[int, Contour]], _: PartPlanner) -> Iterator[Found]:
    """None: the cuts at the ends make them all."""
    return (Settled(f, "made", "saw") for f, _ in contours)


CONTOUR = Kind(
    "contour",
    lambda feature: isinstance(feature, Contour) and feature.process == "cut",
    _needs,
    _refusals,
    _steps,
)
