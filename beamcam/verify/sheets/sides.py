"""On which side of its path a contour lies: the kerf is taken from the waste."""

from collections.abc import Sequence
from typing import cast

import numpy as np
import shapely
from numpy.typing import NDArray

from beamcam.errors import Diagnostic, Source
from beamcam.verify.sheets import rules
from beamcam.verify.sheets.contours import Covered
from beamcam.verify.sheets.elements import Counts
from beamcam.verify.sheets.work import SHOWN, Traced, Work


def polygon_of(t: Traced) -> object:
    """The inside of the ring of a stroke, None if it has none; made once."""
    if t.inside is None and t.ring:
        points = np.concatenate([t.path.outline(first, last, t.fine) for first, last in t.ring])
        if len(points) > 3:
            polygon = shapely.Polygon(points)
            t.inside = polygon if polygon.is_valid else shapely.make_valid(polygon)
    return t.inside


def side_faults(
    work: Work, traced: Sequence[Traced], leader: Counts, covered: Covered
) -> list[Diagnostic]:
    """Contours that lie on the wrong side of the path beside them."""
    by_machine = work.torch.kerf_by == "machine" and work.process == "cut"
    if not by_machine and not any(t.half_kerf for t in traced):
        return []
    depths = _depths([polygon_of(t) for t in traced])
    said: list[Diagnostic] = []
    stroke = leader[work.of_way[covered.way]]
    order = np.argsort(stroke, kind="stable")
    bounds = np.searchsorted(stroke[order], np.arange(len(traced) + 1)).tolist()
    for k, t in enumerate(traced):
        if t.inside is None:
            continue
        is_hole = depths[k] % 2 == 1
        if by_machine:
            said += _kept_side(work, t, is_hole)
        mine = covered.points[order[bounds[k] : bounds[k + 1]]]
        if t.half_kerf == 0.0 or not len(mine):
            continue
        wrong = np.flatnonzero(shapely.contains_xy(t.inside, mine) == is_hole)
        if len(wrong):
            x, y = mine[wrong[0]].tolist()
            source = Source(work.name, t.stroke.line)
            said.append(rules.SIDE.at(source, x=f"{x:.3f}", y=f"{y:.3f}"))
    return said[:SHOWN]


def _kept_side(work: Work, t: Traced, is_hole: bool) -> list[Diagnostic]:
    """Whether the controller is told to keep on the side of the waste, by half the kerf."""
    ring = t.path.outline(t.first, t.last, t.fine)
    left_turning = bool(shapely.is_ccw(shapely.LinearRing(ring)))
    expected = "left" if left_turning == is_hole else "right"
    half = t.stroke.row.kerf / 2
    if not half or (t.stroke.side == expected and abs(t.stroke.radius - half) <= 1e-4):
        return []
    return [
        rules.TOOL.at(
            Source(work.name, t.stroke.line),
            found=f"compensation {t.stroke.side} by {t.stroke.radius:g}",
            expected=f"{expected} by {half:g}",
        )
    ]


def _depths(polygons: Sequence[object]) -> list[int]:
    """How many other polygons each lies in."""
    known = [k for k, p in enumerate(polygons) if p is not None]
    depths = [0] * len(polygons)
    if not known:
        return depths
    shapes = cast("NDArray[np.object_]", np.array([polygons[k] for k in known], dtype=object))
    areas = shapely.area(shapes)
    inner, outer = shapely.STRtree(shapes).query(shapely.point_on_surface(shapes), "within")
    for a, b in zip(inner.tolist(), outer.tolist(), strict=True):
        if a != b and areas[a] < areas[b]:
            depths[known[a]] += 1
    return depths
