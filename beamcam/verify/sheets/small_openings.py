"""Round openings and slots of drawings that are smaller than a torch cuts."""

from collections.abc import Sequence
from math import pi

import numpy as np
import shapely
from msgspec import Struct

from beamcam.geometry.array_types import Floats
from beamcam.geometry.curves import Curve, Line
from beamcam.geometry.plane import Point
from beamcam.machine.torch import Torch
from beamcam.model.part import extent
from beamcam.verify.sheets.region import Region, region_of
from beamcam.verify.sheets.toolpaths import Toolpaths

SAME_SIZE = 1e-6  #: mm, that an opening may be below the least by its last digits


class SmallOpening(Struct, frozen=True):
    """A round opening or a slot of a drawing."""

    centres: tuple[Point, ...]  #: of a slot those of its ends
    features: tuple[int, ...]  #: that draw it
    twins: tuple[int, ...]  #: that draw it again


def small_openings(
    toolpaths: Toolpaths, ways: Sequence[Curve], owners: Sequence[int], drawn: Sequence[int],
    torch: Torch, least: float,
) -> list[SmallOpening]:  # fmt: skip
    """The openings among the cuts that are circles or slots narrower than `least`, by their ways.

    An opening is what an odd number of contours enclose, or what lies within one that is too small.
    `owners` are the features of the `ways`, `drawn` those of contours.
    """
    region = region_of(toolpaths, np.array(owners), torch.gap, torch.tolerance / 8)
    found = []
    for number, centres in _openings(region, ways, torch.tolerance, least).items():
        mine = sorted({owners[way] for way, _ in region.rings[number]})
        hole = shapely.box(*shapely.bounds(shapely.buffer(region.polygons[number], torch.gap)))
        twins = (k for k in drawn if region.twins[k] and hole.contains(shapely.box(*ways[k].bbox)))
        found.append(SmallOpening(centres, tuple(mine), tuple(owners[k] for k in twins)))
    return found


def _openings(
    region: Region, ways: Sequence[Curve], tolerance: float, least: float
) -> dict[int, tuple[Point, ...]]:
    """The centres of the rings that are small openings, by the rings' numbers."""
    found: dict[int, tuple[Point, ...]] = {}
    areas = shapely.area(region.polygons)
    around = shapely.length(region.polygons)
    # A slot that has this area and this length all round is as wide as this; chords make it less.
    widths = (around - np.sqrt(np.maximum(around**2 - 4 * pi * areas, 0.0))) / pi
    for number in np.flatnonzero(widths < least + tolerance).tolist():
        curves = [ways[k] for k, _ in region.rings[number]]
        corners = np.asarray(region.polygons[number].exterior.coords)
        if centres := _centres(corners, curves, tolerance, least):
            found[number] = centres
    openings = {
        k for k, (middle, *_) in found.items()
        if np.count_nonzero(
            shapely.contains(region.polygons[areas > areas[k]], shapely.Point(middle))
        ) % 2
    }  # fmt: skip
    outer = [shapely.buffer(region.polygons[k], tolerance) for k in openings]
    openings |= {k for k in found if any(o.contains(region.polygons[k]) for o in outer)}
    return {k: found[k] for k in sorted(openings)}


def _centres(
    corners: Floats, curves: Sequence[Curve], tolerance: float, least: float
) -> tuple[Point, ...]:
    """The centres of an outline that is a circle or a slot below `least`; none if it is neither.

    Its box is that of its curves, as chords of a circle are within it; of one with straight sides
    that along the longest of them.
    """
    sides = [curve for curve in curves if isinstance(curve, Line)]
    ux, uy = max(sides, key=lambda side: side.length).tangent(0.0) if sides else (1.0, 0.0)
    axes = np.array([[ux, uy], [-uy, ux]])
    turned = [curve.transformed(((ux, uy, 0.0), (-uy, ux, 0.0))) for curve in curves]
    low, high = np.array(extent(turned) or (0.0, 0.0, 0.0, 0.0)).reshape(2, 2)
    long, wide = (high - low).tolist()
    if abs(long - wide) <= 2 * tolerance:
        long = wide = (long + wide) / 2
    if wide > long or wide >= least - SAME_SIZE:
        return ()
    middle = (low + high) / 2
    far = middle + np.array([[-1.0, 0.0], [1.0, 0.0]]) * (long - wide) / 2
    line = shapely.LineString(far @ axes)
    places = np.concatenate((corners, (corners[1:] + corners[:-1]) / 2))
    off = np.abs(shapely.distance(shapely.points(places), line) - wide / 2)
    if off.max() > tolerance:
        return ()
    ends: list[list[float]] = np.unique(far @ axes, axis=0).tolist()
    return tuple((x, y) for x, y in ends)
