"""Round openings and slots of drawings that are smaller than a torch cuts."""

from collections.abc import Sequence
from math import pi

import numpy as np
import shapely
from msgspec import Struct

from beamcam.checks.sheets.region import Region
from beamcam.geometry.array_types import Floats
from beamcam.geometry.curves import Arc, Curve, Line
from beamcam.geometry.plane import Point
from beamcam.machine.torch import Torch
from beamcam.model.part import extent

SAME_SIZE = 1e-6  #: mm, that an opening may be below the least by its last digits


class SmallOpening(Struct, frozen=True):
    """A round opening or a slot of a drawing."""

    centres: tuple[Point, ...]  #: of a slot those of its ends
    features: tuple[int, ...]  #: that draw it
    twins: tuple[int, ...]  #: that draw it again


def small_openings(
    region: Region, ways: Sequence[Curve], owners: Sequence[int], drawn: Sequence[bool],
    torch: Torch, least: float,
) -> list[SmallOpening]:  # fmt: skip
    """The openings among the cuts that are circles or slots narrower than `least`, by their ways.

    An opening is what an odd number of contours enclose, or what lies within one that is too small.
    `owners` are the features of the `ways`, `drawn` tells which of them are contours.
    """
    twins = [k for k in np.flatnonzero(region.twins).tolist() if drawn[k]]
    openings = []
    for number, centres in _openings(region, ways, torch.tolerance, least).items():
        mine = sorted({owners[way] for way, _ in region.rings[number]})
        hole = shapely.box(*shapely.bounds(shapely.buffer(region.polygons[number], torch.gap)))
        again = [owners[k] for k in twins if hole.contains(shapely.box(*ways[k].bbox))]
        openings.append(SmallOpening(centres, tuple(mine), tuple(again)))
    return openings


def _openings(
    region: Region, ways: Sequence[Curve], tolerance: float, least: float
) -> dict[int, tuple[Point, ...]]:
    """The centres of the rings that are small openings, by the rings' numbers."""
    round_ended: dict[int, tuple[Point, ...]] = {}
    areas = shapely.area(region.polygons)
    around = shapely.length(region.polygons)
    # A slot that has this area and this length all round is as wide as this; chords make it less.
    widths = (around - np.sqrt(np.maximum(around**2 - 4 * pi * areas, 0.0))) / pi
    narrow = np.flatnonzero(widths < least + tolerance)
    x0, y0, x1, y1 = shapely.bounds(region.polygons[narrow]).reshape(-1, 4).T
    # The middle of a circle or a slot lies in it, and in what is around it.
    middles = shapely.points((x0 + x1) / 2, (y0 + y1) / 2)
    own, around_it = shapely.STRtree(region.polygons).query(middles, "within")
    own = own[areas[around_it] > areas[narrow[own]]]
    for k in sorted(set(own.tolist())):
        number = int(narrow[k])
        curves = [ways[way] for way, _ in region.rings[number]]
        corners = np.asarray(region.polygons[number].exterior.coords)
        if centres := _centres(corners, curves, tolerance, least):
            round_ended[number] = centres
    if not round_ended:
        return {}
    rings = np.array(list(round_ended), dtype=np.int64)
    larger = np.bincount(own, minlength=len(narrow))[np.searchsorted(narrow, rings)]
    openings = rings[larger % 2 == 1]
    wider = shapely.STRtree(shapely.buffer(region.polygons[openings], tolerance))
    inside, _ = wider.query(region.polygons[rings], "covered_by")
    return {k: round_ended[k] for k in sorted({*openings.tolist(), *rings[inside].tolist()})}


def _centres(
    corners: Floats, curves: Sequence[Curve], tolerance: float, least: float
) -> tuple[Point, ...]:
    """The centres of an outline that is a circle or a slot below `least`; none if it is neither.

    Its box is that of its curves, as chords of a circle are within it; of one with straight sides
    that along the longest of them.
    """
    if len(curves) == 1 and isinstance(circle := curves[0], Arc) and abs(circle.sweep_deg) == 360.0:
        return (circle.centre,) if 2 * circle.radius < least - SAME_SIZE else ()
    sides = [curve for curve in curves if isinstance(curve, Line)]
    ux, uy = max(sides, key=lambda side: side.length).tangent(0.0) if sides else (1.0, 0.0)
    axes = np.array([[ux, uy], [-uy, ux]])
    if float(np.ptp(corners @ axes[1])) >= least:
        return ()
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
