"""Small holes, which are cut slower, and everything else, which is not."""

from collections.abc import Iterator, Sequence
from math import pi

from beamcam.errors import Diagnostic, Source
from beamcam.verify.sheets import rules
from beamcam.verify.sheets.tabs import ring_depths
from beamcam.verify.sheets.work import SHOWN, Traced, Work

ROUND_DOUBT = 2e-3  #: of the way round a hole, by which it may be a small one or not


def hole_faults(work: Work, traced: Sequence[Traced]) -> Iterator[Diagnostic]:
    """Strokes that run as in a small hole elsewhere, or in one as elsewhere."""
    if not any(s.row.slows_holes for s in work.strokes):
        return
    rings = [t for t in traced if t.members or (t.contour is not None and not t.joined)]
    polygons = [t.inside() for t in rings]
    small: dict[int, bool | None] = {}  #: by stroke; None: as good as either
    for t, polygon, depth in zip(rings, polygons, ring_depths(polygons), strict=True):
        row = t.stroke.row
        around = polygon.length if polygon is not None else 0.0
        limit, doubt = pi * row.hole_diameter, ROUND_DOUBT * around + 8 * work.tolerance
        is_small: bool | None = around < limit and depth is not None and depth % 2 == 1
        if depth is None or (depth % 2 == 1 and abs(around - limit) <= doubt):
            is_small = None
        small |= {id(one.stroke): is_small for one in t.members or [t]}
    told = 0
    for t in traced:
        expected, found = small.get(id(t.stroke), False), t.stroke.in_hole
        if expected is None or found is None or expected == found or not t.stroke.row.slows_holes:
            continue
        told += 1
        if told <= SHOWN:
            share = f"{t.stroke.row.hole_feed_share * 100:g} %"
            contour = work.contour_at(work.path.starts[t.first])
            yield rules.HOLE_FEED.at(
                Source(work.name, t.stroke.line), contour=contour,
                found=share if found else "all", expected=share if expected else "all",
            )  # fmt: skip
