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

Curves = tuple[Curve, ...]
Lead = tuple[Curves, Curves]  #: in and out
NO_LEADS: Lead = ((), ())

#: The shares of the machine's lengths that are tried, longest first.
SHARES = (1.0, 0.6, 0.35, 0.2)


def leads_of(
    ways: Sequence[Shape],
    overs: Sequence[Curves],
    torch: Torch,
    half_kerf: float,
    pierce_radius: float,
    contours: Sequence[Shape],
) -> tuple[dict[int, Lead], list[Diagnostic]]:
    """The lead-ins and lead-outs of the shapes that need them and have room, and a remark.

    The torch pierces at least `pierce_radius` from every contour. Where no lead-in begins as far
    off, it is as long as there is room for.
    """
    import shapely

    if torch.lead == "none":
        return {}, []
    asked = [k for k, s in enumerate(ways) if s.process == "cut" and s.is_ring]
    sides = {k: waste_side(ways[k].area, ways[k].depth % 2 == 1) for k in asked}
    # With a kerf the part's own contours must stay untouched, without one the ways as well.
    # What chords and rounding take of half a kerf is less than half of the tolerance.
    clearance = max(0.0, half_kerf - torch.tolerance / 2)
    fence = [s.curves for s in contours if s.process == "cut"]
    tree = shapely.STRtree(polylines_of(fence, torch.tolerance / 4))
    ways_in: dict[int, Curves] = {}
    ways_out: dict[int, Curves] = {}
    short: set[int] = set()
    # Each for itself, so that a way out without room does not shorten the way in.
    for found, is_out, far in (
        (ways_in, False, pierce_radius), (ways_in, False, 0.0), (ways_out, True, 0.0),
    ):  # fmt: skip
        for share in SHARES:
            tried = {
                k: leads(ways[k].curves, sides[k], torch, share, overs[k])[is_out]
                for k in asked
                if k not in found
            }
            kept = _clear_of(tree, tried, is_out, torch.tolerance, clearance, far)
            if share == SHARES[0]:
                short |= tried.keys() - kept
            found |= {k: tried[k] for k in kept}
    led = {k: (ways_in.get(k, ()), ways_out.get(k, ())) for k in asked}
    if not short:
        return led, []
    first = ways[min(short)].source
    return led, [rules.NO_LEAD.at(first, count=len(short), found=f"{torch.lead_in:g}")]


def _clear_of(
    tree: "STRtree",
    tried: dict[int, Curves],
    is_out: bool,
    tolerance: float,
    clearance: float,
    far: float,
) -> set[int]:
    """Those whose leads keep `clearance` from every contour of a tree, and their ends `far`.

    A lead is one line or arc. What of it is nearest to its contour touches that where there is no
    kerf, and is not asked.
    """
    import shapely

    owners, away, ends = [], [], []
    for k, curves in tried.items():
        for curve in curves if is_out else (c.reversed() for c in curves):
            share = AT_CONTOUR
            if clearance > 0.0:  # no farther than to where it would enter the part
                share = min(share, clearance / curve.length)
            owners.append(k)
            away.append((curve.split(share)[1],))
            ends.append(curve.end)
    if not owners:
        return set(tried)
    lines = polylines_of(away, tolerance / 4)
    if clearance > 0.0:
        hit = tree.query(lines, "dwithin", distance=clearance)[0].tolist()
    else:
        hit = tree.query(lines, "intersects")[0].tolist()
    if far > 0.0:
        apart = far - tolerance / 2
        hit += tree.query(shapely.points(ends), "dwithin", distance=apart)[0].tolist()
    return set(tried) - {owners[h] for h in hit}
