r"""Closed cuts by areas: what of the waste no beam reaches.

         waste            the beam, half a kerf r about its path, sweeps a band of the waste
     .-----------.
    (   path      )       taken   no contour is nearer to the path than r: see `leads`
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

import numpy as np
import shapely
from msgspec import Struct
from numpy.typing import NDArray

from beamcam.checks.rules import UNCUT
from beamcam.checks.sheets.toolpaths import Samples, kept_samples
from beamcam.checks.sheets.tracing import Traced
from beamcam.checks.sheets.work import Work
from beamcam.errors import Diagnostic
from beamcam.geometry.array_types import Counts, Flags, Floats

# --- rests ----------------------------------------------------------------------------------------

# With P the part and B a disc of the beam's radius r, its middle has room outside of P + B. What it
# sweeps from there is the waste but for
#
#     (P + B) - B' - P        the rests, B' a disc that is larger by `MARGIN` of the chords' error
#
# of which each is bounded by contours and by arcs, where the beam touches the contours at both
# ends: its mouths. Each end is a corner of the rest that is one neither of P nor of (P + B) - B'.
# What such areas are off by (chords, and a hundredth of r where curves are simplified) decides
# about no sample: each that is left out has no room beside it, measured from the contours.


MARGIN = 0.5  #: of `fine`, by which a rest is farther from the beam than its contour
POLYGON = 3  #: of shapely's types
QUADRANT = 16  #: chords of a quarter of a beam
TOUCHING = 1e-3  #: mm between contours that bound one waste
SHALLOW = 2.0  #: by half the kerf; what is less deep need not grow narrow
NARROWS = 0.75  #: area of what grows narrow, at most, by that of its mouth and its depth
REPORTED = 1.0  #: by the kerf, deeper than which it is reported, as in a corner of 39 degrees


class UncutCorners(Struct, frozen=True):
    """Waste in corners that no beam reaches."""

    rests: NDArray[np.object_]
    depths: Floats  #: of the farthest place of each from the beam
    places: Floats  #: these places, (n, 2)
    middles: Floats  #: of the beam that touches both of its sides, (n, 2)

    def kept(self, which: Counts | Flags) -> "UncutCorners":
        """Some of them."""
        return UncutCorners(*(getattr(self, name)[which] for name in self.__struct_fields__))


def in_corners(
    work: Work, traced: Sequence[Traced], missing: Counts, samples: Samples
) -> tuple[Flags, UncutCorners | None]:
    """Which of the samples without a path lie in a corner that the beam comes to, and these.

    It comes to a corner if its path passes where it touches both sides at once.
    """
    element, share, owner = kept_samples(samples, missing)
    found = np.zeros(len(missing), dtype=bool)
    which = np.flatnonzero(work.beside[owner])
    # Those beside which a beam has no room in the waste.
    need, half = work.need, work.half_kerf
    elements, shares, sides = element[which], share[which], work.sides[owner[which]]
    twins = np.flatnonzero(sides == 0.0)
    left, _ = work.part_beside(elements[twins], shares[twins])
    sides[twins] = np.where(left, -1.0, 1.0)
    middles = need.elements.places(elements, shares)
    middles += half * sides[:, None] * work.left_of(elements, shares)
    near = need.near(middles, half)
    near = near.kept(work.beside[need.owner[near.element]])
    which = which[need.nearest_of(near, len(middles))[0] < half - 2 * work.fine]
    if not len(which):
        return found, None
    corners = _corners(work, owner[which])
    # Along a contour it is as far from where the beam touches to the end of the rest's mouth.
    margin = MARGIN * work.fine
    reach = np.sqrt(2 * work.half_kerf * margin + margin * margin) + 2 * work.fine
    places = shapely.points(work.need.elements.places(element[which], share[which]))
    inside, rest = shapely.STRtree(corners.rests).query(places, "dwithin", distance=reach)
    slack = np.zeros(len(corners.rests))
    np.maximum.at(slack, rest, work.slack[owner[which[inside]]])
    pairs = work.path.near(corners.middles, work.half_kerf)
    keeps_off = np.array([t.half_kerf > 0.0 for t in traced])
    pairs = pairs.kept(keeps_off[work.of_way[work.path.owner[pairs.element]]])
    touched = work.path.nearest_of(pairs, len(slack))[0] <= slack + work.tolerance
    # A curve that lies on another is where that one is.
    found[which] = work.region.twins[owner[which]]
    found[which[inside[touched[rest]]]] = True
    return found, corners.kept(np.unique(rest[touched[rest]]))


def _corners(work: Work, ways: Counts) -> UncutCorners:
    """The corners of the waste beside the contours that some ways are of."""
    areas, signs = _areas(work, ways)
    half, wider = work.half_kerf, work.half_kerf + MARGIN * work.fine
    kept_off = shapely.buffer(areas, signs * half, quad_segs=QUADRANT)
    swept = shapely.buffer(kept_off, -signs * wider, quad_segs=QUADRANT)
    is_part = signs > 0.0
    rests = shapely.difference(np.where(is_part, swept, areas), np.where(is_part, areas, swept))
    rests = shapely.get_parts(rests)
    rests = rests[(shapely.get_type_id(rests) == POLYGON) & ~shapely.is_empty(rests)]
    rests = rests[shapely.get_num_interior_rings(rests) == 0]
    points, own = shapely.get_coordinates(rests, return_index=True)
    corners = np.concatenate([shapely.get_coordinates(some) for some in (areas, swept)])
    is_end = ~np.isin(_complex(points), _complex(corners))
    is_end &= np.append(own[1:] == own[:-1], False)  # the last place of a ring is its first
    rows = np.flatnonzero(is_end)
    count = np.bincount(own[rows], minlength=len(rests))
    for k in np.flatnonzero(count > 2).tolist():
        # Mouths as narrow as paths may be off are closed.
        mine = rows[own[rows] == k]
        apart = np.hypot(*(points[mine][:, None] - points[mine]).transpose(2, 0, 1))
        is_end[mine] = (apart <= 2 * work.tolerance).sum(axis=1) == 1
    rows = np.flatnonzero(is_end)
    count = np.bincount(own[rows], minlength=len(rests))
    two = np.flatnonzero(count == 2)
    firsts = np.searchsorted(own[rows], two)
    ends = points[rows[firsts]], points[rows[firsts + 1]]
    mouths = np.hypot(*(ends[1] - ends[0]).T)
    room = shapely.points(shapely.get_coordinates(kept_off))
    middles = _touching(ends, mouths, wider, shapely.get_coordinates(shapely.centroid(rests[two])))
    # The beam's middle is a corner of where that has room.
    nearest = shapely.STRtree(room).nearest(shapely.points(middles))
    middles = shapely.get_coordinates(room[nearest])
    begins = np.searchsorted(own, two)
    sizes = np.searchsorted(own, two, "right") - begins
    inner = np.repeat(begins - (np.cumsum(sizes) - sizes), sizes) + np.arange(sizes.sum())
    away = np.hypot(*(points[inner] - np.repeat(middles, sizes, axis=0)).T) - half
    group = np.repeat(np.arange(len(two)), sizes)
    deepest = np.lexsort((away, group))[np.cumsum(sizes) - 1]
    depths = away[deepest]
    narrows = shapely.area(rests[two]) <= NARROWS * mouths * depths
    uncut = UncutCorners(rests[two], depths, points[inner[deepest]], middles)
    return uncut.kept((depths <= SHALLOW * half) | narrows)


def _touching(ends: tuple[Floats, Floats], mouths: Floats, radius: float, inner: Floats) -> Floats:
    """Middles of discs with two places each on their edges, (n, 2), beyond an inner one."""
    (x, y), middle = (ends[1] - ends[0]).T, (ends[0] + ends[1]) / 2
    height = np.sqrt(np.maximum(radius**2 - mouths**2 / 4, 0.0)) / mouths
    aside = np.column_stack((-y, x)) * height[:, None]
    towards = np.sum((inner - middle) * aside, axis=1) > 0.0
    touching: Floats = middle + np.where(towards[:, None], -aside, aside)
    return touching


def _complex(points: Floats) -> NDArray[np.complex128]:
    return np.ascontiguousarray(points).view(np.complex128).ravel()


def _areas(work: Work, ways: Counts) -> tuple[NDArray[np.object_], Floats]:
    """What the contours of some ways enclose, those that touch together: 1 part, -1 waste."""
    region = work.region
    rings = np.unique(region.ring_of[ways])
    rings = rings[rings >= 0]
    areas = shapely.make_valid(region.polygons[rings])
    group = np.arange(len(rings))
    outlines = shapely.get_exterior_ring(region.polygons[rings])
    for a, b in shapely.STRtree(outlines).query(outlines, "dwithin", distance=TOUCHING).T.tolist():
        if a < b and group[a] != group[b]:
            group[group == group[b]] = group[a]
    signs = np.ones(len(rings))
    for n, k in enumerate(rings.tolist()):
        way, back = region.rings[k][0]
        waste_left = (work.sides[way] > 0.0) != back
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


def left_faults(work: Work, corners: UncutCorners) -> list[Diagnostic]:
    """Of each contour the deepest of its corners, if it is deep enough to be reported."""
    corners = corners.kept(corners.depths > REPORTED * 2 * work.half_kerf)
    deepest: dict[int, tuple[int, int]] = {}
    for k in np.argsort(corners.depths, kind="stable").tolist():
        way = work.need.nearest_to(corners.places[k])[1]
        deepest[int(work.region.ring_of[way])] = k, way
    diagnostics = []
    for number, (k, way) in sorted(deepest.items()):
        first = min(k for k, _ in work.region.rings[number]) if number >= 0 else way
        x, y = (f"{at:.3f}" for at in corners.places[k] - np.array(work.shift))
        source = work.required.source(work.process, first)
        diagnostics.append(UNCUT.at(source, found=f"{corners.depths[k]:.3f}", x=x, y=y))
    return diagnostics
