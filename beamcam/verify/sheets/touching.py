"""Rings that touch one another or themselves, in the order in which they bound the waste.

 part  | waste
       |          Four curves meet at o, and each of the rings that they belong to may turn
-------o-------   from one part into the other there. Along the waste a corner is what lies
       |          between two curves with nothing but waste between them.
 waste | part
"""

from collections import defaultdict
from collections.abc import Iterator, Sequence
from math import atan2, tau

import numpy as np

from beamcam.geometry.array_types import Floats
from beamcam.verify.sheets.joining import Chain
from beamcam.verify.sheets.sides import waste_sides
from beamcam.verify.sheets.work import Work

DIGITS = 4  #: of mm, in which the ends of curves are alike that meet in one point
LEAST_TURN_RAD = 1e-9  #: of two curves that part


def waste_rings(work: Work) -> Sequence[Chain]:
    """The rings of the region, the waste left of each.

    Where they touch, each curve is followed by the one that bounds the same waste.
    """
    assert work.region is not None
    left = waste_sides(work)
    rings = [
        ring if (left[ring[0][0]] > 0.0) != ring[0][1] else _reversed(ring)
        for ring in work.region.rings
    ]
    ways = [way for ring in rings for way in ring]
    places, number = np.unique(_starts(work, ways).round(DIGITS), axis=0, return_inverse=True)
    if len(places) == len(ways):
        return rings
    after = _following(rings)
    before = {k: n for n, k in enumerate(after)}
    leaving: defaultdict[int, list[int]] = defaultdict(list)
    for k, place in enumerate(number.ravel().tolist()):
        leaving[place].append(k)
    for some in leaving.values():
        if len(some) > 1:
            _link(work, ways, some, [before[k] for k in some], after)
    return list(_walks(ways, after))


def _reversed(ring: Chain) -> Chain:
    return [(k, not turned) for k, turned in reversed(ring)]


def _following(rings: Sequence[Chain]) -> list[int]:
    """Of each way, numbered through all rings, the one that follows in its ring."""
    found: list[int] = []
    for ring in rings:
        first = len(found)
        found += [first + (n + 1) % len(ring) for n in range(len(ring))]
    return found


def _link(
    work: Work, ways: Sequence[tuple[int, bool]], out: list[int], into: list[int], after: list[int]
) -> None:
    """Make each way into a point be followed by the next one out of it, clockwise.

    Nothing is changed where two would be followed by the same one.
    """
    ahead = [atan2(y, x) for x, y in _headings(work, [ways[k] for k in out], 0.0).tolist()]
    back = [atan2(-y, -x) for x, y in _headings(work, [ways[k] for k in into], 1.0).tolist()]
    chosen = [
        min(range(len(out)), key=lambda n: (angle - ahead[n] - LEAST_TURN_RAD) % tau)
        for angle in back
    ]
    if len(set(chosen)) == len(out):
        for k, n in zip(into, chosen, strict=True):
            after[k] = out[n]


def _walks(ways: Sequence[tuple[int, bool]], after: Sequence[int]) -> Iterator[Chain]:
    left = dict.fromkeys(range(len(ways)))
    while left:
        at = next(iter(left))
        ring: Chain = []
        while at in left:
            del left[at]
            ring.append(ways[at])
            at = after[at]
        yield ring


def _starts(work: Work, ways: Sequence[tuple[int, bool]]) -> Floats:
    """Where each way begins."""
    numbers = np.array([k for k, _ in ways], dtype=np.int64)
    turned = np.array([back for _, back in ways])[:, None]
    return np.where(turned, work.need.ends[numbers], work.need.starts[numbers])


def _headings(work: Work, ways: Sequence[tuple[int, bool]], share: float) -> Floats:
    """The direction in which each way begins, or with a share of 1 ends."""
    numbers = np.array([k for k, _ in ways], dtype=np.int64)
    turned = np.array([back for _, back in ways])
    first = turned == bool(share)
    element = np.where(first, work.need.first(numbers), work.need.last(numbers))
    found = work.need.elements.directions(element, np.where(first, 0.0, 1.0))
    return np.where(turned[:, None], -found, found)
