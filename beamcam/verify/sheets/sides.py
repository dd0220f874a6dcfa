"""Which places of the path are on the waste's side of a contour.

      o |   A thin wall may have the beam at both sides, and on one of them no nearer than the
     o  |\\  other. What is cut from behind the wall is not cut on this side.
    o   | \\
"""

from collections import defaultdict
from collections.abc import Iterator, Sequence
from math import atan2, tau

import numpy as np
import shapely
from numpy.typing import NDArray

from beamcam.errors import Diagnostic, Source
from beamcam.geometry.array_types import Counts, Flags, Floats
from beamcam.verify.sheets import rules
from beamcam.verify.sheets.grid import Pairs
from beamcam.verify.sheets.joining import Chain
from beamcam.verify.sheets.paths import on_contour
from beamcam.verify.sheets.toolpaths import Samples
from beamcam.verify.sheets.work import SHOWN, Traced, Work

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


# --- band -----------------------------------------------------------------------------------------

# The band that a beam sweeps, which must stay out of the part.
#
# A beam of radius r along a path takes away every point that is at most r from the path. So it
# takes nothing of the part if the path lies in the waste, and no closed contour is nearer to it
# than r. That is asked of the whole path, its leads too, and of every contour, not at samples: both
# are chords at most `fine` off (an eighth of the machine's tolerance), so that a beam is refused
# that takes more than the tolerance, the rounding of the program's numbers and 3 `fine`, in all 1.4
# times the tolerance and two steps of the last decimal. No buffer is drawn, so there are no
# quadrants of it to add an error.


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


# --- touching -------------------------------------------------------------------------------------

# Rings that touch one another or themselves, in the order in which they bound the waste.
#
#  part  | waste
#        |          Four curves meet at o, and each of the rings that they belong to may turn
# -------o-------   from one part into the other there. Along the waste a corner is what lies
#        |          between two curves with nothing but waste between them.
#  waste | part


DIGITS = 4  #: of mm, in which the ends of curves are alike that meet in one point
LEAST_TURN_RAD = 1e-9  #: of two curves that part


def waste_rings(work: Work) -> Sequence[Chain]:
    """The rings of the region, the waste left of each.

    Where they touch, each curve is followed by the one that bounds the same waste.
    """
    assert work.region is not None
    left = waste_sides(work)
    rings = [
        ring if (left[ring[0][0]] > 0.0) != ring[0][1] else _reversed(ring)
        for ring in work.region.rings
    ]
    ways = [way for ring in rings for way in ring]
    places, number = np.unique(_starts(work, ways).round(DIGITS), axis=0, return_inverse=True)
    if len(places) == len(ways):
        return rings
    after = _following(rings)
    before = {k: n for n, k in enumerate(after)}
    leaving: defaultdict[int, list[int]] = defaultdict(list)
    for k, place in enumerate(number.ravel().tolist()):
        leaving[place].append(k)
    for some in leaving.values():
        if len(some) > 1:
            _link(work, ways, some, [before[k] for k in some], after)
    return list(_walks(ways, after))


def _reversed(ring: Chain) -> Chain:
    return [(k, not turned) for k, turned in reversed(ring)]


def _following(rings: Sequence[Chain]) -> list[int]:
    """Of each way, numbered through all rings, the one that follows in its ring."""
    found: list[int] = []
    for ring in rings:
        first = len(found)
        found += [first + (n + 1) % len(ring) for n in range(len(ring))]
    return found


def _link(
    work: Work, ways: Sequence[tuple[int, bool]], out: list[int], into: list[int], after: list[int]
) -> None:
    """Make each way into a point be followed by the next one out of it, clockwise.

    Nothing is changed where two would be followed by the same one.
    """
    ahead = [atan2(y, x) for x, y in _headings(work, [ways[k] for k in out], 0.0).tolist()]
    back = [atan2(-y, -x) for x, y in _headings(work, [ways[k] for k in into], 1.0).tolist()]
    chosen = [
        min(range(len(out)), key=lambda n: (angle - ahead[n] - LEAST_TURN_RAD) % tau)
        for angle in back
    ]
    if len(set(chosen)) == len(out):
        for k, n in zip(into, chosen, strict=True):
            after[k] = out[n]


def _walks(ways: Sequence[tuple[int, bool]], after: Sequence[int]) -> Iterator[Chain]:
    left = dict.fromkeys(range(len(ways)))
    while left:
        at = next(iter(left))
        ring: Chain = []
        while at in left:
            del left[at]
            ring.append(ways[at])
            at = after[at]
        yield ring


def _starts(work: Work, ways: Sequence[tuple[int, bool]]) -> Floats:
    """Where each way begins."""
    numbers = np.array([k for k, _ in ways], dtype=np.int64)
    turned = np.array([back for _, back in ways])[:, None]
    return np.where(turned, work.need.ends[numbers], work.need.starts[numbers])


def _headings(work: Work, ways: Sequence[tuple[int, bool]], share: float) -> Floats:
    """The direction in which each way begins, or with a share of 1 ends."""
    numbers = np.array([k for k, _ in ways], dtype=np.int64)
    turned = np.array([back for _, back in ways])
    first = turned == bool(share)
    element = np.where(first, work.need.first(numbers), work.need.last(numbers))
    found = work.need.elements.directions(element, np.where(first, 0.0, 1.0))
    return np.where(turned[:, None], -found, found)
