"""Round openings and slots of drawings that are smaller than a torch cuts."""

from collections.abc import Collection, Sequence
from math import pi

import numpy as np
import shapely
from msgspec import Struct

from beamcam.checks.asked import by_hand, left_out
from beamcam.checks.sheets.need import OUTLINE, Need, not_made, thickness_of
from beamcam.checks.sheets.region import Region
from beamcam.geometry.array_types import Floats
from beamcam.geometry.curves import Arc, Curve, Line
from beamcam.geometry.plane import Point
from beamcam.machine.machine import Machine
from beamcam.machine.torch import Torch
from beamcam.model.part import Contour, Part, extent

SAME_SIZE = 1e-6  #: mm, that an opening may be below the least by its last digits


class SmallOpening(Struct, frozen=True):
    """A round opening or a slot of a drawing."""

    centres: tuple[Point, ...]  #: of a slot those of its ends
    features: tuple[int, ...]  #: that draw it
    twins: tuple[int, ...]  #: that draw it again


def leave_small_openings(
    need: Need, part: Part, machine: Machine, torch: Torch, skips: Collection[str]
) -> None:
    """Have openings of drawings that the torch cannot cut marked for the drill, or left out."""
    least = max(torch.min_hole, torch.min_hole_share * thickness_of(part, torch))
    if not least or not need.curves.get("cut"):
        return
    left: set[int] = set()
    for opening in _small_openings(need, part, torch, least):
        left.update(opening.features, opening.twins)
        for index in opening.features:
            feature = part.features[index]
            if torch.drilled != "refuse":
                need.said.append(by_hand(feature, part, machine))
                for place in opening.centres:
                    need.add_centre(place, torch, index, feature.source)
            elif (lack := "slot" if len(opening.centres) > 1 else "tool") in skips:
                need.said += left_out(part, (index,))
            else:
                not_made(need, part, feature, lack)
    if left:
        need.without_cuts(left)


def _small_openings(need: Need, part: Part, torch: Torch, least: float) -> list[SmallOpening]:
    """The openings among the cuts that are circles or slots narrower than `least`, by their ways.

    An opening is what an odd number of contours enclose, or what lies within one that is too small.
    """
    region, ways, owners = need.region(torch), need.curves["cut"], need.features["cut"]
    is_drawn = [k != OUTLINE and isinstance(part.features[k], Contour) for k in owners]
    twins = [k for k in np.flatnonzero(region.twins).tolist() if is_drawn[k]]
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
    if not found:
        return {}
    rings = np.array(list(found), dtype=np.int64)
    middles = shapely.points([centres[0] for centres in found.values()])
    own, around_it = shapely.STRtree(region.polygons).query(middles, "within")
    larger = areas[around_it] > areas[rings[own]]
    openings = rings[np.bincount(own[larger], minlength=len(rings)) % 2 == 1]
    wider = shapely.STRtree(shapely.buffer(region.polygons[openings], tolerance))
    inside, _ = wider.query(region.polygons[rings], "covered_by")
    return {k: found[k] for k in sorted({*openings.tolist(), *rings[inside].tolist()})}


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
