"""Which places of the path are on the waste's side of a contour.

      o |   A thin wall may have the beam at both sides, and on one of them no nearer than the
     o  |\\  other. What is cut from behind the wall is not cut on this side.
    o   | \\
"""

import numpy as np

from beamcam.geometry.array_types import Counts, Flags, Floats
from beamcam.verify.sheets.grid import Pairs
from beamcam.verify.sheets.toolpaths import Samples
from beamcam.verify.sheets.work import Work

LINE = 0
BESIDE_LINE = 2e-4  #: mm off a line, where it is asked on which side of it the part is

#: Sine of the angle below a contour from which on a place of the path may be behind it.
BELOW = 0.1


def off(work: Work, way: Counts) -> Floats:
    """How far off some ways it is sure what is part: the region has chords for all but lines."""
    return np.where(work.need.kinds[way] == LINE, BESIDE_LINE, 2 * work.fine)


def on_own_side(work: Work, samples: Samples, points: Floats, pairs: Pairs) -> Pairs:
    """The pairs of a sample of a contour and a place of the path that are not behind the contour.

    `points` are the places of the samples.
    """
    if work.region is None or not len(pairs.point):
        return pairs
    element, share, owner = samples
    ahead = work.need.elements.directions(element, share)
    to_waste = waste_sides(work)[owner][:, None] * np.column_stack((-ahead[:, 1], ahead[:, 0]))
    path = work.path.elements
    length = path.length[pairs.element]
    at = np.divide(pairs.along, length, out=np.zeros(len(length)), where=length > 0.0)
    way = path.places(pairs.element, at) - points[pairs.point]
    below = np.sum(way * to_waste[pairs.point], axis=1) < -BELOW * pairs.away
    asked = np.flatnonzero(below)
    behind = np.zeros(len(below), dtype=bool)
    behind[asked] = is_behind(
        work, points[pairs.point[asked]], owner[pairs.point[asked]], pairs.away[asked], way[asked]
    )
    return pairs.kept(~behind)


def is_behind(work: Work, points: Floats, way: Counts, away: Floats, to_path: Floats) -> Flags:
    """Whether the part lies between places of some ways and the path, so far away on each."""
    assert work.region is not None
    found = np.isfinite(away) & (away > 0.0)
    step = off(work, way[found]) / away[found]
    found[found] = work.region.in_part(points[found] + step[:, None] * to_path[found])
    return found


def waste_sides(work: Work) -> Floats:
    """Of each way 1 if the waste lies left of it, -1 right of it, 0 if it bounds no part."""
    assert work.region is not None
    need = work.need
    found = np.zeros(need.count)
    rings = work.region.rings
    longest = np.array([max(ring, key=lambda m: need.lengths[m[0]])[0] for ring in rings])
    if not len(longest):
        return found
    element = need.first(longest)
    share = np.full(len(longest), 0.5)
    ahead = need.elements.directions(element, share)
    aside = off(work, longest)[:, None] * np.column_stack((-ahead[:, 1], ahead[:, 0]))
    middle = need.elements.places(element, share)
    left = np.where(work.region.in_part(middle + aside), -1.0, 1.0)
    for ring, way, side in zip(rings, longest.tolist(), left.tolist(), strict=True):
        turned = dict(ring)
        for k, back in ring:
            found[k] = side if back == turned[way] else -side
    return found
