"""Nesting of contours: which lies inside which."""

from collections import defaultdict
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

from msgspec.structs import replace

from beamcam.errors import Diagnostic, PlanError, Rule, Source, errors_in
from beamcam.geometry.plane import Point
from beamcam.planning.contours import rules
from beamcam.planning.contours.assign_process import AssignedCurve
from beamcam.planning.contours.doubling import told_beside, turns
from beamcam.planning.contours.outline import (
    Drawn,
    Shape,
    entity,
    invalid,
    outlines,
    points_of,
    rings_of,
    signed_areas,
    valid,
    ways,
)
from beamcam.planning.contours.pinch import taken_apart, told_flat

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from beamcam.geometry.array_types import Counts, Floats

# --- crossing -------------------------------------------------------------------------------------

# Which closed cuts cross themselves or one another, and where.


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
    closed: Sequence[Shape],
    rings: "NDArray[Any]",
    bad: Sequence[int],
    curves: Sequence[AssignedCurve],
    tolerance: float,
    gap: float,
    kerf: float,
) -> list[Diagnostic]:
    """Closed cuts that cross themselves or one another, with a place and both entities.

    Those that are `bad` meet themselves. Errors where a kerf is to be kept off, as nothing says on
    which side; else warnings.
    """
    import shapely

    entities = _Entities(curves)
    rule = rules.CROSSING if kerf else rules.CROSSED
    diagnostics: list[Diagnostic] = []
    for k, crossed in _loops(closed, rings, bad, tolerance, gap):
        diagnostics.append(_told(rule, *entities.at(crossed, closed[k], closed[k]), crossed))
    for i, k in _meeting(shapely.get_exterior_ring(rings)):
        place = _crossing(closed[i], closed[k], tolerance)
        if place is not None:
            diagnostics.append(_told(rule, *entities.at(place, closed[i], closed[k]), place))
    if len(diagnostics) > SHOWN:
        more = rules.MORE_CROSSINGS if kerf else rules.MORE_CROSSED
        diagnostics[SHOWN:] = [more.at(diagnostics[SHOWN].source, found=len(diagnostics) - SHOWN)]
    return diagnostics


def refuse_tangles(
    closed: Sequence[Shape],
    rings: "NDArray[Any]",
    bad: Sequence[int],
    curves: Sequence[AssignedCurve],
) -> None:
    """Raise PlanError for a contour that meets itself all along, as one of many turns does.

    To take it apart would take minutes; where it crosses itself is known at once.
    """
    import numpy as np
    import shapely

    for k in bad:
        points = shapely.get_coordinates(rings[k])
        segments = shapely.linestrings(np.stack((points[:-1], points[1:]), axis=1))
        some = segments[:: max(len(segments) // MAX_ASKED, 1)]
        meetings = shapely.STRtree(segments).query(some, predicate="intersects").shape[1]
        if meetings > MAX_MEETINGS * len(some):
            place = _reason_place(rings[k])
            entities = _Entities(curves).at(place, closed[k], closed[k])
            raise PlanError(_told(rules.CROSSING, *entities, place))


def _reason_place(ring: Any) -> Point:
    """The place that shapely names: "Self-intersection[12.5 40]"."""
    import shapely

    x, _, y = shapely.is_valid_reason(ring).partition("[")[2].rstrip("]").partition(" ")
    return float(x), float(y)


def _told(rule: Rule, source: Source, other: str, place: Point) -> Diagnostic:
    return rule.at(source, other=other, x=f"{place[0]:.3f}", y=f"{place[1]:.3f}")


def _meeting(boundaries: "NDArray[Any]") -> list[tuple[int, int]]:
    """Pairs of rings that cross or touch, ascending."""
    import numpy as np
    import shapely

    first, second = shapely.STRtree(boundaries).query(boundaries)
    pair = first < second
    first, second = first[pair], second[pair]
    # The one with more points is prepared: it has its neighbours in a tree.
    sizes = shapely.get_num_coordinates(boundaries)
    swap = sizes[second] > sizes[first]
    large, small = np.where(swap, second, first), np.where(swap, first, second)
    shapely.prepare(boundaries[large])
    meet = shapely.intersects(boundaries[large], boundaries[small])
    return sorted(zip(first[meet].tolist(), second[meet].tolist(), strict=True))


def _loops(
    closed: Sequence[Shape],
    rings: "NDArray[Any]",
    bad: Sequence[int],
    tolerance: float,
    gap: float,
) -> list[tuple[int, Point]]:
    """Which of the rings that are `bad` cross themselves, and where."""
    loops = []
    for k in bad:
        place = _crosses_itself(rings[k], tolerance, gap if len(closed[k].features) > 1 else 0.0)
        if place is not None:
            loops.append((k, place))
    return loops


def _crosses_itself(ring: Any, tolerance: float, gap: float) -> Point | None:
    """Where a ring crosses itself; None if it touches itself, or by a hair where ends were joined.

    Where it crosses there is a loop that it goes round the wrong way, or more than once. A loop
    thinner than what counts as touching is none, nor is one no larger than twice the `gap` that
    was closed between two ends. The ring is taken apart on a fine grid, on which a stretch that is
    followed many times over comes out once; exactly that takes minutes, or fails.
    """
    import numpy as np
    import shapely

    edge = shapely.get_exterior_ring(ring)
    corners = shapely.get_coordinates(edge)
    with np.errstate(all="ignore"):  # numbers of 1e-200 are next to nothing, and no fault
        noded = shapely.unary_union(edge, grid_size=GRID)
        faces = shapely.get_parts(shapely.polygonize([noded]))
        inside = shapely.get_coordinates(shapely.point_on_surface(faces))
    if not len(faces):
        return None
    turns = _turns(corners, inside)
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


def _turns(ring: "Floats", points: "Floats") -> "Counts":
    """How often a ring (n, 2) goes counter-clockwise round each of some points."""
    import numpy as np

    (x0, y0), (x1, y1) = ring[:-1].T, ring[1:].T
    turns = np.empty(len(points), dtype=np.int64)
    for k, (x, y) in enumerate(points.tolist()):
        left = (x1 - x0) * (y - y0) - (x - x0) * (y1 - y0) > 0.0
        up, down = (y0 <= y) & (y1 > y), (y0 > y) & (y1 <= y)
        turns[k] = np.count_nonzero(up & left) - np.count_nonzero(down & ~left)
    return turns


def _crossing(a: Shape, b: Shape, tolerance: float) -> Point | None:
    """Where two rings that meet cross; None if they touch.

    Rings that cross part the plane in what lies in both, in the one only and in the other only,
    each thicker than what counts as touching. Of two that lie on one another all round nothing
    but hairs is left outside of both.
    """
    import shapely

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
        self._wanted = curves
        self._of: dict[int, list[AssignedCurve]] = {}

    def at(self, place: Point, a: Shape, b: Shape) -> tuple[Source, str]:
        """The source of the curve of `a` at a place, and how the curve of `b` there is called.

        If both are one, its two curves that are nearest.
        """
        first = self._nearest(place, a)
        if a is not b:
            return first[0], entity(self._nearest(place, b)[0])
        others = [source for source in first if source != first[0]]
        return first[0], entity(others[0]) if others else "itself"

    def _nearest(self, place: Point, shape: Shape) -> list[Source]:
        """The sources of the two curves of a shape nearest to a place, one if there is but one."""
        import numpy as np
        import shapely

        if not self._of:
            for w in self._wanted:
                self._of.setdefault(w.feature, []).append(w)
        curves = [w for feature in shape.features for w in self._of.get(feature, [])]
        if len(shape.features) < 2 or len(curves) < 2:
            return [shape.source]
        away = shapely.distance(ways([(w.curve,) for w in curves], 0.01), shapely.Point(place))
        return [curves[k].source for k in np.argsort(away, kind="stable")[:2].tolist()]


#: A contour that is not wider than twice this, in mm, on an average has no inside.
MIN_WIDTH = 1e-3


def nest(
    shapes: Sequence[Shape],
    drawn: Drawn,
    curves: Sequence[AssignedCurve],
    tolerance: float,
    gap: float,
    kerf: float,
) -> tuple[list[Shape], list[Diagnostic]]:
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
    import numpy as np

    points, owner = drawn
    number = np.full(len(shapes), -1)
    number[closed] = np.arange(len(closed))
    mine = number[owner] >= 0
    rings = rings_of(points[mine], number[owner[mine]], len(closed))
    bad = invalid(rings)
    refuse_tangles([shapes[i] for i in closed], rings, bad, curves)
    diagnostics = crossings([shapes[i] for i in closed], rings, bad, curves, tolerance, gap, kerf)
    nested = _nested(shapes, closed, rings, bad)
    if not kerf or errors_in(diagnostics):
        return nested, diagnostics
    turning = turns((points[mine], number[owner[mine]]))
    needles = list(told_beside([shapes[i] for i in closed], turning, tolerance))
    if needles:
        return nested, [*diagnostics, *needles]
    # A needle whose mouth is written a hair wide does not meet itself.
    which = [closed[k] for k in sorted({*bad, *turning})]
    if not which:
        return nested, diagnostics
    more, flat = taken_apart(nested, which, tolerance)
    if flat:
        return nested, [*diagnostics, *told_flat(flat)]
    if len(more) > len(nested):
        drawn = points_of([s.curves for s in more], tolerance / 4)
        return nest(more, drawn, curves, tolerance, gap, kerf)
    return nested, diagnostics


def _nested(
    shapes: Sequence[Shape], closed: Sequence[int], rings: "NDArray[Any]", bad: Sequence[int]
) -> list[Shape]:
    """The shapes with their places; `rings` are the polygons of those that are `closed`."""
    import numpy as np
    import shapely

    found = list(shapes)
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
        found[i] = replace(shapes[i], area=area, depth=len(rings_around), parent=parent)
    for i, rings_around in around.items():
        for b in rings_around:
            _put_inside(found, i, closed[b])
    return found


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
