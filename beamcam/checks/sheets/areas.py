r"""Closed cuts by areas: what the beam sweeps takes nothing of the part, and frees it.

         waste            the beam, half a kerf r about its path, sweeps a band of the waste
     .-----------.
    (   path      )       taken   no contour is nearer to the path than r: the part stays whole
     `--.     .--'        behind  each place of a contour has its path at the waste's side of it
    ----.\   /.----       rest    waste that no beam reaches: nearer than r to no place where its
    part \\./ / part              middle has room. It stays on the part, and is left out of what is
          \V /                    asked for if it is a corner: one beam touches both of its sides,
                                  and it is shallow or grows narrow. A slot or a hole that is too
                                  narrow for the beam is none, nor is a neck.

The part is what closed contours enclose (see `region`). A path may be off by the slack of its
curve.
"""

from collections.abc import Sequence
from itertools import pairwise

import numpy as np
import shapely
from msgspec import Struct
from numpy.typing import NDArray

from beamcam.checks.request import UNCUT
from beamcam.checks.sheets import rules
from beamcam.checks.sheets.grid import Pairs
from beamcam.checks.sheets.paths import on_contour
from beamcam.checks.sheets.toolpaths import Samples, kept_samples
from beamcam.checks.sheets.work import SHOWN, Traced, Work
from beamcam.errors import Diagnostic, Source
from beamcam.geometry.array_types import Counts, Flags, Floats

LINE = 0
BESIDE_LINE = 2e-4  #: mm off a line, where it is asked on which side of it the part is
BELOW = 0.1  #: sine of the angle below a contour from which on a path may be behind it


def _off(work: Work, way: Counts) -> Floats:
    """How far off some ways it is sure what is part: the region has chords for all but lines."""
    return np.where(work.need.kinds[way] == LINE, BESIDE_LINE, 2 * work.fine)


def on_own_side(work: Work, samples: Samples, points: Floats, pairs: Pairs) -> Pairs:
    """The pairs of a sample of a contour and a place of the path that are not behind the contour.

    A thin wall may have the beam at both sides, and on one of them no nearer than the other: what
    is cut from behind the wall is not cut on this side. `points` are the places of the samples.
    """
    if work.region is None or not len(pairs.point):
        return pairs
    element, share, owner = samples
    to_waste = _to_waste(work, element, share, waste_sides(work)[owner])
    path = work.path.elements
    length = path.length[pairs.element]
    at = np.divide(pairs.along, length, out=np.zeros(len(length)), where=length > 0.0)
    way = path.places(pairs.element, at) - points[pairs.point]
    below = np.sum(way * to_waste[pairs.point], axis=1) < -BELOW * pairs.away
    which = np.flatnonzero(below & (pairs.away > 0.0))
    step = _off(work, owner[pairs.point[which]]) / pairs.away[which]
    beside = points[pairs.point[which]] + step[:, None] * way[which]
    kept = np.ones(len(below), dtype=bool)
    kept[which[work.region.in_part(beside)]] = False
    return pairs.kept(kept)


def _to_waste(work: Work, element: Counts, share: Floats, sides: Floats) -> Floats:
    """The direction square to elements, to the left where their side is 1, to the right at -1."""
    ahead = work.need.elements.directions(element, share)
    return sides[:, None] * np.column_stack((-ahead[:, 1], ahead[:, 0]))


def waste_sides(work: Work) -> Floats:
    """Of each way 1 if the waste lies left of it, -1 right of it, 0 if it bounds no part."""
    assert work.region is not None
    need = work.need
    sides = np.zeros(need.count)
    rings = work.region.rings
    longest = np.array([max(ring, key=lambda m: need.lengths[m[0]])[0] for ring in rings])
    if not len(longest):
        return sides
    left = _sides_at(work, need.first(longest), np.full(len(longest), 0.5))
    for ring, way, side in zip(rings, longest.tolist(), left.tolist(), strict=True):
        turned = dict(ring)
        for k, back in ring:
            sides[k] = side if back == turned[way] else -side
    return sides


def _sides_at(work: Work, element: Counts, share: Floats) -> Floats:
    """The same at places of elements, from what lies left of them."""
    assert work.region is not None
    aside = _to_waste(work, element, share, _off(work, work.need.owner[element]))
    left = work.region.in_part(work.need.elements.places(element, share) + aside)
    return np.where(left, -1.0, 1.0)


# --- taken ----------------------------------------------------------------------------------------

# That is asked of the whole path, its leads too, and of every contour, not at samples: both are
# chords at most `fine` off (an eighth of the machine's tolerance), so that a beam is refused that
# takes more than the tolerance, the rounding of the program's numbers and 3 `fine`, in all 1.4
# times the tolerance and two steps of the last decimal. No buffer is drawn, so there are no
# quadrants of it to add an error.


def band_faults(work: Work, traced: Sequence[Traced]) -> list[Diagnostic]:
    """Places where the beam cuts into the part."""
    if work.region is None:
        return []
    keeps_off = np.array([t.half_kerf > 0.0 for t in traced])
    diagnostics = _bites(work, traced, keeps_off)
    places = work.path.starts[[t.first for t in traced]]
    for k in np.flatnonzero(keeps_off & work.region.in_part(places))[:SHOWN].tolist():
        # For a kerf that is less than what a path may be off, no side is judged.
        away, way = work.need.nearest_to(places[k])
        if away <= work.slack[way]:
            continue
        x, y = places[k].tolist()
        source = Source(work.name, traced[k].stroke.line)
        diagnostics.append(
            rules.SIDE.at(source, x=f"{x:.3f}", y=f"{y:.3f}", contour=work.contour(way))
        )
    return diagnostics


def _bites(work: Work, traced: Sequence[Traced], keeps_off: Flags) -> list[Diagnostic]:
    """The first place of each stroke that is nearer to a closed contour than half a kerf."""
    assert work.region is not None
    closed = np.flatnonzero(work.region.closed & ~work.region.twins)
    strokes = np.flatnonzero(keeps_off)
    if not len(closed) or not len(strokes):
        return []
    contours = work.contours[closed]
    ways = work.path.lines(work.fine, work.of_way)[strokes]
    least = work.half_kerf - work.slack[closed] - 2 * work.fine
    a, b = shapely.STRtree(contours).query(ways, "dwithin", distance=float(least.max()))
    away = shapely.distance(ways[a], contours[b])
    hit = np.flatnonzero(away < least[b])
    _, firsts = np.unique(a[hit], return_index=True)
    is_ring = on_contour(work, traced)
    diagnostics = []
    for k in hit[firsts][:SHOWN].tolist():
        # The place on the path, and the line that leads there.
        near, _ = shapely.get_coordinates(shapely.shortest_line(ways[a[k]], contours[b[k]]))
        x, y = near.tolist()
        way = work.path.nearest_to(near)[1]
        rule = rules.BAND if is_ring[way] else rules.LEAD
        diagnostics.append(
            rule.at(
                Source(work.name, int(work.moves.line[way])), found=f"{away[k]:.3f}",
                contour=work.contour(int(closed[b[k]])), x=f"{x:.3f}", y=f"{y:.3f}",
                expected=f"{work.half_kerf:g}",
            )
        )  # fmt: skip
    return diagnostics


# --- rests ----------------------------------------------------------------------------------------

# With P the part and B a disc of the beam's radius r, its middle has room outside of P + B. What it
# sweeps from there is the waste but for
#
#     (P + B) - B' - P        the rests, B' a disc that is larger by `SPARE` of the chords' error
#
# of which each is bounded by contours and by arcs, where the beam touches the contours at both
# ends: its mouths. Each end is a corner of the rest that is one neither of P nor of (P + B) - B'.
# What such areas are off by (chords, and a hundredth of r where curves are simplified) decides
# about no sample: each that is left out has no room beside it, measured from the contours.


SPARE = 0.5  #: of `fine`, by which a rest is farther from the beam than the contour that it touches
QUADRANT = 16  #: chords of a quarter of a beam
TOUCHING = 1e-3  #: mm between contours that bound one waste
SHALLOW = 2.0  #: by half the kerf; what is less deep need not grow narrow
NARROWS = 0.75  #: area of what grows narrow, at most, by that of its mouth and its depth
TOLD = 1.0  #: by the kerf, deeper than which it is told what stays, as in a corner of 39 degrees


class UncutCorner(Struct, frozen=True):
    """Waste in a corner that no beam reaches."""

    rest: shapely.Polygon
    depth: float  #: of the farthest place from the beam
    place: tuple[float, float]
    middle: Floats  #: of the beam that touches both of its sides


def in_corners(
    work: Work, traced: Sequence[Traced], missing: Counts, samples: Samples
) -> tuple[Flags, Sequence[UncutCorner]]:
    """Which of the samples without a path lie in a corner that the beam comes to, and these.

    It comes to a corner if its path passes where it touches both sides at once.
    """
    element, share, owner = kept_samples(samples, missing)
    found = np.zeros(len(missing), dtype=bool)
    if work.region is None:
        return found, []
    which = np.flatnonzero(work.beside[owner])
    which = which[~_has_room(work, element[which], share[which])]
    if not len(which):
        return found, []
    corners = _corners(work, owner[which])
    # Along a contour it is as far from where the beam touches to the end of the rest's mouth.
    spare = SPARE * work.fine
    reach = np.sqrt(2 * work.half_kerf * spare + spare * spare) + 2 * work.fine
    places = shapely.points(work.need.elements.places(element[which], share[which]))
    rests = shapely.STRtree([corner.rest for corner in corners])
    inside, rest = rests.query(places, "dwithin", distance=reach)
    slack = np.zeros(len(corners))
    np.maximum.at(slack, rest, work.slack[owner[which[inside]]])
    middles = np.array([corner.middle for corner in corners]).reshape(-1, 2)
    pairs = work.path.near(middles, work.half_kerf)
    keeps_off = np.array([t.half_kerf > 0.0 for t in traced])
    pairs = pairs.kept(keeps_off[work.of_way[work.path.owner[pairs.element]]])
    touched = work.path.feet(pairs, len(middles))[0] <= slack + work.tolerance
    # A curve that lies on another is where that one is.
    found[which] = work.region.twins[owner[which]]
    found[which[inside[touched[rest]]]] = True
    return found, [corners[k] for k in np.unique(rest[touched[rest]]).tolist()]


def _has_room(work: Work, element: Counts, share: Floats) -> Flags:
    """Places of contours beside which a beam has room in the waste."""
    need, half = work.need, work.half_kerf
    sides = waste_sides(work)[need.owner[element]]
    twins = np.flatnonzero(sides == 0.0)
    sides[twins] = _sides_at(work, element[twins], share[twins])
    middles = need.elements.places(element, share) + half * _to_waste(work, element, share, sides)
    pairs = need.near(middles, half)
    pairs = pairs.kept(work.beside[need.owner[pairs.element]])
    is_free: Flags = need.nearest_of(pairs, len(middles))[0] >= half - 2 * work.fine
    return is_free


def _corners(work: Work, ways: Counts) -> list[UncutCorner]:
    """The corners of the waste beside the contours that some ways are of."""
    areas, signs = _areas(work, ways)
    half, wider = work.half_kerf, work.half_kerf + SPARE * work.fine
    kept_off = shapely.buffer(areas, signs * half, quad_segs=QUADRANT)
    swept = shapely.buffer(kept_off, -signs * wider, quad_segs=QUADRANT)
    is_part = signs > 0.0
    rests = shapely.difference(np.where(is_part, swept, areas), np.where(is_part, areas, swept))
    rests, group = shapely.get_parts(rests, return_index=True)
    points, own = shapely.get_coordinates(rests, return_index=True)
    corners = np.concatenate([shapely.get_coordinates(some) for some in (areas, swept)])
    is_end = ~np.isin(_complex(points), _complex(corners))
    room, of_area = shapely.get_coordinates(kept_off, return_index=True)
    firsts = np.searchsorted(of_area, np.arange(len(areas) + 1))
    uncut_corners = []
    begins = np.searchsorted(own, np.arange(len(rests) + 1)).tolist()
    sizes = shapely.area(rests).tolist()
    for k, (low, high) in enumerate(pairwise(begins)):
        ring = points[low:high]
        ends = np.unique(ring[is_end[low:high]], axis=0)
        if len(ends) > 2:  # mouths as narrow as paths may be off are closed
            apart = np.hypot(*(ends[:, None] - ends).transpose(2, 0, 1))
            ends = ends[(apart <= 2 * work.tolerance).sum(axis=1) == 1]
        if len(ends) != 2 or shapely.get_num_interior_rings(rests[k]):
            continue
        mouth = float(np.hypot(*(ends[1] - ends[0])))
        aside = np.array((ends[0, 1] - ends[1, 1], ends[1, 0] - ends[0, 0])) / mouth
        aside *= np.sqrt(max(wider**2 - mouth**2 / 4, 0.0))
        middle = ends.mean(axis=0)
        middle -= aside if np.sum((ring.mean(axis=0) - middle) * aside) > 0.0 else -aside
        # The beam's middle is a corner of where that has room.
        mine = room[firsts[group[k]] : firsts[group[k] + 1]]
        middle = mine[np.argmin(np.hypot(*(mine - middle).T))]
        depths = np.hypot(*(ring - middle).T) - half
        deepest = int(np.argmax(depths))
        depth = float(depths[deepest])
        if depth <= SHALLOW * half or sizes[k] <= NARROWS * mouth * depth:
            x, y = ring[deepest].tolist()
            uncut_corners.append(UncutCorner(rests[k], depth, (x, y), middle))
    return uncut_corners


def _complex(points: Floats) -> NDArray[np.complex128]:
    return np.ascontiguousarray(points).view(np.complex128).ravel()


def _areas(work: Work, ways: Counts) -> tuple[NDArray[np.object_], Floats]:
    """What the contours of some ways enclose, those that touch together: 1 part, -1 waste."""
    assert work.region is not None
    region = work.region
    rings = np.unique(region.ring_of[ways])
    rings = rings[rings >= 0]
    sides = waste_sides(work)
    areas = shapely.make_valid(region.polygons[rings])
    group = np.arange(len(rings))
    outlines = shapely.get_exterior_ring(region.polygons[rings])
    for a, b in shapely.STRtree(outlines).query(outlines, "dwithin", distance=TOUCHING).T.tolist():
        if a < b and group[a] != group[b]:
            group[group == group[b]] = group[a]
    signs = np.ones(len(rings))
    for n, k in enumerate(rings.tolist()):
        (way, back), *_ = region.rings[k]
        waste_left = (sides[way] > 0.0) != back
        signs[n] = -1.0 if waste_left == region.anticlockwise[k] else 1.0
    kinds, firsts, count = np.unique(group, return_index=True, return_counts=True)
    found = areas[firsts]
    for n in np.flatnonzero(count > 1).tolist():
        mine = np.flatnonzero(group == kinds[n])
        largest = mine[np.argmax(shapely.area(areas[mine]))]
        found[n] = shapely.Polygon()
        for area in areas[mine]:
            found[n] = shapely.symmetric_difference(found[n], area)
        signs[firsts[n]] = signs[largest]
    return found, signs[firsts]


def left_faults(work: Work, corners: Sequence[UncutCorner]) -> list[Diagnostic]:
    """Of each contour the deepest of its corners, if it is deep enough to be told."""
    if work.region is None:
        return []
    deepest: dict[int, tuple[UncutCorner, int]] = {}
    for corner in sorted(corners, key=lambda one: one.depth):
        if corner.depth > TOLD * 2 * work.half_kerf:
            way = work.need.nearest_to(np.array(corner.place))[1]
            deepest[int(work.region.ring_of[way])] = corner, way
    diagnostics = []
    for number, (corner, way) in sorted(deepest.items()):
        first = min(k for k, _ in work.region.rings[number]) if number >= 0 else way
        x, y = (np.array(corner.place) - np.array(work.shift)).tolist()
        source = work.asked.source(work.process, first)
        diagnostics.append(
            UNCUT.at(source, found=f"{corner.depth:.3f}", x=f"{x:.3f}", y=f"{y:.3f}")
        )
    return diagnostics
