"""Where strokes run: half a kerf off a contour of their wall, on any of its surfaces."""

from collections.abc import Mapping
from typing import Any

from beamcam.checks.coping.section import line_of, narrowed
from beamcam.checks.coping.stock import FINE
from beamcam.checks.coping.strokes import TorchStroke

Shape = Any  #: of shapely


class ContourBand:
    """Where a stroke runs that keeps half a kerf off a contour, as the torch sees it."""

    def __init__(self, wanted: Shape, kerf: float, share: float, slack: float) -> None:
        from shapely import prepare

        self._seen, self._off = narrowed(wanted, share).simplify(FINE / 2), kerf / 2 + slack
        self._along = self._seen.boundary.buffer(self._off)
        prepare(self._along)

    def off(self, run: Shape) -> Shape:
        """What of a path lies elsewhere."""
        from shapely import Polygon

        if self._along.covers(run):
            return Polygon()
        # At an edge of its wall a path goes straight on beyond the end of a slanting contour.
        around = self._seen.buffer(self._off, join_style="mitre").difference(self._seen)
        return run.difference(self._along).difference(around)


def extra_at(
    stroke: TorchStroke,
    beside: Mapping[tuple[float, float, float], ContourBand],
    steel: Shape,
    slack: float,
) -> tuple[float, float] | None:
    """A place of a stroke that runs along the contour of no surface; None where it does of one."""
    first: tuple[float, float] | None = None
    for (depth, *view), near in beside.items():
        if view == [stroke.row.kerf, stroke.share]:
            off = _off_contour(stroke, near, depth, steel, slack)
            if off is None:
                return None
            first = first or off
    return first


def _off_contour(
    stroke: TorchStroke, near: ContourBand, depth: float, steel: Shape, slack: float
) -> tuple[float, float] | None:
    """A place of a stroke that keeps no half a kerf off a contour so far below; None if there is
    none.

    Its first stretch is the lead, and beyond the edges of the wall there is air.
    """
    share = stroke.share
    run = narrowed(line_of(stroke.at(depth)[1:]).intersection(steel), share)
    off = near.off(run)
    if off.length <= slack:
        return None
    x, y = off.representative_point().coords[0]
    return x / share, y
