"""Curves that run over one place again and again, refused before anything is compared with all."""

from collections import Counter
from collections.abc import Iterator, Sequence

import numpy as np
from msgspec.structs import replace

from beamcam.errors import PlanError
from beamcam.geometry.array_types import Counts, Floats
from beamcam.geometry.arrays import CurveTable, first_equal, near_pairs
from beamcam.geometry.curves import Arc, Curve, Line, signed_area
from beamcam.geometry.plane import distance
from beamcam.model.lengths import total_length
from beamcam.planning.contours import rules
from beamcam.planning.contours.assign_process import AssignedCurve
from beamcam.planning.contours.outline import Drawn, Shape, outlines

#: Times that a contour may be passed on an average. Hatching of 0.02 mm passes a place of 0.1 mm
#: five times; work that takes every pair of curves on one place grows with the square of it.
MAX_PASSES = 64
MAX_ASKED = 1000  #: stretches of which the neighbours are counted
MAX_EQUAL = 300_000  #: pairs of curves with the same numbers: 775 copies of one, 245 of ten
CELLS = 512  #: along the longer side of the grid in which neighbours are looked for


def refuse_copies(assigned: Sequence[AssignedCurve], curves: CurveTable) -> None:
    """Raise PlanError where more than `MAX_EQUAL` pairs of the curves are equal in every number."""
    first = np.arange(len(assigned))
    free = np.array(curves.free(), dtype=np.int64)
    kinds = (
        (curves.where(Line), curves.lines), (curves.where(Arc), curves.arcs),
        (free, curves.ends[free]),
    )  # fmt: skip
    for which, rows in kinds:
        if len(which):
            first[which] = which[first_equal(rows)]
    times = np.bincount(first)
    if (times * (times - 1) // 2).sum() > MAX_EQUAL:
        most = int(np.argmax(times))
        copies = len(assigned) - np.count_nonzero(times)
        raise PlanError(rules.COPIES.at(assigned[most].source, found=times[most], copies=copies))


def refuse_many_passes(shapes: Sequence[Shape], drawn: Drawn, tolerance: float) -> None:
    """Raise PlanError for shapes that pass most of their places more than `MAX_PASSES` times.

    `drawn` are points of the shapes, and the shape of each. The passes of a place are the lengths
    of all stretches no farther than `tolerance` from it, each no longer than that place, by its
    length.
    """
    import shapely

    points, owner = drawn
    along = owner[1:] == owner[:-1]
    starts, ends, owner = points[:-1][along], points[1:][along], owner[1:][along]
    if not len(starts):
        return
    every = -(-len(starts) // MAX_ASKED)
    which = np.arange(0, len(starts), max(every, 1))
    places = (starts[which] + ends[which]) / 2
    kept = _may_pass(starts, ends, places, tolerance)
    starts, ends = starts[kept], ends[kept]
    stretches = shapely.linestrings(np.stack((starts, ends), axis=1))
    middles = shapely.points(places)
    near, place = shapely.STRtree(middles).query(stretches, "dwithin", distance=tolerance)
    lengths = np.minimum(np.hypot(*(ends - starts).T), 2 * tolerance)
    passes = np.bincount(place, lengths[near], len(which)) / (2 * tolerance)
    if passes.mean() > MAX_PASSES:
        worst = int(np.argmax(passes))
        x, y = shapely.get_coordinates(middles[worst])[0].tolist()
        raise PlanError(
            rules.CROWDED.at(
                shapes[int(owner[which[worst]])].source,
                found=f"{passes[worst]:.0f}",
                reach=f"{tolerance:g}",
                x=f"{x:.3f}",
                y=f"{y:.3f}",
                expected=MAX_PASSES,
            )
        )


def _may_pass(starts: Floats, ends: Floats, places: Floats, tolerance: float) -> Counts:
    """The stretches that may pass a place within the tolerance.

    Those have a place in a cell of a grid that the box around them comes into. How many places lie
    in the cells of a box follows from the sums of all cells below and to the left of its corners.
    """
    one, other = np.ascontiguousarray(starts.T), np.ascontiguousarray(ends.T)
    low, high = np.minimum(one, other) - tolerance, np.maximum(one, other) + tolerance
    origin = low.min(axis=1, keepdims=True)
    cell = max(float((high.max(axis=1, keepdims=True) - origin).max()) / CELLS, tolerance)

    def cells(points: Floats) -> Counts:
        found: Counts = ((points - origin) / cell).astype(np.int64)
        return found

    side = CELLS + 2
    x, y = cells(places.T)
    held = np.bincount((x + 1) * side + y + 1, minlength=side * side).reshape(side, side)
    sums = held.cumsum(axis=0).cumsum(axis=1).ravel()
    (x0, y0), (x1, y1) = cells(low), cells(high) + 1
    inside = sums[x1 * side + y1] - sums[x0 * side + y1] - sums[x1 * side + y0]
    return np.flatnonzero(inside + sums[x0 * side + y0])


# --- pinch ----------------------------------------------------------------------------------------

# Contours that pass a place again, taken apart where waste hangs together by that point only.
#
#  _________
# |   ___   |   The window touches the edge of the plate at o, and both are drawn as one contour:
# |  |   |  |   two regions of waste, each cut by itself. Where it is the part that hangs together
# |  |   |  |   by a point, the contour stays whole, as nothing says that it is two parts.
# |__o___|__|


#: A place that is passed again, in mm: what is nearer is written alike.
SAME_PLACE = 1e-4
FINE = 1e-3  #: mm that chords may be off
#: Ends that need no joining.
SAME_POINT = 1e-9


def taken_apart(
    shapes: Sequence[Shape], which: Sequence[int], tolerance: float
) -> tuple[list[Shape], list[Shape]]:
    """The shapes, some of them as the contours of the waste that hangs together there by points.

    And those among these that are followed there and back: they go round nothing that is wider
    than half the machine's tolerance.
    """
    found: list[Shape] = []
    flat: list[Shape] = []
    numbers = set(which)
    for k, shape in enumerate(shapes):
        rings = list(_rings(shape, tolerance)) if k in numbers else [shape.curves]
        pieces = [replace(shape, curves=ring) for ring in rings] if len(rings) > 1 else [shape]
        flat += (one for one in pieces if len(rings) > 1 and _is_flat(one.curves, tolerance))
        found += pieces
    return found, flat


def _rings(shape: Shape, tolerance: float) -> Iterator[tuple[Curve, ...]]:
    """The contours that one falls into."""
    places = _places(shape.curves)
    again = {place for place, count in Counter(places).items() if count > 1}
    if not again:
        yield shape.curves
        return
    begin = next(k for k, place in enumerate(places) if place in again)
    order = [*range(begin, len(places)), *range(begin)]
    around = [shape.curves[k] for k in order]
    passed = [places[k] for k in order]
    kept: list[int] = []
    for k, place in enumerate((*passed, passed[0])):
        while place in again:
            # Where the contour ends, what begins there is all that is left of it.
            first = 0 if k < len(around) else 1
            at = max((n for n in range(first, len(kept)) if passed[kept[n]] == place), default=None)
            if at is None:
                break
            loop = _closed([around[n] for n in kept[at:]])
            rest = [around[n] for n in (*kept[:at], *range(k, len(around)))]
            if not _is_waste(loop, rest, shape.is_hole, tolerance):
                break
            yield loop
            del kept[at:]
        if k < len(around):
            kept.append(k)
    yield _closed([around[n] for n in kept])


def _places(curves: Sequence[Curve]) -> list[int]:
    """For each curve the first one that begins where it does."""
    places = list(range(len(curves)))
    pairs = near_pairs(np.array([curve.start for curve in curves]), SAME_PLACE)
    for a, b in sorted(zip(*(some.tolist() for some in pairs), strict=True)):
        places[max(a, b)] = places[min(a, b)]
    return places


def _closed(ring: Sequence[Curve]) -> tuple[Curve, ...]:
    """A chain whose ends are written alike, closed."""
    a, b = ring[-1].end, ring[0].start
    return tuple(ring) if distance(a, b) <= SAME_POINT else (*ring, Line(a, b))


def _is_waste(
    loop: tuple[Curve, ...], rest: Sequence[Curve], is_hole: bool, tolerance: float
) -> bool:
    """Whether part of a contour goes round waste by itself, or round nothing."""
    import shapely

    if _is_flat(loop, tolerance):
        return True
    inner, around = shapely.make_valid(outlines([loop, rest], FINE))
    return bool(shapely.point_on_surface(inner).within(around)) != is_hole


def _is_flat(loop: tuple[Curve, ...], tolerance: float) -> bool:
    return abs(signed_area(loop)) <= tolerance / 4 * total_length(loop)
