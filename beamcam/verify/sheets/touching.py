"""Parts of a drawing that touch: which of them do, and how far they go apart along slants.

The edge of two parts is what of the one's outline lies on the other's. Each straight stretch of it
has a normal; the part that the other one enters if that is moved along it by a hair lies behind.
"""

from collections.abc import Iterator, Mapping, Sequence
from itertools import pairwise
from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from shapely import Polygon

HAIR = 1e-3  #: mm
STRAIGHT = 1e-6  #: of a direction, by which two stretches are one

Normal = tuple[float, float]


def touching(rings: "Mapping[int, Polygon]") -> Iterator[tuple[list[int], bool]]:
    """The parts that touch, directly or by others, and whether some do so along a slant."""
    group = {k: {k} for k in rings}
    slanting: set[int] = set()
    for a, one in rings.items():
        for b, other in rings.items():
            if a >= b or not (normals := list(_normals(one, other))):
                continue
            if any(min(abs(x), abs(y)) > STRAIGHT for x, y in normals):
                slanting.add(a)
            whole = group[a] | group[b]
            group |= dict.fromkeys(whole, whole)
    for k, some in group.items():
        if k == min(some):
            yield sorted(some), not slanting.isdisjoint(some)


def by_slants(rings: "Mapping[int, Polygon]", width: float) -> dict[int, list[float]] | None:
    """The moves that part all edges by `width`; None if there are none."""
    import shapely
    from shapely.affinity import translate

    at = {k: n for n, k in enumerate(rings)}
    asked: list[tuple[int, int, Normal]] = []
    for a, one in rings.items():
        for b, other in rings.items():
            for x, y in _normals(one, other) if a < b else ():
                nearer = translate(other, -HAIR * x, -HAIR * y)
                enters = shapely.intersection(one, nearer).area > HAIR * HAIR
                asked.append((a, b, (x, y)) if enters else (b, a, (x, y)))
    rows = np.zeros((len(asked), 2 * len(rings)))
    for row, (before, behind, normal) in zip(rows, asked, strict=True):
        row[2 * at[before] : 2 * at[before] + 2] -= normal
        row[2 * at[behind] : 2 * at[behind] + 2] += normal
    free = rows[:, 2:]  # the first part rests
    found = np.linalg.pinv(free) @ np.full(len(asked), width)
    if np.abs(free @ found - width).max() > STRAIGHT * width:
        return None
    places = np.concatenate((np.zeros(2), found)).reshape(-1, 2)
    return {k: places[n].tolist() for k, n in at.items()}


def _normals(one: "Polygon", other: "Polygon") -> Iterator[Normal]:
    """The normals of the straight stretches that two outlines share, each once.

    A curve that they share is many of them, which no moves can satisfy.
    """
    import shapely

    if one.distance(other) > HAIR / 10:
        return
    edge = shapely.intersection(one.boundary.buffer(HAIR / 10), other.boundary)
    lengths: dict[Normal, float] = {}
    for line in shapely.get_parts(edge):
        for x, y in _steps(shapely.get_coordinates(line).tolist()):
            size = float(np.hypot(x, y))
            if size < HAIR / 100:
                continue
            normal = (-y / size, x / size)
            if normal[0] < -STRAIGHT or (abs(normal[0]) <= STRAIGHT and normal[1] < 0.0):
                normal = (-normal[0], -normal[1])
            same = next((n for n in lengths if np.hypot(n[0] - normal[0], n[1] - normal[1])
                         < 100 * STRAIGHT), normal)  # fmt: skip
            lengths[same] = lengths.get(same, 0.0) + size
    yield from (normal for normal, length in lengths.items() if length > 4 * HAIR)


def _steps(points: Sequence[Sequence[float]]) -> Iterator[Normal]:
    for (x0, y0), (x1, y1) in pairwise(points):
        yield x1 - x0, y1 - y0
