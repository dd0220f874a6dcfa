"""Round openings of drawings that are smaller than a torch cuts, and what is drawn on them."""

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np
import shapely
from msgspec import Struct

from beamcam.geometry.curves import Curve
from beamcam.geometry.plane import Point
from beamcam.machine.torch import Torch
from beamcam.model.drawing import extent
from beamcam.verify.sheets.region import Region, region_of
from beamcam.verify.sheets.toolpaths import Toolpaths

if TYPE_CHECKING:
    from shapely import Polygon


class SmallOpening(Struct, frozen=True):
    """A round opening of a drawing."""

    middle: Point
    features: tuple[int, ...]  #: that draw it
    twins: tuple[int, ...]  #: that draw it again


def small_openings(
    toolpaths: Toolpaths, ways: Sequence[Curve], owners: Sequence[int], drawn: Sequence[int],
    torch: Torch, least: float,
) -> list[SmallOpening]:  # fmt: skip
    """The openings among the cuts that are circles of less than `least`, by the ways `drawn`.

    An opening is what an odd number of contours enclose, or what lies within one that is too small.
    `owners` are the features of the `ways`.
    """
    region = region_of(toolpaths, np.array(owners), torch.gap, torch.tolerance / 8)
    found = []
    for number, middle in _openings(region, ways, torch.tolerance, least).items():
        mine = sorted({owners[way] for way, _ in region.rings[number]})
        hole = shapely.box(*shapely.bounds(shapely.buffer(region.polygons[number], torch.gap)))
        twins = (k for k in drawn if region.twins[k] and hole.contains(shapely.box(*ways[k].bbox)))
        found.append(SmallOpening(middle, tuple(mine), tuple(owners[k] for k in twins)))
    return found


def _openings(
    region: Region, ways: Sequence[Curve], tolerance: float, least: float
) -> dict[int, Point]:
    """The middles of the rings that are small round openings, by the rings' numbers."""
    found: dict[int, Point] = {}
    for number, polygon in enumerate(region.polygons):
        circle = _circle(polygon, [ways[k] for k, _ in region.rings[number]], tolerance)
        if circle is not None and circle[1] < least:
            found[number] = circle[0]
    areas = shapely.area(region.polygons)
    openings = {
        k for k, middle in found.items()
        if np.count_nonzero(
            shapely.contains(region.polygons[areas > areas[k]], shapely.Point(middle))
        ) % 2
    }  # fmt: skip
    outer = [shapely.buffer(region.polygons[k], tolerance) for k in openings]
    openings |= {k for k in found if any(o.contains(region.polygons[k]) for o in outer)}
    return {k: found[k] for k in sorted(openings)}


def _circle(
    polygon: "Polygon", curves: Sequence[Curve], tolerance: float
) -> tuple[Point, float] | None:
    """Middle and diameter of an outline that is a circle, whatever curves draw it.

    By the curves, as the chords of a circle are within it.
    """
    corners = np.asarray(polygon.exterior.coords)
    x0, y0, x1, y1 = extent(curves) or (0.0, 0.0, 0.0, 0.0)
    across, along = x1 - x0, y1 - y0
    if abs(across - along) > 2 * tolerance:
        return None
    middle, radius = np.array([x0 + x1, y0 + y1]) / 2, (across + along) / 4
    places = np.concatenate((corners, (corners[1:] + corners[:-1]) / 2))
    if np.abs(np.hypot(*(places - middle).T) - radius).max() > tolerance:
        return None
    x, y = middle.tolist()
    return (x, y), 2 * radius
