"""Leads that stay in the waste: shortened, or left out, where a contour is too narrow for them."""

from collections.abc import Sequence
from typing import TYPE_CHECKING

from beamcam.errors import Diagnostic
from beamcam.geometry.curves import Curve
from beamcam.machine.torch import Torch
from beamcam.planning.contours import rules
from beamcam.planning.contours.lead_in import leads, waste_side
from beamcam.planning.contours.outline import ways as polylines_of
from beamcam.planning.contours.shape import Shape

if TYPE_CHECKING:
    from shapely import STRtree

#: The share of a lead that is not asked for its distance, at the contour.
AT_CONTOUR = 0.1

Lead = tuple[tuple[Curve, ...], tuple[Curve, ...]]  #: in and out
NO_LEADS: Lead = ((), ())

#: The shares of the machine's lengths that are tried, longest first.
SHARES = (1.0, 0.6, 0.35, 0.2)


def leads_of(
    ways: Sequence[Shape],
    overs: Sequence[tuple[Curve, ...]],
    torch: Torch,
    half_kerf: float,
    contours: Sequence[Shape],
) -> tuple[dict[int, Lead], list[Diagnostic]]:
    """The lead-ins and lead-outs of the shapes that need them and have room, and a remark."""
    import shapely

    found: dict[int, Lead] = {}
    if torch.lead == "none":
        return found, []
    waiting = [k for k, s in enumerate(ways) if s.process == "cut" and s.is_ring]
    sides = {k: waste_side(ways[k].area, ways[k].depth % 2 == 1) for k in waiting}
    # With a kerf the part's own contours must stay untouched, without one the ways as well.
    # What chords and rounding take of half a kerf is less than half of the tolerance.
    clearance = max(0.0, half_kerf - torch.tolerance / 2)
    fence = [s.curves for s in contours if s.process == "cut"]
    tree = shapely.STRtree(polylines_of(fence, torch.tolerance / 4))
    short: list[Shape] = []
    for share in SHARES:
        tried = {k: leads(ways[k].curves, sides[k], torch, share, overs[k]) for k in waiting}
        kept = _clear_of(tree, tried, torch.tolerance / 4, clearance)
        found |= {k: tried[k] for k in kept}
        waiting = [k for k in waiting if k not in kept]
        if share == SHARES[0]:
            short = [ways[k] for k in waiting]
    if not short:
        return found, []
    said = rules.NO_LEAD.at(short[0].source, count=len(short), found=f"{torch.lead_in:g}")
    return found, [said]


def _clear_of(
    tree: "STRtree", tried: dict[int, Lead], tolerance: float, clearance: float
) -> set[int]:
    """Those whose leads keep their distance from every contour of a tree.

    A lead is one line or arc. What of it is nearest to its contour touches that where there is no
    kerf, and is not asked.
    """
    outer, owners = [], []
    for k, (way_in, way_out) in tried.items():
        # All of them as they lead away from the contour.
        for curve in (*(c.reversed() for c in way_in), *way_out):
            share = AT_CONTOUR
            if clearance > 0.0:  # no farther than to where it would enter the part
                share = min(share, clearance / curve.length)
            outer.append((curve.split(share)[1],))
            owners.append(k)
    if not outer:
        return set(tried)
    lines = polylines_of(outer, tolerance)
    if clearance > 0.0:
        hit, _ = tree.query(lines, "dwithin", distance=clearance)
    else:
        hit, _ = tree.query(lines, "intersects")
    return set(tried) - {owners[h] for h in hit.tolist()}
