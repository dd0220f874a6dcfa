"""Entry moves of a controller's own kerf compensation.

The torch pierces at S, with compensation off, and runs square to the contour to P. At
that corner the controller can only stop where it touches both the lead and the contour, at Q:

          S                     The contour between P and the point below Q is cut at the end, when
          |                     the torch goes on beyond P by as much.
          |   Q
    ------P------->             Source: LinuxCNC, "Cutter Compensation": the first move is longer
                                than the radius, and no corner is narrower than the tool.
"""

from collections.abc import Sequence
from math import asin, dist, hypot, pi, sqrt

from msgspec import Struct

from beamcam.errors import Diagnostic
from beamcam.geometry.conics import direction_deg
from beamcam.geometry.curves import Arc, Curve, Line
from beamcam.geometry.plane import Point, dot
from beamcam.machine.torch import Torch
from beamcam.planning.contours import rules
from beamcam.planning.contours.order import PLAIN
from beamcam.planning.contours.outline import Curves, Shape, stretch, stretches_of
from beamcam.planning.contours.outline import ways as polylines_of

ROUNDING = 1e-6


def overcut_length(shape: Shape, torch: Torch) -> float:
    """The overcut that is asked of a contour: of its colour or layer, of small holes, or of all."""
    if shape.process != "cut" or not shape.is_ring:
        return 0.0
    own = torch.settings.get(shape.look, PLAIN).overcut
    if own is None and shape.is_small:
        own = torch.hole_overcut
    return torch.overcut if own is None else own


def overcut(shape: Shape, kerf: float, torch: Torch) -> Curves:
    """The stretch of a closed contour that is cut again at its end, none without an overcut.

    It is at most half of the way to the first bridge, or of the
    contour where there is none.
    """
    length = overcut_length(shape, torch)
    if not length:
        return ()
    first = stretches_of(shape, kerf, torch)[0]
    lengths = [curve.length for curve in first]
    return stretch(first, lengths, 0.0, min(length, sum(lengths) / 2))


def is_shortened(shape: Shape, kerf: float, torch: Torch) -> bool:
    """Whether a contour has too little room for its overcut."""
    length = overcut_length(shape, torch)
    if not length:
        return False
    first = stretches_of(shape, kerf, torch)[0]
    return sum(curve.length for curve in first) / 2 < length - ROUNDING


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


#: The shares of the machine's length of a lead that are tried, longest first.
SHARES = (1.0, 0.8, 0.6, 0.45, 0.35, 0.25)

#: So many of the longest curves of a contour are tried to begin on.
CANDIDATES = 4

#: What a lead is longer than it has to be, and what is cut twice, as a share of the kerf.
MARGIN = 0.05


class Entry(Struct, frozen=True):
    """A closed contour, begun where there is room for its lead."""

    curves: Curves
    lead_in: Curves
    lead_out: Curves  #: beyond its start, on it


def entries(
    shapes: Sequence[Shape], kerfs: Sequence[float], torch: Torch, fence: Sequence[Shape]
) -> tuple[dict[int, Entry], list[Diagnostic]]:
    """The entry of each compensated shape, and errors for those without one.

    No lead comes nearer than half a kerf to a contour of the `fence`.
    """
    import shapely

    which = [k for k, s in enumerate(shapes) if kerfs[k] and s.is_ring]
    if not which:
        return {}, []
    contours = [s.curves for s in fence if s.process == "cut" and s.closed]
    tree = shapely.STRtree(polylines_of(contours, torch.tolerance / 4))
    entries_of: dict[int, Entry] = {}
    for attempt in range(CANDIDATES * len(SHARES)):
        tried = {}
        for k in which:
            if k not in entries_of and torch.lead != "none":
                one = _entry(shapes[k], kerfs[k], torch, *divmod(attempt, len(SHARES)))
                if one is not None:
                    tried[k] = one
        if tried:
            lines = shapely.linestrings([way for _, way in tried.values()])
            apart = max(kerfs) / 2 - torch.tolerance / 2
            hit = set(tree.query(lines, "dwithin", distance=apart)[0].tolist())
            stops = shapely.points(
                [_beam_at_end(one, shapes[k], kerfs[k]) for k, (one, _) in tried.items()]
            )
            hit |= set(tree.query(stops, "dwithin", distance=apart)[0].tolist())
            free = (k for n, k in enumerate(tried) if n not in hit)
            entries_of |= {k: tried[k][0] for k in free}
        if len(entries_of) == len(which):
            break
    diagnostics = [
        rules.NEEDS_LEAD.at(shapes[k].source, found=f"{kerfs[k]:g}")
        for k in which
        if k not in entries_of
    ]
    return entries_of, diagnostics


def _entry(
    shape: Shape, kerf: float, torch: Torch, candidate: int, share: int
) -> tuple[Entry, tuple[Point, Point]] | None:
    """A contour begun on one of its longest curves, and the torch's path from S to Q.

    None where the curve or the lead is too short for that.
    """
    if candidate >= len(shape.curves):
        return None
    curves = _begun(shape.curves, candidate)
    first, length, radius = curves[0], torch.lead_in * SHARES[share], kerf / 2
    if not isinstance(first, Line | Arc):
        raise TypeError("a controller compensates lines and arcs only")
    (x, y), tangent = first.start, first.tangent(0.0)
    side = waste_side(shape.area, shape.is_hole)
    normal = (-side * tangent[1], side * tangent[0])
    touch = _touch(first, normal, radius)
    if touch is None:
        return None
    rise, beyond = touch
    beyond += MARGIN * kerf
    if length < rise + MARGIN * kerf or beyond > 0.9 * first.length:
        return None
    start = x + length * normal[0], y + length * normal[1]
    at = (
        x + radius * tangent[0] + rise * normal[0],
        y + radius * tangent[1] + rise * normal[1],
    )
    # Behind a corner the beam would end in the part.
    over = min(overcut_length(shape, torch), max(0.0, first.length / 2 - beyond - radius))
    again = stretch((first,), (first.length,), 0.0, beyond + over)
    return Entry(curves, (Line(start, first.start),), again), (start, at)


def _beam_at_end(entry: Entry, shape: Shape, kerf: float) -> Point:
    """Where the beam is when the torch stops: beside the end of what is cut again."""
    last = entry.lead_out[-1]
    (x, y), (tx, ty) = last.end, last.tangent(1.0)
    off = waste_side(shape.area, shape.is_hole) * kerf / 2
    return x - off * ty, y + off * tx


def _begun(curves: Curves, candidate: int) -> Curves:
    """A closed contour from the middle of its longest line on, or of the next longest curve."""
    if len(curves) == 1:
        return curves
    sizes = [(isinstance(c, Line), round(c.length, 6), -k) for k, c in enumerate(curves)]
    k = -sorted(sizes, reverse=True)[candidate][2]
    first, last = curves[k].split(0.5)
    return (last, *curves[k + 1 :], *curves[:k], first)


def _touch(first: Line | Arc, normal: Point, radius: float) -> tuple[float, float] | None:
    """How high above P the torch touches lead and contour, and how far along the contour.

    None where it does not fit between them.
    """
    if isinstance(first, Line):
        return radius, radius
    (x, y), (cx, cy) = first.start, first.centre
    is_inside = dot((cx - x, cy - y), normal) > 0.0
    middle = first.radius - radius if is_inside else first.radius + radius
    if middle <= radius * (1 + MARGIN):
        return None
    across = sqrt(middle * middle - radius * radius)
    rise = first.radius - across if is_inside else across - first.radius
    return rise, first.radius * asin(radius / middle)


def uncompensated(shape: Shape, kerf: float) -> Diagnostic:
    """The error for a contour with a curve that has no other one half a kerf beside it.

    That is one whose middle, moved so far into the waste, comes nearest to another place of the
    contour: an arc that is smaller than the tool, or a side between two corners.
    """
    import numpy as np
    import shapely

    side = waste_side(shape.area, shape.is_hole)
    contour = polylines_of([shape.curves], kerf / 1000)[0]
    curves = [curve for curve in shape.curves if curve.length > 0.0]
    points = []
    for curve in curves:
        (x, y), (tx, ty) = curve.point(0.5), curve.tangent(0.5)
        points.append((x - side * ty * kerf / 2, y + side * tx * kerf / 2))
    k = int(np.argmin(shapely.distance(shapely.points(points), contour)))
    x, y = curves[k].point(0.5)
    size = _size(curves[k])
    return rules.UNCOMPENSATED.at(
        shape.source, found=size, kerf=f"{kerf:g}", x=f"{x:.3f}", y=f"{y:.3f}"
    )


def _size(curve: Curve) -> str:
    if isinstance(curve, Arc):
        return f"an arc of radius {curve.radius:.3f} mm"
    (x0, y0), (x1, y1) = curve.start, curve.end
    return f"a side of {hypot(x1 - x0, y1 - y0):.3f} mm"
