"""The band that a beam sweeps, which must stay out of the part.

A beam of radius r along a path takes away every point that is at most r from the path. So it takes
nothing of the part if the path lies in the waste, and no closed contour is nearer to it than r.
That is asked of the whole path, its leads too, and of every contour, not at samples: both are
chords at most `fine` off (an eighth of the machine's tolerance), so that a beam is refused that
takes more than the tolerance, the rounding of the program's numbers and 3 `fine`, in all 1.4 times
the tolerance and two steps of the last decimal. No buffer is drawn, so there are no quadrants of
it to add an error.
"""

from collections.abc import Sequence

import numpy as np
import shapely
from numpy.typing import NDArray

from beamcam.errors import Diagnostic, Source
from beamcam.geometry.array_types import Counts, Flags, Floats
from beamcam.verify.sheets import rules
from beamcam.verify.sheets.paths import on_contour
from beamcam.verify.sheets.work import SHOWN, Traced, Work


def band_faults(work: Work, traced: Sequence[Traced]) -> list[Diagnostic]:
    """Places where the beam cuts into the part."""
    if work.region is None:
        return []
    keeps_off = np.array([t.half_kerf > 0.0 for t in traced])
    said = _bites(work, traced, keeps_off)
    places = work.path.starts[[t.first for t in traced]]
    for k in np.flatnonzero(keeps_off & work.region.in_part(places))[:SHOWN].tolist():
        # For a kerf that is less than what a path may be off, no side is judged.
        away, way = work.need.nearest_to(places[k])
        if away <= work.slack[way]:
            continue
        x, y = places[k].tolist()
        source = Source(work.name, traced[k].stroke.line)
        said.append(rules.SIDE.at(source, x=f"{x:.3f}", y=f"{y:.3f}", contour=work.contour(way)))
    return said


def _bites(work: Work, traced: Sequence[Traced], keeps_off: Flags) -> list[Diagnostic]:
    """The first place of each stroke that is nearer to a closed contour than half a kerf."""
    assert work.region is not None
    closed = np.flatnonzero(work.region.closed & ~work.region.twins)
    strokes = np.flatnonzero(keeps_off)
    if not len(closed) or not len(strokes):
        return []
    points, begins = work.need.outlines(work.fine)
    contours = _lines(points, np.repeat(np.arange(work.need.count), np.diff(begins)))[closed]
    points, begins = work.path.outlines(work.fine)
    ways = _lines(points, np.repeat(work.of_way, np.diff(begins)))[strokes]
    least = work.half_kerf - work.slack[closed] - 2 * work.fine
    a, b = shapely.STRtree(contours).query(ways, "dwithin", distance=float(least.max()))
    away = shapely.distance(ways[a], contours[b])
    hit = np.flatnonzero(away < least[b])
    _, firsts = np.unique(a[hit], return_index=True)
    is_ring = on_contour(work, traced)
    said = []
    for k in hit[firsts][:SHOWN].tolist():
        # The place on the path, and the line that leads there.
        near, _ = shapely.get_coordinates(shapely.shortest_line(ways[a[k]], contours[b[k]]))
        x, y = near.tolist()
        way = work.path.nearest_to(near)[1]
        kept = f"{away[k]:.3f}"
        source = Source(work.name, int(work.moves.line[way]))
        rule = rules.BAND if is_ring[way] else rules.LEAD
        said.append(
            rule.at(
                source, found=kept, contour=work.contour(int(closed[b[k]])),
                x=f"{x:.3f}", y=f"{y:.3f}", expected=f"{work.half_kerf:g}",
            )
        )  # fmt: skip
    return said


def _lines(points: Floats, owner: Counts) -> NDArray[np.object_]:
    """A line through the points of each owner."""
    lines: NDArray[np.object_] = shapely.linestrings(points, indices=owner)
    return lines
