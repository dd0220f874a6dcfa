"""Position of a sheet on the table, and whether its work fits there."""

from collections.abc import Sequence
from math import dist

from msgspec.structs import replace

from beamcam.errors import PlanError
from beamcam.geometry.arrays import CurveTable
from beamcam.geometry.plane import Box, Point
from beamcam.machine.torch import ORIGINS, Torch
from beamcam.model.moved import moved_curve
from beamcam.model.part import Part
from beamcam.model.plan import ContourOp
from beamcam.planning.contours import rules
from beamcam.planning.contours.outline import Shape


def box_of(curves: CurveTable) -> Box:
    """The bounding box of one or more curves."""
    if curves.box is None:
        raise AssertionError("curves without a box")
    return curves.box


def shift_of(box: Box, torch: Torch) -> Point:
    """Machine coordinates of the part's x 0, y 0, by the box of its work."""
    if torch.place == "drawn" and torch.origin == "table":
        return 0.0, 0.0
    if torch.origin in ORIGINS:
        (u, v), (x0, y0, x1, y1) = ORIGINS[torch.origin], box
        return -x0 - u * (x1 - x0), -y0 - v * (y1 - y0)
    return torch.margin - box[0], torch.margin - box[1]


def moved(shapes: Sequence[Shape], shift: Point) -> list[Shape]:
    """The shapes in machine coordinates."""
    if shift == (0.0, 0.0):
        return list(shapes)
    return [
        replace(shape, curves=tuple([moved_curve(c, shift) for c in shape.curves]))
        for shape in shapes
    ]


def refuse_large(box: Box, part: Part, torch: Torch) -> None:
    """Raises PlanError if the box of the work is larger than the area; kerf and leads add to it.

    Asked first, because what a damaged file holds may be as large as a planet and take hours.
    """
    _refuse_extent(box, part, torch, torch.gap + torch.tolerance)


def worked_box(operations: Sequence[ContourOp], overscan: float = 0.0) -> Box:
    """The box around all that the tool does, leads included, and round hatches their overscan."""
    passes = [one for op in operations for one in op.passes]
    ways = [way for p in passes for way in (p.lead_in, p.curves, p.lead_out)]
    box = box_of(CurveTable([curve for way in ways for curve in way]))
    beyond = [
        point
        for op in operations
        if overscan and op.is_hatch
        for (x0, y0), (x1, y1) in ((op.start, op.end),)
        for k in (overscan / (dist(op.start, op.end) or 1.0),)
        for point in ((x0 - k * (x1 - x0), y0 - k * (y1 - y0)),
                      (x1 + k * (x1 - x0), y1 + k * (y1 - y0)))
    ]  # fmt: skip
    xs, ys = [x for x, _ in beyond], [y for _, y in beyond]
    return (
        min([box[0], *xs]), min([box[1], *ys]), max([box[2], *xs]), max([box[3], *ys])
    )  # fmt: skip


def refuse_size(operations: Sequence[ContourOp], part: Part, torch: Torch) -> None:
    """Raises PlanError if the head would have to leave the work area."""
    low_x, low_y, high_x, high_y = torch.area
    box = worked_box(operations, torch.overscan)
    slack = torch.tolerance
    _refuse_extent(box, part, torch, slack)
    if (
        box[0] < low_x - slack or box[1] < low_y - slack
        or box[2] > high_x + slack or box[3] > high_y + slack
    ):  # fmt: skip
        x0, y0, x1, y1 = (f"{v:.1f}" for v in box)
        raise PlanError(
            rules.SHEET_PLACE.at(
                part.source, x0=x0, y0=y0, x1=x1, y1=y1,
                length=f"{torch.length:g}", width=f"{torch.width:g}",
            )
        )  # fmt: skip


def _refuse_extent(box: Box, part: Part, torch: Torch, slack: float) -> None:
    if box[2] - box[0] > torch.length + slack or box[3] - box[1] > torch.width + slack:
        raise PlanError(
            rules.SHEET_SIZE.at(
                part.source,
                found=f"{box[2] - box[0]:.1f} x {box[3] - box[1]:.1f}",
                expected=f"{torch.length:g} x {torch.width:g}",
            )
        )
