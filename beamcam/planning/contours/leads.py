"""Leads that stay in the waste: shortened, or left out, where a contour is too narrow for them."""

from collections.abc import Sequence

from beamcam.errors import Diagnostic
from beamcam.geometry.curves import Curve
from beamcam.machine.torch import Torch
from beamcam.planning.contours import rules
from beamcam.planning.contours.lead_in import leads, waste_side
from beamcam.planning.contours.outline import ways as polylines_of
from beamcam.planning.contours.shape import Shape

#: The share of a lead that is not asked for its distance, at the contour.
AT_CONTOUR = 0.1

Lead = tuple[tuple[Curve, ...], tuple[Curve, ...]]

#: The shares of the machine's lengths that are tried, longest first.
SHARES = (1.0, 0.6, 0.35, 0.2)


class Leads:
    """The lead-ins and lead-outs of the shapes that need them."""

    def __init__(
        self,
        ways: Sequence[Shape],
        overs: Sequence[tuple[Curve, ...]],
        torch: Torch,
        half_kerf: float,
        contours: Sequence[Shape],
    ) -> None:
        self._leads: dict[int, Lead] = {}
        self.remarks: list[Diagnostic] = []
        if torch.lead == "none":
            return
        waiting = [k for k, s in enumerate(ways) if s.process == "cut" and s.is_ring]
        sides = {k: waste_side(ways[k].area, ways[k].depth % 2 == 1) for k in waiting}
        # With a kerf the part's own contours must stay untouched, without one the ways as well.
        # What chords and rounding take of half a kerf is less than half of the tolerance.
        clearance = max(0.0, half_kerf - torch.tolerance / 2)
        fence = _Fence([s for s in contours if s.process == "cut"], torch, clearance)
        short: list[Shape] = []
        for share in SHARES:
            tried = {k: leads(ways[k].curves, sides[k], torch, share, overs[k]) for k in waiting}
            kept = fence.clear(tried, torch)
            self._leads |= {k: tried[k] for k in kept}
            if share == SHARES[0]:
                short = [ways[k] for k in waiting if k not in kept]
            waiting = [k for k in waiting if k not in kept]
        if short:
            self.remarks.append(
                rules.NO_LEAD.at(short[0].source, count=len(short), found=f"{torch.lead_in:g}")
            )

    def of(self, k: int) -> Lead:
        """Lead-in and lead-out of shape `k`; empty if there is none."""
        return self._leads.get(k, ((), ()))


class _Fence:
    """The contours of the part, which no lead may come near."""

    def __init__(self, contours: Sequence[Shape], torch: Torch, clearance: float) -> None:
        import shapely

        self._clearance = clearance
        self._tree = shapely.STRtree(
            polylines_of([shape.curves for shape in contours], torch.tolerance / 4)
        )

    def clear(self, tried: dict[int, Lead], torch: Torch) -> set[int]:
        """Those whose leads keep their distance from every contour.

        A lead is one line or arc. What of it is nearest to its contour touches that where there is
        no kerf, and is not asked.
        """
        leads, owners = [], []
        for k, (way_in, way_out) in tried.items():
            # All of them as they lead away from the contour.
            for curve in (*(c.reversed() for c in way_in), *way_out):
                share = AT_CONTOUR
                if self._clearance > 0.0:  # no farther than to where it would enter the part
                    share = min(share, self._clearance / curve.length)
                leads.append((curve.split(share)[1],))
                owners.append(k)
        if not leads:
            return set(tried)
        lines = polylines_of(leads, torch.tolerance / 4)
        if self._clearance > 0.0:
            hit, _ = self._tree.query(lines, "dwithin", distance=self._clearance)
        else:
            hit, _ = self._tree.query(lines, "intersects")
        return set(tried) - {owners[h] for h in hit.tolist()}
