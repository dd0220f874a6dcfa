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
from math import asin, sqrt

import shapely

from beamcam.errors import Diagnostic
from beamcam.geometry.curves import Arc, Line
from beamcam.geometry.plane import Point, dot
from beamcam.machine.torch import Torch
from beamcam.planning.contours import rules
from beamcam.planning.contours.kerf import Lead, overcut_length
from beamcam.planning.contours.outline import Curves, Shape, stretch, waste_side
from beamcam.planning.contours.outline import ways as polylines_of

#: The shares of the machine's length of a lead that are tried, longest first.
SHARES = (1.0, 0.8, 0.6, 0.45, 0.35, 0.25)

#: So many of the longest curves of a contour are tried to begin on.
CANDIDATES = 4

#: What a lead is longer than it has to be, and what is cut twice, as a share of the kerf.
MARGIN = 0.05


#: A closed contour, begun where there is room for its lead, and that: it ends beyond the start.
Entry = tuple[Curves, Lead]


def entries(
    shapes: Sequence[Shape], kerfs: Sequence[float], torch: Torch, fence: Sequence[Shape]
) -> tuple[dict[int, Entry], list[Diagnostic]]:
    """The entry of each compensated shape, and errors for those without one.

    No lead comes nearer than half a kerf to a contour of the `fence`.
    """
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
            # The beam stops beside the end of what is cut again.
            ends = []
            for k, ((_, (_, again)), _) in tried.items():
                (x, y), (tx, ty) = again[-1].end, again[-1].tangent(1.0)
                off = waste_side(shapes[k].area, shapes[k].is_hole) * kerfs[k] / 2
                ends.append((x - off * ty, y + off * tx))
            stops = shapely.points(ends)
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
    curves = shape.curves
    if candidate >= len(curves):
        return None
    if len(curves) > 1:  # from the middle of its longest line on, or of the next longest curve
        sizes = [(isinstance(c, Line), round(c.length, 6), -k) for k, c in enumerate(curves)]
        k = -sorted(sizes, reverse=True)[candidate][2]
        before, behind = curves[k].split(0.5)
        curves = (behind, *curves[k + 1 :], *curves[:k], before)
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
    return (curves, ((Line(start, first.start),), again)), (start, at)


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
