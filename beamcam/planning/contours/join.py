"""Curves to contours: duplicates removed, ends joined, tiny ones left out, nested."""

from collections import defaultdict
from collections.abc import Collection, Iterator, Sequence
from itertools import chain as chained
from typing import TYPE_CHECKING, Any

import numpy as np
import shapely
from msgspec import Struct, field
from msgspec.structs import replace

from beamcam.errors import Diagnostic, Severity, Source, errors_in
from beamcam.geometry.array_types import Floats
from beamcam.geometry.arrays import CurveTable, near_pairs, overlapping
from beamcam.geometry.chains import Chains, join_curves
from beamcam.geometry.curves import Line
from beamcam.geometry.plane import distance
from beamcam.machine.torch import Torch, TorchProcess
from beamcam.planning.contours import rules, running_back
from beamcam.planning.contours.assign_process import AssignedCurve
from beamcam.planning.contours.crossing import crossings, refuse_tangles, taken_apart
from beamcam.planning.contours.outline import (
    Drawn,
    Shape,
    entity,
    invalid,
    points_of,
    rings_of,
    signed_areas,
    valid,
)
from beamcam.planning.contours.repeats import Repeats, contours_once, loose_once

if TYPE_CHECKING:
    from numpy.typing import NDArray


#: A gap as wide as the machine closes is within it, whatever the last digits of its ends.
SLACK = 1 + 1e-6

#: So many of the curves that meet at a junction are named.
SHOWN_CURVES = 6


class Joined(Struct):
    """Contours, and the outcome of all other curves."""

    shapes: list[Shape] = field(default_factory=list)  #: in the order of their first features
    repeats: Repeats = field(default_factory=Repeats)
    small: dict[int, Source] = field(default_factory=dict)  #: features too small to be cut
    remarks: list[Diagnostic] = field(default_factory=list)
    refusals: list[Diagnostic] = field(default_factory=list)


def join(
    assigned: Sequence[AssignedCurve], curves: CurveTable, torch: Torch, kerf: float,
    rings: Collection[int] = (),
) -> Joined:  # fmt: skip
    """The contours that `assigned` makes, each process for itself; `curves` are its curves.

    A feature whose curves close stays as it is drawn; all others are joined end to end. What lies
    on others is taken away, and so are contours no larger than the gap that is closed between two
    ends: there the tool would not move. `kerf` is what is kept off closed cuts; features that say
    that they are closed (`rings`) have to be.
    """
    joined = Joined()
    free = curves.free()
    notes = [
        *running_back.remarks(assigned, free, kerf),
        *running_back.free_repeats(assigned, free),
    ]
    for one in notes:
        (joined.refusals if one.severity is Severity.ERROR else joined.remarks).append(one)
    loose, gaping = _closed_features(assigned, curves, torch.gap, rings, joined)
    straight = {k for k in free if running_back.is_straight(assigned[k].curve)}
    may_repeat = bool(straight or overlapping(curves, [w.process for w in assigned]))
    for (process, _), numbers in loose.items():
        once, ends = [assigned[k] for k in numbers], curves.ends[numbers]
        if straight:
            once = [
                replace(w, curve=Line(w.curve.start, w.curve.end)) if k in straight else w
                for k, w in zip(numbers, once, strict=True)
            ]
        if may_repeat:
            once = loose_once(once, joined.repeats)
            ends = CurveTable([w.curve for w in once]).ends
        chains = join_curves([w.curve for w in once], torch.gap, ends=ends)
        for chain in chains.chains:
            members = [once[m] for m in chain.members if m >= 0]
            features, first = tuple(sorted({m.feature for m in members})), members[0]
            shape = (process, chain.curves, chain.closed, features, first.source)
            joined.shapes.append(Shape(*shape, look=first.look))
        for k in chains.dropped:
            joined.small.setdefault(once[k].feature, once[k].source)
        if process == "cut":
            _add_stops(joined, chains, once, torch, kerf)
            _add_closed_gaps(joined, once, ends, torch)
    joined.refusals += _not_closed(joined.shapes, gaping)
    joined.shapes.sort(key=lambda shape: shape.features[0])
    if may_repeat:
        kept = contours_once(joined.shapes, torch.gap, joined.repeats, kerf)
        joined.shapes = list(chained.from_iterable(kept))
    if kerf:
        joined.shapes = [running_back.without_steps_back(shape) for shape in joined.shapes]
    made = {feature for shape in joined.shapes for feature in shape.features}
    joined.small = {f: source for f, source in joined.small.items() if f not in made}
    for source in [*joined.small.values()][:1]:
        count, expected = len(joined.small), f"{torch.gap:g}"
        joined.remarks.append(rules.TINY.at(source, count=count, expected=expected))
    joined.remarks += joined.repeats.remarks()
    joined.refusals += joined.repeats.refusals
    return joined


def _not_closed(shapes: Sequence[Shape], gaping: set[int]) -> Iterator[Diagnostic]:
    """An error for each cut of a feature that is declared closed and has gaps."""
    for s in shapes:
        if s.process == "cut" and not s.closed and not gaping.isdisjoint(s.features):
            a, b = s.curves[0].start, s.curves[-1].end
            (x0, y0), (x1, y1) = ((f"{x:.3f}", f"{y:.3f}") for x, y in (a, b))
            found = f"{distance(a, b):.3f}"
            yield rules.NOT_CLOSED.at(s.source, x0=x0, y0=y0, x1=x1, y1=y1, found=found)


def _closed_features(
    assigned: Sequence[AssignedCurve], curves: CurveTable, gap: float, rings: Collection[int],
    joined: Joined,
) -> tuple[dict[tuple[TorchProcess, str], list[int]], set[int]]:  # fmt: skip
    """Keep the features that close by themselves; the numbers of other curves, by process and
    settings.

    And the features that say that they are closed (`rings`), and have gaps. The curves of a
    feature that closes follow one another and end where they begin.
    """
    loose: dict[tuple[TorchProcess, str], list[int]] = defaultdict(list)
    gaping: set[int] = set()
    hulls, places = curves.hulls, curves.ends
    points = set(
        np.flatnonzero(
            np.ptp(hulls.reshape(-1, 2, 2), axis=1).max(axis=1) <= running_back.SAME_POINT
        )
    )
    features = np.array([w.feature for w in assigned])
    begins = np.flatnonzero(np.concatenate(([True], features[1:] != features[:-1])))
    ends = np.append(begins[1:], len(assigned))
    before = np.arange(len(assigned)) - 1
    before[begins] = ends - 1
    gaps = np.abs(places[:, :2] - places[before, 2:]).max(axis=1) > running_back.SAME_POINT
    closed = ~np.logical_or.reduceat(gaps, begins)
    low, high = np.minimum.reduceat(hulls, begins)[:, :2], np.maximum.reduceat(hulls, begins)[:, 2:]
    small = np.hypot(*(high - low).T) <= gap
    columns = (column.tolist() for column in (begins, ends, closed, small))
    for begin, end, is_closed, is_small in zip(*columns, strict=True):
        first = assigned[begin]
        lines = is_closed and running_back.is_there_and_back(assigned[begin:end])
        if lines or not is_closed:
            loose[first.process, first.look] += range(begin, end)
            if not lines and first.feature in rings:
                gaping.add(first.feature)
        elif is_small:
            joined.small[first.feature] = first.source
        else:
            ring = tuple([assigned[k].curve for k in range(begin, end) if k not in points])
            one = first.feature
            shape = Shape(first.process, ring, True, (one,), first.source, look=first.look)
            joined.shapes.append(shape)
    return loose, gaping


def _add_closed_gaps(
    joined: Joined, once: Sequence[AssignedCurve], ends: Floats, torch: Torch
) -> None:
    """Tell of gaps that were closed, where that moves an end by more than the path may be off."""
    points = ends.reshape(-1, 2)
    first, second = near_pairs(points, torch.gap * SLACK)
    width = np.hypot(*(points[first] - points[second]).T)
    # An end that meets another has no gap beside it, and the ends of one curve are not joined.
    met, wide = np.zeros(len(points), dtype=bool), width > torch.tolerance
    met[first[~wide]] = met[second[~wide]] = True
    apart = wide & (first // 2 != second // 2) & ~met[first] & ~met[second]
    if apart.any():
        k = int(np.argmax(np.where(apart, width, 0.0)))
        source, place = once[int(first[k]) // 2].source, rules.at_place(points[first[k]])
        widths = {"count": int(apart.sum()), "found": f"{width[k]:.3f}"}
        joined.remarks.append(rules.GAPS.at(source, **widths, **place))


def _add_stops(
    joined: Joined, chains: Chains, once: Sequence[AssignedCurve], torch: Torch, kerf: float
) -> None:
    """Says where chains stop: where several curves meet, and at gaps."""
    for junction in chains.junctions:
        names = dict.fromkeys(entity(once[m].source) for m in junction.members)
        values = {"found": len(junction.members), "other": ", ".join(list(names)[1:SHOWN_CURVES])}
        values |= rules.at_place(junction.point)
        source = once[junction.members[0]].source
        if kerf and junction.in_ring:
            joined.refusals.append(rules.BRANCHED.at(source, kerf=f"{kerf:g}", **values))
        else:
            joined.remarks.append(rules.JUNCTION.at(source, **values))
    for gap in chains.gaps:
        widths = {"found": f"{gap.width:.4f}", "expected": f"{torch.gap:g}"}
        source, place = once[gap.members[0]].source, rules.at_place(gap.start)
        joined.remarks.append(rules.GAP.at(source, **widths, **place))


# --- nests ----------------------------------------------------------------------------------------

# Which contour lies inside which.


#: A contour that is not wider than twice this, in mm, on an average has no inside.
MIN_WIDTH = 1e-3


def nest(
    shapes: Sequence[Shape], drawn: Drawn, curves: Sequence[AssignedCurve], tolerance: float,
    gap: float, kerf: float,
) -> tuple[list[Shape], list[Diagnostic]]:  # fmt: skip
    """The shapes with their area, depth and parent, and remarks on those that cross.

    A contour lies in another of greater area that a point inside it lies in. Contours that touch
    are told apart by that, those that cross are not. `tolerance` is the machine's, and `gap` what
    it closes between two ends; `curves` are the curves that the shapes were made of, and `drawn`
    points of the shapes with the shape of each. With a `kerf`, contours of waste that hangs
    together by a point only are taken apart there.
    """
    closed = [i for i, s in enumerate(shapes) if s.closed and s.process == "cut"]
    if not closed:
        return list(shapes), []
    points, owner = drawn
    number = np.full(len(shapes), -1)
    number[closed] = np.arange(len(closed))
    mine = number[owner] >= 0
    rings = rings_of(points[mine], number[owner[mine]], len(closed))
    bad = invalid(rings)
    cuts = [shapes[i] for i in closed]
    if bad:
        refuse_tangles(cuts, rings, bad, curves)
    diagnostics: list[Diagnostic] = []
    # Pairs of rings that cross or touch. The one with more points is prepared: it has its
    # neighbours in a tree.
    edges = shapely.get_exterior_ring(rings)
    first, second = shapely.STRtree(edges).query(edges)
    first, second = first[first < second], second[first < second]
    sizes = shapely.get_num_coordinates(edges)
    swap = sizes[second] > sizes[first]
    large, small = np.where(swap, second, first), np.where(swap, first, second)
    shapely.prepare(edges[large])
    meet = shapely.intersects(edges[large], edges[small])
    pairs = sorted(zip(first[meet].tolist(), second[meet].tolist(), strict=True))
    if pairs or bad:
        diagnostics = crossings(cuts, rings, bad, pairs, curves, tolerance, gap, kerf)
    nested = _nested(shapes, closed, rings, bad)
    if not kerf or errors_in(diagnostics):
        return nested, diagnostics
    turning = running_back.turns((points[mine], number[owner[mine]]))
    needles = [
        one
        for k, at in turning.items()
        for one in running_back.needles_beside(cuts[k].source, *at, tolerance)
    ]
    if needles:
        return nested, [*diagnostics, *needles]
    # A needle whose mouth is written a hair wide does not meet itself.
    which = [closed[k] for k in sorted({*bad, *turning})]
    if not which:
        return nested, diagnostics
    more, flat = taken_apart(nested, which, tolerance)
    if flat:
        return nested, [*diagnostics, *flat]
    if len(more) > len(nested):
        drawn = points_of([s.curves for s in more], tolerance / 4)
        return nest(more, drawn, curves, tolerance, gap, kerf)
    return nested, diagnostics


def _nested(
    shapes: Sequence[Shape], closed: Sequence[int], rings: "NDArray[Any]", bad: Sequence[int]
) -> list[Shape]:
    """The shapes with their places; `rings` are the polygons of those that are `closed`."""
    placed = list(shapes)
    signed = signed_areas(rings)
    areas = np.abs(signed)
    signed[areas <= MIN_WIDTH * shapely.length(rings)] = 0.0
    tree = shapely.STRtree(rings)
    with np.errstate(over="ignore"):  # it divides by sides of next to nothing too
        points = list(shapely.point_on_surface(valid(rings, bad)))
    opened = [i for i, shape in enumerate(shapes) if shape.process == "cut" and not shape.closed]
    middles = [shapes[i].curves[0].point(0.5) for i in opened]
    points += shapely.points(np.reshape(middles, (-1, 2))).tolist()
    which = [*closed, *opened]
    own_area = [*areas, *[0.0] * len(opened)]
    inner, outer = tree.query(points, predicate="within")
    around: dict[int, list[int]] = defaultdict(list)
    for a, b in zip(inner.tolist(), outer.tolist(), strict=True):
        if which[a] != closed[b] and own_area[a] < areas[b]:
            around[which[a]].append(b)
    for i, area in zip(which, [*signed.tolist(), *[0.0] * len(opened)], strict=True):
        rings_around = around[i]
        parent = closed[min(rings_around, key=lambda b: (areas[b], b))] if rings_around else -1
        placed[i] = replace(shapes[i], area=area, depth=len(rings_around), parent=parent)
    for i, rings_around in around.items():
        for b in rings_around:
            _put_inside(placed, i, closed[b])
    return placed


def _put_inside(shapes: list[Shape], inner: int, outer: int) -> None:
    """Make a contour one of those around another, in the order of their areas.

    Of contours that cross, both around a third, neither lies in the other: the smaller of them
    counts as inner, so that what lies in both is done before both.
    """

    def size(k: int) -> tuple[float, int]:
        return abs(shapes[k].area), k

    while (parent := shapes[inner].parent) != outer:
        if parent < 0 or size(outer) < size(parent):
            shapes[inner] = replace(shapes[inner], parent=outer)
            if parent < 0:
                return
            inner, outer = outer, parent
        else:
            inner = parent
