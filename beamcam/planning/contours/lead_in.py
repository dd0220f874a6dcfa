"""Lead-ins and lead-outs: the paths between the pierced point and a closed contour."""

from math import dist, pi

from beamcam.geometry.conics import direction_deg
from beamcam.geometry.curves import Arc, Curve, Line
from beamcam.geometry.plane import Point
from beamcam.machine.torch import Torch

Curves = tuple[Curve, ...]

SAME_CIRCLE = 1e-4  #: mm that arcs of a round hole may be apart


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


def from_middle(curves: Curves) -> Curves:
    """Lead-in of a round hole: half a circle from its middle, tangent to it; none of another."""
    first, *others = curves
    if not isinstance(first, Arc) or not all(_is_of(first, other) for other in others):
        return ()
    (x, y), (mx, my) = first.start, first.centre
    half = Arc(
        ((x + mx) / 2, (y + my) / 2), first.radius / 2, first.start_deg - 180.0,
        180.0 if first.sweep_deg > 0.0 else -180.0,
    )  # fmt: skip
    return (half,)


def _is_of(arc: Arc, other: Curve) -> bool:
    """Whether another curve lies on the circle of an arc."""
    return (
        isinstance(other, Arc)
        and dist(arc.centre, other.centre) <= SAME_CIRCLE
        and abs(arc.radius - other.radius) <= SAME_CIRCLE
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
