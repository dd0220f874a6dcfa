"""Curves and contours that pass a place again: back along themselves, too often, or at a point."""

from collections.abc import Iterator, Sequence
from itertools import pairwise
from math import pi, tau

import numpy as np
import shapely
from msgspec.structs import replace
from shapely.ops import substring

from beamcam.errors import Diagnostic, PlanError, Source
from beamcam.geometry.array_types import Counts, Flags, Floats
from beamcam.geometry.arrays import CurveTable, cubics_of, first_equal
from beamcam.geometry.curves import Arc, Bezier, BSpline, Curve, Line
from beamcam.geometry.plane import distance, dot
from beamcam.geometry.polylines import polylines
from beamcam.planning.contours import rules
from beamcam.planning.contours.assign_process import AssignedCurve
from beamcam.planning.contours.outline import Drawn, Shape

FINE = 1e-3  #: mm that chords are off their curves, and what lies nearer lies on one another
MIN_LENGTH = 0.5  #: mm; both arms of a cusp leave one another, what stays together longer runs back
BACK = -0.9  #: cosine between chords of which the second runs back
NEEDLE = 2.0  #: tolerances between both sides of a needle
#: How far a needle is from another stretch of its contour half way to its tip, by that way: what
#: is nearer leaves a wedge that is too narrow to say on which side of it the waste is.
BESIDE = 0.4
STEP = 0.25  #: mm between places of a needle
NO_STEP = 1e-6  #: mm
MOST_LENGTH = 100.0  #: of a needle, in mm, that is looked at
SHORT = 1e-3  #: mm that a contour may run back along itself; what writes drawings rounds so


def without_steps_back(shape: Shape) -> Shape:
    """A closed cut without lines shorter than `SHORT` that run back along their neighbour.

    The line behind one begins where it began, or the line before it ends where it ended; between
    two curves that are no lines it stays.
    """
    ring = list(shape.curves) if shape.closed and shape.process == "cut" else []
    k = 0
    while k < len(ring) > 2:
        one, before, behind = ring[k], ring[k - 1], ring[(k + 1) % len(ring)]
        if (
            isinstance(one, Line)
            and one.length < SHORT
            and (_turns_back(before, one) or _turns_back(one, behind))
        ):
            if isinstance(behind, Line):
                ring[(k + 1) % len(ring)] = Line(one.start, behind.end)
            elif isinstance(before, Line):
                ring[k - 1] = Line(before.start, one.end)
            else:
                k += 1
                continue
            del ring[k]
            k = max(k - 2, 0)  # what is before it may run back now
        else:
            k += 1
    is_same = not ring or len(ring) == len(shape.curves)
    return shape if is_same else replace(shape, curves=tuple(ring))


def _turns_back(one: Curve, other: Curve) -> bool:
    if one.length == 0.0 or other.length == 0.0:
        return True
    return dot(one.tangent(1.0), other.tangent(0.0)) < BACK


def remarks(
    curves: Sequence[AssignedCurve], which: Sequence[int], kerf: float
) -> Iterator[Diagnostic]:
    """Remarks on the curves that turn round and run back along themselves.

    An error with kerf compensation, as the side of such a stretch is undefined.
    """
    which = [k for k in which if _may_turn_round(curves[k].curve)]
    if not which:
        return
    drawn = polylines([curves[k].curve for k in which], FINE)
    steps = np.diff(drawn.points, axis=0)
    sizes = np.hypot(*steps.T)
    back = np.sum(steps[1:] * steps[:-1], axis=1) < BACK * sizes[1:] * sizes[:-1]
    for at in (np.flatnonzero(back) + 1).tolist():
        own = int(np.searchsorted(drawn.begins, at, "right")) - 1
        begin, end = int(drawn.begins[own]), int(drawn.begins[own + 1])
        if begin < at < end - 1:
            arms = drawn.points[begin : at + 1][::-1], drawn.points[at:end]
            length, w = _together(*arms, 2 * FINE), curves[which[own]]
            if length > MIN_LENGTH:
                rule = rules.RUNS_BACK_KERF if kerf and w.process == "cut" else rules.RUNS_BACK
                yield rule.at(w.source, found=f"{length:.3f}", **rules.at_place(drawn.points[at]))


def _may_turn_round(curve: Curve) -> bool:
    """Whether the directions of neighbouring sides of its control polygon fill half a circle.

    The derivative of a polynomial lies between as many of them as its degree, so that it goes
    through 0 nowhere else, and at a knot a curve turns no farther than they do.
    """
    if isinstance(curve, BSpline):
        points, degree = curve.control, curve.degree
    elif isinstance(curve, Bezier):
        points, degree = curve.points, len(curve.points) - 1
    else:
        return True
    sides = []
    for a, b in pairwise(points):
        if (length := distance(a, b)) > 0.0:
            sides.append(((b[0] - a[0]) / length, (b[1] - a[1]) / length))
    for k in range(max(len(sides) - degree, 0) + 1):
        some = sides[k : k + degree]
        x, y = sum(u for u, _ in some), sum(v for _, v in some)
        if any(u * x + v * y <= 0.0 for u, v in some):
            return True
    return False


def _together(one: Floats, other: Floats, near: float) -> float:
    """Length over which two polylines from a common start are no farther apart than `near`."""
    if shapely.length(shapely.linestrings(one)) > shapely.length(shapely.linestrings(other)):
        one, other = other, one
    away = shapely.distance(shapely.points(one), shapely.linestrings(other))
    apart = np.flatnonzero(away > near)
    last = int(apart[0]) if len(apart) else len(one)
    return float(np.hypot(*np.diff(one[:last], axis=0).T).sum()) if last > 1 else 0.0


def turns(drawn: Drawn) -> dict[int, tuple[Floats, Counts]]:
    """Each closed contour that turns round: its places, (n, 2), and at which of them it does so.

    `drawn` are points of the contours, of which each has the number of its contour.
    """
    points, owner = drawn
    steps = np.diff(points, axis=0)
    real = np.flatnonzero((np.hypot(*steps.T) > NO_STEP) & (owner[1:] == owner[:-1]))
    steps, owner = steps[real], owner[real]
    after = np.arange(1, len(real) + 1)
    begins = np.flatnonzero(np.diff(owner, prepend=-1))
    after[np.append(begins[1:], len(real))[: len(begins)] - 1] = begins
    sizes = np.hypot(*steps.T)
    back = np.sum(steps * steps[after], axis=1) < BACK * sizes * sizes[after]
    at = np.sort(after[back])
    by_curve = {}
    for k in np.unique(owner[at]).tolist():
        first, last = np.searchsorted(owner, [k, k + 1]).tolist()
        own = at[(at >= first) & (at < last)] - first
        by_curve[k] = points[real[first:last]], own
    return by_curve


def needles_beside(
    source: Source, ring: Floats, turns: Counts, tolerance: float
) -> Iterator[Diagnostic]:
    """An error for each needle of a ring (n, 2) that lies beside another stretch of it."""
    near = NEEDLE * tolerance
    for at in turns.tolist():
        places = np.append(np.roll(ring, -at, axis=0), ring[at : at + 1], axis=0)
        around = shapely.linestrings(places)
        reached = np.append(0.0, np.cumsum(np.hypot(*np.diff(places, axis=0).T)))
        half = min(reached[-1] / 2, MOST_LENGTH)
        others = reached[(turns[turns != at] - at) % len(ring)]
        ahead, back = (min([half, *some]) for some in (others, reached[-1] - others))
        sides = substring(around, 0.0, ahead), substring(around, reached[-1], reached[-1] - back)
        one, other = (shapely.get_coordinates(shapely.segmentize(side, STEP)) for side in sides)
        length = _together(one, other, near)
        if length <= MIN_LENGTH or reached[-1] <= 2 * (length + near):
            continue
        rest = substring(around, length + near, reached[-1] - length - near)
        if rest.distance(around.interpolate(length / 2)) <= BESIDE * length / 2:
            yield rules.RUNS_BACK_KERF.at(source, found=f"{length:.3f}", **rules.at_place(ring[at]))


# --- copies ---------------------------------------------------------------------------------------

# Refused before anything is compared with all.


#: Times that a contour may be passed on an average. Hatching of 0.02 mm passes a place of 0.1 mm
#: five times; work that takes every pair of curves on one place grows with the square of it.
MAX_PASSES = 64
MAX_ASKED = 1000  #: segments of which the neighbours are counted
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
    of all segments no farther than `tolerance` from it, each no longer than that place, by its
    length.
    """
    points, owner = drawn
    along = owner[1:] == owner[:-1]
    starts, ends, owner = points[:-1][along], points[1:][along], owner[1:][along]
    if not len(starts):
        return
    which = np.arange(0, len(starts), -(-len(starts) // MAX_ASKED))
    places = (starts[which] + ends[which]) / 2
    kept = _may_pass(starts, ends, places, tolerance)
    starts, ends = starts[kept], ends[kept]
    segments = shapely.linestrings(np.stack((starts, ends), axis=1))
    middles = shapely.points(places)
    near, place = shapely.STRtree(middles).query(segments, "dwithin", distance=tolerance)
    lengths = np.minimum(np.hypot(*(ends - starts).T), 2 * tolerance)
    passes = np.bincount(place, lengths[near], len(which)) / (2 * tolerance)
    if passes.mean() > MAX_PASSES:
        worst = int(np.argmax(passes))
        source = shapes[int(owner[which[worst]])].source
        values = {"found": f"{passes[worst]:.0f}", "reach": f"{tolerance:g}"}
        place = rules.at_place(places[worst])
        raise PlanError(rules.CROWDED.at(source, **values, **place, expected=MAX_PASSES))


def _may_pass(starts: Floats, ends: Floats, places: Floats, tolerance: float) -> Counts:
    """The segments that may pass a place within the tolerance.

    Those have a place in a cell of a grid that the box around them comes into. How many places lie
    in the cells of a box follows from the sums of all cells below and to the left of its corners.
    """
    one, other = np.ascontiguousarray(starts.T), np.ascontiguousarray(ends.T)
    low, high = np.minimum(one, other) - tolerance, np.maximum(one, other) + tolerance
    origin = low.min(axis=1, keepdims=True)
    cell = max(float((high.max(axis=1, keepdims=True) - origin).max()) / CELLS, tolerance)

    def cells(points: Floats) -> Counts:
        return np.asarray(((points - origin) / cell).astype(np.int64))

    side = CELLS + 2
    x, y = cells(places.T)
    held = np.bincount((x + 1) * side + y + 1, minlength=side * side).reshape(side, side)
    sums = held.cumsum(axis=0).cumsum(axis=1).ravel()
    (x0, y0), (x1, y1) = cells(low), cells(high) + 1
    inside = sums[x1 * side + y1] - sums[x0 * side + y1] - sums[x1 * side + y0]
    return np.flatnonzero(inside + sums[x0 * side + y0])


#: A curve that goes over itself the same way has turned by a whole circle in between.
TURNED_RAD = 1.01 * tau
AT_ONCE = 1000  #: chords that are asked about
MAX_PAIRS = 2_000_000  #: hundreds of rounds on one place are refused without comparing each pair


def free_repeats(curves: Sequence[AssignedCurve], which: Sequence[int]) -> Iterator[Diagnostic]:
    """An error for each feature to cut whose free curves run over themselves in one direction."""
    features: dict[int, list[int]] = {}
    for k in which:
        if curves[k].process == "cut":
            features.setdefault(curves[k].feature, []).append(k)
    numbers = list(features)
    going = may_go_round([[curves[k].curve for k in some] for some in features.values()])
    features = {numbers[n]: features[numbers[n]] for n in sorted(going)}
    if not features:
        return
    starts, steps, owner = chords_of([curves[k].curve for some in features.values() for k in some])
    ends = np.cumsum([len(some) for some in features.values()])
    bounds = np.searchsorted(owner, [0, *ends.tolist()]).tolist()
    ahead = np.unwrap(np.arctan2(*steps.T[::-1]))
    for some, (low, high) in zip(features.values(), pairwise(bounds), strict=True):
        if high > low and np.ptp(ahead[low:high]) > TURNED_RAD:
            own = steps[low:high]
            again = _again(starts[low:high], own)
            if (length := float(np.hypot(*own[again].T).sum())) > MIN_LENGTH:
                first = starts[low:high][int(np.argmax(again))]
                yield rules.RUNS_OVER.at(
                    curves[some[0]].source, found=f"{length:.3f}", **rules.at_place(first)
                )


def may_go_round(chains: Sequence[Sequence[Curve]]) -> set[int]:
    """The numbers of the chains whose directions may fill a whole circle.

    The directions of a cubic lie between those of the sides of its control polygon, where none of
    these turns by more than a right angle.
    """
    control, owner, odd = cubics_of([curve for chain in chains for curve in chain])
    chain_of = np.repeat(np.arange(len(chains)), [len(chain) for chain in chains])
    sides = np.diff(control, axis=1).reshape(-1, 2)
    chain = np.repeat(chain_of[owner], 3)
    long = np.any(sides != 0.0, axis=1)
    sides, chain = sides[long], chain[long]
    ahead = np.unwrap(np.arctan2(*sides.T[::-1]))
    sharp = (np.abs(np.diff(ahead)) > pi / 2) & (chain[1:] == chain[:-1])
    first = np.flatnonzero(np.diff(chain, prepend=-1))
    turned = np.maximum.reduceat(ahead, first) - np.minimum.reduceat(ahead, first)
    going = (chain_of[odd], chain[1:][sharp], chain[first][turned > TURNED_RAD])
    return set(np.concatenate(going).tolist())


def chords_of(curves: Sequence[Curve]) -> tuple[Floats, Floats, Counts]:
    """Where the chords of curves begin, how far each goes, (n, 2) each, and the curve of each."""
    drawn = polylines(curves, FINE)
    steps = np.diff(drawn.points, axis=0)
    inner = np.hypot(*steps.T) > 0.0
    inner[drawn.begins[1:-1] - 1] = False  # from one curve to the next
    owner = np.searchsorted(drawn.begins, np.flatnonzero(inner), "right") - 1
    return drawn.points[:-1][inner], steps[inner], owner


def _again(starts: Floats, steps: Floats) -> Flags:
    """Which chords lie on others that are followed before them, in the same direction.

    Of a curve with more than `MAX_PAIRS` chords on one another it may be those that come first.
    """
    along = np.cumsum(np.hypot(*steps.T))
    chords = shapely.STRtree(shapely.linestrings(np.stack((starts, starts + steps), axis=1)))
    middles = shapely.points(starts + steps / 2)
    is_again, pairs = np.zeros(len(steps), dtype=bool), 0
    for first in range(0, len(steps), AT_ONCE):
        own, other = chords.query(middles[first : first + AT_ONCE], "dwithin", distance=2 * FINE)
        own += first
        before = (along[own] - along[other] > MIN_LENGTH) & (
            np.sum(steps[own] * steps[other], axis=1) > 0.0
        )
        is_again[own[before]] = True
        pairs += len(own)
        if pairs > MAX_PAIRS and np.hypot(*steps[is_again].T).sum() > MIN_LENGTH:
            break
    return is_again


#: A closed chain whose ends are nearer than this needs no joining.
SAME_POINT = 1e-9


def is_there_and_back(curves: Sequence[AssignedCurve]) -> bool:
    """Whether a closed feature is a line that is drawn in both directions."""
    return len(curves) == 2 and all(type(w.curve) is Line or is_straight(w.curve) for w in curves)


def is_straight(curve: Curve) -> bool:
    """Whether a Bezier goes straight from end to end, without turning round."""
    if not isinstance(curve, Bezier) or curve.weights is not None:
        return False
    (x0, y0), (x1, y1) = curve.start, curve.end
    length = distance(curve.start, curve.end)
    if length <= SAME_POINT:
        return False
    u, v = (x1 - x0) / length, (y1 - y0) / length
    along = [u * (x - x0) + v * (y - y0) for x, y in curve.points]
    aside = max(abs(u * (y - y0) - v * (x - x0)) for x, y in curve.points)
    return aside <= SAME_POINT and along == sorted(along)
