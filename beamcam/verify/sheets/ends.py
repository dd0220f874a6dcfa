"""Strokes that begin or end in the middle of a contour."""

from collections.abc import Sequence
from math import dist

import numpy as np
import shapely

from beamcam.errors import Diagnostic, Source
from beamcam.geometry.array_types import Floats
from beamcam.verify.sheets import rules
from beamcam.verify.sheets.toolpaths import Toolpaths
from beamcam.verify.sheets.work import SHOWN, Traced, Work

#: Contours that leave a place in directions as near as this lie on one another there.
SAME_DIRECTION_DEG = 2.0
ROUNDING = 1e-9
End = tuple[Sequence[float], float]  #: where a contour ends, and in which direction it goes on

#: Tolerances along a path behind which it is elsewhere.
APART = 8.0


def end_faults(work: Work, traced: Sequence[Traced]) -> list[Diagnostic]:
    """Open ends of paths where no contour ends and no bridge begins.

    Where the beam keeps off a contour, what is left of that says whether it closes.
    """
    opened = [t for t in traced if not t.closed and not t.half_kerf]
    if not opened:
        return []
    path = work.path
    ends = [(t, end) for t in opened for end in (("begins", t.first), ("ends", t.last - 1))]
    toolpaths = np.array([way for _, (_, way) in ends])
    stops = np.tile([False, True], len(opened))
    places = np.where(stops[:, None], path.ends[toolpaths], path.starts[toolpaths])
    reached = path.begins[toolpaths] + np.where(stops, path.lengths[toolpaths], 0.0)
    counts = _directions(work.need, places, work.tolerance, work.torch.gap)
    said: list[Diagnostic] = []
    for (t, (what, way)), place, at, count in zip(ends, places, reached, counts, strict=True):
        if (
            count != 2
            or t.joined
            or _on_another(work, place, way, at)
            or work.on_kept_off(place.reshape(1, 2))[0]
        ):
            continue
        x, y = place.tolist()
        source = Source(work.name, int(work.moves.line[way]))
        contour = work.contour_at(place)
        said.append(rules.OPEN.at(source, what=what, contour=contour, x=f"{x:.3f}", y=f"{y:.3f}"))
    return said[:SHOWN]


def restart_faults(work: Work, traced: Sequence[Traced]) -> list[Diagnostic]:
    """Cuts that end where another goes on along the same contour, the tool off and on between.

    Where contours meet, or what lies on another is cut with it, a cut may end on a third one. With
    bridges the last of several cuts ends where the first began; see `tab_faults`.
    """
    opened = [t for t in traced if not t.closed and not t.joined]
    if work.process != "cut" or work.bridged or len(opened) < 2:
        return []
    path, count = work.path, len(opened)
    reach = 2 * work.tolerance
    ways = np.array([way for t in opened for way in (t.first, t.last - 1)])
    places = np.where((np.arange(2 * count) % 2)[:, None], path.ends[ways], path.starts[ways])
    low, high = (path.begins[[t.first for t in opened]], path.begins[[t.last - 1 for t in opened]])
    high = high + path.lengths[[t.last - 1 for t in opened]]
    number = {int(work.of_way[t.first]): k for k, t in enumerate(opened)}
    pairs = path.near(places, reach)
    at, stroke = path.at(pairs.element, pairs.along), work.of_way[path.owner[pairs.element]]
    touching: list[set[tuple[int, int]]] = [set() for _ in places]
    for place, other, along in zip(pairs.point.tolist(), stroke.tolist(), at.tolist(), strict=True):
        k = number.get(other, -1)
        side = -1
        if k >= 0 and min(along - low[k], high[k] - along) <= 2 * reach:
            side = int(along - low[k] > high[k] - along)
        touching[place].add((other, side))
    asked = [
        k
        for k, found in enumerate(touching)
        if len(found) == len(dict(found)) == 2 and all(side >= 0 for _, side in found)
    ]
    said = []
    for k in asked:
        t = opened[k // 2]
        other = max(s for s, _ in touching[k])
        if other == work.of_way[t.first] and _goes_on(work, places[k], t.half_kerf):
            x, y = places[k].tolist()
            said.append(
                rules.RESTART.at(
                    Source(work.name, t.stroke.line), contour=work.contour_at(places[k]),
                    x=f"{x:.3f}", y=f"{y:.3f}",
                )
            )  # fmt: skip
    return said[:SHOWN]


def _goes_on(work: Work, place: Floats, half_kerf: float) -> bool:
    """Whether one contour goes on at a place of the path, with the same settings."""
    reach = half_kerf + work.tolerance
    pairs = work.need.near(place.reshape(1, 2), reach if half_kerf else work.tolerance)
    looks = work.asked.looks[work.process]
    if len({looks[way] for way in work.need.owner[pairs.element].tolist()}) > 1:
        return False
    if half_kerf:
        return True
    return _directions(work.need, place.reshape(1, 2), work.tolerance, work.torch.gap) == [2]


def _on_another(work: Work, place: Floats, way: int, at: float) -> bool:
    """Whether an end `at` so far along the path lies on another stroke, or elsewhere on its own.

    An edge that two contours share, or one has twice, is cut once: what is left ends on it.
    """
    path = work.path
    pairs = path.near(place.reshape(1, 2), work.tolerance)
    is_other = work.of_way[path.owner[pairs.element]] != work.of_way[way]
    is_apart = np.abs(path.at(pairs.element, pairs.along) - at) > APART * work.tolerance
    return bool((is_other | is_apart).any())


def _directions(need: Toolpaths, places: Floats, reach: float, gap: float) -> list[int]:
    """In how many directions contours go on from where they end at each place; 2 amid one.

    A path may miss its end by `reach`. Ends farther apart than `gap` do not belong together,
    though both are within reach of the path's.
    """
    apart = np.flatnonzero(np.hypot(*(need.ends - need.starts).T) > 1e-9)
    lengths = need.lengths[apart]
    near = np.minimum(lengths / 2, 20 * reach)
    corners = np.concatenate((need.starts[apart], need.ends[apart]))
    inner = np.concatenate((need.point(apart, near), need.point(apart, lengths - near)))
    x, y = (inner - corners).T
    ends = list(zip(corners.tolist(), np.degrees(np.arctan2(y, x)).tolist(), strict=True))
    beside: list[list[End]] = [[] for _ in places]
    tree = shapely.STRtree(shapely.points(corners))
    pairs = tree.query(shapely.points(places), "dwithin", distance=reach)
    for place, end in pairs.T.tolist():
        beside[place].append(ends[end])
    own = zip(places.tolist(), beside, strict=True)
    return [_branches(place, some, gap) if some else 2 for place, some in own]


def _branches(place: Sequence[float], ends: Sequence[End], gap: float) -> int:
    """How many directions there are of the nearest end and those that belong to it."""
    nearest = min((end for end, _ in ends), key=lambda end: dist(end, place))
    apart: list[float] = []
    for end, angle in ends:
        if dist(end, nearest) <= gap + ROUNDING and all(
            abs((angle - a + 180.0) % 360.0 - 180.0) > SAME_DIRECTION_DEG for a in apart
        ):
            apart.append(angle)
    return len(apart)
