"""Curves that lie on others in part: there they are drawn twice, and count once."""

from collections.abc import Sequence

import numpy as np
import shapely
from msgspec import Struct
from shapely import STRtree
from shapely.ops import substring

from beamcam.geometry.array_types import Counts, Flags, Floats
from beamcam.verify.sheets.toolpaths import Toolpaths


class Stretches(Struct):
    """What of each way counts: its ends, and points along it."""

    starts: Floats  #: (n, 2)
    ends: Floats
    points: Floats  #: of all ways, chords between them
    begins: Counts  #: where the points of each way begin, (n + 1,)

    def rows(self, way: int) -> Counts:
        """The numbers of a way's points."""
        return np.arange(self.begins[way], self.begins[way + 1])


def whole(toolpaths: Toolpaths, fine: float) -> Stretches:
    """All ways from end to end; chords are at most `fine` off."""
    points, begins = toolpaths.outlines(fine)
    return Stretches(toolpaths.starts.copy(), toolpaths.ends.copy(), points, begins)


def trim(
    found: Stretches, toolpaths: Toolpaths, loose: Sequence[int], rank: Counts, same: float
) -> None:
    """Trim the ends of loose lines and arcs where they lie on a way of lower rank.

    W overlaps V where both are of one line or circle, an end of W lies on V and an end of V on W.
    Neither is cut where a third loose way ends at one of these two: there it may go on along W.
    """
    if not loose:
        return
    numbers = np.array(loose, dtype=np.int64)
    places = np.concatenate((toolpaths.starts[numbers], toolpaths.ends[numbers]))
    pairs = toolpaths.by_way(toolpaths.near(places, same))
    own = np.tile(numbers, 2)[pairs.point]
    other = toolpaths.owner[pairs.element]
    at_end = np.minimum(
        np.hypot(*(toolpaths.starts[other] - places[pairs.point]).T),
        np.hypot(*(toolpaths.ends[other] - places[pairs.point]).T),
    )
    asked = np.flatnonzero((rank[other] < rank[own]) & (at_end > same))
    if not len(asked):
        return
    asked = asked[_of_one_course(toolpaths, own[asked], other[asked], same)]
    ends = STRtree(shapely.points(places))

    def is_lost(place: Floats, w: int, v: int) -> bool:
        """Whether a third way, of another line or circle, ends at a place."""
        near = numbers[ends.query(shapely.Point(place), "dwithin", distance=same) % len(numbers)]
        third = near[(near != w) & (near != v)]
        return not _of_one_course(toolpaths, third, np.full(len(third), w), same).all()

    spans: dict[int, list[float]] = {}
    for k in asked.tolist():
        w, v, place = int(own[k]), int(other[k]), places[pairs.point[k]]
        at_start = bool(pairs.point[k] < len(numbers))
        for end in (toolpaths.starts[v], toolpaths.ends[v]):
            at = _beginning_of_overlap(found, w, v, end, at_start, same)
            if at is not None and not is_lost(end, w, v) and not is_lost(place, w, v):
                whole = [0.0, _line(found, w).length]
                spans.setdefault(w, whole)[0 if at_start else 1] = at
    for w, (low, high) in spans.items():
        if low < high:
            _replace(found, w, np.array(substring(_line(found, w), low, high).coords))


def _beginning_of_overlap(
    found: Stretches, w: int, v: int, end: Floats, at_start: bool, same: float
) -> float | None:
    """How far along way `w` an end of `v` lies, if `w` lies on `v` from its own end up to there."""
    line, point = _line(found, w), shapely.Point(end)
    at: float = line.project(point)
    if line.distance(point) > same or not same < at < line.length - same:
        return None
    middle = line.interpolate(at / 2 if at_start else (at + line.length) / 2)
    return None if _line(found, v).distance(middle) > same else at


def _of_one_course(toolpaths: Toolpaths, some: Counts, others: Counts, same: float) -> Flags:
    """Which of some ways lie on the line or the circle of another one each, but for `same`."""
    kinds, elements = toolpaths.kinds, toolpaths.elements
    alike = (kinds[some] == kinds[others]) & (kinds[some] < 2)
    first, second = toolpaths.first(some), toolpaths.first(others)
    arcs, on = elements.arcs[first], elements.arcs[second]
    off = np.hypot(*(arcs[:, :2] - on[:, :2]).T) + np.abs(arcs[:, 2] - on[:, 2])
    along = np.column_stack([column[second] for column in elements.along])
    for ends in (toolpaths.starts, toolpaths.ends):
        away = ends[some] - toolpaths.starts[others]
        aside = np.abs(along[:, 0] * away[:, 1] - along[:, 1] * away[:, 0])
        off = np.where(kinds[some] == 0, np.maximum(off, aside), off)
    found: Flags = alike & (off <= same)
    return found


def _line(found: Stretches, way: int) -> shapely.LineString:
    return shapely.LineString(found.points[found.rows(way)])


def _replace(found: Stretches, way: int, points: Floats) -> None:
    """Puts other points in the place of a way's."""
    low, high = found.begins[way], found.begins[way + 1]
    found.points = np.concatenate((found.points[:low], points, found.points[high:]))
    found.begins = found.begins.copy()
    found.begins[way + 1 :] += len(points) - (high - low)
    found.starts[way], found.ends[way] = points[0], points[-1]
