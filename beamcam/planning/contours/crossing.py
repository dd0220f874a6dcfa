"""Closed cuts that cross themselves or one another, and those that only touch themselves."""

from collections import Counter
from collections.abc import Iterator, Sequence
from typing import Any

import numpy as np
import shapely
from msgspec.structs import replace
from numpy.typing import NDArray

from beamcam.errors import Diagnostic, PlanError, Rule, Source
from beamcam.geometry.arrays import near_pairs
from beamcam.geometry.curves import Curve, Line, signed_area
from beamcam.geometry.plane import Point, distance
from beamcam.model.lengths import total_length
from beamcam.planning.contours import rules
from beamcam.planning.contours.assign_process import AssignedCurve
from beamcam.planning.contours.outline import (
    Shape,
    entity,
    invalid,
    outlines,
    signed_areas,
    valid,
    ways,
)
from beamcam.planning.contours.running_back import FINE

#: Two contours that lie over one another by less than this share of the machine's tolerance
#: touch: so near are the chords that stand for their curves, and what programs round.
TOUCH_SHARE = 0.25

#: Contours that may cross are looked at with chords so near to them, as a share of the tolerance.
FINE_SHARE = 0.02

#: Segments that one of a contour meets, itself and its neighbours among them, on an average.
MAX_MEETINGS = 12
GRID = 1e-6  #: mm, on which a ring is taken apart where it meets itself
MAX_ASKED = 1000  #: segments of which the meetings are counted
SHOWN = 20  #: crossings are named one by one up to so many


def crossings(
    closed: Sequence[Shape], rings: NDArray[Any], bad: Sequence[int],
    pairs: Sequence[tuple[int, int]], curves: Sequence[AssignedCurve], tolerance: float,
    gap: float, kerf: float,
) -> list[Diagnostic]:  # fmt: skip
    """Closed cuts that cross themselves or one another, with a place and both entities.

    Those that are `bad` meet themselves, `pairs` of them one another. Errors where a kerf is to be
    kept off, as nothing says on which side; else warnings.
    """
    rule, more = rules.CROSSED, rules.MORE_CROSSED
    if kerf:
        rule, more = rules.CROSSING, rules.MORE_CROSSINGS
    entities = _Entities(curves)
    diagnostics: list[Diagnostic] = []
    for i, k in (*((k, k) for k in bad), *pairs):
        if i == k:
            own_gap = gap if len(closed[k].features) > 1 else 0.0
            place = _crosses_itself(rings[k], tolerance, own_gap)
        else:
            place = _crossing(closed[i], closed[k], tolerance)
        if place is not None:
            diagnostics.append(entities.crossing(rule, place, closed[i], closed[k]))
    if len(diagnostics) > SHOWN:
        diagnostics[SHOWN:] = [more.at(diagnostics[SHOWN].source, found=len(diagnostics) - SHOWN)]
    return diagnostics


def refuse_tangles(
    closed: Sequence[Shape], rings: NDArray[Any], bad: Sequence[int],
    curves: Sequence[AssignedCurve],
) -> None:  # fmt: skip
    """Raise PlanError for a contour that meets itself all along, as one of many turns does.

    To take it apart would take minutes; where it crosses itself is known at once.
    """
    for k in bad:
        points = shapely.get_coordinates(rings[k])
        segments = shapely.linestrings(np.stack((points[:-1], points[1:]), axis=1))
        some = segments[:: max(len(segments) // MAX_ASKED, 1)]
        meetings = shapely.STRtree(segments).query(some, predicate="intersects").shape[1]
        if meetings > MAX_MEETINGS * len(some):
            # "Self-intersection[12.5 40]"
            reason = shapely.is_valid_reason(rings[k])
            x, _, y = reason.partition("[")[2].rstrip("]").partition(" ")
            crossing = _Entities(curves).crossing
            raise PlanError(crossing(rules.CROSSING, (float(x), float(y)), closed[k], closed[k]))


def _crosses_itself(ring: Any, tolerance: float, gap: float) -> Point | None:
    """Where a ring crosses itself; None if it touches itself, or by a hair where ends were joined.

    Where it crosses there is a loop that it goes round the wrong way, or more than once. A loop
    thinner than what counts as touching is none, nor is one no larger than twice the `gap` that
    was closed between two ends. The ring is taken apart on a fine grid, on which a stretch that is
    followed many times over comes out once; exactly that takes minutes, or fails.
    """
    edge = shapely.get_exterior_ring(ring)
    corners = shapely.get_coordinates(edge)
    with np.errstate(all="ignore"):  # numbers of 1e-200 are next to nothing, and no fault
        noded = shapely.unary_union(edge, grid_size=GRID)
        faces = shapely.get_parts(shapely.polygonize([noded]))
        inside = shapely.get_coordinates(shapely.point_on_surface(faces))
    if not len(faces):
        return None
    # How often it goes counter-clockwise round each of them.
    (x0, y0), (x1, y1) = corners[:-1].T, corners[1:].T
    turns = np.empty(len(inside), dtype=np.int64)
    for k, (x, y) in enumerate(inside.tolist()):
        left = (x1 - x0) * (y - y0) - (x - x0) * (y1 - y0) > 0.0
        up, down = (y0 <= y) & (y1 > y), (y0 > y) & (y1 <= y)
        turns[k] = np.count_nonzero(up & left) - np.count_nonzero(down & ~left)
    right = int(np.sign(signed_areas(np.array([ring]))[0]))
    low, high = shapely.bounds(faces)[:, :2], shapely.bounds(faces)[:, 2:]
    is_hair = shapely.area(faces) <= tolerance * TOUCH_SHARE * shapely.length(faces)
    is_hair |= np.hypot(*(high - low).T) <= 2 * gap
    wrong = np.flatnonzero((turns != 0) & (turns != right) & ~is_hair)
    if not len(wrong):
        return None
    points = shapely.get_coordinates(faces[wrong[0]])
    cells = (np.round(some / (4 * GRID)).view(np.complex128) for some in (points, corners))
    own = np.isin(*cells).ravel()
    x, y = points[int(np.argmin(own))].tolist()
    return x, y


def _crossing(a: Shape, b: Shape, tolerance: float) -> Point | None:
    """Where two rings that meet cross; None if they touch.

    Rings that cross part the plane in what lies in both, in the one only and in the other only,
    each thicker than what counts as touching. Of two that lie on one another all round nothing
    but hairs is left outside of both.
    """
    pair = outlines([a.curves, b.curves], tolerance * FINE_SHARE)
    pair = valid(pair, invalid(pair))
    touch = tolerance * TOUCH_SHARE
    both = shapely.intersection(*pair)
    thick = [
        not shapely.buffer(piece, -touch / 2, join_style="mitre").is_empty
        for piece in (both, shapely.difference(*pair), shapely.difference(*pair[::-1]))
    ]
    if not thick[0] or thick[1] != thick[2]:
        return None
    shared = shapely.intersection(*shapely.boundary(pair))
    points = shapely.get_coordinates(shared)
    if not len(points):
        return None
    x, y = points[0].tolist()
    return x, y


class _Entities:
    """The curves of features, looked at where contours cross."""

    def __init__(self, curves: Sequence[AssignedCurve]) -> None:
        self._curves = curves
        self._of: dict[int, list[AssignedCurve]] = {}

    def crossing(self, rule: Rule, place: Point, a: Shape, b: Shape) -> Diagnostic:
        """That the curve of `a` at a place crosses that of `b`.

        If both are one, its two curves that are nearest.
        """
        source, *others = self._nearest(place, a)
        if a is not b:
            other = entity(self._nearest(place, b)[0])
        else:
            others = [one for one in others if one != source]
            other = entity(others[0]) if others else "itself"
        return rule.at(source, other=other, **rules.at_place(place))

    def _nearest(self, place: Point, shape: Shape) -> list[Source]:
        """The sources of the two curves of a shape nearest to a place, one if there is but one."""
        if not self._of:
            for w in self._curves:
                self._of.setdefault(w.feature, []).append(w)
        curves = [w for feature in shape.features for w in self._of.get(feature, [])]
        if len(shape.features) < 2 or len(curves) < 2:
            return [shape.source]
        away = shapely.distance(ways([(w.curve,) for w in curves], 0.01), shapely.Point(place))
        return [curves[k].source for k in np.argsort(away, kind="stable")[:2].tolist()]


# --- loops ----------------------------------------------------------------------------------------

# Contours that pass a place again, taken apart where waste hangs together by that point only.
#
#  _________
# |   ___   |   The window touches the edge of the plate at o, and both are drawn as one contour:
# |  |   |  |   two regions of waste, each cut by itself. Where it is the part that hangs together
# |  |   |  |   by a point, the contour stays whole, as nothing says that it is two parts.
# |__o___|__|


SAME_PLACE = 1e-4  #: mm, of a place that is passed again: what is nearer is written alike
SAME_POINT = 1e-9  #: of ends that need no joining


def taken_apart(
    shapes: Sequence[Shape], which: Sequence[int], tolerance: float
) -> tuple[list[Shape], list[Diagnostic]]:
    """The shapes, some of them as the contours of the waste that hangs together there by points.

    And an error for each of these that is followed there and back: it goes round nothing that is
    wider than half the machine's tolerance.
    """
    apart: list[Shape] = []
    flat: list[Diagnostic] = []
    numbers = set(which)
    for k, shape in enumerate(shapes):
        rings = list(_rings(shape, tolerance)) if k in numbers else [shape.curves]
        apart += [replace(shape, curves=ring) for ring in rings] if len(rings) > 1 else [shape]
        for ring in rings if len(rings) > 1 else ():
            if _is_flat(ring, tolerance):
                start = ring[0].start
                end = max((curve.end for curve in ring), key=lambda at: distance(at, start))
                length = total_length(ring) / 2
                place = rules.at_place(end)
                flat.append(rules.RUNS_BACK_KERF.at(shape.source, found=f"{length:.3f}", **place))
    return apart, flat


def _rings(shape: Shape, tolerance: float) -> Iterator[tuple[Curve, ...]]:
    """The contours that one falls into."""
    # For each curve the first one that begins where it does.
    places = list(range(len(shape.curves)))
    pairs = near_pairs(np.array([curve.start for curve in shape.curves]), SAME_PLACE)
    for a, b in sorted(zip(*(some.tolist() for some in pairs), strict=True)):
        places[max(a, b)] = places[min(a, b)]
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
            if not _is_flat(loop, tolerance):
                # It stays where it goes round no waste by itself.
                rest = [around[n] for n in (*kept[:at], *range(k, len(around)))]
                inner, outer = shapely.make_valid(outlines([loop, rest], FINE))
                if bool(shapely.point_on_surface(inner).within(outer)) == shape.is_hole:
                    break
            yield loop
            del kept[at:]
        if k < len(around):
            kept.append(k)
    yield _closed([around[n] for n in kept])


def _closed(ring: Sequence[Curve]) -> tuple[Curve, ...]:
    """A chain whose ends are written alike, closed."""
    a, b = ring[-1].end, ring[0].start
    return tuple(ring) if distance(a, b) <= SAME_POINT else (*ring, Line(a, b))


def _is_flat(loop: tuple[Curve, ...], tolerance: float) -> bool:
    return abs(signed_area(loop)) <= tolerance / 4 * total_length(loop)
