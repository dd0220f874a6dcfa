"""In which direction contours are cut: as they are drawn, or with the material at one side.

A swirling plasma bevels the side of its cut that is left of the head more than the right one: cut
the other way round, the bevel is on the part.
"""

from collections.abc import Sequence

import numpy as np
import shapely
from msgspec.structs import replace

from beamcam.errors import Diagnostic, Source
from beamcam.geometry.array_types import Counts, Floats
from beamcam.verify.sheets import rules
from beamcam.verify.sheets.joining import Chain
from beamcam.verify.sheets.region import region_of
from beamcam.verify.sheets.sides import waste_sides
from beamcam.verify.sheets.work import MITRE, SHOWN, Traced, Work

ASKED = 8  #: places of a stroke where it is asked which contour it follows
MIN_WIDTH = 1e-3  #: mm, half of it on an average, of what a ring goes round


def direction_faults(work: Work, traced: Sequence[Traced]) -> list[Diagnostic]:
    """Closed cuts that go round their contour the wrong way."""
    # A beam that the controller leads comes to its contour half a kerf behind the start.
    led = work.torch.kerf_by == "machine"
    heads = [t for t in traced if t.members or (led and t.contour is not None)]
    if work.process != "cut" or not heads or not work.need.count:
        return []
    if work.region is None:
        features = np.array(work.asked.features[work.process])
        region = region_of(work.need, features, work.torch.gap, work.fine)
        work = replace(work, region=region)
    assert work.region is not None
    asked = _asked(work)
    said = []
    for t, ring in zip(heads, _rings_of(work, heads).tolist(), strict=True):
        wanted = asked[ring] if ring >= 0 else None
        found = _is_anticlockwise(work, t)
        if wanted is None or found is None or found == wanted:
            continue
        said.append(
            rules.DIRECTION.at(
                Source(work.name, t.stroke.line), found=_shown(found), expected=_shown(wanted),
                contour=work.contour(work.region.rings[ring][0][0]), how=work.torch.direction,
            )
        )  # fmt: skip
    return said[:SHOWN]


def _shown(is_anticlockwise: bool) -> str:
    return "counter-clockwise" if is_anticlockwise else "clockwise"


def _asked(work: Work) -> list[bool | None]:
    """Of each ring whether it is to be followed counter-clockwise; None if that is left open."""
    assert work.region is not None
    rings, polygons = work.region.rings, work.region.polygons
    turned = [_area(np.array(polygon.exterior.coords)) > 0.0 for polygon in polygons]
    # Of contours that cross, neither lies inside of the other.
    clear = shapely.is_valid(polygons)
    crossing, _ = shapely.STRtree(polygons[clear]).query(polygons[clear], "overlaps")
    clear[np.flatnonzero(clear)[crossing]] = False
    way = work.torch.direction
    sides = waste_sides(work) if way != "drawn" else np.zeros(0)
    found: list[bool | None] = []
    for ring, is_turned, is_clear in zip(rings, turned, clear.tolist(), strict=True):
        if way == "drawn":
            found.append(is_turned if _is_one_feature(work, ring) else None)
            continue
        first, back = ring[0]
        waste_left = bool((sides[first] > 0.0) != back)
        # With climb the waste is on the left: counter-clockwise where it lies inside.
        is_hole = waste_left == is_turned
        found.append(is_hole == (way == "climb") if is_clear and sides[first] else None)
    return found


def _is_one_feature(work: Work, ring: Chain) -> bool:
    """Whether a ring is one feature as it is drawn, and no other curve lies on it.

    Of curves that are joined, and of what is drawn twice, any direction is one that is drawn.
    """
    assert work.region is not None
    ways = np.array([way for way, _ in ring])
    features = np.array(work.asked.features[work.process])
    own = features[ways[0]]
    if any(back for _, back in ring) or (features[ways] != own).any():
        return False
    low, high = work.need.boxes
    twins = np.flatnonzero(work.region.twins)
    least, most = low[ways].min(axis=0), high[ways].max(axis=0)
    beside = np.all((high[twins] >= least) & (low[twins] <= most), axis=1)
    return not beside.any()


def _rings_of(work: Work, heads: Sequence[Traced]) -> Counts:
    """The ring that each stroke follows at most of the places where it is asked; -1 for none."""
    assert work.region is not None
    ring_of = np.full(work.need.count, -1)
    for k, ring in enumerate(work.region.rings):
        ring_of[[way for way, _ in ring]] = k
    ways = [np.unique(np.linspace(t.first, t.last - 1, ASKED).astype(np.int64)) for t in heads]
    owner = np.repeat(np.arange(len(heads)), [len(own) for own in ways])
    every = np.concatenate(ways)
    places = work.path.point(every, work.path.lengths[every] / 2)
    most = float(work.slack.max(initial=0.0))
    reaches = (work.half_kerf + most, MITRE * work.half_kerf + 2 * most)
    away, nearest, _ = work.need.nearest_within(places, reaches, ring_of >= 0)
    rings = np.where(np.isfinite(away), ring_of[nearest], -1)
    found = np.full(len(heads), -1)
    for k in range(len(heads)):
        own = rings[owner == k]
        kinds, times = np.unique(own[own >= 0], return_counts=True)
        if len(kinds) and 2 * times.max() > len(own):
            found[k] = kinds[np.argmax(times)]
    return found


def _is_anticlockwise(work: Work, head: Traced) -> bool | None:
    """The turn of strokes that go round a contour together; None of what has no inside."""
    points = np.concatenate(
        [work.path.outline(m.first, m.last, work.fine) for m in head.members or [head]]
    )
    if len(points) < 3:
        return None
    area = _area(points)
    length = float(np.hypot(*np.diff(points, axis=0, append=points[:1]).T).sum())
    return None if abs(area) <= MIN_WIDTH * length else area > 0.0


def _area(points: Floats) -> float:
    """What a ring encloses, above 0 counter-clockwise."""
    x, y = (points - points[0]).T
    return float((x * np.roll(y, -1) - np.roll(x, -1) * y).sum()) / 2
