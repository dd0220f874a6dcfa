"""Strokes that begin or end in the middle of a contour."""

from collections.abc import Sequence
from math import hypot

import numpy as np

from beamcam.errors import Diagnostic, Source
from beamcam.geometry.array_types import Floats
from beamcam.verify.sheets import rules
from beamcam.verify.sheets.elements import points_as_elements
from beamcam.verify.sheets.grid import Grid
from beamcam.verify.sheets.ways import Ways
from beamcam.verify.sheets.work import SHOWN, Traced, Work

#: Contours that leave a place in directions as near as this lie on one another there.
SAME_DIRECTION_DEG = 2.0
ROUNDING = 1e-9
#: Tolerances along a path behind which it is elsewhere.
APART = 8.0


def end_faults(work: Work, traced: Sequence[Traced]) -> list[Diagnostic]:
    """Open ends of paths where no contour ends and no bridge begins.

    Where the beam keeps off a contour, what is left of that says whether it closes.
    """
    said: list[Diagnostic] = []
    opened = [t for t in traced if not t.closed and not t.half_kerf]
    if not opened:
        return said
    starts = work.path.starts[[t.first for t in opened]]
    stops = work.path.ends[[t.last - 1 for t in opened]]
    begin = work.path.begins[[t.first for t in opened]]
    lasts = [t.last - 1 for t in opened]
    end = work.path.begins[lasts] + work.path.lengths[lasts]
    branches = _Branches(work.need, work.tolerance, work.torch.gap)
    out_of_starts, out_of_stops = branches.at(starts), branches.at(stops)
    for k, t in enumerate(opened):
        for what, place, count, way, at in (
            ("begins", starts[k], out_of_starts[k], t.first, begin[k]),
            ("ends", stops[k], out_of_stops[k], t.last - 1, end[k]),
        ):
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
            at = {"x": f"{x:.3f}", "y": f"{y:.3f}"}
            said.append(rules.OPEN.at(source, what=what, contour=contour, **at))
    return said[:SHOWN]


def _on_another(work: Work, place: Floats, way: int, at: float) -> bool:
    """Whether an end `at` so far along the path lies on another stroke, or elsewhere on its own.

    An edge that two contours share, or one has twice, is cut once: what is left ends on it.
    """
    path = work.path
    pairs = path.near(place.reshape(1, 2), work.tolerance)
    is_other = work.of_way[path.owner[pairs.element]] != work.of_way[way]
    is_apart = np.abs(path.at(pairs.element, pairs.along) - at) > APART * work.tolerance
    return bool((is_other | is_apart).any())


class _Branches:
    """Where contours end, and in how many directions they go on from there.

    A path may miss its end by `reach`. Ends farther apart than `gap` do not belong together,
    though both are within reach of the path's.
    """

    def __init__(self, need: Ways, reach: float, gap: float) -> None:
        apart = np.flatnonzero(np.hypot(*(need.ends - need.starts).T) > 1e-9)
        lengths = need.lengths[apart]
        near = np.minimum(lengths / 2, 20 * reach)
        self._gap = gap
        self._places = np.concatenate((need.starts[apart], need.ends[apart]))
        inner = np.concatenate((need.point(apart, near), need.point(apart, lengths - near)))
        towards = inner - self._places
        self._angles = np.degrees(np.arctan2(towards[:, 1], towards[:, 0]))
        self._grid = Grid(points_as_elements(self._places), reach)

    def at(self, places: Floats) -> list[int]:
        """Directions in which contours leave each place; 2 in the middle of one."""
        near: list[list[tuple[float, int]]] = [[] for _ in range(len(places))]
        pairs = self._grid.near(places, self._grid.reach)
        columns = (pairs.point.tolist(), pairs.away.tolist(), pairs.element.tolist())
        for place, away, end in zip(*columns, strict=True):
            near[place].append((away, end))
        return [self._directions(ends) if ends else 2 for ends in near]

    def _directions(self, ends: list[tuple[float, int]]) -> int:
        """Of the nearest end and those that belong to it."""
        x, y = self._places[min(ends)[1]].tolist()
        apart: list[float] = []
        for _, end in ends:
            to_x, to_y = self._places[end].tolist()
            angle = float(self._angles[end])
            if hypot(to_x - x, to_y - y) <= self._gap + ROUNDING and all(
                abs((angle - a + 180.0) % 360.0 - 180.0) > SAME_DIRECTION_DEG for a in apart
            ):
                apart.append(angle)
        return len(apart)
