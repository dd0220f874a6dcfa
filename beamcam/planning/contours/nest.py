"""What lies inside what, and which contours cross and so have no inside."""

from collections import defaultdict
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

from msgspec.structs import replace

from beamcam.errors import Diagnostic, PlanError, Rule, Source
from beamcam.geometry.plane import Point
from beamcam.planning.contours import rules
from beamcam.planning.contours.gather import Wanted
from beamcam.planning.contours.outline import outlines, ways
from beamcam.planning.contours.shape import Shape, entity

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from beamcam.geometry.array_types import Floats

#: Two contours that lie over one another by less than this share of the machine's tolerance
#: touch: so near are the chords that stand for their curves, and what programs round.
TOUCH_SHARE = 0.25

#: Contours that may cross are looked at with chords so near to them, as a share of the tolerance.
FINE_SHARE = 0.02

#: Segments that one of a contour meets, itself and its neighbours among them, on an average.
MAX_MEETINGS = 12
SHOWN = 20  #: crossings are named one by one up to so many


def nest(
    shapes: Sequence[Shape], wanted: Sequence[Wanted], tolerance: float, kerf: float
) -> tuple[list[Shape], list[Diagnostic]]:
    """The shapes with their area, depth and parent, and what is to be said of those that cross.

    A contour lies in another of greater area that a point inside it lies in. Contours that touch
    are told apart by that, those that cross are not. `tolerance` is the machine's; `wanted` are
    the curves that the shapes were made of.
    """
    closed = [i for i, s in enumerate(shapes) if s.closed and s.process == "cut"]
    if not closed:
        return list(shapes), []
    rings = outlines([shapes[i].curves for i in closed], tolerance / 4)
    bad = _invalid(rings)
    _refuse_tangles([shapes[i] for i in closed], rings, bad, wanted)
    said = _crossings([shapes[i] for i in closed], rings, bad, wanted, tolerance, kerf)
    return _nested(shapes, closed, rings, bad), said


def _nested(
    shapes: Sequence[Shape], closed: Sequence[int], rings: "NDArray[Any]", bad: Sequence[int]
) -> list[Shape]:
    """The shapes with their places; `rings` are the polygons of those that are `closed`."""
    import numpy as np
    import shapely

    found = list(shapes)
    signed = _signed_areas(rings)
    areas = np.abs(signed)
    tree = shapely.STRtree(rings)
    points = list(shapely.point_on_surface(_valid(rings, bad)))
    asked = list(closed)
    own_area = list(areas)
    for i, shape in enumerate(shapes):
        if shape.process == "cut" and not shape.closed:
            points.append(shapely.Point(shape.curves[0].point(0.5)))
            asked.append(i)
            own_area.append(0.0)
    inner, outer = tree.query(points, predicate="within")
    around: dict[int, list[int]] = defaultdict(list)
    for a, b in zip(inner.tolist(), outer.tolist(), strict=True):
        if asked[a] != closed[b] and own_area[a] < areas[b]:
            around[asked[a]].append(b)
    for i, area in zip(asked, [*signed.tolist(), *[0.0] * (len(asked) - len(closed))], strict=True):
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


def _signed_areas(rings: "NDArray[Any]") -> "Floats":
    """The areas of polygons, above 0 for those that run counter-clockwise.

    By the corners about the first one of each: asked which way a ring runs, GEOS looks at its
    highest corner only, and is wrong where that is double but for the last digit.
    """
    import numpy as np
    import shapely

    points, owner = shapely.get_coordinates(rings, return_index=True)
    counts = np.bincount(owner, minlength=len(rings))
    points -= points[np.repeat(np.cumsum(counts) - counts, counts)]
    (x0, y0), (x1, y1) = points[:-1].T, points[1:].T
    # From the last corner of a ring to the first of the next one, which is its own 0, 0.
    swept = (x0 * y1 - x1 * y0) / 2
    return np.bincount(owner[:-1], swept, len(rings)).astype(np.float64)


def _invalid(rings: "NDArray[Any]") -> list[int]:
    """The numbers of the rings that meet themselves, ascending."""
    import numpy as np
    import shapely

    found: list[int] = np.flatnonzero(~shapely.is_valid(rings)).tolist()
    return found


def _valid(rings: "NDArray[Any]", bad: Sequence[int]) -> "NDArray[Any]":
    """The rings, those that are `bad` taken apart."""
    import shapely

    if not bad:
        return rings
    found = rings.copy()
    found[bad] = shapely.make_valid(rings[bad])
    return found


def _refuse_tangles(
    closed: Sequence[Shape], rings: "NDArray[Any]", bad: Sequence[int], wanted: Sequence[Wanted]
) -> None:
    """Raise PlanError for a contour that meets itself all along, as one of many turns does.

    To take it apart would take minutes; where it crosses itself is known at once.
    """
    import numpy as np
    import shapely

    for k in bad:
        points = shapely.get_coordinates(rings[k])
        segments = shapely.linestrings(np.stack((points[:-1], points[1:]), axis=1))
        meetings = shapely.STRtree(segments).query(segments, predicate="intersects").shape[1]
        if meetings > MAX_MEETINGS * len(segments):
            place = _reason_place(rings[k])
            entities = _Entities(wanted).at(place, closed[k], closed[k])
            raise PlanError(_told(rules.CROSSING, *entities, place))


def _reason_place(ring: Any) -> Point:
    """The place that shapely names: "Self-intersection[12.5 40]"."""
    import shapely

    x, _, y = shapely.is_valid_reason(ring).partition("[")[2].rstrip("]").partition(" ")
    return float(x), float(y)


def _crossings(
    closed: Sequence[Shape],
    rings: "NDArray[Any]",
    bad: Sequence[int],
    wanted: Sequence[Wanted],
    tolerance: float,
    kerf: float,
) -> list[Diagnostic]:
    """Closed cuts that cross themselves or one another, with a place and both entities.

    Errors where a kerf is to be kept off, as nothing says on which side; else warnings.
    """
    import shapely

    entities = _Entities(wanted)
    rule = rules.CROSSING if kerf else rules.CROSSED
    said: list[Diagnostic] = []
    for k in bad:
        place = _crosses_itself(closed[k], rings[k], tolerance)
        if place is not None:
            said.append(_told(rule, *entities.at(place, closed[k], closed[k]), place))
    for i, k in _meeting(shapely.get_exterior_ring(rings)):
        place = _crossing(closed[i], closed[k], tolerance)
        if place is not None:
            said.append(_told(rule, *entities.at(place, closed[i], closed[k]), place))
    if len(said) > SHOWN:
        more = rules.MORE_CROSSINGS if kerf else rules.MORE_CROSSED
        said[SHOWN:] = [more.at(said[SHOWN].source, found=len(said) - SHOWN)]
    return said


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
    shapely.prepare(boundaries[np.unique(large)])
    meet = shapely.intersects(boundaries[large], boundaries[small])
    return sorted(zip(first[meet].tolist(), second[meet].tolist(), strict=True))


def _crosses_itself(shape: Shape, ring: Any, tolerance: float) -> Point | None:
    """Where a ring crosses itself; None if it touches itself, or by a hair where ends were joined.

    That changes no inside worth speaking of.
    """
    import shapely

    if abs(shapely.make_valid(ring).area - ring.area) <= tolerance / 4 * ring.length:
        return None
    return _reason_place(ring)


def _crossing(a: Shape, b: Shape, tolerance: float) -> Point | None:
    """Where two rings that meet cross; None if they touch.

    Rings that cross part the plane in what lies in both, in the one only and in the other only,
    each thicker than what counts as touching. Of two that lie on one another all round nothing
    but hairs is left outside of both.
    """
    import shapely

    pair = outlines([a.curves, b.curves], tolerance * FINE_SHARE)
    pair = _valid(pair, _invalid(pair))
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

    def __init__(self, wanted: Sequence[Wanted]) -> None:
        self._wanted = wanted
        self._of: dict[int, list[Wanted]] = {}

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
