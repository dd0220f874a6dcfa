"""Lead-ins and lead-outs: the paths between the pierced point and a closed contour."""

from math import pi

from beamcam.geometry.conics import direction_deg
from beamcam.geometry.curves import Arc, Curve, Line
from beamcam.geometry.plane import Point
from beamcam.machine.torch import Torch

Curves = tuple[Curve, ...]


def waste_side(area: float, is_hole: bool) -> int:
    """1 if what falls out lies left of a closed contour of that signed area, -1 if right."""
    return 1 if (area > 0.0) == is_hole else -1


def leads(
    curves: Curves, side: int, torch: Torch, share: float, over: Curves = ()
) -> tuple[Curves, Curves]:
    """Lead-in and lead-out of a closed contour on its waste side, `share` of the machine's length.

    The lead-out begins at the end of the overcut, `over`. A line comes square to the contour; an
    arc is a quarter circle that is tangent to it.

          |  line            .-  arc
          v                 (
        --o--->           --o--->
    """
    start, last = curves[0].start, (over or curves)[-1]
    return (
        _lead(start, curves[0].tangent(0.0), side, torch, torch.lead_in * share, False),
        _lead(last.end, last.tangent(1.0), side, torch, torch.lead_out * share, True),
    )


def _lead(
    at: Point, tangent: Point, side: int, torch: Torch, length: float, is_out: bool
) -> Curves:
    if torch.lead == "none" or length <= 0.0:
        return ()
    normal = (-side * tangent[1], side * tangent[0])
    if torch.lead == "line":
        far = (at[0] + length * normal[0], at[1] + length * normal[1])
        return (Line(at, far) if is_out else Line(far, at),)
    radius = length / (pi / 2)
    centre = (at[0] + radius * normal[0], at[1] + radius * normal[1])
    at_contour = direction_deg((-normal[0], -normal[1]))
    sweep = 90.0 * side
    return (Arc(centre, radius, at_contour if is_out else at_contour - sweep, sweep),)
